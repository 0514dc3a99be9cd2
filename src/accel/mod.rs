//! Acceleration structures: boxes in, hits out.
//!
//! Rays come in batches, because that is what makes them fast; nothing here takes one ray at a time. Every accelerator
//! gives the same bits: a hit's `t`, `u` and `v` come from the primitive's one scalar routine (or from operations in
//! the same order), of two hits at the same `t` the primitive with the lower number wins, and a box is passed over
//! only when it lies strictly farther than the nearest hit so far.

use std::{num::NonZeroU32, sync::Arc};

use crate::math::Ray;

pub mod geometry;

pub use geometry::{Geometry, Placed};

/// The number of a primitive: triangles first, then shapes, both in the order of [`Geometry`]'s arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimRef(NonZeroU32);

impl PrimRef {
    /// The largest number there can be.
    pub const MAX: u32 = u32::MAX - 1;

    pub fn new(index: u32) -> Self {
        Self(NonZeroU32::new(index.wrapping_add(1)).expect("a primitive's number is below 2^32 - 1"))
    }

    pub fn index(self) -> u32 {
        self.0.get() - 1
    }
}

/// Which copy of an instanced mesh was hit; [`Instance::NONE`] for what is not instanced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Instance(pub u32);

impl Instance {
    pub const NONE: Self = Self(u32::MAX);
}

/// What a ray met first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// In lengths of the ray's direction.
    pub t: f32,
    pub u: f32,
    pub v: f32,
    pub prim: PrimRef,
    pub instance: Instance,
}

/// The contract of every accelerator.
pub trait Accelerator: Send + Sync {
    /// Fills `hits[i]` with what `rays[i]` meets first with `tmin < t <= tmax`, `None` where it meets nothing.
    fn nearest(&self, rays: &[Ray], hits: &mut [Option<Hit>]);

    /// Fills `blocked[i]` with whether `rays[i]` meets anything at all with `tmin < t <= tmax`.
    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]);

    /// The arrays that it was built over.
    fn geometry(&self) -> &Arc<Geometry>;
}
