//! Branch-free intersection attempts, which are vectorized over many rays.

use super::ShapeHit;

/// The known facts about a ray and a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attempt {
    /// The hit, if the ray hits the shape.
    pub hit: ShapeHit,
    /// [`Attempt::MISSES`], [`Attempt::MEETS`] or [`Attempt::UNKNOWN`]; a number, for vectors of
    /// them.
    pub answer: u32,
}

impl Attempt {
    pub const MISSES: u32 = 0;
    pub const MEETS: u32 = 1;
    /// [`ShapeKind::intersect`](super::ShapeKind::intersect) has to be asked.
    pub const UNKNOWN: u32 = 2;

    /// Nothing is known.
    pub const NOTHING: Self = Self {
        hit: ShapeHit { t: 0.0, u: 0.0, v: 0.0 },
        answer: Self::UNKNOWN,
    };
}
