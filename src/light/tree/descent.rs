//! Descents from the root of the tree to lights, for a block of points.

use super::{
    groups::WIDTH,
    node::{Child, LightNode},
    shares::Shares,
};
use crate::math::{
    Vec3, VectorLoop,
    block::{Each, LANES, get, set},
};

/// A point for which [`LightTree::choose_all`](super::LightTree::choose_all) selects a light.
#[derive(Clone, Copy, Debug)]
pub struct TreeChoice {
    p: Vec3,
    n: Vec3,
    u: f64,
    /// The light and its probability; `None` if no light can contribute.
    pub chosen: Option<(u32, f64)>,
}

impl TreeChoice {
    /// A point `p` on a surface of unit normal `n` (zero: of any), with a uniform number in `[0, 1)`.
    #[inline(always)]
    pub fn new(p: Vec3, n: Vec3, u: f64) -> Self {
        Self { p, n, u, chosen: None }
    }
}

/// The descents of points; see [`LightTree::choose_all`](super::LightTree::choose_all). They go down level by level, so that the
/// work for different points overlaps in the processor.
pub(super) struct Descents<'a> {
    pub nodes: &'a [LightNode],
    pub points: &'a mut [TreeChoice],
    /// The points for which a light is selected, one bit each.
    pub lanes: u32,
}

/// Points as arrays.
struct Points {
    p: [Each; 3],
    n: [Each; 3],
    u: Each<f64>,
    pmf: Each<f64>,
    /// The node that each point has reached.
    node: Each<u32>,
}

impl Points {
    #[inline(always)]
    fn load(points: &[TreeChoice]) -> Self {
        let mut loaded = Self {
            p: [[0.0; LANES]; 3],
            n: [[0.0; LANES]; 3],
            u: [0.0; LANES],
            pmf: [1.0; LANES],
            node: [0; LANES],
        };
        for (lane, point) in points.iter().enumerate().take(LANES) {
            set(&mut loaded.p, lane, point.p);
            set(&mut loaded.n, lane, point.n);
            loaded.u[lane] = point.u;
        }
        loaded
    }

    #[inline(always)]
    fn at(&self, lane: usize) -> (Vec3, Vec3) {
        (get(&self.p, lane), get(&self.n, lane))
    }

    /// The importances of a node's groups for all points.
    #[inline(always)]
    fn importances_of(&self, node: &LightNode) -> [Each; WIDTH] {
        let mut all = [[0.0; LANES]; WIDTH];
        for (group, importances) in all.iter_mut().enumerate().take(node.count) {
            let mut found = [0.0; LANES];
            for (lane, importance) in found.iter_mut().enumerate() {
                let (p, n) = self.at(lane);
                *importance = node.groups.importance(group, p, n);
            }
            *importances = found;
        }
        all
    }

    /// The importances of the groups of the nodes that the points in `active` have reached.
    #[inline(always)]
    fn importances(&self, nodes: &[LightNode], active: u32) -> [Each; WIDTH] {
        let mut all = [[0.0; LANES]; WIDTH];
        let mut left = active;
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let (p, n) = self.at(lane);
            let importances = nodes[self.node[lane] as usize].groups.importances(p, n);
            for group in 0..WIDTH {
                all[group][lane] = importances[group];
            }
        }
        all
    }
}

impl VectorLoop for Descents<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { nodes, points, lanes } = self;
        let mut loaded = Points::load(points);
        // The points that have not reached a light.
        let mut active = lanes & ((1 << points.len().min(LANES)) - 1);
        let mut importances = loaded.importances_of(&nodes[0]);
        while active != 0 {
            let chosen = Shares::of(&importances).choose(&loaded.u);
            loaded.u = chosen.u;
            for lane in 0..LANES {
                loaded.pmf[lane] *= chosen.probability[lane];
            }
            let mut left = active;
            while left != 0 {
                let lane = left.trailing_zeros() as usize % LANES;
                left &= left - 1;
                if !chosen.is_any[lane] {
                    active &= !(1 << lane);
                    continue;
                }
                match nodes[loaded.node[lane] as usize].child(chosen.group[lane] as usize) {
                    Child::Node(below) => loaded.node[lane] = below,
                    Child::Light(light) => {
                        points[lane].chosen = Some((light, loaded.pmf[lane]));
                        active &= !(1 << lane);
                    }
                }
            }
            importances = loaded.importances(nodes, active);
        }
    }
}
