//! Columns of values that are drawn at random, and whether their draws are right.

use super::{
    DrawKey, FrameTime, MovingDesc, RandomDesc, SceneDesc,
    cell_faults::Faults,
    values::{Curve, RandomCurve, Values},
};
use crate::value::Problem;

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
                let is_open = problem.help.is_none() && random.distribution.is_unbounded();
                let help = is_open.then(|| "`min` and `max` keep draws in a range".to_owned());
                let help = help.or_else(|| problem.help.clone());
                faults.add(self.head(column), Problem { help, ..problem });
            }
            if faults.are_many() {
                return;
            }
        }
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
