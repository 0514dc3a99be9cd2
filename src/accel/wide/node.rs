//! What the wide tree is made of.

use crate::math::{Aabb, Vec3};

/// What a child is, in the lowest four bits; its number is above them.
pub const LEAF: u32 = 1;

/// With [`LEAF`]: one analytic primitive, whose number follows. Without: the end of a ray's stack.
pub const SHAPE: u32 = 1 << 1;

/// With [`LEAF`] and [`SHAPE`]: an instance, whose number follows, or [`EXIT`].
pub const INSTANCE: u32 = 1 << 2;

/// On a ray's stack: the end of what is in an instance.
pub const EXIT: u32 = LEAF | SHAPE | INSTANCE | 1 << 3;

/// No child. Its box is inside out, so it is met only by a ray for which no plane has a finite distance.
pub const EMPTY: u32 = u32::MAX;

/// The end of a ray's stack.
pub const DONE: u32 = SHAPE;

/// The most blocks in a leaf.
pub const MAX_LEAF: usize = 4;

/// Bytes that nodes and blocks are multiples of: in these they are numbered, so that where they lie takes no time to
/// find.
pub const UNIT: usize = 32;

const NODE_UNITS: usize = size_of::<WideNode>() / UNIT;
const BLOCK_UNITS: usize = size_of::<TriangleBlock>() / UNIT;

/// Where the number of a leaf's blocks begins, less one: above [`SHAPE`].
const COUNT: u32 = 2;

/// Where a child's number begins: of [`UNIT`]s for nodes and blocks.
const NUMBER: u32 = 4;

/// The most nodes and blocks of all trees.
pub const MAX_NODES: usize = MAX_PRIMS / NODE_UNITS;
pub const MAX_BLOCKS: usize = MAX_PRIMS / BLOCK_UNITS;

/// The most primitives and instances that children's numbers have room for.
pub const MAX_PRIMS: usize = 1 << (32 - NUMBER);

/// Where in [`WideNode::order`] that of packets begins.
pub const FOR_PACKETS: u32 = 24;

/// Up to eight boxes with what is in them: four cache lines.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct WideNode {
    /// Minima and maxima in turn: x, y, z.
    pub planes: [[f32; 8]; 6],
    /// An [`inner`] node, a [`leaf`], a shape or an instance.
    pub child: [u32; 8],
    /// For each octant of directions, three bits that say which child comes at this place, the nearest first. Bit k of
    /// an octant's number is set where directions are negative on axis k. From bit [`FOR_PACKETS`] on the same for packets that
    /// ask whether anything is in their way; single rays that do try children as they lie.
    pub order: [u32; 8],
}

impl WideNode {
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
        order: {
            let mut order = [0; 8];
            let mut place = 0;
            while place < 8 {
                order[place] = (place as u32) << FOR_PACKETS;
                place += 1;
            }
            order
        },
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
pub struct TriangleBlock {
    /// Corners a, b, c; of each the axes; of each the triangles. NaN where there is no triangle.
    pub corners: [[[f32; 4]; 3]; 3],
    /// The primitives' numbers plus one.
    pub ids: [u32; 4],
}

impl TriangleBlock {
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

/// A child that is the inner node `index`.
pub fn inner(index: usize) -> u32 {
    ((index * NODE_UNITS) as u32) << NUMBER
}

/// A child that is the blocks `first .. first + count`.
pub fn leaf(first: usize, count: usize) -> u32 {
    LEAF | (count as u32 - 1) << COUNT | ((first * BLOCK_UNITS) as u32) << NUMBER
}

/// A child that is an analytic primitive.
pub const fn shape(number: u32) -> u32 {
    LEAF | SHAPE | number << NUMBER
}

/// A child that is an instance.
pub const fn instance(number: u32) -> u32 {
    LEAF | SHAPE | INSTANCE | number << NUMBER
}

/// The number of a shape or an instance.
#[inline(always)]
pub fn number(child: u32) -> u32 {
    child >> NUMBER
}

/// Which node an inner child is.
pub fn index(child: u32) -> usize {
    number(child) as usize / NODE_UNITS
}

/// The blocks of a leaf.
pub fn blocks(child: u32) -> std::ops::Range<usize> {
    let first = number(child) as usize / BLOCK_UNITS;
    first..first + count(child)
}

/// How many blocks a leaf has.
#[inline(always)]
pub fn count(child: u32) -> usize {
    (child >> COUNT & 3) as usize + 1
}

/// How many bytes there are in one of a child's numbers.
const STEP: usize = UNIT >> NUMBER;

/// How many bytes before a child's node or blocks the tree's begin.
#[inline(always)]
pub fn offset(child: u32) -> usize {
    (child & !((1 << NUMBER) - 1)) as usize * STEP
}

/// The same, with what the flags add: less than a [`UNIT`], so that it is in the same cache line.
#[inline(always)]
pub fn offset_nearly(child: u32) -> usize {
    const { assert!(((1 << NUMBER) - 1) * STEP < UNIT) };
    child as usize * STEP
}

/// The same of an inner node, which has no flags.
#[inline(always)]
pub fn node_offset(child: u32) -> usize {
    debug_assert_eq!(child, inner(index(child)));
    child as usize * STEP
}

/// A child after its tree's nodes and blocks were moved by so many.
pub fn moved(child: u32, nodes: isize, blocks: isize) -> u32 {
    let units = if child & LEAF == 0 {
        nodes * NODE_UNITS as isize
    } else if child & SHAPE == 0 {
        blocks * BLOCK_UNITS as isize
    } else {
        0
    };
    child.wrapping_add_signed((units as i32) << NUMBER)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_what_was_put_in() {
        for i in [0, 1, 1000, MAX_NODES - 1] {
            assert_eq!(index(inner(i)), i);
            assert_eq!(index(moved(inner(i), -(i as isize), 7)), 0);
        }
        for first in [0, 1, 1000, MAX_BLOCKS - MAX_LEAF] {
            for count in 1..=MAX_LEAF {
                assert_eq!(blocks(leaf(first, count)), first..first + count);
                let moved = moved(leaf(0, count), 7, first as isize);
                assert_eq!(blocks(moved), first..first + count);
            }
        }
        assert!(leaf(MAX_BLOCKS - MAX_LEAF, MAX_LEAF) & SHAPE == 0);
    }
}
