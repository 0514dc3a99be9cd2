//! The alpha, which is filtered as a gray picture of its own, and light that follows it.
//!
//! Light over alpha is filtered apart from the alpha (`frame`), so edges whose light is the alpha's alone keep the ratio of both.

use super::{
    accumulate, blur, choose,
    denoised::Denoised,
    frame::{Frame, Guides, divide},
    nlm, reproject,
    signal::{Color, black},
};
use crate::simd::Isa;

/// Pixels beyond an edge to which light over alpha is continued: as far as filters reach.
const REACH: usize = 8;

/// The alpha is filtered as light from this on, so that no pixel counts as a spot of light or as one without.
const BASE: f32 = 1.0;

/// Filters the alpha with that of the frames around, where their camera rests; light follows it, but that of shadow catchers.
pub(super) fn filter_alpha(own: &Frame, others: &[&Frame], denoised: &mut Denoised, simd: Isa) {
    let (own_alpha, halves) = own.picture_alpha();
    let is_partial = |i: usize| halves.iter().any(|half| half[i] != own_alpha[i]);
    if !(0..own.pixels()).any(is_partial) {
        return;
    }
    let gray = gray(own);
    let others: Vec<Frame> = others
        .iter()
        .filter(|other| reproject::is_still(own, other))
        .map(|other| self::gray(other))
        .collect();
    let (mean, modulation) = accumulate::accumulate(&gray, &others.iter().collect::<Vec<_>>(), simd);
    let filtered = choose::choose(&gray, (&mean, &modulation), &nlm::filter(&mean, &gray, simd));
    let [is_near, ..] = fill(&[(); 3].map(|()| own_alpha.to_vec()), own_alpha, own.size);
    let alpha = (0..own.pixels()).map(|i| match filtered.is_exact[i] || is_near[i] == 0.0 {
        true => own_alpha[i],
        false => (filtered.beauty[0][i] - BASE).clamp(0.0, 1.0),
    });
    let alpha: Vec<f32> = alpha.collect();
    if own.catcher_alpha.is_none() {
        follow(own, &alpha, denoised);
    }
    for (own, alpha) in denoised.is_exact.iter_mut().zip(&filtered.is_exact) {
        *own &= alpha;
    }
    denoised.alpha = Some(alpha);
}

/// Multiplies light over the alpha of the frame by this one.
fn follow(own: &Frame, alpha: &[f32], denoised: &mut Denoised) {
    let colors = [&mut denoised.beauty].into_iter().chain(&mut denoised.light);
    for color in colors.chain(&mut denoised.error) {
        *color = fill(color, &own.alpha, own.size);
        for plane in color {
            plane.iter_mut().zip(alpha).for_each(|(value, alpha)| *value *= alpha);
        }
    }
}

/// The alpha of a frame as gray light of full coverage.
fn gray(frame: &Frame) -> Frame {
    let pixels = frame.pixels();
    let mut gray = Frame {
        size: frame.size,
        origin: frame.origin,
        resolution: frame.resolution,
        alpha: vec![1.0; pixels],
        alpha_halves: [vec![1.0; pixels], vec![1.0; pixels]],
        guides: Guides {
            albedo: [vec![1.0; pixels], vec![1.0; pixels], vec![1.0; pixels]],
            albedo_variance: vec![0.0; pixels],
            normal: black(pixels),
            normal_variance: vec![0.0; pixels],
            inverse_depth: vec![1.0; pixels],
            inverse_depth_variance: vec![0.0; pixels],
            object: None,
        },
        scene: frame.scene.clone(),
        camera: frame.camera,
        ..Frame::default()
    };
    let (_, halves) = frame.picture_alpha();
    let half = |half: usize| -> Color {
        let light = halves[half].iter().map(|alpha| BASE + alpha);
        let light: Vec<f32> = light.collect();
        [light.clone(), light.clone(), light]
    };
    gray.set_light([half(0), half(1)], Vec::new());
    gray
}

/// Light over alpha; where nothing covers, that of the nearest pixels.
pub(super) fn fill(light: &Color, alpha: &[f32], size: [usize; 2]) -> Color {
    let (mut light, mut alpha) = (light.clone(), alpha.to_vec());
    for _ in 0..REACH {
        if alpha.iter().all(|alpha| *alpha > 0.0) {
            break;
        }
        let around = blur::mean(&alpha, size, 1);
        let means = light.each_ref().map(|plane| blur::mean(plane, size, 1));
        for i in (0..alpha.len()).filter(|i| around[*i] > 0.0) {
            if alpha[i] == 0.0 {
                alpha[i] = around[i];
                (0..3).for_each(|c| light[c][i] = means[c][i]);
            }
        }
    }
    for plane in &mut light {
        divide(plane, &alpha);
    }
    light
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_beyond_the_edge_equals_that_of_the_nearest_pixels_as_far_as_filters_reach() {
        let (width, edge) = (24, 10);
        let row = |value: f32| -> Vec<f32> {
            (0..2 * width)
                .map(|i| if i % width < edge { value } else { 0.0 })
                .collect()
        };
        let filled = fill(&[row(0.4), row(0.2), row(0.1)], &row(0.5), [width, 2]);
        for (plane, color) in filled.iter().zip([0.8, 0.4, 0.2]) {
            for (i, light) in plane.iter().enumerate() {
                let expected = if i % width < edge + REACH { color } else { 0.0 };
                assert!((light - expected).abs() < 1e-5, "{i}: {light}");
            }
        }
    }
}
