//! Axis-aligned boxes.

use glam::Vec3;

/// A closed axis-aligned box; empty when any `min` exceeds its `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    pub min: Vec3,
    pub max: Vec3,
}

impl Default for Aabb {
    /// [`Aabb::EMPTY`].
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Aabb {
    /// The box that holds nothing and is the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    /// The box of a shape without bounds, such as a plane.
    pub const UNBOUNDED: Self = Self {
        min: Vec3::NEG_INFINITY,
        max: Vec3::INFINITY,
    };

    /// The smallest box around `points`; [`Aabb::EMPTY`] for none.
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::extended)
    }

    /// This box grown to hold `p`.
    pub fn extended(self, p: Vec3) -> Self {
        Self {
            min: self.min.min(p),
            max: self.max.max(p),
        }
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The box that both boxes share.
    pub fn intersection(self, other: Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }

    /// Whether every bound is a finite number and no `min` exceeds its `max`.
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }

    /// Whether it holds no point at all.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// The middle of the box.
    pub fn center(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// The edge lengths.
    pub fn extent(&self) -> Vec3 {
        self.max - self.min
    }

    /// Half the surface, in m^2.
    pub fn half_area(&self) -> f32 {
        let e = self.extent();
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    /// Corner `i` of 8; bit k of `i` picks the maximum on axis k.
    pub fn corner(&self, i: usize) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|axis| {
            if i >> axis & 1 == 1 {
                self.max[axis]
            } else {
                self.min[axis]
            }
        }))
    }

    /// The box grown on every side by `ulps` units in the last place of its largest coordinate, so
    /// that a box test with rounding never misses what the box holds.
    pub fn padded(&self, ulps: f32) -> Self {
        let pad = self.min.abs().max(self.max.abs()) * (ulps * f32::EPSILON);
        Self {
            min: self.min - pad,
            max: self.max + pad,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn union_with_empty_is_the_identity() {
        let b = Aabb::from_points([Vec3::ZERO, Vec3::new(1.0, -2.0, 3.0)]);
        assert_eq!(b.union(Aabb::EMPTY), b);
        assert!(Aabb::EMPTY.is_empty() && !b.is_empty() && b.is_finite());
        assert_eq!(b.half_area(), 2.0 + 6.0 + 3.0);
    }
}
