//! The memory of the kernels, kept between batches.

use super::{
    aliased_buffer::Room,
    entry_points::Heads,
    leaf_queue::Visits,
    packet::rays::Packet,
    ray_state::{Inside, Slot},
    slot_set::SLOTS,
    tree::Tree,
};
use super::{packet::rays::PACKETS, stack::StackMemory};

/// What is under way, with its stacks.
pub struct Scratch {
    pub slots: Box<[Slot; SLOTS]>,
    pub packets: Box<[Packet; PACKETS]>,
    pub inside: Box<[Inside; SLOTS]>,
    pub visits: Room<Visits>,
    pub heads: Box<Heads>,
    pub stacks: StackMemory,
}

impl Scratch {
    pub fn new() -> Self {
        Self {
            slots: Box::new(std::array::from_fn(|_| Slot::default())),
            packets: Box::new(std::array::from_fn(|_| Packet::default())),
            inside: Box::new([Inside::NOTHING; SLOTS]),
            visits: Room::new(),
            heads: Box::new(Heads::new()),
            stacks: StackMemory::new(),
        }
    }

    /// Makes room for the stacks of `tree`, and marks their ends.
    pub fn prepare(&mut self, tree: &Tree) {
        if self.stacks.reserve(tree.stack_len()) {
            let of_slots = self.slots.iter_mut().map(|slot| &mut slot.course.stack);
            let of_packets = self.packets.iter_mut().map(|packet| &mut packet.course.stack);
            for (id, ends) in of_slots.enumerate().chain(of_packets.enumerate()) {
                *ends = self.stacks.of_slot(id);
            }
        }
    }
}
