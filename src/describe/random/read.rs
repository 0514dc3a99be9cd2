//! Reading distributions from TOML.

use std::cmp::Ordering;

use serde::Deserialize;
use toml::de::{DeArray, DeTable, DeValue};

use super::distribution::{Choice, Distribution, LEAST_SHARE, Law, Sphere};
use crate::{
    describe::{Overrides, deserialize::FileValue},
    value::{List, Point, Precise, Problem, Span, Spanned, UnknownName, one_of},
};

type Value<'i> = Spanned<DeValue<'i>>;

/// The names of distributions, each with the keys that may stand beside it.
const LAWS: [(&str, &[&str]); 6] = [
    ("uniform", &[]),
    ("log", &[]),
    ("normal", &["min", "max"]),
    ("integer", &[]),
    ("choice", &["weights"]),
    ("sphere", &["center", "upper"]),
];

/// The longest list of numbers that is drawn.
const LONGEST: usize = 16;

/// The whole numbers that are drawn at most, either way: those of double precision.
const LARGEST: i64 = 1 << 53;

const HELP: &str = "a range [least, most], a list of names, or a table such as { log = [1, 100] }";

/// Whether a table is a distribution: it has the key of one, which is no table by itself.
pub(super) fn is_distribution(table: &DeTable<'_>) -> bool {
    let is_law = |(name, _): &(&str, _)| table.get(*name).is_some_and(|value| !value.get_ref().is_table());
    LAWS.iter().any(is_law)
}

/// Whether a value says that nothing is drawn.
pub(super) fn is_none(value: &Value<'_>) -> bool {
    value.get_ref().as_str() == Some("none")
}

/// Reads a distribution.
///
/// # Errors
/// It is none, or its numbers are wrong.
pub(super) fn distribution(value: Value<'_>, overrides: &Overrides) -> Result<Distribution, Problem> {
    let span = value.span();
    match value.into_inner() {
        DeValue::Array(list) => of_list(list, span, overrides),
        DeValue::Table(table) => of_table(table, span, overrides),
        other => {
            let message = format!("expected a distribution, found {}", found(&other));
            Err(Problem::at(span, message).with_help(HELP))
        }
    }
}

/// Reads a seed.
pub(super) fn seed(value: Value<'_>, overrides: &Overrides) -> Result<u64, Problem> {
    let span = value.span();
    let seed: i64 = read(value, overrides)?;
    u64::try_from(seed).map_err(|_| Problem::at(span, format!("a seed is a whole number from 0, not {seed}")))
}

/// Reads a text.
pub(super) fn text(value: Value<'_>, overrides: &Overrides) -> Result<String, Problem> {
    read(value, overrides)
}

/// Reads a value of a type that checks itself.
fn read<'i, T: Deserialize<'i>>(value: Value<'i>, overrides: &Overrides) -> Result<T, Problem> {
    let span = value.span();
    T::deserialize(FileValue(value)).map_err(|error| {
        let problem = error.problem(overrides);
        Problem {
            span: problem.span.or(Some(span)),
            ..problem
        }
    })
}

/// The words for a value of a wrong type.
fn found(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("the text \"{text}\""),
        DeValue::Integer(_) | DeValue::Float(_) => "one number".to_owned(),
        DeValue::Boolean(truth) => format!("`{truth}`"),
        DeValue::Datetime(_) => "a date".to_owned(),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}

fn is_number(value: &Value<'_>) -> bool {
    matches!(value.get_ref(), DeValue::Integer(_) | DeValue::Float(_))
}

/// A range, or values to choose from.
fn of_list(list: DeArray<'_>, span: Span, overrides: &Overrides) -> Result<Distribution, Problem> {
    let is_word = |value: &Value<'_>| matches!(value.get_ref(), DeValue::String(_) | DeValue::Boolean(_));
    let is_end = |value: &Value<'_>| is_number(value) || value.get_ref().is_array();
    if !list.is_empty() && list.iter().all(is_word) {
        return choice(list, None, (span, overrides));
    }
    if list.len() == 2 && list.iter().all(is_end) {
        let value = Spanned::new(span, DeValue::Array(list));
        return numbers(value, overrides, |ends, span| rising(ends, span).map(Law::Uniform));
    }
    let message = match list.len() {
        0 => "there is nothing to choose from",
        _ => "a list is a range of two numbers, or names to choose from",
    };
    Err(Problem::at(span, message).with_help("{ choice = [...] } chooses from any values"))
}

fn of_table(mut table: DeTable<'_>, span: Span, overrides: &Overrides) -> Result<Distribution, Problem> {
    let given: Vec<&(&str, &[&str])> = LAWS.iter().filter(|(name, _)| table.contains_key(*name)).collect();
    let (law, beside) = match given[..] {
        [one] => *one,
        [] => {
            let names = LAWS.map(|(name, _)| name);
            let message = "this distribution has no kind";
            return Err(Problem::at(span, message).with_help(format!("expected {}", one_of(names))));
        }
        [(first, _), (second, _), ..] => {
            let message = format!("a distribution is of one kind, and not `{first}` and `{second}`");
            return Err(Problem::at(span, message));
        }
    };
    let is_known = |key: &str| key == law || beside.contains(&key);
    if let Some(key) = table.keys().find(|key| !is_known(key.get_ref())) {
        let known = beside.iter().copied().chain([law]);
        return Err(UnknownName::new("key", key.get_ref(), known).at(key.span()));
    }
    let mut take = |key: &str| table.remove(key);
    let value = take(law).expect("it is given");
    match law {
        "uniform" => numbers(value, overrides, |ends, span| rising(ends, span).map(Law::Uniform)),
        "log" => numbers(value, overrides, |ends, span| {
            let [least, most] = rising(ends, span.clone())?;
            match least > 0.0 {
                true => Ok(Law::Log([least, most])),
                false => {
                    let message = format!("a logarithmic range lies above 0, and does not begin at {least}");
                    Err(Problem::at(span, message))
                }
            }
        }),
        "normal" => {
            let mut end = |key: &str| {
                let given = take(key).map(|value| read::<Precise>(value, overrides));
                given.transpose().map(|end| end.map(|Precise(end)| end))
            };
            let within = [
                end("min")?.unwrap_or(f64::NEG_INFINITY),
                end("max")?.unwrap_or(f64::INFINITY),
            ];
            numbers(value, overrides, |[mean, deviation], span| {
                normal((mean, deviation), within, span)
            })
        }
        "integer" => {
            let span = value.span();
            let List(ends): List<i64, 2> = read(value, overrides)?;
            if let Some(end) = ends.iter().find(|end| end.unsigned_abs() > LARGEST.unsigned_abs()) {
                return Err(Problem::at(span, format!("{end} is too large")));
            }
            match ends[0] <= ends[1] {
                true => Ok(Distribution::Integer(ends)),
                false => Err(falling(ends, span)),
            }
        }
        "choice" => {
            let weights = take("weights");
            let span = value.span();
            match value.into_inner() {
                DeValue::Array(list) => choice(list, weights, (span, overrides)),
                other => {
                    let message = format!("expected a list to choose from, found {}", found(&other));
                    Err(Problem::at(span, message))
                }
            }
        }
        _ => {
            let span = value.span();
            let radii = match is_number(&value) {
                true => read::<Precise>(value, overrides).map(|Precise(radius)| [radius; 2])?,
                false => {
                    let List([Precise(inner), Precise(outer)]) = read(value, overrides)?;
                    rising([inner, outer], span.clone())?
                }
            };
            if radii[0] < 0.0 || radii[1] == 0.0 {
                let message = format!("a radius is above 0, not {}", radii[0]);
                return Err(Problem::at(span, message));
            }
            let center: Option<Point> = take("center").map(|value| read(value, overrides)).transpose()?;
            let upper: Option<bool> = take("upper").map(|value| read(value, overrides)).transpose()?;
            Ok(Distribution::Sphere(Sphere {
                center: center.unwrap_or_default().0.to_array(),
                radii,
                is_upper: upper.unwrap_or_default(),
            }))
        }
    }
}

/// A number with a law of two numbers, or a list of numbers of which each has one.
fn numbers(
    value: Value<'_>,
    overrides: &Overrides,
    law: impl Fn([f64; 2], Span) -> Result<Law, Problem>,
) -> Result<Distribution, Problem> {
    let span = value.span();
    let is_list = |value: &Value<'_>| value.get_ref().is_array();
    let has_lists = value.get_ref().as_array().is_some_and(|ends| ends.iter().any(is_list));
    if !has_lists {
        let List([Precise(first), Precise(second)]) = read(value, overrides)?;
        return law([first, second], span).map(Distribution::Number);
    }
    let List([first, second]): List<Vec<Precise>, 2> = read(value, overrides)?;
    if first.len() != second.len() || !(1..=LONGEST).contains(&first.len()) {
        let message = format!(
            "two lists of as many numbers are expected, 1 to {LONGEST}, not {} and {}",
            first.len(),
            second.len()
        );
        return Err(Problem::at(span, message));
    }
    let each = first.into_iter().zip(second);
    let laws = each.map(|(Precise(first), Precise(second))| law([first, second], span.clone()));
    laws.collect::<Result<_, _>>().map(Distribution::List)
}

/// Checks that a range does not fall.
fn rising(ends: [f64; 2], span: Span) -> Result<[f64; 2], Problem> {
    match ends[0].partial_cmp(&ends[1]) {
        Some(Ordering::Less | Ordering::Equal) => Ok(ends),
        _ => Err(falling(ends, span)),
    }
}

fn falling<T: std::fmt::Display>([least, most]: [T; 2], span: Span) -> Problem {
    let help = format!("write [{most}, {least}]");
    Problem::at(span, format!("a range rises, and does not fall from {least} to {most}")).with_help(help)
}

fn normal((mean, deviation): (f64, f64), within: [f64; 2], span: Span) -> Result<Law, Problem> {
    if deviation <= 0.0 {
        let message = format!("the deviation of a normal distribution is above 0, not {deviation}");
        return Err(Problem::at(span, message));
    }
    let [least, most] = within;
    if least > most {
        let message = format!("`min` is {least} and lies above `max`, {most}");
        return Err(Problem::at(span, message));
    }
    let share = Law::normal_share(mean, deviation, within);
    if share < LEAST_SHARE {
        let message = format!(
            "less than {} % of the distribution lies in this range",
            100.0 * LEAST_SHARE
        );
        return Err(Problem::at(span, message).with_help("move the range or the mean, or use a uniform range"));
    }
    Ok(Law::Normal {
        mean,
        deviation,
        within,
    })
}

fn choice(
    list: DeArray<'_>,
    weights: Option<Value<'_>>,
    (span, overrides): (Span, &Overrides),
) -> Result<Distribution, Problem> {
    let options: Vec<String> = list.into_iter().map(option).collect::<Result<_, _>>()?;
    if options.is_empty() {
        return Err(Problem::at(span, "there is nothing to choose from"));
    }
    let weights_span = weights.as_ref().map_or(span, |weights| weights.span());
    let weights: Vec<Precise> = match weights {
        Some(weights) => read(weights, overrides)?,
        None => vec![Precise(1.0); options.len()],
    };
    if weights.len() != options.len() {
        let values = match options.len() {
            1 => "1 value".to_owned(),
            count => format!("{count} values"),
        };
        let message = match weights.len() {
            1 => format!("there is 1 weight for {values}"),
            count => format!("there are {count} weights for {values}"),
        };
        return Err(Problem::at(weights_span, message));
    }
    if let Some(Precise(weight)) = weights.iter().find(|Precise(weight)| *weight < 0.0) {
        return Err(Problem::at(
            weights_span,
            format!("a weight is at least 0, not {weight}"),
        ));
    }
    let sums: Vec<f64> = (weights.iter())
        .scan(0.0, |sum, Precise(weight)| {
            *sum += weight;
            Some(*sum)
        })
        .collect();
    if sums.last().is_none_or(|total| *total <= 0.0) {
        return Err(Problem::at(weights_span, "one weight at least is above 0"));
    }
    Ok(Distribution::Choice(Choice { options, sums }))
}

/// A value to choose, in TOML.
fn option(value: Value<'_>) -> Result<String, Problem> {
    let span = value.span();
    let wrong = |what: &str| {
        Problem::at(
            span.clone(),
            format!("{what} cannot be chosen: name the keys that change"),
        )
    };
    Ok(match value.into_inner() {
        DeValue::String(text) => toml::Value::from(text.as_ref()).to_string(),
        DeValue::Boolean(truth) => truth.to_string(),
        number @ (DeValue::Integer(_) | DeValue::Float(_)) => {
            let is_whole = matches!(number, DeValue::Integer(_));
            let value = Spanned::new(span, number);
            let none = Overrides::default();
            match is_whole {
                true => read::<i64>(value, &none)?.to_string(),
                false => read::<Precise>(value, &none).map(|Precise(v)| toml::Value::from(v).to_string())?,
            }
        }
        DeValue::Array(list) => {
            let elements: Vec<String> = list.into_iter().map(option).collect::<Result<_, _>>()?;
            format!("[{}]", elements.join(", "))
        }
        DeValue::Table(_) => return Err(wrong("a table")),
        DeValue::Datetime(_) => return Err(wrong("a date")),
    })
}
