//! The limits of paths: their length, Russian roulette, and clamping.

use serde::Serialize;

use super::{Bounces, Limit, LimitValue, PathState, ShadowPassage, VertexContext};
use crate::{
    bsdf::Lobe,
    math::Rgb,
    sampler::{Dimension, SampleUse},
    scene::MediumStack,
};

#[derive(Clone, Copy, Debug, Serialize)]
pub struct PathLimits {
    pub max_depth: u32,
    /// The most scattering events of each kind.
    pub bounces: Bounces,
    pub roulette_depth: u32,
    /// The most light by one surface, and by several, in W m^-2 sr^-1.
    pub clamp_direct: Option<f32>,
    pub clamp_indirect: Option<f32>,
}

/// The throughput below which the survival probability is proportional to the throughput. Source: Veach, "Robust Monte Carlo
/// Methods for Light Transport Simulation", 1997, section 10.4.
const DIM: f32 = 0.25;
/// The largest survival probability, so that paths between mirrors end.
const MAX_SURVIVAL: f32 = 0.98;

impl PathLimits {
    /// The limits that are set, with their names in metadata.
    pub fn named(&self) -> Vec<Limit> {
        let bounces = |name, n: u16| {
            (n < u16::MAX).then(|| Limit {
                name,
                value: LimitValue::Count(n.into()),
            })
        };
        let depth = Limit {
            name: "maxDepth",
            value: LimitValue::Count(self.max_depth),
        };
        let clamp = |name, l: Option<f32>| {
            l.map(|l| Limit {
                name,
                value: LimitValue::Radiance(l),
            })
        };
        let all = [
            Some(depth),
            bounces("maxDiffuse", self.bounces.diffuse),
            bounces("maxSpecular", self.bounces.specular),
            bounces("maxTransmission", self.bounces.transmission),
            clamp("clampDirect", self.clamp_direct),
            clamp("clampIndirect", self.clamp_indirect),
        ];
        all.into_iter().flatten().collect()
    }

    /// The bounces and the weight of the path if `lobe` continues it; `None` if the roulette ends it.
    #[inline(always)]
    pub(super) fn go_on(&self, context: &VertexContext<'_>, lobe: Lobe, weight: Rgb) -> Option<(Bounces, Rgb)> {
        let path = context.path;
        let bounces = path.last.bounces.and(lobe, self.bounces);
        if path.depth < self.roulette_depth {
            return Some((bounces, weight));
        }
        let survival = ((path.throughput * weight).max_component() / DIM).min(MAX_SURVIVAL);
        let u = context.numbers.get_2d(Dimension::at(path.depth, SampleUse::Roulette)).x;
        (u < survival).then(|| (bounces, weight / survival))
    }

    /// The passage of a shadow ray that starts in `media`, behind the surface if that is `transmitted`.
    #[cold]
    pub(super) fn passage(&self, path: &PathState, media: MediumStack, transmitted: bool) -> ShadowPassage {
        let events = path.last.bounces.transmission.saturating_add(transmitted.into());
        let transmissions = self.bounces.transmission.saturating_sub(events);
        ShadowPassage {
            media,
            surfaces: (self.max_depth - path.depth - 1).min(transmissions.into()),
        }
    }

    /// Clamps the light `l` that `path` finds after `further` more segments.
    pub(super) fn clamped(&self, path: &PathState, further: u32, l: Rgb) -> Rgb {
        let segments = path.depth - u32::from(path.last.bounces.straight) + further;
        let limit = match segments {
            0 | 1 => None,
            2 => self.clamp_direct,
            _ => self.clamp_indirect,
        };
        let Some(limit) = limit else { return l };
        let brought = (path.throughput * l).max_component();
        if brought > limit { l * (limit / brought) } else { l }
    }
}
