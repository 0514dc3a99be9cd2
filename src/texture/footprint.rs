//! The footprints of rays in the texels of pictures.

use super::StTransform;
use crate::math::{Vec2, exponential};

/// Pieces that a long footprint is taken apart into, at most.
pub const MAX_PROBES: u32 = 8;

/// The footprint of a look-up in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Places along the long axis.
    pub probes: u32,
    /// In s and t.
    pub long_axis: Vec2,
    /// The width across the long axis, in texels, at least 1.
    pub width: f32,
}

impl Footprint {
    /// The level: 0 for the picture itself, 1 for the copy of half its size, and between.
    pub fn level(&self) -> f32 {
        exponential::log2(self.width)
    }

    /// The footprint of the ellipse with these axes (s and t, from end to end) on a picture of `size` texels, and its level.
    pub fn with_level(axes: [Vec2; 2], size: Vec2) -> (Self, f32) {
        let footprint = Self::of(axes, size, MAX_PROBES);
        (footprint, footprint.level())
    }

    /// The footprint of the ellipse with these axes (s and t, from end to end) on a picture of `size` texels, in at most
    /// `max_probes` places.
    pub fn of([a, b]: [Vec2; 2], size: Vec2, max_probes: u32) -> Self {
        let (in_a, in_b) = (a * size, b * size);
        let (long, long_axis) = if in_a.length_squared() >= in_b.length_squared() {
            (in_a.length(), a)
        } else {
            (in_b.length(), b)
        };
        // Of parallelograms too: the area over the length.
        let short = if long > 0.0 {
            in_a.perp_dot(in_b).abs() / long
        } else {
            0.0
        };
        let width = short.max(long / max_probes as f32).max(1.0);
        if !(width.is_finite() && long_axis.is_finite()) {
            // Wider than any picture.
            return Self {
                probes: 1,
                long_axis: Vec2::ZERO,
                width: f32::MAX,
            };
        }
        Self {
            // To the nearest number; the sum is exact enough below 64.
            probes: ((long / width + 0.5) as u32).clamp(1, max_probes),
            long_axis,
            width,
        }
    }
}

/// The footprint at a point in the texels of all pictures of a size that lie on `uv` as it is. The pictures of
/// a material mostly have one size.
#[derive(Clone, Copy, Debug)]
pub struct SharedFootprint {
    /// The size in texels; zero for none.
    size: Vec2,
    footprint: Footprint,
    level: f32,
}

impl SharedFootprint {
    /// That of no picture.
    pub const NONE: Self = Self {
        size: Vec2::ZERO,
        footprint: Footprint {
            probes: 1,
            long_axis: Vec2::ZERO,
            width: 1.0,
        },
        level: 0.0,
    };

    /// The footprint with these axes in `uv`, from end to end, on pictures of `size` texels.
    pub fn new(axes: [Vec2; 2], size: Vec2) -> Self {
        // The same operations as for a texture.
        let [a, b] = axes.map(|d| StTransform::IDENTITY.vector(d));
        let (footprint, level) = Footprint::with_level([a, b], size);
        Self { size, footprint, level }
    }

    /// The footprint on pictures of `size` texels and its level, if it is known.
    #[inline(always)]
    pub fn on(&self, size: Vec2) -> Option<(Footprint, f32)> {
        (self.size == size).then_some((self.footprint, self.level))
    }
}
