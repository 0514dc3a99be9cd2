//! The passes of what is in flight, rays or packets, over the nodes of the tree: all that wait at one are tested against its
//! boxes; then all take what comes next from their stacks.

use std::ptr;

use super::{
    super::{
        slab::LEAVE,
        wide::node::{DONE, Node},
    },
    course::Course,
    lanes::{Eight, Floats, Level, Top},
    query::Query,
    scratch::{Ends, Stacks},
    tree::{Starts, Tree},
    waiting::take,
};

/// What is under way, and what comes next for each. That lies on the stack of the kernel, so that no register is needed to find
/// it.
pub struct Flight<'s, T, const N: usize> {
    pub all: &'s mut [T; N],
    pub next: &'s mut [u32; N],
}

/// What goes through the tree.
pub trait Traveller {
    /// From where to where it is in each of a node's boxes.
    fn cross<L: Level>(&mut self, level: L, node: &Node) -> (L::F8, L::F8);
    fn course(&mut self) -> &mut Course;
}

/// Which of a node's boxes are met.
struct Met<'t, L: Level> {
    stack: *mut Ends,
    children: &'t [u32; 8],
    order: L::Order,
    met: Eight,
    enter: L::F8,
}

/// Tests all that `waiting` says of, each at the node that `next` says, and puts the children that are met on their stacks.
///
/// Where any hit will do, what one has found goes on the stack only when the next one's test is under way, so that the processor
/// has more to do at once. It is too much to keep in registers where the order counts.
///
/// # Safety
/// All in `waiting` are at nodes of `tree`, and `stacks` are theirs and were made for it.
#[inline(always)]
pub unsafe fn step<L: Level, Q: Query, T: Traveller, const N: usize>(
    level: L,
    tree: &Tree,
    flight: &mut Flight<'_, T, N>,
    mut waiting: u64,
    stacks: Stacks,
) {
    // What one has found is kept while the next one is tested, so each is borrowed by itself.
    let (all, next) = (flight.all.as_mut_ptr(), &*flight.next);
    // SAFETY: by this function's own contract.
    unsafe {
        if Q::ANY && waiting != 0 {
            let mut before = meet::<L, Q, T, N>(level, tree, all, next, take(&mut waiting));
            while waiting != 0 {
                let met = meet::<L, Q, T, N>(level, tree, all, next, take(&mut waiting));
                keep::<L, Q>(level, &before, stacks);
                before = met;
            }
            keep::<L, Q>(level, &before, stacks);
        }
        while waiting != 0 {
            let met = meet::<L, Q, T, N>(level, tree, all, next, take(&mut waiting));
            keep::<L, Q>(level, &met, stacks);
        }
    }
}

/// # Safety
/// There are `N` of `all`, and `id` is at a node of `tree`.
#[inline(always)]
unsafe fn meet<'t, L: Level, Q: Query, T: Traveller, const N: usize>(
    level: L,
    tree: &'t Tree,
    all: *mut T,
    next: &[u32; N],
    id: usize,
) -> Met<'t, L> {
    // SAFETY: by this function's own contract; what is settled is what it was.
    let (node, traveller) = unsafe {
        let node = ptr::from_ref(tree.node(next[id % N])).cast_mut();
        (&*level.settle(node), &mut *level.settle(all.add(id % N)))
    };
    let (enter, leave) = traveller.cross(level, node);
    let leave = leave.mul(level.splat8(LEAVE));
    let course = traveller.course();
    let order = level.order(&node.order, course.octant());
    let met = if Q::ANY {
        level.met(enter, leave)
    } else {
        level.met_in(order, enter, leave)
    };
    Met {
        stack: &mut course.stack,
        children: &node.child,
        order,
        met,
        enter,
    }
}

/// Puts the children that are met on the stack.
///
/// # Safety
/// The stack exists and is among `stacks`, which were made for the node's tree.
#[inline(always)]
unsafe fn keep<L: Level, Q: Query>(level: L, met: &Met<'_, L>, stacks: Stacks) {
    // SAFETY: by this function's own contract; a stack has room for all that may wait and for a store of eight before it.
    let (stack, top, to) = unsafe {
        let top = (*met.stack).top;
        let to = Top {
            enter: &mut *stacks.enter.add(top as usize).sub(7).cast(),
            child: &mut *stacks.child.add(top as usize).sub(7).cast(),
        };
        (&mut *met.stack, top, to)
    };
    let count = if Q::ANY {
        level.push_any(met.met, met.children, to.child)
    } else {
        level.push(met.met, met.order, met.enter, met.children, to)
    };
    stack.top = top - count;
}

/// Takes for all that `waiting` says of the topmost child that is not too far from its stack: that comes next.
///
/// Memory is asked for two turns late: four requests that wait for a child's number keep others out of the queue.
///
/// # Safety
/// `stacks` are theirs.
#[inline(always)]
pub unsafe fn pop<L: Level, Q: Query, T: Traveller, const N: usize>(
    level: L,
    starts: &Starts,
    flight: &mut Flight<'_, T, N>,
    mut waiting: u64,
    stacks: Stacks,
) {
    let mut late = [DONE; 2];
    while waiting != 0 {
        let id = take(&mut waiting) % N;
        // SAFETY: what is settled is what it was.
        let course = unsafe { (*level.settle(&mut flight.all[id])).course() };
        let end = course.end;
        let mut top = course.stack.top as usize;
        if Q::ANY {
            top += 1;
        } else {
            // SAFETY: there are eight entries behind the last, which are never farther than anything.
            let near = |top: usize| level.up_to(unsafe { &*stacks.enter.add(top + 1).cast() }, end);
            let mut found = near(top);
            while found == 0 {
                top += 8;
                found = near(top);
            }
            top += 1 + found.trailing_zeros() as usize;
        }
        course.stack.top = top as u32;
        // SAFETY: what is popped was pushed, or is the base.
        let child = unsafe { *stacks.child.add(top) };
        flight.next[id] = child;
        level.prefetch::<4>(starts.of(late[0]));
        late = [late[1], child];
    }
    for child in late {
        level.prefetch::<4>(starts.of(child));
    }
}
