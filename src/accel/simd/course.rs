//! Where what goes through the tree is bound for, and what waits for it there.

use super::{scratch::Ends, slot::SIDE};

/// What the passes over nodes need of a ray or a packet, besides the planes it meets.
#[repr(C)]
#[derive(Clone, Default)]
pub struct Course {
    /// Where in a node the planes lie through which boxes are entered, in bytes; [`SIDE`] tells the opposite ones.
    near: [u8; 3],
    /// Three times the octant of the direction.
    octant: u8,
    pub stack: Ends,
    /// Where it begins.
    pub tmin: f32,
    /// What is farther is passed over.
    pub end: f32,
}

/// [`Course::near`] and [`Course::octant`] for each set of axes on which the direction is negative.
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

impl Course {
    /// Sets the axes on which the direction is negative, a bit for each.
    #[inline(always)]
    pub fn set_octant(&mut self, negative: u32) {
        let [x, y, z, octant] = SIDES[negative as usize & 7];
        self.near = [x, y, z];
        self.octant = octant;
    }

    /// Three times the octant of the direction.
    #[inline(always)]
    pub fn octant(&self) -> u32 {
        u32::from(self.octant)
    }

    /// Where in a node the planes lie through which boxes are entered on an axis, in bytes.
    #[inline(always)]
    pub fn near(&self, axis: usize) -> usize {
        usize::from(self.near[axis])
    }

    /// The same for where they are left.
    #[inline(always)]
    pub fn far(&self, axis: usize) -> usize {
        self.near(axis) ^ SIDE
    }

    /// On which axes boxes are entered through their larger side.
    #[inline(always)]
    pub fn negative(&self) -> [bool; 3] {
        self.near.map(|at| usize::from(at) & SIDE != 0)
    }
}
