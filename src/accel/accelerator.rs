//! The contract of every accelerator, and what they tell of themselves.

use std::{fmt, str::FromStr, sync::Arc, time::Duration};

use crate::{
    geometry::{BuildError, Edit, Geometry, Hit},
    math::Ray,
    simd::Isa,
    value::UnknownName,
};

/// How the rays of a batch lie beside one another. Hits do not depend on it, only time does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BatchLayout {
    /// Nothing is known.
    #[default]
    Unordered,
    /// A tile of a picture, row after row, of so many rays each: the samples of a pixel follow one another, and so do the pixels of
    /// a row. A few rays may be missing.
    Rows(u32),
}

/// Rays that are traced together.
#[derive(Clone, Copy, Debug)]
pub struct RayBatch<'a> {
    pub rays: &'a [Ray],
    pub layout: BatchLayout,
}

impl<'a> RayBatch<'a> {
    /// Rays of which no layout is known.
    pub fn unordered(rays: &'a [Ray]) -> Self {
        Self {
            rays,
            layout: BatchLayout::Unordered,
        }
    }
}

/// The contract of every accelerator.
///
/// # Panics
/// The methods that fill a slice panic when it is shorter than the batch.
pub trait Accelerator: Send + Sync {
    /// Fills `hits[i]` with what ray `i` meets first with `tmin < t <= tmax`, `None` where it meets nothing.
    fn nearest_batch(&self, batch: RayBatch<'_>, hits: &mut [Option<Hit>]);

    /// Fills `blocked[i]` with whether ray `i` meets anything at all with `tmin < t <= tmax`.
    fn occluded_batch(&self, batch: RayBatch<'_>, blocked: &mut [bool]);

    /// [`Accelerator::nearest_batch`] for rays of which no layout is known.
    fn nearest(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.nearest_batch(RayBatch::unordered(rays), hits);
    }

    /// [`Accelerator::occluded_batch`] for rays of which no layout is known.
    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]) {
        self.occluded_batch(RayBatch::unordered(rays), blocked);
    }

    /// Fills `costs[i]` with what the nearest hit of `rays[i]` costs. Slow: for pictures of it.
    fn cost(&self, rays: &[Ray], costs: &mut [RayCost]);

    /// Changes the geometry and what is built over it, and only that: where instances and shapes stand is known to the
    /// top alone, positions to the tree that their triangles are in. Hits are then those of a new accelerator over the
    /// changed geometry, bit for bit. Changes nothing where it fails.
    fn update(&mut self, edit: &Edit) -> Result<UpdateReport, BuildError>;

    /// The vectors that it was built for. Loops that run beside it use the same.
    fn simd(&self) -> Isa;

    /// What building took, the last time anything was built.
    fn stats(&self) -> BuildStats;

    /// The arrays that it was built over.
    fn geometry(&self) -> &Arc<Geometry>;
}

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
    pub fn of(geometry: &Geometry) -> Self {
        Self {
            prims: geometry.prim_count(),
            instances: geometry.instances.len(),
            seen: geometry.instanced_prim_count(),
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

/// A tree of an accelerator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeId {
    /// Over instances, shapes and the two below.
    Top,
    /// Over the triangles that are in no group.
    Static,
    /// Over a group's triangles.
    Group(u32),
}

/// What an update took. Trees that are not named were not touched.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UpdateReport {
    /// Built anew.
    pub built: Vec<TreeId>,
    /// Given new boxes, with the branches they had.
    pub refitted: Vec<TreeId>,
}
