//! Direct light: light sampling, BSDF sampling, and their combination.
//!
//! Both estimate the same light, and each has little noise where the other has much. The power heuristic weights them so that
//! the sum stays unbiased. Source: Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, section 9.2.

use serde::{Deserialize, Serialize};

use super::{DirectionPdf, Lobes, ShadingOutput, ShadowPassage, Stage, Tag, VertexContext};
use crate::{
    bsdf::BsdfKind,
    light::LightSample,
    math::{Frame, Rgb, Vec3},
    sampler::{Dimension, SampleUse},
    scene::{LightFamily, LightSampleContext, SampledLight, SurfaceInteraction},
};

/// The technique of sampling direct light. All converge to the same picture; they differ in noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Strategy {
    /// Multiple importance sampling: both techniques, weighted.
    #[default]
    Mis,
    /// Light sampling alone, except for delta lobes.
    Light,
    /// BSDF sampling alone, except for delta lights.
    Bsdf,
}

impl Strategy {
    /// The weight of light that light sampling found with density `light`, and BSDF sampling finds with density `bsdf`.
    #[inline(always)]
    pub fn weight_of_light(self, light: f32, bsdf: f32) -> f32 {
        // Without branches, so that it compiles to vectors.
        let both = power_heuristic(light, bsdf);
        let alone = if self == Self::Light { 1.0 } else { 0.0 };
        if self == Self::Mis { both } else { alone }
    }

    /// The weight of light that BSDF sampling found with density `bsdf`, and light sampling finds with density `light` (0 if
    /// it cannot).
    #[inline]
    pub fn weight_of_bsdf(self, bsdf: DirectionPdf, light: impl FnOnce() -> f32) -> f32 {
        let Some(bsdf) = bsdf.get() else { return 1.0 };
        match self {
            Self::Mis => power_heuristic(bsdf, light()),
            Self::Light if light() > 0.0 => 0.0,
            Self::Light | Self::Bsdf => 1.0,
        }
    }
}

/// The power heuristic's weight of the technique with density `a`.
#[inline(always)]
fn power_heuristic(a: f32, b: f32) -> f32 {
    // Computed from the ratio, because squared densities may overflow.
    let r = b / a;
    let weight = 1.0 / (1.0 + r * r);
    if a.is_infinite() { 1.0 } else { weight }
}

/// A surface with its shading frame and BSDF.
pub struct ShadingPoint<'a, B: BsdfKind> {
    pub surface: &'a SurfaceInteraction,
    pub frame: Frame,
    pub bsdf: &'a B,
    /// The BSDF's precomputed data for `wo_local`.
    pub prepared: B::Prepared,
    pub wo_local: Vec3,
    /// Light arrives only from above the plane with this normal; zero if it arrives from everywhere.
    pub horizon: Vec3,
}

impl<B: BsdfKind> ShadingPoint<'_, B> {
    /// Whether light from `wi` passes through the surface.
    ///
    /// The shading frame decides. At the silhouette of a smooth mesh it disagrees with the triangles, which only approximate the
    /// surface.
    #[inline(always)]
    pub fn is_transmitted(&self, wi_local: Vec3) -> bool {
        self.bsdf.transmits() && wi_local.z * self.wo_local.z < 0.0
    }

    /// Whether `wi` passes through the surface by the shading frame, but not by its triangles.
    #[inline(always)]
    pub fn misses_far_side(&self, wi: Vec3, transmitted: bool) -> bool {
        transmitted && self.surface.ng.dot(wi) * self.surface.ng.dot(self.surface.wo) > 0.0
    }

    /// The point for which light is sampled.
    #[inline(always)]
    pub fn receiver(&self) -> LightSampleContext {
        LightSampleContext {
            p: self.surface.p,
            n: self.horizon,
        }
    }
}

/// The parameters of direct light.
pub struct DirectLight<C, P> {
    pub strategy: Strategy,
    /// Clamps the light of one path.
    pub clamp: C,
    /// The passage of a shadow ray that leaves the surface through it, or on the side of the viewer.
    pub passage: P,
}

/// The number in `[0, 1)` that selects the lights of the vertex.
#[inline(always)]
fn light_choice(context: &VertexContext<'_>) -> f64 {
    if !context.scene.lights.has_choice() {
        return 0.0;
    }
    context
        .numbers
        .get_third(Dimension::at(context.path.depth, SampleUse::Light))
        .f64()
}

/// Adds a shadow ray for a sampled light of each family.
#[inline(always)]
pub fn sample_direct(
    context: &VertexContext<'_>,
    shading: &ShadingPoint<'_, impl BsdfKind>,
    how: &DirectLight<impl Fn(Rgb) -> Rgb, impl Fn(bool) -> ShadowPassage>,
    out: &mut ShadingOutput,
) {
    for family in context.scene.lights.families() {
        sample_family(context, shading, family, how, out);
    }
}

/// Adds a shadow ray for a light of one family.
#[inline(always)]
fn sample_family(
    context: &VertexContext<'_>,
    shading: &ShadingPoint<'_, impl BsdfKind>,
    family: LightFamily,
    how: &DirectLight<impl Fn(Rgb) -> Rgb, impl Fn(bool) -> ShadowPassage>,
    out: &mut ShadingOutput,
) {
    let receiver = shading.receiver();
    out.clock.lap(Stage::Bsdf);
    let sample = sample_light(context, shading.surface, family, &receiver);
    out.clock.lap(Stage::Light);
    let Some((choice, sample)) = sample else { return };
    let wi_local = shading.frame.to_local(sample.wi);
    let eval = shading
        .bsdf
        .eval_prepared(&shading.prepared, shading.wo_local, wi_local);
    let l = match sample.pdf {
        None => eval.f_cos() * sample.li / choice.pmf,
        Some(pdf) => {
            let pdf = pdf * choice.pmf;
            eval.f_cos() * sample.li * (how.strategy.weight_of_light(pdf, eval.pdf) / pdf)
        }
    };
    let transmitted = shading.is_transmitted(wi_local);
    let is_lit = !l.is_black() && context.is_lit(shading.surface.object, choice.light);
    if is_lit && !shading.misses_far_side(sample.wi, transmitted) {
        let ray = shading.surface.shadow_ray(transmitted, sample.wi, sample.distance);
        out.add_shadow_ray(
            ray,
            (how.clamp)(l),
            || (how.passage)(transmitted),
            || Tag {
                group: context.scene.group_of(choice.light),
                lobes: if transmitted {
                    Lobes::Transmitted
                } else {
                    Lobes::reflected(eval.f_cos(), eval.diffuse)
                },
            },
        );
    }
}

/// Selects a light of a family and samples its light at `receiver`; `None` if none arrives.
#[inline(always)]
fn sample_light(
    context: &VertexContext<'_>,
    surface: &SurfaceInteraction,
    family: LightFamily,
    receiver: &LightSampleContext,
) -> Option<(SampledLight, LightSample)> {
    if (!context.scene.lights.depends_on_normal(family) || surface.viewed_normal() == receiver.n)
        && let Some(sample) = context.lights.get(family, context.numbers.index)
    {
        return sample;
    }
    draw_light(context, family, receiver)
}

/// The same where no batch has the sample. It is not inlined: every BSDF would have a copy.
#[inline(never)]
fn draw_light(
    context: &VertexContext<'_>,
    family: LightFamily,
    receiver: &LightSampleContext,
) -> Option<(SampledLight, LightSample)> {
    let (scene, depth) = (context.scene, context.path.depth);
    let uc = light_choice(context);
    let choice = scene.lights.choose(scene.geometry.accel.simd(), family, receiver, uc)?;
    let sample_use = match family {
        LightFamily::Finite | LightFamily::Suns => SampleUse::Light,
        LightFamily::Background => SampleUse::Background,
    };
    let u = context.numbers.get_2d(Dimension::at(depth, sample_use));
    Some((choice, scene.sample_light(choice.light, receiver.p, u)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_of_both_ways_sum_to_one() {
        for (a, b) in [(1.0, 3.0), (1e-20, 1e20), (1e30, 1e30), (0.5, 0.0)] {
            let sum = Strategy::Mis.weight_of_light(a, b) + Strategy::Mis.weight_of_bsdf(Some(b).into(), || a);
            assert!((sum - 1.0).abs() < 1e-6, "{a} {b} {sum}");
        }
    }
}
