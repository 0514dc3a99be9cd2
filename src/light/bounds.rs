//! Bounds of a group of lights: position, orientation and power, and the importance for a point.
//!
//! Source: Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", HPG 2018, doi:10.1145/3233305.

use std::f32::consts::PI;

use crate::math::{Aabb, Sidedness, Vec3, trig};

/// Cosines this far below 0 still count as a little above, so that rounding never hides a light.
const MARGIN: f32 = 1e-3;

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
        // An axis whose surfaces shine both ways may as well point the other way.
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
        // Once more than rounding of the angles could take away.
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
    /// The intensity that it can reach along its axis, in W sr^-1, the channels' mean.
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

    /// The compact bounds for [`CompactLightBounds::importance`].
    pub fn compact(&self) -> CompactLightBounds {
        let half = (self.bounds.max - self.bounds.min) * 0.5;
        let center = self.bounds.min + half;
        // The middle is rounded.
        let radius = half.length() * (1.0 + 4.0 * f32::EPSILON) + center.abs().max_element() * f32::EPSILON;
        CompactLightBounds {
            center,
            radius: if half == Vec3::ZERO { 0.0 } else { radius },
            axis: self.directions.axis,
            power: self.power,
            cos_o: self.directions.cos_o,
            cos_e: self.directions.cos_e,
        }
    }
}

/// The bounding sphere and the orientation cone of a group of lights, as a node of the tree stores
/// them.
#[derive(Clone, Copy, Debug)]
pub struct CompactLightBounds {
    center: Vec3,
    radius: f32,
    axis: Vec3,
    power: f32,
    cos_o: f32,
    cos_e: f32,
}

impl CompactLightBounds {
    /// An estimate of the irradiance at `p` on a surface of unit normal `n` (zero: of any), in W
    /// m^-2, where no light is hidden. 0 only where the lights do not shine on that side of `p` at
    /// all.
    #[inline]
    pub fn importance(&self, p: Vec3, n: Vec3, sidedness: Sidedness) -> f32 {
        if self.power == 0.0 {
            return 0.0;
        }
        let to = self.center - p;
        let (d2, r2) = (to.length_squared(), self.radius * self.radius);
        let mut factor = 1.0;
        if d2 > r2 {
            let wi = to / d2.sqrt();
            // The angle that the ball is seen under.
            let sin2 = r2 / d2;
            let ball = Angle {
                cos: (1.0 - sin2).sqrt(),
                sin: sin2.sqrt(),
            };
            if self.cos_o > -1.0 {
                let cos = -self.axis.dot(wi);
                let cos = if sidedness == Sidedness::Both { cos.abs() } else { cos };
                let off = Angle::of_cos(cos).less(Angle::of_cos(self.cos_o)).less(ball);
                if off.cos < self.cos_e - MARGIN {
                    return 0.0;
                }
                factor = off.cos.max(MARGIN);
            }
            if n != Vec3::ZERO {
                let cos = Angle::of_cos(n.dot(wi)).less(ball).cos;
                if cos < -MARGIN {
                    return 0.0;
                }
                factor *= cos.max(MARGIN);
            }
        }
        let nearest = d2.max(r2);
        let importance = self.power * factor / nearest;
        if importance.is_finite() {
            importance
        } else {
            f32::MAX * 0.125
        }
    }
}

/// An angle from 0 to pi by its cosine and sine.
#[derive(Clone, Copy)]
struct Angle {
    cos: f32,
    sin: f32,
}

impl Angle {
    #[inline]
    fn of_cos(cos: f32) -> Self {
        Self {
            cos,
            sin: (1.0 - cos * cos).max(0.0).sqrt(),
        }
    }

    /// This one less the other, at least 0.
    #[inline]
    fn less(self, other: Self) -> Self {
        if self.cos >= other.cos {
            return Self { cos: 1.0, sin: 0.0 };
        }
        Self {
            cos: self.cos * other.cos + self.sin * other.sin,
            sin: self.sin * other.cos - self.cos * other.sin,
        }
    }
}
