//! A node of the light tree: the bounds of its lights and how many there are.

use crate::{
    light::bounds::{CompactLightBounds, LightBounds},
    math::{Sidedness, Vec3},
};

/// The leaf of a light that is in no leaf.
pub(super) const NO_LEAF: u32 = u32::MAX;

/// The bit of [`LightNode::leaves`] that says that lights shine against their normals too.
const BOTH_SIDES: u32 = 1 << 31;

#[derive(Clone, Copy, Debug)]
pub(super) struct LightNode {
    bounds: CompactLightBounds,
    /// The number of leaves below, and [`BOTH_SIDES`].
    leaves: u32,
}

impl LightNode {
    pub fn new(bounds: &LightBounds, leaves: u32) -> Self {
        let both = if bounds.directions.sidedness == Sidedness::Both {
            BOTH_SIDES
        } else {
            0
        };
        Self {
            bounds: bounds.compact(),
            leaves: leaves | both,
        }
    }

    #[inline]
    pub fn leaves(&self) -> u32 {
        self.leaves & !BOTH_SIDES
    }

    #[inline]
    pub fn importance(&self, p: Vec3, n: Vec3) -> f64 {
        let sidedness = if self.leaves & BOTH_SIDES != 0 {
            Sidedness::Both
        } else {
            Sidedness::Front
        };
        f64::from(self.bounds.importance(p, n, sidedness))
    }
}
