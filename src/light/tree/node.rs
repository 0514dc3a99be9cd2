//! A node of the light tree: up to eight groups of lights.

use super::groups::LightGroups;
use crate::math::Vec3;

/// The number of groups in a node.
pub(super) const WIDTH: usize = 8;

/// The bit of a child that is a light.
const LIGHT: u32 = 1 << 31;

/// A place in a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub node: u32,
    pub lane: u32,
}

/// The nodes below a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    Node(u32),
    Light(u32),
}

#[derive(Clone, Debug)]
pub(super) struct LightNode {
    pub groups: LightGroups<WIDTH>,
    children: [u32; WIDTH],
    /// The position of this node in its parent; `None` for the root.
    pub above: Option<Place>,
}

/// The cumulative weights of a node's groups.
#[derive(Clone, Copy)]
pub(super) struct Shares {
    sums: [f64; WIDTH],
}

impl LightNode {
    pub fn new(above: Option<Place>) -> Self {
        Self {
            groups: LightGroups::NONE,
            children: [0; WIDTH],
            above,
        }
    }

    pub fn set_child(&mut self, lane: usize, child: Child) {
        self.children[lane] = match child {
            Child::Node(node) => node,
            Child::Light(light) => light | LIGHT,
        };
    }

    #[inline(always)]
    pub fn child(&self, lane: usize) -> Child {
        let child = self.children[lane];
        if child & LIGHT == 0 {
            Child::Node(child)
        } else {
            Child::Light(child & !LIGHT)
        }
    }

    /// The cumulative weights for `p` on a surface of unit normal `n` (zero: of any); `None` if no group can contribute.
    ///
    /// Groups that can contribute have a least weight, because importance ignores occlusion and the distances within a group: a
    /// very small probability would cause fireflies.
    #[inline(always)]
    pub fn shares(&self, p: Vec3, n: Vec3) -> Option<Shares> {
        const MIN_PROBABILITY: f32 = 1e-4;
        let importances = self.groups.importances(p, n);
        let mut all = 0.0;
        for importance in importances {
            all += importance;
        }
        let least = all * MIN_PROBABILITY;
        let mut sums = [0.0; WIDTH];
        let mut sum = 0.0;
        for (to, importance) in sums.iter_mut().zip(importances) {
            sum += f64::from(if importance > 0.0 { importance.max(least) } else { 0.0 });
            *to = sum;
        }
        (sum > 0.0).then_some(Shares { sums })
    }
}

impl Shares {
    #[inline(always)]
    fn before(&self, lane: usize) -> f64 {
        if lane == 0 { 0.0 } else { self.sums[lane - 1] }
    }

    #[inline(always)]
    pub fn probability(&self, lane: usize) -> f64 {
        (self.sums[lane] - self.before(lane)) / self.sums[WIDTH - 1]
    }

    /// The group that `u` in `[0, 1)` selects, and a new uniform number for its children.
    ///
    /// The group is unpredictable, so all sums are compared without branches.
    #[inline(always)]
    pub fn choose(&self, u: f64) -> (usize, f64) {
        let total = self.sums[WIDTH - 1];
        // Rounding must not reach the total, so that the selected group has a weight.
        let place = (u * total).min(total.next_down());
        let mut lane = 0;
        for sum in &self.sums[..WIDTH - 1] {
            lane += usize::from(*sum <= place);
        }
        let (before, weight) = (self.before(lane), self.sums[lane] - self.before(lane));
        (lane, ((place - before) / weight).clamp(0.0, 1.0 - f64::EPSILON))
    }
}
