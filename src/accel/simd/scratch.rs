//! The memory of the kernels, kept between batches.

use super::{
    heads::Heads, inflight::Inside, packet::Packet, room::Room, slot::Slot, tree::Tree, visits::Visits, waiting::SLOTS,
};
use crate::accel::wide::node::DONE;

/// Entries of a stack in a cache line.
const LINE: usize = 16;

/// Of a stack's entries the first and what is behind it end a cache line, so that stores of eight seldom lie in two: that
/// takes twice as long, and all rays together need more of the first cache. What is behind says that the ray is done.
const BASE: usize = 1;

/// Popping may look at seven more, in which it finds nothing before.
const MORE: usize = 7;

/// A cache line of either.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct Line<T>([T; LINE]);

/// Packets in flight: each covers the others' latency as rays do, and more would not stay in the first cache.
pub const PACKETS: usize = 32;

/// What is under way, with its stacks.
pub struct Scratch {
    pub slots: Box<[Slot; SLOTS]>,
    pub packets: Box<[Packet; PACKETS]>,
    pub inside: Box<[Inside; SLOTS]>,
    pub visits: Room<Visits>,
    pub heads: Box<Heads>,
    /// Of packets for occlusion.
    pub packet_doubt: Doubt,
    pub head_doubt: Doubt,
    /// What the rays took that were in flight last and asked whether anything is in their way, in halves of a node's test.
    pub taken: u64,
    /// What some rays took each that might go in packets for occlusion, in the same unit.
    pub alone: u64,
    /// How many might have since; before the first, as many as there can be.
    pub untold: usize,
    /// The numbers of rays that were in no packet, or not answered at once.
    pub left: Vec<u32>,
    /// Whether it is the latter.
    pub is_sifted: bool,
    /// Where children on the stacks are entered, then the children: [`Scratch::stride`] of each for every slot.
    enter: Vec<Line<f32>>,
    child: Vec<Line<u32>>,
    /// In cache lines.
    stride: usize,
}

/// Where stacks begin and end in [`Stacks`]. They grow towards smaller places.
#[repr(C)]
#[derive(Clone, Default)]
pub struct Ends {
    /// Where the next child goes.
    pub top: u32,
    /// Where the first one goes, or went.
    base: u32,
}

impl Ends {
    /// Takes everything off.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.top = self.base;
    }

    /// Where the next child goes, and the first one.
    #[inline(always)]
    pub fn places(&self) -> (usize, usize) {
        (self.top as usize, self.base as usize)
    }
}

impl Scratch {
    pub fn new() -> Self {
        Self {
            slots: Box::new(std::array::from_fn(|_| Slot::default())),
            packets: Box::new(std::array::from_fn(|_| Packet::default())),
            inside: Box::new([Inside::NOTHING; SLOTS]),
            visits: Room::new(),
            heads: Box::new(Heads::new()),
            packet_doubt: Doubt::default(),
            head_doubt: Doubt::default(),
            taken: 0,
            alone: 40,
            untold: usize::MAX,
            left: Vec::new(),
            is_sifted: false,
            enter: Vec::new(),
            child: Vec::new(),
            stride: 0,
        }
    }

    /// Makes room for the stacks of `tree`, and marks their ends.
    pub fn prepare(&mut self, tree: &Tree) {
        // An odd number of cache lines, so that the ends of all stacks do not share a few sets of the cache.
        let stride = (BASE + tree.stack_len()).div_ceil(LINE) | 1;
        if self.stride < stride {
            self.stride = stride;
            let lines = SLOTS * stride + MORE.div_ceil(LINE);
            self.enter = vec![Line([f32::NEG_INFINITY; LINE]); lines];
            self.child = vec![Line([DONE; LINE]); lines];
            let of_slots = self.slots.iter_mut().map(|slot| &mut slot.course.stack);
            let of_packets = self.packets.iter_mut().map(|packet| &mut packet.course.stack);
            for (id, ends) in of_slots.enumerate().chain(of_packets.enumerate()) {
                ends.base = ((id + 1) * stride * LINE - BASE - 1) as u32;
            }
        }
    }

    pub fn stacks(&mut self) -> Stacks {
        Stacks {
            enter: self.enter.as_mut_ptr().cast(),
            child: self.child.as_mut_ptr().cast(),
        }
    }
}

/// The stacks of all slots, behind one another; [`Ends`] say where.
#[derive(Clone, Copy)]
pub struct Stacks {
    pub enter: *mut f32,
    pub child: *mut u32,
}

/// Whether something is tried: where it did not pay, the next batches do without, up to 16 of them.
#[derive(Default)]
pub struct Doubt {
    without: u32,
    next: u32,
}

impl Doubt {
    /// Whether to try it with this batch.
    pub fn tries(&mut self) -> bool {
        let tries = self.without == 0;
        self.without = self.without.saturating_sub(1);
        tries
    }

    /// After a batch with it.
    pub fn learn(&mut self, pays: bool) {
        if pays {
            self.next = 0;
        } else {
            self.without = self.next;
            self.next = (2 * self.next + 1).min(16);
        }
    }
}
