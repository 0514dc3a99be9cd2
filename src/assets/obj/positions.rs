//! Positions of vertices far from the origin of their file, in double precision.

use std::io::Write;

use super::lines::{Lines, words};
use crate::math::{DAabb, DVec3, origin};

/// The least number of digits before the point of numbers that are far from 0.
const FAR_DIGITS: usize = 4;

/// Whether a number may be far from 0, by its length.
pub(super) fn may_be_far(number: &[u8]) -> bool {
    let whole = number.iter().position(|b| *b == b'.').unwrap_or(number.len());
    whole >= FAR_DIGITS || number.iter().any(|b| b.eq_ignore_ascii_case(&b'e'))
}

fn parse(number: &[u8]) -> Option<f64> {
    let v: f64 = std::str::from_utf8(number).ok()?.parse().ok()?;
    v.is_finite().then_some(v)
}

/// The position of a `v` statement; `None` if it is invalid.
fn position(statement: &[u8]) -> Option<DVec3> {
    let mut numbers = words(statement).skip(1).map(parse);
    let mut next = || numbers.next().flatten();
    Some(DVec3::new(next()?, next()?, next()?))
}

/// The origin for the vertices of a decoded file; `None` for the file's own.
pub(super) fn origin(text: &[u8]) -> Option<DVec3> {
    let vertices = Lines::new(text).filter(|line| matches!(words(&line.text).next(), Some(b"v" | b"V")));
    let bounds = DAabb::from_points(vertices.filter_map(|line| position(&line.text)));
    origin::of_box(&bounds)
}

/// Appends a `v` statement to `out`, its position relative to `origin`; `false` where it has no position.
pub(super) fn append_relative(statement: &[u8], origin: DVec3, out: &mut Vec<u8>) -> bool {
    let relative = position(statement).map(|p| p - origin);
    if let Some(p) = relative {
        writeln!(out, "v {} {} {}", p.x, p.y, p.z).expect("memory takes all bytes");
    }
    relative.is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_far_by_their_length() {
        for far in ["1000", "-1000.0", "1e3", "1E+3", "431250.20"] {
            assert!(may_be_far(far.as_bytes()), "{far}");
        }
        for near in ["0", "999", "-99.5", "0.123456789"] {
            assert!(!may_be_far(near.as_bytes()), "{near}");
        }
    }

    #[test]
    fn statements_become_relative_and_broken_ones_are_told() {
        let relative = |text: &str| {
            let mut out = Vec::new();
            let done = append_relative(text.as_bytes(), DVec3::new(431_250.0, 0.0, 5_649_830.0), &mut out);
            (done, String::from_utf8(out).expect("text"))
        };
        assert_eq!(
            relative("v 431250.25 7 5649829.5 1 0 0"),
            (true, "v 0.25 7 -0.5\n".to_owned())
        );
        assert_eq!(relative("v 431250.25 seven 5649829.5"), (false, String::new()));
    }
}
