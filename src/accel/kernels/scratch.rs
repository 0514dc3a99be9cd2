//! The memory of the kernels, which is kept between batches.

use super::{
    aliased_buffer::AliasedBuffer,
    analytic::ShapeQueue,
    leaf_queue::LeafQueue,
    packet::rays::Packet,
    ray_state::{InstanceState, RayState},
    slot_set::SLOTS,
    tree::WideTree,
};
use super::{packet::rays::PACKETS, stack::StackMemory};

/// The states of the active rays and packets, and their stacks.
pub struct Scratch {
    pub slots: Box<[RayState; SLOTS]>,
    pub packets: Box<[Packet; PACKETS]>,
    pub inside: Box<[InstanceState; SLOTS]>,
    pub leaf_queue: AliasedBuffer<LeafQueue>,
    pub shape_queue: Box<ShapeQueue>,
    pub stacks: StackMemory,
}

impl Scratch {
    pub fn new() -> Self {
        Self {
            slots: Box::new(std::array::from_fn(|_| RayState::default())),
            packets: Box::new(std::array::from_fn(|_| Packet::default())),
            inside: Box::new([InstanceState::NOTHING; SLOTS]),
            leaf_queue: AliasedBuffer::new(),
            shape_queue: Box::new(ShapeQueue::new()),
            stacks: StackMemory::new(),
        }
    }

    /// Reserves the stacks for `tree` and writes their end markers.
    pub fn prepare(&mut self, tree: &WideTree) {
        if self.stacks.reserve(tree.stack_len()) {
            let of_slots = self.slots.iter_mut().map(|slot| &mut slot.state.stack);
            let of_packets = self.packets.iter_mut().map(|packet| &mut packet.state.stack);
            for (id, ends) in of_slots.enumerate().chain(of_packets.enumerate()) {
                *ends = self.stacks.of_slot(id);
            }
        }
    }
}
