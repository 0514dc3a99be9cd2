//! Ids of primitives and instances, and hits.

use std::num::NonZeroU32;

/// The id of a primitive: triangles first, then shapes, both in the order of
/// [`Geometry`](super::Geometry)'s arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimId(NonZeroU32);

impl PrimId {
    /// The largest id.
    pub const MAX: u32 = u32::MAX - 1;

    #[inline]
    pub fn new(index: u32) -> Self {
        Self(NonZeroU32::new(index.wrapping_add(1)).expect("a primitive's number is below 2^32 - 1"))
    }

    /// Returns the key of one of the primitive's triangles, by which kernels order hits that are equally near. A primitive has
    /// one triangle, 0, or those of a parallelogram, 0 and 1.
    #[inline(always)]
    pub(crate) fn key(self, triangle: u32) -> u32 {
        2 * self.index() + triangle + 1
    }

    /// Returns the primitive with this key, or `None` if it is `u32::MAX`.
    #[inline(always)]
    pub(crate) fn of_key(key: u32) -> Option<Self> {
        NonZeroU32::new(key.wrapping_add(1) >> 1).map(Self)
    }

    #[inline]
    pub fn index(self) -> u32 {
        self.0.get() - 1
    }
}

/// The id of an instance; [`InstanceId::NONE`] for primitives that are not instanced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InstanceId(pub u32);

impl InstanceId {
    pub const NONE: Self = Self(u32::MAX);
}

impl Hit {
    /// Returns whether this hit takes precedence over the other one: it is nearer, or equally near
    /// with a lower primitive id, or on the same primitive with a lower instance id. All
    /// accelerators use this order.
    #[inline(always)]
    pub fn comes_before(&self, other: &Self) -> bool {
        self.t < other.t || (self.t == other.t && (self.prim, self.instance) < (other.prim, other.instance))
    }
}

/// A ray's hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The ray parameter, in lengths of the ray's direction.
    pub t: f32,
    pub u: f32,
    pub v: f32,
    pub prim: PrimId,
    pub instance: InstanceId,
}
