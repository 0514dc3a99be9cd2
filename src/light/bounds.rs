//! Bounds of a group of lights: position, orientation and power.
//!
//! Source: Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", HPG 2018, doi:10.1145/3233305.

use std::f32::consts::PI;

use crate::math::{Aabb, Sidedness, Vec3, trig};

/// The orientation cone of lights: their normals are within `cos_o` of the axis, and they emit
/// within `cos_e` of their normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientationCone {
    /// Unit.
    pub axis: Vec3,
    /// Cosine of the largest angle between a normal and the axis.
    pub cos_o: f32,
    /// Cosine of the largest angle between a normal and the light.
    pub cos_e: f32,
    pub sidedness: Sidedness,
}

impl OrientationCone {
    /// All of them.
    pub const ALL: Self = Self {
        axis: Vec3::Y,
        cos_o: -1.0,
        cos_e: 0.0,
        sidedness: Sidedness::Front,
    };

    /// A flat surface.
    pub fn flat(normal: Vec3, sidedness: Sidedness) -> Self {
        Self {
            axis: normal,
            cos_o: 1.0,
            cos_e: 0.0,
            sidedness,
        }
    }

    /// The smallest cone that contains both.
    pub fn union(&self, other: &Self) -> Self {
        let sidedness = if self.sidedness == Sidedness::Both || other.sidedness == Sidedness::Both {
            Sidedness::Both
        } else {
            Sidedness::Front
        };
        let cos_e = self.cos_e.min(other.cos_e);
        let (a, b) = if self.cos_o <= other.cos_o {
            (self, other)
        } else {
            (other, self)
        };
        // The axis of two-sided emitters has no direction.
        let flips = b.sidedness == Sidedness::Both && a.axis.dot(b.axis) < 0.0;
        let b_axis = if flips { -b.axis } else { b.axis };
        let between = angle(a.axis, b_axis);
        let (wide, narrow) = (trig::acos(a.cos_o), trig::acos(b.cos_o));
        if (between + narrow).min(PI) <= wide {
            return Self { sidedness, cos_e, ..*a };
        }
        let half = (wide + between + narrow) * 0.5;
        let normal = a.axis.cross(b_axis).try_normalize();
        let (Some(normal), true) = (normal, half < PI) else {
            return Self {
                axis: a.axis,
                cos_o: -1.0,
                cos_e,
                sidedness,
            };
        };
        // The axis turns away from the wider cone's.
        let (sin, cos) = trig::sin_cos(half - wide);
        let axis = (a.axis * cos + normal.cross(a.axis) * sin).normalize_or(a.axis);
        // The cone is widened by the rounding error of the angles.
        let cos_o = (trig::cos(half) - 1e-5).max(-1.0);
        Self {
            axis,
            cos_o,
            cos_e,
            sidedness,
        }
    }

    /// The solid angle measure of the directions, for the cost of a split: the integral over the cone
    /// of normals, and a cosine beyond.
    pub fn measure(&self) -> f32 {
        let o = trig::acos(self.cos_o.clamp(-1.0, 1.0));
        let w = (o + trig::acos(self.cos_e.clamp(-1.0, 1.0))).min(PI);
        let (sin_o, cos_o) = trig::sin_cos(o);
        2.0 * PI * (1.0 - cos_o) + PI * 0.5 * (2.0 * w * sin_o - trig::cos(o - 2.0 * w) - 2.0 * o * sin_o + cos_o)
    }
}

/// The angle between unit vectors, exact for small ones too.
fn angle(a: Vec3, b: Vec3) -> f32 {
    2.0 * trig::atan2((a - b).length(), (a + b).length())
}

/// The bounds of one light or of a group of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBounds {
    pub bounds: Aabb,
    pub directions: OrientationCone,
    /// The largest intensity along its axis, in W sr^-1, as a mean of the channels.
    pub power: f32,
}

impl LightBounds {
    pub fn union(&self, other: &Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            directions: self.directions.union(&other.directions),
            power: self.power + other.power,
        }
    }
}
