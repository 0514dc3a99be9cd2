//! Layers of light whose lamps change from frame to frame.

use super::*;
use crate::denoise::Vectors;

/// The light of a lamp at a pixel.
type Lamp<'a> = &'a dyn Fn(i32, usize, usize) -> f32;

/// Frame number `number` of a wall in the light of two lamps, which are the layers. Each half of a layer has noise of 0.3 of its
/// light. No two frames show one scene.
fn lit(number: i32, lamps: [Lamp<'_>; 2]) -> Frame {
    let mut frame = frame(0, 0.0, 0.0, |_, _| 0.0);
    frame.number = number;
    frame.scene = Some(format!("wall {number}"));
    let half = |lamp: usize, half: u32| -> Color {
        std::array::from_fn(|c| {
            let seed = 900 + number as u32 * 12 + lamp as u32 * 6 + half * 3 + c as u32;
            let noisy = |x: usize, y: usize| 1.0 + 0.3 * noise(seed, y * SIZE[0] + x);
            plane(|x, y| 0.5 * lamps[lamp](number, x, y) * noisy(x, y))
        })
    };
    let sum = |a: &Color, b: &Color, by: f32| -> Color {
        std::array::from_fn(|c| a[c].iter().zip(&b[c]).map(|(a, b)| by * (a + b)).collect())
    };
    let lamps = [0, 1].map(|lamp| [half(lamp, 0), half(lamp, 1)]);
    let halves = [0, 1].map(|half| sum(&lamps[0][half], &lamps[1][half], 1.0));
    let light = lamps.iter().map(|[a, b]| sum(a, b, 0.5)).collect();
    frame.families = vec![vec![0, 1]];
    frame.set_light(halves, light);
    frame
}

/// Five frames in the light of two lamps, with vectors of surfaces that rest or without.
fn sequence(lamps: [Lamp<'_>; 2], has_vectors: bool) -> Vec<Frame> {
    let zero = || -> Color { std::array::from_fn(|_| vec![0.0; PIXELS]) };
    let frame = |number| Frame {
        vectors: has_vectors.then(|| Vectors {
            backward: zero(),
            forward: zero(),
        }),
        ..lit(number, lamps)
    };
    (0..5).map(frame).collect()
}

fn others(frames: &[Frame], own: usize) -> Vec<&Frame> {
    frames.iter().filter(|frame| frame.number != own as i32).collect()
}

/// The mean light of a layer over columns, in parts of the albedo.
fn light(denoised: &Denoised, layer: usize, columns: std::ops::Range<usize>) -> f32 {
    let pixels = columns.clone().flat_map(|x| (0..SIZE[1]).map(move |y| y * SIZE[0] + x));
    let sum: f32 = pixels.map(|i| denoised.light[layer][1][i] / 0.5).sum();
    sum / (columns.len() * SIZE[1]) as f32
}

#[test]
fn a_lamp_that_changes_changes_its_own_layer_alone() {
    let steady: Lamp<'_> = &|_, _, _| 1.0;
    let dims: Lamp<'_> = &|number, _, _| (1.0 - number as f32 / 3.0).max(0.0);
    let begins: Lamp<'_> = &|number, _, _| if number >= 2 { 0.5 } else { 0.0 };
    let ends: Lamp<'_> = &|number, _, _| if number < 2 { 0.5 } else { 0.0 };
    for (name, own, lamps) in [
        ("dims", 2, [steady, dims]),
        ("begins", 1, [steady, begins]),
        ("begins", 2, [steady, begins]),
        ("swap", 2, [ends, begins]),
    ] {
        let frames = sequence(lamps, name != "swap");
        let denoised = run(&frames[own], &others(&frames, own));
        for (layer, lamp) in lamps.iter().enumerate() {
            let truth = lamp(own as i32, 0, 0);
            let found = light(&denoised, layer, 0..SIZE[0]);
            let what = format!("{name}, frame {own}, layer {layer}: {found} of {truth}");
            assert!((found - truth).abs() < 0.01, "{what}");
            let is_black = denoised.light[layer].iter().flatten().all(|light| *light == 0.0);
            assert_eq!(is_black, truth == 0.0, "{what}");
        }
        for c in 0..3 {
            for (i, beauty) in denoised.beauty[c].iter().enumerate() {
                let sum = denoised.light[0][c][i] + denoised.light[1][c][i];
                assert!((sum - beauty).abs() < 1e-5, "{sum} {beauty}");
            }
        }
    }
}

#[test]
fn a_beam_that_moves_leaves_no_ghost_in_its_layer() {
    // It is hidden in the noise of the other lamp.
    let beam: Lamp<'_> = &|number, x, _| {
        if x / 32 == (number as usize + 1) % 3 {
            0.15
        } else {
            0.02
        }
    };
    let frames = sequence([&|_, _, _| 1.0, beam], true);
    let denoised = run(&frames[2], &others(&frames, 2));
    for (columns, truth) in [(4..28, 0.15), (36..60, 0.02), (68..92, 0.02)] {
        let found = light(&denoised, 1, columns.clone());
        assert!((found - truth).abs() < 0.01, "{columns:?}: {found} of {truth}");
    }
}

#[test]
fn layers_that_do_not_change_have_less_noise_by_all_frames() {
    let frames = sequence([&|_, _, _| 1.0, &|_, _, _| 0.3], true);
    let (mean, _) = accumulate::accumulate(&frames[2], &others(&frames, 2), Isa::best());
    for (layer, truth) in [(0, 1.0), (1, 0.3)] {
        let error = mean_square(mean.light[layer].iter().flatten().map(|light| light - truth));
        let alone = 0.5 * 0.3_f64.powi(2) * f64::from(truth).powi(2);
        assert!(error < 0.25 * alone, "{layer}: {error} {alone}");
    }
}
