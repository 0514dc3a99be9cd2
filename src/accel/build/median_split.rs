//! Sets of boxes: the input of a build, the splitting of sets in halves, and the order of the
//! smallest sets.

use glam::Vec4;
use rayon::prelude::*;

use crate::math::{Aabb, Vec3};

/// The box of a primitive, with the primitive's index.
#[derive(Clone, Copy, Debug)]
pub struct PrimBox {
    /// The last component has the bits of the index.
    min: Vec4,
    max: Vec4,
}

impl PrimBox {
    pub fn new(bounds: &Aabb, index: u32) -> Self {
        Self {
            min: bounds.min.extend(f32::from_bits(index)),
            max: bounds.max.extend(0.0),
        }
    }

    pub fn index(&self) -> u32 {
        self.min.w.to_bits()
    }

    pub fn bounds(&self) -> Aabb {
        Aabb {
            min: self.min.truncate(),
            max: self.max.truncate(),
        }
    }

    /// Returns twice the centre.
    #[inline(always)]
    fn center(&self) -> Vec4 {
        self.min + self.max
    }
}

/// A box whose last component is unused.
#[derive(Clone, Copy, Debug)]
pub struct Box4 {
    pub min: Vec4,
    pub max: Vec4,
}

impl Box4 {
    pub const EMPTY: Self = Self {
        min: Vec4::INFINITY,
        max: Vec4::NEG_INFINITY,
    };

    pub fn add(&mut self, r: &PrimBox) {
        self.grow(r.min, r.max);
    }

    #[inline(always)]
    fn grow(&mut self, min: Vec4, max: Vec4) {
        self.min = self.min.min(min);
        self.max = self.max.max(max);
    }

    pub fn union(mut self, other: Self) -> Self {
        self.grow(other.min, other.max);
        self
    }

    pub fn aabb(&self) -> Aabb {
        Aabb {
            min: self.min.truncate(),
            max: self.max.truncate(),
        }
    }

    fn extent(&self) -> Vec3 {
        (self.max - self.min).truncate()
    }
}

/// The bounds of a set that is to be split.
#[derive(Clone, Copy, Debug)]
pub struct SetBounds {
    /// The bounds of all boxes.
    pub boxes: Box4,
    /// The bounds of twice their centres.
    centers: Box4,
}

impl Default for SetBounds {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl SetBounds {
    pub const EMPTY: Self = Self {
        boxes: Box4::EMPTY,
        centers: Box4::EMPTY,
    };

    #[inline(always)]
    pub fn add(&mut self, r: &PrimBox) {
        self.boxes.grow(r.min, r.max);
        let center = r.center();
        self.centers.grow(center, center);
    }

    pub fn union(self, other: Self) -> Self {
        Self {
            boxes: self.boxes.union(other.boxes),
            centers: self.centers.union(other.centers),
        }
    }

    pub fn of(refs: &[PrimBox]) -> Self {
        let serial = |refs: &[PrimBox]| {
            let mut bounds = Self::EMPTY;
            refs.iter().for_each(|r| bounds.add(r));
            bounds
        };
        if refs.len() < PAR_MIN_LEN {
            return serial(refs);
        }
        refs.par_chunks(PAR_MIN_LEN / 4)
            .map(serial)
            .reduce(|| Self::EMPTY, Self::union)
    }

    /// Returns the length by which edges are weighted relative to surfaces.
    pub fn thin(&self) -> f32 {
        self.boxes.extent().max_element() * EDGE_WEIGHT
    }

    /// Returns whether all boxes have the same centre.
    pub fn is_point(&self) -> bool {
        self.centers.extent().max_element() == 0.0
    }
}

/// The number of boxes from which bounds are computed in parallel.
const PAR_MIN_LEN: usize = 1 << 16;

/// The number of triangles that are tested together.
const BLOCK_TRIANGLES: usize = 4;

/// Returns half the surface area of a box, plus a small multiple of its edges, which distinguishes
/// boxes without area.
fn size(b: &Box4, thin: f32) -> f32 {
    let e = b.extent();
    e.x * e.y + e.y * e.z + e.z * e.x + thin * (e.x + e.y + e.z)
}

/// The weight of edges relative to surfaces, in units of the longest edge of all.
const EDGE_WEIGHT: f32 = 1.0 / (1 << 20) as f32;

/// Returns the cost of testing this number of triangles in a box.
fn cost(b: &Box4, count: usize, thin: f32) -> f32 {
    size(b, thin) * count.div_ceil(BLOCK_TRIANGLES) as f32
}

/// The largest set that [`cut_few`] accepts.
const MAX_CUT_PRIMS: usize = 8;

/// Splits a few triangles, at least two, where the cost by the surface area heuristic is least,
/// counting blocks of four. They are sorted along the axis of the largest extent of their centres.
/// Returns the number of triangles on the left.
pub fn cut_few(refs: &mut [PrimBox]) -> usize {
    let bounds = SetBounds::of(refs);
    let axis = bounds.centers.extent().max_position();
    let key = |r: &PrimBox| r.min[axis] + r.max[axis];
    for i in 1..refs.len() {
        let moving = refs[i];
        let at = key(&moving);
        let mut to = i;
        while to > 0 && key(&refs[to - 1]) > at {
            refs[to] = refs[to - 1];
            to -= 1;
        }
        refs[to] = moving;
    }
    let (count, thin) = (refs.len(), bounds.thin());
    let mut right = [0.0_f32; MAX_CUT_PRIMS];
    let mut all = Box4::EMPTY;
    for i in (1..count).rev() {
        all.add(&refs[i]);
        right[i] = cost(&all, count - i, thin);
    }
    let (mut best, mut middle) = (f32::INFINITY, count / 2);
    let mut all = Box4::EMPTY;
    for i in 1..count {
        all.add(&refs[i - 1]);
        let cost = cost(&all, i, thin) + right[i];
        if cost < best {
            (best, middle) = (cost, i);
        }
    }
    middle
}

/// Moves the lower half of the boxes, by their centres along the axis of their largest extent, to
/// the front. If all centres are equal, small boxes come before large ones. Returns the number of
/// boxes in front. The time is linear.
pub fn halve(refs: &mut [PrimBox], bounds: &SetBounds) -> usize {
    let extent = bounds.centers.extent();
    let axis = extent.max_position();
    let middle = refs.len() / 2;
    if extent[axis] > 0.0 {
        let key = |r: &PrimBox| (r.min[axis] + r.max[axis], r.index());
        refs.select_nth_unstable_by(middle, |a, b| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        });
    } else {
        let key = |r: &PrimBox| (r.max - r.min).truncate().element_sum();
        refs.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.index().cmp(&b.index())));
    }
    middle
}
