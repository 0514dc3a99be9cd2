//! Sampling of area lights: points on shapes and triangles, with the density of their direction.
//!
//! A shape is sampled in its local space, by solid angle where it supports that. A linear map M
//! takes the unit direction w to M w / |M w|, and scales a small solid angle around it by |det M| /
//! |M w|^3. The density in world space is the local one divided by this factor.

use super::LightSample;
use crate::{
    math::{Ray, Rgb, Transform, Vec2, Vec3, float::gamma},
    shape::{
        LocalSurface, Shape, ShapeHit, spherical,
        triangle::{self, TrianglePoint},
    },
};

/// A sampled point of an emitter.
#[derive(Clone, Copy, Debug)]
pub struct AreaSample {
    /// In world space.
    pub p: Vec3,
    /// Bound on the absolute error of each coordinate of `p`.
    pub p_error: Vec3,
    /// Unit geometric normal in world space, as authored.
    pub ng: Vec3,
    /// Density of the direction towards `p`, in sr^-1.
    pub pdf: f32,
}

impl AreaSample {
    /// The sample of a shape in world space.
    #[inline(always)]
    pub(super) fn in_world(p: Vec3, ng: Vec3, pdf: f32) -> Self {
        Self {
            p,
            p_error: p.abs() * gamma(4),
            ng,
            pdf,
        }
    }

    /// The height of `from` above the plane of the emitter: above 0 if `from` is in front.
    #[inline]
    pub fn front_cos(&self, from: Vec3) -> f32 {
        self.ng.dot(from - self.p)
    }

    /// The light that arrives at `from` with the radiance `li`.
    ///
    /// The distance is reduced by a bound of the rounding error, so that a shadow ray ends in front of the emitter.
    #[inline]
    pub fn light(&self, from: Vec3, li: Rgb) -> Option<LightSample> {
        let (wi, distance) = self.direction(from);
        (distance > 0.0).then_some(LightSample {
            wi,
            distance,
            li,
            pdf: Some(self.pdf),
        })
    }

    /// The direction and the distance of that light. The distance is 0 if rounding errors alone keep `from` from lying in the plane
    /// of the emitter, as they do for a point of a tilted emitter itself: no light arrives there.
    #[inline(always)]
    pub(super) fn direction(&self, from: Vec3) -> (Vec3, f32) {
        let reach = from.abs().max_element() + self.p.abs().max_element();
        let gap = self.ng.abs().dot(self.p_error) + reach * gamma(32);
        let height = self.front_cos(from);
        let side = if height < 0.0 { -gap } else { gap };
        let to = self.p + self.ng * side - from;
        let distance = to.length();
        (to / distance, if height.abs() > gap { distance } else { 0.0 })
    }
}

/// A point of `shape` as seen from `from` (world), and the same point in the shape's own space;
/// `None` if it is invisible or cannot be sampled.
#[inline]
pub fn sample_shape(shape: &Shape, transform: Option<&Transform>, from: Vec3, u: Vec2) -> Option<(AreaSample, Vec3)> {
    let from_local = transform.map_or(from, |t| t.point_to_local(from));
    let local = shape.sample(from_local, u)?;
    let mut sample = match transform {
        None => AreaSample::in_world(local.p, local.ng, local.pdf),
        Some(t) => {
            let to = local.p - from_local;
            let stretch = t.vector_to_world(to).length() / to.length();
            AreaSample {
                p: t.point_to_world(local.p),
                p_error: t.point_error_to_world(local.p, local.p.abs() * gamma(4)),
                ng: t.normal_to_world(local.ng).normalize(),
                pdf: local.pdf * (stretch * stretch * stretch) / t.volume(),
            }
        }
    };
    if let Some(flat) = shape.parallelogram() {
        sample.p_error += flat.plane_error(transform);
    }
    (sample.pdf > 0.0 && sample.pdf.is_finite()).then_some((sample, local.p))
}

/// The density of [`sample_shape`] for the unit direction `w`, in sr^-1. `hit` is the hit of the ray from `from` along `w` on
/// the shape.
#[inline]
pub fn pdf_shape(shape: &Shape, transform: Option<&Transform>, from: Vec3, w: Vec3, hit: &ShapeHit) -> f32 {
    let Some(t) = transform else {
        return shape.pdf(from, w, hit);
    };
    let ray = t.ray_to_local(&Ray::new(from, w));
    let length = ray.d.length();
    let pdf = shape.pdf(ray.o, ray.d, hit) / (length * length * length * t.volume());
    if pdf.is_finite() { pdf } else { 0.0 }
}

/// The surface of `shape` at its point `p`, as seen from `from`, both in the shape's own space.
pub fn surface_at(shape: &Shape, from: Vec3, p: Vec3) -> Option<LocalSurface> {
    /// The most intersections of a line with any shape.
    const MAX_HITS: usize = 6;
    let mut ray = Ray::new(from, p - from);
    let mut best: Option<ShapeHit> = None;
    for _ in 0..MAX_HITS {
        let Some(hit) = shape.intersect(&ray) else { break };
        if best.is_none_or(|b| (hit.t - 1.0).abs() < (b.t - 1.0).abs()) {
            best = Some(hit);
        }
        ray.tmin = hit.t;
    }
    best.map(|hit| shape.surface(&ray, &hit))
}

/// A point of the triangle as seen from `from`; `None` if it is seen edge-on or has no area.
#[inline]
pub fn sample_triangle(corners: [Vec3; 3], from: Vec3, u: Vec2) -> Option<AreaSample> {
    let (weights, pdf) = spherical::sample(corners, from, u);
    let TrianglePoint { p, p_error, ng } = triangle::surface_point(corners, weights.x, weights.y);
    (pdf > 0.0).then_some(AreaSample { p, p_error, ng, pdf })
}
