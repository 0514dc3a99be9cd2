//! What the wide tree is made of.

use crate::math::{Aabb, Vec3};

/// What a child is; its number is in the lower bits.
pub const LEAF: u32 = 1 << 31;

/// With [`LEAF`]: one analytic primitive, whose number follows. Without: the end of a ray's stack.
pub const SHAPE: u32 = 1 << 30;

/// With [`LEAF`] and [`SHAPE`]: an instance, whose number follows, or [`EXIT`].
pub const INSTANCE: u32 = 1 << 29;

/// On a ray's stack: the end of what is in an instance.
pub const EXIT: u32 = LEAF | SHAPE | INSTANCE | (INSTANCE - 2);

/// No child. Its box is inside out, so it is met only by a ray for which no plane has a finite distance.
pub const EMPTY: u32 = u32::MAX;

/// The end of a ray's stack.
pub const DONE: u32 = SHAPE;

/// The most blocks in a leaf.
pub const MAX_BLOCKS: usize = 4;

/// The most primitives and instances that children's numbers have room for.
pub const MAX_PRIMS: usize = 1 << 28;

/// Up to eight boxes with what is in them: four cache lines.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Minima and maxima in turn: x, y, z.
    pub planes: [[f32; 8]; 6],
    /// An inner node's number; a leaf's first block times four and its number of blocks less one; a shape; or
    /// an instance.
    pub child: [u32; 8],
    /// For each octant of directions, three bits that say which child comes at this place, the farthest first. Bit k of
    /// an octant's number is set where directions are negative on axis k.
    pub order: [u32; 8],
}

impl Node {
    pub const NOTHING: Self = Self {
        planes: [
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
        ],
        child: [EMPTY; 8],
        order: [0; 8],
    };

    pub fn set(&mut self, lane: usize, bounds: &Aabb, child: u32) {
        for axis in 0..3 {
            self.planes[2 * axis][lane] = bounds.min[axis];
            self.planes[2 * axis + 1][lane] = bounds.max[axis];
        }
        self.child[lane] = child;
    }

    pub fn bounds(&self, lane: usize) -> Aabb {
        let side = |k: usize| Vec3::new(self.planes[k][lane], self.planes[k + 2][lane], self.planes[k + 4][lane]);
        Aabb {
            min: side(0),
            max: side(1),
        }
    }
}

/// Four triangles.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// Corners a, b, c; of each the axes; of each the triangles. NaN where there is no triangle.
    pub corners: [[[f32; 4]; 3]; 3],
    /// The primitives' numbers plus one.
    pub ids: [u32; 4],
}

impl Block {
    pub const NOTHING: Self = Self {
        corners: [[[f32::NAN; 4]; 3]; 3],
        ids: [u32::MAX; 4],
    };

    pub fn set(&mut self, lane: usize, corners: [Vec3; 3], id: u32) {
        for (to, from) in self.corners.iter_mut().zip(corners) {
            for axis in 0..3 {
                to[axis][lane] = from[axis];
            }
        }
        self.ids[lane] = id + 1;
    }
}

/// A child that is the blocks `first .. first + count`.
pub fn leaf(first: usize, count: usize) -> u32 {
    LEAF | (first as u32) << 2 | (count as u32 - 1)
}

/// The blocks of a leaf.
#[inline(always)]
pub fn blocks(child: u32) -> std::ops::Range<usize> {
    let first = (child & !LEAF) as usize >> 2;
    first..first + (child as usize & 3) + 1
}
