//! The state of a ray or a packet that the traversal of inner nodes needs.

use std::{mem::offset_of, ptr};

use super::stack::StackRange;
use crate::{
    accel::wide::node::WideNode,
    geometry::slab::EXIT_PADDING,
    simd::lanes::{Floats, SimdLevel},
};

/// The distance in bytes between the minima and the maxima of an axis in a node.
pub const SIDE: usize = 32;

/// The part of a ray or a packet that the passes over nodes read: one cache line.
///
/// A processor loads half as many vectors per cycle as it computes. So four numbers are loaded at a
/// time and broadcast from there.
#[repr(C)]
#[derive(Clone, Default)]
pub struct TraversalState {
    /// The distance to a plane at `b` through which boxes are entered is `b * inv + near`.
    pub inv: [f32; 3],
    /// The start.
    pub tmin: f32,
    pub near: [f32; 3],
    /// The end: boxes beyond it are culled.
    pub end: f32,
    /// The same as `near`, for planes through which boxes are left.
    pub far: [f32; 3],
    /// The byte offsets in a node of the planes through which boxes are entered. Their exclusive or
    /// with [`SIDE`] gives the opposite planes.
    first: [u8; 4],
    /// Three times the octant of the direction; the second element is zero.
    octant: [u32; 2],
    pub stack: StackRange,
}

const _: () = assert!(size_of::<TraversalState>() == 64 && offset_of!(TraversalState, octant) == 48);

/// [`TraversalState::first`] and three times the octant, for each set of axes on which the
/// direction is negative.
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
    /// Returns [`TraversalState::inv`], [`TraversalState::near`] and [`TraversalState::far`], each
    /// with the field after it.
    #[inline(always)]
    pub fn rows(&self) -> &[[f32; 4]; 3] {
        // SAFETY: this is the layout of the fields, and every bit pattern is a valid number.
        unsafe { &*ptr::from_ref(self).cast() }
    }

    #[inline(always)]
    pub fn rows_mut(&mut self) -> &mut [[f32; 4]; 3] {
        // SAFETY: as above; every number is a valid bit pattern of four bytes.
        unsafe { &mut *ptr::from_mut(self).cast() }
    }

    /// Sets the axes on which the direction is negative, one bit each.
    #[inline(always)]
    pub fn set_octant(&mut self, negative: u32) {
        self.first = SIDES[negative as usize & 7];
        self.octant[0] = u32::from(self.first[3]);
    }

    /// Returns three times the octant of the direction as a 64-bit number, and then two arbitrary
    /// elements.
    #[inline(always)]
    pub fn octant(&self) -> &[u32; 4] {
        const { assert!(size_of::<Self>() - offset_of!(Self, octant) >= size_of::<[u32; 4]>()) };
        // SAFETY: the four elements are inside the struct.
        unsafe { &*ptr::from_ref(self).byte_add(offset_of!(Self, octant)).cast() }
    }

    /// Returns the axes on which boxes are entered through their upper side.
    #[inline(always)]
    pub fn negative(&self) -> [bool; 3] {
        [0, 1, 2].map(|axis| usize::from(self.first[axis]) & SIDE != 0)
    }

    /// Returns the entry and exit distances of a node's boxes. `inv_far` are the reciprocals for
    /// exit planes, if they differ from those for entry planes. Distances that are NaN are ignored.
    #[inline(always)]
    pub fn intersect_node<L: SimdLevel>(
        &self,
        level: L,
        node: &WideNode,
        inv_far: Option<&[f32; 4]>,
    ) -> (L::F8, L::F8) {
        let [inv, near, far] = self.rows();
        let [inv, near, far] = [level.four8(inv), level.four8(near), level.four8(far)];
        let inv_far = inv_far.map_or(inv, |inv| level.four8(inv));
        // SAFETY: a normal read. It is volatile so that the compiler does not load a vector and
        // extract its elements.
        let first = |axis: usize| usize::from(unsafe { ptr::read_volatile(&self.first[axis]) });
        let first = [first(0), first(1), first(2)];
        let meet = |axis: usize, side: usize, inv: &[L::F8; 4], shift: &[L::F8; 4]| {
            let at = first[axis] ^ side;
            debug_assert!(at.is_multiple_of(SIDE) && at < size_of_val(&node.planes));
            // SAFETY: there are six planes, and the index is twice an axis plus a side.
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

    /// Returns which of these boxes, given by their minima and maxima, are hit. `inv_far` are the
    /// reciprocals for exit planes.
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
        enter.le(leave.mul(leave.fill(EXIT_PADDING)))
    }
}
