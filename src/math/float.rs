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
pub fn offset_origin(p: Vec3, p_error: Vec3, ng: Vec3, w: Vec3) -> Vec3 {
    let distance = ng.abs().dot(p_error);
    let side = if w.dot(ng) < 0.0 { -1.0 } else { 1.0 };
    let offset = ng * (side * distance);
    let away = |p: f32, d: f32| {
        let moved = p + d;
        if d > 0.0 {
            moved.next_up()
        } else if d < 0.0 {
            moved.next_down()
        } else {
            moved
        }
    };
    Vec3::new(away(p.x, offset.x), away(p.y, offset.y), away(p.z, offset.z))
}

#[cfg(test)]
mod tests {
    use super::*;

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
