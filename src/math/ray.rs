//! Rays.

use glam::Vec3;

/// The points `o + t d` with `tmin <= t <= tmax`. `d` need not be a unit vector; `t` counts its
/// lengths.
///
/// 32 bytes, an array of them is what an acceleration structure reads.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub o: Vec3,
    pub tmin: f32,
    pub d: Vec3,
    pub tmax: f32,
}

impl Ray {
    /// The absence of a ray; it hits nothing.
    pub const NONE: Self = Self {
        o: Vec3::ZERO,
        tmin: 0.0,
        d: Vec3::ZERO,
        tmax: 0.0,
    };

    /// Whether this is [`Ray::NONE`].
    pub fn is_none(&self) -> bool {
        self.d == Vec3::ZERO
    }

    /// The infinite ray from `o` along `d`.
    pub fn new(o: Vec3, d: Vec3) -> Self {
        Self {
            o,
            tmin: 0.0,
            d,
            tmax: f32::INFINITY,
        }
    }

    /// The segment from `o` to `o + tmax d`, such as a shadow ray.
    pub fn segment(o: Vec3, d: Vec3, tmax: f32) -> Self {
        Self { o, tmin: 0.0, d, tmax }
    }

    /// The point at `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.o + self.d * t
    }
}
