//! Frames whose pixels are covered in part.

use super::*;
use crate::denoise::CatcherAlpha;

#[test]
fn light_over_alpha_is_filtered_and_nothing_shines_where_nothing_covers() {
    // Coverage from 0 to 1 across the picture, with light that is 0.8 of it.
    let alpha = plane(|x, _| ((x as f32 - 8.0) / 64.0).clamp(0.0, 1.0));
    let mut own = frame(5, 0.0, 0.0, |_, _| 0.0);
    own.guides.albedo = std::array::from_fn(|_| alpha.iter().map(|a| 0.5 * a).collect());
    own.guides.divide_by_alpha(&alpha);
    let half = |seed: u32| -> Color {
        std::array::from_fn(|c| {
            (0..PIXELS)
                .map(|i| 0.8 * alpha[i] * (1.0 + 0.2 * noise(seed + c as u32, i)))
                .collect()
        })
    };
    let halves = [half(20), half(30)];
    let noisy = mean_of(&halves);
    own.alpha.clone_from(&alpha);
    own.alpha_halves = [alpha.clone(), alpha.clone()];
    own.set_light(halves, Vec::new());
    let denoised = run(&own, &[]);
    let apart = |picture: &Color| {
        let lit = picture[1].iter().zip(&alpha).filter(|(_, alpha)| **alpha > 0.0);
        mean_square(lit.map(|(light, alpha)| light / alpha / 0.8 - 1.0))
    };
    assert!(
        apart(&denoised.beauty) < 0.3 * apart(&noisy),
        "{} {}",
        apart(&denoised.beauty),
        apart(&noisy)
    );
    let uncovered = denoised.beauty[1]
        .iter()
        .zip(&alpha)
        .filter(|(_, alpha)| **alpha == 0.0);
    assert!(uncovered.clone().count() > 0 && uncovered.clone().all(|(light, _)| *light == 0.0));
}

#[test]
fn edges_of_a_resting_camera_keep_their_light_over_alpha() {
    // Two frames whose coverage has other noise, and light that is exactly 0.8 of it.
    let frames = [1, 2].map(|seed| {
        let alpha = plane(|x, y| (0.5 + 0.2 * noise(seed, y * SIZE[0] + x)).clamp(0.0, 1.0));
        let mut frame = frame(seed, 0.0, 0.0, |_, _| 0.0);
        let light: Color = std::array::from_fn(|_| alpha.iter().map(|a| 0.8 * a).collect());
        frame.alpha_halves = [alpha.clone(), alpha.clone()];
        frame.alpha = alpha;
        frame.set_light([light.clone(), light], Vec::new());
        frame
    });
    let (mean, _) = accumulate::accumulate(&frames[0], &[&frames[1]], Isa::best());
    for (i, light) in mean.halves[0][0].iter().enumerate() {
        let light = light * frames[0].modulation[0][i];
        assert!((light - 0.8 * frames[0].alpha[i]).abs() < 1e-5);
    }
}

/// A frame whose coverage rises from 0 to 1 from the left to the right, with noise; its light is 0.8 of it.
fn frame_with_noisy_alpha(seed: u32, covers: impl Fn(usize, usize) -> f32) -> Frame {
    let mut own = frame(seed, 0.0, 0.0, |_, _| 0.0);
    let half = |half: u32| {
        let noisy = |x, y| covers(x, y) * (1.0 + 0.2 * noise(2 * seed + half, y * SIZE[0] + x));
        plane(|x, y| noisy(x, y).clamp(0.0, 1.0))
    };
    own.alpha_halves = [half(0), half(1)];
    let [a, b] = &own.alpha_halves;
    own.alpha = a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
    let light = [a, b].map(|half| -> Color { std::array::from_fn(|_| half.iter().map(|a| 0.8 * a).collect()) });
    own.set_light(light, Vec::new());
    own
}

#[test]
fn filtered_alpha_has_less_noise_and_red_over_alpha_equals_08_in_every_pixel() {
    let covers = |x: usize, _: usize| ((x as f32 - 16.0) / 64.0).clamp(0.0, 1.0);
    let frames = [60, 61, 62].map(|seed| frame_with_noisy_alpha(seed, covers));
    let truth = plane(covers);
    let apart = |alpha: &[f32]| mean_square(alpha.iter().zip(&truth).map(|(a, b)| a - b));
    for others in [&[][..], &[&frames[1], &frames[2]]] {
        let denoised = run(&frames[0], others);
        let alpha = denoised.alpha.expect("it has noise");
        let (before, after) = (apart(&frames[0].alpha), apart(&alpha));
        assert!(after < 0.5 * before, "{after} {before}");
        for (i, alpha) in alpha.iter().enumerate() {
            let light = denoised.beauty[0][i];
            assert!((light - 0.8 * alpha).abs() <= 1e-5 * alpha, "{i}: {light} {alpha}");
        }
    }
}

#[test]
fn covered_frames_keep_their_alpha() {
    assert!(run(&frame(3, 0.0, 0.1, |_, _| 1.0), &[]).alpha.is_none());
}

/// A frame of a shadow catcher, the alpha of whose noisy shadow rises from 0 to 1, and whose reflection is `light`.
fn catcher(seed: u32, light: f32) -> (Frame, Vec<f32>) {
    let shadow = |x: usize, _: usize| ((x as f32 - 32.0) / 48.0).clamp(0.0, 1.0);
    let half =
        |half: u32| plane(|x, y| (shadow(x, y) * (1.0 + 0.3 * noise(2 * seed + half, y * SIZE[0] + x))).min(1.0));
    let halves = [half(0), half(1)];
    let mut own = frame(seed, 0.0, 0.2 * light, |_, _| light);
    own.catcher_alpha = Some(CatcherAlpha {
        all: halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (a + b)).collect(),
        halves,
    });
    (own, plane(shadow))
}

#[test]
fn the_alpha_of_a_catcher_is_filtered_and_says_nothing_of_its_light() {
    let (own, truth) = catcher(70, 0.5);
    let (plain, _) = catcher(70, 0.5);
    let plain = Frame {
        catcher_alpha: None,
        ..plain
    };
    let (denoised, plain) = (run(&own, &[]), run(&plain, &[]));
    assert_eq!(denoised.beauty, plain.beauty);
    let apart = |alpha: &[f32]| mean_square(alpha.iter().zip(&truth).map(|(a, b)| a - b));
    let alpha = denoised.alpha.expect("it has noise");
    let noisy = &own.catcher_alpha.as_ref().expect("it has a catcher").all;
    assert!(apart(&alpha) < 0.5 * apart(noisy), "{} {}", apart(&alpha), apart(noisy));
}

#[test]
fn light_that_rounding_makes_negative_is_no_outlier() {
    let mut own = frame(80, 0.0, 0.1, |_, _| 1.0);
    let dark = |i: usize| i % SIZE[0] < 16 && i.is_multiple_of(3);
    let half = |c: usize, half: f32| (0..PIXELS).map(|i| if c < 2 && dark(i) { half } else { 0.0 }).collect();
    let tiny = f32::from_bits(1);
    for (a, b) in [(-1e-9, 0.0), (-tiny, tiny), (0.0, -tiny)] {
        let halves = [a, b].map(|value| -> Color { std::array::from_fn(|c| half(c, value)) });
        own.set_light(halves, Vec::new());
        let denoised = run(&own, &[]);
        assert!(denoised.beauty.iter().flatten().all(|v| v.abs() <= 1e-8));
    }
}
