//! Texture coordinates far from 0, in double precision.
//!
//! The parser reads single precision. So it gets the number of each statement in place of its coordinates, as two numbers that
//! single precision holds exactly, and the coordinates stay in a table.

use std::io::Write;

use super::lines::{Lines, words};
use crate::{
    assets::repair::is_not_finite,
    math::{DVec2, origin},
};

/// The bits of the first of the two numbers.
const LOW_BITS: usize = 20;

fn parse(number: &[u8]) -> Option<f64> {
    if is_not_finite(number) {
        return Some(f64::NAN);
    }
    std::str::from_utf8(number).ok()?.parse().ok()
}

/// The coordinates of a `vt` statement; `None` if it is broken.
fn coordinates(statement: &[u8]) -> Option<DVec2> {
    let mut numbers = words(statement).skip(1).map(parse);
    let u = numbers.next()??;
    let v = numbers.next().unwrap_or(Some(0.0))?;
    Some(DVec2::new(u, v))
}

/// The coordinates of all `vt` statements of a decoded file, in order; `None` unless some are far from 0.
pub(super) fn far(text: &[u8]) -> Option<Vec<DVec2>> {
    let statements = Lines::new(text).filter(|line| matches!(words(&line.text).next(), Some(b"vt" | b"VT")));
    let all: Vec<DVec2> = statements
        .map(|line| coordinates(&line.text).unwrap_or_default())
        .collect();
    (all.iter().any(|uv| uv.abs().max_element() >= origin::FAR)).then_some(all)
}

/// Appends a `vt` statement that holds its own number, counted from 0, to `out`; `false` if it is broken.
pub(super) fn append_number(statement: &[u8], number: usize, out: &mut Vec<u8>) -> bool {
    let is_sound = coordinates(statement).is_some();
    if is_sound {
        let (low, high) = (number % (1 << LOW_BITS), number >> LOW_BITS);
        writeln!(out, "vt {low} {high}").expect("memory takes all bytes");
    }
    is_sound
}

/// The number of a statement that [`append_number`] wrote.
pub(super) fn number([low, high]: [f32; 2]) -> usize {
    low as usize + ((high as usize) << LOW_BITS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_kept_in_double_precision_where_some_are_far() {
        let text = b"vt 1000000.001\nvt 0.5 nan\nv 0 0 0\nVT x 1\n";
        let all = far(text).expect("far");
        assert_eq!((all.len(), all[0], all[1].x), (3, DVec2::new(1_000_000.001, 0.0), 0.5));
        assert!(all[1].y.is_nan());
        assert_eq!(far(b"vt 999 -999.5\n"), None);
    }

    #[test]
    fn numbers_of_statements_survive_single_precision() {
        for n in [0, 1, (1 << LOW_BITS) - 1, 1 << LOW_BITS, 123_456_789] {
            let mut out = Vec::new();
            assert!(append_number(b"vt 5 5", n, &mut out));
            let text = String::from_utf8(out).expect("text");
            let read: Vec<f32> = text
                .split(' ')
                .skip(1)
                .map(|w| w.trim().parse().expect("a number"))
                .collect();
            assert_eq!(number([read[0], read[1]]), n);
        }
        assert!(!append_number(b"vt 5 five", 0, &mut Vec::new()));
    }
}
