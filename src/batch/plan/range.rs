//! Frame ranges: `1-100x2`, `1,3,5-10`, `1-10:3`.
//!
//! A range is a list of parts separated by commas. A part is a frame, or a first and a last frame separated by `-`, optionally
//! with `x` or `:` and a step: `1-10x3` is 1, 4, 7, 10. Frames may be negative: `-5-5`, `-10--5`. Spaces are allowed around
//! numbers. Parts may overlap and come in any order; the range is sorted and has each frame once.

use std::{fmt, str::FromStr};

pub use crate::camera::path::MAX_FRAME;

/// The most frames in one range; more are probably a typing error.
pub const MAX_FRAMES: usize = 1_000_000;

/// At least one frame, in ascending order without duplicates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameRange {
    frames: Vec<i64>,
}

/// Why a text is no frame range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RangeError {
    #[error("a frame range is empty: expected something like 1-100, 1-100x2 or 1,3,5-10")]
    Empty,
    #[error("nothing stands before or after a comma in '{0}'")]
    EmptyPart(String),
    #[error("'{0}' is not a frame or a range of frames: expected something like 12, 1-100 or 1-100x2")]
    Syntax(String),
    #[error("'{part}' has a step but no last frame: expected something like {part_with_last}")]
    StepOfOne { part: String, part_with_last: String },
    #[error("the step of '{0}' is 0: expected a whole number above 0")]
    ZeroStep(String),
    #[error("'{part}' goes backwards: write {last}-{first}, frames are rendered upwards")]
    Backwards { part: String, first: i64, last: i64 },
    #[error("frame {0} is out of range: frames lie between -{MAX_FRAME} and {MAX_FRAME}")]
    FrameNumber(String),
    #[error("'{part}' makes {frames} frames: a range holds at most {MAX_FRAMES}")]
    TooMany { part: String, frames: u64 },
}

impl FrameRange {
    /// All frames from `first` to `last`; `None` for none or more than [`MAX_FRAMES`].
    pub fn all(first: i64, last: i64) -> Option<Self> {
        let frames = usize::try_from(last.checked_sub(first)?).ok()?;
        (frames < MAX_FRAMES).then(|| Self {
            frames: (first..=last).collect(),
        })
    }

    /// The range of these frames.
    pub fn of(frames: impl IntoIterator<Item = i64>) -> Self {
        Self {
            frames: frames.into_iter().collect(),
        }
    }

    /// The number of frames; never 0.
    #[expect(clippy::len_without_is_empty, reason = "a range is never empty")]
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// The frames, in ascending order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = i64> + DoubleEndedIterator + '_ {
        self.frames.iter().copied()
    }

    /// Whether `frame` is one of them.
    pub fn contains(&self, frame: i64) -> bool {
        self.frames.binary_search(&frame).is_ok()
    }

    /// The lowest frame.
    pub fn first(&self) -> i64 {
        self.frames[0]
    }

    /// The highest frame.
    pub fn last(&self) -> i64 {
        self.frames[self.frames.len() - 1]
    }
}

impl FromStr for FrameRange {
    type Err = RangeError;

    fn from_str(text: &str) -> Result<Self, RangeError> {
        if text.trim().is_empty() {
            return Err(RangeError::Empty);
        }
        let mut frames = Vec::new();
        for part in text.split(',').map(str::trim) {
            if part.is_empty() {
                return Err(RangeError::EmptyPart(text.to_owned()));
            }
            let part = Part::read(part)?;
            let total = frames.len() as u64 + part.len();
            if total > MAX_FRAMES as u64 {
                return Err(RangeError::TooMany {
                    part: text.to_owned(),
                    frames: total,
                });
            }
            frames.extend((0..part.len()).map(|i| part.first + (i * part.step) as i64));
        }
        frames.sort_unstable();
        frames.dedup();
        Ok(Self { frames })
    }
}

/// One part of a range: `first`, and every `step`-th frame up to `last`, which is not before `first`.
struct Part {
    first: i64,
    last: i64,
    step: u64,
}

impl Part {
    fn read(text: &str) -> Result<Self, RangeError> {
        let syntax = || RangeError::Syntax(text.to_owned());
        let (first, rest) = signed(text).ok_or_else(syntax)?;
        let (last, rest) = match rest.strip_prefix('-') {
            Some(rest) => {
                let (last, rest) = signed(rest.trim_start()).ok_or_else(syntax)?;
                (Some(last), rest)
            }
            None => (None, rest),
        };
        let step = match rest.strip_prefix(['x', 'X', ':']) {
            Some(step) => Some(step.trim_start()),
            None if rest.is_empty() => None,
            None => return Err(syntax()),
        };
        if step.is_some_and(|s| s.is_empty() || !s.bytes().all(|b| b.is_ascii_digit())) {
            return Err(syntax());
        }
        let first = frame(first)?;
        let Some(last) = last else {
            return match step {
                None => Ok(Self {
                    first,
                    last: first,
                    step: 1,
                }),
                Some(step) => Err(RangeError::StepOfOne {
                    part: text.to_owned(),
                    part_with_last: format!("{first}-{}x{step}", first + 99),
                }),
            };
        };
        let last = frame(last)?;
        // A step that overflows exceeds every last frame.
        let step = step.map_or(1, |s| s.parse().unwrap_or(u64::MAX));
        if step == 0 {
            return Err(RangeError::ZeroStep(text.to_owned()));
        }
        if last < first {
            return Err(RangeError::Backwards {
                part: text.to_owned(),
                first,
                last,
            });
        }
        Ok(Self { first, last, step })
    }

    fn len(&self) -> u64 {
        self.last.abs_diff(self.first) / self.step + 1
    }
}

/// Splits off the integer at the start of `text` and the spaces after it.
fn signed(text: &str) -> Option<(&str, &str)> {
    let sign = usize::from(text.starts_with('-'));
    let digits = text[sign..].bytes().take_while(u8::is_ascii_digit).count();
    (digits > 0).then(|| {
        let (number, rest) = text.split_at(sign + digits);
        (number, rest.trim_start())
    })
}

fn frame(number: &str) -> Result<i64, RangeError> {
    number
        .parse()
        .ok()
        .filter(|n| (-MAX_FRAME..=MAX_FRAME).contains(n))
        .ok_or_else(|| RangeError::FrameNumber(number.to_owned()))
}

impl fmt::Display for FrameRange {
    /// Writes it compactly: three or more frames with a constant step become one part.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut rest = &self.frames[..];
        let mut comma = "";
        while let [first, more @ ..] = rest {
            f.write_str(comma)?;
            comma = ",";
            let step = more.first().map_or(0, |next| next - first);
            let run = 1 + rest.windows(2).take_while(|pair| pair[1] - pair[0] == step).count();
            let last = rest[run - 1];
            match (run, step) {
                (3.., 1) => write!(f, "{first}-{last}")?,
                (3.., _) => write!(f, "{first}-{last}x{step}")?,
                _ => write!(f, "{first}")?,
            }
            rest = if run >= 3 { &rest[run..] } else { more };
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> Result<Vec<i64>, String> {
        text.parse::<FrameRange>()
            .map(|range| range.iter().collect())
            .map_err(|e| e.to_string())
    }

    #[test]
    fn x_and_colon_both_mean_step() {
        assert_eq!(read("1-10x3"), Ok(vec![1, 4, 7, 10]));
        assert_eq!(read("1-9:3"), Ok(vec![1, 4, 7]));
        assert_eq!(read("1-5:2,6"), Ok(vec![1, 3, 5, 6]));
        assert_eq!(read("7"), Ok(vec![7]));
        assert_eq!(read("1-2x99999999999999999999999"), Ok(vec![1]));
    }

    #[test]
    fn frames_may_be_negative() {
        assert_eq!(read("-2-2"), Ok(vec![-2, -1, 0, 1, 2]));
        assert_eq!(read("-10--8"), Ok(vec![-10, -9, -8]));
        assert_eq!(read("-5"), Ok(vec![-5]));
        assert_eq!(read(" -5 - -4 , 3 "), Ok(vec![-5, -4, 3]));
    }

    #[test]
    fn each_frame_is_there_once_and_they_rise() {
        assert_eq!(read("5-7,1,6,1-2"), Ok(vec![1, 2, 5, 6, 7]));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let cases = [
            (
                "",
                "a frame range is empty: expected something like 1-100, 1-100x2 or 1,3,5-10",
            ),
            ("1,,2", "nothing stands before or after a comma in '1,,2'"),
            ("1-5,", "nothing stands before or after a comma in '1-5,'"),
            (
                "a-b",
                "'a-b' is not a frame or a range of frames: expected something like 12, 1-100 or 1-100x2",
            ),
            (
                "1..5",
                "'1..5' is not a frame or a range of frames: expected something like 12, 1-100 or 1-100x2",
            ),
            (
                "1-5x",
                "'1-5x' is not a frame or a range of frames: expected something like 12, 1-100 or 1-100x2",
            ),
            (
                "1-5x-2",
                "'1-5x-2' is not a frame or a range of frames: expected something like 12, 1-100 or 1-100x2",
            ),
            (
                "5x2",
                "'5x2' has a step but no last frame: expected something like 5-104x2",
            ),
            ("1-5x0", "the step of '1-5x0' is 0: expected a whole number above 0"),
            ("10-1", "'10-1' goes backwards: write 1-10, frames are rendered upwards"),
            ("3--3", "'3--3' goes backwards: write -3-3, frames are rendered upwards"),
            (
                "1-4000000000",
                "frame 4000000000 is out of range: frames lie between -1000000000 and 1000000000",
            ),
            (
                "1-99999999999999999999",
                "frame 99999999999999999999 is out of range: frames lie between -1000000000 and 1000000000",
            ),
            (
                "1-1000000000",
                "'1-1000000000' makes 1000000000 frames: a range holds at most 1000000",
            ),
            (
                "1-600000,1-600000",
                "'1-600000,1-600000' makes 1200000 frames: a range holds at most 1000000",
            ),
        ];
        for (text, message) in cases {
            assert_eq!(read(text), Err(message.to_owned()));
        }
    }

    #[test]
    fn a_range_is_written_in_a_short_way() {
        let short = |text: &str| text.parse::<FrameRange>().map(|r| r.to_string());
        assert_eq!(short("1,2,3,4,5"), Ok("1-5".into()));
        assert_eq!(short("1-10x3"), Ok("1-10x3".into()));
        assert_eq!(short("3,1,10,-5,-4,-3"), Ok("-5--3,1,3,10".into()));
    }

    #[test]
    fn all_frames_of_a_path_make_a_range_unless_there_are_too_many() {
        let range = FrameRange::all(-1, 3).expect("five frames");
        assert_eq!((range.first(), range.last(), range.len()), (-1, 3, 5));
        assert!(range.contains(3) && !range.contains(4));
        assert_eq!(FrameRange::all(1, 0), None);
        assert_eq!(FrameRange::all(1, 1_000_001), None);
        assert_eq!(FrameRange::all(i64::MIN, i64::MAX), None);
    }

    proptest! {
        #[test]
        fn writing_and_reading_a_range_gives_the_same(frames in prop::collection::btree_set(-60_i64..60, 1..40)) {
            let range = FrameRange { frames: frames.into_iter().collect() };
            prop_assert_eq!(range.to_string().parse::<FrameRange>(), Ok(range));
        }

        #[test]
        fn no_text_makes_it_panic(text in "[-0-9x:, ]{0,24}|.{0,12}") {
            if let Ok(range) = text.parse::<FrameRange>() {
                prop_assert!(range.iter().zip(range.iter().skip(1)).all(|(a, b)| a < b));
                prop_assert!(range.contains(range.first()) && range.contains(range.last()));
            }
        }
    }
}
