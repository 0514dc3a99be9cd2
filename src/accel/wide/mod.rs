//! The default accelerator: an eight-wide tree and kernels for many rays at once.
//!
//! A binary tree is built ([`super::build`]) and [`build`] makes a wide one of it. Triangles lie in blocks of four with
//! their corners, so that a leaf reads nothing else; an analytic primitive is a leaf of its own.
//!
//! [`super::kernels`] traces: packets of 16 rays where [`packet_order`] finds that they stay together, 64 rays in flight where they
//! have nothing in common. Shadow rays are looked at before, whether one look answers many of them.

use std::{cell::RefCell, sync::Arc, time::Instant};

use super::{
    accelerator::{Accelerator, BuildStats, Quality, RayBatch, RayCost, TreeId, UpdateReport},
    build::prims::Prims,
    kernels::{
        self,
        packet::{PacketBatch, order::PacketOrder},
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
mod policy;

use policy::OcclusionPolicy;

/// What a thread keeps between batches: allocating the kernels' memory for a batch of a thousand rays costs 6 %.
struct ThreadState {
    scratch: Scratch,
    /// The numbers of rays that a kernel has left to the next.
    remaining: Vec<u32>,
    policy: OcclusionPolicy,
}

thread_local! {
    static THREAD: RefCell<ThreadState> = RefCell::new(ThreadState {
        scratch: Scratch::new(),
        remaining: Vec::new(),
        policy: OcclusionPolicy::new(),
    });
}

/// What the top must know of a tree below it.
#[derive(Clone, Copy, Debug, Default)]
struct Blas {
    bounds: Aabb,
    reach: f32,
}

/// Eight-wide trees.
#[derive(Clone)]
pub struct Wide {
    geometry: Arc<Geometry>,
    quality: Quality,
    /// One tree where nothing was ever an instance or moved; otherwise those of groups, of the still triangles, and the
    /// top. Nothing at all where nothing has a box.
    pub(super) tree: Arc<WideTree>,
    /// Of each group, then of the still triangles; empty where there is one tree.
    lower: Vec<Blas>,
    unbounded: Vec<PrimId>,
    /// The longest side of the box around everything.
    size: f32,
    simd: Isa,
    stats: BuildStats,
}

impl Wide {
    pub fn build(geometry: Arc<Geometry>, quality: Quality, simd: Isa) -> Result<Self, BuildError> {
        let start = Instant::now();
        check::geometry(&geometry)?;
        let count = geometry.prim_count() + geometry.instances.len();
        if count >= node::MAX_PRIMS {
            return Err(BuildError::TooMany { count });
        }
        let mut wide = Self {
            geometry,
            quality,
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
            wide.push_lower(Prims::still(&wide.geometry))?;
            wide.build_top()?;
        }
        wide.measure(start);
        Ok(wide)
    }

    /// The same tree for the kernels of another level.
    pub fn with(&self, simd: Isa) -> Self {
        Self { simd, ..self.clone() }
    }

    fn tree_mut(&mut self) -> &mut WideTree {
        Arc::make_mut(&mut self.tree)
    }

    fn grow(&self, prims: Prims) -> BuiltTree {
        build::build(prims, &self.geometry, self.quality).unwrap_or_default()
    }

    fn too_many(&self) -> BuildError {
        BuildError::TooMany {
            count: self.geometry.prim_count(),
        }
    }

    fn push_lower(&mut self, prims: Prims) -> Result<(), BuildError> {
        self.lower.push(Blas::of(&prims));
        let built_tree = self.grow(prims);
        let numbers = IdSpace::prims(self.geometry.prim_count());
        self.tree_mut().push(built_tree, numbers).ok_or_else(|| self.too_many())
    }

    fn build_top(&mut self) -> Result<(), BuildError> {
        let boxes: Vec<Aabb> = self.lower.iter().map(|lower| lower.bounds).collect();
        let (still, groups) = boxes.split_last().expect("the still triangles are always there");
        let prims = Prims::top(&self.geometry, still, groups)?;
        self.push_top(prims)
    }

    fn push_top(&mut self, mut prims: Prims) -> Result<(), BuildError> {
        self.size = prims.bounds().extent().max_element().max(0.0);
        let reach = self.lower.iter().map(|lower| lower.reach).fold(prims.reach, f32::max);
        self.tree_mut().padding = BoundsPadding::new(self.geometry.instance_transforms(), reach);
        self.unbounded = std::mem::take(&mut prims.unbounded);
        let built_tree = self.grow(prims);
        let numbers = IdSpace {
            prims: self.geometry.prim_count(),
            instances: self.geometry.instances.len(),
            still: self.lower.len().checked_sub(1),
        };
        self.tree_mut().push(built_tree, numbers).ok_or_else(|| self.too_many())
    }

    /// Gives the boxes of a tree's triangles to the nodes above them, or builds it anew where that makes rays much
    /// slower or where a triangle has come in.
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
        let built_tree = self.grow(prims);
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

    /// What lies outside the tree: the state that a ray enters the tree with.
    fn outside(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = None;
        self.geometry
            .keep_nearest_of(&self.unbounded, &mut ray.clone(), &mut hit);
        hit
    }
}

impl Accelerator for Wide {
    fn nearest_batch(&self, batch: RayBatch<'_>, hits: &mut [Option<Hit>]) {
        let rays = batch.rays;
        let hits = &mut hits[..rays.len()];
        hits.fill(None);
        if !self.unbounded.is_empty() {
            for (ray, hit) in rays.iter().zip(&mut *hits) {
                *hit = self.outside(ray);
            }
        }
        let tree = &self.tree;
        if tree.nodes().is_empty() {
            return;
        }
        let order = packet_order::nearest(batch, self.size).filter(|_| !tree.has_instances());
        THREAD.with_borrow_mut(|thread| {
            let ThreadState { scratch, remaining, .. } = thread;
            let (simd, geometry) = (self.simd, &*self.geometry);
            if let Some(order) = order {
                let packets = PacketBatch {
                    rays,
                    order,
                    single_cost: 0,
                };
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
                *blocked = self.outside(ray).is_some();
            }
        }
        let tree = &self.tree;
        if tree.nodes().is_empty() {
            return;
        }
        let order = packet_order::occlusion(batch, self.size).filter(|_| !tree.has_instances());
        THREAD.with_borrow_mut(|thread| {
            let ThreadState {
                scratch,
                remaining,
                policy,
            } = thread;
            let (simd, geometry) = (self.simd, &*self.geometry);
            let is_sifted = !tree.has_instances() && {
                let order = order.unwrap_or(PacketOrder::ROWS);
                kernels::occluded_at_once(simd, tree, rays, order, blocked, remaining)
            };
            // What is left of rays that lay side by side does not.
            let in_packets = order.filter(|_| !is_sifted && policy.packets.should_try());
            if in_packets.is_some()
                && let Some(some) = policy.probe(rays.len())
            {
                let pick = RaySelection::Some(&some);
                policy.record_probe(kernels::occluded_stream(
                    simd, tree, geometry, rays, pick, blocked, scratch,
                ));
            }
            let together = order.filter(|_| policy.entry_points.should_try());
            match (in_packets, together) {
                (Some(order), _) => {
                    let packets = PacketBatch {
                        rays,
                        order,
                        single_cost: policy.single_cost(),
                    };
                    let pays = kernels::occluded_packets(simd, tree, geometry, packets, blocked, remaining, scratch);
                    policy.packets.record(pays);
                }
                (None, Some(order)) if !is_sifted => order.put(rays.len(), remaining),
                (None, _) => {}
            }
            let pick = match together {
                Some(_) => RaySelection::Together(remaining),
                None if is_sifted || in_packets.is_some() => RaySelection::Some(remaining),
                None => RaySelection::All,
            };
            let report = kernels::occluded_stream(simd, tree, geometry, rays, pick, blocked, scratch);
            if let Some(pays) = report.entry_points_pay {
                policy.entry_points.record(pays);
            }
        });
    }

    fn cost(&self, rays: &[Ray], costs: &mut [RayCost]) {
        for (ray, cost) in rays.iter().zip(costs) {
            *cost = RayCost {
                nodes: 0,
                prims: self.unbounded.len() as u32,
            };
            let best = self.outside(ray);
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
        // What was one tree becomes two, so that the next change finds what moves apart from what does not.
        if self.lower.is_empty() {
            for group in 0..groups {
                self.push_lower(Prims::group(&self.geometry, group))?;
                updated.built.push(TreeId::Group(group as u32));
            }
            self.push_lower(Prims::still(&self.geometry))?;
            updated.built.push(TreeId::Static);
        } else {
            for group in changed.groups {
                let prims = Prims::group(&self.geometry, group as usize);
                self.refit_or_rebuild(group as usize, prims, TreeId::Group(group), &mut updated)?;
            }
            if changed.still {
                let prims = Prims::still(&self.geometry);
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
