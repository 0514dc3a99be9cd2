//! Edge functions of triangles for lines through one origin, as functions of a line's shear.

use super::singles::BLOCK_TRIANGLES;
use crate::{accel::kernels::triangle::Vec3s, simd::lanes::Floats};

/// The edge functions of a block's triangles for lines through one common origin.
#[derive(Clone, Copy)]
pub struct Edges {
    /// A line with the shear `[s, t]` passes each triangle's first edge on the side that the sign
    /// of `x * s + y * t + z` gives, and likewise the other edges.
    pub sides: [[[f32; BLOCK_TRIANGLES]; 3]; 3],
    /// A bound on the error of the edge functions.
    pub margin: [f32; BLOCK_TRIANGLES],
}

/// Returns the edge function of the edge from `q` to `p`, for [`Edges::sides`].
#[inline(always)]
pub fn side<F: Floats>(p: Vec3s<F>, q: Vec3s<F>) -> Vec3s<F> {
    [
        p[1].mul_sub(q[2], p[2].mul(q[1])),
        p[2].mul_sub(q[0], p[0].mul(q[2])),
        p[0].mul_sub(q[1], p[1].mul(q[0])),
    ]
}

/// Evaluates an edge function.
#[inline(always)]
pub fn passed<F: Floats>([x, y, z]: Vec3s<F>, shear: [F; 2]) -> F {
    shear[0].mul_add(x, shear[1].mul_add(y, z))
}

/// Returns the minimum and the maximum of an edge function over shears of at most `half`.
#[inline(always)]
pub fn range<F: Floats>([x, y, z]: Vec3s<F>, half: [F; 2]) -> (F, F) {
    let around = half[0].mul_add(x.abs(), half[1].mul(y.abs()));
    (z.sub(around), z.add(around))
}

/// Applies a shear to a vertex.
#[inline(always)]
pub fn flat<F: Floats>([x, y, z]: Vec3s<F>, back: [F; 2]) -> Vec3s<F> {
    [back[0].mul_add(z, x), back[1].mul_add(z, y), z]
}
