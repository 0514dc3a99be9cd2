//! The lights of a scene, and which of them to ask.

use super::LightId;
use crate::{
    light::{Light, LightSample},
    math::{Vec2, Vec3},
};

/// A place that light is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    pub p: Vec3,
    /// Unit shading normal; zero where light counts from all sides.
    pub n: Vec3,
}

/// A light that was chosen for a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    pub light: LightId,
    /// The probability of the choice.
    pub pmf: f32,
}

/// All lights.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    all: Vec<Light>,
}

impl Lights {
    pub fn new(all: Vec<Light>) -> Self {
        Self { all }
    }

    pub fn all(&self) -> &[Light] {
        &self.all
    }

    /// A light for the place `at`, by a uniform number in `[0, 1)`; `None` where none can matter.
    pub fn choose(&self, _at: &Receiver, u: f32) -> Option<Choice> {
        let count = self.all.len();
        let index = ((u * count as f32) as usize).min(count.checked_sub(1)?);
        Some(Choice {
            light: LightId(index as u32),
            pmf: 1.0 / count as f32,
        })
    }

    /// See [`crate::light::LightKind::sample`].
    pub fn sample(&self, light: LightId, from: Vec3, u: Vec2) -> Option<LightSample> {
        self.all[light.0 as usize].sample(from, u)
    }
}
