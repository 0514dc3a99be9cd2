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
//! Sixty-four cover the latency of memory; with 128 the rays' own state no longer fits the first cache.

use super::{
    super::{
        Geometry, Instance,
        instance::Spread,
        wide::node::{DONE, EMPTY, EXIT, INSTANCE, Node, number},
    },
    analytic,
    course::Course,
    lanes::Level,
    nodes::{self, Flight, Traveller},
    query::Query,
    scratch::{Scratch, Stacks},
    slot::Slot,
    tree::{Starts, Tree},
    visits::Visits,
    waiting::{SLOTS, take},
};
use crate::math::Ray;

/// How many rays before its turn one is fetched.
const AHEAD: usize = 16;

/// As long as fewer rays wait at leaves, and at least as many are at nodes, those at leaves go on waiting.
const ENOUGH: u32 = SLOTS as u32 / 4;

/// Which instances a slot's ray has to do with.
#[derive(Clone, Copy)]
pub struct Inside {
    /// In which it is under way.
    pub current: Instance,
    /// Of its nearest hit so far.
    pub best: Instance,
}

impl Inside {
    pub const NOTHING: Self = Self {
        current: Instance::NONE,
        best: Instance::NONE,
    };
}

/// The rays of a batch that are asked for: all, or some of them by number.
#[derive(Clone, Copy)]
pub enum Pick<'a> {
    All,
    Some(&'a [u32]),
}

/// The rays that are not under way yet.
struct Feed<'a> {
    rays: &'a [Ray],
    pick: Pick<'a>,
    upcoming: usize,
    root: u32,
    spread: Spread,
}

impl Feed<'_> {
    /// Puts the next ray that has anything to ask into `slot`; what comes next for the slot, `None` where no ray is left.
    #[inline(always)]
    fn refill<L: Level, Q: Query, const INSTANCES: bool>(
        &mut self,
        level: L,
        slot: &mut Slot,
        inside: &mut Inside,
        answers: &[Q::Answer],
    ) -> Option<u32> {
        loop {
            let ray = match self.pick {
                Pick::All if self.upcoming < self.rays.len() => self.upcoming,
                Pick::Some(list) if self.upcoming < list.len() => list[self.upcoming] as usize,
                _ => return None,
            };
            self.upcoming += 1;
            // Rays are read one after another, but so seldom that the processor does not notice.
            let ahead = ray + AHEAD;
            level.prefetch::<1>(self.rays.as_ptr().wrapping_add(ahead).cast());
            level.prefetch::<1>(answers.as_ptr().wrapping_add(ahead).cast());
            let is_known = Q::is_known(&answers[ray]);
            if Q::ANY && is_known || !slot.start(level, &self.rays[ray], ray, self.spread) {
                continue;
            }
            if is_known && let Some(best) = Q::begin(&answers[ray], self.rays[ray].tmax) {
                slot.set_best(best);
            }
            if INSTANCES {
                *inside = Inside {
                    current: Instance::NONE,
                    best: Q::instance(&answers[ray]),
                };
            }
            return Some(self.root);
        }
    }
}

/// Asks `rays`; `answers` holds what is known already, and then the answers.
#[inline(always)]
pub fn trace<L: Level, Q: Query, const INSTANCES: bool>(
    level: L,
    tree: &Tree,
    geometry: &Geometry,
    rays: &[Ray],
    pick: Pick,
    answers: &mut [Q::Answer],
    scratch: &mut Scratch,
) {
    scratch.prepare(tree);
    let (starts, stacks) = (tree.starts(), scratch.stacks());
    let inside = &mut *scratch.inside;
    let mut flight = Flight {
        all: &mut scratch.slots,
        next: &mut [DONE; SLOTS],
    };
    let mut feed = Feed {
        rays,
        pick,
        upcoming: 0,
        root: tree.root(),
        spread: tree.spread,
    };
    let mut visits = Visits::new();
    // Sets of slots, a bit for each: those under way, and of these those that wait at a leaf or for the next ray.
    let mut active = 0;
    for (id, inside) in inside.iter_mut().enumerate() {
        let Some(root) = feed.refill::<L, Q, INSTANCES>(level, &mut flight.all[id], inside, answers) else {
            break;
        };
        flight.next[id] = root;
        active |= 1 << id;
    }
    while active != 0 {
        let [leaf, shape_or_done] = level.flags(flight.next);
        let mut done = active & shape_or_done & !leaf;
        while done != 0 {
            let id = take(&mut done);
            let slot = &mut flight.all[id];
            let instance = if INSTANCES { inside[id].best } else { Instance::NONE };
            answers[slot.ray as usize] = Q::end(&slot.best, instance);
            match feed.refill::<L, Q, INSTANCES>(level, slot, &mut inside[id], answers) {
                Some(root) => flight.next[id] = root,
                None => active ^= 1 << id,
            }
        }
        let at_node = active & !leaf;
        let mut at_leaf = active & leaf;
        if at_leaf.count_ones() < ENOUGH && at_node.count_ones() >= ENOUGH {
            at_leaf = 0;
        }
        // SAFETY: these slots wait at nodes, and the stacks are theirs.
        unsafe { nodes::step::<L, Q, _, SLOTS>(level, tree, &starts, &mut flight, at_node, stacks) };
        // Those whose rays have come to end nearer.
        let mut nearer = 0_u64;
        let mut at_shape = at_leaf & shape_or_done;
        while at_shape != 0 {
            let id = take(&mut at_shape);
            let leaf = flight.next[id];
            let (slot, inside) = (&mut flight.all[id], &mut inside[id]);
            if INSTANCES && leaf & INSTANCE != 0 {
                let ray = &rays[slot.ray as usize];
                // SAFETY: the stack is the slot's own.
                unsafe { instance_step(level, slot, leaf, inside, tree, geometry, ray, stacks) };
            } else if leaf != EMPTY {
                let placed = analytic::test(slot, number(leaf), geometry, rays);
                inside.best = if placed { Instance::NONE } else { inside.best };
                nearer |= u64::from(placed) << id;
            }
            // SAFETY: the stack is the slot's own.
            flight.next[id] = unsafe { advance(level, &starts, &mut slot.course, stacks) };
        }
        let mut visited = 0;
        let mut at_triangles = at_leaf & !shape_or_done;
        while at_triangles != 0 {
            let id = take(&mut at_triangles);
            let next = &mut flight.next[id];
            // SAFETY: the slot waits at a leaf of this tree, and the stack is its own; what is settled is what it was.
            unsafe {
                let slot = level.settle(&mut flight.all[id]);
                visited = visits.add(level, visited, slot.addr(), tree.leaf(*next));
                *next = advance(level, &starts, &mut (*slot).course, stacks);
            }
        }
        // SAFETY: the tree has not changed.
        nearer |= unsafe { visits.test::<L, Q, INSTANCES>(level, visited, flight.all, inside) };
        while nearer != 0 {
            let id = take(&mut nearer);
            flight.next[id] = if Q::ANY {
                DONE
            } else {
                let course = &mut flight.all[id].course;
                // What was popped meanwhile may be too far as well.
                course.stack.top -= 1;
                // SAFETY: the stack is the slot's own.
                unsafe {
                    nodes::drop_far(level, course, stacks);
                    nodes::pop_one(course, stacks)
                }
            };
        }
    }
}

/// Pops what comes next, and asks for it.
///
/// # Safety
/// `course` has its stack among `stacks`.
#[inline(always)]
unsafe fn advance<L: Level>(level: L, starts: &Starts, course: &mut Course, stacks: Stacks) -> u32 {
    // SAFETY: by this function's own contract.
    let next = unsafe { nodes::pop_one(course, stacks) };
    level.prefetch::<4>(starts.of(next));
    next
}

impl Traveller for Slot {
    const IN_PASSING: bool = true;

    #[inline(always)]
    fn cross<L: Level>(&mut self, level: L, node: &Node) -> (L::F8, L::F8) {
        self.course.cross(level, node, None)
    }

    #[inline(always)]
    fn course(&mut self) -> &mut Course {
        &mut self.course
    }
}

/// Takes a ray into an instance, or out of one.
///
/// # Safety
/// `stacks` hold the slot's and were made for `tree`.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "all of a step's state, in registers")]
unsafe fn instance_step<L: Level>(
    level: L,
    slot: &mut Slot,
    leaf: u32,
    inside: &mut Inside,
    tree: &Tree,
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
        if slot.set_line(level, &geometry.enter(placed, ray), tree.spread.inside()) {
            inside.current = Instance(number);
            let top = slot.course.stack.top as usize;
            for (at, child) in [(top, EXIT), (top - 1, tree.group_root(placed.group))] {
                // SAFETY: a stack has room for these two besides all that may wait.
                unsafe {
                    *stacks.enter.add(at) = f32::NEG_INFINITY;
                    *stacks.child.add(at) = child;
                }
            }
            slot.course.stack.top -= 2;
            return;
        }
    }
    inside.current = Instance::NONE;
    slot.set_line(level, ray, tree.spread);
}
