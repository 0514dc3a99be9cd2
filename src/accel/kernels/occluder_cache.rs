//! A cache of the last occluder, which resolves shadow rays without a traversal.
//!
//! A group of shadow rays with nearby origins may be unoccluded, as on a roof: then its bounds
//! ([`Shaft`]) hit no box. Or one leaf may block most of its rays, such as a ceiling under the sun.
//! Then the triangles of that leaf that the shaft intersects are tested with all rays, sixteen at a
//! time, and with the groups that follow. A group of which they block few searches for other
//! triangles.
//!
//! Trial groups of a batch show whether this pays off.

use super::{
    packet::order::PacketOrder,
    ray_state::BEYOND,
    ray16::{RAYS, Ray16},
    shaft::Shaft,
    slot_set::pop_lowest,
    tree::WideTree,
    triangle::{Vec3s, candidates, each, meet, plane, sides, spread, stretch_any},
};
use crate::{
    accel::wide::node::{EMPTY, LEAF, SHAPE, TriangleBlock},
    math::Ray,
    shape::triangle::Shear,
    simd::lanes::{Floats, Mask, SimdLevel},
};

/// The number of rays in a group.
const GROUP: usize = 4 * RAYS;

/// The number of trial groups of a batch.
const TRIAL_GROUPS: usize = 8;

/// The reciprocal of the smallest fraction of resolved rays that pays off. The other rays are
/// traced without packets, which takes as long as all rays would take in the best packets.
const MIN_ANSWERED: usize = 3;

/// The reciprocal of the smallest fraction of a group's rays that an occluder must block to be kept
/// for the next group.
const MIN_BLOCKED: u32 = 4;

/// The largest number of nodes that are visited for a group.
const MAX_NODES: usize = 8;

/// The number of triangles in a block.
const BLOCK_TRIANGLES: usize = 4;

/// The capacity of the stack: all children but one of each visited node, and the eight of the last
/// one.
const STACK: usize = 7 * MAX_NODES + 8;

struct OccluderSearch<'a> {
    tree: &'a WideTree,
    rays: &'a [Ray],
    shaft: Shaft,
    /// The occluder that blocked many rays of the last group.
    occluder: Option<Occluder>,
}

/// Some of the triangles of a leaf.
#[derive(Clone, Copy, PartialEq)]
struct Occluder {
    leaf: u32,
    /// The set of triangles, in the order of the leaf's blocks.
    triangles: u32,
}

/// The result of a shaft query.
enum ShaftQuery {
    Nothing,
    /// The first leaf with triangles that may block rays.
    Leaf(Occluder),
    Anything,
}

/// Resolves shadow rays if this pays off, and writes the indices of the unresolved ones to
/// `remaining`. Returns whether it pays off. If not, some rays may be resolved, and all must be
/// traced.
#[inline(always)]
pub fn trace<L: SimdLevel>(
    level: L,
    tree: &WideTree,
    rays: &[Ray],
    order: PacketOrder,
    blocked: &mut [bool],
    remaining: &mut Vec<u32>,
) -> bool {
    let count = rays.len();
    let groups = count / GROUP;
    if groups < 2 * TRIAL_GROUPS {
        return false;
    }
    let mut search = OccluderSearch {
        tree,
        rays,
        shaft: Shaft::default(),
        occluder: None,
    };
    remaining.clear();
    for k in 0..TRIAL_GROUPS {
        let group = k * (groups - 1) / (TRIAL_GROUPS - 1);
        search.resolve(level, &ids(order, group, count), blocked, remaining);
    }
    let resolved = TRIAL_GROUPS * GROUP - remaining.len();
    remaining.clear();
    let pays = resolved * MIN_ANSWERED >= TRIAL_GROUPS * GROUP;
    if pays {
        for group in 0..groups {
            search.resolve(level, &ids(order, group, count), blocked, remaining);
        }
        for packet in groups * GROUP / RAYS..count.div_ceil(RAYS) {
            remaining.extend(order.list(packet, count).as_slice());
        }
    }
    pays
}

/// Returns the rays of a full group in a batch of `count` rays.
#[inline(always)]
fn ids(order: PacketOrder, group: usize, count: usize) -> [u32; GROUP] {
    let mut ids = [0; GROUP];
    for (packet, ids) in (group * GROUP / RAYS..).zip(ids.as_chunks_mut().0) {
        *ids = order.list(packet, count).ids;
    }
    ids
}

impl OccluderSearch<'_> {
    /// Resolves the rays of a group, and adds the unresolved ones to `left`.
    #[inline(always)]
    fn resolve<L: SimdLevel>(&mut self, level: L, ids: &[u32; GROUP], blocked: &mut [bool], left: &mut Vec<u32>) {
        let before = left.len();
        let tested = self.occluder.take();
        if let Some(occluder) = tested
            && self.test(level, occluder, ids, blocked, left)
        {
            return;
        }
        let found = if self.shaft.enclose(level, self.rays, ids, self.tree.padding.reach) {
            self.query_shaft(level)
        } else {
            ShaftQuery::Anything
        };
        match found {
            ShaftQuery::Nothing => left.truncate(before),
            ShaftQuery::Leaf(occluder) if Some(occluder) != tested => {
                left.truncate(before);
                self.test(level, occluder, ids, blocked, left);
            }
            _ if tested.is_none() => left.extend(ids),
            _ => {}
        }
    }

    /// Tests these triangles with all rays of a group, and adds the rays that they do not block to
    /// `left`. Returns whether they block many rays; then they are kept for the next group.
    #[inline(always)]
    fn test<L: SimdLevel>(
        &mut self,
        level: L,
        occluder: Occluder,
        ids: &[u32; GROUP],
        blocked: &mut [bool],
        left: &mut Vec<u32>,
    ) -> bool {
        // SAFETY: this is a leaf of this tree.
        let blocks = unsafe { self.tree.leaf(occluder.leaf) };
        let (mut rest, mut count) = ([0; GROUP], 0);
        for ids in ids.as_chunks::<RAYS>().0 {
            let lanes = blocked_by(
                level,
                blocks,
                occluder.triangles,
                self.rays,
                ids,
                self.tree.padding.reach,
            );
            for (lane, &id) in ids.iter().enumerate() {
                let is_blocked = lanes >> lane & 1 == 1;
                blocked[id as usize] |= is_blocked;
                rest[count % GROUP] = id;
                count += usize::from(!is_blocked);
            }
        }
        left.extend_from_slice(&rest[..count]);
        let many = (GROUP - count) as u32 * MIN_BLOCKED >= GROUP as u32;
        self.occluder = many.then_some(occluder);
        many
    }

    /// Finds what the shaft intersects, in the order of the nodes' lanes.
    #[inline(always)]
    fn query_shaft<L: SimdLevel>(&self, level: L) -> ShaftQuery {
        let mut stack = [0; STACK];
        stack[0] = self.tree.root();
        let (mut count, mut nodes) = (1, 0);
        while count > 0 {
            count -= 1;
            let child = stack[count];
            if child & LEAF == 0 {
                if nodes == MAX_NODES {
                    return ShaftQuery::Anything;
                }
                nodes += 1;
                // SAFETY: this is the root or an inner child.
                let node = unsafe { self.tree.node(child) };
                let mut met = self.shaft.intersect_node(level, node).bits();
                while met != 0 {
                    let lane = met.ilog2();
                    met ^= 1 << lane;
                    stack[count] = node.child[lane as usize];
                    count += 1;
                }
            } else if child & SHAPE == 0 {
                // SAFETY: this is a leaf with triangles.
                let blocks = unsafe { self.tree.leaf(child) };
                let mut triangles = 0;
                for (i, block) in blocks.iter().enumerate() {
                    triangles |= self.shaft.possible_occluders(level, block) << (BLOCK_TRIANGLES * i);
                }
                if triangles != 0 {
                    return ShaftQuery::Leaf(Occluder { leaf: child, triangles });
                }
            } else if child != EMPTY {
                return ShaftQuery::Anything;
            }
        }
        ShaftQuery::Nothing
    }
}

/// Returns the set of rays that these triangles of the blocks block.
#[inline(always)]
fn blocked_by<L: SimdLevel>(
    level: L,
    blocks: &[TriangleBlock],
    triangles: u32,
    rays: &[Ray],
    ids: &[u32; RAYS],
    reach: f32,
) -> u32 {
    let sixteen = Ray16::load(level, rays, ids);
    let sorted = sixteen.sort(reach);
    let Ray16 { o, d, inv, tmin, tmax } = sixteen;
    let asked = level.mask16(sorted.ordinary & sorted.along);
    let [x, y, z] = Shear::new(&rays[ids[sorted.leader] as usize].d).axes;
    let permute_axes = |v: &Vec3s<L::F16>| [v[x], v[y], v[z]];
    let (turned_o, turned_d) = (permute_axes(&o), permute_axes(&d));
    let shear = [turned_d[0].mul(inv[z]), turned_d[1].mul(inv[z])];
    let begin = tmin.mul(level.splat16(1.0 - BEYOND));
    let until = tmax.add(tmax.abs().mul(level.splat16(BEYOND)));
    let mut blocked = 0;
    let mut triangles = u64::from(triangles);
    while triangles != 0 && blocked != asked.bits() {
        let triangle = pop_lowest(&mut triangles);
        let (block, k) = (&blocks[triangle / BLOCK_TRIANGLES], triangle % BLOCK_TRIANGLES);
        let [a, b, c] = block.corners.each_ref();
        let world = [
            spread(level, a.each_ref(), k),
            spread(level, b.each_ref(), k),
            spread(level, c.each_ref(), k),
        ];
        let [a, b, c] = &world;
        let corners = [
            each(permute_axes(a), turned_o, L::F16::sub),
            each(permute_axes(b), turned_o, L::F16::sub),
            each(permute_axes(c), turned_o, L::F16::sub),
        ];
        let sides = sides(&corners, shear);
        if sides.inside.and(asked).bits() & !blocked == 0 {
            continue;
        }
        let candidates = candidates(turned_d, &plane(&corners), sides, begin, until);
        let meets = meet(stretch_any(&o, &inv, &world), &candidates.crossing);
        let is_between = tmin.lt(meets.t).and(meets.t.le(tmax));
        blocked |= candidates.mask.and(meets.valid).and(is_between).and(asked).bits();
    }
    blocked
}
