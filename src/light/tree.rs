//! A tree over many lights, to choose one that matters to a place in the time of a few.
//!
//! Each node knows the ball around its lights, where they shine to and how strong they are together. A choice walks down from
//! the root and takes one of two children at each node, in proportion to what they might bring to the place. What a light's
//! chance was is found again on the same walk, by where its leaf is.
//!
//! A node of k lights has 2k - 1 nodes below and with it, the left child beside its parent: so the number of leaves is all that
//! the walk needs to find children and leaves.
//!
//! Source: Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", HPG 2018,
//! doi:10.1145/3233305; without the splitting.

use super::bounds::{Faces, LightBounds, Reach};
use crate::math::Vec3;

mod build;
#[cfg(test)]
mod tests;

/// The lights of a tree, numbered from 0.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    nodes: Vec<Node>,
    /// The light of each leaf, from left to right.
    lights: Vec<u32>,
    /// The leaf of each light; [`ABSENT`] for one that has no power.
    leaves: Vec<u32>,
}

const ABSENT: u32 = u32::MAX;

/// The bit of [`Node::leaves`] that says that lights shine against their normals too.
const BOTH: u32 = 1 << 31;

#[derive(Clone, Copy, Debug)]
struct Node {
    reach: Reach,
    /// How many there are below, and [`BOTH`].
    leaves: u32,
}

impl Node {
    fn new(bounds: &LightBounds, leaves: u32) -> Self {
        let both = if bounds.directions.faces == Faces::Both {
            BOTH
        } else {
            0
        };
        Self {
            reach: bounds.reach(),
            leaves: leaves | both,
        }
    }

    #[inline]
    fn leaves(&self) -> u32 {
        self.leaves & !BOTH
    }

    #[inline]
    fn importance(&self, p: Vec3, n: Vec3) -> f64 {
        let faces = if self.leaves & BOTH != 0 {
            Faces::Both
        } else {
            Faces::Front
        };
        f64::from(self.reach.importance(p, n, faces))
    }
}

/// How likely a walk goes left and right, at one node.
#[derive(Clone, Copy)]
struct Fork {
    left: usize,
    right: usize,
    left_leaves: u32,
    /// The probability of the left; `None` where neither side can matter.
    share: Option<f64>,
}

/// The probability of the first of two importances.
///
/// No side that matters is all but forgotten: what an importance leaves out (the distances within a group, what hides its
/// lights) would make it a bright dot.
#[inline]
fn share(a: f64, b: f64) -> Option<f64> {
    const LEAST: f64 = 1e-4;
    match (a > 0.0, b > 0.0) {
        (false, false) => None,
        (true, false) => Some(1.0),
        (false, true) => Some(0.0),
        (true, true) => Some((a / (a + b)).clamp(LEAST, 1.0 - LEAST)),
    }
}

impl Tree {
    /// Over lights of these bounds, on the threads of the current rayon pool; the same tree on any number of them.
    pub fn build(lights: impl ExactSizeIterator<Item = LightBounds>) -> Self {
        build::tree(lights)
    }

    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// An estimate of what all lights bring to `p` on a surface of unit normal `n` (zero: of any), in W m^-2; 0 only where they
    /// bring nothing.
    #[inline]
    pub fn importance(&self, p: Vec3, n: Vec3) -> f64 {
        self.nodes.first().map_or(0.0, |root| root.importance(p, n))
    }

    #[inline]
    fn fork(&self, node: usize, p: Vec3, n: Vec3) -> Fork {
        let left = node + 1;
        let left_leaves = self.nodes[left].leaves();
        let right = node + 2 * left_leaves as usize;
        let (l, r) = (self.nodes[left].importance(p, n), self.nodes[right].importance(p, n));
        Fork {
            left,
            right,
            left_leaves,
            share: share(l, r),
        }
    }

    /// A light for `p` on a surface of unit normal `n` (zero: of any), and the probability of the choice, by a uniform number in
    /// `[0, 1)`; `None` where none can matter.
    #[inline]
    pub fn choose(&self, p: Vec3, n: Vec3, mut u: f64) -> Option<(u32, f64)> {
        let (mut node, mut first, mut pmf) = (0, 0, 1.0);
        while self.nodes.get(node)?.leaves() > 1 {
            let fork = self.fork(node, p, n);
            let share = fork.share?;
            if u < share {
                u /= share;
                pmf *= share;
                node = fork.left;
            } else {
                u = (u - share) / (1.0 - share);
                pmf *= 1.0 - share;
                node = fork.right;
                first += fork.left_leaves;
            }
            u = u.min(1.0 - f64::EPSILON);
        }
        Some((self.lights[first as usize], pmf))
    }

    /// The probability of [`Tree::choose`] to choose `light`.
    #[inline]
    pub fn pmf(&self, p: Vec3, n: Vec3, light: u32) -> f64 {
        let leaf = self.leaves[light as usize];
        if leaf == ABSENT {
            return 0.0;
        }
        let (mut node, mut first, mut pmf) = (0, 0, 1.0);
        while self.nodes[node].leaves() > 1 {
            let fork = self.fork(node, p, n);
            let Some(share) = fork.share else { return 0.0 };
            if leaf < first + fork.left_leaves {
                pmf *= share;
                node = fork.left;
            } else {
                pmf *= 1.0 - share;
                node = fork.right;
                first += fork.left_leaves;
            }
        }
        pmf
    }
}
