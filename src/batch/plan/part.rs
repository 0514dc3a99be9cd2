//! Parts of a job, for machines that know only their own number.

use std::{fmt, str::FromStr};

/// A part of the frames of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobPart {
    /// From 0 to `count - 1`.
    index: usize,
    count: usize,
    order: PartOrder,
}

/// The frames that make up a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartOrder {
    /// Consecutive frames.
    Contiguous,
    /// Every Nth frame of N parts.
    Interleaved,
}

/// The number of the first part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PartBase {
    Zero,
    #[default]
    One,
}

/// A part as text: `I/N` or `I/N:interleave`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartSpec {
    number: usize,
    count: usize,
    order: PartOrder,
}

impl FromStr for PartSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("expected I/N or I/N:interleave, such as 3/10, found `{text}`");
        let (numbers, order) = match text.split_once(':') {
            None => (text, PartOrder::Contiguous),
            Some((numbers, "interleave")) => (numbers, PartOrder::Interleaved),
            Some(_) => return Err(expected()),
        };
        let (number, count) = numbers.split_once('/').ok_or_else(expected)?;
        let whole = |text: &str| text.trim().parse::<u32>().map(|n| n as usize).map_err(|_| expected());
        let (number, count) = (whole(number)?, whole(count)?);
        if count == 0 {
            return Err(expected());
        }
        Ok(Self { number, count, order })
    }
}

impl fmt::Display for PartSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)?;
        match self.order {
            PartOrder::Contiguous => Ok(()),
            PartOrder::Interleaved => f.write_str(":interleave"),
        }
    }
}

impl PartSpec {
    /// The part, if the first one has the number `base`.
    ///
    /// # Errors
    /// There is no part of this number.
    pub fn counted_from(self, base: PartBase) -> Result<JobPart, String> {
        let first = usize::from(base == PartBase::One);
        let Self { number, count, order } = self;
        let index = number.checked_sub(first).filter(|index| *index < count);
        index.map(|index| JobPart { index, count, order }).ok_or_else(|| {
            let last = count - 1 + first;
            format!("part {number} of {count} does not exist: parts are numbered from {first} to {last} (--part-base)")
        })
    }
}

impl JobPart {
    /// The frames of this part. Each frame is in exactly one part, and the sizes of parts differ by at most one.
    pub fn choose<T>(self, frames: Vec<T>) -> Vec<T> {
        let Self { index, count, order } = self;
        let len = frames.len();
        let is_chosen = |i: usize| match order {
            PartOrder::Contiguous => (index * len / count..(index + 1) * len / count).contains(&i),
            PartOrder::Interleaved => i % count == index,
        };
        let frames = frames.into_iter().enumerate();
        frames.filter(|(i, _)| is_chosen(*i)).map(|(_, frame)| frame).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_hold_every_frame_once_and_are_even() {
        for len in [0, 1, 7, 100] {
            for count in [1, 3, 8, 150] {
                for order in ["", ":interleave"] {
                    let part = |number: usize| {
                        let spec: PartSpec = format!("{number}/{count}{order}").parse().expect("a part");
                        spec.counted_from(PartBase::One)
                            .expect("exists")
                            .choose((0..len).collect())
                    };
                    let parts: Vec<Vec<usize>> = (1..=count).map(part).collect();
                    let mut all: Vec<usize> = parts.concat();
                    all.sort_unstable();
                    assert!(all.into_iter().eq(0..len), "{len} {count}{order}");
                    let sizes = parts.iter().map(Vec::len);
                    let (least, most) = (sizes.clone().min().expect("parts"), sizes.max().expect("parts"));
                    assert!(most - least <= 1, "{len} {count}{order}");
                }
            }
        }
    }

    #[test]
    fn contiguous_parts_follow_each_other() {
        let part = |text: &str, base| {
            let spec: PartSpec = text.parse().expect("a part");
            spec.counted_from(base)
                .expect("exists")
                .choose((1..=10).collect::<Vec<_>>())
        };
        assert_eq!(part("1/3", PartBase::One), [1, 2, 3]);
        assert_eq!(part("2/3", PartBase::Zero), [7, 8, 9, 10]);
        assert_eq!(part("2/3:interleave", PartBase::One), [2, 5, 8]);
    }

    #[test]
    fn what_is_no_part_is_refused_with_the_numbers_that_are() {
        for text in ["", "3", "a/b", "1/0", "-1/4", "1/4:other"] {
            assert!(text.parse::<PartSpec>().is_err(), "{text}");
        }
        let spec: PartSpec = "4/4".parse().expect("well formed");
        assert!(spec.counted_from(PartBase::One).is_ok());
        let error = spec.counted_from(PartBase::Zero).expect_err("too large");
        assert!(error.contains("from 0 to 3"), "{error}");
    }
}
