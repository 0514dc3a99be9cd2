//! obvhs's compressed wide BVH in its own traversal order, for comparison.
//!
//! The node test is our own: that of obvhs has an absolute epsilon, and it misses boxes if a
//! component of the direction is -0. Boxes are quantised to 8 bits; the test adds what rounding may
//! have removed, see [`QUANTISATION`]. The stack grows, where obvhs's own stack of 32 entries would
//! drop subtrees.
//!
//! Source: Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed
//! Wide BVHs", 2017, <https://doi.org/10.1145/3105762.3105773>.

use glam::{UVec2, Vec3A};
use obvhs::{
    aabb::Aabb as Box3,
    bvh2::{Bvh2, node::Bvh2Node},
    cwbvh::{CwBvh as Nodes, bvh2_to_cwbvh::bvh2_to_cwbvh, node::CwBvhNode},
};
use std::ops::ControlFlow;

use super::{
    accelerator::Quality,
    build::{
        self,
        bvh2_tree::{self, FlatNode, Leaves},
        prims::Prims,
    },
    two_level::{self, BoxTree},
};
use crate::{
    geometry::{Geometry, slab::Planes},
    math::{Aabb, Ray, Vec3},
};

/// The amount by which quantisation may shrink a box, relative to the node's extent. obvhs rounds
/// the logarithm of the scale, with an error of at most 2^-18, and clamps what lies outside.
const QUANTISATION: f32 = 1.0 / 65_536.0;

/// The largest number of primitives in a leaf.
const MAX_LEAF: u32 = 3;

/// The accelerator.
pub(super) type CwBvh = two_level::TwoLevel<Compressed>;

/// obvhs's compressed 8-wide tree.
#[derive(Default)]
pub(super) struct Compressed {
    nodes: Nodes,
}

impl BoxTree for Compressed {
    type Stack = Stack;

    fn build(prims: Prims, geometry: &Geometry, quality: Quality) -> Self {
        let leaves = Leaves { triangles: 1 };
        let binary = build::build_tree(prims, geometry, quality, leaves);
        let nodes = binary.map_or_else(Nodes::default, |binary| {
            bvh2_to_cwbvh(&pair_up(binary), MAX_LEAF, true, false)
        });
        Self { nodes }
    }

    fn walk(
        &self,
        ray: &mut Ray,
        planes: &Planes,
        stack: &mut Stack,
        nodes: &mut u32,
        mut leaf: impl FnMut(u32, &mut Ray) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        if self.nodes.nodes.is_empty() {
            return ControlFlow::Continue(());
        }
        stack.0.clear();
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
        obvhs::traverse!(
            self.nodes,
            node,
            state,
            {
                *nodes += 1;
                hit_children(node, planes, ray, state.oct_inv4)
            },
            {
                let prim = self.nodes.primitive_indices[state.primitive_id as usize];
                leaf(prim, ray)?;
            }
        );
        ControlFlow::Continue(())
    }

    fn node_count(&self) -> usize {
        self.nodes.nodes.len()
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.nodes.nodes[..]) + size_of_val(&self.nodes.primitive_indices[..])
    }
}

/// Converts a tree to the layout of obvhs, with siblings adjacent.
fn pair_up(binary: bvh2_tree::Bvh2Tree) -> Bvh2 {
    let mut tree = Bvh2 {
        nodes: vec![Bvh2Node::default(); binary.nodes.len()],
        primitive_indices: binary.ids,
        ..Bvh2::default()
    };
    let mut next = 1;
    let mut open = vec![(0, 0)];
    while let Some((from, to)) = open.pop() {
        let FlatNode { bounds, link, count } = binary.nodes[from as usize];
        let first = if count == FlatNode::INNER { next } else { link };
        tree.nodes[to as usize] = Bvh2Node::new(Box3::new(bounds.min.into(), bounds.max.into()), count, first);
        if count == FlatNode::INNER {
            open.extend([(link, next + 1), (from + 1, next)]);
            next += 2;
        }
    }
    tree
}

/// The state of a ray for `traverse!`, with the names that the macro expects.
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
pub(super) struct Stack(Vec<UVec2>);

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

/// Returns the children of `node` that `ray` may hit, as the bits by which `traverse!` sorts its
/// groups.
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
