//! Collapses a binary BVH into an eight-wide one.
//!
//! For each binary node and each `k` up to 7, dynamic programming finds the cheapest way to
//! represent the node with at most `k` wide children, by the surface area heuristic. A wide node is
//! a binary node whose two sides share eight children. The tables are two arrays parallel to the
//! nodes and are filled from the leaves upwards, without an allocation per node.
//!
//! Source: Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017,
//! section 3.1, <https://doi.org/10.1145/3105762.3105773>.

use super::node::{MAX_LEAF, TriangleBlock, WideNode, inner, leaf, shape};
use crate::{
    accel::build::bvh2_tree::{Bvh2Tree, FlatNode},
    geometry::{Geometry, PrimId},
    math::exponential,
};

/// The cost of a block of four triangles, in node tests.
const BLOCK_COST: f32 = 0.85;

/// The cost of an analytic primitive, in node tests.
const SHAPE_COST: f32 = 1.0;

/// A wide tree or a piece of one, with its own indices.
#[derive(Default)]
pub(super) struct TreePiece {
    pub nodes: Vec<WideNode>,
    pub blocks: Vec<TriangleBlock>,
    /// The child that refers to the whole piece: node 0 or a leaf.
    pub root: u32,
    pub cost: f32,
    /// The surface area of the contents; that of triangles counts twice, for both sides.
    pub surface: f32,
    /// Children that are other pieces: the node, its lane and the piece's index.
    pub joints: Vec<(u32, u8, u32)>,
}

/// The best ways to represent a binary node.
#[derive(Clone, Copy)]
struct CollapsePlan {
    /// `cost[k]` is the cost with at most `k` wide children; `cost[0]` that of a wide node's eight
    /// children.
    cost: [f32; 8],
    /// `first[k]` is the number of those `k` children that go to the first side, or a mark;
    /// `first[0]` is for eight.
    first: [u8; 8],
    /// The number of triangles below, or [`TOO_MANY`] if there is any other primitive.
    triangles: u32,
    /// See [`TreePiece::surface`].
    surface: f32,
}

/// Mark: the whole subtree is one leaf.
const AS_LEAF: u8 = 255;

/// Mark: the solution is that with one child less.
const FEWER: u8 = 254;

/// More triangles than fit into a leaf.
const TOO_MANY: u32 = 1 << 20;

/// Returns the cost of a leaf, infinite if the leaf is not possible.
fn leaf_cost(area: f32, triangles: u32) -> f32 {
    let blocks = triangles.div_ceil(4);
    if blocks as usize > MAX_LEAF {
        return f32::INFINITY;
    }
    area * BLOCK_COST * blocks as f32
}

fn plan(tree: &Bvh2Tree, geometry: &Geometry, piece_cost: impl Fn(u32) -> [f32; 2]) -> Vec<CollapsePlan> {
    let flat = &tree.nodes;
    let empty = CollapsePlan {
        cost: [0.0; 8],
        first: [0; 8],
        triangles: 0,
        surface: 0.0,
    };
    let mut plans = vec![empty; flat.len()];
    for i in (0..flat.len()).rev() {
        let node = &flat[i];
        let area = node.bounds.half_area();
        plans[i] = if !node.is_leaf() {
            inner_plan(area, &plans[i + 1], &plans[node.link as usize])
        } else if node.count == FlatNode::PIECE {
            let [cost, surface] = piece_cost(node.link);
            leaf_plan(cost, TOO_MANY, surface)
        } else {
            let ids = &tree.ids[node.link as usize..][..node.count as usize];
            let (mut count, mut surface) = (0, 0.0);
            for (_, [a, b, c]) in ids.iter().flat_map(|&id| geometry.triangles_of(PrimId::new(id))) {
                count += 1;
                surface += (b - a).cross(c - a).length();
            }
            if count > 0 {
                leaf_plan(leaf_cost(area, count), count, surface)
            } else {
                leaf_plan(area * SHAPE_COST, TOO_MANY, area)
            }
        };
    }
    plans
}

fn leaf_plan(cost: f32, triangles: u32, surface: f32) -> CollapsePlan {
    CollapsePlan {
        cost: [cost; 8],
        first: [AS_LEAF; 8],
        triangles,
        surface,
    }
}

fn inner_plan(area: f32, a: &CollapsePlan, b: &CollapsePlan) -> CollapsePlan {
    // The bits of non-negative floats sort like the floats, so the lowest three bits can hold the
    // choice.
    let mut best = [u32::MAX; 9];
    for i in 1..8 {
        for j in 1..=(8 - i).min(7) {
            let key = ((a.cost[i] + b.cost[j]).to_bits() & !7) | i as u32;
            best[i + j] = best[i + j].min(key);
        }
    }
    let triangles = (a.triangles + b.triangles).min(TOO_MANY);
    let mut plan = CollapsePlan {
        cost: [0.0; 8],
        first: [FEWER; 8],
        triangles,
        surface: a.surface + b.surface,
    };
    (plan.cost[0], plan.first[0]) = (f32::from_bits(best[8] & !7), (best[8] & 7) as u8);
    let (as_node, as_leaf) = (area + plan.cost[0], leaf_cost(area, triangles));
    (plan.cost[1], plan.first[1]) = if as_leaf <= as_node {
        (as_leaf, AS_LEAF)
    } else {
        (as_node, 0)
    };
    for (k, &key) in best.iter().enumerate().take(8).skip(2) {
        let cost = f32::from_bits(key & !7);
        if cost < plan.cost[k - 1] {
            (plan.cost[k], plan.first[k]) = (cost, (key & 7) as u8);
        } else {
            plan.cost[k] = plan.cost[k - 1];
        }
    }
    plan
}

/// Collapses `tree` into a wide tree.
pub(super) fn collapse(tree: &Bvh2Tree, geometry: &Geometry, piece_cost: impl Fn(u32) -> [f32; 2]) -> TreePiece {
    let flat = &tree.nodes[..];
    let plans = plan(tree, geometry, piece_cost);
    let mut emitter = Emitter {
        flat,
        ids: &tree.ids,
        plans: &plans,
        geometry,
        piece: TreePiece {
            nodes: Vec::with_capacity(tree.ids.len() / 16 + 1),
            blocks: Vec::with_capacity(tree.ids.len() / 3 + 1),
            cost: plans[0].cost[1],
            surface: plans[0].surface,
            ..TreePiece::default()
        },
    };
    if plans[0].first[1] == AS_LEAF {
        emitter.piece.root = emitter.leaf(0);
    } else {
        emitter.nodes();
    }
    emitter.piece
}

struct Emitter<'a> {
    flat: &'a [FlatNode],
    ids: &'a [u32],
    plans: &'a [CollapsePlan],
    geometry: &'a Geometry,
    piece: TreePiece,
}

impl Emitter<'_> {
    /// Emits the nodes, each before its children, with siblings adjacent.
    fn nodes(&mut self) {
        self.piece.nodes.push(WideNode::NOTHING);
        let mut open = vec![(0_usize, 0_usize)];
        while let Some((from, to)) = open.pop() {
            let mut children = [0; 8];
            let count = self.children(from, &mut children);
            let children = &mut children[..count];
            self.order_for_occlusion(children);
            let mut node = WideNode::NOTHING;
            let first_inner = open.len();
            for (lane, &child) in children.iter().enumerate() {
                let FlatNode { bounds, link, count } = self.flat[child];
                let number = if count == FlatNode::PIECE {
                    self.piece.joints.push((to as u32, lane as u8, link));
                    0
                } else if self.plans[child].first[1] == AS_LEAF {
                    self.leaf(child)
                } else {
                    open.push((child, self.piece.nodes.len()));
                    self.piece.nodes.push(WideNode::NOTHING);
                    inner(self.piece.nodes.len() - 1)
                };
                node.set(lane, &bounds, number);
            }
            open[first_inner..].reverse();
            order_children(&mut node, count);
            self.piece.nodes[to] = node;
        }
    }

    /// Sorts children for shadow rays: by the probability of blocking the ray, divided by
    /// the cost of traversal. The lanes are in this order.
    ///
    /// On average, a line through a box crosses half as many layers of its contents as the ratio of
    /// their surface area to half the area of the box (Cauchy's formula). It passes randomly placed
    /// layers with an exponentially falling probability. The factor of two for the layers was found
    /// by experiment.
    fn order_for_occlusion(&self, children: &mut [usize]) {
        let mut promise = [0.0; 8];
        for (promise, &child) in promise.iter_mut().zip(&*children) {
            let CollapsePlan { surface, cost, .. } = &self.plans[child];
            let area = self.flat[child].bounds.half_area().max(f32::MIN_POSITIVE);
            let blocks = 1.0 - exponential::exp(-surface / area);
            *promise = blocks * area / cost[1].max(f32::MIN_POSITIVE);
        }
        let mut places = [0, 1, 2, 3, 4, 5, 6, 7];
        // NaN if the contents of a box overflow; any order is correct then.
        places[..children.len()].sort_by(|&a, &b| promise[b].total_cmp(&promise[a]));
        let mut before = [0; 8];
        before[..children.len()].copy_from_slice(children);
        for (child, place) in children.iter_mut().zip(places) {
            *child = before[place];
        }
    }

    /// Finds the binary nodes that become the children of the wide node at `from`, and returns
    /// their number.
    fn children(&self, from: usize, children: &mut [usize; 8]) -> usize {
        let mut count = 0;
        let first = self.plans[from].first[0];
        let mut open = [(0, 0); 8];
        open[0] = (self.flat[from].link as usize, 8 - first);
        open[1] = (from + 1, first);
        let mut waiting = 2;
        while waiting > 0 {
            waiting -= 1;
            let (node, mut k) = open[waiting];
            while self.plans[node].first[usize::from(k)] == FEWER {
                k -= 1;
            }
            if k == 1 || self.flat[node].is_leaf() {
                children[count] = node;
                count += 1;
            } else {
                let first = self.plans[node].first[usize::from(k)];
                open[waiting] = (self.flat[node].link as usize, k - first);
                open[waiting + 1] = (node + 1, first);
                waiting += 2;
            }
        }
        count
    }

    /// Emits the subtree at `from` as a leaf.
    fn leaf(&mut self, from: usize) -> u32 {
        let mut node = from;
        while !self.flat[node].is_leaf() {
            node += 1;
        }
        let place = self.flat[node].link as usize;
        let count = self.plans[from].triangles;
        if count == TOO_MANY {
            return shape(self.ids[place]);
        }
        // In depth-first order, the primitives of a node's leaves are contiguous.
        let prims = self.ids[place..].iter().map(|&id| PrimId::new(id));
        let first = self.piece.blocks.len();
        let triangles = prims.flat_map(|prim| self.geometry.triangles_of(prim));
        for (at, (key, corners)) in triangles.take(count as usize).enumerate() {
            if at % 4 == 0 {
                self.piece.blocks.push(TriangleBlock::NOTHING);
            }
            let block = self.piece.blocks.last_mut().expect("one was pushed");
            block.set(at % 4, corners, key);
        }
        leaf(first, self.piece.blocks.len() - first)
    }
}

/// Sorts the children for each octant of directions, front to back, by the projection of their
/// centres on its diagonal.
pub(super) fn order_children(node: &mut WideNode, count: usize) {
    let mut centers = [[0.0_f32; 3]; 8];
    for (lane, center) in centers[..count].iter_mut().enumerate() {
        *center = (node.bounds(lane).center()).to_array();
    }
    for octant in 0..4_u32 {
        let mut keys = [0_u32; 8];
        for (lane, key) in keys.iter_mut().enumerate() {
            let [x, y, z] = centers[lane];
            let along = if octant & 1 == 0 { x } else { -x } + if octant & 2 == 0 { y } else { -y } + z;
            // The keys sort like the floats, with the lane in the lowest bits.
            let bits = along.to_bits();
            let ordered = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
            *key = (ordered & !7) | lane as u32;
        }
        keys.sort_unstable();
        for (place, key) in keys.iter().enumerate() {
            let lane = key & 7;
            node.order[place] |= lane << (3 * octant);
            node.order[7 - place] |= lane << (3 * (7 - octant));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        accel::build::{self, bvh2_tree, prims::Prims},
        geometry::MAX_COORDINATE,
        math::{
            Aabb, Vec3,
            hash::{pcg4d, unit_f32},
        },
    };

    #[test]
    fn rays_come_to_every_child_also_where_surfaces_are_too_large_or_too_small_for_numbers() {
        for size in [1.0, 1e-25, MAX_COORDINATE] {
            let corner = |i: u32| {
                let [x, y, z, _] = pcg4d([i, i / 3, 5, 7]).map(unit_f32);
                (Vec3::new(x, y, z) - 0.5) * size
            };
            let geometry = Geometry {
                vertices: (0..600).map(corner).collect(),
                triangles: (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
                ..Geometry::default()
            };
            let prims = Prims::whole(&geometry).expect("all is finite");
            let leaves = bvh2_tree::Leaves { triangles: 2 };
            let tree = build::build_tree(prims, &geometry, leaves).expect("there are triangles");
            let piece = collapse(&tree, &geometry, |_| [f32::INFINITY; 2]);
            assert!(piece.nodes.len() > 5);
            for node in &piece.nodes {
                for octant in 0..8 {
                    let lanes = node.order.map(|order| order >> (3 * octant) & 7);
                    assert_eq!(lanes.iter().fold(0, |set, lane| set | 1 << lane), 0xff, "{lanes:?}");
                }
            }
        }
    }

    #[test]
    fn children_come_nearest_first_in_every_octant() {
        let mut node = WideNode::NOTHING;
        for lane in 0..8 {
            let p = Vec3::new(
                lane as f32 * 0.37 % 1.0,
                lane as f32 * 0.61 % 1.0,
                lane as f32 * 0.83 % 1.0,
            );
            node.set(lane, &Aabb { min: p, max: p + 0.1 }, 0);
        }
        order_children(&mut node, 8);
        for octant in 0..8 {
            let sign = |axis: u32| if octant >> axis & 1 == 1 { -1.0 } else { 1.0 };
            let d = Vec3::new(sign(0), sign(1), sign(2));
            let along: Vec<f32> = (0..8)
                .map(|place| {
                    node.bounds((node.order[place] >> (3 * octant) & 7) as usize)
                        .center()
                        .dot(d)
                })
                .collect();
            assert!(along.is_sorted_by(|a, b| *a <= *b + 1e-5), "{octant}: {along:?}");
        }
    }
}
