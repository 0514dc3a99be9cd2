//! The numbers of what is traced, and what a ray meets.

use std::num::NonZeroU32;

/// The number of a primitive: triangles first, then shapes, both in the order of [`Geometry`](super::Geometry)'s arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimId(NonZeroU32);

impl PrimId {
    /// The largest number there can be.
    pub const MAX: u32 = u32::MAX - 1;

    pub fn new(index: u32) -> Self {
        Self(NonZeroU32::new(index.wrapping_add(1)).expect("a primitive's number is below 2^32 - 1"))
    }

    /// The primitive whose number is one less, `None` for the largest there is.
    #[inline(always)]
    pub(crate) fn one_below(number: u32) -> Option<Self> {
        NonZeroU32::new(if number == u32::MAX { 0 } else { number }).map(Self)
    }

    pub fn index(self) -> u32 {
        self.0.get() - 1
    }
}

/// Which copy of an instanced mesh was hit; [`InstanceId::NONE`] for what is not instanced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InstanceId(pub u32);

impl InstanceId {
    pub const NONE: Self = Self(u32::MAX);
}

impl Hit {
    /// Whether this is the hit that counts of two: the nearer one; of two as near the one of the lower primitive; of
    /// two of one primitive that of the lower instance. An order that every accelerator keeps.
    #[inline(always)]
    pub fn comes_before(&self, other: &Self) -> bool {
        self.t < other.t || (self.t == other.t && (self.prim, self.instance) < (other.prim, other.instance))
    }
}

/// What a ray met first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// In lengths of the ray's direction.
    pub t: f32,
    pub u: f32,
    pub v: f32,
    pub prim: PrimId,
    pub instance: InstanceId,
}
