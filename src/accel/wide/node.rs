//! The nodes of the wide tree.

use crate::math::{Aabb, Vec3};

/// The lowest four bits of a child are its kind; the bits above are its number. Leaf flag.
pub const LEAF: u32 = 1;

/// With [`LEAF`]: one analytic primitive, whose id is the number. Without: the end of a ray's
/// stack.
pub const SHAPE: u32 = 1 << 1;

/// With [`LEAF`] and [`SHAPE`]: an instance, whose id is the number, or [`EXIT`].
pub const INSTANCE: u32 = 1 << 2;

/// On a ray's stack: the end of an instance's subtree.
pub const EXIT: u32 = LEAF | SHAPE | INSTANCE | 1 << 3;

/// An absent child. Its box is inverted, so it is hit only by a ray for which no plane has a finite
/// distance.
pub const EMPTY: u32 = u32::MAX;

/// The end of a ray's stack.
pub const DONE: u32 = SHAPE;

/// The largest number of blocks in a leaf.
pub const MAX_LEAF: usize = 4;

/// The size in bytes of which nodes and blocks are multiples. Children are numbered in these units,
/// so that an address is a shift away.
pub const UNIT: usize = 32;

const NODE_UNITS: usize = size_of::<WideNode>() / UNIT;
const BLOCK_UNITS: usize = size_of::<TriangleBlock>() / UNIT;

/// The position of a leaf's block count minus one, above [`SHAPE`].
const COUNT: u32 = 2;

/// The position of a child's number, in [`UNIT`]s for nodes and blocks.
const NUMBER: u32 = 4;

/// The largest number of nodes and blocks of all trees.
pub const MAX_NODES: usize = MAX_PRIMS / NODE_UNITS;
pub const MAX_BLOCKS: usize = MAX_PRIMS / BLOCK_UNITS;

/// The largest number of primitives and instances that fit into a child's number.
pub const MAX_PRIMS: usize = 1 << (32 - NUMBER);

/// Up to eight boxes and their contents, in four cache lines.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct WideNode {
    /// Minima and maxima of x, then y, then z.
    pub planes: [[f32; 8]; 6],
    /// Each is an [`inner`] node, a [`leaf`], a shape or an instance.
    pub child: [u32; 8],
    /// For each octant of directions, three bits give the child at this place in front-to-back
    /// order. Bit k of an octant's index is set if the direction is negative on axis k. Occlusion
    /// rays visit the children in storage order.
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

/// A block of four triangles.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct TriangleBlock {
    /// Indexed by vertex (a, b, c), axis and triangle. NaN where there is no triangle.
    pub corners: [[[f32; 4]; 3]; 3],
    /// The [`PrimId::key`](crate::geometry::PrimId::key) of each triangle.
    pub keys: [u32; 4],
}

impl TriangleBlock {
    pub const NOTHING: Self = Self {
        corners: [[[f32::NAN; 4]; 3]; 3],
        keys: [u32::MAX; 4],
    };

    pub fn set(&mut self, lane: usize, corners: [Vec3; 3], key: u32) {
        for (to, from) in self.corners.iter_mut().zip(corners) {
            for axis in 0..3 {
                to[axis][lane] = from[axis];
            }
        }
        self.keys[lane] = key;
    }
}

/// Returns the child for the inner node `index`.
pub fn inner(index: usize) -> u32 {
    ((index * NODE_UNITS) as u32) << NUMBER
}

/// Returns the child for a leaf of the blocks `first .. first + count`.
pub fn leaf(first: usize, count: usize) -> u32 {
    LEAF | (count as u32 - 1) << COUNT | ((first * BLOCK_UNITS) as u32) << NUMBER
}

/// Returns the child for an analytic primitive.
pub const fn shape(number: u32) -> u32 {
    LEAF | SHAPE | number << NUMBER
}

/// Returns the child for an instance.
pub const fn instance(number: u32) -> u32 {
    LEAF | SHAPE | INSTANCE | number << NUMBER
}

/// Returns the id of a shape or an instance.
#[inline(always)]
pub fn number(child: u32) -> u32 {
    child >> NUMBER
}

/// Returns the node index of an inner child.
pub fn index(child: u32) -> usize {
    number(child) as usize / NODE_UNITS
}

/// Returns the range of a leaf's blocks.
pub fn blocks(child: u32) -> std::ops::Range<usize> {
    let first = number(child) as usize / BLOCK_UNITS;
    first..first + count(child)
}

/// Returns the number of blocks in a leaf.
#[inline(always)]
pub fn count(child: u32) -> usize {
    (child >> COUNT & 3) as usize + 1
}

/// The number of bytes per unit of a child's encoded number.
const STEP: usize = UNIT >> NUMBER;

/// Returns the byte offset of a child's node or blocks from the start of the tree's array.
#[inline(always)]
pub fn offset(child: u32) -> usize {
    (child & !((1 << NUMBER) - 1)) as usize * STEP
}

/// Returns the same offset plus the flags. They add less than a [`UNIT`], so the address is in the
/// same cache line.
#[inline(always)]
pub fn offset_nearly(child: u32) -> usize {
    const { assert!(((1 << NUMBER) - 1) * STEP < UNIT) };
    child as usize * STEP
}

/// Returns the same offset for an inner node, which has no flags.
#[inline(always)]
pub fn node_offset(child: u32) -> usize {
    debug_assert_eq!(child, inner(index(child)));
    child as usize * STEP
}

/// Returns a child after its tree's nodes and blocks were moved by these counts.
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
