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
//! A packet's rays have the same octant and the same main axis. Rays that match too few others,
//! that have a component close to zero or a negative `tmin` are left to the stream kernel.

use super::{
    query::Nearest,
    scratch::Scratch,
    slot_set::pop_lowest,
    traversal::{self, Active, NodePass, Traverser},
    traversal_state::TraversalState,
    tree::WideTree,
};
use crate::{
    accel::wide::node::{DONE, EMPTY, SHAPE, WideNode, number},
    geometry::{Geometry, Hit},
    math::{Ray, VectorLoop},
    simd::lanes::SimdLevel,
};
use leaf::PacketLeafQueue;
use order::PacketRays;
use rays::{Gathered, PACKETS};
use shape::shape_step;

mod edges;
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

/// The number of packets that are traced first. The others start once one of these is done, so that
/// incoherent packets are noticed early.
const PROBES: u32 = 4;

/// The number of packets by which prefetching runs ahead.
const PREFETCH_DISTANCE: usize = 4;

/// The set of all packets.
const ALL_PACKETS: u64 = u64::MAX >> (64 - PACKETS);

/// The packets that have not started yet.
struct PacketQueue<'a> {
    rays: &'a [Ray],
    order: PacketOrder,
    upcoming: usize,
    /// The number of packets that have started.
    started: u32,
    /// The other rays of a list that was split, since not all of them go into one packet.
    rest: Option<PacketRays>,
    reach: f32,
    left: &'a mut Vec<u32>,
}

impl PacketQueue<'_> {
    #[inline(always)]
    fn next<L: SimdLevel>(&mut self, level: L) -> Option<PacketRays> {
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
        for id in soon.ids.iter().step_by(2) {
            level.prefetch::<1>(self.rays.as_ptr().wrapping_add(*id as usize).cast());
        }
        Some(self.order.list(packet, count))
    }

    /// Fills `packet` with the next rays. Returns whether there are any.
    #[inline(always)]
    fn refill<L: SimdLevel>(&mut self, level: L, packet: &mut Packet, hits: &[Option<Hit>]) -> bool {
        let mut next = self.next(level);
        while let Some(list) = next {
            next = match packet.gather(level, self.rays, &list, hits, self.reach) {
                Gathered::All => {
                    self.started += 1;
                    return true;
                }
                Gathered::Some { together, alone } => self.split(&list, together, alone).or_else(|| self.next(level)),
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
    /// The mean number of nodes and leaves that a packet may visit. If packets visit more, they are
    /// abandoned.
    pub visits: u32,
}

/// Traces the rays of a batch. `hits` holds earlier results and receives the new ones. The indices
/// of rays that fit into no packet, or whose packet is abandoned, are written to `remaining`; these
/// rays may have hits that are not the nearest ones.
#[inline(always)]
pub fn trace<L: SimdLevel>(
    level: L,
    tree: &WideTree,
    geometry: &Geometry,
    PacketBatch { rays, order, visits }: PacketBatch<'_>,
    hits: &mut [Option<Hit>],
    remaining: &mut Vec<u32>,
    scratch: &mut Scratch,
) {
    scratch.prepare(tree);
    let (starts, stacks) = (tree.starts(), scratch.stacks.stacks());
    let mut active = Active {
        all: &mut scratch.packets,
        next: &mut [DONE; PACKETS],
    };
    remaining.clear();
    let mut queue = PacketQueue {
        rays,
        order,
        upcoming: 0,
        started: 0,
        rest: None,
        reach: tree.padding.reach,
        left: remaining,
    };
    let mut leaf_queue = PacketLeafQueue::new();
    // The set of active packets, one bit each.
    let mut active_set = 0_u64;
    // The slots that packets may use.
    let mut slots = (1 << PROBES) - 1;
    let mut visited = 0_u64;
    loop {
        let [leaf, shape_or_done] = level.flags(active.next);
        let mut done = active_set & shape_or_done & !leaf;
        active_set ^= done;
        if done != 0 {
            slots = ALL_PACKETS;
        }
        while done != 0 {
            active.all[pop_lowest(&mut done) % PACKETS].scatter(hits);
        }
        if visited > u64::from(queue.started) * u64::from(visits) {
            abandon(&mut queue, active.all, active_set, hits);
            break;
        }
        let mut free = slots & !active_set;
        while free != 0 {
            let id = pop_lowest(&mut free) % PACKETS;
            if !queue.refill(level, &mut active.all[id], hits) {
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
        visited += u64::from(active_set.count_ones());
        // SAFETY: these packets wait at nodes, and `stacks` are their stacks.
        let pass =
            unsafe { NodePass::<L, Nearest, _, PACKETS>::new(level, tree, &starts, &mut active, at_node, stacks) };
        pass.run();
        let mut at_leaf = at_leaf;
        // The packets that have rays which were shortened.
        let mut nearer = 0;
        leaf_queue.clear();
        while at_leaf != 0 {
            let id = pop_lowest(&mut at_leaf) % PACKETS;
            let (leaf, packet) = (active.next[id], &mut active.all[id]);
            if leaf & SHAPE == 0 {
                // SAFETY: the packet waits at a leaf of this tree.
                nearer |= u64::from(leaf_queue.add(level, id, packet, unsafe { tree.leaf(leaf) })) << id;
            } else if leaf != EMPTY {
                let met = shape_step(level, packet, number(leaf), geometry, rays);
                nearer |= u64::from(met) << id;
            }
        }
        // SAFETY: the tree has not changed.
        nearer |= unsafe { leaf_queue.test(level, active.all, rays) };
        while nearer != 0 {
            active.all[pop_lowest(&mut nearer) % PACKETS].set_ends(level);
        }
        // SAFETY: `stacks` are the stacks of these packets.
        unsafe { traversal::pop::<L, _, PACKETS>(level, &starts, &mut active, active_set, stacks) };
    }
}

/// Leaves the rays of the active and of all later packets to the stream kernel.
#[cold]
#[inline(never)]
fn abandon(queue: &mut PacketQueue<'_>, packets: &[Packet; PACKETS], mut active: u64, hits: &mut [Option<Hit>]) {
    while active != 0 {
        let packet = &packets[pop_lowest(&mut active) % PACKETS];
        packet.scatter(hits);
        queue.left.extend(packet.rays());
    }
    if let Some(rest) = queue.rest.take() {
        queue.left.extend(rest.as_slice());
    }
    for packet in queue.upcoming..queue.rays.len().div_ceil(RAYS) {
        queue.left.extend(queue.order.list(packet, queue.rays.len()).as_slice());
    }
}

impl Traverser for Packet {
    const POPS_IN_STEP: bool = false;

    #[inline(always)]
    fn intersect_node<L: SimdLevel>(&mut self, level: L, node: &WideNode) -> (L::F8, L::F8) {
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
            started: 0,
            rest: None,
            reach: 1.0,
            left: &mut left,
        };
        let mut seen = vec![0; rays.len()];
        let mut packet = Packet::default();
        while queue.refill(Portable, &mut packet, &vec![None; rays.len()]) {
            let used = (0..RAYS).filter(|lane| packet.used() >> lane & 1 == 1);
            used.for_each(|lane| seen[packet.ray(lane) as usize] += 1);
        }
        assert!(left.len() > 100 && left.len() < 900);
        left.iter().for_each(|&ray| seen[ray as usize] += 1);
        assert!(seen.iter().all(|&n| n == 1));
    }
}
