//! The surface of a point light that has a radius.

use std::f32::consts::PI;

use super::{
    LightSample,
    area::sample_shape,
    lamp::{Sight, sample_surface, see_surface},
};
use crate::{
    math::{Aabb, DVec3, Rgb, Vec2, Vec3},
    shape::{Shape, ShapeHit, sphere::SphereDesc},
    value::{Point, Positive, Problem},
};

/// A ball that shines outwards. Its radiance in a direction is such that it has the intensity of the
/// point light there, as seen from afar.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    pub(super) shape: Shape,
    /// The radiance by the intensity, in m^-2.
    per_intensity: f32,
    pub(super) sight: Sight,
}

impl Ball {
    pub(super) fn new(center: Point, radius: Positive, origin: DVec3, sight: Sight) -> Result<Self, Problem> {
        Ok(Self {
            shape: SphereDesc { center, radius }.compile(origin)?.into(),
            per_intensity: 1.0 / (PI * radius.0 * radius.0),
            sight,
        })
    }

    pub(super) fn bounds(&self) -> Aabb {
        self.shape.bounds()
    }

    /// The radiance at a cosine from the normal.
    #[inline]
    fn radiance(&self, cos: f32, intensity: Rgb) -> Rgb {
        if cos > 0.0 {
            intensity * self.per_intensity
        } else {
            Rgb::BLACK
        }
    }

    /// Samples the light at `from`, of the given intensity against the unit direction to it.
    #[inline]
    pub(super) fn sample(&self, from: Vec3, u: Vec2, intensity: impl Fn(Vec3) -> Rgb) -> Option<LightSample> {
        let radiance = |cos, wi| self.radiance(cos, intensity(wi));
        let (point, _) = sample_shape(&self.shape, None, from, u)?;
        sample_surface(&point, from, self.sight, radiance)
    }

    /// See [`LightKind::seen`](super::LightKind::seen).
    pub(super) fn seen(&self, from: Vec3, w: Vec3, hit: &ShapeHit, intensity: Rgb) -> (Rgb, f32) {
        see_surface(&self.shape, from, w, hit, |cos| self.radiance(cos, intensity))
    }
}
