//! Frames denoised by Open Image Denoise, whose network learned what pictures look like.

use super::{
    choose, coverage,
    denoised::Denoised,
    frame::Frame,
    nlm,
    signal::{Color, Signal, black},
};
use crate::{
    native::{Oidn, OidnError, OidnImages},
    simd::Isa,
};

/// Denoises `mean`, the mean over time at the pixels of `own`, which the second color multiplies.
pub(super) fn denoise(
    own: &Frame,
    (mean, modulation): (&Signal, &Color),
    oidn: &mut Oidn,
    simd: Isa,
) -> Result<Denoised, OidnError> {
    let pixels = own.pixels();
    let noisy: Color = std::array::from_fn(|c| {
        let halves = mean.halves[0][c].iter().zip(&mean.halves[1][c]);
        let light = halves.zip(&modulation[c]).map(|((a, b), by)| 0.5 * (a + b) * by);
        light.collect()
    });
    let noisy = coverage::fill(&noisy, &own.alpha, own.size);
    let [albedo, normal] = [&own.guides.albedo, &own.guides.normal].map(|guide| {
        let covered = |plane: &Vec<f32>| plane.iter().zip(&own.alpha).map(|(v, alpha)| v * alpha).collect();
        coverage::fill(&guide.each_ref().map(covered), &own.alpha, own.size)
    });
    let interleaved =
        |value: &dyn Fn(usize, usize) -> f32| -> Vec<f32> { (0..3 * pixels).map(|at| value(at % 3, at / 3)).collect() };
    let mut output = vec![0.0; 3 * pixels];
    oidn.denoise(&mut OidnImages {
        width: own.size[0],
        height: own.size[1],
        color: &mut interleaved(&|c, i| noisy[c][i]),
        albedo: &mut interleaved(&|c, i| albedo[c][i]),
        normal: &mut interleaved(&|c, i| normal[c][i]),
        output: &mut output,
    })?;
    let mut beauty: Color = black(pixels);
    for (at, value) in output.into_iter().enumerate() {
        beauty[at % 3][at / 3] = value * own.alpha[at / 3];
    }
    if mean.light.is_empty() {
        return Ok(Denoised {
            beauty,
            light: Vec::new(),
            error: None,
            alpha: None,
            is_exact: choose::exact(own),
        });
    }
    let windows = nlm::filter(mean, own, simd);
    let mut denoised = choose::choose(own, (mean, modulation), &windows);
    (denoised.beauty, denoised.error) = (beauty, None);
    choose::scale_families(own, &mut denoised);
    Ok(denoised)
}
