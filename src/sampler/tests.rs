//! The requirements on every sampler, and the quality of the good ones.

use super::*;

/// Every kind, for `samples` samples of each pixel.
fn samplers(samples: u32) -> Vec<(&'static str, Sampler)> {
    let all: Vec<_> = SamplerDesc::NAMES
        .iter()
        .map(|name| {
            let desc: SamplerDesc = toml::from_str(&format!("{name} = {{}}")).expect("a sampler without keys");
            (*name, desc.compile(samples).expect("a sampler"))
        })
        .collect();
    assert!(all.iter().all(|(name, sampler)| sampler.name() == *name));
    all
}

fn key(x: u32, y: u32, sample: u32) -> SampleKey {
    SampleKey {
        seed: 0,
        frame: 1,
        pixel: [x, y],
        sample,
    }
}

const BSDF: Dimension = Dimension::at(1, SampleUse::Bsdf);
const LIGHT: Dimension = Dimension::at(2, SampleUse::Light);

/// The correlation of two sets of numbers.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let (ma, mb) = pairs.iter().fold((0.0, 0.0), |(a, b), p| (a + p.0 / n, b + p.1 / n));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (a, b) in pairs.iter().map(|(a, b)| (a - ma, b - mb)) {
        ab += a * b;
        aa += a * a;
        bb += b * b;
    }
    ab / (aa * bb).sqrt()
}

#[test]
fn any_part_of_the_address_changes_the_numbers_and_they_fill_the_unit_square() {
    for (name, sampler) in samplers(64) {
        let base = key(3, 4, 5);
        let others = [
            SampleKey { seed: 1, ..base },
            SampleKey { frame: 2, ..base },
            SampleKey { pixel: [4, 4], ..base },
            SampleKey { pixel: [3, 5], ..base },
            SampleKey {
                pixel: [3 + (1 << 20), 4],
                ..base
            },
            SampleKey { sample: 6, ..base },
            SampleKey { sample: 5 + 64, ..base },
        ];
        for other in others {
            assert_ne!(
                sampler.get_2d(&other, BSDF),
                sampler.get_2d(&base, BSDF),
                "{name} {other:?}"
            );
        }
        assert_ne!(sampler.get_2d(&base, LIGHT), sampler.get_2d(&base, BSDF), "{name}");
        let mut cells = [0_u32; 64];
        for i in 0..64_000 {
            let u = sampler.get_2d(&key(i / 64 % 32, i / 2048, i % 64), BSDF);
            assert!(u.min_element() >= 0.0 && u.max_element() < 1.0);
            cells[(u.x * 8.0) as usize * 8 + (u.y * 8.0) as usize] += 1;
        }
        // Chi-square with 63 degrees of freedom: 99.99 % lie below 115.
        let chi2: f64 = cells.iter().map(|&n| (f64::from(n) - 1000.0).powi(2) / 1000.0).sum();
        assert!(chi2 < 115.0, "{name}: {chi2}");
    }
}

#[test]
fn numbers_depend_on_their_address_and_not_on_the_order_of_asking() {
    for (name, sampler) in samplers(20) {
        let keys: Vec<_> = (0..500)
            .map(|i| (key(i % 7, i % 11, i % 20), Dimension(i % 13)))
            .collect();
        let forward: Vec<_> = keys.iter().map(|(k, d)| sampler.get_2d(k, *d)).collect();
        let mut backward: Vec<_> = keys.iter().rev().map(|(k, d)| sampler.get_2d(k, *d)).collect();
        backward.reverse();
        assert_eq!(forward, backward, "{name}");
    }
}

/// Whether `points`, a power of two, are one in each elementary interval.
fn is_a_net(points: &[Vec2]) -> bool {
    let bits = points.len().ilog2();
    (0..=bits).all(|i| {
        let mut seen = vec![false; points.len()];
        points.iter().all(|u| {
            let column = (u.x * (1_u32 << i) as f32) as usize;
            let row = (u.y * (1_u32 << (bits - i)) as f32) as usize;
            !std::mem::replace(&mut seen[column << (bits - i) | row], true)
        })
    })
}

#[test]
fn every_aligned_power_of_two_of_a_pixels_sobol_points_is_a_net() {
    for samples in [1, 2, 8, 20, 64, 256] {
        let sobol = Sampler::default_for(samples);
        for pixel in [[0, 0], [17, 5], [1919, 1079]] {
            for dimension in [Dimension::FILM, BSDF, LIGHT] {
                let all: Vec<_> = (0..samples.next_power_of_two())
                    .map(|s| sobol.get_2d(&key(pixel[0], pixel[1], s), dimension))
                    .collect();
                for bits in 0..=all.len().ilog2() {
                    assert!(all.chunks(1 << bits).all(is_a_net), "{samples} {pixel:?} {bits}");
                }
            }
        }
    }
}

#[test]
fn the_sobol_points_of_every_square_of_pixels_are_a_net() {
    for samples in [1, 4, 16, 32] {
        let sobol = Sampler::default_for(samples);
        for side in [2, 4, 8] {
            for (x0, y0) in [(0, 0), (8, 16), (640, 360)] {
                let points: Vec<_> = (0..side * side * samples)
                    .map(|i| {
                        let pixel = i / samples;
                        sobol.get_2d(&key(x0 + pixel % side, y0 + pixel / side, i % samples), BSDF)
                    })
                    .collect();
                assert!(is_a_net(&points), "{samples} samples, {side}x{side} pixels");
            }
        }
    }
}

#[test]
fn any_two_of_the_three_numbers_are_a_net_in_which_each_box_of_two_shares_has_two_points() {
    // Of the third coordinate two digits belong together: boxes of the volume of two points have two.
    for samples in [2_u32, 8, 64, 256] {
        let sobol = Sampler::default_for(samples);
        for (pixel, dimension) in [([0, 0], BSDF), ([17, 5], LIGHT), ([1919, 1079], BSDF)] {
            let all: Vec<_> = (0..samples)
                .map(|s| sobol.get_3d(&key(pixel[0], pixel[1], s), dimension))
                .map(|(u, third)| u.extend(third.f32()))
                .collect();
            for points in (1..=samples.ilog2()).flat_map(|bits| all.chunks(1 << bits)) {
                let digits = points.len().ilog2() - 1;
                for (i, j) in (0..=digits).flat_map(|i| (0..=digits - i).map(move |j| (i, j))) {
                    let sides = [i, j, digits - i - j];
                    let mut counts = vec![0; points.len() / 2];
                    for u in points {
                        let cell = |k: usize| (u[k] * (1_u32 << sides[k]) as f32) as usize;
                        counts[(cell(0) << j | cell(1)) << sides[2] | cell(2)] += 1;
                    }
                    assert!(counts.iter().all(|n| *n == 2), "{sides:?} of {}", points.len());
                }
            }
        }
    }
}

#[test]
fn the_third_number_is_uniform_and_independent_of_those_of_other_dimensions() {
    for (name, sampler) in samplers(16) {
        for other in [Dimension::FILM, LIGHT] {
            let mut cells = [0_u32; 64];
            for n in 0..16 * 1024 {
                let k = key(n / 16 % 32, n / 512, n % 16);
                let ((_, u), (pair, v)) = (sampler.get_3d(&k, BSDF), sampler.get_3d(&k, other));
                assert_eq!(pair, sampler.get_2d(&k, other), "{name}");
                cells[(u.f32() * 8.0) as usize * 8 + (v.f64() * 8.0) as usize] += 1;
            }
            let chi2: f64 = cells.iter().map(|&n| (f64::from(n) - 256.0).powi(2) / 256.0).sum();
            assert!(chi2 < 115.0, "{name}: {chi2}");
        }
    }
}

#[test]
fn different_dimensions_of_a_sample_are_independent() {
    // Sixteen samples, as a path draws them: every cell of a pair of dimensions gets its share,
    // over 1024 pixels.
    for (name, sampler) in samplers(16) {
        let dimensions = [Dimension::FILM, Dimension::LENS, BSDF, LIGHT];
        for (i, &a) in dimensions.iter().enumerate() {
            for &b in &dimensions[i + 1..] {
                let pairs: Vec<_> = (0..16 * 1024)
                    .map(|n| {
                        let k = key(n / 16 % 32, n / 512, n % 16);
                        (sampler.get_2d(&k, a), sampler.get_2d(&k, b))
                    })
                    .collect();
                let mut cells = [0_u32; 64];
                for (u, v) in &pairs {
                    cells[(u.x * 8.0) as usize * 8 + (v.y * 8.0) as usize] += 1;
                }
                let chi2: f64 = cells.iter().map(|&n| (f64::from(n) - 256.0).powi(2) / 256.0).sum();
                assert!(chi2 < 115.0, "{name} {a:?} {b:?}: {chi2}");
                let both: Vec<_> = pairs.iter().map(|(u, v)| (u.x.into(), v.x.into())).collect();
                let r = correlation(&both);
                // Four standard deviations of white noise.
                assert!(r.abs() < 4.0 / 128.0, "{name} {a:?} {b:?}: {r}");
            }
        }
    }
}

#[test]
fn distant_pixels_frames_and_seeds_are_independent() {
    for (name, sampler) in samplers(4) {
        let partner = |k: SampleKey| {
            [
                SampleKey {
                    pixel: [k.pixel[0] + 41, k.pixel[1] + 23],
                    ..k
                },
                SampleKey {
                    frame: k.frame + 1,
                    ..k
                },
                SampleKey { seed: k.seed + 1, ..k },
            ]
        };
        for which in 0..3 {
            let pairs: Vec<_> = (0..16 * 1024)
                .map(|i| {
                    let k = key(i % 64, i / 64 % 64, i / 4096);
                    let (u, v) = (sampler.get_2d(&k, BSDF), sampler.get_2d(&partner(k)[which], BSDF));
                    (u.x.into(), v.x.into())
                })
                .collect();
            let r = correlation(&pairs);
            assert!(r.abs() < 4.0 / 128.0, "{name} {which}: {r}");
        }
    }
}

/// A function on the unit square, and its mean.
type Integral = (fn(Vec2) -> f64, f64);

const DISK: Integral = (
    |u| f64::from(u8::from(u.length_squared() < 0.5)),
    std::f64::consts::FRAC_PI_8,
);
const SMOOTH: Integral = (|u| f64::from(u.x * u.x * (1.0 - u.y)), 1.0 / 6.0);

/// The error of each of 64 x 64 pixels where all samples estimate an integral.
fn errors(sampler: Sampler, samples: u32, seed: u32, (f, mean): Integral) -> Vec<f64> {
    let pixel = |i: u32| {
        let at = |s| SampleKey {
            seed,
            ..key(i % 64, i / 64, s)
        };
        let sum: f64 = (0..samples).map(|s| f(sampler.get_2d(&at(s), BSDF))).sum();
        sum / f64::from(samples) - mean
    };
    (0..64 * 64).map(pixel).collect()
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn sobol_points_integrate_better_than_independent_ones_and_the_better_the_more() {
    let gain = |total: u32, taken: u32, integral: Integral| {
        let white = errors(Sampler::Independent(Independent), taken, 0, integral);
        rms(&white) / rms(&errors(Sampler::default_for(total), taken, 0, integral))
    };
    for (integral, least) in [(DISK, [1.8, 2.6, 3.6]), (SMOOTH, [4.0, 14.0, 50.0])] {
        for (samples, least) in [16, 64, 256].into_iter().zip(least) {
            let found = gain(samples, samples, integral);
            assert!(found > least, "{samples}: {found}");
        }
    }
    // Half of a run, and numbers that are no powers of two.
    for (total, taken) in [(128, 64), (48, 48), (100, 100)] {
        let found = gain(total, taken, DISK);
        assert!(found > 2.0, "{taken} of {total}: {found}");
    }
}

/// The mean product of the errors of pixels that are (dx, dy) apart, over that of a pixel with
/// itself.
fn neighbours(errors: &[f64], dx: usize, dy: usize) -> f64 {
    let at = |x: usize, y: usize| errors[y * 64 + x];
    let pairs: Vec<_> = (0..64 - dy)
        .flat_map(|y| (0..64 - dx).map(move |x| (at(x, y), at(x + dx, y + dy))))
        .collect();
    correlation(&pairs)
}

/// The variance of the mean error of squares of 5 by 5 pixels, wherever they lie, over what white
/// noise has.
fn coarse(errors: &[f64]) -> f64 {
    let mean = |x0: usize, y0: usize| {
        let square = (y0..y0 + 5).flat_map(|y| (x0..x0 + 5).map(move |x| errors[y * 64 + x]));
        square.sum::<f64>() / 25.0
    };
    let means: Vec<_> = (0..60).flat_map(|y| (0..60).map(move |x| mean(x, y))).collect();
    25.0 * rms(&means).powi(2) / rms(errors).powi(2)
}

/// Correlation with the neighbours to the right, below and across, and [`coarse`], over several
/// seeds.
fn spectrum(sampler: Sampler, samples: u32) -> [f64; 4] {
    const SEEDS: u32 = 8;
    let mut mean = [0.0; 4];
    for seed in 0..SEEDS {
        let e = errors(sampler, samples, seed, SMOOTH);
        let found = [
            neighbours(&e, 1, 0),
            neighbours(&e, 0, 1),
            neighbours(&e, 1, 1),
            coarse(&e),
        ];
        mean.iter_mut().zip(found).for_each(|(m, f)| *m += f / f64::from(SEEDS));
    }
    mean
}

#[test]
fn the_noise_of_sobol_points_is_blue_and_that_of_independent_ones_white() {
    for samples in [1, 2, 4] {
        let [right, below, across, coarse] = spectrum(Sampler::default_for(samples), samples);
        assert!(
            right < -0.1 && below < -0.1 && across < -0.07,
            "{right} {below} {across}"
        );
        assert!((right - below).abs() < 0.03, "{right} {below}");
        assert!(coarse < 0.36, "{coarse}");
        let [right, below, across, coarse] = spectrum(Sampler::Independent(Independent), samples);
        // Five standard deviations.
        assert!(
            [right, below, across].iter().all(|r| r.abs() < 0.03),
            "{right} {below} {across}"
        );
        assert!((0.85..1.15).contains(&coarse), "{coarse}");
    }
}

#[test]
fn a_fixed_seed_mode_gives_all_frames_the_numbers_of_one() {
    assert_eq!(SeedMode::default(), SeedMode::Frame);
    assert_eq!(
        (SeedMode::Frame.frame(7), SeedMode::Fixed.frame(7)),
        (7, SeedMode::Fixed.frame(8))
    );
}
