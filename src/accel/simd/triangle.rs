//! The triangle test of [`crate::shape::triangle`] and the rule of [`super::super::slab`], many at once: four triangles
//! and a ray, or a triangle and sixteen rays.
//!
//! The operations and their order are those of the scalar routines and nothing is fused, so every lane has the bits
//! that [`super::super::Geometry::intersect`] gives.

use super::{
    super::slab::{CLIP_SLACK, TINY},
    lanes::{Floats, Mask},
};

pub type Vec3s<F> = [F; 3];

/// The line of a ray, or of sixteen that enter boxes through the same sides.
#[derive(Clone, Copy)]
pub struct Line<F> {
    pub o: Vec3s<F>,
    pub d: Vec3s<F>,
    /// [`super::super::slab::reciprocal`] of it.
    pub inv: Vec3s<F>,
    pub negative: [bool; 3],
}

/// What the edge tests leave behind.
pub struct Edges<F: Floats> {
    /// Where the line passes on the same side of all three edges.
    pub inside: F::Mask,
    u: F,
    v: F,
    w: F,
    a: Vec3s<F>,
    e1: Vec3s<F>,
    e2: Vec3s<F>,
}

/// Where lines meet triangles.
pub struct Meets<F: Floats> {
    pub valid: F::Mask,
    pub t: F,
    pub u: F,
    pub v: F,
}

#[inline(always)]
fn each<F: Floats>(a: Vec3s<F>, b: Vec3s<F>, f: impl Fn(F, F) -> F) -> Vec3s<F> {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])]
}

#[inline(always)]
fn cross<F: Floats>(a: Vec3s<F>, b: Vec3s<F>) -> Vec3s<F> {
    [
        a[1].mul(b[2]).sub(b[1].mul(a[2])),
        a[2].mul(b[0]).sub(b[2].mul(a[0])),
        a[0].mul(b[1]).sub(b[0].mul(a[1])),
    ]
}

#[inline(always)]
fn dot<F: Floats>(a: Vec3s<F>, b: Vec3s<F>) -> F {
    a[0].mul(b[0]).add(a[1].mul(b[1])).add(a[2].mul(b[2]))
}

/// The edge tests: all that most triangles need.
///
/// A NaN anywhere may pass or not; it does not pass [`meet`].
#[inline(always)]
pub fn edges<F: Floats>(line: &Line<F>, corners: &[Vec3s<F>; 3]) -> Edges<F> {
    let a = each(corners[0], line.o, F::sub);
    let b = each(corners[1], line.o, F::sub);
    let c = each(corners[2], line.o, F::sub);
    let (e0, e1, e2) = (each(c, b, F::sub), each(a, c, F::sub), each(b, a, F::sub));
    let u = dot(cross(each(c, b, F::add), e0), line.d);
    let v = dot(cross(each(a, c, F::add), e1), line.d);
    let w = dot(cross(each(b, a, F::add), e2), line.d);
    let zero = u.fill(0.0);
    let smallest = u.min(v).min(w);
    let largest = u.max(v).max(w);
    Edges {
        inside: zero.le(smallest).or(largest.le(zero)),
        u,
        v,
        w,
        a,
        e1,
        e2,
    }
}

/// Where the lines that are inside meet the planes, brought into the triangles' own boxes.
#[inline(always)]
pub fn meet<F: Floats>(line: &Line<F>, corners: &[Vec3s<F>; 3], edges: &Edges<F>) -> Meets<F> {
    let zero = edges.u.fill(0.0);
    let lowest = edges.u.fill(f32::NEG_INFINITY);
    let n = cross(edges.e1, edges.e2);
    let det = dot(n, line.d);
    let t = dot(n, edges.a).div(det);
    let sum = edges.u.add(edges.v).add(edges.w);
    let (u, v) = (edges.v.div(sum), edges.w.div(sum));
    let numbers = u.eq(u).and(v.eq(v)).and(lowest.lt(t));
    let valid = det.differs(zero).and(sum.differs(zero)).and(numbers).and(edges.inside);

    let tiny = edges.u.fill(TINY);
    let slack = edges.u.fill(CLIP_SLACK);
    let padding = edges.u.fill(4.0 * f32::EPSILON);
    let mut enter = lowest;
    let mut leave = edges.u.fill(f32::INFINITY);
    for axis in 0..3 {
        let [a, b, c] = [corners[0][axis], corners[1][axis], corners[2][axis]];
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        let pad = min.abs().max(max.abs()).mul(padding);
        let (min, max) = (min.sub(pad), max.add(pad));
        let (o, inv) = (line.o[axis], line.inv[axis]);
        let (near, far) = if line.negative[axis] {
            (max.sub(o).add(tiny), min.sub(o).sub(tiny))
        } else {
            (min.sub(o).sub(tiny), max.sub(o).add(tiny))
        };
        enter = near.mul(inv).max(enter);
        leave = far.mul(inv).min(leave);
    }
    let enter = enter.sub(enter.abs().mul(slack));
    let leave = leave.add(leave.abs().mul(slack));
    let t = t.max(enter).min(leave).add(zero);
    Meets {
        valid: valid.and(enter.le(leave)),
        t,
        u,
        v,
    }
}
