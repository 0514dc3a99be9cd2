//! Sixty-four rays in flight: the kernel for rays that have nothing in common.
//!
//! A single ray waits: for the node it will test, and for the outcome of branches nobody can predict. So many are
//! under way at once. All that are at nodes are tested in one pass without branches, which takes what comes next for each
//! from its stack and asks for the memory that it will touch when its turn comes again. Rays at leaves wait until there are
//! enough of them. A ray that is done makes room for the next.
//!
//! At an instance a ray goes on in the space of its group: its line is mapped, the end of the instance goes on its stack
//! and then the group's root. At the end it takes its line in the world again. Kernels for scenes without instances are
//! compiled without any of this.
//!
//! Rays to one light, of which any hit will do, may begin together ([`super::entry_points`]).
//!
//! Sixty-four cover the latency of memory; with 128 the rays' own state no longer fits the first cache.

use super::{
    analytic,
    entry_points::EntryPoints,
    leaf_queue::LeafQueue,
    query::Query,
    ray_state::RayState,
    scratch::Scratch,
    slot_set::{SLOTS, pop_lowest},
    stack::Stacks,
    traversal::{self, Active, Traverser},
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

/// As long as fewer rays wait at leaves, and at least so many are at nodes, those at leaves go on waiting.
const AT_LEAVES: u32 = 3 * SLOTS as u32 / 8;
const AT_NODES: u32 = SLOTS as u32 / 4;

/// What a block of triangles takes, and what else there is to do for a ray, in halves of a node's test.
const BLOCK_COST: u64 = 3;
const RAY_COST: u64 = 8;

/// That of a slot which has had none.
const NO_RAY: u32 = u32::MAX;

/// What becomes of a slot that has room.
enum Refill {
    /// A ray begins at the root, or at the head of that number.
    Begins(u32),
    /// The next ray cannot begin before the others have passed their heads.
    Waits,
    /// No ray is left.
    StackRange,
}

/// The rays that are not under way yet.
struct RayQueue<'a> {
    rays: &'a [Ray],
    pick: RaySelection<'a>,
    upcoming: usize,
    tree: &'a WideTree,
    root: u32,
    heads: &'a mut EntryPoints,
}

impl RayQueue<'_> {
    /// How many rays there are.
    fn len(&self) -> usize {
        match self.pick {
            RaySelection::All => self.rays.len(),
            RaySelection::Some(list) | RaySelection::Together(list) => list.len(),
        }
    }

    /// Puts the next ray that has anything to ask into `slot`.
    #[inline(always)]
    fn refill<L: SimdLevel, Q: Query, const INSTANCES: bool, const HEADS: bool>(
        &mut self,
        level: L,
        slot: &mut RayState,
        inside: &mut InstanceState,
        answers: &[Q::Answer],
    ) -> Refill {
        loop {
            let mut first = self.root;
            // Rays are read one after another, but so seldom that the processor does not notice.
            let (ray, soon) = match self.pick {
                RaySelection::Together(list) if HEADS && self.upcoming < list.len() => {
                    let Some(next) = self.heads.next(level, self.tree, self.rays, list, self.upcoming) else {
                        return Refill::Waits;
                    };
                    level.prefetch::<1>(self.rays.as_ptr().wrapping_add(next.soon[1]).cast());
                    first = next.head;
                    (next.ray, next.soon[0])
                }
                RaySelection::All if self.upcoming < self.rays.len() => {
                    (self.upcoming, self.upcoming + PREFETCH_DISTANCE)
                }
                RaySelection::Some(list) | RaySelection::Together(list) if !HEADS && self.upcoming < list.len() => {
                    let ray = list[self.upcoming] as usize;
                    (ray, ray + PREFETCH_DISTANCE)
                }
                _ => return Refill::StackRange,
            };
            self.upcoming += 1;
            level.prefetch::<1>(self.rays.as_ptr().wrapping_add(soon).cast());
            level.prefetch::<1>(answers.as_ptr().wrapping_add(soon).cast());
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
            return Refill::Begins(first);
        }
    }
}

/// What a stream of rays found out about itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct StreamReport {
    /// What the rays cost, in halves of a node's test; only where any hit will do.
    pub cost: u64,
    /// Whether it paid to look for entry points, where that was tried often enough to know.
    pub entry_points_pay: Option<bool>,
}

/// Asks `rays`; `answers` holds what is known already, and then the answers. Rays begin together with `HEADS`, which is for
/// [`RaySelection::Together`] and where any hit will do.
#[inline(always)]
pub fn trace<L: SimdLevel, Q: Query, const INSTANCES: bool, const HEADS: bool>(
    level: L,
    tree: &WideTree,
    geometry: &Geometry,
    rays: &[Ray],
    pick: RaySelection,
    answers: &mut [Q::Answer],
    scratch: &mut Scratch,
) -> StreamReport {
    scratch.prepare(tree);
    let (starts, stacks) = (tree.starts(), scratch.stacks.stacks());
    let inside = &mut *scratch.inside;
    let mut flight = Active {
        all: &mut scratch.slots,
        next: &mut [DONE; SLOTS],
    };
    let mut queue = RayQueue {
        rays,
        pick,
        upcoming: 0,
        tree,
        root: tree.root(),
        heads: &mut scratch.heads,
    };
    let visits = LeafQueue::opposite(&mut scratch.visits, &*flight.next);
    // No ray is under way yet, so that all have come to their ends.
    for slot in &mut *flight.all {
        slot.ray = NO_RAY;
    }
    if HEADS {
        const { assert!(Q::ANY || !HEADS) };
        queue.heads.begin(tree);
    }
    // Sets of slots, a bit for each: those under way, and of these those that wait at a leaf or for the next ray.
    let mut active = u64::MAX;
    let mut halves = if Q::ANY { RAY_COST * queue.len() as u64 } else { 0 };
    while active != 0 {
        let [leaf, shape_or_done] = level.flags(flight.next);
        let mut done = active & shape_or_done & !leaf;
        // Those that begin at a head.
        let mut fresh = 0;
        while done != 0 {
            let id = pop_lowest(&mut done);
            let slot = &mut flight.all[id];
            let instance = if INSTANCES { inside[id].best } else { InstanceId::NONE };
            if let Some(answer) = answers.get_mut(slot.ray as usize) {
                *answer = Q::end(&slot.best, instance);
            }
            match queue.refill::<L, Q, INSTANCES, HEADS>(level, slot, &mut inside[id], answers) {
                Refill::Begins(first) => {
                    flight.next[id] = first;
                    fresh |= u64::from(HEADS) << id;
                }
                Refill::Waits => {
                    slot.ray = NO_RAY;
                    done |= 1 << id;
                    break;
                }
                Refill::StackRange => active ^= 1 << id,
            }
        }
        let at_node = active & !leaf & !fresh & !done;
        let mut at_leaf = active & leaf & !fresh;
        if at_leaf.count_ones() < AT_LEAVES && at_node.count_ones() >= AT_NODES {
            at_leaf = 0;
        }
        if Q::ANY {
            halves += 2 * u64::from((fresh | at_node).count_ones());
        }
        // SAFETY: these slots begin at heads or wait at nodes, and the stacks are theirs.
        unsafe {
            if HEADS {
                traversal::step::<L, Q, _, SLOTS>(level, &*queue.heads, &starts, &mut flight, fresh, stacks);
                queue.heads.passed();
            }
            traversal::step::<L, Q, _, SLOTS>(level, tree, &starts, &mut flight, at_node, stacks);
        }
        // Those whose rays have come to end nearer.
        let mut nearer = 0_u64;
        let mut at_shape = at_leaf & shape_or_done;
        while at_shape != 0 {
            let id = pop_lowest(&mut at_shape);
            let leaf = flight.next[id];
            let (slot, inside) = (&mut flight.all[id], &mut inside[id]);
            if INSTANCES && leaf & INSTANCE != 0 {
                let ray = &rays[slot.ray as usize];
                // SAFETY: the stack is the slot's own.
                unsafe { instance_step(level, slot, leaf, inside, tree, geometry, ray, stacks) };
            } else if leaf != EMPTY {
                let placed = analytic::test(slot, number(leaf), geometry, rays);
                inside.best = if placed { InstanceId::NONE } else { inside.best };
                nearer |= u64::from(placed) << id;
            }
            // SAFETY: the stack is the slot's own.
            flight.next[id] = unsafe { advance(level, &starts, &mut slot.course, stacks) };
        }
        let mut visited = 0;
        let mut at_triangles = at_leaf & !shape_or_done;
        while at_triangles != 0 {
            let id = pop_lowest(&mut at_triangles);
            let next = &mut flight.next[id];
            // SAFETY: the slot waits at a leaf of this tree, and the stack is its own; what is settled is what it was.
            unsafe {
                let slot = level.launder(&mut flight.all[id]);
                visited = visits.add(level, visited, slot.addr(), tree.leaf(*next));
                *next = advance(level, &starts, &mut (*slot).course, stacks);
            }
        }
        if Q::ANY {
            halves += BLOCK_COST * visited as u64;
        }
        // SAFETY: the tree has not changed.
        nearer |= unsafe { visits.test::<L, Q, INSTANCES>(level, visited, flight.all, inside) };
        while nearer != 0 {
            let id = pop_lowest(&mut nearer);
            flight.next[id] = if Q::ANY {
                DONE
            } else {
                let course = &mut flight.all[id].course;
                // What was popped meanwhile may be too far as well.
                course.stack.top -= 1;
                // SAFETY: the stack is the slot's own.
                unsafe {
                    traversal::drop_far(level, course, stacks);
                    traversal::pop_one(course, stacks)
                }
            };
        }
    }
    StreamReport {
        cost: halves,
        entry_points_pay: if HEADS { queue.heads.verdict() } else { None },
    }
}

/// Pops what comes next, and asks for it.
///
/// # Safety
/// `course` has its stack among `stacks`.
#[inline(always)]
unsafe fn advance<L: SimdLevel>(level: L, starts: &Starts, course: &mut TraversalState, stacks: Stacks) -> u32 {
    // SAFETY: by this function's own contract.
    let next = unsafe { traversal::pop_one(course, stacks) };
    level.prefetch::<4>(starts.of(next));
    next
}

impl Traverser for RayState {
    const IN_PASSING: bool = true;
    const SEVERAL: bool = false;

    #[inline(always)]
    fn cross<L: SimdLevel>(&mut self, level: L, node: &WideNode) -> (L::F8, L::F8) {
        self.course.cross(level, node, None)
    }

    #[inline(always)]
    fn course(&mut self) -> &mut TraversalState {
        &mut self.course
    }
}

/// Takes a ray into an instance, or out of one.
///
/// # Safety
/// `stacks` hold the slot's and were made for `tree`.
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
        if slot.turn_to(level, &geometry.enter(placed, ray), tree.padding.inside()) {
            inside.current = InstanceId(number);
            let top = slot.course.stack.top as usize;
            for (at, child) in [(top, EXIT), (top - 1, tree.group_root(placed.group))] {
                // SAFETY: a stack has room for these two besides all that may wait.
                unsafe { stacks.set(at, f32::NEG_INFINITY, child) };
            }
            slot.course.stack.top -= 2;
            return;
        }
    }
    inside.current = InstanceId::NONE;
    slot.turn_to(level, ray, tree.padding);
}
