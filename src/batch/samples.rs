//! The samples of each pixel, from the scene file and the request.

use super::Request;
use crate::{
    describe::{AdaptiveDesc, SceneDesc},
    error::Error,
    math::exponential,
    render::{AdaptiveSampling, SampleBudget},
};

/// The samples of each pixel of a job whose pictures have this exposure, in stops.
///
/// # Errors
/// A minimum of samples is requested without a noise threshold.
pub(super) fn budget(desc: &SceneDesc, request: &Request, exposure: f32) -> Result<SampleBudget, Error> {
    let described = desc.render.samples.get_ref();
    let max = request.samples.unwrap_or_else(|| described.max());
    let own = described.adaptive();
    let threshold = request.noise_threshold.or(own.map(|own| own.threshold.0));
    if threshold.is_none() && request.min_samples.is_some() {
        let message = "--min-samples: the number of samples is fixed (--noise-threshold makes it adaptive)";
        return Err(Error::Usage(message.to_owned()));
    }
    let min = request.min_samples.or(own.map(|own| own.min.0));
    let adaptive = threshold.map(|threshold| AdaptiveSampling {
        min: min.unwrap_or(AdaptiveDesc::MIN).min(max),
        threshold,
        gain: exponential::pow(2.0, exposure),
    });
    Ok(SampleBudget {
        adaptive,
        time: request.time_limit,
        ..SampleBudget::fixed(max)
    })
}
