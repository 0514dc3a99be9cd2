//! Frames denoised by Open Image Denoise, whose network learned what pictures look like.

use super::{
    choose,
    denoised::Denoised,
    frame::Frame,
    nlm,
    signal::{Color, Signal, black},
};
use crate::{
    native::{Oidn, OidnError, OidnImages},
    simd::Isa,
};

/// Denoises `mean`, the mean over time at the pixels of `own`.
pub(super) fn denoise(own: &Frame, mean: &Signal, oidn: &mut Oidn, simd: Isa) -> Result<Denoised, OidnError> {
    let pixels = own.pixels();
    let noisy = |c: usize, i: usize| {
        let mean = 0.5 * (mean.halves[0][c][i] + mean.halves[1][c][i]);
        mean * own.modulation[c][i]
    };
    let interleaved =
        |value: &dyn Fn(usize, usize) -> f32| -> Vec<f32> { (0..3 * pixels).map(|at| value(at % 3, at / 3)).collect() };
    let mut output = vec![0.0; 3 * pixels];
    oidn.denoise(&mut OidnImages {
        width: own.size[0],
        height: own.size[1],
        color: &mut interleaved(&noisy),
        albedo: &mut interleaved(&|c, i| own.guides.albedo[c][i]),
        normal: &mut interleaved(&|c, i| own.guides.normal[c][i]),
        output: &mut output,
    })?;
    let mut beauty: Color = black(pixels);
    for (at, value) in output.into_iter().enumerate() {
        beauty[at % 3][at / 3] = value;
    }
    if mean.light.is_empty() {
        return Ok(Denoised {
            beauty,
            light: Vec::new(),
            error: None,
            is_exact: choose::exact(own),
        });
    }
    let windows = nlm::filter(mean, own, simd);
    let mut denoised = choose::choose(own, mean, &windows);
    (denoised.beauty, denoised.error) = (beauty, None);
    choose::scale_families(own, &mut denoised);
    Ok(denoised)
}
