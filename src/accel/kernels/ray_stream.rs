//! The stream kernel, for incoherent rays: 64 active rays.
//!
//! A single ray waits for memory and for unpredictable branches. So 64 rays are active at once. All
//! rays that are at inner nodes are tested in one branch-free pass, which pops the next child of
//! each ray from its stack and prefetches it. Rays at leaves wait until there are enough of them. A
//! finished ray is replaced by the next one.
//!
//! At an instance, a ray is transformed to the local space of the group. The end marker of the
//! instance and then the root of the group are pushed on the ray's stack. At the end marker, the
//! ray returns to world space. Kernels for scenes without instances are compiled without this code.
//!
//! With 64 rays, the latency of memory is hidden; with 128, their state no longer fits into the L1
//! cache.

use super::{
    leaf_queue::LeafQueue,
    query::Query,
    ray_state::RayState,
    scratch::Scratch,
    slot_set::{SLOTS, pop_lowest},
    stack::Stacks,
    traversal::{self, Active, NodePass, Traverser},
    traversal_state::TraversalState,
    tree::{Starts, WideTree},
};
use super::{
    ray_selection::{PREFETCH_DISTANCE, RaySelection},
    ray_state::InstanceState,
};
use crate::{
    accel::wide::node::{DONE, EMPTY, EXIT, INSTANCE, WideNode, number},
    geometry::{Geometry, InstanceId},
    math::Ray,
    simd::lanes::SimdLevel,
};

/// Rays at leaves wait while there are fewer than `AT_LEAVES` of them and at least `AT_NODES` rays
/// at nodes.
const AT_LEAVES: u32 = 3 * SLOTS as u32 / 8;
const AT_NODES: u32 = SLOTS as u32 / 4;

/// The index of a slot without a ray.
const NO_RAY: u32 = u32::MAX;

/// The result of refilling a free slot.
enum Refill {
    /// A ray starts at the root.
    Started,
    /// No rays are left.
    Exhausted,
}

/// The rays that have not started yet.
struct RayQueue<'a> {
    rays: &'a [Ray],
    selection: RaySelection<'a>,
    upcoming: usize,
    tree: &'a WideTree,
}

impl RayQueue<'_> {
    /// Starts the next unresolved ray in `slot`.
    #[inline(always)]
    fn refill<L: SimdLevel, Q: Query, const INSTANCES: bool>(
        &mut self,
        level: L,
        slot: &mut RayState,
        inside: &mut InstanceState,
        answers: &[Q::Answer],
    ) -> Refill {
        loop {
            // Rays are read in order, but too slowly for the hardware prefetcher.
            let (ray, prefetch) = match self.selection {
                RaySelection::All if self.upcoming < self.rays.len() => {
                    (self.upcoming, self.upcoming + PREFETCH_DISTANCE)
                }
                RaySelection::Some(list) if self.upcoming < list.len() => {
                    let ray = list[self.upcoming] as usize;
                    (ray, ray + PREFETCH_DISTANCE)
                }
                _ => return Refill::Exhausted,
            };
            self.upcoming += 1;
            level.prefetch::<1>(self.rays.as_ptr().wrapping_add(prefetch).cast());
            level.prefetch::<1>(answers.as_ptr().wrapping_add(prefetch).cast());
            let is_known = Q::is_known(&answers[ray]);
            if Q::ANY && is_known || !slot.start(level, &self.rays[ray], ray, self.tree.padding) {
                continue;
            }
            if is_known && let Some(best) = Q::begin(&answers[ray], self.rays[ray].tmax) {
                slot.set_best(best);
            }
            if INSTANCES {
                *inside = InstanceState {
                    current: InstanceId::NONE,
                    best: Q::instance(&answers[ray]),
                };
            }
            return Refill::Started;
        }
    }
}

/// Traces `rays`. `answers` holds earlier results and receives the new ones.
#[inline(always)]
pub fn trace<L: SimdLevel, Q: Query, const INSTANCES: bool>(
    level: L,
    tree: &WideTree,
    geometry: &Geometry,
    rays: &[Ray],
    selection: RaySelection,
    answers: &mut [Q::Answer],
    scratch: &mut Scratch,
) {
    scratch.prepare(tree);
    let (starts, stacks) = (tree.starts(), scratch.stacks.stacks());
    let inside = &mut *scratch.inside;
    let mut active = Active {
        all: &mut scratch.slots,
        next: &mut [DONE; SLOTS],
    };
    let mut queue = RayQueue {
        rays,
        selection,
        upcoming: 0,
        tree,
    };
    let shape_queue = &mut *scratch.shape_queue;
    let leaf_queue = LeafQueue::opposite(&mut scratch.leaf_queue, &*active.next);
    // No slot has a ray yet, so all of them count as finished.
    for slot in &mut *active.all {
        slot.ray = NO_RAY;
    }
    // The set of active slots, one bit each.
    let mut active_set = u64::MAX;
    while active_set != 0 {
        let [leaf, shape_or_done] = level.flags(active.next);
        let mut done = active_set & shape_or_done & !leaf;
        while done != 0 {
            let id = pop_lowest(&mut done);
            let slot = &mut active.all[id];
            let instance = if INSTANCES { inside[id].best } else { InstanceId::NONE };
            if let Some(answer) = answers.get_mut(slot.ray as usize) {
                *answer = Q::end(&slot.best, instance);
            }
            match queue.refill::<L, Q, INSTANCES>(level, slot, &mut inside[id], answers) {
                Refill::Started => active.next[id] = tree.root(),
                Refill::Exhausted => active_set ^= 1 << id,
            }
        }
        let at_node = active_set & !leaf;
        let mut at_leaf = active_set & leaf;
        if at_leaf.count_ones() < AT_LEAVES && at_node.count_ones() >= AT_NODES {
            at_leaf = 0;
        }
        // SAFETY: these slots wait at nodes, and `stacks` are their stacks.
        let pass = unsafe { NodePass::<L, Q, _, SLOTS>::new(level, tree, &starts, &mut active, at_node, stacks) };
        pass.run_apart();
        let mut shapes_wait = false;
        let mut at_shape = at_leaf & shape_or_done;
        while at_shape != 0 {
            let id = pop_lowest(&mut at_shape);
            let leaf = active.next[id];
            let (slot, inside) = (&mut active.all[id], &mut inside[id]);
            if INSTANCES && leaf & INSTANCE != 0 {
                let ray = &rays[slot.ray as usize];
                // SAFETY: the stack is the slot's own.
                unsafe { instance_step(level, slot, leaf, inside, tree, geometry, ray, stacks) };
            } else if leaf != EMPTY {
                shape_queue.add(id, number(leaf), geometry);
                shapes_wait = true;
            }
            // SAFETY: the stack is the slot's own.
            active.next[id] = unsafe { advance(level, &starts, &mut slot.state, stacks) };
        }
        // The slots whose rays were shortened or blocked.
        let mut nearer = 0_u64;
        if shapes_wait {
            nearer = shape_queue.test(level, active.all, inside, geometry, rays);
        }
        let mut visited = 0;
        let mut at_triangles = at_leaf & !shape_or_done;
        while at_triangles != 0 {
            let id = pop_lowest(&mut at_triangles);
            let next = &mut active.next[id];
            // SAFETY: the slot waits at a leaf of this tree, and the stack is its own; `launder`
            // returns the same address.
            unsafe {
                let slot = level.launder(&mut active.all[id]);
                visited = leaf_queue.add(level, visited, slot.addr(), tree.leaf(*next));
                *next = advance(level, &starts, &mut (*slot).state, stacks);
            }
        }
        // SAFETY: the tree has not changed.
        nearer |= unsafe { leaf_queue.test::<L, Q, INSTANCES>(level, visited, active.all, inside) };
        while nearer != 0 {
            let id = pop_lowest(&mut nearer);
            active.next[id] = if Q::ANY {
                DONE
            } else {
                let state = &mut active.all[id].state;
                // The child that was popped meanwhile may be too far as well.
                state.stack.top -= 1;
                // SAFETY: the stack is the slot's own.
                unsafe {
                    traversal::drop_far(level, state, stacks);
                    traversal::pop_one(state, stacks)
                }
            };
        }
    }
}

/// Pops the next child and prefetches it.
///
/// # Safety
/// The stack of `state` is one of `stacks`.
#[inline(always)]
unsafe fn advance<L: SimdLevel>(level: L, starts: &Starts, state: &mut TraversalState, stacks: Stacks) -> u32 {
    // SAFETY: by this function's own contract.
    let next = unsafe { traversal::pop_one(state, stacks) };
    level.prefetch::<4>(starts.of(next));
    next
}

impl Traverser for RayState {
    const POPS_IN_STEP: bool = true;

    #[inline(always)]
    fn intersect_node<L: SimdLevel>(&mut self, level: L, node: &WideNode) -> (L::F8, L::F8) {
        self.state.intersect_node(level, node, None)
    }

    #[inline(always)]
    fn state(&mut self) -> &mut TraversalState {
        &mut self.state
    }
}

/// Moves a ray into an instance or out of one.
///
/// # Safety
/// The slot's stack is one of `stacks`, which were made for `tree`.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "all of a step's state, in registers")]
unsafe fn instance_step<L: SimdLevel>(
    level: L,
    slot: &mut RayState,
    leaf: u32,
    inside: &mut InstanceState,
    tree: &WideTree,
    geometry: &Geometry,
    ray: &Ray,
    stacks: Stacks,
) {
    if leaf == EMPTY {
        return;
    }
    if leaf != EXIT {
        let number = number(leaf);
        let placed = &geometry.instances[number as usize];
        if slot.continue_along(level, &geometry.enter(placed, ray), tree.padding.inside()) {
            inside.current = InstanceId(number);
            let top = slot.state.stack.top as usize;
            for (at, child) in [(top, EXIT), (top - 1, tree.group_root(placed.group))] {
                // SAFETY: a stack has room for these two entries besides all children that may
                // wait.
                unsafe { stacks.set(at, f32::NEG_INFINITY, child) };
            }
            slot.state.stack.top -= 2;
            return;
        }
    }
    inside.current = InstanceId::NONE;
    slot.continue_along(level, ray, tree.padding);
}
