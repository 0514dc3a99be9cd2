//! The metadata of a frame.

use super::{Attribute, display::DisplayTransform};
use crate::{
    integrator::{Integrator, LimitValue},
    math::WorkingSpace,
    render::Settings,
};

/// The metadata of a frame, the same for every format.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameMetadata {
    /// The number of the frame.
    pub frame: i32,
    /// The samples of each pixel, with adaptive sampling the most.
    pub samples: u32,
    pub seed: u32,
    /// The name of the sampler.
    pub sampler: &'static str,
    /// The primaries of its light.
    pub working_space: WorkingSpace,
    /// The display transform of 8-bit formats.
    pub view: DisplayTransform,
    /// The exposure of 8-bit formats, in stops.
    pub exposure: f32,
    /// Frames per second as a fraction, if known.
    pub fps: Option<(i32, u32)>,
    /// More attributes. They replace the renderer's own attributes of the same names.
    pub attributes: Vec<Attribute>,
}

impl FrameMetadata {
    /// The metadata of a frame that `integrator` renders with `settings`.
    pub fn new(frame: i32, settings: &Settings, integrator: &dyn Integrator) -> Self {
        Self {
            frame,
            samples: settings.pixel_samples(),
            seed: settings.seed,
            sampler: settings.sampler.name(),
            working_space: WorkingSpace::default(),
            view: DisplayTransform::default(),
            exposure: 0.0,
            fps: None,
            attributes: [limits(integrator), adaptive_sampling(settings)].concat(),
        }
    }
}

#[cfg(test)]
impl FrameMetadata {
    /// The metadata of a frame of tests.
    pub(super) fn example(frame: i32, attributes: Vec<Attribute>) -> Self {
        Self {
            frame,
            samples: 64,
            seed: 5,
            sampler: "sobol",
            view: DisplayTransform::Srgb,
            working_space: WorkingSpace::default(),
            exposure: 0.0,
            fps: None,
            attributes,
        }
    }
}

/// The rule of adaptive sampling.
fn adaptive_sampling(settings: &Settings) -> Vec<Attribute> {
    let Some(rule) = settings.samples.adaptive else {
        return Vec::new();
    };
    vec![
        Attribute::new("batch-render/minSamples", i32::try_from(rule.min).unwrap_or(i32::MAX)),
        Attribute::new("batch-render/noiseThreshold", rule.threshold),
    ]
}

/// The limits of the integrator.
fn limits(integrator: &dyn Integrator) -> Vec<Attribute> {
    let attribute = |name: &str, value: LimitValue| {
        let name = format!("batch-render/{name}");
        match value {
            LimitValue::Count(n) => Attribute::new(name, i32::try_from(n).unwrap_or(i32::MAX)),
            LimitValue::Radiance(l) => Attribute::new(name, l),
        }
    };
    let limits = integrator.limits().into_iter();
    limits.map(|limit| attribute(limit.name, limit.value)).collect()
}
