//! What is seen where a ray meets nothing.

use std::sync::Arc;

use crate::{
    light::environment::Environment,
    math::{Rgb, Vec3},
};

/// What is seen where a ray meets nothing, and by whom.
#[derive(Clone, Debug)]
pub struct Background {
    pub radiance: BackgroundRadiance,
    /// Whether camera rays see it; where they do not, RGB and A are 0.
    pub visible: bool,
}

/// What lies in each direction.
#[derive(Clone, Debug)]
pub enum BackgroundRadiance {
    /// One radiance everywhere, in W m^-2 sr^-1. No light is asked for it: surfaces know better where to look.
    Color(Rgb),
    Environment(Arc<Environment>),
}

impl Background {
    /// One radiance everywhere, in W m^-2 sr^-1, seen by all.
    pub fn new(radiance: Rgb) -> Self {
        Self {
            radiance: BackgroundRadiance::Color(radiance),
            visible: true,
        }
    }

    /// A picture of all directions, seen by all.
    pub fn environment(environment: Environment) -> Self {
        Self {
            radiance: BackgroundRadiance::environment(environment),
            visible: true,
        }
    }
}

impl BackgroundRadiance {
    pub fn environment(environment: Environment) -> Self {
        Self::Environment(Arc::new(environment))
    }

    /// What arrives from the unit direction `w`, in W m^-2 sr^-1.
    #[inline]
    pub fn radiance(&self, w: Vec3) -> Rgb {
        match self {
            Self::Color(color) => *color,
            Self::Environment(environment) => environment.radiance(w),
        }
    }

    /// Whether light is asked for by direction.
    pub fn is_sampled(&self) -> bool {
        match self {
            Self::Color(_) => false,
            Self::Environment(environment) => environment.is_sampled(),
        }
    }
}
