//! The triangle test of [`crate::shape::triangle`] and the rule of [`super::super::slab`], many at once: four triangles
//! and a ray, or a triangle and sixteen rays.
//!
//! The operations and their order are those of the scalar routines and nothing is fused, so every lane has the bits
//! that [`super::super::Geometry::intersect`] gives.

use super::{
    super::slab::{CLIP_SLACK, NOISE, TINY},
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

/// What of a triangle's test depends on the ray's origin alone.
pub struct Seen<F> {
    /// For each edge the normal of the plane through it and the origin.
    pub edges: [Vec3s<F>; 3],
    pub normal: Vec3s<F>,
    /// The normal times the way to the plane.
    pub distance: F,
}

/// On which sides of the edges lines pass.
pub struct Sides<F: Floats> {
    /// Where it is the same side of all three.
    pub inside: F::Mask,
    u: F,
    v: F,
    w: F,
}

/// Triangles that may be hit, with what tells where.
pub struct Candidates<F: Floats> {
    pub mask: F::Mask,
    sides: Sides<F>,
    det: F,
    /// `t` times [`Candidates::det`].
    t_det: F,
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

/// Triangles as they are seen from `o`.
#[inline(always)]
pub fn see<F: Floats>(o: Vec3s<F>, corners: &[Vec3s<F>; 3]) -> Seen<F> {
    let a = each(corners[0], o, F::sub);
    let b = each(corners[1], o, F::sub);
    let c = each(corners[2], o, F::sub);
    let (e0, e1, e2) = (each(c, b, F::sub), each(a, c, F::sub), each(b, a, F::sub));
    let normal = cross(e1, e2);
    Seen {
        edges: [
            cross(each(c, b, F::add), e0),
            cross(each(a, c, F::add), e1),
            cross(each(b, a, F::add), e2),
        ],
        normal,
        distance: dot(normal, a),
    }
}

/// The edge tests.
#[inline(always)]
pub fn sides<F: Floats>(d: Vec3s<F>, seen: &Seen<F>) -> Sides<F> {
    let u = dot(seen.edges[0], d);
    let v = dot(seen.edges[1], d);
    let w = dot(seen.edges[2], d);
    let zero = u.fill(0.0);
    let smallest = u.min(v).min(w);
    let largest = u.max(v).max(w);
    Sides {
        inside: zero.le(smallest).or(largest.le(zero)),
        u,
        v,
        w,
    }
}

/// Which lines that are inside are so between their rays' ends, roughly: what does not pass is no hit; what passes may
/// be none, [`meet`] decides. The ends are widened by twice what [`NOISE`] allows, which makes up for the division that
/// is not done.
#[inline(always)]
pub fn candidates<F: Floats>(d: Vec3s<F>, seen: &Seen<F>, sides: Sides<F>, tmin: F, tmax: F) -> Candidates<F> {
    let det = dot(seen.normal, d);
    let t_det = seen.distance;
    let scale = det.abs();
    let t = t_det.with_sign_of(det);
    let noise = t.abs().mul(t.fill(2.0 * NOISE));
    let begun = tmin.mul(scale).le(t.add(noise));
    let ended = t.sub(noise).le(tmax.mul(scale));
    Candidates {
        mask: sides.inside.and(begun).and(ended),
        sides,
        det,
        t_det,
    }
}

/// Where the candidates meet the planes, brought into the triangles' own boxes.
#[inline(always)]
pub fn meet<F: Floats>(line: &Line<F>, corners: &[Vec3s<F>; 3], candidates: &Candidates<F>) -> Meets<F> {
    let zero = candidates.sides.u.fill(0.0);
    let infinity = candidates.sides.u.fill(f32::INFINITY);
    let raw = candidates.t_det.div(candidates.det);
    let sum = candidates.sides.u.add(candidates.sides.v).add(candidates.sides.w);
    let (u, v) = (candidates.sides.v.div(sum), candidates.sides.w.div(sum));
    let numbers = u.eq(u).and(v.eq(v)).and(raw.abs().lt(infinity));
    let valid = candidates
        .det
        .differs(zero)
        .and(sum.differs(zero))
        .and(numbers)
        .and(candidates.mask);

    let tiny = candidates.sides.u.fill(TINY);
    let slack = candidates.sides.u.fill(CLIP_SLACK);
    let padding = candidates.sides.u.fill(4.0 * f32::EPSILON);
    let mut enter = candidates.sides.u.fill(f32::NEG_INFINITY);
    let mut leave = infinity;
    let [a, b, c] = *corners;
    let least = each(each(a, b, F::min), c, F::min);
    let most = each(each(a, b, F::max), c, F::max);
    for axis in 0..3 {
        let (min, max) = (least[axis], most[axis]);
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
    let t = raw.max(enter).min(leave).add(zero);
    let near = t.sub(raw).abs().le(raw.abs().mul(raw.fill(NOISE)));
    Meets {
        valid: valid.and(enter.le(leave)).and(near),
        t,
        u,
        v,
    }
}
