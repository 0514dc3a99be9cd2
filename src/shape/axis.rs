//! Coordinates around an axis, for disks, cylinders and cones.

use std::f64::consts::TAU;

use crate::math::{DVec3, Vec3, trig};

/// An axis through the local origin, a unit vector in double precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis(pub DVec3);

impl Axis {
    /// Along `direction`, which has a length.
    pub fn new(direction: Vec3) -> Self {
        Self(direction.as_dvec3().normalize_or(DVec3::Y))
    }

    /// `v` without its part along the axis.
    #[inline(always)]
    pub fn across(self, v: DVec3) -> DVec3 {
        v - self.0 * v.dot(self.0)
    }

    /// The directions at a quarter and no turn, of Duff et al. as [`Frame`](crate::math::Frame) has
    /// them; the second is mirrored so that +y turns from +x towards +z.
    #[inline(always)]
    fn frame(self) -> (DVec3, DVec3) {
        let n = self.0;
        let sign = 1.0_f64.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        (
            DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            -DVec3::new(b, sign + n.y * n.y * a, -n.y),
        )
    }

    /// The unit vector across the axis after `turn` of a whole turn.
    #[inline(always)]
    pub fn ring(self, turn: f64) -> DVec3 {
        let (x, y) = self.frame();
        let (sin, cos) = trig::sin_cos_turn(turn);
        x * cos + y * sin
    }

    /// The part of a turn in `[0, 1)` at which `e` stands; the inverse of [`Axis::ring`].
    pub fn turn(self, e: DVec3) -> f32 {
        let (x, y) = self.frame();
        whole_turn(libm::atan2(e.dot(y), e.dot(x)))
    }

    /// The direction in which the unit vector `e` across the axis turns.
    pub fn tangent(self, e: DVec3) -> DVec3 {
        e.cross(self.0)
    }

    /// The unit vector from the axis towards `p`, and the distance; any direction for a point on
    /// the axis.
    pub fn outwards(self, p: DVec3) -> (DVec3, f64) {
        let e = self.across(p);
        let rho = e.length();
        e.try_normalize().map_or((self.frame().0, 0.0), |e| (e, rho))
    }

    /// Half the edges of the box around a circle of `radius` about the axis.
    pub fn circle_extent(self, radius: f64) -> DVec3 {
        let w = self.0;
        DVec3::from_array([w.x, w.y, w.z].map(|w| radius * (1.0 - w * w).max(0.0).sqrt()))
    }
}

/// An angle in radians as a part of a turn in `[0, 1)`.
pub(super) fn whole_turn(angle: f64) -> f32 {
    let turn = (angle / TAU) as f32;
    let turn = if turn < 0.0 { turn + 1.0 } else { turn };
    if turn < 1.0 { turn } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_turn_about_y_from_x_towards_z() {
        let axis = Axis::new(Vec3::Y);
        assert!((axis.ring(0.0) - DVec3::X).length() < 1e-15);
        assert!((axis.ring(0.25) - DVec3::Z).length() < 1e-15);
        assert!((axis.tangent(DVec3::X) - DVec3::Z).length() < 1e-15);
    }

    #[test]
    fn turns_invert_rings_about_any_axis() {
        for w in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::Z, Vec3::new(0.3, -2.0, 0.7)] {
            let axis = Axis::new(w);
            for turn in [0.0, 0.125, 0.3, 0.5, 0.75, 0.999] {
                let e = axis.ring(turn);
                assert!(e.dot(axis.0).abs() < 1e-15 && (e.length() - 1.0).abs() < 1e-15);
                assert!((f64::from(axis.turn(e * 3.0)) - turn).abs() < 1e-7);
                let ahead = axis.ring(turn + 1e-6) - e;
                assert!((ahead.normalize() - axis.tangent(e)).length() < 1e-5);
            }
        }
    }
}
