//! Where what goes through the tree is bound for, and what waits for it there.

use std::{mem::offset_of, ptr};

use super::stack::StackRange;
use crate::{
    accel::wide::node::WideNode,
    geometry::slab::LEAVE,
    simd::lanes::{Floats, SimdLevel},
};

/// Bytes between the minima and the maxima of an axis in a node.
pub const SIDE: usize = 32;

/// What the passes over nodes need of a ray or a packet: a cache line.
///
/// A processor loads half as many vectors in a cycle as it computes, so numbers come four at a time, and go into all lanes
/// from there.
#[repr(C)]
#[derive(Clone, Default)]
pub struct TraversalState {
    /// A plane at `b` through which boxes are entered is met at `b * inv + near`.
    pub inv: [f32; 3],
    /// Where it begins.
    pub tmin: f32,
    pub near: [f32; 3],
    /// What is farther is passed over.
    pub end: f32,
    /// The same as `near` for planes through which boxes are left.
    pub far: [f32; 3],
    /// Where in a node the planes lie through which boxes are entered, in bytes; [`SIDE`] tells the opposite ones.
    first: [u8; 4],
    /// Three times the octant of the direction; then nothing.
    octant: [u32; 2],
    pub stack: StackRange,
}

const _: () = assert!(size_of::<TraversalState>() == 64 && offset_of!(TraversalState, octant) == 48);

/// [`TraversalState::first`] and three times the octant for each set of axes on which the direction is negative.
static SIDES: [[u8; 4]; 8] = {
    let mut sides = [[0; 4]; 8];
    let mut set: usize = 0;
    while set < 8 {
        let mut axis = 0;
        while axis < 3 {
            sides[set][axis] = ((2 * axis + (set >> axis & 1)) * SIDE) as u8;
            axis += 1;
        }
        sides[set][3] = 3 * set as u8;
        set += 1;
    }
    sides
};

impl TraversalState {
    /// [`TraversalState::inv`], [`TraversalState::near`] and [`TraversalState::far`], each with what follows it.
    #[inline(always)]
    pub fn rows(&self) -> &[[f32; 4]; 3] {
        // SAFETY: so the fields lie, and any bits are a number.
        unsafe { &*ptr::from_ref(self).cast() }
    }

    #[inline(always)]
    pub fn rows_mut(&mut self) -> &mut [[f32; 4]; 3] {
        // SAFETY: as above, and any number is four bytes.
        unsafe { &mut *ptr::from_mut(self).cast() }
    }

    /// Sets the axes on which the direction is negative, a bit for each.
    #[inline(always)]
    pub fn set_octant(&mut self, negative: u32) {
        self.first = SIDES[negative as usize & 7];
        self.octant[0] = u32::from(self.first[3]);
    }

    /// Three times the octant of the direction, as a number of 64 bits; then anything.
    #[inline(always)]
    pub fn octant(&self) -> &[u32; 4] {
        const { assert!(size_of::<Self>() - offset_of!(Self, octant) >= size_of::<[u32; 4]>()) };
        // SAFETY: as many numbers lie there, up to the end of the whole.
        unsafe { &*ptr::from_ref(self).byte_add(offset_of!(Self, octant)).cast() }
    }

    /// On which axes boxes are entered through their larger side.
    #[inline(always)]
    pub fn negative(&self) -> [bool; 3] {
        [0, 1, 2].map(|axis| usize::from(self.first[axis]) & SIDE != 0)
    }

    /// From where to where it is in each of a node's boxes; with reciprocals of their own for the planes through which boxes are
    /// left, where it has such. A distance that is not a number does not count.
    #[inline(always)]
    pub fn cross<L: SimdLevel>(&self, level: L, node: &WideNode, inv_far: Option<&[f32; 4]>) -> (L::F8, L::F8) {
        let [inv, near, far] = self.rows();
        let [inv, near, far] = [level.four8(inv), level.four8(near), level.four8(far)];
        let inv_far = inv_far.map_or(inv, |inv| level.four8(inv));
        // SAFETY: an ordinary read, of which the compiler shall not make one of a vector, and then parts of that.
        let first = |axis: usize| usize::from(unsafe { ptr::read_volatile(&self.first[axis]) });
        let first = [first(0), first(1), first(2)];
        let meet = |axis: usize, side: usize, inv: &[L::F8; 4], shift: &[L::F8; 4]| {
            let at = first[axis] ^ side;
            debug_assert!(at.is_multiple_of(SIDE) && at < size_of_val(&node.planes));
            // SAFETY: there are six planes, and the number is twice an axis plus a side.
            let planes = unsafe { &*node.planes.as_ptr().byte_add(at) };
            level.load8(planes).mul_add(inv[axis], shift[axis])
        };
        let enter = |axis| meet(axis, 0, &inv, &near);
        let leave = |axis| meet(axis, SIDE, &inv_far, &far);
        (
            enter(0).max(enter(1).max(enter(2).max(inv[3]))),
            leave(0).min(leave(1).min(leave(2).min(near[3]))),
        )
    }

    /// Which boxes it comes to, given as the least and the greatest on each axis; for what has reciprocals of its own for leaving.
    #[inline(always)]
    pub fn meets<F: Floats>(&self, [low, high]: &[[F; 3]; 2], inv_far: &[f32; 4]) -> F::Mask {
        let negative = self.negative();
        let (mut enter, mut leave) = (low[0].fill(self.tmin), low[0].fill(self.end));
        for axis in 0..3 {
            let (near, far) = if negative[axis] {
                (high[axis], low[axis])
            } else {
                (low[axis], high[axis])
            };
            let (inv, inv_far) = (near.fill(self.inv[axis]), near.fill(inv_far[axis]));
            enter = near.mul_add(inv, near.fill(self.near[axis])).max(enter);
            leave = far.mul_add(inv_far, near.fill(self.far[axis])).min(leave);
        }
        enter.le(leave.mul(leave.fill(LEAVE)))
    }
}
