//! Bounds on what rounding can do, and rays that leave surfaces without an epsilon.
//!
//! Source: Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th ed., section 6.8 "Managing rounding error".

use glam::Vec3;

/// Bound on the relative error of `n` rounded operations in a row: `n u / (1 - n u)`, u = 2^-24.
pub const fn gamma(n: u32) -> f32 {
    let nu = n as f32 * (f32::EPSILON * 0.5);
    nu / (1.0 - nu)
}

/// The origin of a ray that leaves the surface point `p` towards `w`: `p` moved along `ng` just past the box of
/// its own rounding error, on the side that `w` points to.
///
/// `p_error` bounds the absolute error of each coordinate of `p`, `ng` is the unit geometric normal.
#[inline]
pub fn offset_origin(p: Vec3, p_error: Vec3, ng: Vec3, w: Vec3) -> Vec3 {
    let distance = ng.abs().dot(p_error);
    let side = if w.dot(ng) < 0.0 { -1.0 } else { 1.0 };
    let offset = ng * (side * distance);
    Vec3::new(
        next_after(p.x, offset.x),
        next_after(p.y, offset.y),
        next_after(p.z, offset.z),
    )
}

/// `p + d`, and from there the next number in the direction of `d`; `p` itself where `d` is 0. Finite numbers only.
///
/// Nobody can predict signs of directions, so none is branched on.
#[inline]
fn next_after(p: f32, d: f32) -> f32 {
    let moved = p + d;
    if moved == 0.0 {
        return f32::from_bits(1).copysign(d) * f32::from(u8::from(d != 0.0));
    }
    // In the order of their bits numbers of one sign grow away from zero.
    let inwards = ((moved.to_bits() ^ d.to_bits()) >> 31) as i32;
    let step = if d == 0.0 { 0 } else { 1 - 2 * inwards };
    f32::from_bits(moved.to_bits().wrapping_add_signed(step))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_number_is_found_from_signs_alone() {
        let numbers = [0.0, -0.0, 1e-45, 1.0, 3.7, 1e-30, 1e30, 16_777_216.0];
        for p in numbers.into_iter().flat_map(|p| [p, -p]) {
            for d in numbers.into_iter().flat_map(|d| [d, -d]) {
                let moved: f32 = p + d;
                let expected = match d.partial_cmp(&0.0) {
                    Some(std::cmp::Ordering::Greater) => moved.next_up(),
                    Some(std::cmp::Ordering::Less) => moved.next_down(),
                    _ => moved,
                };
                assert_eq!(next_after(p, d), expected, "{p} {d}");
            }
        }
    }

    #[test]
    fn offset_origin_leaves_the_error_box_on_the_side_of_the_direction() {
        let (p, e) = (Vec3::new(100.0, -3.0, 0.5), Vec3::splat(1e-5));
        for ng in [Vec3::X, Vec3::new(0.6, 0.0, -0.8)] {
            for w in [ng, -ng] {
                let o = offset_origin(p, e, ng, w);
                assert!((o - p).dot(w) >= e.dot(ng.abs()));
                assert!((o - p).length() < 1e-4);
            }
        }
    }
}
