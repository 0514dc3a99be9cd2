//! Bounds on what rounding can do, and rays that leave surfaces without an epsilon.
//!
//! Source: Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th ed., section 6.8 "Managing
//! rounding error".

use glam::Vec3;

/// Bound on the relative error of `n` rounded operations in a row: `n u / (1 - n u)`, u = 2^-24.
#[inline]
pub const fn gamma(n: u32) -> f32 {
    let nu = n as f32 * (f32::EPSILON * 0.5);
    nu / (1.0 - nu)
}

/// The decimal fraction that `x` is rounded from, if it has up to nine digits after the point; else `x`.
pub fn decimal(x: f32) -> f64 {
    let exact = f64::from(x);
    let powers = std::iter::successors(Some(1.0), |power| Some(power * 10.0)).take(10);
    let mut rounded = powers.map(|power: f64| (exact * power).round() / power);
    rounded.find(|r| *r as f32 == x).unwrap_or(exact)
}

/// `a` where `condition` holds, else `b`; number by number, for the compiler to see that there is no branch.
#[inline(always)]
pub fn select(condition: bool, a: Vec3, b: Vec3) -> Vec3 {
    let either = |a: f32, b: f32| if condition { a } else { b };
    Vec3::new(either(a.x, b.x), either(a.y, b.y), either(a.z, b.z))
}

/// The origins of rays that leave the surface point `p`: `p` moved just past the box of its own
/// rounding error, along `ng` and against it.
///
/// `p_error` bounds the absolute error of each coordinate of `p`, `ng` is the unit geometric
/// normal.
#[inline(always)]
pub fn offset_origins(p: Vec3, p_error: Vec3, ng: Vec3) -> [Vec3; 2] {
    let offset = ng * ng.abs().dot(p_error);
    let moved = |d: Vec3| Vec3::new(next_after(p.x, d.x), next_after(p.y, d.y), next_after(p.z, d.z));
    [moved(offset), moved(-offset)]
}

/// `p + d`, and from there the next number in the direction of `d`; `p` itself where `d` is 0.
/// Finite numbers only.
///
/// The signs of directions are unpredictable, so there is no branch.
#[inline(always)]
fn next_after(p: f32, d: f32) -> f32 {
    let moved = p + d;
    // In the order of their bits numbers of one sign grow away from zero; from zero itself they
    // grow either way.
    let inwards = ((moved.to_bits() ^ d.to_bits()) >> 31) as i32;
    let next = moved.to_bits().wrapping_add_signed(1 - 2 * inwards);
    let from_zero = 1 | d.to_bits() & (1 << 31);
    let next = if moved == 0.0 { from_zero } else { next };
    if d == 0.0 { moved } else { f32::from_bits(next) }
}

/// The largest whole number that is at most `x`, like [`f32::floor`], which is a call on processors that lack an instruction
/// for it.
#[inline(always)]
pub fn floor(x: f32) -> f32 {
    /// Larger numbers have no fraction.
    const LARGE: f32 = 8_388_608.0;
    let whole = x as i32 as f32;
    let floor = if whole > x { whole - 1.0 } else { whole };
    if x.abs() < LARGE { floor } else { x }
}

/// Whether a whole number is odd; false for others that `floor` may return. In place of a remainder, which takes ten times as long.
#[inline]
pub fn is_odd(whole: f32) -> bool {
    let half = whole * 0.5;
    floor(half) < half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_numbers_are_those_that_a_file_has() {
        for (x, decimal) in [
            (0.1, 0.1),
            (-0.3, -0.3),
            (1_000_000.3, 1_000_000.3),
            (7.0, 7.0),
            (1e-7, 1e-7),
        ] {
            assert_eq!(super::decimal(x), decimal);
        }
        assert_eq!(super::decimal(f32::MIN_POSITIVE), f64::from(f32::MIN_POSITIVE));
    }

    #[test]
    fn floors_are_those_of_the_library() {
        let large = [8_388_607.5, 8_388_608.0, 2e9, 3e9, 1e30, f32::INFINITY];
        let small = (0..=4000_i16).map(|i| f32::from(i) / 1000.0);
        for x in small.chain(large).flat_map(|x| [x, -x, x.next_up(), x.next_down()]) {
            assert_eq!(floor(x), x.floor(), "{x}");
        }
        assert!(floor(f32::NAN).is_nan());
    }

    #[test]
    fn odd_numbers_are_those_with_a_remainder() {
        for x in (-2000..2000).map(|i| i as f32).chain([
            8_388_609.0,
            16_777_215.0,
            16_777_216.0,
            1e30,
            f32::INFINITY,
            f32::NAN,
        ]) {
            assert_eq!(is_odd(x), x.rem_euclid(2.0) == 1.0, "{x}");
        }
    }

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
    fn offset_origins_leave_the_error_box_on_their_sides() {
        let (p, e) = (Vec3::new(100.0, -3.0, 0.5), Vec3::splat(1e-5));
        for ng in [Vec3::X, Vec3::new(0.6, 0.0, -0.8)] {
            for (o, w) in offset_origins(p, e, ng).into_iter().zip([ng, -ng]) {
                assert!((o - p).dot(w) >= e.dot(ng.abs()));
                assert!((o - p).length() < 1e-4);
            }
        }
    }
}
