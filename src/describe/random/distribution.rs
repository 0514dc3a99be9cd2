//! Distributions that values are drawn from.

use std::f64::consts::SQRT_2;

use super::draw::{DrawKey, Numbers};
use crate::math::trig;

/// The most attempts to draw a number of a normal distribution that lies in its range. Each one has a
/// chance of [`LEAST_SHARE`] or more.
const MOST_ATTEMPTS: u32 = 4096;

/// The deviations from its mean beyond which no number of a normal distribution is drawn, by the 53 bits of those it is made from:
/// `sqrt(106 ln 2)`, rounded up.
const FARTHEST: f64 = 8.6;

/// The least part of a normal distribution that may lie in its range.
pub(super) const LEAST_SHARE: f64 = 0.01;

/// A distribution of a value.
#[derive(Clone, Debug, PartialEq)]
pub enum Distribution {
    /// A number.
    Number(Law),
    /// A list of numbers, each drawn by itself.
    List(Vec<Law>),
    /// A whole number, from the first to the second.
    Integer([i64; 2]),
    Choice(Choice),
    Sphere(Sphere),
}

/// A distribution of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    Uniform([f64; 2]),
    /// Its logarithm is uniform. Both ends are above 0.
    Log([f64; 2]),
    /// Normal, and within these ends.
    Normal {
        mean: f64,
        deviation: f64,
        within: [f64; 2],
    },
}

/// One of several values.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// In TOML.
    pub options: Vec<String>,
    /// The sums of the weights up to and with each option.
    pub sums: Vec<f64>,
}

/// A point in the direction of a uniform point of the unit sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    pub center: [f64; 3],
    /// The distance from the centre is uniform between these.
    pub radii: [f64; 2],
    /// Whether it lies above the centre.
    pub is_upper: bool,
}

impl Law {
    fn draw(self, numbers: &mut Numbers) -> f64 {
        match self {
            Self::Uniform([least, most]) => (least + numbers.unit() * (most - least)).clamp(least, most),
            Self::Log([least, most]) => {
                let (from, to) = (libm::log(least), libm::log(most));
                libm::exp(from + numbers.unit() * (to - from)).clamp(least, most)
            }
            Self::Normal {
                mean,
                deviation,
                within: [least, most],
            } => {
                let mut drawn = mean;
                for _ in 0..MOST_ATTEMPTS {
                    drawn = mean + deviation * normal(numbers);
                    if (least..=most).contains(&drawn) {
                        break;
                    }
                }
                drawn.clamp(least, most)
            }
        }
    }

    /// The ends of its range.
    fn ends(self) -> [f64; 2] {
        match self {
            Self::Uniform(ends) | Self::Log(ends) => ends,
            Self::Normal {
                mean,
                deviation,
                within: [least, most],
            } => {
                let reach = FARTHEST * deviation;
                let or = |end: f64, other: f64| if end.is_finite() { end } else { other };
                [or(least, mean - reach), or(most, mean + reach)]
            }
        }
    }

    /// The part of a normal distribution that lies between two numbers.
    pub(super) fn normal_share(mean: f64, deviation: f64, [least, most]: [f64; 2]) -> f64 {
        let below = |x: f64| 0.5 * libm::erfc((mean - x) / (deviation * SQRT_2));
        below(most) - below(least)
    }
}

/// A number of the standard normal distribution.
///
/// Source: Box and Muller, "A Note on the Generation of Random Normal Deviates", Annals of Mathematical Statistics 29(2), 1958,
/// doi:10.1214/aoms/1177706645.
fn normal(numbers: &mut Numbers) -> f64 {
    let (u, v) = (numbers.unit(), numbers.unit());
    let (_, cos) = trig::sin_cos_turn(v);
    (-2.0 * libm::log(1.0 - u)).sqrt() * cos
}

impl Choice {
    fn draw(&self, numbers: &mut Numbers) -> &str {
        let total = self.sums.last().copied().unwrap_or_default();
        let at = numbers.unit() * total;
        let found = self.sums.partition_point(|sum| *sum <= at);
        // Rounding may have reached the total, which is that of the last option with a weight.
        let last = self.sums.partition_point(|sum| *sum < total);
        &self.options[found.min(last)]
    }

    /// The options that have a weight.
    pub fn possible(&self) -> impl Iterator<Item = &str> {
        let before = [0.0].into_iter().chain(self.sums.iter().copied());
        let weights = self.sums.iter().zip(before);
        let options = self.options.iter().zip(weights);
        options.filter_map(|(option, (sum, before))| (*sum > before).then_some(option.as_str()))
    }
}

impl Sphere {
    fn draw(&self, numbers: &mut Numbers) -> [f64; 3] {
        let (u, v) = (numbers.unit(), numbers.unit());
        let y = if self.is_upper { u } else { 2.0 * u - 1.0 };
        let (sin, cos) = trig::sin_cos_turn(v);
        let across = (1.0 - y * y).max(0.0).sqrt();
        let distance = Law::Uniform(self.radii).draw(numbers);
        let direction = [across * sin, y, across * cos];
        [0, 1, 2].map(|axis| self.center[axis] + distance * direction[axis])
    }
}

impl Distribution {
    /// The value of a frame, in TOML.
    pub fn draw(&self, key: DrawKey, frame: i64) -> String {
        let mut numbers = key.numbers(frame);
        match self {
            Self::Number(law) => number(law.draw(&mut numbers)),
            Self::List(laws) => list(laws.iter().map(|law| law.draw(&mut numbers))),
            Self::Integer(ends) => numbers.whole(*ends).to_string(),
            Self::Choice(choice) => choice.draw(&mut numbers).to_owned(),
            Self::Sphere(sphere) => list(sphere.draw(&mut numbers)),
        }
    }

    /// The outermost values, in TOML: all others lie between these.
    pub fn outermost(&self) -> Vec<String> {
        match self {
            Self::Number(law) => law.ends().map(number).to_vec(),
            Self::List(laws) => [0, 1].map(|end| list(laws.iter().map(|law| law.ends()[end]))).to_vec(),
            Self::Integer(ends) => ends.map(|end| end.to_string()).to_vec(),
            Self::Choice(choice) => choice.possible().map(str::to_owned).collect(),
            Self::Sphere(Sphere { center, radii, .. }) => [-radii[1], radii[1]]
                .map(|by| list(center.map(|own| own + by)))
                .to_vec(),
        }
    }

    /// Whether it is normal and lacks an end.
    pub fn is_unbounded(&self) -> bool {
        let is_unbounded = |law: &Law| match law {
            Law::Normal { within, .. } => within.iter().any(|end| !end.is_finite()),
            Law::Uniform(_) | Law::Log(_) => false,
        };
        match self {
            Self::Number(law) => is_unbounded(law),
            Self::List(laws) => laws.iter().any(is_unbounded),
            Self::Integer(_) | Self::Choice(_) | Self::Sphere(_) => false,
        }
    }

    /// The texts that it chooses from.
    pub fn words(&self) -> impl Iterator<Item = &str> {
        let choice = match self {
            Self::Choice(choice) => Some(choice),
            _ => None,
        };
        let options = choice.into_iter().flat_map(Choice::possible);
        options.filter(|option| option.starts_with(['"', '\'']))
    }
}

/// A number in TOML.
fn number(v: f64) -> String {
    toml::Value::from(v).to_string()
}

/// A list of numbers in TOML.
fn list(numbers: impl IntoIterator<Item = f64>) -> String {
    let numbers: Vec<String> = numbers.into_iter().map(number).collect();
    format!("[{}]", numbers.join(", "))
}

#[cfg(test)]
mod tests;
