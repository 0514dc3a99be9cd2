//! A binary BVH with a scalar traversal: simple, and a reference for the speed of the others. It
//! has two levels if there are instances.

use std::{ops::ControlFlow, sync::Arc, time::Instant};

use super::{
    accelerator::{Accelerator, BuildStats, RayBatch, RayCost, TreeId, UpdateReport},
    build::{
        self,
        bvh2_tree::{Bvh2Tree, Leaves},
        prims::{Item, Prims},
    },
};
use crate::{
    geometry::{BuildError, Edit, Geometry, Hit, InstanceId, PrimId, check, padding::BoundsPadding, slab::Planes},
    math::{Aabb, Ray},
    simd::Isa,
};

/// A bottom-level tree, with what the top-level tree needs.
#[derive(Default)]
struct Blas {
    tree: Bvh2Tree,
    bounds: Aabb,
    reach: f32,
}

impl Blas {
    fn build(prims: Prims, geometry: &Geometry) -> Self {
        Self {
            bounds: prims.bounds(),
            reach: prims.reach,
            tree: build_tree(prims, geometry),
        }
    }
}

/// An accelerator of binary trees.
pub struct Bvh2 {
    geometry: Arc<Geometry>,
    /// The only tree if the scene has never had instances or edits; otherwise the top-level tree.
    top: Bvh2Tree,
    /// The tree over the triangles that are in no group, if they are not in `top`.
    static_tree: Blas,
    groups: Vec<Blas>,
    unbounded: Vec<PrimId>,
    padding: BoundsPadding,
    simd: Isa,
    stats: BuildStats,
}

/// The children of one tree that wait, with their entry distances.
type Stack = Vec<(u32, f32)>;

/// The stacks of a ray: that of the top-level tree, and that of a tree below it.
#[derive(Default)]
struct Stacks {
    top: Stack,
    below: Stack,
}

fn build_tree(prims: Prims, geometry: &Geometry) -> Bvh2Tree {
    build::build_tree(prims, geometry, Leaves { triangles: 4 }).unwrap_or_default()
}

impl Bvh2Tree {
    /// Visits the items that `ray` may hit, the nearer child first, and counts the boxes that are
    /// tested. `leaf` tests an item, may shorten the ray, and returns whether to continue.
    fn walk(
        &self,
        ray: &mut Ray,
        planes: &Planes,
        stack: &mut Stack,
        nodes: &mut u32,
        mut leaf: impl FnMut(u32, &mut Ray) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        stack.clear();
        let Some(root) = self.nodes.first() else {
            return ControlFlow::Continue(());
        };
        *nodes += 1;
        if let Some(t) = planes.enter(&root.bounds, ray.tmin, ray.tmax) {
            stack.push((0, t));
        }
        while let Some((index, t)) = stack.pop() {
            if t > ray.tmax {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.is_leaf() {
                let (first, count) = (node.link as usize, node.count as usize);
                for &id in &self.ids[first..first + count] {
                    leaf(id, ray)?;
                }
                continue;
            }
            *nodes += 2;
            let children = [index + 1, node.link];
            let enter = children.map(|c| planes.enter(&self.nodes[c as usize].bounds, ray.tmin, ray.tmax));
            match enter {
                [Some(a), Some(b)] if a <= b => stack.extend([(children[1], b), (children[0], a)]),
                [Some(a), Some(b)] => stack.extend([(children[0], a), (children[1], b)]),
                [Some(a), None] => stack.push((children[0], a)),
                [None, Some(b)] => stack.push((children[1], b)),
                [None, None] => {}
            }
        }
        ControlFlow::Continue(())
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.ids[..])
    }
}

impl Bvh2 {
    pub fn build(geometry: Arc<Geometry>, simd: Isa) -> Result<Self, BuildError> {
        let start = Instant::now();
        check::geometry(&geometry)?;
        let mut levels = Self {
            geometry,
            top: Bvh2Tree::default(),
            static_tree: Blas::default(),
            groups: Vec::new(),
            unbounded: Vec::new(),
            padding: BoundsPadding::default(),
            simd,
            stats: BuildStats::default(),
        };
        if levels.geometry.instances.is_empty() {
            levels.set_top(Prims::whole(&levels.geometry)?);
        } else {
            levels.build_still();
            let groups = 0..levels.geometry.groups.len();
            levels.groups = groups.map(|group| levels.group(group)).collect();
            levels.build_top()?;
        }
        levels.measure(start);
        Ok(levels)
    }

    fn group(&self, group: usize) -> Blas {
        Blas::build(Prims::group(&self.geometry, group), &self.geometry)
    }

    fn build_still(&mut self) {
        self.static_tree = Blas::build(Prims::static_triangles(&self.geometry), &self.geometry);
    }

    fn build_top(&mut self) -> Result<(), BuildError> {
        let groups: Vec<Aabb> = self.groups.iter().map(|group| group.bounds).collect();
        self.set_top(Prims::top(&self.geometry, &self.static_tree.bounds, &groups)?);
        Ok(())
    }

    fn set_top(&mut self, mut prims: Prims) {
        let below = self.groups.iter().map(|group| group.reach);
        self.padding = BoundsPadding::new(self.geometry.instance_transforms(), below.fold(prims.reach, f32::max));
        self.unbounded = std::mem::take(&mut prims.unbounded);
        self.top = build_tree(prims, &self.geometry);
    }

    fn measure(&mut self, start: Instant) {
        let below = || self.groups.iter().chain([&self.static_tree]).map(|lower| &lower.tree);
        self.stats = BuildStats {
            build_time: start.elapsed(),
            node_count: self.top.nodes.len() + below().map(|tree| tree.nodes.len()).sum::<usize>(),
            bytes: self.top.bytes() + below().map(Bvh2Tree::bytes).sum::<usize>(),
            ..BuildStats::of(&self.geometry)
        };
    }

    /// Visits everything that `ray` may hit, on both levels. `test` is called with a primitive, its
    /// instance and the ray in their space.
    fn visit(
        &self,
        ray: &mut Ray,
        stacks: &mut Stacks,
        cost: &mut RayCost,
        mut test: impl FnMut(PrimId, InstanceId, &mut Ray) -> ControlFlow<()>,
    ) {
        let geometry = &*self.geometry;
        let Stacks { top, below } = stacks;
        let (mut nodes, mut nodes_below) = (0, 0);
        let planes = Planes::new(ray, self.padding);
        // `test` itself records whether it ended the traversal.
        _ = self.top.walk(ray, &planes, top, &mut nodes, |item, ray| {
            let mut prims = |tree: &Bvh2Tree, instance, ray: &mut Ray, planes: &Planes| {
                tree.walk(ray, planes, below, &mut nodes_below, |prim, ray| {
                    cost.prims += 1;
                    test(PrimId::new(prim), instance, ray)
                })
            };
            match Item::new(item, geometry) {
                Item::Prim(prim) => {
                    cost.prims += 1;
                    test(prim, InstanceId::NONE, ray)
                }
                Item::StaticTree => prims(&self.static_tree.tree, InstanceId::NONE, ray, &planes),
                Item::InstanceId(instance) => {
                    let placed = &geometry.instances[instance.0 as usize];
                    let mut local = geometry.enter(placed, ray);
                    let planes = Planes::new(&local, self.padding.inside());
                    let walk = prims(&self.groups[placed.group as usize].tree, instance, &mut local, &planes);
                    ray.tmax = local.tmax;
                    walk
                }
            }
        });
        cost.nodes += nodes + nodes_below;
    }

    fn nearest_hit(&self, ray: &Ray, stacks: &mut Stacks, cost: &mut RayCost) -> Option<Hit> {
        let (mut ray, mut hit) = (*ray, None);
        cost.prims += self.unbounded.len() as u32;
        self.geometry.keep_nearest_of(&self.unbounded, &mut ray, &mut hit);
        self.visit(&mut ray, stacks, cost, |prim, instance, ray| {
            self.geometry.keep_nearest(prim, instance, ray, &mut hit);
            ControlFlow::Continue(())
        });
        hit
    }
}

impl Accelerator for Bvh2 {
    fn nearest_batch(&self, batch: RayBatch<'_>, hits: &mut [Option<Hit>]) {
        let rays = batch.rays;
        let mut stacks = Stacks::default();
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.nearest_hit(ray, &mut stacks, &mut RayCost::default());
        }
    }

    fn occluded_batch(&self, batch: RayBatch<'_>, blocked: &mut [bool]) {
        let rays = batch.rays;
        let mut stacks = Stacks::default();
        for (ray, blocked) in rays.iter().zip(blocked) {
            let meets = |prim: PrimId, ray: &Ray| self.geometry.intersect(prim, ray).is_some();
            *blocked = self.unbounded.iter().any(|&prim| meets(prim, ray));
            if *blocked {
                continue;
            }
            self.visit(
                &mut ray.clone(),
                &mut stacks,
                &mut RayCost::default(),
                |prim, _, ray| {
                    *blocked = meets(prim, ray);
                    if *blocked {
                        ControlFlow::Break(())
                    } else {
                        ControlFlow::Continue(())
                    }
                },
            );
        }
    }

    fn cost(&self, rays: &[Ray], costs: &mut [RayCost]) {
        let mut stacks = Stacks::default();
        for (ray, cost) in rays.iter().zip(costs) {
            *cost = RayCost::default();
            self.nearest_hit(ray, &mut stacks, cost);
        }
    }

    fn update(&mut self, edit: &Edit) -> Result<UpdateReport, BuildError> {
        let start = Instant::now();
        let bounds: Vec<Aabb> = self.groups.iter().map(|group| group.bounds).collect();
        let changed = edit.apply(&mut self.geometry, &bounds)?;
        let mut updated = UpdateReport::default();
        // A single tree is split in two levels, so that later updates find moving and static
        // geometry in separate trees.
        let had_one_tree = self.groups.is_empty() && self.static_tree.bounds.is_empty();
        if changed.static_triangles || had_one_tree {
            self.build_still();
            updated.built.push(TreeId::Static);
        }
        for group in changed.groups {
            self.groups[group as usize] = self.group(group as usize);
            updated.built.push(TreeId::Group(group));
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
