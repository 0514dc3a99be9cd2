//! A ray under way, and how it begins.

use super::{
    super::{
        instance::Spread,
        slab::{END, FAR, NOISE, PAD, Planes, STEEPEST, TINY},
    },
    lanes::{Floats, Level, Mask},
    query::Best,
};
use crate::{
    math::{Ray, Vec3},
    shape::triangle::Shear,
};

/// Entries below a stack's first: popping looks at eight at once. All say that the ray is done.
pub const BASE: usize = 8;

/// Bytes between the minima and the maxima of an axis in a node.
pub const SIDE: usize = 32;

/// How far the raw `t` of a triangle's hit may lie beyond the ray's ends; more than [`NOISE`] moves it, which makes up for
/// a division that is not done.
pub const BEYOND: f32 = 4.0 * NOISE;

/// A ray under way, in two cache lines. The last of four numbers is not used.
#[repr(C, align(64))]
#[derive(Clone, Default)]
pub struct Slot {
    /// See [`Planes`].
    pub inv: [f32; 4],
    pub shift_near: [f32; 4],
    pub shift_far: [f32; 4],
    /// Where in a node the planes lie that the ray enters boxes through, in bytes; [`SIDE`] tells the opposite ones.
    pub near: [u8; 3],
    /// Three times the octant of the direction.
    pub octant: u8,
    /// The stack's length, its base included.
    pub len: u32,
    pub tmin: f32,
    /// What is farther is passed over.
    pub end: f32,
    pub best: Best,
    /// Beyond these no triangle's raw `t` belongs to a hit.
    pub begin: f32,
    pub until: f32,
    /// Which ray it is.
    pub ray: u32,
    /// The origin and the direction, in the order of [`Slot::axes`].
    pub o: [f32; 3],
    pub d: [f32; 3],
    /// See [`Shear`].
    pub shear: [f32; 2],
    /// The order of the axes, the main one last; each below three.
    axes: [u8; 3],
}

impl Slot {
    /// Whether there is anything to do for the ray.
    #[inline(always)]
    pub fn start<L: Level>(&mut self, level: L, ray: &Ray, number: usize, best: Best, spread: Spread) -> bool {
        self.tmin = ray.tmin;
        self.begin = ray.tmin - ray.tmin.abs() * BEYOND;
        self.set_best(best);
        self.ray = number as u32;
        self.len = BASE as u32;
        ray.tmin <= best.t && self.set_line(level, ray, spread)
    }

    /// Goes on along the line of `ray`, which is that of the slot's ray in one space or another; whether it can meet
    /// anything.
    #[inline(always)]
    pub fn set_line<L: Level>(&mut self, level: L, ray: &Ray, spread: Spread) -> bool {
        let shear = Shear::new(&ray.d);
        self.axes = shear.axes.map(|axis| axis as u8);
        self.shear = [shear.x, shear.y];
        self.o = shear.turn(&ray.o).to_array();
        self.d = shear.turn(&ray.d).to_array();
        self.set_planes(level, ray, spread) || self.set_any_planes(ray, spread)
    }

    #[inline(always)]
    pub fn set_best(&mut self, best: Best) {
        self.best = best;
        self.end = best.t * END;
        self.until = best.t + best.t.abs() * BEYOND;
    }

    /// Does what [`Planes::new`] does, for a ray whose numbers are ordinary; whether this one's are.
    #[inline(always)]
    fn set_planes<L: Level>(&mut self, level: L, ray: &Ray, spread: Spread) -> bool {
        let o = level.load4(&[ray.o.x, ray.o.y, ray.o.z, ray.tmin]);
        let d = level.load4(&[ray.d.x, ray.d.y, ray.d.z, ray.d.x]);
        let length = d.abs();
        let inv = level.splat4(1.0).div(d);
        let negative = d.lt(level.splat4(0.0));
        let mut pad = o.abs().mul(level.splat4(PAD)).add(level.splat4(4.0 * TINY));
        if spread.origin != 0.0 {
            pad = pad.add(level.splat4(o.abs().highest() * spread.origin));
        }
        let (less, more) = (o.sub(pad), o.add(pad));
        let shift_near = less.select(negative, more).mul(inv);
        let shift_far = more.select(negative, less).mul(inv);

        let steep = level.splat4(length.highest() * (2.0 / STEEPEST));
        let most = level.splat4(f32::MAX);
        let finite = length
            .le(most)
            .and(shift_near.abs().le(most))
            .and(shift_far.abs().le(most));
        let ordinary = steep
            .lt(length)
            .and(finite)
            .and(o.abs().le(level.splat4(FAR * spread.reach)));

        self.inv = inv.to_array();
        self.shift_near = shift_near.to_array();
        self.shift_far = shift_far.to_array();
        let negative = negative.bits();
        self.set_octant([negative & 1, negative >> 1 & 1, negative >> 2 & 1]);
        ordinary.bits() == 0b1111 && ray.tmin >= 0.0
    }

    /// Does it for any ray; whether the ray can meet anything.
    #[cold]
    fn set_any_planes(&mut self, ray: &Ray, spread: Spread) -> bool {
        let planes = Planes::new(ray, spread);
        self.inv = planes.inv.extend(0.0).to_array();
        self.shift_near = planes.shift_near.extend(0.0).to_array();
        self.shift_far = planes.shift_far.extend(0.0).to_array();
        self.set_octant(planes.negative.map(u32::from));
        planes.alive
    }

    #[inline(always)]
    fn set_octant(&mut self, negative: [u32; 3]) {
        let [x, y, z] = negative;
        let side = SIDE as u32;
        self.near = [x * side, (2 + y) * side, (4 + z) * side].map(|at| at as u8);
        self.octant = 3 * (x | y << 1 | z << 2) as u8;
    }

    /// `rows` of a corner in the order of the axes.
    #[inline(always)]
    pub fn turn<'a, T>(&self, rows: &'a [T; 3]) -> [&'a T; 3] {
        let [x, y, z] = self.axes;
        debug_assert!(x < 3 && y < 3 && z < 3);
        // SAFETY: [`Shear`]'s axes are below three.
        unsafe {
            [
                rows.get_unchecked(usize::from(x)),
                rows.get_unchecked(usize::from(y)),
                rows.get_unchecked(usize::from(z)),
            ]
        }
    }

    /// The origin or the direction in the order of the world's axes.
    #[inline(always)]
    pub fn turn_back(&self, v: &[f32; 3]) -> Vec3 {
        let mut world = [0.0; 3];
        for (axis, x) in self.axes.iter().zip(v) {
            world[usize::from(*axis)] = *x;
        }
        Vec3::from_array(world)
    }

    /// On which axes the ray enters boxes through their larger side.
    #[inline(always)]
    pub fn negative(&self) -> [bool; 3] {
        self.near.map(|at| usize::from(at) & SIDE != 0)
    }
}
