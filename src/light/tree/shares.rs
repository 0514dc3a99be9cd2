//! The shares of a node's groups for a block of points.

use super::groups::WIDTH;

/// The least probability of a group that can contribute. Importance ignores occlusion and the distances within a group: a very
/// small probability would cause fireflies.
const MIN_PROBABILITY: f32 = 1e-4;

/// The cumulative weights of a node's groups, for `N` points.
#[derive(Clone, Copy)]
pub(super) struct Shares<const N: usize> {
    sums: [[f64; N]; WIDTH],
}

/// The groups that uniform numbers select, for `N` points.
pub(super) struct Selection<const N: usize> {
    pub group: [u32; N],
    pub probability: [f64; N],
    /// A new uniform number for the children of the group.
    pub u: [f64; N],
    /// Whether any group can contribute. If not, the rest is unspecified.
    pub is_any: [bool; N],
}

impl<const N: usize> Shares<N> {
    /// The shares of groups of these importances.
    #[inline(always)]
    pub fn of(importances: &[[f32; N]; WIDTH]) -> Self {
        let mut all = [0.0; N];
        for group in importances {
            for i in 0..N {
                all[i] += group[i];
            }
        }
        let (mut sums, mut sum) = ([[0.0; N]; WIDTH], [0.0; N]);
        for k in 0..WIDTH {
            for i in 0..N {
                let (importance, least) = (importances[k][i], all[i] * MIN_PROBABILITY);
                let weight = if importance > least { importance } else { least };
                sum[i] += f64::from(if importance > 0.0 { weight } else { 0.0 });
            }
            sums[k] = sum;
        }
        Self { sums }
    }

    /// The weights of the groups before `group`.
    #[inline(always)]
    pub fn before(&self, group: usize) -> [f64; N] {
        if group == 0 { [0.0; N] } else { self.sums[group - 1] }
    }

    /// The weights of the groups up to `group`.
    #[inline(always)]
    pub fn after(&self, group: usize) -> [f64; N] {
        self.sums[group]
    }

    /// The weights of all groups.
    #[inline(always)]
    pub fn total(&self) -> [f64; N] {
        self.sums[WIDTH - 1]
    }

    /// The groups that uniform numbers in `[0, 1)` select. Groups are unpredictable, so all sums are compared, without branches.
    #[inline(always)]
    pub fn choose(&self, u: &[f64; N]) -> Selection<N> {
        let mut chosen = Selection {
            group: [0; N],
            probability: [0.0; N],
            u: [0.0; N],
            is_any: [false; N],
        };
        for (i, u) in u.iter().enumerate() {
            let total = self.sums[WIDTH - 1][i];
            // Rounding must not reach the total, so that the selected group has a weight.
            let below = f64::from_bits(total.to_bits().wrapping_sub(1));
            let place = if u * total < below { u * total } else { below };
            let (mut group, mut before, mut after) = (0, 0.0, total);
            for k in 0..WIDTH - 1 {
                let sum = self.sums[k][i];
                group += u32::from(sum <= place);
                before = if sum <= place { sum } else { before };
            }
            for k in (0..WIDTH - 1).rev() {
                let sum = self.sums[k][i];
                after = if sum <= place { after } else { sum };
            }
            let rest = (place - before) / (after - before);
            let most = 1.0 - f64::EPSILON;
            let rest = if rest > 0.0 { rest } else { 0.0 };
            chosen.u[i] = if rest < most { rest } else { most };
            chosen.probability[i] = (after - before) / total;
            chosen.group[i] = group;
            chosen.is_any[i] = total > 0.0;
        }
        chosen
    }
}
