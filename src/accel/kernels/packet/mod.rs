//! Sixteen rays together, several such packets in flight: the kernel for rays that leave one place in nearly one direction,
//! as camera rays do.
//!
//! A node's boxes are tested once for all rays of a packet, with what encloses them ([`rays::Packet`]), which takes no
//! longer than one ray does; and so packets go through the tree as [`super::ray_stream`]'s rays do, in passes without
//! branches that cover one another's latency. So do the triangles of the leaves that they come to: four at a time against what
//! encloses the rays, each that may be met against sixteen lines, and where few of them go through it, these rays alone
//! ([`leaf`], [`singles`]).
//!
//! Rays that ask whether anything is in their way are put in order before ([`group`]): what a picture's rows gave away is lost
//! where some of its paths have ended.
//!
//! Rays of different octants or main axes go into packets of their own; those that are few, have a component of nearly
//! zero or a negative `tmin` are left to the other kernel.

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

mod group;
mod leaf;
pub mod order;
pub mod rays;
mod shape;
mod singles;

use super::ray16::RAYS;
use order::PacketOrder;
use rays::Packet;

/// Fewer rays than these are faster one by one.
const MIN_PACKET_RAYS: u32 = 4;

/// How many packets before its turn one is fetched.
const PREFETCH_DISTANCE: usize = 4;

/// Packets of a batch after which all may be under way, where it is asked whether they pay.
const TRIAL_PACKETS: u64 = 8;

/// How many tests of a node, in halves, a packet for occlusion may cost on average for each that one ray takes by itself, so that its
/// rays are no faster so; with those that were given up. With vectors of sixteen packets are faster.
const PACKET_COST_LIMIT: u64 = 11;
const PACKET_COST_LIMIT_16: u64 = 13;

/// How many fair packets' cost may be lost in a batch before the rest goes without: dear packets lie next to one another, so
/// the first few say little about all.
const MAX_LOST_PACKETS: u64 = 32;

/// What packets must cost on average so that it pays to look for rays that start nearer to one another: five nanoseconds a
/// ray, which is half of what rays in an empty room take.
const MIN_COST_TO_REORDER: u64 = 40;

/// What a packet may cost before it is given up.
const MAX_PACKET_COST: u32 = 300;

/// What a block of triangles costs, in tests of a node.
const BLOCK_COST: u32 = 6;

/// The packets that are not under way yet.
struct PacketQueue<'a> {
    rays: &'a [Ray],
    order: PacketOrder,
    upcoming: usize,
    /// What is left of a list whose rays do not all go together.
    rest: Option<PacketRays>,
    /// The rays of four packets, if they were put in order.
    band: [u32; BAND],
    is_grouped: bool,
    reach: f32,
    left: &'a mut Vec<u32>,
    /// What a packet may cost so that it pays.
    cost_limit: u64,
    /// How many packets are done, and what they took together.
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
        // Rays of a block lie in several places, which no processor expects.
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

    /// Which packets may be under way: for occlusion not many until it is seen whether they pay. Rays that start all over a
    /// surface may have so much around them that packets take longer than rays do.
    fn room<Q: Query>(&self) -> u64 {
        let few = Q::ANY && self.done < TRIAL_PACKETS;
        u64::MAX >> (64 - if few { TRIAL_PACKETS as usize } else { PACKETS })
    }

    fn pays(&self) -> bool {
        self.cost <= self.cost_limit * (self.done + MAX_LOST_PACKETS)
    }

    /// After a packet is done.
    fn note(&mut self, packet: &Packet) {
        self.cost += u64::from(packet.cost);
        self.done += 1;
        if packet.cost > MAX_PACKET_COST {
            // Its rays begin again, each by itself.
            self.cost += self.cost_limit;
            self.left.extend(packet.rays().map(|(_, id)| id));
        }
    }

    /// Puts the next rays into `packet`; whether there are any.
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
                    self.part(&list, together, alone).or_else(|| self.next::<L, Q>(level))
                }
            };
        }
        false
    }

    /// Parts a list whose rays do not all go together; those that do if they are enough.
    #[cold]
    #[inline(never)]
    fn part(&mut self, list: &PacketRays, together: u32, mut alone: u32) -> Option<PacketRays> {
        let others = list.lanes() & !(together | alone);
        // Those that go together may yet be too far apart: what is left of a list before is kept.
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

/// Rays that go in packets.
#[derive(Clone, Copy)]
pub struct PacketBatch<'a> {
    pub rays: &'a [Ray],
    /// Which rays make a packet.
    pub order: PacketOrder,
    /// What a ray costs by itself, in halves of a node's test; only where any hit will do.
    pub single_cost: u64,
}

/// Asks the rays of a batch; `answers` holds what is known already, and then the answers. The numbers of the rays that make no
/// packet are put into `remaining`. Returns whether packets pay.
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
    let mut flight = Active {
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
        // Both are in halves.
        cost_limit: single_cost * cost_limit / 4,
        done: 0,
        cost: 0,
    };
    let mut visits = PacketLeafQueue::new();
    // Sets of packets, a bit for each.
    let mut active = 0_u64;
    loop {
        let [leaf, shape_or_done] = level.flags(flight.next);
        let mut done = active & shape_or_done & !leaf;
        active ^= done;
        while done != 0 {
            let packet = &flight.all[pop_lowest(&mut done) % PACKETS];
            packet.scatter::<Q>(answers);
            if Q::ANY {
                queue.note(packet);
            }
        }
        let mut free = queue.room::<Q>() & !active;
        while free != 0 {
            let id = pop_lowest(&mut free) % PACKETS;
            if !queue.refill::<L, Q>(level, &mut flight.all[id], answers) {
                break;
            }
            flight.next[id] = tree.root();
            active |= 1 << id;
        }
        if active == 0 {
            break;
        }
        let at_leaf = active & leaf;
        let at_node = active ^ at_leaf;
        // SAFETY: these packets wait at nodes, and the stacks are theirs.
        unsafe { traversal::step::<L, Q, _, PACKETS>(level, tree, &starts, &mut flight, at_node, stacks) };
        let mut at_leaf = at_leaf;
        // Those whose rays have come to end nearer.
        let mut nearer = 0;
        visits.clear();
        while at_leaf != 0 {
            let id = pop_lowest(&mut at_leaf) % PACKETS;
            let (leaf, packet) = (flight.next[id], &mut flight.all[id]);
            packet.cost += BLOCK_COST * count(leaf) as u32;
            if leaf & SHAPE == 0 {
                // SAFETY: the packet waits at a leaf of this tree.
                nearer |= u64::from(visits.add::<L, Q>(level, id, packet, unsafe { tree.leaf(leaf) })) << id;
            } else if leaf != EMPTY {
                let met = shape_step::<L, Q>(level, packet, number(leaf), geometry, rays);
                nearer |= u64::from(met) << id;
            }
            if Q::ANY && packet.cost > MAX_PACKET_COST {
                packet.course.stack.clear();
            }
        }
        // SAFETY: the tree has not changed.
        nearer |= unsafe { visits.test::<L, Q>(level, flight.all, rays) };
        while nearer != 0 {
            let packet = &mut flight.all[pop_lowest(&mut nearer) % PACKETS];
            packet.set_ends(level);
            // Nothing is left to ask.
            if Q::ANY && packet.course.end == f32::NEG_INFINITY {
                packet.course.stack.clear();
            }
        }
        // SAFETY: the stacks are theirs.
        unsafe { traversal::pop::<L, Q, _, PACKETS>(level, &starts, &mut flight, active, stacks) };
    }
    queue.pays()
}

impl Traverser for Packet {
    const IN_PASSING: bool = false;
    const SEVERAL: bool = true;

    #[inline(always)]
    fn cross<L: SimdLevel>(&mut self, level: L, node: &WideNode) -> (L::F8, L::F8) {
        self.cost += 1;
        self.course.cross(level, node, Some(&self.inv_far))
    }

    #[inline(always)]
    fn course(&mut self) -> &mut TraversalState {
        &mut self.course
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
