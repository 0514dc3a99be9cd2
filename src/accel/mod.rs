//! Acceleration structures: boxes in, hits out.
//!
//! Rays come in batches, because that is what makes them fast; nothing here takes one ray at a time. Every accelerator
//! gives the same bits: a hit's `t`, `u` and `v` come from the primitive's one scalar routine (or from operations in
//! the same order), of two hits at the same `t` the primitive with the lower number wins, a box is passed over only
//! when it lies strictly farther than the nearest hit so far, and a hit counts inside its primitive's own box
//! (the module `slab` says why that is needed, and why it is enough).
//!
//! | kind | what it is |
//! |---|---|
//! | `linear` | every primitive for every ray: the ground truth |
//! | `bvh2` | a binary tree and a scalar traversal |
//! | `cwbvh` | obvhs's compressed wide tree |
//! | `wide` | an eight-wide tree and kernels for many rays at once: the default |

use std::{fmt, num::NonZeroU32, str::FromStr, sync::Arc, time::Duration};

use thiserror::Error;

use crate::{math::Ray, value::UnknownName};

mod binary;
mod bvh2;
mod check;
mod crown;
mod cwbvh;
pub mod edit;
pub mod geometry;
mod instance;
mod levels;
mod linear;
mod ploc;
mod plots;
mod prims;
mod reinsert;
mod sets;
mod simd;
mod slab;
mod spatial;
#[cfg(test)]
mod tests;
mod wide;

pub use check::LARGEST;
pub use edit::{Edit, TreeId, Updated};
pub use geometry::{Geometry, Group, Placed, PlacedGroup};
pub use instance::MOST_MAGNIFICATION;
pub use simd::{Simd, VARIABLE as SIMD_VARIABLE, prefetch};

/// Which accelerator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum AccelKind {
    Linear,
    Bvh2,
    CwBvh,
    #[default]
    Wide,
}

impl AccelKind {
    /// Every kind with its name, in the order of the documentation.
    pub const TABLE: &[(Self, &str)] = &[
        (Self::Linear, "linear"),
        (Self::Bvh2, "bvh2"),
        (Self::CwBvh, "cwbvh"),
        (Self::Wide, "wide"),
    ];
}

/// How much time goes into a tree. Hits do not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Quality {
    /// For a frame or two.
    Fast,
    #[default]
    Medium,
    /// For many frames of a still scene.
    High,
}

impl Quality {
    /// Every quality with its name, from fast to slow.
    pub const TABLE: &[(Self, &str)] = &[(Self::Fast, "fast"), (Self::Medium, "medium"), (Self::High, "high")];
}

fn find<T: Copy>(what: &'static str, table: &[(T, &'static str)], name: &str) -> Result<T, UnknownName> {
    table
        .iter()
        .find(|row| row.1 == name)
        .map(|row| row.0)
        .ok_or_else(|| UnknownName::new(what, name, table.iter().map(|row| row.1)))
}

fn name<T: Copy + PartialEq>(table: &[(T, &'static str)], value: T) -> &'static str {
    table
        .iter()
        .find(|row| row.0 == value)
        .expect("the table lists every value")
        .1
}

impl FromStr for AccelKind {
    type Err = UnknownName;

    fn from_str(s: &str) -> Result<Self, UnknownName> {
        find("accelerator", Self::TABLE, s)
    }
}

impl fmt::Display for AccelKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(name(Self::TABLE, *self))
    }
}

impl FromStr for Quality {
    type Err = UnknownName;

    fn from_str(s: &str) -> Result<Self, UnknownName> {
        find("build quality", Self::TABLE, s)
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(name(Self::TABLE, *self))
    }
}

/// Why nothing was built.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum BuildError {
    #[error("primitive {prim} has a coordinate that is not a finite number")]
    NotFinite { prim: usize },
    #[error("primitive {prim} has a coordinate beyond {LARGEST:e} m")]
    TooLarge { prim: usize },
    #[error("triangle {prim} names vertex {vertex}, but there are {vertices}")]
    NoSuchVertex { prim: usize, vertex: u32, vertices: usize },
    #[error("triangle {prim} and one that is not of its group have a vertex in common")]
    SharedVertex { prim: usize },
    #[error("group {group} is out of order or names what does not exist")]
    BadGroup { group: usize },
    #[error("instance {instance} names a group or a transform that does not exist")]
    BadInstance { instance: usize },
    #[error("instance {instance} reaches beyond {LARGEST:e} m")]
    InstanceTooLarge { instance: usize },
    #[error("there is no {what} {index} to be moved")]
    NothingThere { what: &'static str, index: usize },
    #[error("vertex {vertex} would be at no finite place, or beyond {LARGEST:e} m")]
    BadVertex { vertex: usize },
    #[error("{count} primitives are more than can be numbered")]
    TooMany { count: usize },
}

/// What building took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildStats {
    pub build_time: Duration,
    pub node_count: usize,
    /// Of the structure itself; the geometry's arrays are not counted.
    pub bytes: usize,
    /// All primitives that are stored, those outside the tree included.
    pub prims: usize,
    pub instances: usize,
    /// Primitives as rays see them: those of an instanced mesh once for each instance.
    pub seen: u64,
}

impl BuildStats {
    /// What is known of `geometry` before anything is built.
    fn of(geometry: &Geometry) -> Self {
        Self {
            prims: geometry.prim_count(),
            instances: geometry.instances.len(),
            seen: geometry.seen_prim_count(),
            ..Self::default()
        }
    }
}

/// What a ray's nearest hit cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCost {
    /// Boxes tested; of a wide node all together count as one.
    pub nodes: u32,
    pub prims: u32,
}

/// Builds an accelerator of medium quality.
pub fn build(kind: AccelKind, geometry: Arc<Geometry>) -> Result<Box<dyn Accelerator>, BuildError> {
    build_with(kind, Quality::default(), geometry)
}

/// Builds an accelerator.
pub fn build_with(
    kind: AccelKind,
    quality: Quality,
    geometry: Arc<Geometry>,
) -> Result<Box<dyn Accelerator>, BuildError> {
    Ok(match kind {
        AccelKind::Linear => Box::new(linear::Linear::build(geometry)?),
        AccelKind::Bvh2 => Box::new(bvh2::Bvh2::build(geometry, quality)?),
        AccelKind::CwBvh => Box::new(cwbvh::CwBvh::build(geometry, quality)?),
        AccelKind::Wide => Box::new(wide::Wide::build(geometry, quality, Simd::detect())?),
    })
}

/// Builds the wide accelerator with the kernels of one level: for tests and benches, which compare them.
pub fn build_wide(simd: Simd, quality: Quality, geometry: Arc<Geometry>) -> Result<Box<dyn Accelerator>, BuildError> {
    Ok(Box::new(wide::Wide::build(geometry, quality, simd)?))
}

/// The wide accelerator with the kernels of one level.
pub type AtLevel = (Simd, Box<dyn Accelerator>);

/// One tree with the kernels of every level that this processor has.
pub fn build_wide_levels(quality: Quality, geometry: &Arc<Geometry>) -> Result<Vec<AtLevel>, BuildError> {
    let tree = wide::Wide::build(Arc::clone(geometry), quality, Simd::detect())?;
    let levels = Simd::available().into_iter();
    Ok(levels
        .map(|simd| (simd, Box::new(tree.with(simd)) as Box<dyn Accelerator>))
        .collect())
}

/// Tests what lies outside every tree.
fn nearest_unbounded(geometry: &Geometry, unbounded: &[PrimRef], ray: &mut Ray, best: &mut Option<Hit>) {
    for &prim in unbounded {
        geometry.keep_nearest(prim, Instance::NONE, ray, best);
    }
}

/// The number of a primitive: triangles first, then shapes, both in the order of [`Geometry`]'s arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimRef(NonZeroU32);

impl PrimRef {
    /// The largest number there can be.
    pub const MAX: u32 = u32::MAX - 1;

    pub fn new(index: u32) -> Self {
        Self(NonZeroU32::new(index.wrapping_add(1)).expect("a primitive's number is below 2^32 - 1"))
    }

    /// The primitive whose number is one less, `None` for the largest there is.
    #[inline(always)]
    fn one_below(number: u32) -> Option<Self> {
        NonZeroU32::new(if number == u32::MAX { 0 } else { number }).map(Self)
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
    pub prim: PrimRef,
    pub instance: Instance,
}

/// The contract of every accelerator.
///
/// # Panics
/// The methods that fill a slice panic when it is shorter than `rays`.
pub trait Accelerator: Send + Sync {
    /// Fills `hits[i]` with what `rays[i]` meets first with `tmin < t <= tmax`, `None` where it meets nothing.
    fn nearest(&self, rays: &[Ray], hits: &mut [Option<Hit>]);

    /// Fills `blocked[i]` with whether `rays[i]` meets anything at all with `tmin < t <= tmax`.
    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]);

    /// Fills `costs[i]` with what the nearest hit of `rays[i]` costs. Slow: for pictures of it.
    fn cost(&self, rays: &[Ray], costs: &mut [RayCost]);

    /// Changes the geometry and what is built over it, and only that: where instances and shapes stand is known to the
    /// top alone, positions to the tree that their triangles are in. Hits are then those of a new accelerator over the
    /// changed geometry, bit for bit. Changes nothing where it fails.
    fn update(&mut self, edit: &Edit) -> Result<Updated, BuildError>;

    /// What building took, the last time anything was built.
    fn stats(&self) -> BuildStats;

    /// The arrays that it was built over.
    fn geometry(&self) -> &Arc<Geometry>;
}
