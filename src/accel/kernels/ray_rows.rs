//! Loading of rays as vectors of four elements.

use std::{mem::offset_of, ptr};

use crate::{math::Ray, simd::lanes::SimdLevel};

/// Returns a ray's origin and `tmin`, then its direction and `tmax`.
#[inline(always)]
pub fn numbers(ray: &Ray) -> &[f32; 8] {
    const { assert!(size_of::<Ray>() == 32 && offset_of!(Ray, d) == 16) };
    // SAFETY: this is the layout of the eight floats.
    unsafe { &*ptr::from_ref(ray).cast() }
}

#[inline(always)]
pub fn fours<L: SimdLevel>(level: L, x: &[f32; 8]) -> [L::F4; 2] {
    let [a, b] = x.as_chunks().0 else {
        unreachable!("eight are twice four")
    };
    [level.load4(a), level.load4(b)]
}
