//! Frames in which something moves, with its motion vectors.

use super::*;
use crate::denoise::Vectors;

/// The side of a card before the wall, and its first row.
const SIDE: usize = 40;
const TOP: usize = 20;

/// The columns that the card moves in a frame.
const STEP: usize = 6;

/// Frame number `number` of a card at half of the wall's distance, whose left edge is in column `left`. Light is that of `light`,
/// times an albedo of 0.5; a checker on the card moves with it.
fn frame_with_card(number: i32, left: usize, sigma: f32, light: impl Fn(bool, usize, usize) -> f32 + Copy) -> Frame {
    let is_card = |x: usize, y: usize| (left..left + SIDE).contains(&x) && (TOP..TOP + SIDE).contains(&y);
    let albedo = |x: usize, y: usize| match is_card(x, y) {
        true if ((x - left) / 5 + (y - TOP) / 5).is_multiple_of(2) => 0.8,
        _ => 0.5,
    };
    let truth = |x: usize, y: usize| albedo(x, y) * light(is_card(x, y), x, y);
    let mut frame = frame(100 + number as u32, 0.0, 0.0, |_, _| 0.0);
    frame.number = number;
    frame.scene = Some(format!("card {left} {number}"));
    frame.guides.albedo = gray(albedo);
    frame.guides.inverse_depth = plane(|x, y| if is_card(x, y) { 1.0 } else { 0.5 });
    let object = |i: usize| u32::from(is_card(i % SIZE[0], i / SIZE[0]));
    frame.guides.object = Some((0..PIXELS).map(object).collect());
    let half = |half: u32| -> Color {
        std::array::from_fn(|c| {
            let seed = 600 + number as u32 * 6 + half * 3 + c as u32;
            plane(|x, y| truth(x, y) * (1.0 + sigma * noise(seed, y * SIZE[0] + x)))
        })
    };
    frame.set_light([half(0), half(1)], Vec::new());
    frame
}

/// Gives the frames vectors by which the card moves by so many columns a frame.
fn with_vectors(mut frames: Vec<Frame>, step: usize) -> Vec<Frame> {
    for frame in &mut frames {
        let object = frame.guides.object.clone().expect("frames have it");
        let along = || object.iter().map(|object| (*object as usize * step) as f32).collect();
        let zero = || vec![0.0; PIXELS];
        frame.vectors = Some(Vectors {
            backward: [along(), zero(), zero()],
            forward: [along(), zero(), zero()],
        });
    }
    frames
}

/// Five frames of a card that moves by `step` columns a frame, with vectors by `told` columns.
fn sequence(step: usize, told: usize, light: impl Fn(i32, bool, usize, usize) -> f32 + Copy) -> Vec<Frame> {
    let frames = (0..5).map(|number| {
        frame_with_card(number, 8 + step * number as usize, 0.2, move |card, x, y| {
            light(number, card, x, y)
        })
    });
    with_vectors(frames.collect(), told)
}

/// The mean square error of the light of the mean over time on the inner part of the card of the third of five frames.
fn error_on_card(frames: &[Frame], left: usize) -> f64 {
    let others: Vec<&Frame> = frames.iter().filter(|frame| frame.number != 2).collect();
    let (mean, modulation) = accumulate::accumulate(&frames[2], &others, Isa::best());
    let inner = (left + 4..left + SIDE - 4).flat_map(|x| (TOP + 4..TOP + SIDE - 4).map(move |y| y * SIZE[0] + x));
    let light = |i: usize| {
        let light = 0.5 * (mean.halves[0][0][i] + mean.halves[1][0][i]);
        light * modulation[0][i] / frames[2].guides.albedo[0][i]
    };
    mean_square(inner.map(|i| light(i) - 1.0))
}

#[test]
fn a_moving_surface_has_as_little_noise_as_a_still_one_and_without_vectors_it_has_more() {
    let still = error_on_card(&sequence(0, 0, |_, _, _, _| 1.0), 8);
    let moving = error_on_card(&sequence(STEP, STEP, |_, _, _, _| 1.0), 8 + 2 * STEP);
    assert!(moving < 1.15 * still, "{moving} {still}");
    // Five frames: a fifth of the variance of a frame, if all weights were 1.
    assert!(moving < 0.4 * 0.5 * 0.2 * 0.2, "{moving}");
    let mut blind = sequence(STEP, STEP, |_, _, _, _| 1.0);
    blind.iter_mut().for_each(|frame| frame.vectors = None);
    let blind = error_on_card(&blind, 8 + 2 * STEP);
    assert!(blind > 1.5 * moving, "{blind} {moving}");
}

#[test]
fn what_a_bright_card_uncovers_and_covers_shows_nothing_of_it() {
    let frames = sequence(STEP, STEP, |_, card, _, _| if card { 20.0 } else { 1.0 });
    let others: Vec<&Frame> = frames.iter().filter(|frame| frame.number != 2).collect();
    let denoised = run(&frames[2], &others);
    let left = 8 + 2 * STEP;
    // The columns that the card covers in other frames, without the edge, where pixels around it look alike by half.
    for columns in [left - 2 * STEP..left - 1, left + SIDE + 1..left + SIDE + 2 * STEP] {
        let pixels = columns.flat_map(|x| (TOP..TOP + SIDE).map(move |y| y * SIZE[0] + x));
        let light: Vec<f32> = pixels.map(|i| denoised.beauty[0][i] / 0.5).collect();
        let mean = light.iter().sum::<f32>() / light.len() as f32;
        assert!((mean - 1.0).abs() < 0.02, "{mean}");
    }
}

#[test]
fn a_lamp_that_dims_and_a_shadow_that_moves_do_not_lag() {
    let dimmed = sequence(STEP, STEP, |number, _, _, _| 0.8_f32.powi(number - 2));
    let shaded = sequence(STEP, STEP, |number, _, x, _| {
        let edge = 20 + 8 * number as usize;
        if (edge..edge + 16).contains(&x) { 0.3 } else { 1.0 }
    });
    let truths: [&dyn Fn(usize) -> f32; 2] = [&|_| 1.0, &|x| if (36..52).contains(&x) { 0.3 } else { 1.0 }];
    for (frames, truth) in [dimmed, shaded].iter().zip(truths) {
        let others: Vec<&Frame> = frames.iter().filter(|frame| frame.number != 2).collect();
        let denoised = run(&frames[2], &others);
        // By bands of columns below the card; none across an edge of the shadow.
        for band in [4..20, 20..34, 38..50, 54..68, 68..92] {
            let pixels = band.clone().flat_map(|x| (64..76).map(move |y| (x, y * SIZE[0] + x)));
            let light: Vec<f32> = pixels.map(|(x, i)| denoised.beauty[0][i] / 0.5 / truth(x)).collect();
            let mean = light.iter().sum::<f32>() / light.len() as f32;
            assert!((mean - 1.0).abs() < 0.03, "{band:?}: {mean}");
        }
    }
}

#[test]
fn a_frame_far_away_is_reached_by_those_between_and_not_without_them() {
    let frames = sequence(STEP, STEP, |_, _, _, _| 1.0);
    let found = |others: &[&Frame]| {
        let (mean, _) = accumulate::accumulate(&frames[2], others, Isa::best());
        let differs = |i: &usize| mean.halves[0][0][*i] != frames[2].signal.halves[0][0][*i];
        let left = 8 + 2 * STEP;
        let inner = (left + 4..left + SIDE - 4).flat_map(|x| (TOP + 4..TOP + SIDE - 4).map(move |y| y * SIZE[0] + x));
        inner.filter(differs).count() as f64 / 1024.0
    };
    assert_eq!(found(&[&frames[4]]), 0.0);
    let mut dark = frames[3].clone();
    dark.set_light([gray(|_, _| 0.0), gray(|_, _| 0.0)], Vec::new());
    assert!(found(&[&dark, &frames[4]]) > 0.9);
}

#[test]
fn vectors_change_no_bit_where_nothing_moves() {
    let mut frames: Vec<Frame> = (0..3).map(|i| frame(i, 0.0, 0.1, |_, _| 1.0)).collect();
    (0..).zip(&mut frames).for_each(|(number, frame)| frame.number = number);
    let plain = run(&frames[1], &[&frames[0], &frames[2]]);
    for frame in &mut frames {
        let zero = || -> Color { std::array::from_fn(|_| vec![0.0; PIXELS]) };
        frame.vectors = Some(Vectors {
            backward: zero(),
            forward: zero(),
        });
    }
    let with_vectors = run(&frames[1], &[&frames[0], &frames[2]]);
    assert!(plain.beauty == with_vectors.beauty);
}
