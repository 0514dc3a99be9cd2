//! Cuts through primitives: both sides get a part of what lies across.
//!
//! A wall's box is as large as the room, and with it every set that the wall is in. For [`Quality::High`] such triangles
//! may be in several leaves, each with the box around its part there.
//!
//! Only triangles in a plane across an axis are cut. Hits must not depend on the tree, and a hit is what the rounded
//! test of [`crate::shape::triangle`] says it is. In such a plane that test is accurate even along the surface. The normal
//! has one component, so `t` is that of the plane to a few roundings. A sheared corner's coordinate across the plane
//! errs by some roundings of what it is made of, and both parts shrink with the ray's slope; so the edges' tests are
//! exact for corners that lie elsewhere in the plane by less than 8 [`f32::EPSILON`] of the way to them and to the hit.
//! [`SLACK`] covers that for rays that start up to [`FAR`] times as far away as anything is, and [`super::slab`] widens
//! the boxes for others. In an inclined plane the error grows with the reciprocal of the angle, and no box but the
//! whole triangle's holds whatever may count as a hit.
//!
//! Source: Stich, Friedrich, Dietrich, "Spatial Splits in Bounding Volume Hierarchies", 2009,
//! <https://doi.org/10.1145/1572769.1572771>.
//!
//! [`Quality::High`]: super::Quality::High

use super::{
    Geometry,
    slab::FAR,
    split::{Bounds, Box4, Ref, cost},
};
use crate::math::{Aabb, Vec3};

/// How much larger than its part of the triangle a box is, relative to the largest coordinate of the scene.
const SLACK: f32 = 16.0 * FAR * f32::EPSILON;

/// Places of an axis at which cuts are tried.
const BINS: usize = 32;

/// A cut through space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub cost: f32,
    axis: usize,
    place: usize,
    bins: Slices,
    left: Box4,
    right: Box4,
    counts: [u32; 2],
}

/// An axis in equal parts.
#[derive(Clone, Copy, Debug)]
struct Slices {
    start: f32,
    width: f32,
}

impl Slices {
    fn of(&self, x: f32) -> usize {
        (((x - self.start) / self.width) as usize).min(BINS - 1)
    }

    fn from(&self, place: usize) -> f32 {
        self.start + self.width * place as f32
    }
}

/// One side of a cut.
#[derive(Default)]
pub(super) struct Side {
    pub refs: Vec<Ref>,
    pub bounds: Bounds,
}

impl Side {
    fn add(&mut self, r: Ref) {
        self.bounds.add(&r);
        self.refs.push(r);
    }
}

/// Cuts triangles.
pub(super) struct Cutter<'a> {
    pub geometry: &'a Geometry,
    /// The largest coordinate of the scene.
    pub reach: f32,
}

impl Cutter<'_> {
    /// The corners of what can be cut, and the axis that its plane lies across.
    fn flat(&self, r: &Ref) -> Option<([Vec3; 3], usize)> {
        let index = r.index() as usize;
        if index >= self.geometry.triangles.len() {
            return None;
        }
        let [a, b, c] = self.geometry.corners(index);
        let axis = (0..3).find(|&axis| a[axis] == b[axis] && b[axis] == c[axis])?;
        Some(([a, b, c], axis))
    }

    /// The part of `r` between two planes, `None` where there is none.
    fn part(&self, r: &Ref, corners: &[Vec3; 3], axis: usize, [from, to]: [f32; 2]) -> Option<Ref> {
        let mut around = Aabb::EMPTY;
        for i in 0..3 {
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            if (from..=to).contains(&p[axis]) {
                around = around.extended(p);
            }
            for plane in [from, to] {
                if (p[axis] < plane) != (q[axis] < plane) {
                    let mut at = p + (q - p) * ((plane - p[axis]) / (q[axis] - p[axis]));
                    at[axis] = plane;
                    around = around.extended(at);
                }
            }
        }
        let (own, slack) = (r.bounds(), SLACK * self.reach);
        let part = Aabb {
            min: own.min.max(around.min - slack),
            max: own.max.min(around.max + slack),
        };
        (!part.is_empty()).then(|| Ref::new(&part, r.index()))
    }

    /// The best cut through space, `None` where nothing can be cut.
    pub fn find(&self, refs: &[Ref], bounds: &Bounds, thin: f32) -> Option<Plane> {
        let all = bounds.boxes.aabb();
        let flat: Vec<_> = refs.iter().map(|r| self.flat(r)).collect();
        if flat.iter().all(Option::is_none) {
            return None;
        }
        let mut best: Option<Plane> = None;
        for axis in 0..3 {
            let bins = Slices {
                start: all.min[axis],
                width: all.extent()[axis] / BINS as f32,
            };
            if bins.width < SLACK * self.reach {
                continue;
            }
            let mut boxes = [Box4::EMPTY; BINS];
            let mut counts = [[0_u32; 2]; BINS];
            for (r, flat) in refs.iter().zip(&flat) {
                let (first, last) = self.places(r, flat.as_ref(), axis, &bins);
                counts[first][0] += 1;
                counts[last][1] += 1;
                if first == last {
                    boxes[first].add(r);
                    continue;
                }
                let corners = &flat.as_ref().expect("only what can be cut is in several places").0;
                for (place, inside) in boxes.iter_mut().enumerate().take(last + 1).skip(first) {
                    let ends = [bins.from(place), bins.from(place + 1)];
                    if let Some(part) = self.part(r, corners, axis, ends) {
                        inside.add(&part);
                    }
                }
            }
            let mut right = [(Box4::EMPTY, 0); BINS];
            let (mut around, mut count) = (Box4::EMPTY, 0);
            for i in (1..BINS).rev() {
                around = around.union(boxes[i]);
                count += counts[i][1];
                right[i] = (around, count);
            }
            let (mut around, mut count) = (Box4::EMPTY, 0);
            for i in 1..BINS {
                around = around.union(boxes[i - 1]);
                count += counts[i - 1][0];
                if count == 0 || right[i].1 == 0 {
                    continue;
                }
                let cost = cost(&around, count, thin) + cost(&right[i].0, right[i].1, thin);
                if best.is_none_or(|best| cost < best.cost) {
                    best = Some(Plane {
                        cost,
                        axis,
                        place: i,
                        bins,
                        left: around,
                        right: right[i].0,
                        counts: [count, right[i].1],
                    });
                }
            }
        }
        best
    }

    /// The first and the last place that `r` is in. What cannot be cut is where its centre is.
    fn places(&self, r: &Ref, flat: Option<&([Vec3; 3], usize)>, axis: usize, bins: &Slices) -> (usize, usize) {
        let b = r.bounds();
        if flat.is_some_and(|flat| flat.1 != axis) {
            (bins.of(b.min[axis]), bins.of(b.max[axis]))
        } else {
            let place = bins.of(b.center()[axis]);
            (place, place)
        }
    }

    /// Cuts `refs`. What lies across goes to one side alone where that is cheaper.
    pub fn cut(&self, refs: &[Ref], plane: &Plane) -> [Side; 2] {
        let Plane {
            axis,
            place,
            bins,
            mut left,
            mut right,
            counts: [mut a, mut b],
            ..
        } = *plane;
        let mut sides = [Side::default(), Side::default()];
        let at = bins.from(place);
        for r in refs {
            let flat = self.flat(r);
            let (first, last) = self.places(r, flat.as_ref(), axis, &bins);
            if last < place {
                sides[0].add(*r);
                continue;
            }
            if first >= place {
                sides[1].add(*r);
                continue;
            }
            let corners = &flat.expect("only what can be cut lies across").0;
            let parts = [[f32::NEG_INFINITY, at], [at, f32::INFINITY]].map(|ends| self.part(r, corners, axis, ends));
            let (mut with_left, mut with_right) = (left, right);
            with_left.add(r);
            with_right.add(r);
            let price = |b: &Box4, count: u32| cost(b, 1, 0.0) * count as f32;
            let both = price(&left, a) + price(&right, b);
            let only_left = price(&with_left, a) + price(&right, b - 1);
            let only_right = price(&left, a - 1) + price(&with_right, b);
            if a > 1 && b > 1 && only_left.min(only_right) < both {
                if only_left <= only_right {
                    (left, b) = (with_left, b - 1);
                    sides[0].add(*r);
                } else {
                    (right, a) = (with_right, a - 1);
                    sides[1].add(*r);
                }
                continue;
            }
            for (side, part) in sides.iter_mut().zip(parts) {
                if let Some(part) = part {
                    side.add(part);
                }
            }
        }
        sides
    }
}
