//! Groups of lights as arrays, and their importance for a point.
//!
//! Source: Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", HPG 2018, doi:10.1145/3233305.

use crate::{
    light::bounds::LightBounds,
    math::{Sidedness, Vec3},
};

/// The number of groups in a node.
pub(super) const WIDTH: usize = 8;

/// Cosines down to this far below 0 count as positive, so that rounding never hides a light.
const MARGIN: f32 = 1e-3;

/// The bounding spheres and the orientation cones of `N` groups, as arrays.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct LightGroups<const N: usize> {
    center: [[f32; N]; 3],
    radius: [f32; N],
    /// In m^-1; infinite for a point.
    inverse_radius: [f32; N],
    axis: [[f32; N]; 3],
    /// The intensity in W sr^-1; 0 where there is no group.
    power: [f32; N],
    /// Cosine and sine of the largest angle between a normal and the axis.
    cos_o: [f32; N],
    sin_o: [f32; N],
    /// Cosine of the largest angle between a normal and the light, minus [`MARGIN`]; below -1 if the lights emit in all directions.
    cos_e: [f32; N],
    /// -1 if lights also emit against their normals, else 1.
    side: [f32; N],
}

/// Angles from 0 to pi by their cosines and sines.
#[derive(Clone, Copy)]
struct Angle {
    cos: f32,
    sin: f32,
}

impl Angle {
    #[inline(always)]
    fn of_cos(cos: f32) -> Self {
        Self {
            cos,
            sin: (1.0 - cos * cos).max(0.0).sqrt(),
        }
    }

    /// The difference to another angle, at least 0.
    #[inline(always)]
    fn less(self, other: Self) -> Self {
        let is_less = self.cos >= other.cos;
        let (cos, sin) = (
            self.cos * other.cos + self.sin * other.sin,
            self.sin * other.cos - self.cos * other.sin,
        );
        Self {
            cos: if is_less { 1.0 } else { cos },
            sin: if is_less { 0.0 } else { sin },
        }
    }
}

impl<const N: usize> LightGroups<N> {
    pub const NONE: Self = Self {
        center: [[0.0; N]; 3],
        radius: [0.0; N],
        inverse_radius: [f32::INFINITY; N],
        axis: [[0.0; N]; 3],
        power: [0.0; N],
        cos_o: [0.0; N],
        sin_o: [0.0; N],
        cos_e: [0.0; N],
        side: [1.0; N],
    };

    /// Sets the group at place `i`.
    pub fn set(&mut self, i: usize, group: &LightBounds) {
        let half = (group.bounds.max - group.bounds.min) * 0.5;
        let center = group.bounds.min + half;
        // Bounds the rounding error of the centre.
        let radius = half.length() * (1.0 + 4.0 * f32::EPSILON) + center.abs().max_element() * f32::EPSILON;
        let radius = if half == Vec3::ZERO { 0.0 } else { radius };
        let directions = group.directions;
        for axis in 0..3 {
            self.center[axis][i] = center[axis];
            self.axis[axis][i] = directions.axis[axis];
        }
        (self.radius[i], self.inverse_radius[i]) = (radius, 1.0 / radius);
        self.power[i] = group.power;
        let shines_all_ways = directions.cos_o <= -1.0;
        let open = Angle::of_cos(directions.cos_o);
        (self.cos_o[i], self.sin_o[i]) = (open.cos, open.sin);
        self.cos_e[i] = if shines_all_ways {
            // Then all directions count as along the axis.
            (self.cos_o[i], self.sin_o[i]) = (-2.0, 0.0);
            -2.0
        } else {
            directions.cos_e - MARGIN
        };
        self.side[i] = if directions.sidedness == Sidedness::Both {
            -1.0
        } else {
            1.0
        };
    }

    /// Estimates of the unoccluded irradiance at `p` on a surface of unit normal `n` (zero: of any), in W m^-2. 0 only if no light
    /// of the group reaches that side.
    #[inline(always)]
    pub fn importances(&self, p: Vec3, n: Vec3) -> [f32; N] {
        let mut importances = [0.0; N];
        for (i, importance) in importances.iter_mut().enumerate() {
            *importance = self.importance(i, p, n);
        }
        importances
    }

    /// The same of the group at place `i`.
    #[inline(always)]
    pub fn importance(&self, i: usize, p: Vec3, n: Vec3) -> f32 {
        let is_any = (n.x == 0.0) & (n.y == 0.0) & (n.z == 0.0);
        // Without a normal every light is at normal incidence.
        let least = if is_any { f32::NEG_INFINITY } else { -MARGIN };
        let (x, y, z) = (
            self.center[0][i] - p.x,
            self.center[1][i] - p.y,
            self.center[2][i] - p.z,
        );
        let d = (x * x + y * y + z * z).sqrt();
        let scale = 1.0 / d;
        // The angular radius of the bounding sphere.
        let sin = self.radius[i] * scale;
        let ball = Angle {
            cos: (1.0 - sin * sin).max(0.0).sqrt(),
            sin,
        };
        let out = -(self.axis[0][i] * x + self.axis[1][i] * y + self.axis[2][i] * z) * scale;
        let out = if self.side[i] < 0.0 { out.abs() } else { out };
        let open = Angle {
            cos: self.cos_o[i],
            sin: self.sin_o[i],
        };
        let off = Angle::of_cos(out).less(open).less(ball);
        let facing = (n.x * x + n.y * y + n.z * z) * scale;
        let facing = Angle::of_cos(facing).less(ball).cos;
        let shines = (off.cos >= self.cos_e[i]) & (facing >= least);
        let facing = if is_any { 1.0 } else { facing.max(MARGIN) };
        let factor = if shines { off.cos.max(MARGIN) * facing } else { 0.0 };
        // Inside of the bounding sphere all directions are possible.
        let is_outside = d > self.radius[i];
        let factor = if is_outside { factor } else { 1.0 };
        let nearest = if is_outside { scale } else { self.inverse_radius[i] };
        let brought = self.power[i] * factor * nearest * nearest;
        let bounded = if brought < f32::MAX {
            brought
        } else {
            f32::MAX * 0.03125
        };
        if self.power[i] > 0.0 { bounded } else { 0.0 }
    }
}
