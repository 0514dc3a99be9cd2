//! Axis-aligned boxes in double precision, for places far from the origin.

use glam::{DAffine3, DVec3};

use super::Aabb;

/// A closed axis-aligned box in double precision; empty when any `min` exceeds its `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DAabb {
    pub min: DVec3,
    pub max: DVec3,
}

impl DAabb {
    /// The box that holds nothing and is the neutral element of [`DAabb::union`].
    pub const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// The smallest box around `points`; [`DAabb::EMPTY`] for none.
    pub fn from_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |all, p| Self {
            min: all.min.min(p),
            max: all.max.max(p),
        })
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Whether every bound is a finite number and no `min` exceeds its `max`.
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }

    /// The middle of the box.
    pub fn center(&self) -> DVec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// The distance from the middle to a corner.
    pub fn half_diagonal(&self) -> f64 {
        0.5 * (self.max - self.min).length()
    }

    /// The distance from `p` to the box; 0 inside.
    pub fn distance(&self, p: DVec3) -> f64 {
        p.distance(p.clamp(self.min, self.max))
    }

    /// The box around this one after an affine map; empty for an empty box.
    pub fn transformed(&self, map: &DAffine3) -> Self {
        if self.min.cmpgt(self.max).any() {
            return Self::EMPTY;
        }
        let corner = |i: u32, axis: u32| if i >> axis & 1 == 0 { self.min } else { self.max };
        let corner = |i: u32| DVec3::new(corner(i, 0).x, corner(i, 1).y, corner(i, 2).z);
        Self::from_points((0..8).map(|i| map.transform_point3(corner(i))))
    }

    /// The box as seen from `origin`, in single precision.
    pub fn relative_to(&self, origin: DVec3) -> Aabb {
        Aabb {
            min: (self.min - origin).as_vec3(),
            max: (self.max - origin).as_vec3(),
        }
    }
}

impl From<Aabb> for DAabb {
    fn from(b: Aabb) -> Self {
        Self {
            min: b.min.as_dvec3(),
            max: b.max.as_dvec3(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_that_is_turned_by_a_quarter_has_its_sides_exchanged() {
        let long = DAabb::from_points([DVec3::ZERO, DVec3::new(4.0, 2.0, 1.0)]);
        let turned = long.transformed(&DAffine3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z, DVec3::X * 9.0));
        assert_eq!(
            turned,
            DAabb::from_points([DVec3::new(7.0, 0.0, 0.0), DVec3::new(9.0, 4.0, 1.0)])
        );
        assert!(!DAabb::EMPTY.transformed(&DAffine3::IDENTITY).is_finite());
    }

    #[test]
    fn the_distance_to_a_box_is_that_to_its_nearest_point() {
        let unit = DAabb::from_points([DVec3::ZERO, DVec3::ONE]);
        assert_eq!(unit.distance(DVec3::splat(0.5)), 0.0);
        assert_eq!(unit.distance(DVec3::new(4.0, 5.0, 0.5)), 5.0);
    }
}
