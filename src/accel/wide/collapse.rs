//! From two children to eight: which nodes of a binary tree become nodes and leaves of the wide one.
//!
//! A dynamic programme over the surface area heuristic finds, for each binary node and each `k` up to 7, the cheapest
//! way to stand for it with at most `k` wide children; a wide node is a binary one whose two sides share eight. All of
//! it lives in two arrays beside the nodes, from the leaves upwards: no allocation for a node.
//!
//! Source: Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017,
//! section 3.1, <https://doi.org/10.1145/3105762.3105773>.

use super::node::{FOR_PACKETS, MAX_LEAF, TriangleBlock, WideNode, inner, leaf, shape};
use crate::{
    accel::build::bvh2_tree::{Bvh2Tree, FlatNode},
    geometry::Geometry,
    math::trig,
};

/// What a block of four triangles costs, in tests of a node.
const BLOCK_COST: f32 = 0.85;

/// What an analytic primitive costs.
const SHAPE_COST: f32 = 1.0;

/// A wide tree, or a piece of one, with numbers of its own.
#[derive(Default)]
pub(super) struct TreePiece {
    pub nodes: Vec<WideNode>,
    pub blocks: Vec<TriangleBlock>,
    /// What stands for all of it: node 0 or a leaf.
    pub root: u32,
    pub cost: f32,
    /// Of everything in it, doubled where it is of triangles.
    pub surface: f32,
    /// Children that are other pieces: the node, its lane, and the piece's number.
    pub joints: Vec<(u32, u8, u32)>,
}

/// How a binary node is stood for.
#[derive(Clone, Copy)]
struct CollapsePlan {
    /// With at most so many wide children; at 0 what the eight children of a wide node cost.
    cost: [f32; 8],
    /// How many children of so many the first side gets, or one of the marks; at 0 of eight.
    first: [u8; 8],
    /// Triangles below; more than fit where there is anything else.
    triangles: u32,
    /// See [`TreePiece::surface`].
    surface: f32,
}

/// All of it in one leaf.
const AS_LEAF: u8 = 255;

/// With one child less.
const FEWER: u8 = 254;

/// More triangles than go into a leaf.
const TOO_MANY: u32 = 1 << 20;

/// What a leaf costs, infinite for one that cannot be.
fn leaf_cost(area: f32, triangles: u32) -> f32 {
    let blocks = triangles.div_ceil(4);
    if blocks as usize > MAX_LEAF {
        return f32::INFINITY;
    }
    area * BLOCK_COST * blocks as f32
}

fn plan(tree: &Bvh2Tree, geometry: &Geometry, piece_cost: impl Fn(u32) -> [f32; 2]) -> Vec<CollapsePlan> {
    let triangles = geometry.triangles.len() as u32;
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
        } else if tree.ids[node.link as usize] < triangles {
            let ids = &tree.ids[node.link as usize..][..node.count as usize];
            let surface = ids.iter().map(|&id| {
                let [a, b, c] = geometry.corners(id as usize);
                (b - a).cross(c - a).length()
            });
            leaf_plan(leaf_cost(area, node.count), node.count, surface.sum())
        } else {
            leaf_plan(area * SHAPE_COST, TOO_MANY, area)
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
    // The bits of floats that are not negative are ordered as they are, so the last three can carry a choice.
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

/// The wide tree over `tree`.
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
    /// Emits nodes, each before its children and sisters side by side.
    fn nodes(&mut self) {
        self.piece.nodes.push(WideNode::NOTHING);
        let mut open = vec![(0_usize, 0_usize)];
        while let Some((from, to)) = open.pop() {
            let mut children = [0; 8];
            let count = self.children(from, &mut children);
            let children = &mut children[..count];
            self.order_for_occlusion(children);
            let mut node = WideNode::NOTHING;
            self.order_for_packets(children, &mut node);
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

    /// Sorts children so that the one comes first which a ray that asks whether anything is in its way had best try first:
    /// that which blocks it with the greatest chance for what it costs to go through. Lanes have no other order.
    ///
    /// A line through a box goes through half as many layers of what is in it, on average, as that has surface for each half of the
    /// box's own (Cauchy); through layers at random it gets by the chance that the exponential tells. Twice as many layers are by trial.
    fn order_for_occlusion(&self, children: &mut [usize]) {
        let sorted = self.sorted(children, |surface, area| 1.0 - trig::exp(-surface / area));
        let mut before = [0; 8];
        before[..children.len()].copy_from_slice(children);
        for (child, place) in children.iter_mut().zip(sorted) {
            *child = before[place];
        }
    }

    /// The same for packets, which are done when all of their rays are blocked: so that large surfaces come sooner.
    ///
    /// After Nah and Manocha, "SATO: Surface Area Traversal Order for Shadow Ray Tracing", 2014,
    /// <https://doi.org/10.1111/cgf.12426>. The root and the cost are by trial: the surface alone sends rays into trees
    /// that take long.
    fn order_for_packets(&self, children: &[usize], node: &mut WideNode) {
        let lanes = self.sorted(children, |surface, _| surface.sqrt());
        for (order, lane) in node.order.iter_mut().zip(lanes) {
            *order = (lane as u32) << FOR_PACKETS;
        }
    }

    /// The places of children, that with the greatest `gain` for its cost first, and those of no children last.
    fn sorted(&self, children: &[usize], gain: impl Fn(f32, f32) -> f32) -> [usize; 8] {
        let mut promise = [0.0; 8];
        for (promise, &child) in promise.iter_mut().zip(children) {
            let CollapsePlan { surface, cost, .. } = &self.plans[child];
            let area = self.flat[child].bounds.half_area().max(f32::MIN_POSITIVE);
            *promise = gain(*surface, area) * area / cost[1].max(f32::MIN_POSITIVE);
        }
        let mut places = [0, 1, 2, 3, 4, 5, 6, 7];
        // Not a number where what is in a box is too large for one: any order will do.
        places[..children.len()].sort_by(|&a, &b| promise[b].total_cmp(&promise[a]));
        places
    }

    /// The binary nodes that become the children of the wide one at `from`; how many there are.
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

    /// Emits what is below `from` as a leaf.
    fn leaf(&mut self, from: usize) -> u32 {
        let mut node = from;
        while !self.flat[node].is_leaf() {
            node += 1;
        }
        let place = self.flat[node].link as usize;
        let id = self.ids[place];
        if id as usize >= self.geometry.triangles.len() {
            return shape(id);
        }
        // In depth-first order what the leaves below a node hold lies side by side.
        let mut ids = [0; 4 * MAX_LEAF];
        let mut count = 0;
        for &id in &self.ids[place..place + self.plans[from].triangles as usize] {
            if !ids[..count].contains(&id) {
                ids[count] = id;
                count += 1;
            }
        }
        let first = self.piece.blocks.len();
        for four in ids[..count].chunks(4) {
            let mut block = TriangleBlock::NOTHING;
            for (lane, &id) in four.iter().enumerate() {
                block.set(lane, self.geometry.corners(id as usize), id);
            }
            self.piece.blocks.push(block);
        }
        leaf(first, self.piece.blocks.len() - first)
    }
}

/// Sorts children for each octant of directions by how far along its diagonal their centres lie, the nearest first.
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
            // Ordered as the floats are, with the lane in the last bits.
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
        accel::{
            accelerator::Quality,
            build::{self, bvh2_tree, prims::Prims},
        },
        geometry::MAX_COORDINATE,
        math::{
            Aabb, Vec3,
            hash::{pcg4d, unit_f32},
        },
    };

    #[test]
    fn packets_come_to_every_child_also_where_surfaces_are_too_large_or_too_small_for_numbers() {
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
            let tree = build::build_tree(prims, &geometry, Quality::Medium, leaves).expect("there are triangles");
            let piece = collapse(&tree, &geometry, |_| [f32::INFINITY; 2]);
            assert!(piece.nodes.len() > 5);
            for node in &piece.nodes {
                let lanes = node.order.map(|order| order >> FOR_PACKETS);
                assert_eq!(lanes.iter().fold(0, |set, lane| set | 1 << lane), 0xff, "{lanes:?}");
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
