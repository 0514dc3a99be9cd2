//! The packet kernel, for coherent rays such as camera rays: packets of sixteen rays, several of
//! which are active at once.
//!
//! A node's boxes are tested once per packet, against the bounds of its rays ([`rays::Packet`]).
//! This takes as long as the test of a single ray. So packets traverse the tree as the rays of
//! [`super::ray_stream`] do, in branch-free passes that hide each other's latency. Leaves are
//! processed in passes as well: four triangles are culled at a time against the bounds of the
//! packet, and each triangle that remains is tested against sixteen lines. If few of these
//! intersect it, the rays are tested on their own ([`leaf`], [`singles`]).
//!
//! Shadow rays are first reordered by their origins ([`group`]), since the coherence of a tile is
//! lost once some of its paths have ended.
//!
//! A packet's rays have the same octant and the same main axis. Rays that match too few others,
//! that have a component close to zero or a negative `tmin` are left to the stream kernel.

use super::{
    query::Query,
    scratch::Scratch,
    slot_set::pop_lowest,
    traversal::{self, Active, Traverser},
    traversal_state::TraversalState,
    tree::WideTree,
};
use crate::{
    accel::wide::node::{DONE, EMPTY, SHAPE, WideNode, count, number},
    geometry::Geometry,
    math::Ray,
    simd::lanes::SimdLevel,
};
use group::{BAND, group};
use leaf::PacketLeafQueue;
use order::PacketRays;
use rays::{Gathered, PACKETS};
use shape::shape_step;

mod edges;
mod group;
mod leaf;
pub mod order;
pub mod rays;
mod shape;
mod singles;

use super::ray16::RAYS;
use order::PacketOrder;
use rays::Packet;

/// The smallest number of rays for which a packet is faster than single rays.
const MIN_PACKET_RAYS: u32 = 4;

/// The number of packets by which prefetching runs ahead.
const PREFETCH_DISTANCE: usize = 4;

/// The number of occlusion packets after which it is known whether packets pay off. Until then, at
/// most this many are active.
const TRIAL_PACKETS: u64 = 8;

/// The largest average cost of an occlusion packet, in halves of the cost of a single ray, for
/// which packets are faster. Packets that were abandoned count as well. With vectors of sixteen
/// floats, packets are faster.
const PACKET_COST_LIMIT: u64 = 11;
const PACKET_COST_LIMIT_16: u64 = 13;

/// The number of packets' worth of cost that a batch may lose before its other rays are traced
/// without packets. Expensive packets are adjacent, so the first few are not representative.
const MAX_LOST_PACKETS: u64 = 32;

/// The smallest average cost of packets for which reordering the rays pays off: five nanoseconds
/// per ray, which is half of the time of a ray in an empty room.
const MIN_COST_TO_REORDER: u64 = 40;

/// The cost at which a packet is abandoned.
const MAX_PACKET_COST: u32 = 300;

/// The cost of a block of triangles, in node tests.
const BLOCK_COST: u32 = 6;

/// The packets that have not started yet.
struct PacketQueue<'a> {
    rays: &'a [Ray],
    order: PacketOrder,
    upcoming: usize,
    /// The other rays of a list that was split, since not all of them go into one packet.
    rest: Option<PacketRays>,
    /// The rays of four packets, if they were reordered.
    band: [u32; BAND],
    is_grouped: bool,
    reach: f32,
    left: &'a mut Vec<u32>,
    /// The largest cost of a packet that pays off.
    cost_limit: u64,
    /// The number of finished packets and their total cost.
    done: u64,
    cost: u64,
}

impl PacketQueue<'_> {
    #[inline(always)]
    fn next<L: SimdLevel, Q: Query>(&mut self, level: L) -> Option<PacketRays> {
        if let Some(rest) = self.rest.take() {
            return Some(rest);
        }
        let (packet, count) = (self.upcoming, self.rays.len());
        if packet * RAYS >= count {
            return None;
        }
        self.upcoming += 1;
        // The rays of a block are not contiguous, so the hardware prefetcher does not help.
        let soon = self.order.list(packet + PREFETCH_DISTANCE, count);
        for id in soon.ids.into_iter().step_by(2) {
            level.prefetch::<1>(self.rays.as_ptr().wrapping_add(id as usize).cast());
        }
        let first = packet & !3;
        if packet == first {
            let worth = self.cost >= MIN_COST_TO_REORDER * self.done && self.pays();
            self.is_grouped = Q::ANY && worth && first * RAYS + BAND <= count;
        }
        if !self.is_grouped {
            return Some(self.order.list(packet, count));
        }
        if packet == first {
            let mut ids = [0; BAND];
            for (k, ids) in ids.as_chunks_mut::<RAYS>().0.iter_mut().enumerate() {
                *ids = self.order.list(first + k, count).ids;
            }
            self.band = group(level, self.rays, &ids);
        }
        let ids = self.band.as_chunks().0[packet - first];
        Some(PacketRays { ids, len: RAYS })
    }

    /// Returns the set of packets that may be active. For occlusion there are few until it is known
    /// whether packets pay off. If the origins are spread over a surface, there may be so much
    /// geometry around them that packets are slower than single rays.
    fn allowed_packets<Q: Query>(&self) -> u64 {
        let few = Q::ANY && self.done < TRIAL_PACKETS;
        u64::MAX >> (64 - if few { TRIAL_PACKETS as usize } else { PACKETS })
    }

    fn pays(&self) -> bool {
        self.cost <= self.cost_limit * (self.done + MAX_LOST_PACKETS)
    }

    /// Records a finished packet.
    fn record(&mut self, packet: &Packet) {
        self.cost += u64::from(packet.cost);
        self.done += 1;
        if packet.cost > MAX_PACKET_COST {
            // Its rays start again, each on its own.
            self.cost += self.cost_limit;
            self.left.extend(packet.rays().map(|(_, id)| id));
        }
    }

    /// Fills `packet` with the next rays. Returns whether there are any.
    #[inline(always)]
    fn refill<L: SimdLevel, Q: Query>(&mut self, level: L, packet: &mut Packet, answers: &[Q::Answer]) -> bool {
        if Q::ANY && !self.pays() {
            while let Some(list) = self.next::<L, Q>(level) {
                self.left.extend(list.as_slice());
            }
        }
        let mut next = self.next::<L, Q>(level);
        while let Some(list) = next {
            next = match packet.gather::<L, Q>(level, self.rays, &list, answers, self.reach) {
                Gathered::All => return true,
                Gathered::Some { together, alone } => {
                    self.split(&list, together, alone).or_else(|| self.next::<L, Q>(level))
                }
            };
        }
        false
    }

    /// Splits a list whose rays do not all go into one packet. Returns the rays that do, if there
    /// are enough of them.
    #[cold]
    #[inline(never)]
    fn split(&mut self, list: &PacketRays, together: u32, mut alone: u32) -> Option<PacketRays> {
        let others = list.lanes() & !(together | alone);
        // The coherent rays may still have distant origins, so the rest of an earlier list must not
        // be overwritten.
        if others != 0 {
            self.rest = Some(list.only(others));
        }
        let enough = together.count_ones() >= MIN_PACKET_RAYS;
        if !enough {
            alone |= together;
        }
        self.left.extend(list.only(alone).as_slice());
        enough.then(|| list.only(together))
    }
}

/// Rays that are traced in packets.
#[derive(Clone, Copy)]
pub struct PacketBatch<'a> {
    pub rays: &'a [Ray],
    /// The grouping of the rays into packets.
    pub order: PacketOrder,
    /// The cost of a ray that is traced on its own, in halves of a node test; for occlusion only.
    pub single_cost: u64,
}

/// Traces the rays of a batch. `answers` holds earlier results and receives the new ones. The
/// indices of rays that fit into no packet are written to `remaining`. Returns whether packets pay
/// off.
#[inline(always)]
pub fn trace<L: SimdLevel, Q: Query>(
    level: L,
    tree: &WideTree,
    geometry: &Geometry,
    PacketBatch {
        rays,
        order,
        single_cost,
    }: PacketBatch<'_>,
    answers: &mut [Q::Answer],
    remaining: &mut Vec<u32>,
    scratch: &mut Scratch,
) -> bool {
    scratch.prepare(tree);
    let (starts, stacks) = (tree.starts(), scratch.stacks.stacks());
    let mut active = Active {
        all: &mut scratch.packets,
        next: &mut [DONE; PACKETS],
    };
    let cost_limit = if L::SIXTEEN {
        PACKET_COST_LIMIT_16
    } else {
        PACKET_COST_LIMIT
    };
    remaining.clear();
    let mut queue = PacketQueue {
        rays,
        order,
        upcoming: 0,
        rest: None,
        band: [0; BAND],
        is_grouped: false,
        reach: tree.padding.reach,
        left: remaining,
        // Both costs are in halves.
        cost_limit: single_cost * cost_limit / 4,
        done: 0,
        cost: 0,
    };
    let mut leaf_queue = PacketLeafQueue::new();
    // The set of active packets, one bit each.
    let mut active_set = 0_u64;
    loop {
        let [leaf, shape_or_done] = level.flags(active.next);
        let mut done = active_set & shape_or_done & !leaf;
        active_set ^= done;
        while done != 0 {
            let packet = &active.all[pop_lowest(&mut done) % PACKETS];
            packet.scatter::<Q>(answers);
            if Q::ANY {
                queue.record(packet);
            }
        }
        let mut free = queue.allowed_packets::<Q>() & !active_set;
        while free != 0 {
            let id = pop_lowest(&mut free) % PACKETS;
            if !queue.refill::<L, Q>(level, &mut active.all[id], answers) {
                break;
            }
            active.next[id] = tree.root();
            active_set |= 1 << id;
        }
        if active_set == 0 {
            break;
        }
        let at_leaf = active_set & leaf;
        let at_node = active_set ^ at_leaf;
        // SAFETY: these packets wait at nodes, and `stacks` are their stacks.
        unsafe { traversal::step::<L, Q, _, PACKETS>(level, tree, &starts, &mut active, at_node, stacks) };
        let mut at_leaf = at_leaf;
        // The packets that have rays which were shortened or blocked.
        let mut nearer = 0;
        leaf_queue.clear();
        while at_leaf != 0 {
            let id = pop_lowest(&mut at_leaf) % PACKETS;
            let (leaf, packet) = (active.next[id], &mut active.all[id]);
            packet.cost += BLOCK_COST * count(leaf) as u32;
            if leaf & SHAPE == 0 {
                // SAFETY: the packet waits at a leaf of this tree.
                nearer |= u64::from(leaf_queue.add::<L, Q>(level, id, packet, unsafe { tree.leaf(leaf) })) << id;
            } else if leaf != EMPTY {
                let met = shape_step::<L, Q>(level, packet, number(leaf), geometry, rays);
                nearer |= u64::from(met) << id;
            }
            if Q::ANY && packet.cost > MAX_PACKET_COST {
                packet.state.stack.clear();
            }
        }
        // SAFETY: the tree has not changed.
        nearer |= unsafe { leaf_queue.test::<L, Q>(level, active.all, rays) };
        while nearer != 0 {
            let packet = &mut active.all[pop_lowest(&mut nearer) % PACKETS];
            packet.set_ends(level);
            // All rays of the packet are blocked.
            if Q::ANY && packet.state.end == f32::NEG_INFINITY {
                packet.state.stack.clear();
            }
        }
        // SAFETY: `stacks` are the stacks of these packets.
        unsafe { traversal::pop::<L, Q, _, PACKETS>(level, &starts, &mut active, active_set, stacks) };
    }
    queue.pays()
}

impl Traverser for Packet {
    const POPS_IN_STEP: bool = false;
    const IS_PACKET: bool = true;

    #[inline(always)]
    fn intersect_node<L: SimdLevel>(&mut self, level: L, node: &WideNode) -> (L::F8, L::F8) {
        self.cost += 1;
        self.state.intersect_node(level, node, Some(&self.inv_far))
    }

    #[inline(always)]
    fn state(&mut self) -> &mut TraversalState {
        &mut self.state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        accel::kernels::query::Occluded,
        math::{Vec3, hash},
        simd::portable::Portable,
    };

    #[test]
    fn every_ray_is_in_one_packet_or_left() {
        let unit = |i: u32, k: usize| hash::unit_f32(hash::pcg4d([i, 3, 5, 7])[k]) - 0.5;
        let ray = |i: u32| {
            let apart = if (i / 64).is_multiple_of(2) { 0.0 } else { 3.0 };
            let d = Vec3::new(unit(i / 5, 0), unit(i / 7, 1), 0.3);
            let mut ray = Ray::new(Vec3::new(apart * unit(i / 3, 2), 0.0, 0.0), d);
            if i.is_multiple_of(37) {
                ray.d.x = 0.0;
            }
            ray
        };
        let rays: Vec<Ray> = (0..1000).map(ray).collect();
        let mut left = Vec::new();
        let mut queue = PacketQueue {
            rays: &rays,
            order: PacketOrder::blocks(4, 16),
            upcoming: 0,
            rest: None,
            band: [0; BAND],
            is_grouped: false,
            reach: 1.0,
            left: &mut left,
            cost_limit: 100,
            done: 0,
            cost: 0,
        };
        let mut seen = vec![0; rays.len()];
        let mut packet = Packet::default();
        while queue.refill::<_, Occluded>(Portable, &mut packet, &vec![false; rays.len()]) {
            packet.rays().for_each(|(_, ray)| seen[ray as usize] += 1);
        }
        assert!(left.len() > 100 && left.len() < 900);
        left.iter().for_each(|&ray| seen[ray as usize] += 1);
        assert!(seen.iter().all(|&n| n == 1));
    }
}
