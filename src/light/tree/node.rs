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
    /// The place of this node in the one above; `None` for the root.
    pub above: Option<Place>,
}

/// The shares of a node's groups in a choice.
#[derive(Clone, Copy)]
pub(super) struct Shares {
    weights: [f64; WIDTH],
    sum: f64,
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

    #[inline]
    pub fn child(&self, lane: usize) -> Child {
        let child = self.children[lane];
        if child & LIGHT == 0 {
            Child::Node(child)
        } else {
            Child::Light(child & !LIGHT)
        }
    }

    /// The shares of the groups for `p` on a surface of unit normal `n` (zero: of any); `None` where none can matter.
    ///
    /// No group that matters is all but forgotten: what an importance leaves out (the distances within a group, what hides its
    /// lights) would make it a bright dot.
    #[inline(always)]
    pub fn shares(&self, p: Vec3, n: Vec3) -> Option<Shares> {
        const MIN_PROBABILITY: f32 = 1e-4;
        let importances = self.groups.importances(p, n);
        let least = importances.iter().sum::<f32>() * MIN_PROBABILITY;
        let weights = importances.map(|w| f64::from(if w > 0.0 { w.max(least) } else { 0.0 }));
        let sum = weights.iter().sum::<f64>();
        (sum > 0.0).then_some(Shares { weights, sum })
    }
}

impl Shares {
    #[inline]
    pub fn probability(&self, lane: usize) -> f64 {
        self.weights[lane] / self.sum
    }

    /// The group that `u` in `[0, 1)` chooses, and a fresh number for what is below it.
    #[inline]
    pub fn choose(&self, u: f64) -> (usize, f64) {
        let mut rest = u * self.sum;
        let mut chosen = (0, 0.0);
        for (lane, &weight) in self.weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            chosen = (lane, (rest / weight).min(1.0 - f64::EPSILON));
            if rest < weight {
                break;
            }
            rest -= weight;
        }
        chosen
    }
}
