//! The clear coat, whose normal may differ from that of the surface below it.

use super::{BsdfEval, BsdfSample, Layered, LobeState, mirror_image};
use crate::{
    bsdf::{BsdfKind, Lobe, fresnel::schlick_term, microfacet::Facets},
    math::{Frame, Rgb, Sample2D, Vec3},
};

/// The reflectance of a clear coat at normal incidence: an index of refraction of 1.5.
pub(super) const COAT_F0: f32 = 0.04;

impl Layered {
    /// The frame of the coat in that of the facets, seen from behind if `below`; `None` where the two have one normal.
    pub(super) fn coat_frame(&self, below: bool) -> Option<Frame> {
        let n = self.layers.coat_normal;
        if n == Vec3::Z {
            return None;
        }
        let outwards = if below { Vec3::new(-n.x, -n.y, n.z) } else { n };
        Some(Frame::from_normal(self.layers.facet_from_surface(outwards)))
    }

    /// The part of the light that the coat reflects towards `coat_o`, in its own frame.
    pub(super) fn albedo_of_coat(&self, coat_o: Vec3) -> f32 {
        if self.layers.coat > 0.0 && coat_o.z > 0.0 {
            let [a, b] = self.coat_albedo.schlick(&self.layers.coat_facets, coat_o);
            self.layers.coat * (COAT_F0 * a + b)
        } else {
            0.0
        }
    }

    /// The light that the coat's facets reflect at the cosine `cos`.
    fn coat_weight(&self, state: &LobeState, cos: f32) -> f32 {
        let grazing = schlick_term(cos);
        self.layers.coat * state.under_sheen * (COAT_F0 * (1.0 - grazing) + grazing)
    }

    /// Adds the reflection of a rough coat to `eval`; `i` is seen from the side of `state.o`.
    pub(super) fn add_coat(&self, state: &LobeState, i: Vec3, eval: &mut BsdfEval) {
        if state.probabilities.coat > 0.0
            && !self.layers.coat_facets.is_smooth()
            && let Some(facet) = self
                .layers
                .coat_facets
                .reflection(state.coat_o, state.coat_from_facet(i))
        {
            let f = self.coat_weight(state, facet.cos);
            eval.glossy += Rgb::gray(f * facet.pdf * facet.masking);
            eval.pdf += state.probabilities.coat * facet.pdf;
        }
    }

    /// A reflection of the coat. That of a tilted one may be below the plane of an opaque surface's normal.
    pub(super) fn sample_coat(&self, state: &LobeState, u: Sample2D) -> Option<BsdfSample> {
        let o = state.coat_o;
        let is_smooth = self.layers.coat_facets.is_smooth();
        let mirrored = if is_smooth {
            mirror_image(o)
        } else {
            self.layers.coat_facets.sample_reflection(o, u.square)?
        };
        let i = state.facet_from_coat(mirrored);
        if i.z < 0.0 && self.transmits() {
            return None;
        }
        if is_smooth {
            let weight = Rgb::gray(self.coat_weight(state, o.z));
            Some(self.delta(i, weight, state.probabilities.coat, Lobe::Specular))
        } else {
            self.weighted(state, i, Lobe::Specular, 1.0)
        }
    }
}

impl LobeState {
    /// `w`, given in the frame of the facets, in that of the coat.
    fn coat_from_facet(&self, w: Vec3) -> Vec3 {
        self.coat_frame.map_or(w, |frame| frame.to_local(w))
    }

    /// `w`, given in the frame of the coat, in that of the facets.
    fn facet_from_coat(&self, w: Vec3) -> Vec3 {
        self.coat_frame.map_or(w, |frame| frame.to_world(w))
    }
}
