//! An atmosphere around a ball: molecules, aerosols and ozone, and the light that they scatter.
//!
//! Source: Hillaire, "A Scalable and Production Ready Sky and Atmosphere Rendering Technique", CGF 39(4), 2020,
//! doi:10.1111/cgf.14050, for the densities and the sum of all orders of scattering; Bruneton and Neyret, "Precomputed
//! Atmospheric Scattering", CGF 27(4), 2008, doi:10.1111/j.1467-8659.2008.01245.x, for the coordinates of the table of
//! columns; Bird and Riordan, "Simple Solar Spectral Model for Direct and Diffuse Irradiance on Horizontal and Tilted Planes
//! at the Earth's Surface for Cloudless Atmospheres", Journal of Climate and Applied Meteorology 25, 1986, for how (rural)
//! aerosols scatter.
//!
//! Lengths are in km, coefficients in km^-1.

use std::f64::consts::PI;

use super::spectrum::{COUNT, OZONE, Spectrum, spectrum};
use crate::math::parallel;

pub(super) const GROUND: f64 = 6360.0;
pub(super) const TOP: f64 = 6420.0;
/// The heights over which the densities of molecules and of aerosols fall by e.
const MOLECULES_HEIGHT: f64 = 8.0;
const AEROSOLS_HEIGHT: f64 = 1.2;
/// The mean cosine of the angle by which aerosols scatter.
const AEROSOLS_G: f64 = 0.65;
/// The wavelength exponent of aerosols, by Angstrom.
const AEROSOLS_EXPONENT: f64 = -1.3;
/// Molecules of ozone above 1 m^2 in a Dobson unit, in 1e26, over the height of a constant density, in km.
const DOBSON: f64 = 2.687e-6 / 15.0;

/// The sizes of the table of columns: heights and directions.
const COLUMNS: [usize; 2] = [48, 160];
const COLUMN_STEPS: usize = 40;
/// The sizes of the table of multiple scattering: heights and heights of the sun.
const MULTIPLE: [usize; 2] = [12, 24];
const MULTIPLE_STEPS: usize = 12;
/// Polar angles and half as many azimuths of the directions for multiple scattering.
const MULTIPLE_DIRECTIONS: usize = 8;

/// The densities at a height, as parts of the largest: of molecules, aerosols and ozone.
fn densities(height: f64) -> [f64; 3] {
    [
        libm::exp(-height / MOLECULES_HEIGHT),
        libm::exp(-height / AEROSOLS_HEIGHT),
        (1.0 - (height - 25.0).abs() / 15.0).max(0.0),
    ]
}

/// The part of the light of molecules that turns by an angle of this cosine, in sr^-1.
pub(super) fn molecules_phase(cos: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cos * cos)
}

/// The same of aerosols, after Henyey and Greenstein.
pub(super) fn aerosols_phase(cos: f64) -> f64 {
    let g = AEROSOLS_G;
    let d = 1.0 + g * g - 2.0 * g * cos;
    (1.0 - g * g) / (4.0 * PI * d * d.sqrt())
}

/// A point by its distance from the centre, and the cosine of the angle between the sun and its zenith.
#[derive(Clone, Copy)]
struct Place {
    r: f64,
    sun: f64,
}

/// A ray: where it starts, its cosine to the zenith, and its cosine to the sun.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub r: f64,
    pub up: f64,
    pub to_sun: f64,
    /// The cosine of the angle of the sun to the zenith of the start.
    pub sun: f64,
}

impl Ray {
    fn at(&self, t: f64) -> Place {
        let r = (self.r * self.r + t * t + 2.0 * self.r * t * self.up).max(0.0).sqrt();
        Place {
            r: r.clamp(GROUND, TOP),
            sun: ((self.r * self.sun + t * self.to_sun) / r).clamp(-1.0, 1.0),
        }
    }

    /// The distance to the ground, if it meets it.
    fn to_ground(self) -> Option<f64> {
        let d = self.r * self.r * (self.up * self.up - 1.0) + GROUND * GROUND;
        (self.up < 0.0 && d >= 0.0).then(|| (-self.r * self.up - d.sqrt()).max(0.0))
    }

    fn to_top(self) -> f64 {
        let d = self.r * self.r * (self.up * self.up - 1.0) + TOP * TOP;
        (-self.r * self.up + d.max(0.0).sqrt()).max(0.0)
    }
}

/// The light that reaches the start of a ray for sunlight of 1, by where it was scattered last; the first two without the
/// phase function.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scattered {
    /// Once, by molecules and by aerosols.
    pub molecules: Spectrum,
    pub aerosols: Spectrum,
    /// More than once.
    pub multiple: Spectrum,
    /// The part of light that passes the whole ray.
    pub transmittance: Spectrum,
}

pub(super) struct Atmosphere {
    /// Scattering by molecules, extinction by aerosols and absorption by ozone at the largest density.
    molecules: Spectrum,
    aerosols: Spectrum,
    ozone: Spectrum,
    /// The part of what aerosols take from light that they scatter.
    aerosols_albedo: Spectrum,
    ground_albedo: Spectrum,
    /// The lengths of air at the largest density on the way out, see [`Atmosphere::columns`].
    columns: Vec<[f64; 3]>,
    /// The light of all orders beyond the first at each height and each height of the sun, in sr^-1 for sunlight of 1.
    multiple: Vec<Spectrum>,
    /// The sine of the angular radius of the sun.
    sun_radius: f64,
}

/// The composition of an atmosphere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Air {
    /// The optical depth of aerosols at 550 nm.
    pub aerosols: f64,
    /// In Dobson units.
    pub ozone: f64,
    pub ground_albedo: Spectrum,
    /// The angular radius of the sun, in radians.
    pub sun_radius: f64,
}

/// The place of a number between two of `count` entries for a coordinate from 0 to 1.
fn entry(x: f64, count: usize) -> (usize, f64) {
    let x = x.clamp(0.0, 1.0) * (count - 1) as f64;
    let i = (x as usize).min(count - 2);
    (i, x - i as f64)
}

/// The four entries around a point of a table and their weights.
fn corners([(i, x), (j, y)]: [(usize, f64); 2], width: usize) -> [(usize, f64); 4] {
    let at = i * width + j;
    [
        (at, (1.0 - x) * (1.0 - y)),
        (at + 1, (1.0 - x) * y),
        (at + width, x * (1.0 - y)),
        (at + width + 1, x * y),
    ]
}

impl Atmosphere {
    pub fn new(air: &Air) -> Self {
        let mut atmosphere = Self {
            molecules: spectrum(|l| 1.24062e-3 / (l * l * l * l)),
            aerosols: spectrum(|l| air.aerosols / AEROSOLS_HEIGHT * libm::exp(AEROSOLS_EXPONENT * libm::log(l / 0.55))),
            ozone: OZONE.map(|cross_section| cross_section * air.ozone * DOBSON),
            aerosols_albedo: spectrum(|l| {
                let log = libm::log(l / 0.4);
                0.945 * libm::exp(-0.095 * log * log)
            }),
            ground_albedo: air.ground_albedo,
            columns: Vec::new(),
            multiple: Vec::new(),
            sun_radius: libm::sin(air.sun_radius),
        };
        let [heights, directions] = COLUMNS;
        let column = |k: usize| Self::column(k / directions, k % directions);
        atmosphere.columns = parallel::map(0..heights * directions, column);
        let [heights, suns] = MULTIPLE;
        let multiple = |k: usize| {
            let at = |i: usize, count: usize| i as f64 / (count - 1) as f64;
            let x = at(k / suns, heights);
            atmosphere.multiple_at(GROUND + x * x * (TOP - GROUND), 2.0 * at(k % suns, suns) - 1.0)
        };
        atmosphere.multiple = parallel::map(0..heights * suns, multiple);
        atmosphere
    }

    /// An entry of the table of columns.
    fn column(i: usize, j: usize) -> [f64; 3] {
        let horizon = (TOP * TOP - GROUND * GROUND).sqrt();
        let at = |i: usize, count: usize| i as f64 / (count - 1) as f64;
        let rho = horizon * at(i, COLUMNS[0]);
        let r = (rho * rho + GROUND * GROUND).sqrt();
        let (nearest, farthest) = (TOP - r, rho + horizon);
        let length = nearest + at(j, COLUMNS[1]) * (farthest - nearest);
        let up = match length {
            0.0 => 1.0,
            d => ((horizon * horizon - rho * rho - d * d) / (2.0 * r * d)).clamp(-1.0, 1.0),
        };
        let ray = Ray {
            r,
            up,
            to_sun: 0.0,
            sun: 0.0,
        };
        let mut sum = [0.0; 3];
        let mut from = 0.0;
        for k in 0..COLUMN_STEPS {
            let x = (k + 1) as f64 / COLUMN_STEPS as f64;
            let to = length * x * x;
            let own = densities(ray.at(0.5 * (from + to)).r - GROUND);
            for (sum, own) in sum.iter_mut().zip(own) {
                *sum += own * (to - from);
            }
            from = to;
        }
        sum
    }

    /// The lengths of air at the largest density from a place to space, in a direction that does not meet the ground.
    fn columns(&self, r: f64, up: f64) -> [f64; 3] {
        let horizon = (TOP * TOP - GROUND * GROUND).sqrt();
        let rho = (r * r - GROUND * GROUND).max(0.0).sqrt();
        let (nearest, farthest) = (TOP - r, rho + horizon);
        let length = Ray {
            r,
            up,
            to_sun: 0.0,
            sun: 0.0,
        }
        .to_top();
        let x = (length - nearest) / (farthest - nearest);
        let mut sum = [0.0; 3];
        for (at, weight) in corners([entry(rho / horizon, COLUMNS[0]), entry(x, COLUMNS[1])], COLUMNS[1]) {
            for (sum, own) in sum.iter_mut().zip(self.columns[at]) {
                *sum += own * weight;
            }
        }
        sum
    }

    /// The part of the sun's disk above the horizon at a place, by the height of its centre.
    fn seen_of_sun(&self, Place { r, sun }: Place) -> f64 {
        let sin = GROUND / r;
        let dip = -(1.0 - sin * sin).max(0.0).sqrt();
        // The sine of the height above the horizon, for small heights.
        let above = ((sun - dip) / sin / self.sun_radius.max(1e-6)).clamp(-1.0, 1.0);
        // The part of a disk above a chord.
        0.5 + (above * (1.0 - above * above).sqrt() + libm::asin(above)) / PI
    }

    /// The part of sunlight that reaches a place.
    pub fn sunlight(&self, r: f64, sun: f64) -> Spectrum {
        let seen = self.seen_of_sun(Place { r, sun });
        if seen <= 0.0 {
            return [0.0; COUNT];
        }
        let sin = GROUND / r;
        let [m, a, o] = self.columns(r, sun.max(-(1.0 - sin * sin).max(0.0).sqrt()));
        let mut to = [0.0; COUNT];
        for (k, to) in to.iter_mut().enumerate() {
            *to = seen * libm::exp(-(self.molecules[k] * m + self.aerosols[k] * a + self.ozone[k] * o));
        }
        to
    }

    /// The light of all orders of scattering but the first, in sr^-1.
    fn multiple(&self, Place { r, sun }: Place) -> Spectrum {
        let x = ((r - GROUND) / (TOP - GROUND)).max(0.0).sqrt();
        let mut sum = [0.0; COUNT];
        let entries = [entry(x, MULTIPLE[0]), entry(0.5 * (sun + 1.0), MULTIPLE[1])];
        for (at, weight) in corners(entries, MULTIPLE[1]) {
            for (sum, own) in sum.iter_mut().zip(&self.multiple[at]) {
                *sum += own * weight;
            }
        }
        sum
    }

    /// An entry of the table of multiple scattering: the second order, scattered evenly, over what the further orders leave
    /// of it (equations 5 to 10 of Hillaire).
    fn multiple_at(&self, r: f64, sun: f64) -> Spectrum {
        let (mut second, mut again) = ([0.0; COUNT], [0.0; COUNT]);
        let n = MULTIPLE_DIRECTIONS;
        let across = (1.0 - sun * sun).max(0.0).sqrt();
        for i in 0..n * n / 2 {
            let up = 1.0 - 2.0 * ((i % n) as f64 + 0.5) / n as f64;
            let around = PI * ((i / n) as f64 + 0.5) / (n / 2) as f64;
            let to_sun = up * sun + (1.0 - up * up).sqrt() * across * libm::cos(around);
            let ray = Ray { r, up, to_sun, sun };
            let found = self.follow(&ray, MULTIPLE_STEPS, |_| [0.0; COUNT], &mut again);
            let bounced = self.ground(&ray, &[0.0; COUNT]);
            for k in 0..COUNT {
                let once = (found.molecules[k] + found.aerosols[k]) / (4.0 * PI);
                second[k] += once + found.transmittance[k] * bounced[k];
            }
        }
        // Both are means over all directions.
        let count = (n * n / 2) as f64;
        let mut sum = [0.0; COUNT];
        for (k, sum) in sum.iter_mut().enumerate() {
            *sum = second[k] / count / (1.0 - again[k] / count);
        }
        sum
    }

    /// The radiance of the ground at the end of a ray under sunlight of 1 and the irradiance of the sky; 0 if it does not
    /// meet the ground.
    pub fn ground(&self, ray: &Ray, sky: &Spectrum) -> Spectrum {
        let Some(end) = ray.to_ground() else {
            return [0.0; COUNT];
        };
        let Place { sun, .. } = ray.at(end);
        let mut light = self.sunlight(GROUND, sun);
        for (k, light) in light.iter_mut().enumerate() {
            *light = self.ground_albedo[k] / PI * (*light * sun.max(0.0) + sky[k]);
        }
        light
    }

    /// The light along a ray.
    pub fn scattered(&self, ray: &Ray, steps: usize) -> Scattered {
        self.follow(ray, steps, |place| self.multiple(place), &mut [0.0; COUNT])
    }

    /// The light along a ray, whose multiple scattering comes from light `multiple`. Adds the part of even light that it
    /// scatters to `even`.
    fn follow(&self, ray: &Ray, steps: usize, multiple: impl Fn(Place) -> Spectrum, even: &mut Spectrum) -> Scattered {
        let length = ray.to_ground().unwrap_or_else(|| ray.to_top());
        let zero = [0.0; COUNT];
        let (mut molecules, mut aerosols, mut many) = (zero, zero, zero);
        let mut transmittance = [1.0; COUNT];
        let mut from = 0.0;
        for step in 0..steps {
            let x = (step + 1) as f64 / steps as f64;
            let to = length * x * x;
            let place = ray.at(0.5 * (from + to));
            let [m, a, o] = densities(place.r - GROUND);
            let (light, more) = (self.sunlight(place.r, place.sun), multiple(place));
            for k in 0..COUNT {
                let by_molecules = self.molecules[k] * m;
                let extinction_of_aerosols = self.aerosols[k] * a;
                let by_aerosols = self.aerosols_albedo[k] * extinction_of_aerosols;
                let extinction = by_molecules + extinction_of_aerosols + self.ozone[k] * o;
                let passed = libm::exp(-extinction * (to - from));
                // The integral of the transmittance over the step.
                let whole = transmittance[k]
                    * if extinction > 0.0 {
                        (1.0 - passed) / extinction
                    } else {
                        to - from
                    };
                molecules[k] += whole * by_molecules * light[k];
                aerosols[k] += whole * by_aerosols * light[k];
                many[k] += whole * (by_molecules + by_aerosols) * more[k];
                even[k] += whole * (by_molecules + by_aerosols);
                transmittance[k] *= passed;
            }
            from = to;
        }
        Scattered {
            molecules,
            aerosols,
            multiple: many,
            transmittance,
        }
    }
}

#[cfg(test)]
mod tests;
