//! The background: the radiance of rays that hit nothing.

use std::sync::Arc;

use crate::{
    light::{
        LightSample,
        environment::{Environment, EnvironmentLight},
        gradient::Gradient,
    },
    math::{DMat3, Dispatch, Rgb, Vec2, Vec3},
};

/// The background of a scene.
#[derive(Clone, Debug)]
pub struct Background {
    pub radiance: BackgroundRadiance,
    /// Whether the camera sees it; otherwise its pixels have RGB and alpha 0.
    pub visible: bool,
    /// The radiance that the camera sees in place of the light, in W m^-2 sr^-1; it lights nothing.
    pub backdrop: Option<Rgb>,
}

/// The radiance of the background in each direction.
#[derive(Clone, Debug)]
pub enum BackgroundRadiance {
    /// A constant radiance, in W m^-2 sr^-1. It is not sampled as a light, because BSDF sampling is
    /// better.
    Color(Rgb),
    /// Not sampled either.
    Gradient(Gradient),
    Environment(Arc<Environment>),
}

impl Background {
    /// A constant radiance, in W m^-2 sr^-1, visible to the camera.
    pub fn new(radiance: Rgb) -> Self {
        Self {
            radiance: BackgroundRadiance::Color(radiance),
            visible: true,
            backdrop: None,
        }
    }

    /// An environment map, visible to the camera.
    pub fn environment(environment: Environment) -> Self {
        Self {
            radiance: BackgroundRadiance::environment(environment),
            visible: true,
            backdrop: None,
        }
    }
}

impl BackgroundRadiance {
    pub fn environment(environment: Environment) -> Self {
        Self::Environment(Arc::new(environment))
    }

    /// The same with this rotation of its environment map, if it has one. It shares the texels.
    pub fn rotated(&self, world_from_map: DMat3) -> Self {
        match self {
            Self::Color(_) | Self::Gradient(_) => self.clone(),
            Self::Environment(environment) => Self::environment(environment.rotated(world_from_map)),
        }
    }

    /// The address of its environment map, to tell whether others have the same one.
    #[cfg(test)]
    pub(crate) fn address(&self) -> Option<*const Rgb> {
        match self {
            Self::Color(_) | Self::Gradient(_) => None,
            Self::Environment(environment) => Some(environment.texels_address()),
        }
    }

    /// Whether it is known to be black in all directions.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Color(color) => color.is_black(),
            Self::Gradient(gradient) => gradient.is_black(),
            Self::Environment(_) => false,
        }
    }

    /// The radiance from the unit direction `w`, in W m^-2 sr^-1.
    #[inline]
    pub fn radiance(&self, w: Vec3) -> Rgb {
        match self {
            Self::Color(color) => *color,
            Self::Gradient(gradient) => gradient.radiance(w),
            Self::Environment(environment) => environment.radiance(w),
        }
    }

    /// Writes the light from each of these unit directions to `to`, in place of its contents.
    pub fn look_up(&self, on: impl Dispatch, directions: impl Iterator<Item = Vec3>, to: &mut Vec<EnvironmentLight>) {
        to.clear();
        match self {
            Self::Color(radiance) => to.extend(directions.map(|_| EnvironmentLight {
                radiance: *radiance,
                pdf: 0.0,
            })),
            Self::Gradient(gradient) => to.extend(directions.map(|w| EnvironmentLight {
                radiance: gradient.radiance(w),
                pdf: 0.0,
            })),
            Self::Environment(environment) => environment.look_up(on, directions, to),
        }
    }

    /// Samples its light by two uniform numbers in `[0, 1)`; `None` where it is not sampled.
    #[inline]
    pub fn sample(&self, on: impl Dispatch, u: Vec2) -> Option<LightSample> {
        match self {
            Self::Color(_) | Self::Gradient(_) => None,
            Self::Environment(environment) => environment.sample(on, u),
        }
    }

    /// The density of [`Self::sample`] to choose the unit direction `w`, in sr^-1.
    #[inline]
    pub fn pdf(&self, w: Vec3) -> f32 {
        match self {
            Self::Color(_) | Self::Gradient(_) => 0.0,
            Self::Environment(environment) => environment.pdf(w),
        }
    }

    /// Calls `to` with the index of each of these pairs of uniform numbers and the light sample for it.
    pub fn sample_all(&self, on: impl Dispatch, numbers: &[Vec2], to: impl FnMut(usize, Option<LightSample>)) {
        if let Self::Environment(environment) = self {
            environment.sample_all(on, numbers, to);
        }
    }

    /// Whether it is sampled as a light.
    pub fn is_sampled(&self) -> bool {
        match self {
            Self::Color(_) | Self::Gradient(_) => false,
            Self::Environment(environment) => environment.is_sampled(),
        }
    }
}
