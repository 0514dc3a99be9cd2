//! The triangle test of [`crate::shape::triangle`] and clipping as in [`crate::geometry::slab`],
//! vectorised: four triangles and one ray, or one triangle and sixteen rays.
//!
//! The operations and their order are those of the scalar routines, without fused multiply-add. So
//! every lane has the bits that [`crate::geometry::Geometry::intersect`] returns.

use crate::{
    geometry::slab::{CLIP_SLACK, MAX_T_NOISE, MIN_PADDING},
    simd::lanes::{Floats, Mask, SimdLevel},
};

/// The padding of triangles' bounds, relative to the larger coordinate.
pub const PADDING: f32 = 4.0 * f32::EPSILON;

pub type Vec3s<F> = [F; 3];

/// The vertices of triangles relative to a ray's origin, in the order of its [`Shear::axes`].
///
/// [`Shear::axes`]: crate::shape::triangle::Shear::axes
pub type Corners<F> = [Vec3s<F>; 3];

/// The distances from a ray's origin to the planes of triangles' bounds, the entry planes first, in
/// the order of the world's axes.
#[derive(Clone, Copy)]
pub struct Faces<F> {
    pub near: Vec3s<F>,
    pub far: Vec3s<F>,
}

/// The edge functions of lines and triangles.
pub struct Sides<F: Floats> {
    /// The lanes in which all three edge functions have the same sign.
    pub inside: F::Mask,
    u: F,
    v: F,
    w: F,
}

/// The terms of the intersections of lines and triangles.
#[derive(Clone, Copy)]
pub struct Crossing<T> {
    u: T,
    v: T,
    w: T,
    det: T,
    /// `t` times [`Crossing::det`].
    t_det: T,
}

impl<F: Floats<Array = [f32; 8]>> Crossing<F> {
    #[inline(always)]
    pub fn to_arrays(self) -> Crossing<[f32; 8]> {
        Crossing {
            u: self.u.to_array(),
            v: self.v.to_array(),
            w: self.w.to_array(),
            det: self.det.to_array(),
            t_det: self.t_det.to_array(),
        }
    }
}

impl Crossing<[f32; 8]> {
    /// Broadcasts one of the eight lanes.
    #[inline(always)]
    pub fn spread<L: SimdLevel>(&self, level: L, k: usize) -> Crossing<L::F4> {
        Crossing {
            u: level.splat4(self.u[k]),
            v: level.splat4(self.v[k]),
            w: level.splat4(self.w[k]),
            det: level.splat4(self.det[k]),
            t_det: level.splat4(self.t_det[k]),
        }
    }
}

/// Triangles that may be hit.
pub struct Candidates<F: Floats> {
    pub mask: F::Mask,
    pub crossing: Crossing<F>,
}

/// Intersections of lines and triangles.
pub struct Meets<F: Floats> {
    pub valid: F::Mask,
    pub t: F,
    pub u: F,
    pub v: F,
}

#[inline(always)]
pub fn each<F: Floats>(a: Vec3s<F>, b: Vec3s<F>, f: impl Fn(F, F) -> F) -> Vec3s<F> {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])]
}

/// Loads three rows of four triangles.
#[inline(always)]
pub fn load3<L: SimdLevel>(level: L, [x, y, z]: [&[f32; 4]; 3]) -> Vec3s<L::F4> {
    [level.load4(x), level.load4(y), level.load4(z)]
}

/// Broadcasts one triangle's element to all rays.
#[inline(always)]
pub fn spread<L: SimdLevel>(level: L, [x, y, z]: [&[f32; 4]; 3], k: usize) -> Vec3s<L::F16> {
    [level.splat16(x[k]), level.splat16(y[k]), level.splat16(z[k])]
}

/// Joins four elements of one block and four of another.
#[inline(always)]
pub fn join<L: SimdLevel>(level: L, first: &[f32; 4], second: &[f32; 4]) -> L::F8 {
    level.join4(level.load4(first), level.load4(second))
}

/// Joins three rows of each of two blocks.
#[inline(always)]
pub fn join3<L: SimdLevel>(level: L, [x, y, z]: [&[f32; 4]; 3], [x2, y2, z2]: [&[f32; 4]; 3]) -> Vec3s<L::F8> {
    [join(level, x, x2), join(level, y, y2), join(level, z, z2)]
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

#[inline(always)]
fn flat<F: Floats>(p: Vec3s<F>, shear: [F; 2]) -> [F; 2] {
    [p[0].sub(shear[0].mul(p[2])), p[1].sub(shear[1].mul(p[2]))]
}

#[inline(always)]
fn edge<F: Floats>(p: [F; 2], q: [F; 2]) -> F {
    p[0].mul(q[1]).sub(p[1].mul(q[0]))
}

/// Evaluates the edge functions for rays that `shear` aligns with their main axis.
#[inline(always)]
pub fn sides<F: Floats>(corners: &Corners<F>, shear: [F; 2]) -> Sides<F> {
    let [a, b, c] = *corners;
    let (a, b, c) = (flat(a, shear), flat(b, shear), flat(c, shear));
    let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
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

/// The planes of triangles.
pub struct TrianglePlane<F> {
    pub normal: Vec3s<F>,
    /// The dot product of the normal and the vector from the ray's origin to the plane.
    pub distance: F,
}

#[inline(always)]
pub fn plane<F: Floats>(corners: &Corners<F>) -> TrianglePlane<F> {
    let [a, b, c] = *corners;
    let normal = cross(each(a, c, F::sub), each(b, a, F::sub));
    TrianglePlane {
        normal,
        distance: dot(normal, a),
    }
}

/// Returns the lanes that pass the edge tests and whose intersection is between `begin` and
/// `until`. These extend beyond the rays' ends so far that no hit is lost. A candidate may be no
/// hit; [`meet`] decides.
#[inline(always)]
pub fn candidates<F: Floats>(
    d: Vec3s<F>,
    plane: &TrianglePlane<F>,
    sides: Sides<F>,
    begin: F,
    until: F,
) -> Candidates<F> {
    let det = dot(plane.normal, d);
    let t_det = plane.distance;
    let scale = det.abs();
    let t = t_det.with_sign_of(det);
    let begun = begin.mul(scale).le(t);
    let ended = t.le(until.mul(scale));
    let Sides { inside, u, v, w } = sides;
    Candidates {
        mask: inside.and(begun).and(ended),
        crossing: Crossing { u, v, w, det, t_det },
    }
}

/// Computes the bounds from world-space vertices, for rays that enter boxes through the upper side
/// on the `negative` axes.
#[inline(always)]
pub fn faces<F: Floats>(o: &Vec3s<F>, negative: [bool; 3], corners: &[Vec3s<F>; 3]) -> Faces<F> {
    let tiny = o[0].fill(MIN_PADDING);
    let [mut near, mut far] = boxes(corners);
    for axis in 0..3 {
        let low = near[axis].sub(o[axis]).sub(tiny);
        let high = far[axis].sub(o[axis]).add(tiny);
        (near[axis], far[axis]) = if negative[axis] { (high, low) } else { (low, high) };
    }
    Faces { near, far }
}

/// Returns triangles' bounds as [`crate::geometry::Geometry::bounds`] does.
#[inline(always)]
pub fn boxes<F: Floats>(corners: &[Vec3s<F>; 3]) -> [Vec3s<F>; 2] {
    let [a, b, c] = *corners;
    let padding = a[0].fill(PADDING);
    let mut low = each(each(a, b, F::min), c, F::min);
    let mut high = each(each(a, b, F::max), c, F::max);
    for axis in 0..3 {
        let (min, max) = (low[axis], high[axis]);
        let pad = min.abs().max(max.abs()).mul(padding);
        (low[axis], high[axis]) = (min.sub(pad), max.add(pad));
    }
    [low, high]
}

/// Returns the intervals of lines in triangles' bounds; `inv` is
/// [`crate::geometry::slab::reciprocal`] of the direction.
#[inline(always)]
pub fn stretch<F: Floats>(inv: &Vec3s<F>, faces: &Faces<F>) -> [F; 2] {
    let near = each(faces.near, *inv, F::mul);
    let far = each(faces.far, *inv, F::mul);
    let mut enter = near[0].fill(f32::NEG_INFINITY);
    let mut leave = far[0].fill(f32::INFINITY);
    for axis in 0..3 {
        enter = near[axis].max(enter);
        leave = far[axis].min(leave);
    }
    [enter, leave]
}

/// Intersects candidate lines with the planes and clips the hits to the triangles' bounds.
#[inline(always)]
pub fn meet<F: Floats>([enter, leave]: [F; 2], crossing: &Crossing<F>) -> Meets<F> {
    let Crossing { u, v, w, det, t_det } = *crossing;
    let zero = u.fill(0.0);
    let infinity = u.fill(f32::INFINITY);
    let raw = t_det.div(det);
    let sum = u.add(v).add(w);
    // So `raw` is finite and the barycentric coordinates are not NaN. They are not computed here,
    // since not all callers need them.
    let valid = raw.abs().max(v.abs()).max(w.abs()).lt(infinity).and(sum.ne(zero));

    let slack = u.fill(CLIP_SLACK);
    let enter = enter.sub(enter.abs().mul(slack));
    let leave = leave.add(leave.abs().mul(slack));
    let t = raw.max(enter).min(leave).add(zero);
    let near = t.sub(raw).abs().le(raw.abs().mul(raw.fill(MAX_T_NOISE)));
    Meets {
        valid: valid.and(enter.le(leave)).and(near),
        t,
        u: v.div(sum),
        v: w.div(sum),
    }
}
