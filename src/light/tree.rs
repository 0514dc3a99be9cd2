//! A bounding volume hierarchy over lights, which samples one light in proportion to its importance
//! for a point.
//!
//! Each node bounds the position, the orientation and the power of up to eight groups of lights. Sampling descends from the
//! root and chooses one of the groups by their importance, which is computed for all of them at once. The probability of a given
//! light is computed by the same descent.
//!
//! Source: Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", HPG 2018, doi:10.1145/3233305; without the splitting, which brings no gain with low-discrepancy numbers: in a scene
//! of 200 lights, four lights instead of one at the first vertex lower the variance 1.3 to 1.5 times, in 1.6 times the time.

use crate::math::{Dispatch, Vec3};
use descent::Descents;
pub use descent::TreeChoice;
use groups::LightGroups;
use node::{LightNode, Place};

mod binary;
mod build;
mod collapse;
mod descent;
mod groups;
mod node;
mod shares;
#[cfg(test)]
mod tests;

/// A tree over lights, which are numbered from 0.
#[derive(Clone, Debug)]
pub struct LightTree {
    nodes: Vec<LightNode>,
    /// The bounds of all lights.
    all: LightGroups<1>,
    /// The position of each light in the tree; `None` for a light without power.
    places: Vec<Option<Place>>,
}

impl Default for LightTree {
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            all: LightGroups::NONE,
            places: Vec::new(),
        }
    }
}

impl LightTree {
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// An estimate of the irradiance of all lights at `p` on a surface of unit normal `n` (zero: of any), in W m^-2; 0 only if none
    /// arrives.
    #[inline]
    pub fn importance(&self, p: Vec3, n: Vec3) -> f64 {
        let [importance] = self.all.importances(p, n);
        importance.into()
    }

    /// Selects a light for `p` on a surface of unit normal `n` (zero: of any), by a uniform number in `[0, 1)`; returns it with its
    /// probability, or `None` if no light can contribute.
    pub fn choose(&self, on: impl Dispatch, p: Vec3, n: Vec3, u: f64) -> Option<(u32, f64)> {
        let mut point = TreeChoice::new(p, n, u);
        self.choose_all(on, std::slice::from_mut(&mut point), 1);
        point.chosen
    }

    /// Does the same for each of up to [`LANES`](crate::math::block::LANES) points, those whose bits in `lanes` are set.
    #[inline]
    pub fn choose_all(&self, on: impl Dispatch, points: &mut [TreeChoice], lanes: u32) {
        if lanes != 0 && !self.is_empty() {
            on.dispatch(Descents {
                nodes: &self.nodes,
                points,
                lanes,
            });
        }
    }

    /// The probability that [`LightTree::choose`] selects `light`.
    #[inline]
    pub fn pmf(&self, p: Vec3, n: Vec3, light: u32) -> f64 {
        self.places[light as usize].map_or(0.0, |place| self.pmf_of(p, n, place))
    }

    fn pmf_of(&self, p: Vec3, n: Vec3, place: Place) -> f64 {
        let node = &self.nodes[place.node as usize];
        let above = node.above.map_or(1.0, |above| self.pmf_of(p, n, above));
        if above > 0.0 {
            above * node.probability(p, n, place.lane as usize)
        } else {
            0.0
        }
    }
}
