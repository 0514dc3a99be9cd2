//! obvhs's compressed wide tree in its own traversal order, for comparison.
//!
//! The node test is ours: obvhs's has an absolute epsilon, and misses where a direction is -0. The boxes are quantised
//! to 8 bits; what their rounding may lose is added back, see [`QUANTISATION`]. The stack grows, where
//! obvhs's own of 32 entries would drop subtrees.
//!
//! Source: Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017,
//! <https://doi.org/10.1145/3105762.3105773>.

use std::{sync::Arc, time::Instant};

use glam::{UVec2, Vec3A};
use obvhs::cwbvh::{CwBvh as Tree, bvh2_to_cwbvh::bvh2_to_cwbvh, node::CwBvhNode};

use super::{
    Accelerator, BuildError, BuildStats, Geometry, Hit, PrimRef, Quality, RayCost, binary, nearest_unbounded,
    prims::Prims, slab::Planes,
};
use crate::math::{Aabb, Ray, Vec3};

/// What quantising may take off a box, relative to the node's extent: obvhs rounds the scale's logarithm, which is
/// wrong by at most 2^-18, and clamps what sticks out.
const QUANTISATION: f32 = 1.0 / 65_536.0;

/// obvhs's compressed 8-wide tree.
pub struct CwBvh {
    geometry: Arc<Geometry>,
    tree: Tree,
    ids: Vec<u32>,
    unbounded: Vec<PrimRef>,
    reach: f32,
    stats: BuildStats,
}

impl CwBvh {
    pub fn build(geometry: Arc<Geometry>, quality: Quality) -> Result<Self, BuildError> {
        let start = Instant::now();
        let prims = Prims::new(&geometry)?;
        let tree = binary::build(&prims, quality).map_or_else(Tree::default, |mut tree| {
            binary::refit(&mut tree, &prims.boxes);
            bvh2_to_cwbvh(&tree, 3, true, false)
        });
        let stats = BuildStats {
            build_time: start.elapsed(),
            node_count: tree.nodes.len(),
            bytes: size_of_val(&tree.nodes[..])
                + size_of_val(&tree.primitive_indices[..])
                + size_of_val(&prims.ids[..]),
            prims: geometry.prim_count(),
        };
        Ok(Self {
            geometry,
            tree,
            ids: prims.ids,
            unbounded: prims.unbounded,
            reach: prims.reach,
            stats,
        })
    }

    /// Calls `leaf` with the primitives that `ray` may meet until it returns `false`.
    fn walk(
        &self,
        ray: &mut Ray,
        stack: &mut Stack,
        cost: &mut RayCost,
        mut leaf: impl FnMut(PrimRef, &mut Ray) -> bool,
    ) {
        if self.tree.nodes.is_empty() {
            return;
        }
        stack.0.clear();
        let planes = Planes::new(ray, self.reach);
        let octant = |negative: bool, bit: u32| if negative { 0 } else { bit * 0x0101_0101 };
        let mut state = State {
            stack,
            current_group: UVec2::new(0, 0x8000_0000),
            primitive_group: UVec2::ZERO,
            oct_inv4: octant(planes.negative[0], 4) | octant(planes.negative[1], 2) | octant(planes.negative[2], 1),
            primitive_id: 0,
            hitmask: 0,
        };
        let mut node;
        'traversal: {
            obvhs::traverse!(
                self.tree,
                node,
                state,
                {
                    cost.nodes += 1;
                    hit_children(node, &planes, ray, state.oct_inv4)
                },
                {
                    cost.prims += 1;
                    let prim = self.tree.primitive_indices[state.primitive_id as usize];
                    if !leaf(PrimRef::new(self.ids[prim as usize]), ray) {
                        break 'traversal;
                    }
                }
            );
        }
    }
}

/// What `traverse!` keeps of a ray, with the names it expects.
struct State<'a> {
    stack: &'a mut Stack,
    current_group: UVec2,
    primitive_group: UVec2,
    oct_inv4: u32,
    primitive_id: u32,
    hitmask: u32,
}

/// A stack that grows.
#[derive(Default)]
struct Stack(Vec<UVec2>);

impl Stack {
    fn push(&mut self, v: UVec2) {
        self.0.push(v);
    }

    fn pop_fast(&mut self) -> UVec2 {
        self.0.pop().unwrap_or_default()
    }

    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// The children of `node` that `ray` may meet, as the bits that `traverse!` sorts its groups by.
fn hit_children(node: &CwBvhNode, planes: &Planes, ray: &Ray, oct_inv4: u32) -> u32 {
    let extent = node.compute_extent();
    let origin = Vec3A::from(node.p);
    let lost = extent * (255.0 * QUANTISATION) + origin.abs() * (4.0 * f32::EPSILON);
    let (child_bits, bit_index) = node.get_child_and_index_bits(oct_inv4);
    let mut mask = 0;
    for child in 0..8 {
        let bits = (child_bits >> (8 * child)) as u32 & 0xff;
        if bits == 0 {
            continue;
        }
        let quantised = node.local_child_aabb(child);
        let bounds = Aabb {
            min: Vec3::from(quantised.min * extent + origin - lost),
            max: Vec3::from(quantised.max * extent + origin + lost),
        };
        if planes.enter(&bounds, ray.tmin, ray.tmax).is_some() {
            mask |= bits << ((bit_index >> (8 * child)) as u32 & 0xff);
        }
    }
    mask
}

impl Accelerator for CwBvh {
    fn nearest(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        let mut stack = Stack::default();
        for (ray, hit) in rays.iter().zip(hits) {
            let mut ray = *ray;
            *hit = None;
            nearest_unbounded(&self.geometry, &self.unbounded, &mut ray, hit);
            self.walk(&mut ray, &mut stack, &mut RayCost::default(), |prim, ray| {
                self.geometry.keep_nearest(prim, ray, hit);
                true
            });
        }
    }

    fn occluded(&self, rays: &[Ray], blocked: &mut [bool]) {
        let mut stack = Stack::default();
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = self
                .unbounded
                .iter()
                .any(|&p| self.geometry.intersect(p, ray).is_some());
            if *blocked {
                continue;
            }
            self.walk(&mut ray.clone(), &mut stack, &mut RayCost::default(), |prim, ray| {
                *blocked = self.geometry.intersect(prim, ray).is_some();
                !*blocked
            });
        }
    }

    fn cost(&self, rays: &[Ray], costs: &mut [RayCost]) {
        let mut stack = Stack::default();
        for (ray, cost) in rays.iter().zip(costs) {
            let (mut ray, mut hit) = (*ray, None);
            *cost = RayCost {
                nodes: 0,
                prims: self.unbounded.len() as u32,
            };
            nearest_unbounded(&self.geometry, &self.unbounded, &mut ray, &mut hit);
            self.walk(&mut ray, &mut stack, cost, |prim, ray| {
                self.geometry.keep_nearest(prim, ray, &mut hit);
                true
            });
        }
    }

    fn stats(&self) -> BuildStats {
        self.stats
    }

    fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }
}
