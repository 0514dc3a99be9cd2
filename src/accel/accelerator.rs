//! The contract of all accelerators, and their options and statistics.

use std::{sync::Arc, time::Duration};

use crate::{
    geometry::{BuildError, Edit, Geometry, Hit},
    kind::named,
    math::Ray,
    simd::Isa,
};

/// The order of the rays in a batch. It affects speed only, never the hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BatchLayout {
    /// The order is unknown.
    #[default]
    Unordered,
    /// A tile of an image in scanline order, with this many rays in a row. The samples of a pixel
    /// are consecutive, and so are the pixels of a row. A few rays may be missing.
    Rows(u32),
}

/// Rays that are traced together.
#[derive(Clone, Copy, Debug)]
pub struct RayBatch<'a> {
    pub rays: &'a [Ray],
    pub layout: BatchLayout,
}

impl<'a> RayBatch<'a> {
    /// Returns a batch whose layout is unknown.
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
    /// Writes the nearest hit of ray `i` with `tmin < t <= tmax` to `hits[i]`, or `None` if there
    /// is no hit.
    fn nearest_batch(&self, batch: RayBatch<'_>, hits: &mut [Option<Hit>]);

    /// Writes to `blocked[i]` whether ray `i` has any hit with `tmin < t <= tmax`.
    fn occluded_batch(&self, batch: RayBatch<'_>, blocked: &mut [bool]);

    /// Calls [`Accelerator::nearest_batch`] for rays of unknown layout.
    fn nearest(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.nearest_batch(RayBatch::unordered(rays), hits);
    }

    /// Calls [`Accelerator::occluded_batch`] for rays of unknown layout.
    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]) {
        self.occluded_batch(RayBatch::unordered(rays), blocked);
    }

    /// Writes to `costs[i]` the work that finding the nearest hit of `rays[i]` takes. It is slow
    /// and meant for visualisation.
    fn cost(&self, rays: &[Ray], costs: &mut [RayCost]);

    /// Applies `edit` to the geometry and updates only the trees that it affects: a moved instance
    /// or shape affects the top-level tree, a moved vertex the tree that holds its triangles. Hits
    /// are then bit-identical to those of a new accelerator over the changed geometry. If the
    /// update fails, nothing is changed.
    fn update(&mut self, edit: &Edit) -> Result<UpdateReport, BuildError>;

    /// Returns the SIMD level of the kernels. Other loops of the render use the same level.
    fn simd(&self) -> Isa;

    /// Returns the statistics of the last build or update.
    fn stats(&self) -> BuildStats;

    /// Returns the geometry that the accelerator was built over.
    fn geometry(&self) -> &Arc<Geometry>;
}

named! {
    /// The kinds of accelerators.
    #[derive(Default, Hash)]
    pub enum AccelKind: "accelerator" {
        Linear = "linear",
        Bvh2 = "bvh2",
        #[default]
        Wide = "wide",
    }
}

/// Statistics of a build.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildStats {
    pub build_time: Duration,
    pub node_count: usize,
    /// Memory of the structure, without the arrays of the geometry.
    pub bytes: usize,
    /// All stored primitives, including those outside of the tree.
    pub prims: usize,
    pub instances: usize,
    /// Primitives that rays can hit: those of an instanced mesh count once per instance.
    pub seen: u64,
}

impl BuildStats {
    /// Returns the statistics of `geometry` that are known before a build.
    pub fn of(geometry: &Geometry) -> Self {
        Self {
            prims: geometry.prim_count(),
            instances: geometry.instances.len(),
            seen: geometry.instanced_prim_count(),
            ..Self::default()
        }
    }
}

/// The work that finding a ray's nearest hit takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCost {
    /// Boxes tested; all boxes of a wide node count as one.
    pub nodes: u32,
    pub prims: u32,
}

/// Identifies a tree of an accelerator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeId {
    /// The top-level tree, over instances, shapes and the trees below.
    Top,
    /// The tree over the triangles that are in no group.
    Static,
    /// The tree over the triangles of one group.
    Group(u32),
}

/// The work of an update. Trees that are not listed were not changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UpdateReport {
    /// Trees that were rebuilt.
    pub built: Vec<TreeId>,
    /// Trees whose boxes were refitted, with the topology unchanged.
    pub refitted: Vec<TreeId>,
}
