//! A bounding volume hierarchy over lights, which samples one light in proportion to its importance
//! for a point.
//!
//! Each node bounds the position, the orientation and the power of its lights. Sampling descends
//! from the root and chooses one of two children by their importance. The probability of a given
//! light is computed by the same descent.
//!
//! A node of k lights and its descendants are 2k - 1 consecutive nodes; the left child follows its
//! parent. The number of leaves is therefore enough to find the children.
//!
//! Source: Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", HPG 2018, doi:10.1145/3233305; without the splitting.

use crate::math::Vec3;
use node::{LightNode, NO_LEAF};

mod build;
mod node;
#[cfg(test)]
mod tests;

/// A tree over lights, which are numbered from 0.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    nodes: Vec<LightNode>,
    /// The light of each leaf, from left to right.
    lights: Vec<u32>,
    /// The leaf of each light; [`NO_LEAF`] for one that has no power.
    leaves: Vec<u32>,
}

/// The children of a node and the probability of the left one.
#[derive(Clone, Copy)]
struct Children {
    left: usize,
    right: usize,
    left_leaves: u32,
    /// The probability of the left; `None` where neither side can matter.
    share: Option<f64>,
}

/// The probability of the first of two importances.
///
/// No side that matters is all but forgotten: what an importance leaves out (the distances within a
/// group, what hides its lights) would make it a bright dot.
#[inline]
fn share(a: f64, b: f64) -> Option<f64> {
    const MIN_PROBABILITY: f64 = 1e-4;
    match (a > 0.0, b > 0.0) {
        (false, false) => None,
        (true, false) => Some(1.0),
        (false, true) => Some(0.0),
        (true, true) => Some((a / (a + b)).clamp(MIN_PROBABILITY, 1.0 - MIN_PROBABILITY)),
    }
}

impl LightTree {
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// An estimate of what all lights bring to `p` on a surface of unit normal `n` (zero: of any),
    /// in W m^-2; 0 only where they bring nothing.
    #[inline]
    pub fn importance(&self, p: Vec3, n: Vec3) -> f64 {
        self.nodes.first().map_or(0.0, |root| root.importance(p, n))
    }

    #[inline]
    fn children(&self, node: usize, p: Vec3, n: Vec3) -> Children {
        let left = node + 1;
        let left_leaves = self.nodes[left].leaves();
        let right = node + 2 * left_leaves as usize;
        let (l, r) = (self.nodes[left].importance(p, n), self.nodes[right].importance(p, n));
        Children {
            left,
            right,
            left_leaves,
            share: share(l, r),
        }
    }

    /// A light for `p` on a surface of unit normal `n` (zero: of any), and the probability of the
    /// choice, by a uniform number in `[0, 1)`; `None` where none can matter.
    #[inline]
    pub fn choose(&self, p: Vec3, n: Vec3, mut u: f64) -> Option<(u32, f64)> {
        let (mut node, mut first, mut pmf) = (0, 0, 1.0);
        while self.nodes.get(node)?.leaves() > 1 {
            let children = self.children(node, p, n);
            let share = children.share?;
            if u < share {
                u /= share;
                pmf *= share;
                node = children.left;
            } else {
                u = (u - share) / (1.0 - share);
                pmf *= 1.0 - share;
                node = children.right;
                first += children.left_leaves;
            }
            u = u.min(1.0 - f64::EPSILON);
        }
        Some((self.lights[first as usize], pmf))
    }

    /// The probability of [`LightTree::choose`] to choose `light`.
    #[inline]
    pub fn pmf(&self, p: Vec3, n: Vec3, light: u32) -> f64 {
        let leaf = self.leaves[light as usize];
        if leaf == NO_LEAF {
            return 0.0;
        }
        let (mut node, mut first, mut pmf) = (0, 0, 1.0);
        while self.nodes[node].leaves() > 1 {
            let children = self.children(node, p, n);
            let Some(share) = children.share else { return 0.0 };
            if leaf < first + children.left_leaves {
                pmf *= share;
                node = children.left;
            } else {
                pmf *= 1.0 - share;
                node = children.right;
                first += children.left_leaves;
            }
        }
        pmf
    }
}
