//! Sixty-four rays in flight: the kernel for rays that have nothing in common.
//!
//! A single ray waits: for the node it will test, and for the outcome of branches nobody can predict. So many are
//! under way at once. All node tests are done in one pass and all pops in a second, both without branches; a pop asks
//! for the memory that its ray will touch when its turn comes again. Rays at leaves wait until there are enough of them.
//! A ray that is done makes room for the next.
//!
//! At an instance a ray goes on in the space of its group: its line is mapped, the end of the instance goes on its stack
//! and then the group's root. At the end it takes its line in the world again. Kernels for scenes without instances are
//! compiled without any of this.
//!
//! Sixty-four cover the latency of memory; with 128 the rays' own state no longer fits the first cache.

use super::{
    super::{
        Geometry, Instance, PrimRef,
        instance::Spread,
        slab::{END, LEAVE},
        wide::node::{DONE, EMPTY, EXIT, INSTANCE, LEAF, Node, SHAPE, blocks},
    },
    lanes::{Floats, Level, Mask, Top},
    query::{Best, Query},
    slot::{BASE, Slot},
    tree::Tree,
    triangle::{self, Line},
    waiting::{List, SLOTS, Waiting},
};
use crate::math::{Ray, Vec3};

/// The memory of the kernel, kept between batches.
pub struct Scratch {
    slots: Box<[Slot; SLOTS]>,
    /// Where children on the stacks are entered, then the children: [`Scratch::stride`] of each for every slot.
    enter: Vec<f32>,
    child: Vec<u32>,
    stride: usize,
    inside: Box<[Inside; SLOTS]>,
}

/// Which instances a slot's ray has to do with.
#[derive(Clone, Copy)]
struct Inside {
    /// In which it is under way.
    current: Instance,
    /// Of its nearest hit so far.
    best: Instance,
}

impl Inside {
    const NOTHING: Self = Self {
        current: Instance::NONE,
        best: Instance::NONE,
    };
}

impl Scratch {
    pub fn new() -> Self {
        Self {
            slots: Box::new(std::array::from_fn(|_| Slot::default())),
            enter: Vec::new(),
            child: Vec::new(),
            stride: 0,
            inside: Box::new([Inside::NOTHING; SLOTS]),
        }
    }

    /// Makes room for the stacks of `tree`, and marks their ends.
    fn prepare(&mut self, tree: &Tree) {
        // An odd number of cache lines, so that the ends of all stacks do not share a few sets of the cache.
        let stride = 16 * ((BASE + tree.stack_len()).div_ceil(16) | 1);
        if self.stride < stride {
            self.stride = stride;
            self.enter = vec![f32::NEG_INFINITY; SLOTS * stride];
            self.child = vec![DONE; SLOTS * stride];
        }
    }

    /// One stack, for a packet.
    pub fn stack(&mut self, tree: &Tree) -> (&mut [f32], &mut [u32]) {
        self.prepare(tree);
        let stride = self.stride;
        (&mut self.enter[BASE..stride], &mut self.child[BASE..stride])
    }
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
    /// Puts the next ray that has anything to ask into `slot`.
    #[inline(always)]
    fn refill<L: Level, Q: Query>(
        &mut self,
        level: L,
        slot: &mut Slot,
        inside: &mut Inside,
        answers: &[Q::Answer],
    ) -> bool {
        loop {
            let ray = match self.pick {
                Pick::All if self.upcoming < self.rays.len() => self.upcoming,
                Pick::Some(list) if self.upcoming < list.len() => list[self.upcoming] as usize,
                _ => return false,
            };
            self.upcoming += 1;
            if let Some(best) = Q::begin(&answers[ray], self.rays[ray].tmax)
                && slot.start(level, &self.rays[ray], ray, best, self.spread)
            {
                slot.next = self.root;
                *inside = Inside {
                    current: Instance::NONE,
                    best: Q::instance(&answers[ray]),
                };
                return true;
            }
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
    let stride = scratch.stride;
    let stacks = Stacks {
        enter: scratch.enter.as_mut_ptr(),
        child: scratch.child.as_mut_ptr(),
        stride,
    };
    let (slots, inside) = (&mut *scratch.slots, &mut *scratch.inside);
    let mut feed = Feed {
        rays,
        pick,
        upcoming: 0,
        root: tree.root(),
        spread: tree.spread,
    };
    let mut waiting = Waiting {
        at_node: List::EMPTY,
        at_leaf: List::EMPTY,
        done: List::EMPTY,
    };
    for (i, (slot, inside)) in slots.iter_mut().zip(&mut *inside).enumerate() {
        if !feed.refill::<L, Q>(level, slot, inside, answers) {
            break;
        }
        waiting.at_node.push_if(i as u8, 1);
    }
    while waiting.at_node.len + waiting.at_leaf.len > 0 {
        let count = waiting.at_node.len;
        for i in 0..count {
            let id = waiting.at_node.get(i) as usize % SLOTS;
            // SAFETY: the slot waits at a node, and its stack is its own.
            unsafe { node_step::<L, Q>(level, &mut slots[id], tree, stacks.of(id)) };
        }
        waiting.at_node.len = 0;
        for i in 0..count {
            let id = waiting.at_node.get(i);
            let slot = &mut slots[id as usize % SLOTS];
            // SAFETY: the stack is the slot's own, with its base.
            unsafe { pop::<L, Q>(level, slot, stacks.of(id as usize % SLOTS)) };
            level.prefetch::<4>(tree.address(slot.next));
            waiting.file(id, slot.next);
        }
        if waiting.at_leaf.len * 2 >= SLOTS || waiting.at_node.len * 4 < SLOTS {
            let count = waiting.at_leaf.len;
            waiting.at_leaf.len = 0;
            for i in 0..count {
                let id = waiting.at_leaf.get(i);
                let slot = &mut slots[id as usize % SLOTS];
                let inside = &mut inside[id as usize % SLOTS];
                let stops = if INSTANCES && slot.next & (SHAPE | INSTANCE) == SHAPE | INSTANCE {
                    // SAFETY: the stack is the slot's own.
                    unsafe {
                        instance_step(
                            level,
                            slot,
                            inside,
                            tree,
                            geometry,
                            rays,
                            stacks.of(id as usize % SLOTS),
                        );
                    }
                    false
                } else {
                    // SAFETY: the slot waits at a leaf of this tree.
                    unsafe { leaf_step::<L, Q, INSTANCES>(level, slot, inside, tree, geometry) }
                };
                if stops {
                    slot.len = BASE as u32;
                }
                // SAFETY: the stack is the slot's own, with its base.
                unsafe { pop::<L, Q>(level, slot, stacks.of(id as usize % SLOTS)) };
                level.prefetch::<4>(tree.address(slot.next));
                waiting.file(id, slot.next);
            }
        }
        for i in 0..waiting.done.len {
            let id = waiting.done.get(i);
            let slot = &mut slots[id as usize % SLOTS];
            let inside = &mut inside[id as usize % SLOTS];
            answers[slot.ray as usize] = Q::end(&slot.best, inside.best);
            if feed.refill::<L, Q>(level, slot, inside, answers) {
                waiting.at_node.push_if(id, 1);
            }
        }
        waiting.done.len = 0;
    }
}

/// The stacks of all slots.
#[derive(Clone, Copy)]
struct Stacks {
    enter: *mut f32,
    child: *mut u32,
    stride: usize,
}

/// The stack of one slot.
#[derive(Clone, Copy)]
struct Stack {
    enter: *mut f32,
    child: *mut u32,
}

impl Stacks {
    /// # Safety
    /// `slot` is below [`SLOTS`].
    #[inline(always)]
    unsafe fn of(&self, slot: usize) -> Stack {
        // SAFETY: both arrays hold a stride for every slot.
        unsafe {
            Stack {
                enter: self.enter.add(slot * self.stride),
                child: self.child.add(slot * self.stride),
            }
        }
    }
}

/// Tests a node's boxes and puts the children that the ray meets on its stack.
///
/// # Safety
/// `slot.next` is a node of `tree`, and `stack` belongs to `slot` and was made for `tree`.
#[inline(always)]
unsafe fn node_step<L: Level, Q: Query>(level: L, slot: &mut Slot, tree: &Tree, stack: Stack) {
    // SAFETY: by this function's own contract.
    let node: &Node = unsafe { tree.node(slot.next) };
    let near = slot.near.map(usize::from);
    let far = near.map(|side| side ^ 1);
    let inv = [
        level.splat8(slot.inv[0]),
        level.splat8(slot.inv[1]),
        level.splat8(slot.inv[2]),
    ];
    // A plane whose distance is not a number comes first in these, so that it does not count.
    let enter = level.splat8(slot.tmin);
    let enter = distance(level, node, near[2], inv[2], slot.shift_near[2]).max(enter);
    let enter = distance(level, node, near[1], inv[1], slot.shift_near[1]).max(enter);
    let enter = distance(level, node, near[0], inv[0], slot.shift_near[0]).max(enter);
    let leave = level.splat8(f32::INFINITY);
    let leave = distance(level, node, far[2], inv[2], slot.shift_far[2]).min(leave);
    let leave = distance(level, node, far[1], inv[1], slot.shift_far[1]).min(leave);
    let leave = distance(level, node, far[0], inv[0], slot.shift_far[0]).min(leave);
    let leave = leave.mul(level.splat8(LEAVE)).min(level.splat8(slot.end));
    let len = slot.len as usize;
    // SAFETY: a stack has room for all that may wait and for a store of eight above it.
    let to = unsafe {
        Top {
            enter: &mut *stack.enter.add(len).cast(),
            child: &mut *stack.child.add(len).cast(),
        }
    };
    let pushed = if Q::ANY {
        level.push_any(enter, leave, &node.child, to.child)
    } else {
        level.push_ordered(enter, leave, &node.child, &node.order, u32::from(slot.octant), to)
    };
    slot.len += pushed as u32;
}

/// Where a ray meets one of the planes of each box.
#[inline(always)]
fn distance<L: Level>(level: L, node: &Node, plane: usize, inv: L::F8, shift: f32) -> L::F8 {
    debug_assert!(plane < 6);
    // SAFETY: there are six planes, and the caller's number is twice an axis plus a side.
    let planes = unsafe { node.planes.get_unchecked(plane) };
    level.load8(planes).mul_sub(inv, level.splat8(shift))
}

/// Takes the topmost child that is not farther than the nearest hit.
///
/// # Safety
/// `stack` belongs to `slot`.
#[inline(always)]
unsafe fn pop<L: Level, Q: Query>(level: L, slot: &mut Slot, stack: Stack) {
    let mut len = slot.len as usize;
    if Q::ANY {
        len -= 1;
    } else {
        let end = level.splat8(slot.end);
        loop {
            // SAFETY: there are eight entries below the first, the last of them never farther than anything.
            let enter = level.load8(unsafe { &*stack.enter.add(len - 8).cast() });
            let nearer = enter.le(end).bits();
            if nearer != 0 {
                len -= (nearer << 24).leading_zeros() as usize + 1;
                break;
            }
            len -= 8;
        }
    }
    // SAFETY: what is popped was pushed, or is the base.
    slot.next = unsafe { *stack.child.add(len) };
    slot.len = len as u32;
}

/// Tests what is in a leaf; whether the ray needs to go no further.
///
/// # Safety
/// `slot.next` is a leaf of `tree`.
#[inline(always)]
unsafe fn leaf_step<L: Level, Q: Query, const INSTANCES: bool>(
    level: L,
    slot: &mut Slot,
    inside: &mut Inside,
    tree: &Tree,
    geometry: &Geometry,
) -> bool {
    if slot.next & SHAPE != 0 {
        return shape_step::<Q>(slot, inside, geometry);
    }
    let line = Line {
        o: splat3(level, slot.o),
        d: splat3(level, slot.d),
        inv: splat3(level, Vec3::from_slice(&slot.inv)),
        negative: slot.negative(),
    };
    for index in blocks(slot.next) {
        // SAFETY: by this function's own contract.
        let block = unsafe { tree.block(index) };
        let [a, b, c] = &block.corners;
        let corners = [load3(level, a), load3(level, b), load3(level, c)];
        let (tmin, tmax) = (level.splat4(slot.tmin), level.splat4(slot.best.t));
        let seen = triangle::see(line.o, &corners);
        let sides = triangle::sides(line.d, &seen);
        let candidates = triangle::candidates(line.d, &seen, sides, tmin, tmax);
        if candidates.mask.bits() == 0 {
            continue;
        }
        let meets = triangle::meet(&line, &corners, &candidates);
        let within = level
            .splat4(slot.tmin)
            .lt(meets.t)
            .and(meets.t.le(level.splat4(slot.best.t)));
        let mut hits = within.and(meets.valid).bits();
        if hits == 0 {
            continue;
        }
        if Q::ANY {
            slot.best.id = 0;
            return true;
        }
        let (t, u, v) = (meets.t.to_array(), meets.u.to_array(), meets.v.to_array());
        while hits != 0 {
            let k = hits.trailing_zeros() as usize & 3;
            hits &= hits - 1;
            let again =
                INSTANCES && t[k] == slot.best.t && block.ids[k] == slot.best.id && inside.current < inside.best;
            if slot.best.loses_to(t[k], block.ids[k]) || again {
                slot.best = Best {
                    t: t[k],
                    u: u[k],
                    v: v[k],
                    id: block.ids[k],
                };
                slot.end = slot.best.t * END;
                if INSTANCES {
                    inside.best = inside.current;
                }
            }
        }
    }
    false
}

#[inline(always)]
fn splat3<L: Level>(level: L, v: Vec3) -> [L::F4; 3] {
    [level.splat4(v.x), level.splat4(v.y), level.splat4(v.z)]
}

/// One corner of four triangles.
#[inline(always)]
pub fn load3<L: Level>(level: L, v: &[[f32; 4]; 3]) -> [L::F4; 3] {
    [level.load4(&v[0]), level.load4(&v[1]), level.load4(&v[2])]
}

/// Tests an analytic primitive by its own scalar routine.
fn shape_step<Q: Query>(slot: &mut Slot, inside: &mut Inside, geometry: &Geometry) -> bool {
    if slot.next == EMPTY {
        return false;
    }
    let index = slot.next & !(LEAF | SHAPE);
    let ray = Ray {
        o: slot.o,
        tmin: slot.tmin,
        d: slot.d,
        tmax: slot.best.t,
    };
    let Some(hit) = geometry.intersect(PrimRef::new(index), &ray) else {
        return false;
    };
    if slot.best.loses_to(hit.t, index + 1) {
        slot.best = Best {
            t: hit.t,
            u: hit.u,
            v: hit.v,
            id: index + 1,
        };
        slot.end = slot.best.t * END;
        inside.best = Instance::NONE;
    }
    Q::ANY
}

/// Takes a ray into an instance, or out of one.
///
/// # Safety
/// `stack` belongs to `slot` and was made for `tree`.
#[inline(always)]
unsafe fn instance_step<L: Level>(
    level: L,
    slot: &mut Slot,
    inside: &mut Inside,
    tree: &Tree,
    geometry: &Geometry,
    rays: &[Ray],
    stack: Stack,
) {
    if slot.next == EMPTY {
        return;
    }
    let ray = &rays[slot.ray as usize];
    if slot.next != EXIT {
        let number = slot.next & !(LEAF | SHAPE | INSTANCE);
        let placed = &geometry.instances[number as usize];
        if slot.set_line(level, &geometry.enter(placed, ray), tree.spread.inside()) {
            inside.current = Instance(number);
            let len = slot.len as usize;
            for (at, child) in [(len, EXIT), (len + 1, tree.group_root(placed.group))] {
                // SAFETY: a stack has room for these two besides all that may wait.
                unsafe {
                    *stack.enter.add(at) = f32::NEG_INFINITY;
                    *stack.child.add(at) = child;
                }
            }
            slot.len += 2;
            return;
        }
    }
    inside.current = Instance::NONE;
    slot.set_line(level, ray, tree.spread);
}
