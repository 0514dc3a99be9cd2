//! The denoiser on pictures whose truth is known.

mod alpha;
mod layers;
mod motion;

use super::{CameraMatrices, Color, Denoised, Frame, Guides, Method, accumulate, denoise, nlm};
use crate::{
    math::{exponential, hash, trig},
    simd::Isa,
};

const SIZE: [usize; 2] = [96, 80];
const PIXELS: usize = SIZE[0] * SIZE[1];

/// A camera at the origin that looks along -z of the world, with 90 degrees across; moved to the right by `x`.
fn camera(x: f32) -> CameraMatrices {
    // For row vectors: camera space is x, y and -z of the world.
    let view = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., -1., 0., -x, 0., 0., 1.];
    let high = SIZE[0] as f32 / SIZE[1] as f32;
    // ndc x = 0.5 + 0.5 (px - x) / z with z = -pz, and y downwards.
    let ndc = [
        0.5,
        0.,
        0.,
        0.,
        0.,
        -0.5 * high,
        0.,
        0.,
        -0.5,
        -0.5,
        -1.,
        -1.,
        -0.5 * x,
        0.,
        0.,
        0.,
    ];
    CameraMatrices {
        camera_from_world: view,
        ndc_from_world: Some(ndc),
        lens: None,
    }
}

/// Normally distributed numbers with variance 1.
fn noise(seed: u32, i: usize) -> f32 {
    let [a, b, ..] = hash::pcg4d([seed, i as u32, 0, 0]).map(hash::unit_f32);
    (-2.0 * exponential::ln(1.0 - a)).sqrt() * trig::cos(std::f32::consts::TAU * b)
}

fn plane(value: impl Fn(usize, usize) -> f32) -> Vec<f32> {
    (0..PIXELS).map(|i| value(i % SIZE[0], i / SIZE[0])).collect()
}

fn gray(value: impl Fn(usize, usize) -> f32) -> Color {
    let values = plane(value);
    [values.clone(), values.clone(), values]
}

/// A wall at z = -2 whose albedo is 0.5, seen from `x`; each half of the samples has light `truth` with noise of deviation `sigma`.
fn frame(seed: u32, x: f32, sigma: f32, truth: impl Fn(usize, usize) -> f32 + Copy) -> Frame {
    let mut frame = Frame {
        size: SIZE,
        resolution: SIZE.map(|v| v as u32),
        alpha: vec![1.0; PIXELS],
        alpha_halves: [vec![1.0; PIXELS], vec![1.0; PIXELS]],
        guides: Guides {
            albedo: gray(|_, _| 0.5),
            albedo_variance: vec![0.0; PIXELS],
            normal: [plane(|_, _| 0.0), plane(|_, _| 0.0), plane(|_, _| 1.0)],
            normal_variance: vec![0.0; PIXELS],
            inverse_depth: vec![0.5; PIXELS],
            inverse_depth_variance: vec![0.0; PIXELS],
            object: None,
        },
        camera: Some(camera(x)),
        scene: Some("wall".to_owned()),
        ..Frame::default()
    };
    let half = |half: u32| -> Color {
        std::array::from_fn(|c| {
            plane(|x, y| truth(x, y) + sigma * noise(seed * 6 + half * 3 + c as u32, y * SIZE[0] + x))
        })
    };
    frame.set_light([half(0), half(1)], Vec::new());
    frame
}

fn mean_of(halves: &[Color; 2]) -> Color {
    let mean = |c: usize, i: usize| 0.5 * (halves[0][c][i] + halves[1][c][i]);
    std::array::from_fn(|c| (0..PIXELS).map(|i| mean(c, i)).collect())
}

fn run(own: &Frame, others: &[&Frame]) -> Denoised {
    denoise(own, others, &mut Method::NonLocalMeans, Isa::best()).expect("this method cannot fail")
}

fn mean_square(values: impl Iterator<Item = f32>) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for value in values {
        sum += f64::from(value) * f64::from(value);
        count += 1;
    }
    sum / f64::from(count)
}

/// The mean square of the difference from `truth`.
fn error(denoised: &Color, truth: impl Fn(usize, usize) -> f32) -> f64 {
    let truth = plane(truth);
    mean_square(
        denoised
            .iter()
            .flat_map(|values| values.iter().zip(&truth))
            .map(|(v, truth)| v - truth),
    )
}

#[test]
fn a_picture_without_noise_stays_as_it_is() {
    let truth = |x: usize, y: usize| if (x / 7 + y / 5).is_multiple_of(2) { 3.0 } else { 0.25 };
    let frames = [0, 1, 2].map(|i| frame(i, 0.0, 0.0, truth));
    let denoised = run(&frames[1], &[&frames[0], &frames[2]]);
    assert!(denoised.is_exact.iter().all(|exact| *exact));
    assert!(error(&denoised.beauty, truth) < 1e-12);
}

#[test]
fn white_noise_is_left_with_the_variance_that_the_weights_predict() {
    let own = frame(7, 0.0, 0.1, |_, _| 1.0);
    let [_, large] = nlm::filter(&own.signal, &own, Isa::best());
    // In parts of the albedo.
    let variance = (0.1_f64 / 0.5).powi(2);
    let predicted = large.squares.iter().map(|s| f64::from(*s)).sum::<f64>() / PIXELS as f64 * variance;
    let measured = mean_square(large.halves.iter().flatten().flatten().map(|v| v - 2.0));
    assert!((measured / predicted - 1.0).abs() < 0.15, "{measured} {predicted}");
    assert!(predicted < variance / 80.0, "{predicted}");
}

#[test]
fn frames_around_take_the_noise_of_a_still_camera_down_by_their_number() {
    let frames: Vec<Frame> = (0..5).map(|i| frame(i, 0.0, 0.1, |_, _| 1.0)).collect();
    let others: Vec<&Frame> = frames[..4].iter().collect();
    let (mean, _) = accumulate::accumulate(&frames[4], &others, Isa::best());
    let left = mean_square(mean.halves.iter().flatten().flatten().map(|v| v - 2.0));
    assert!((left / (0.04 / 5.0) - 1.0).abs() < 0.05, "{left}");
    let told = mean.variance.iter().flatten().map(|v| f64::from(*v)).sum::<f64>() / (3 * PIXELS) as f64;
    assert!((told / left - 1.0).abs() < 0.1, "{told} {left}");
}

/// The part of the noise that is left of a moving frame with one beside it, whose halves are correlated by `correlation`.
fn noise_left_of_a_moving_camera(correlation: f32) -> f64 {
    // A pattern on the wall, whose columns are 2 * 2 / 96 m wide: a step of 6 columns between the frames.
    let step = 6.0 * 4.0 / 96.0;
    let seen =
        |shift: usize| move |x: usize, y: usize| 1.0 + 0.5 * f32::from(((x + shift) / 6 + y / 6).is_multiple_of(2));
    let (common, apart) = ((0.5 + 0.5 * correlation).sqrt(), (0.5 - 0.5 * correlation).sqrt());
    let frame = |seed: u32, x: f32, shift: usize| {
        let mut frame = frame(seed, x, 0.0, seen(shift));
        let half = |sign: f32| -> Color {
            std::array::from_fn(|c| {
                let noise = |i: usize, which: u32| noise(6 * seed + 2 * c as u32 + which, i);
                let noise = |i: usize| common * noise(i, 0) + sign * apart * noise(i, 1);
                plane(|x, y| seen(shift)(x, y) + 0.02 * noise(y * SIZE[0] + x))
            })
        };
        frame.set_light([half(1.0), half(-1.0)], Vec::new());
        frame
    };
    let (own, other) = (frame(1, 0.0, 0), frame(2, step, 6));
    let (mean, _) = accumulate::accumulate(&own, &[&other], Isa::best());
    let inner = |values: &Color| -> f64 {
        let pixels = (8..88).flat_map(|x| (8..72).map(move |y| (x, y)));
        mean_square((0..3).flat_map(|c| {
            let pixels = pixels.clone();
            pixels.map(move |(x, y)| values[c][y * SIZE[0] + x] - 2.0 * seen(0)(x, y))
        }))
    };
    inner(&mean.halves[0]) / inner(&own.signal.halves[0])
}

/// Weights w leave (1 + w^2) / (1 + w)^2 of the noise. They are the part of the frames' difference that noise explains, times what
/// the test of patches leaves: 0.66 in the mean, as it compares estimated variances. Halves that are correlated by -0.3, as is
/// assumed, explain all: 0.55 is left with the spread of the weights. Independent ones explain 0.7 / 1.3 = 0.54: 0.64 is left.
#[test]
fn a_moving_camera_finds_the_places_of_the_wall_again() {
    for (correlation, expected) in [(-0.3, 0.4..0.6), (0.0, 0.6..0.68)] {
        let left = noise_left_of_a_moving_camera(correlation);
        assert!(expected.contains(&left), "{correlation}: {left}");
    }
}

#[test]
fn what_has_changed_between_frames_is_left_out() {
    let own = frame(1, 0.0, 0.02, |_, _| 1.0);
    let other = frame(2, 0.0, 0.02, |x, _| if x < 48 { 1.0 } else { 1.5 });
    let (mean, _) = accumulate::accumulate(&own, &[&other], Isa::best());
    let of = |columns: std::ops::Range<usize>| {
        let values = columns.flat_map(|x| (0..SIZE[1]).map(move |y| y * SIZE[0] + x));
        values.map(|i| f64::from(mean.halves[0][0][i])).sum::<f64>() / (40.0 * 80.0)
    };
    assert!((of(4..44) - 2.0).abs() < 0.005);
    assert!((of(52..92) - 2.0).abs() < 0.005);
}

#[test]
fn where_the_scene_has_changed_a_resting_camera_tests_surface_and_light() {
    let lit = |light: f32| move |_: usize, _: usize| light;
    let own = frame(1, 0.0, 0.2, lit(1.0));
    // A tenth more light, half of the noise of a half of a pixel; and another object in the left half.
    let mut brighter = frame(2, 0.0, 0.2, lit(1.1));
    let mut moved = frame(3, 0.0, 0.2, lit(1.0));
    moved.guides.inverse_depth = plane(|x, _| if x < 48 { 1.0 } else { 0.5 });
    for other in [&mut brighter, &mut moved] {
        other.scene = Some("another".to_owned());
    }
    let taken = |other: &Frame| {
        let (mean, _) = accumulate::accumulate(&own, &[other], Isa::best());
        let differs = |i: usize| mean.halves[0][0][i] != own.signal.halves[0][0][i];
        let count = |columns: std::ops::Range<usize>| {
            (0..PIXELS)
                .filter(|i| columns.contains(&(i % SIZE[0])) && differs(*i))
                .count()
        };
        [count(0..48), count(48..96)]
    };
    assert_eq!(taken(&brighter), [0, 0]);
    let [left, right] = taken(&moved);
    assert!(left == 0 && right > PIXELS / 3, "{left} {right}");
}

#[test]
fn a_single_bright_half_is_cut_and_spreads_nowhere_and_the_error_tells_it() {
    let bright = 40 * SIZE[0] + 50;
    let mut frames = [0, 1, 2].map(|seed| frame(seed, 0.0, 0.1, |_, _| 1.0));
    let mut halves = frames[0]
        .signal
        .halves
        .clone()
        .map(|half| half.map(|v| v.iter().map(|v| 0.5 * v).collect::<Vec<f32>>()));
    for plane in &mut halves[1] {
        plane[bright] = 500.0;
    }
    frames[0].set_light(halves, Vec::new());
    assert_eq!(frames[0].cut_light().0, 1);
    let [firefly, own, other] = &frames;
    for (own, others) in [(firefly, [own, other]), (own, [firefly, other])] {
        let denoised = run(own, &others);
        let largest = denoised.beauty[0].iter().fold(0.0_f32, |a, b| a.max(*b));
        assert!(largest < 1.5, "{largest}");
    }
    let error = run(firefly, &[own, other]).error.expect("this filter tells it");
    assert!(error[0][bright] > 100.0, "{}", error[0][bright]);
}

/// The pixels that are more than twice as bright as the median of the 5 x 5 pixels around them, and 0.02.
fn specks(light: &[f32]) -> Vec<usize> {
    let is_speck = |i: &usize| {
        let around = |at: usize, size: usize| at.saturating_sub(2)..(at + 3).min(size);
        let rows = around(i / SIZE[0], SIZE[1]);
        let mut values: Vec<f32> = rows
            .flat_map(|y| around(i % SIZE[0], SIZE[0]).map(move |x| y * SIZE[0] + x))
            .map(|i| light[i])
            .collect();
        values.sort_by(f32::total_cmp);
        light[*i] > 2.0 * values[values.len() / 2] + 0.02
    };
    (0..PIXELS).filter(is_speck).collect()
}

#[test]
fn at_most_a_tenth_of_the_specks_is_left_and_none_spreads() {
    let frames = [0, 1, 2].map(|seed| {
        let mut frame = frame(seed, 0.0, 0.0, |_, _| 1.0);
        // A path of much light in one of 400 pixels of each half, several times as many as in scenes with caustics.
        let half = |half: u32| {
            gray(|x, y| {
                let [chance, light, ..] = hash::pcg4d([x as u32, y as u32, seed, 50 + half]).map(hash::unit_f32);
                let path = if chance < 0.0025 { 10.0 + 90.0 * light } else { 0.0 };
                1.0 + 0.1 * noise(10 * seed + half, y * SIZE[0] + x) + path
            })
        };
        frame.set_light([half(0), half(1)], Vec::new());
        (frame, mean_of(&[half(0), half(1)]))
    });
    let [(own, noisy), (before, _), (after, _)] = &frames;
    let denoised = run(own, &[before, after]);
    let (noisy, left) = (specks(&noisy[0]), specks(&denoised.beauty[0]));
    assert!(
        noisy.len() > 25 && 10 * left.len() <= noisy.len(),
        "{} {}",
        noisy.len(),
        left.len()
    );
    assert!(left.iter().all(|i| noisy.contains(i)), "{left:?}");
}

#[test]
fn a_bright_path_of_another_frame_beside_a_lamp_counts_as_little_as_its_brightness_differs() {
    let (path, is_lamp) = (40 * SIZE[0] + 52, |x: usize, y: usize| {
        x.abs_diff(49) < 2 && y.abs_diff(40) < 2
    });
    let frames = [70, 80].map(|seed| {
        let mut frame = frame(seed, 0.0, 0.0, |_, _| 1.0);
        let half = |half: u32| -> Color {
            let grain = |x, y| 0.02 * noise(seed + half, y * SIZE[0] + x);
            gray(|x, y| if is_lamp(x, y) { 100.0 } else { 1.0 + grain(x, y) })
        };
        let mut halves = [half(0), half(1)];
        if seed == 80 {
            halves[0].iter_mut().for_each(|plane| plane[path] = 16.0);
        }
        frame.set_light(halves, Vec::new());
        frame
    });
    let mean = mean_of(&accumulate::accumulate(&frames[0], &[&frames[1]], Isa::best()).0.halves);
    // It may have twice the light, and counts as 2 / 16: (1 + 8.5 / 8) / (1 + 1 / 8).
    let light = 0.5 * mean[0][path];
    assert!((light - 1.83).abs() < 0.05, "{light}");
}

#[test]
fn a_mirrored_lamp_of_few_pixels_lends_no_light_to_what_is_around_it() {
    let distance = |x: usize, y: usize| x.abs_diff(48).max(y.abs_diff(40));
    let truth = |x: usize, y: usize| if distance(x, y) < 2 { 100.0 } else { 1.0 };
    let mut own = frame(17, 0.0, 0.0, truth);
    // Both halves show the lamp, with much noise; what is around it has little.
    let half = |seed: u32| -> Color {
        let grain = |x: usize, y: usize| noise(seed, y * SIZE[0] + x);
        gray(|x, y| truth(x, y) * (1.0 + if distance(x, y) < 2 { 0.4 } else { 0.02 } * grain(x, y)).max(0.1))
    };
    own.set_light([half(60), half(70)], Vec::new());
    let denoised = run(&own, &[]);
    for ring in 2..6 {
        let pixels = (0..PIXELS).filter(|i| distance(i % SIZE[0], i / SIZE[0]) == ring);
        let light: Vec<f32> = pixels.map(|i| denoised.beauty[0][i]).collect();
        let mean = light.iter().sum::<f32>() / light.len() as f32;
        assert!((mean - 1.0).abs() < 0.02, "{ring}: {mean}");
    }
}

#[test]
fn a_noisy_texture_of_two_pixels_keeps_its_contrast() {
    // Albedo and light have the same noise, as pixels at the edges of a texture have.
    let (bright, dark) = (0.8, 0.1);
    let color = |x: usize, y: usize| {
        if (x / 2 + y / 2).is_multiple_of(2) {
            bright
        } else {
            dark
        }
    };
    let mut own = frame(9, 0.0, 0.0, |_, _| 0.0);
    let covers = |i: usize| 1.0 + 0.3 * noise(77, i);
    own.guides.albedo = gray(|x, y| color(x, y) * covers(y * SIZE[0] + x));
    own.guides.albedo_variance = plane(|x, y| 3.0 * (0.3 * color(x, y)).powi(2));
    let half = |seed: u32| -> Color {
        let albedo = &own.guides.albedo[0];
        std::array::from_fn(|c| {
            (0..PIXELS)
                .map(|i| albedo[i] * (1.0 + 0.2 * noise(seed + c as u32, i)))
                .collect()
        })
    };
    let halves = [half(40), half(50)];
    let noisy = mean_of(&halves);
    own.set_light(halves, Vec::new());
    let denoised = run(&own, &[]);
    let [before, after] = [&noisy, &denoised.beauty].map(|picture| error(picture, color));
    assert!(after < before, "{after} {before}");
}

#[test]
fn edges_of_albedo_normal_and_depth_stay() {
    let truth = |x: usize, _: usize| if x < 48 { 0.8 } else { 1.2 };
    for edge in 1..4 {
        let mut own = frame(3, 0.0, 0.2, truth);
        let right = |a: f32, b: f32| plane(move |x, _| if x < 48 { a } else { b });
        match edge {
            1 => own.guides.albedo[1] = right(0.1, 0.9),
            2 => (own.guides.normal[2], own.guides.normal[0]) = (right(1.0, 0.0), right(0.0, 1.0)),
            _ => own.guides.inverse_depth = right(0.5, 0.25),
        }
        let halves = own
            .signal
            .halves
            .clone()
            .map(|color| color.map(|values| values.iter().map(|v| v * 0.5).collect()));
        own.set_light(halves, Vec::new());
        let denoised = run(&own, &[]);
        // The columns beside the edge.
        let mean = |x: usize| {
            (0..SIZE[1])
                .map(|y| f64::from(denoised.beauty[0][y * SIZE[0] + x]))
                .sum::<f64>()
                / 80.0
        };
        // The noise of the mean of a column that was not filtered, three times and a half.
        let most = 3.5 * 0.2 / 160_f64.sqrt();
        assert!((mean(47) - 0.8).abs() < most, "{edge}: {}", mean(47));
        assert!((mean(48) - 1.2).abs() < most, "{edge}: {}", mean(48));
    }
}

#[test]
fn layers_sum_to_the_beauty() {
    let mut own = frame(5, 0.0, 0.1, |x, _| 1.0 + 0.01 * x as f32);
    let half = |part: f32, seed: u32| -> Color {
        std::array::from_fn(|c| plane(|x, y| part * (1.0 + 0.1 * noise(seed + c as u32, y * SIZE[0] + x))))
    };
    let layers = vec![half(0.7, 91), half(0.3, 95)];
    let halves = own.signal.halves.clone();
    own.set_light(halves, layers);
    own.families = vec![vec![0, 1]];
    let denoised = run(&own, &[]);
    for c in 0..3 {
        for i in 0..PIXELS {
            let sum = denoised.light[0][c][i] + denoised.light[1][c][i];
            assert!((sum / denoised.beauty[c][i] - 1.0).abs() < 1e-5);
        }
    }
}

#[test]
fn with_less_noise_the_picture_goes_to_the_truth() {
    // A pattern of the light alone, finer than the windows.
    let truth = |x: usize, y: usize| 1.0 + 0.3 * trig::sin(x as f32 * 0.9) * trig::cos(y as f32 * 0.7);
    for sigma in [0.1, 0.01, 0.001] {
        let denoised = run(&frame(11, 0.0, sigma, truth), &[]);
        let noise = f64::from(sigma * sigma) / 2.0;
        let left = error(&denoised.beauty, truth);
        assert!(left < 1.1 * noise, "{sigma}: {left} {noise}");
    }
}

#[test]
fn the_error_told_is_that_of_the_picture() {
    let truth = |x: usize, y: usize| {
        1.0 + 0.002 * x as f32
            + if (x as i32 - 40).pow(2) + (y as i32 - 40).pow(2) < 300 {
                0.5
            } else {
                0.0
            }
    };
    let denoised = run(&frame(13, 0.0, 0.15, truth), &[]);
    let told = mean_square(denoised.error.iter().flatten().flatten().copied());
    let left = error(&denoised.beauty, truth);
    assert!((0.5..2.0).contains(&(told / left)), "{told} {left}");
}

#[test]
fn the_bits_are_the_same_on_every_simd_level() {
    let (own, other) = (
        frame(1, 0.0, 0.1, |x, _| x as f32 * 0.02),
        frame(2, 0.13, 0.1, |x, _| x as f32 * 0.02),
    );
    let by = |simd| {
        denoise(&own, &[&other], &mut Method::NonLocalMeans, simd)
            .expect("it cannot fail")
            .beauty
    };
    let all: Vec<Color> = Isa::available().into_iter().map(by).collect();
    assert!(all.iter().all(|beauty| *beauty == all[0]));
}
