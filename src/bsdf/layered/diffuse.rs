//! The diffuse base below its boundary.
//!
//! Light that it passes on leaves through a boundary like the one that it came in by, so that it takes the same way back.

use std::f32::consts::FRAC_1_PI;

use super::{BsdfEval, Layered, LobeState};
use crate::{
    bsdf::fresnel::mirrored,
    math::{Vec3, warp},
};

impl Layered {
    /// Adds the diffuse base to `eval`; `i` is seen from the side of `state.o`.
    pub(super) fn add_diffuse(&self, state: &LobeState, i: Vec3, eval: &mut BsdfEval) {
        if state.diffuse == 0.0 {
            return;
        }
        let (color, share, above) = if i.z < 0.0 {
            let color = self.layers.diffuse_transmission_color * self.layers.diffuse_transmission;
            (color, state.diffuse_passes, mirrored(i))
        } else {
            let color = self.layers.base_color * (1.0 - self.layers.diffuse_transmission);
            (color, 1.0 - state.diffuse_passes, i)
        };
        let passes = (1.0 - self.over_albedo(state.over_f0, above)) * state.diffuse_gain;
        eval.diffuse += color * (state.diffuse * state.under_coat * passes * above.z * FRAC_1_PI);
        eval.pdf += state.probabilities.diffuse * share * warp::cosine_hemisphere_pdf(above.z);
    }
}
