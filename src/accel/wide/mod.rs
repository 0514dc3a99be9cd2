//! The default accelerator: an eight-wide BVH, with kernels that trace many rays at once.
//!
//! A binary BVH is built ([`mod@super::build`]) and collapsed into a wide one (`build`). Triangles
//! are stored with their vertices in blocks of four, so that a leaf reads no other memory; an
//! analytic primitive is a leaf of its own.
//!
//! The kernels are in [`super::kernels`]. Coherent rays of which the nearest hit is wanted, as
//! [`packet_order`] detects them, are traced in packets of 16. All other rays are traced as a
//! stream of 64 active rays.

use std::{cell::RefCell, sync::Arc, time::Instant};

use super::{
    accelerator::{Accelerator, BuildStats, RayBatch, RayCost, TreeId, UpdateReport},
    build::prims::Prims,
    kernels::{
        self,
        packet::PacketBatch,
        ray_selection::RaySelection,
        scratch::Scratch,
        tree::{BuiltTree, IdSpace, WideTree},
    },
};
use crate::{
    geometry::{BuildError, Edit, Geometry, Hit, PrimId, check, padding::BoundsPadding},
    math::{Aabb, Ray},
    simd::Isa,
};

mod build;
mod collapse;
mod cost;
pub(super) mod node;
pub(super) mod packet_order;

/// The number of rays whose cost limits the cost of packets.
const COST_SAMPLES: usize = 8;

/// The number of nodes and leaves that a packet may visit, relative to the tests of a single ray. A
/// visit of a packet takes as long as that of a ray, and a packet that visits as much as four or
/// five rays is as fast as its sixteen rays in a stream.
const PACKET_VISITS: f32 = 4.0;

/// Per-thread state that is kept between batches. Allocating the kernels' memory for every batch of
/// a thousand rays would cost 6 %.
struct ThreadState {
    scratch: Scratch,
    /// The indices of the rays that packets leave to the stream.
    remaining: Vec<u32>,
}

thread_local! {
    static THREAD: RefCell<ThreadState> = RefCell::new(ThreadState {
        scratch: Scratch::new(),
        remaining: Vec::new(),
    });
}

/// A bottom-level tree, as the top-level tree needs it.
#[derive(Clone, Copy, Debug, Default)]
struct Blas {
    bounds: Aabb,
    reach: f32,
}

/// An accelerator of eight-wide trees.
#[derive(Clone)]
pub struct Wide {
    geometry: Arc<Geometry>,
    /// One tree if the scene has never had instances or edits. Otherwise the trees of the groups,
    /// the tree of the static triangles and the top-level tree. Empty if nothing in the scene has
    /// bounds.
    pub(super) tree: Arc<WideTree>,
    /// The bottom-level trees: those of the groups, then that of the static triangles. Empty if
    /// there is a single tree.
    lower: Vec<Blas>,
    unbounded: Vec<PrimId>,
    /// The longest side of the scene's bounds.
    size: f32,
    simd: Isa,
    stats: BuildStats,
}

impl Wide {
    pub fn build(geometry: Arc<Geometry>, simd: Isa) -> Result<Self, BuildError> {
        let start = Instant::now();
        check::geometry(&geometry)?;
        let count = geometry.prim_count() + geometry.instances.len();
        if count >= node::MAX_PRIMS {
            return Err(BuildError::TooMany { count });
        }
        let mut wide = Self {
            geometry,
            tree: Arc::default(),
            lower: Vec::new(),
            unbounded: Vec::new(),
            size: 0.0,
            simd,
            stats: BuildStats::default(),
        };
        if wide.geometry.instances.is_empty() {
            let prims = Prims::whole(&wide.geometry)?;
            wide.push_top(prims)?;
        } else {
            for group in 0..wide.geometry.groups.len() {
                wide.push_lower(Prims::group(&wide.geometry, group))?;
            }
            wide.push_lower(Prims::static_triangles(&wide.geometry))?;
            wide.build_top()?;
        }
        wide.measure(start);
        Ok(wide)
    }

    /// Returns the same tree with the kernels of another SIMD level.
    pub fn with(&self, simd: Isa) -> Self {
        Self { simd, ..self.clone() }
    }

    fn tree_mut(&mut self) -> &mut WideTree {
        Arc::make_mut(&mut self.tree)
    }

    fn build_tree(&self, prims: Prims) -> BuiltTree {
        build::build(prims, &self.geometry).unwrap_or_default()
    }

    fn too_many(&self) -> BuildError {
        BuildError::TooMany {
            count: self.geometry.prim_count(),
        }
    }

    fn push_lower(&mut self, prims: Prims) -> Result<(), BuildError> {
        self.lower.push(Blas::of(&prims));
        let built_tree = self.build_tree(prims);
        let numbers = IdSpace::prims(self.geometry.prim_count());
        self.tree_mut().push(built_tree, numbers).ok_or_else(|| self.too_many())
    }

    fn build_top(&mut self) -> Result<(), BuildError> {
        let boxes: Vec<Aabb> = self.lower.iter().map(|lower| lower.bounds).collect();
        let (static_bounds, groups) = boxes.split_last().expect("the static triangles are always there");
        let prims = Prims::top(&self.geometry, static_bounds, groups)?;
        self.push_top(prims)
    }

    fn push_top(&mut self, mut prims: Prims) -> Result<(), BuildError> {
        self.size = prims.bounds().extent().max_element().max(0.0);
        let reach = self.lower.iter().map(|lower| lower.reach).fold(prims.reach, f32::max);
        self.tree_mut().padding = BoundsPadding::new(self.geometry.instance_transforms(), reach);
        self.unbounded = std::mem::take(&mut prims.unbounded);
        let built_tree = self.build_tree(prims);
        let numbers = IdSpace {
            prims: self.geometry.prim_count(),
            instances: self.geometry.instances.len(),
            static_tree: self.lower.len().checked_sub(1),
        };
        self.tree_mut().push(built_tree, numbers).ok_or_else(|| self.too_many())
    }

    /// Refits the boxes of a bottom-level tree. Rebuilds it instead if the refitted tree would be
    /// much slower, or if a triangle has to be added to it.
    fn refit_or_rebuild(
        &mut self,
        section: usize,
        prims: Prims,
        id: TreeId,
        updated: &mut UpdateReport,
    ) -> Result<(), BuildError> {
        self.lower[section] = Blas::of(&prims);
        if Arc::make_mut(&mut self.tree).refit(section, &self.geometry, prims.refs.len()) {
            updated.refitted.push(id);
            return Ok(());
        }
        let built_tree = self.build_tree(prims);
        let numbers = IdSpace::prims(self.geometry.prim_count());
        updated.built.push(id);
        self.tree_mut()
            .replace(section, built_tree, numbers)
            .ok_or_else(|| self.too_many())
    }

    fn measure(&mut self, start: Instant) {
        self.stats = BuildStats {
            build_time: start.elapsed(),
            node_count: self.tree.nodes().len(),
            bytes: self.tree.bytes(),
            ..BuildStats::of(&self.geometry)
        };
    }

    /// Returns the nearest hit among the unbounded primitives: the initial state of a ray that
    /// enters the tree.
    fn nearest_unbounded(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = None;
        self.geometry
            .keep_nearest_of(&self.unbounded, &mut ray.clone(), &mut hit);
        hit
    }
}

/// The traversal of coherent rays.
impl Wide {
    /// Returns the mean number of nodes and leaves that packets of `rays` may visit.
    fn packet_visits(&self, rays: &[Ray]) -> u32 {
        let samples: [Ray; COST_SAMPLES] = std::array::from_fn(|k| rays[(2 * k + 1) * rays.len() / (2 * COST_SAMPLES)]);
        let mut costs = [RayCost::default(); COST_SAMPLES];
        self.cost(&samples, &mut costs);
        let tests: u32 = costs.iter().map(|cost| cost.nodes + cost.prims).sum();
        (tests as f32 * (PACKET_VISITS / COST_SAMPLES as f32)).ceil() as u32
    }
}

impl Accelerator for Wide {
    fn nearest_batch(&self, batch: RayBatch<'_>, hits: &mut [Option<Hit>]) {
        let rays = batch.rays;
        let hits = &mut hits[..rays.len()];
        hits.fill(None);
        if !self.unbounded.is_empty() {
            for (ray, hit) in rays.iter().zip(&mut *hits) {
                *hit = self.nearest_unbounded(ray);
            }
        }
        let tree = &self.tree;
        if tree.nodes().is_empty() {
            return;
        }
        let order = packet_order::nearest(batch, self.size).filter(|_| !tree.has_instances());
        THREAD.with_borrow_mut(|thread| {
            let ThreadState { scratch, remaining } = thread;
            let (simd, geometry) = (self.simd, &*self.geometry);
            if let Some(order) = order {
                let visits = self.packet_visits(rays);
                let packets = PacketBatch { rays, order, visits };
                kernels::nearest_packets(simd, tree, geometry, packets, hits, remaining, scratch);
                kernels::nearest_stream(simd, tree, geometry, rays, RaySelection::Some(remaining), hits, scratch);
            } else {
                kernels::nearest_stream(simd, tree, geometry, rays, RaySelection::All, hits, scratch);
            }
        });
    }

    fn occluded_batch(&self, batch: RayBatch<'_>, blocked: &mut [bool]) {
        let rays = batch.rays;
        let blocked = &mut blocked[..rays.len()];
        blocked.fill(false);
        if !self.unbounded.is_empty() {
            for (ray, blocked) in rays.iter().zip(&mut *blocked) {
                *blocked = self.nearest_unbounded(ray).is_some();
            }
        }
        let tree = &self.tree;
        if tree.nodes().is_empty() {
            return;
        }
        THREAD.with_borrow_mut(|thread| {
            kernels::occluded_stream(self.simd, tree, &self.geometry, rays, blocked, &mut thread.scratch);
        });
    }

    fn cost(&self, rays: &[Ray], costs: &mut [RayCost]) {
        for (ray, cost) in rays.iter().zip(costs) {
            *cost = RayCost {
                nodes: 0,
                prims: self.unbounded.len() as u32,
            };
            let best = self.nearest_unbounded(ray);
            let mut ray = *ray;
            ray.tmax = best.map_or(ray.tmax, |hit| hit.t);
            cost::count(&self.tree, &self.geometry, ray, best, cost);
        }
    }

    fn update(&mut self, edit: &Edit) -> Result<UpdateReport, BuildError> {
        let start = Instant::now();
        let groups = self.geometry.groups.len();
        let boxes: Vec<Aabb> = self.lower.iter().take(groups).map(|lower| lower.bounds).collect();
        let changed = edit.apply(&mut self.geometry, &boxes)?;
        let mut updated = UpdateReport::default();
        self.tree_mut().pop();
        // A single tree is split in two levels, so that later updates find moving and static
        // geometry in separate trees.
        if self.lower.is_empty() {
            for group in 0..groups {
                self.push_lower(Prims::group(&self.geometry, group))?;
                updated.built.push(TreeId::Group(group as u32));
            }
            self.push_lower(Prims::static_triangles(&self.geometry))?;
            updated.built.push(TreeId::Static);
        } else {
            for group in changed.groups {
                let prims = Prims::group(&self.geometry, group as usize);
                self.refit_or_rebuild(group as usize, prims, TreeId::Group(group), &mut updated)?;
            }
            if changed.static_triangles {
                let prims = Prims::static_triangles(&self.geometry);
                self.refit_or_rebuild(groups, prims, TreeId::Static, &mut updated)?;
            }
        }
        self.build_top()?;
        updated.built.push(TreeId::Top);
        self.measure(start);
        Ok(updated)
    }

    fn simd(&self) -> Isa {
        self.simd
    }

    fn stats(&self) -> BuildStats {
        self.stats
    }

    fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }
}

impl Blas {
    fn of(prims: &Prims) -> Self {
        Self {
            bounds: prims.bounds(),
            reach: prims.reach,
        }
    }
}
