//! The light of the sky against random walks of photons, and columns of air against closed forms.

use super::*;

fn air(aerosols: f64) -> Air {
    Air {
        aerosols,
        ozone: 300.0,
        ground_albedo: [0.3; COUNT],
        sun_radius: 0.0047,
    }
}

type Vector = [f64; 3];

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn along(p: Vector, t: f64, d: Vector) -> Vector {
    [0, 1, 2].map(|i| p[i] + t * d[i])
}

/// Uniform numbers.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
    }

    /// A unit direction whose angle to `axis` has this cosine.
    fn around(&mut self, axis: Vector, cos: f64) -> Vector {
        let helper = if axis[0].abs() < 0.7 {
            [1.0, 0.0, 0.0]
        } else {
            [0.0, 1.0, 0.0]
        };
        let across = along(helper, -dot(helper, axis), axis);
        let x = across.map(|c| c / dot(across, across).sqrt());
        let y = [
            axis[1] * x[2] - axis[2] * x[1],
            axis[2] * x[0] - axis[0] * x[2],
            axis[0] * x[1] - axis[1] * x[0],
        ];
        let (sin, phi) = ((1.0 - cos * cos).max(0.0).sqrt(), 2.0 * PI * self.next());
        let d = along(axis.map(|c| c * cos), sin * libm::cos(phi), x);
        along(d, sin * libm::sin(phi), y)
    }
}

impl Atmosphere {
    /// The light that a walk from the ground finds, at one wavelength: next-event estimation at each collision.
    fn walk(&self, k: usize, sun: Vector, random: &mut Random) -> f64 {
        let most = self.molecules[k] + self.aerosols[k] + self.ozone[k];
        let up = [0.0, 1.0, 0.0];
        let mut p = [0.0, GROUND + 1e-6, 0.0];
        let cos = random.next().sqrt();
        let mut d = random.around(up, cos);
        let (mut weight, mut found) = (1.0, 0.0);
        for _ in 0..300 {
            p = along(p, -libm::log(random.next()) / most, d);
            let r = dot(p, p).sqrt();
            let normal = p.map(|c| c / r);
            let height = dot(normal, sun);
            if r > TOP {
                break;
            }
            if r < GROUND {
                // The rest of a step above the ground has no memory: the walk goes on from where it met the ground.
                p = normal.map(|c| c * (GROUND + 1e-6));
                weight *= self.ground_albedo[k];
                found += weight / PI * self.sunlight(GROUND, height)[k] * height.max(0.0);
                let cos = random.next().sqrt();
                d = random.around(normal, cos);
                continue;
            }
            let [m, a, o] = densities(r - GROUND);
            let (m, a, o) = (self.molecules[k] * m, self.aerosols[k] * a, self.ozone[k] * o);
            if random.next() * most > m + a + o {
                continue;
            }
            let a_scattered = a * self.aerosols_albedo[k];
            weight *= (m + a_scattered) / (m + a + o);
            let part = m / (m + a_scattered);
            let to_sun = dot(d, sun);
            let phase = part * molecules_phase(to_sun) + (1.0 - part) * aerosols_phase(to_sun);
            found += weight * phase * self.sunlight(r, height)[k];
            if random.next() < part {
                let cos = 2.0 * random.next() - 1.0;
                weight *= 4.0 * PI * molecules_phase(cos);
                d = random.around(d, cos);
            } else {
                let g = AEROSOLS_G;
                let s = (1.0 - g * g) / (1.0 - g + 2.0 * g * random.next());
                d = random.around(d, ((1.0 + g * g - s * s) / (2.0 * g)).clamp(-1.0, 1.0));
            }
        }
        found
    }

    /// The irradiance of the sky on the ground for sunlight of 1.
    fn irradiance(&self, sun: f64) -> Spectrum {
        let (n, mut sum) = (12, [0.0; COUNT]);
        for i in 0..n * n {
            let up = (((i / n) as f64 + 0.5) / n as f64).sqrt();
            let azimuth = PI * ((i % n) as f64 + 0.5) / n as f64;
            let to_sun = up * sun + ((1.0 - up * up) * (1.0 - sun * sun)).sqrt() * libm::cos(azimuth);
            let ray = Ray {
                r: GROUND,
                up,
                to_sun,
                sun,
            };
            let light = self.scattered(&ray, 40);
            for (k, sum) in sum.iter_mut().enumerate() {
                let once = molecules_phase(to_sun) * light.molecules[k] + aerosols_phase(to_sun) * light.aerosols[k];
                *sum += PI / (n * n) as f64 * (once + light.multiple[k]);
            }
        }
        sum
    }
}

#[test]
fn light_of_all_orders_is_within_13_percent_of_random_walks() {
    for (aerosols, elevation) in [(0.0_f64, 50.0_f64), (0.1, 50.0), (0.1, 12.0)] {
        let atmosphere = Atmosphere::new(&air(aerosols));
        let elevation = elevation.to_radians();
        let sun = [libm::cos(elevation), libm::sin(elevation), 0.0];
        let found = atmosphere.irradiance(sun[1]);
        for k in [3, 9, 13] {
            let (mut random, walks) = (Random(7), 20_000);
            let sum: f64 = (0..walks).map(|_| atmosphere.walk(k, sun, &mut random)).sum();
            let expected = PI * sum / f64::from(walks);
            let ratio = found[k] / expected;
            assert!((ratio - 1.0).abs() < 0.13, "{aerosols} {elevation} {k}: {ratio}");
        }
    }
}

#[test]
fn sunlight_from_the_zenith_passes_the_whole_depth_of_the_air() {
    let atmosphere = Atmosphere::new(&air(0.2));
    let found = atmosphere.sunlight(GROUND, 1.0);
    for (k, found) in found.into_iter().enumerate() {
        let molecules = atmosphere.molecules[k] * MOLECULES_HEIGHT * (1.0 - libm::exp(-60.0 / MOLECULES_HEIGHT));
        let depth = molecules + atmosphere.aerosols[k] * AEROSOLS_HEIGHT + atmosphere.ozone[k] * 15.0;
        assert!((found / libm::exp(-depth) - 1.0).abs() < 0.01, "{k}");
    }
    // At 550 nm, of molecules: Bodhaine et al., "On Rayleigh Optical Depth Calculations", 1999, have 0.097.
    let depth = 1.24062e-3 / 0.55_f64.powi(4) * MOLECULES_HEIGHT;
    assert!((depth / 0.097 - 1.0).abs() < 0.15, "{depth}");
    // The Chappuis band of 300 Dobson units dims zenith light of 600 nm by 3 to 4 %.
    let depth = atmosphere.ozone[11] * 15.0;
    assert!((0.03..0.042).contains(&depth), "{depth}");
    // A sun on the horizon is half there, and below it not at all.
    let half = atmosphere.seen_of_sun(Place { r: GROUND, sun: 0.0 });
    assert!((half - 0.5).abs() < 1e-6);
    assert!(atmosphere.sunlight(GROUND, -0.01).iter().all(|s| *s == 0.0));
}
