//! The default accelerator: an eight-wide tree and kernels for many rays at once.
//!
//! A binary tree is built ([`super::build`]) and [`build`] makes a wide one of it. Triangles lie in blocks of four with
//! their corners, so that a leaf reads nothing else; an analytic primitive is a leaf of its own.
//!
//! [`super::kernels`] traces: packets of 16 rays where [`policy`] finds that they stay together, 64 rays in flight where they
//! have nothing in common. Shadow rays are looked at before, whether one look answers many of them.

use std::{cell::RefCell, sync::Arc, time::Instant};

use super::{
    accelerator::{Accelerator, BuildStats, Quality, RayCost, TreeId, Updated},
    build::prims::Prims,
    kernels::{
        self,
        packet::order::Order,
        ray_selection::Pick,
        scratch::Scratch,
        tree::{Grown, Numbers, Tree},
    },
};
use crate::{
    geometry::{BuildError, Edit, Geometry, Hit, PrimRef, check, padding::Spread},
    math::{Aabb, Ray},
    simd::Simd,
};

mod build;
mod collapse;
mod cost;
pub(super) mod node;
pub(super) mod policy;

/// Rays that tell what those around them take by themselves, where these might go in packets. What that is differs from one part
/// of a picture to another by a factor of two.
const SOME: usize = 64;

/// For how many rays that holds.
const AROUND: usize = SOME * SOME;

thread_local! {
    /// The kernels' memory. One for a thread, since allocating it for a batch of a thousand rays costs 6 %.
    static SCRATCH: RefCell<Scratch> = RefCell::new(Scratch::new());
}

/// What the top must know of a tree below it.
#[derive(Clone, Copy, Debug, Default)]
struct Lower {
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
    pub(super) tree: Arc<Tree>,
    /// Of each group, then of the still triangles; empty where there is one tree.
    lower: Vec<Lower>,
    unbounded: Vec<PrimRef>,
    /// The longest side of the box around everything.
    size: f32,
    simd: Simd,
    stats: BuildStats,
}

impl Wide {
    pub fn build(geometry: Arc<Geometry>, quality: Quality, simd: Simd) -> Result<Self, BuildError> {
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
    pub fn with(&self, simd: Simd) -> Self {
        Self { simd, ..self.clone() }
    }

    fn tree_mut(&mut self) -> &mut Tree {
        Arc::make_mut(&mut self.tree)
    }

    fn grow(&self, prims: Prims) -> Grown {
        build::build(prims, &self.geometry, self.quality).unwrap_or_default()
    }

    fn too_many(&self) -> BuildError {
        BuildError::TooMany {
            count: self.geometry.prim_count(),
        }
    }

    fn push_lower(&mut self, prims: Prims) -> Result<(), BuildError> {
        self.lower.push(Lower::of(&prims));
        let grown = self.grow(prims);
        let numbers = Numbers::prims(self.geometry.prim_count());
        self.tree_mut().push(grown, numbers).ok_or_else(|| self.too_many())
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
        self.tree_mut().spread = Spread::new(self.geometry.instance_transforms(), reach);
        self.unbounded = std::mem::take(&mut prims.unbounded);
        let grown = self.grow(prims);
        let numbers = Numbers {
            prims: self.geometry.prim_count(),
            instances: self.geometry.instances.len(),
            still: self.lower.len().checked_sub(1),
        };
        self.tree_mut().push(grown, numbers).ok_or_else(|| self.too_many())
    }

    /// Gives the boxes of a tree's triangles to the nodes above them, or builds it anew where that makes rays much
    /// slower or where a triangle has come in.
    fn renew(&mut self, section: usize, prims: Prims, id: TreeId, updated: &mut Updated) -> Result<(), BuildError> {
        self.lower[section] = Lower::of(&prims);
        if Arc::make_mut(&mut self.tree).refit(section, &self.geometry, prims.refs.len()) {
            updated.refitted.push(id);
            return Ok(());
        }
        let grown = self.grow(prims);
        let numbers = Numbers::prims(self.geometry.prim_count());
        updated.built.push(id);
        self.tree_mut()
            .replace(section, grown, numbers)
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

    /// Asks some rays of a batch by themselves, so that it is known what they take, if so many have gone without since the last ones
    /// that these say nothing of the batch.
    fn ask_some(&self, rays: &[Ray], blocked: &mut [bool], scratch: &mut Scratch) {
        scratch.untold = scratch.untold.saturating_add(rays.len());
        if scratch.untold < AROUND || rays.len() < SOME {
            return;
        }
        let some: [u32; SOME] = std::array::from_fn(|k| (k * rays.len() / SOME) as u32);
        let pick = Pick::Some(&some);
        kernels::occluded_inflight(self.simd, &self.tree, &self.geometry, rays, pick, blocked, scratch);
        scratch.alone = scratch.taken / SOME as u64;
        scratch.untold = 0;
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
    fn nearest(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
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
        let order = policy::order(rays, self.size).filter(|_| !tree.has_instances());
        SCRATCH.with_borrow_mut(|scratch| {
            let (simd, geometry) = (self.simd, &*self.geometry);
            if let Some(order) = order {
                kernels::nearest_packets(simd, tree, geometry, rays, order, hits, scratch);
                let left = std::mem::take(&mut scratch.left);
                kernels::nearest_inflight(simd, tree, geometry, rays, Pick::Some(&left), hits, scratch);
                scratch.left = left;
            } else {
                kernels::nearest_inflight(simd, tree, geometry, rays, Pick::All, hits, scratch);
            }
        });
    }

    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]) {
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
        let order = policy::occlusion_order(rays, self.size).filter(|_| !tree.has_instances());
        SCRATCH.with_borrow_mut(|scratch| {
            let (simd, geometry) = (self.simd, &*self.geometry);
            let is_sifted = !tree.has_instances() && {
                let order = order.unwrap_or(Order::ROWS);
                kernels::occluded_at_once(simd, tree, rays, order, blocked, scratch);
                scratch.is_sifted
            };
            // What is left of rays that lay side by side does not.
            let in_packets = order.filter(|_| !is_sifted && scratch.packet_doubt.tries());
            if in_packets.is_some() {
                self.ask_some(rays, blocked, scratch);
            }
            let together = order.filter(|_| scratch.head_doubt.tries());
            match (in_packets, together) {
                (Some(order), _) => kernels::occluded_packets(simd, tree, geometry, rays, order, blocked, scratch),
                (None, Some(order)) if !is_sifted => order.put(rays.len(), &mut scratch.left),
                (None, _) => {}
            }
            let left = std::mem::take(&mut scratch.left);
            let pick = match together {
                Some(_) => Pick::Together(&left),
                None if is_sifted || in_packets.is_some() => Pick::Some(&left),
                None => Pick::All,
            };
            kernels::occluded_inflight(simd, tree, geometry, rays, pick, blocked, scratch);
            scratch.left = left;
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

    fn update(&mut self, edit: &Edit) -> Result<Updated, BuildError> {
        let start = Instant::now();
        let groups = self.geometry.groups.len();
        let boxes: Vec<Aabb> = self.lower.iter().take(groups).map(|lower| lower.bounds).collect();
        let changed = edit.apply(&mut self.geometry, &boxes)?;
        let mut updated = Updated::default();
        self.tree_mut().pop();
        // What was one tree becomes two, so that the next change finds what moves apart from what does not.
        if self.lower.is_empty() {
            for group in 0..groups {
                self.push_lower(Prims::group(&self.geometry, group))?;
                updated.built.push(TreeId::Group(group as u32));
            }
            self.push_lower(Prims::still(&self.geometry))?;
            updated.built.push(TreeId::Still);
        } else {
            for group in changed.groups {
                let prims = Prims::group(&self.geometry, group as usize);
                self.renew(group as usize, prims, TreeId::Group(group), &mut updated)?;
            }
            if changed.still {
                let prims = Prims::still(&self.geometry);
                self.renew(groups, prims, TreeId::Still, &mut updated)?;
            }
        }
        self.build_top()?;
        updated.built.push(TreeId::Top);
        self.measure(start);
        Ok(updated)
    }

    fn stats(&self) -> BuildStats {
        self.stats
    }

    fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }
}

impl Lower {
    fn of(prims: &Prims) -> Self {
        Self {
            bounds: prims.bounds(),
            reach: prims.reach,
        }
    }
}
