//! The passes of active rays or packets over the inner nodes of the tree. All that wait at a node
//! are tested against its boxes and pop their next child from their stacks: rays in the same pass,
//! packets in a pass of its own.

use std::{marker::PhantomData, ptr};

use super::{
    query::Query,
    slot_set::pop_lowest,
    stack::{StackRange, Stacks},
    traversal_state::TraversalState,
    tree::{Starts, WideTree},
};
use crate::{
    accel::wide::node::{DONE, WideNode},
    geometry::slab::EXIT_PADDING,
    math::VectorLoop,
    simd::lanes::{Eight, Floats, SimdLevel},
};

/// The active rays or packets and the next child of each. The children are in the kernel's stack
/// frame, so that no register is needed for their address.
pub struct Active<'s, T, const N: usize> {
    pub all: &'s mut [T; N],
    pub next: &'s mut [u32; N],
}

/// A ray or a packet that traverses the tree.
pub trait Traverser {
    /// Whether the entries of its stack are never too far, because [`drop_far`] removes such
    /// children when its end is shortened. Then the next child is popped in the same pass.
    /// Otherwise, [`pop`] skips them. Dropping pays off if many children are popped for each time
    /// that the end is shortened.
    const POPS_IN_STEP: bool;

    /// Returns the entry and exit distances of a node's boxes.
    fn intersect_node<L: SimdLevel>(&mut self, level: L, node: &WideNode) -> (L::F8, L::F8);
    fn state(&mut self) -> &mut TraversalState;
}

/// The boxes of a node that are hit.
struct ChildHits<'t, L: SimdLevel> {
    stack: *mut StackRange,
    children: &'t [u32; 8],
    order: L::Order,
    met: Eight,
    enter: L::F8,
}

/// A pass over the inner nodes: tests all in `waiting` against the node that `next` gives, and pushes the children that are hit on
/// their stacks. Rays also pop their next child.
pub struct NodePass<'a, 's, L, Q, T, const N: usize> {
    level: L,
    tree: &'a WideTree,
    starts: &'a Starts,
    active: &'a mut Active<'s, T, N>,
    waiting: u64,
    stacks: Stacks<'a>,
    query: PhantomData<Q>,
}

impl<'a, 's, L: SimdLevel, Q: Query, T: Traverser, const N: usize> NodePass<'a, 's, L, Q, T, N> {
    /// # Safety
    /// All in `waiting` are at one of the tree's nodes, and `stacks` are their stacks, made for the tree.
    #[inline(always)]
    pub unsafe fn new(
        level: L,
        tree: &'a WideTree,
        starts: &'a Starts,
        active: &'a mut Active<'s, T, N>,
        waiting: u64,
        stacks: Stacks<'a>,
    ) -> Self {
        Self {
            level,
            tree,
            starts,
            active,
            waiting,
            stacks,
            query: PhantomData,
        }
    }

    /// Runs the pass in a function of its own: its loop keeps all addresses in registers, whatever the kernel around it needs.
    #[inline(never)]
    pub fn run_apart(self) {
        self.level.dispatch(self);
    }
}

impl<L: SimdLevel, Q: Query, T: Traverser, const N: usize> VectorLoop for NodePass<'_, '_, L, Q, T, N> {
    #[inline(always)]
    fn run(self) {
        let Self {
            level,
            tree,
            starts,
            active,
            mut waiting,
            stacks,
            ..
        } = self;
        if waiting == 0 {
            return;
        }
        // A child is popped one iteration after the pushes. The first iteration pops an arbitrary
        // child, which the next one corrects. The loop is unrolled twice, so that no register moves
        // are needed between iterations.
        let mut last = (waiting.trailing_zeros() as usize, 0);
        loop {
            // SAFETY: by the contract of `new`.
            unsafe {
                let first = visit::<L, Q, T, N>(level, tree, active, &mut waiting, stacks);
                pop_late::<L, T, N>(level, starts, active, last, stacks);
                last = first;
                if waiting == 0 {
                    break;
                }
                let second = visit::<L, Q, T, N>(level, tree, active, &mut waiting, stacks);
                pop_late::<L, T, N>(level, starts, active, first, stacks);
                last = second;
                if waiting == 0 {
                    break;
                }
            }
        }
        // SAFETY: by the contract of `new`.
        unsafe { pop_late::<L, T, N>(level, starts, active, last, stacks) };
    }
}

/// Tests the first in `waiting`. Returns its index and the place of the topmost child of its stack.
///
/// # Safety
/// The contract is that of [`NodePass::new`]; `waiting` is not empty.
#[inline(always)]
unsafe fn visit<L: SimdLevel, Q: Query, T: Traverser, const N: usize>(
    level: L,
    tree: &WideTree,
    active: &mut Active<'_, T, N>,
    waiting: &mut u64,
    stacks: Stacks,
) -> (usize, usize) {
    let id = pop_lowest(waiting);
    // SAFETY: by this function's own contract.
    unsafe {
        let met = test_node::<L, Q, T, N>(level, tree, active.all.as_mut_ptr(), active.next, id);
        (id, push_children::<L, Q, T>(level, &met, stacks))
    }
}

/// Pops the child at a `place` of the stacks, if rays pop in the same pass.
///
/// # Safety
/// The place holds a child that was pushed, or is the base of a stack or the first place of all.
#[inline(always)]
unsafe fn pop_late<L: SimdLevel, T: Traverser, const N: usize>(
    level: L,
    starts: &Starts,
    active: &mut Active<'_, T, N>,
    (id, place): (usize, usize),
    stacks: Stacks,
) {
    if T::POPS_IN_STEP {
        // SAFETY: by this function's own contract.
        let child = unsafe { stacks.child(place) };
        active.next[id % N] = child;
        level.prefetch::<4>(starts.of(child));
    }
}

/// # Safety
/// `all` has `N` elements, and `id` is at one of the `nodes`.
#[inline(always)]
unsafe fn test_node<'t, L: SimdLevel, Q: Query, T: Traverser, const N: usize>(
    level: L,
    tree: &'t WideTree,
    all: *mut T,
    next: &[u32; N],
    id: usize,
) -> ChildHits<'t, L> {
    // SAFETY: by this function's own contract; `launder` returns the same address.
    let (node, traverser) = unsafe {
        let node = ptr::from_ref(tree.node(next[id % N])).cast_mut();
        (&*level.launder(node), &mut *level.launder(all.add(id % N)))
    };
    let (enter, leave) = traverser.intersect_node(level, node);
    let leave = leave.mul(level.splat8(EXIT_PADDING));
    let state = traverser.state();
    let order = level.order(&node.order, state.octant());
    let met = if Q::ANY {
        level.met(enter, leave)
    } else {
        level.met_in(order, enter, leave)
    };
    ChildHits {
        stack: &mut state.stack,
        children: &node.child,
        order,
        met,
        enter,
    }
}

/// Pushes the children that are hit. Returns the place of the topmost one, if rays pop in the same
/// pass.
///
/// # Safety
/// The stack exists and is one of `stacks`, which were made for the node's tree.
#[inline(always)]
unsafe fn push_children<L: SimdLevel, Q: Query, T: Traverser>(
    level: L,
    met: &ChildHits<'_, L>,
    stacks: Stacks,
) -> usize {
    // SAFETY: by this function's own contract; a stack has room for all children that may wait and
    // for a store of eight before them.
    let (stack, top, to) = unsafe {
        let top = (*met.stack).top;
        (&mut *met.stack, top, stacks.top(top as usize))
    };
    let count = if Q::ANY {
        level.push_any(met.met, met.children, to.child)
    } else {
        level.push(met.met, met.order, met.enter, met.children, to)
    };
    stack.top = top - count + u32::from(T::POPS_IN_STEP);
    stack.top as usize
}

/// Pops, for all in `waiting`, the topmost child that is not too far. For packets, which do not pop
/// in the same pass.
///
/// Prefetches are two iterations late: if four prefetches wait for the index of a child, they block
/// the load queue.
///
/// # Safety
/// `stacks` are their stacks.
#[inline(always)]
pub unsafe fn pop<L: SimdLevel, T: Traverser, const N: usize>(
    level: L,
    starts: &Starts,
    active: &mut Active<'_, T, N>,
    mut waiting: u64,
    stacks: Stacks,
) {
    const { assert!(!T::POPS_IN_STEP) };
    let mut late = [DONE; 2];
    while waiting != 0 {
        let id = pop_lowest(&mut waiting) % N;
        // SAFETY: `launder` returns the same address.
        let state = unsafe { (*level.launder(&mut active.all[id])).state() };
        let mut top = state.stack.top as usize;
        let end = level.splat8(state.end);
        let near = |top: usize| {
            // SAFETY: there are eight entries after the last one, which always pass the distance
            // test.
            let enter = level.load8(&unsafe { stacks.enter8(top + 1) });
            level.met(enter, end).bits()
        };
        let mut found = near(top);
        while found == 0 {
            top += 8;
            found = near(top);
        }
        top += 1 + found.trailing_zeros() as usize;
        state.stack.top = top as u32;
        // SAFETY: the popped child was pushed, or is the base.
        let child = unsafe { stacks.child(top) };
        active.next[id] = child;
        level.prefetch::<4>(starts.of(late[0]));
        late = [late[1], child];
    }
    for child in late {
        level.prefetch::<4>(starts.of(child));
    }
}

/// Pops the topmost child.
///
/// # Safety
/// The stack of `state` is one of `stacks`.
#[inline(always)]
pub unsafe fn pop_one(state: &mut TraversalState, stacks: Stacks) -> u32 {
    state.stack.top += 1;
    // SAFETY: the popped child was pushed, or is the base.
    unsafe { stacks.child(state.stack.top as usize) }
}

/// Removes the children from the stack that are farther than the end, after that was shortened.
///
/// # Safety
/// The stack of `state` is one of `stacks`.
#[inline(always)]
pub unsafe fn drop_far<L: SimdLevel>(level: L, state: &mut TraversalState, stacks: Stacks) {
    let end = level.splat8(state.end);
    let (top, base) = state.stack.places();
    let (mut from, mut to) = (base, base);
    while from > top {
        // SAFETY: by this function's own contract; before a stack there is room for eight entries.
        // Entries move towards the base, over entries that were read before.
        to -= unsafe {
            let (enter, child) = (stacks.enter8(from - 7), stacks.child8(from - 7));
            // Entries above the top are invalid.
            let valid = 0xff00 >> (from - top).min(8) & 0xff;
            let kept = level.met(level.load8(&enter), end);
            let kept = Eight::new(kept.bits() & valid);
            let end = stacks.top(to);
            level.push_any(kept, bytemuck::cast_ref(&enter), bytemuck::cast_mut(end.enter));
            level.push_any(kept, &child, end.child) as usize
        };
        from -= 8;
    }
    state.stack.top = to as u32;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{accel::kernels::scratch::Scratch, simd::portable::Portable};

    #[test]
    fn what_is_too_far_leaves_the_stack_and_the_rest_keeps_its_order() {
        let mut scratch = Scratch::new();
        scratch.prepare(&WideTree::default());
        let stacks = scratch.stacks.stacks();
        // The stacks of an empty tree are short; together with those before it, this one has room
        // for all children.
        let state = &mut scratch.slots[4].state;
        let (_, base) = state.stack.places();
        for count in 0..=30_u32 {
            for far in [0, 1, 0b1010_0110_1111_0000_0110_0101_1101, u32::MAX] {
                let is_far = |child: &u32| far >> child & 1 == 1;
                state.end = 1.0;
                state.stack.clear();
                for child in 0..count {
                    let at = state.stack.top as usize;
                    // SAFETY: the stack has room for more.
                    unsafe { stacks.set(at, if is_far(&child) { 1.5 } else { 1.0 }, child) };
                    state.stack.top -= 1;
                }
                // SAFETY: the stack is the slot's own.
                let left: Vec<u32> = unsafe {
                    drop_far(Portable, state, stacks);
                    let (top, base) = state.stack.places();
                    (top + 1..=base).rev().map(|at| stacks.child(at)).collect()
                };
                let near: Vec<u32> = (0..count).filter(|child| !is_far(child)).collect();
                assert_eq!(left, near);
                // SAFETY: the entry after a stack's base is its end marker.
                assert_eq!(unsafe { stacks.child(base + 1) }, DONE);
            }
        }
    }
}
