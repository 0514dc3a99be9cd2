//! The animations of a model that are played, and when.

use serde::{Deserialize, Deserializer, Serialize, de};

use crate::value::number;

/// The animations of a file that are played.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
pub enum AnimationChoice {
    All,
    /// By their names.
    Named(Vec<String>),
}

impl AnimationChoice {
    /// The choice that a word means: `all`, or the name of an animation.
    pub fn of_name(name: &str) -> Self {
        match name {
            "all" => Self::All,
            name => Self::Named(vec![name.to_owned()]),
        }
    }
}

impl AnimationChoice {
    /// Whether none is played.
    pub fn is_empty(&self) -> bool {
        matches!(self, Self::Named(names) if names.is_empty())
    }
}

impl<'de> Deserialize<'de> for AnimationChoice {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = AnimationChoice;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("the name of an animation, a list of names, or \"all\"")
            }
            fn visit_str<E: de::Error>(self, name: &str) -> Result<Self::Value, E> {
                Ok(AnimationChoice::of_name(name))
            }
            fn visit_seq<A: de::SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut names = Vec::new();
                while let Some(name) = seq.next_element()? {
                    names.push(name);
                }
                Ok(AnimationChoice::Named(names))
            }
        }
        d.deserialize_any(Visitor)
    }
}

/// The number of times that an animation is played.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Repeat {
    #[default]
    Once,
    Times(u32),
    Forever,
}

impl<'de> Deserialize<'de> for Repeat {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = Repeat;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("true, false, or how often: a whole number above 0")
            }
            fn visit_bool<E: de::Error>(self, is_repeated: bool) -> Result<Repeat, E> {
                Ok(if is_repeated { Repeat::Forever } else { Repeat::Once })
            }
            fn visit_i64<E: de::Error>(self, times: i64) -> Result<Repeat, E> {
                let count = u32::try_from(times).ok().filter(|count| *count > 0);
                let count = count.ok_or_else(|| E::invalid_value(de::Unexpected::Signed(times), &self))?;
                Ok(Repeat::Times(count))
            }
        }
        d.deserialize_any(Visitor)
    }
}

/// When animations are played, and how fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// The time at which they begin, in s.
    pub start: f64,
    /// Seconds of the animation in a second; backwards below 0.
    pub speed: f64,
    pub repeat: Repeat,
}

impl Default for Playback {
    fn default() -> Self {
        Self {
            start: 0.0,
            speed: 1.0,
            repeat: Repeat::Once,
        }
    }
}

impl Playback {
    /// The time within an animation that ends at `end` at the time `time`, in s.
    pub fn local_time(&self, end: f64, time: f64) -> f64 {
        let run = (time - self.start) * self.speed.abs();
        let times = match self.repeat {
            Repeat::Once => 1.0,
            Repeat::Times(times) => f64::from(times),
            Repeat::Forever => f64::INFINITY,
        };
        let gone = if run.is_nan() || run <= 0.0 || end <= 0.0 {
            0.0
        } else if run >= end * times {
            end
        } else {
            run % end
        };
        if self.speed < 0.0 { end - gone } else { gone }
    }
}

/// A finite number in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precise(pub f64);

impl<'de> Deserialize<'de> for Precise {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let v = number(d)?;
        if v.is_finite() {
            Ok(Self(v))
        } else {
            Err(de::Error::custom(format_args!("expected a finite number, found {v}")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(playback: Playback, time: f64) -> f64 {
        playback.local_time(2.0, time)
    }

    #[test]
    fn local_time_is_held_outside_and_runs_from_the_start_at_its_speed() {
        let late = Playback {
            start: 1.0,
            speed: 0.5,
            ..Playback::default()
        };
        assert_eq!(
            [0.0, 1.0, 2.0, 5.0, 9.0].map(|t| at(late, t)),
            [0.0, 0.0, 0.5, 2.0, 2.0]
        );
        let back = Playback { speed: -2.0, ..late };
        assert_eq!([0.0, 1.0, 1.5, 9.0].map(|t| at(back, t)), [2.0, 2.0, 1.0, 0.0]);
    }

    #[test]
    fn a_count_of_repetitions_ends_at_the_last_key_and_forever_does_not_end() {
        let of = |repeat| Playback {
            repeat,
            ..Playback::default()
        };
        let times = [0.0, 1.5, 2.0, 3.5, 6.0, 7.0];
        assert_eq!(
            times.map(|t| at(of(Repeat::Times(3)), t)),
            [0.0, 1.5, 0.0, 1.5, 2.0, 2.0]
        );
        assert_eq!(
            times.map(|t| at(of(Repeat::Forever), t)),
            [0.0, 1.5, 0.0, 1.5, 0.0, 1.0]
        );
        assert_eq!(at(of(Repeat::Forever), 1e12 + 1.0), 1.0);
        assert_eq!(of(Repeat::Forever).local_time(0.0, 5.0), 0.0);
    }
}
