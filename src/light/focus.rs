//! The concentration of the light of a flat surface about its normal.
//!
//! A point within the beam sees little of the surface shine: only that part of it is sampled. A parallel beam comes from a single
//! point of the surface.

use std::f32::consts::FRAC_PI_2;

use super::{area::AreaSample, picture::Screen};
use crate::{
    math::{Vec2, Vec3},
    shape::rectangle::{Rectangle, SeenRectangle},
};

/// Below this spread a beam is parallel: single precision does not tell its directions apart.
const MIN_SPREAD: f32 = 1e-4;

/// The largest part of the surface that is sampled by itself.
const MAX_PART: f64 = 0.5;

/// The concentration of a flat light about its normal, as by the grid of a soft box, whose cells hide more of the surface the
/// more aslant it is seen. The power does not depend on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Focus {
    /// The tangent of the largest angle from the normal; 0 for a parallel beam.
    tan: f32,
    /// The factor that keeps the power.
    scale: f32,
    screen: Screen,
}

impl Focus {
    /// The focus of a surface that fills `screen`; `None` for a spread of 1, which concentrates nothing.
    pub fn new(spread: f32, screen: Screen) -> Option<Self> {
        let h = f64::from(spread * FRAC_PI_2);
        let tan = libm::tan(h);
        // The power is 2 pi times the integral of (tan h - tan a) cos a sin a over the angle a: pi (tan h - h).
        let rest = if h < 0.02 {
            h * h * h * (1.0 / 3.0 + h * h * 2.0 / 15.0)
        } else {
            tan - h
        };
        let (tan, scale) = if spread < MIN_SPREAD {
            (0.0, 0.0)
        } else {
            (tan as f32, (1.0 / rest) as f32)
        };
        (spread < 1.0).then_some(Self { tan, scale, screen })
    }

    pub fn is_parallel(&self) -> bool {
        self.tan == 0.0
    }

    /// The cosine of the largest angle from the normal.
    pub fn widest(&self) -> f32 {
        1.0 / (1.0 + self.tan * self.tan).sqrt()
    }

    /// The radiance in the unit direction `w`, in parts of that of an unfocused surface.
    #[inline]
    pub fn factor(&self, w: Vec3) -> f32 {
        let normal = self.screen.normal;
        // A cosine near 1 does not tell a small angle.
        let tan = normal.cross(w).length() / normal.dot(w).abs();
        (self.tan - tan).max(0.0) * self.scale
    }

    /// The point of the surface whose parallel beam meets `from`.
    #[inline]
    pub fn foot(&self, from: Vec3) -> Option<AreaSample> {
        let st = self.screen.st(from);
        let is_part = st.cmpge(Vec2::ZERO).all() && st.cmple(Vec2::ONE).all() && self.screen.contains(st);
        is_part.then(|| AreaSample::in_world(self.screen.point(st), self.screen.normal, 1.0))
    }

    /// The rectangle that holds all that shines at `from`: the outer `None` if nothing does, the inner one if that is most of the
    /// surface.
    #[inline]
    fn part(&self, from: Vec3) -> Option<Option<SeenRectangle>> {
        let Screen {
            corner, sides, normal, ..
        } = self.screen;
        let (corner, from, normal) = (corner.as_dvec3(), from.as_dvec3(), normal.as_dvec3());
        let to_foot = from - corner;
        let radius = to_foot.dot(normal).abs() * f64::from(self.tan);
        let mut part = Rectangle {
            corner,
            edges: sides.map(|side| side.as_dvec3()),
            lengths: [0.0; 2],
            normal,
        };
        let mut share = 1.0;
        for (edge, to_length) in part.edges.iter_mut().zip(&mut part.lengths) {
            let length = edge.length();
            let (unit, foot) = (*edge / length, to_foot.dot(*edge) / length);
            let (start, end) = ((foot - radius).max(0.0), (foot + radius).min(length));
            if start >= end {
                return None;
            }
            part.corner += unit * start;
            (*edge, *to_length) = (unit * (end - start), end - start);
            share *= (end - start) / length;
        }
        Some((share <= MAX_PART).then(|| part.seen_from(from)))
    }

    /// Samples a point that shines at `from`; the outer `None` if the whole surface is to be
    /// sampled, the inner one if there is none.
    #[inline]
    pub fn sample(&self, from: Vec3, u: Vec2) -> Option<Option<AreaSample>> {
        let Some(part) = self.part(from) else {
            return Some(None);
        };
        let seen = part?;
        let p = seen.sample(u.x.into(), u.y.into());
        let pdf = seen.pdf(p);
        let p = p.as_vec3();
        let is_part = pdf > 0.0 && self.screen.contains(self.screen.st(p));
        Some(is_part.then(|| AreaSample::in_world(p, self.screen.normal, pdf)))
    }

    /// The density of [`Focus::sample`] for a point, in sr^-1; `None` if the whole surface is to be sampled.
    #[inline]
    pub fn pdf(&self, from: Vec3, p: Vec3) -> Option<f32> {
        let Some(part) = self.part(from) else {
            return Some(0.0);
        };
        part.map(|seen| seen.pdf(p.as_dvec3()))
    }
}
