//! Ambient occlusion: how open to the sky each point is, without any light, material or bounce.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `distance` | farthest surface that occludes; 0 is no limit | m | 0 |
//! | `samples` | occlusion rays for each camera ray, at least 1 | | 1 |
//!
//! ```toml
//! [render]
//! integrator.occlusion = { distance = 2, samples = 4 }
//! ```
//!
//! White is open, black is enclosed. Rays are distributed by their cosine with the shading normal on the viewer's side, so
//! the value is the fraction of a uniform sky's irradiance that arrives. A camera ray that meets nothing is white, or
//! transparent where the background is invisible. A shadow catcher shows the occlusion by other objects alone, over white
//! or what the picture is put over.
//!
//! Source: Zhukov, Iones, Kronin, "An Ambient Light Illumination Model", EGWR 1998, doi:10.1007/978-3-7091-6453-2_5.

use serde::{Deserialize, Serialize};

use super::{Integrator, ShadingOutput, Vertex, VertexContext};
use crate::{
    math::{Frame, Rgb},
    sampler::{Dimension, SampleUse},
    value::{Count, NonNegative, Problem, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OcclusionDesc {
    pub distance: Option<NonNegative>,
    pub samples: Option<Spanned<Count>>,
}

impl OcclusionDesc {
    pub fn compile(&self) -> Result<Occlusion, Problem> {
        let samples = match &self.samples {
            None => 1,
            Some(n) if n.get_ref().0 == 0 => {
                return Err(Problem::at(n.span(), "expected at least 1 sample, found 0"));
            }
            Some(n) => n.get_ref().0,
        };
        let distance = self.distance.map_or(0.0, |d| d.0);
        Ok(Occlusion {
            distance: if distance == 0.0 { f32::INFINITY } else { distance },
            samples,
        })
    }
}

#[derive(Clone, Copy, Debug, Serialize)]
pub struct Occlusion {
    /// In m; infinite for no limit.
    pub distance: f32,
    /// Occlusion rays for each vertex.
    pub samples: u32,
}

/// The most rays of a vertex that are in memory at the same time.
const RAYS_PER_ROUND: u32 = 64;

impl Integrator for Occlusion {
    fn shadow_rounds(&self) -> u32 {
        self.samples.div_ceil(RAYS_PER_ROUND)
    }

    fn has_light(&self) -> bool {
        false
    }

    fn vertex(&self, context: &VertexContext<'_>, out: &mut ShadingOutput) {
        let Vertex::Surface(surface, _) = context.vertex else {
            return out.add(Rgb::WHITE);
        };
        let outward = surface.outward_normal();
        let front = surface.ng.dot(surface.wo) >= 0.0;
        let frame = Frame::from_normal(if front { outward } else { -outward });
        let share = Rgb::gray(1.0 / self.samples as f32);
        let first = context.round * RAYS_PER_ROUND;
        for i in first..self.samples.min(first.saturating_add(RAYS_PER_ROUND)) {
            // No path continues, so the numbers of later vertices are free.
            let u = context.numbers.get_sample_2d(Dimension::at(1 + i, SampleUse::Bsdf));
            let wi = frame.to_world(u.cosine_hemisphere());
            out.add_shadow(surface.shadow_ray(false, wi, self.distance), share);
        }
    }
}
