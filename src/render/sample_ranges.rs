//! Ranges of the samples of a frame, which several machines render.
//!
//! The samples `0..n` are divided into ranges of nearly the same length. The sums of each are added for themselves,
//! and then the sums of the ranges in their order, wherever they were rendered: so all machines together make the
//! bits of one that renders all ranges.

use std::{fmt, ops::Range, str::FromStr};

use serde::Serialize;

/// The ranges of a frame's samples, and the one that is rendered, if it is not all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct SampleRanges {
    pub count: u32,
    /// From 0 to `count - 1`.
    pub only: Option<u32>,
}

impl SampleRanges {
    /// One range of this number from 0.
    pub fn only(self, index: u32) -> Self {
        Self {
            only: Some(index),
            ..self
        }
    }

    /// The samples of a range, of `samples`.
    pub fn range(&self, index: u32, samples: u32) -> Range<u32> {
        let start = |index: u32| (u64::from(samples) * u64::from(index) / u64::from(self.count)) as u32;
        start(index)..start(index + 1)
    }

    /// The folder of the files of a range, inside that of the whole frames; `None` for all ranges.
    pub fn folder(&self) -> Option<String> {
        Some(format!("samples-{}-of-{}", self.only? + 1, self.count))
    }

    /// Whether a folder has the name of that of a range.
    pub fn is_folder(name: &str) -> bool {
        let numbers = name.strip_prefix("samples-").and_then(|rest| rest.split_once("-of-"));
        let ranges = numbers.and_then(|(only, count)| format!("{only}/{count}").parse::<Self>().ok());
        ranges.and_then(|ranges| ranges.folder()).as_deref() == Some(name)
    }

    /// The numbers of the ranges that are rendered.
    pub fn indices(&self) -> Range<u32> {
        self.only.map_or(0..self.count, |index| index..index + 1)
    }
}

impl fmt::Display for SampleRanges {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.only {
            Some(index) => write!(f, "{}/{}", index + 1, self.count),
            None => write!(f, "all/{}", self.count),
        }
    }
}

impl FromStr for SampleRanges {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("expected I/N or all/N with I from 1 to N, such as 2/4, found `{text}`");
        let (only, count) = text.split_once('/').ok_or_else(expected)?;
        let whole = |text: &str| text.trim().parse::<u32>().map_err(|_| expected());
        let count = whole(count)?;
        let only = match only.trim() {
            "all" => None,
            number => Some(whole(number)?.checked_sub(1).ok_or_else(expected)?),
        };
        if count == 0 || only.is_some_and(|only| only >= count) {
            return Err(expected());
        }
        Ok(Self { count, only })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_cover_all_samples_once_and_are_named_from_1() {
        for (samples, count) in [(64, 4), (7, 3), (5, 5), (u32::MAX, 7)] {
            let ranges = SampleRanges { count, only: None };
            let mut end = 0;
            for index in ranges.indices() {
                let range = ranges.range(index, samples);
                assert!(range.start == end && !range.is_empty());
                end = range.end;
            }
            assert_eq!(end, samples);
        }
        let second: SampleRanges = "2/4".parse().expect("a range");
        assert_eq!((second.indices(), second.range(1, 64)), (1..2, 16..32));
        assert_eq!(
            ["2/4", "all/4"].map(|text| text.parse::<SampleRanges>().unwrap().to_string()),
            ["2/4", "all/4"]
        );
        assert_eq!(second.folder().as_deref(), Some("samples-2-of-4"));
        assert!(SampleRanges::is_folder("samples-2-of-4"));
        for wrong in [
            "samples-all-of-4",
            "samples-5-of-4",
            "samples-02-of-4",
            "samples-2-of-4.exr",
            "samples",
        ] {
            assert!(!SampleRanges::is_folder(wrong), "{wrong}");
        }
        for wrong in ["", "0/4", "5/4", "1/0", "all", "a/b", "-1/4"] {
            assert!(wrong.parse::<SampleRanges>().is_err(), "{wrong}");
        }
    }
}
