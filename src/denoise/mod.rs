//! The denoiser: pictures of a sequence with less noise, from the frames around each.
//!
//! Outliers are cut first (`outliers`). Then it works in three steps, each a pure function of pixels:
//!
//! 1. The frames around a frame are brought to its pixels by the cameras and the depth (`reproject`), and where surfaces move by
//!    their motion vectors (`motion`), and averaged where a test of the two pixels' surroundings
//!    cannot tell them apart (`accumulate`).
//! 2. Each pixel becomes a mean of the pixels around it (`nlm`), weighted by how alike their surroundings, normals, depths and
//!    albedos are, in windows of two sizes.
//! 3. The windows are mixed by their estimated errors, and the result with the mean of step 1, so that it goes to the
//!    truth as samples grow (`choose`).
//!
//! Everything works on the halves of each pixel's samples: weights from one half average the other, so that a pixel's noise
//! does not choose its own neighbours, and the difference of the results measures the noise that is left. Light is divided by
//! the albedo before and multiplied afterwards, so textures stay sharp. All light layers get the weights of the beauty, and
//! less of frames in which lamps or objects have changed them (`layers`). The alpha is filtered as a picture of its own, and light
//! over alpha apart from it (`coverage`); the alpha of shadow catchers says nothing of their light, which is divided by the
//! part of a pixel that surfaces cover.
//!
//! Sources: Rousselle, Knaus, Zwicker, "Adaptive Rendering with Non-Local Means Filtering", SIGGRAPH Asia 2012,
//! doi:10.1145/2366145.2366214; Rousselle, Manzi, Zwicker, "Robust Denoising using Feature and Color Information", Pacific
//! Graphics 2013, doi:10.1111/cgf.12219; Bitterli et al., "Nonlinearly Weighted First-order Regression for Denoising Monte
//! Carlo Renderings", EGSR 2016, doi:10.1111/cgf.12954.

mod accumulate;
mod albedo;
mod blur;
mod choose;
mod coverage;
mod denoised;
mod error;
mod frame;
mod layers;
mod learned;
mod level;
mod lighting;
mod motion;
mod nlm;
mod outliers;
mod padded;
mod places;
mod projection;
mod reproject;
mod signal;
mod vectors;

pub use denoised::Denoised;
pub use error::DenoiseError;
pub use frame::{CameraMatrices, CatcherAlpha, Frame, Guides};
pub use signal::{Color, Signal};
pub use vectors::Vectors;

pub use crate::native::{Oidn, OidnError};
use crate::simd::Isa;

/// The filter that follows the mean over time.
pub enum Method {
    /// Non-local means.
    NonLocalMeans,
    /// Open Image Denoise; other light than the beauty is filtered as above, and scaled to it.
    Oidn(Oidn),
}

/// Denoises `own` with the help of the frames around it, in the order of time without itself; on the threads of the current rayon
/// pool. All have the same size and the same layers.
///
/// # Errors
/// Open Image Denoise has failed.
pub fn denoise(own: &Frame, others: &[&Frame], method: &mut Method, simd: Isa) -> Result<Denoised, OidnError> {
    let (mean, modulation) = accumulate::accumulate(own, others, simd);
    let mut denoised = match method {
        Method::NonLocalMeans => {
            let windows = nlm::filter(&mean, own, simd);
            choose::choose(own, (&mean, &modulation), &windows)
        }
        Method::Oidn(oidn) => learned::denoise(own, (&mean, &modulation), oidn, simd)?,
    };
    coverage::filter_alpha(own, others, &mut denoised, simd);
    Ok(denoised)
}

#[cfg(test)]
mod tests;
