//! A node of the light tree: up to eight groups of lights.

use super::{
    groups::{LightGroups, WIDTH},
    shares::Shares,
};
use crate::math::Vec3;

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
    /// The number of groups.
    pub count: usize,
    /// The position of this node in its parent; `None` for the root.
    pub above: Option<Place>,
}

impl LightNode {
    pub fn new(above: Option<Place>) -> Self {
        Self {
            groups: LightGroups::NONE,
            children: [0; WIDTH],
            count: 0,
            above,
        }
    }

    pub fn set_child(&mut self, lane: usize, child: Child) {
        self.children[lane] = match child {
            Child::Node(node) => node,
            Child::Light(light) => light | LIGHT,
        };
        self.count = self.count.max(lane + 1);
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

    /// The probability of the group at place `lane` for `p` on a surface of unit normal `n` (zero: of any).
    pub fn probability(&self, p: Vec3, n: Vec3, lane: usize) -> f64 {
        let importances = self.groups.importances(p, n);
        let shares = Shares::of(&importances.map(|importance| [importance]));
        let probability = shares.after(lane)[0] - shares.before(lane)[0];
        if shares.total()[0] > 0.0 {
            probability / shares.total()[0]
        } else {
            0.0
        }
    }
}
