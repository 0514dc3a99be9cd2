//! Columns of values that are drawn at random, and whether their draws are right.

use super::{
    Diagnostics, DrawKey, FrameTime, MovingDesc, RandomDesc, SceneDesc,
    cell_faults::Faults,
    values::{Curve, RandomCurve, Values},
};
use crate::{math::sorting, value::Problem};

impl Values {
    /// Whether the value that has a problem is drawn.
    pub(super) fn is_drawn(&self, problem: &Problem) -> bool {
        let column = self.column_of(problem).map(|at| &self.columns[at]);
        column.is_some_and(|column| matches!(column.curve, Curve::Random(_)))
    }

    /// Adds a fault for each distribution whose outermost values are wrong.
    pub(super) fn judge_distributions(&self, moving: &MovingDesc<'_>, faults: &mut Faults<'_>) {
        for (at, column) in self.columns.iter().enumerate() {
            let Curve::Random(random) = &column.curve else { continue };
            let outermost = random.distribution.outermost().into_iter();
            let wrong = outermost.flat_map(|text| moving.problems_of(at, &text, FrameTime::from(1.0)));
            if let Some(problem) = wrong.into_iter().next() {
                faults.add(self.head(column), problem);
            }
            if faults.are_many() {
                return;
            }
        }
    }

    /// Checks the least and the largest draw of these frames, of the distributions that have no ends.
    ///
    /// # Errors
    /// One of them is wrong.
    pub fn check_draws(&self, desc: &SceneDesc, frames: impl Iterator<Item = i64> + Clone) -> Result<(), Diagnostics> {
        let moving = MovingDesc::new(desc, self);
        for (at, column) in self.columns.iter().enumerate() {
            let Curve::Random(random) = &column.curve else { continue };
            if !random.distribution.is_unbounded() {
                continue;
            }
            let drawn = frames
                .clone()
                .map(|frame| (random.distribution.draw(random.key, frame), frame));
            let mut drawn: Vec<(Vec<f64>, String, i64)> =
                drawn.map(|(text, frame)| (numbers(&text), text, frame)).collect();
            for component in 0..drawn.first().map_or(0, |(numbers, ..)| numbers.len()) {
                sorting::sort_by(&mut drawn, |a, b| a.0[component].total_cmp(&b.0[component]));
                for (_, text, frame) in drawn.first().into_iter().chain(drawn.last()) {
                    let time = FrameTime::from(*frame as f64);
                    let problems = moving.problems_of(at, text, time);
                    if let Some(problem) = problems.into_iter().next() {
                        let help = problem
                            .help
                            .clone()
                            .unwrap_or_else(|| "`min` and `max` keep draws in a range".to_owned());
                        return Err(moving.diagnostics(time, vec![problem.with_help(help)]));
                    }
                }
            }
        }
        Ok(())
    }
}

/// The draws of a value.
pub(super) fn drawn_curve(desc: &SceneDesc, random: &RandomDesc, at: usize) -> Curve {
    let draw = &random.draws[at];
    let scene = random.scene.clone().unwrap_or_else(|| desc.name());
    Curve::Random(RandomCurve {
        key: DrawKey::new(random.seed, &scene, &draw.name),
        distribution: draw.distribution.clone(),
        origin: draw.origin.clone(),
    })
}

/// The numbers of a value in TOML.
fn numbers(text: &str) -> Vec<f64> {
    match text.parse::<toml::Value>() {
        Ok(toml::Value::Array(list)) => list.iter().filter_map(toml::Value::as_float).collect(),
        Ok(value) => value.as_float().into_iter().collect(),
        Err(_) => Vec::new(),
    }
}
