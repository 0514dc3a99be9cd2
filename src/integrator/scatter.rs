//! Scattering at a single surface with any BSDF.

use super::{
    BounceState, FirstLobe, Lobes, ShadingOutput, ShadowPassage, VertexContext,
    direct::{DirectLight, ShadingPoint, Strategy, sample_direct},
    path_limits::PathLimits,
};
use crate::{
    bsdf::{BsdfKind, BsdfVisitor, Lobe, folded::Folded, fresnel::reflect},
    material::Material,
    math::{Frame, Ray, Vec3},
    sampler::{Dimension, SampleUse},
    scene::{
        MediumStack, SurfaceInteraction,
        shading_frame::{ShadingFrame, shading_frame},
    },
};

/// The scattering of a path at a surface, generic over the type of its BSDF.
pub(super) struct Scatter<'a, 'b> {
    pub limits: &'a PathLimits,
    pub strategy: Strategy,
    pub context: &'a VertexContext<'b>,
    pub surface: &'a SurfaceInteraction,
    pub material: &'a Material,
    pub out: &'a mut ShadingOutput,
}

impl BsdfVisitor for Scatter<'_, '_> {
    fn visit(self, bsdf: &(impl BsdfKind + Copy)) {
        let Self {
            context,
            surface,
            material,
            ..
        } = self;
        let shading_frame = shading_frame(context.scene, surface, material, bsdf);
        let adapted = shading_frame.adapt(bsdf);
        let bsdf = adapted.as_ref().unwrap_or(bsdf);
        let ShadingFrame { frame, base, coat, .. } = shading_frame;
        let wo_local = frame.to_local(surface.wo);
        let has_map = || context.scene.shading.normal_map(surface.material).is_some();
        if !bsdf.transmits() && (coat.is_some() || has_map()) {
            let folded = Folded {
                bsdf,
                plane: frame.to_local(base),
            };
            self.scatter(&folded, frame, wo_local, base);
        } else {
            let horizon = if bsdf.transmits() { Vec3::ZERO } else { frame.n };
            self.scatter(bsdf, frame, wo_local, horizon);
        }
    }
}

impl Scatter<'_, '_> {
    /// Adds shadow rays, and continues the path; for `horizon` see [`ShadingPoint`].
    #[inline(always)]
    fn scatter(self, bsdf: &impl BsdfKind, frame: Frame, wo_local: Vec3, horizon: Vec3) {
        let Self {
            limits,
            strategy,
            context,
            surface,
            out,
            ..
        } = self;
        let shading = ShadingPoint {
            surface,
            frame,
            prepared: bsdf.prepare(wo_local),
            bsdf,
            wo_local,
            horizon,
        };
        let (scene, path) = (context.scene, context.path);
        // A delta lobe reflects no sampled light.
        if !bsdf.is_delta() && !scene.lights.is_empty() && !path.last.bounces.exceed {
            let how = DirectLight {
                strategy,
                clamp: |l| limits.clamped(path, 1, l),
                passage: |transmitted| shadow_passage(limits, context, &shading, transmitted),
            };
            sample_direct(context, &shading, &how, out);
        }
        let uc = if bsdf.has_lobes() {
            context
                .numbers
                .get_third(Dimension::at(path.depth, SampleUse::Bsdf))
                .f32()
        } else {
            0.0
        };
        go_on(limits, context, &shading, uc, out);
    }
}

/// Continues the path in a direction that the BSDF samples; `uc` selects the lobe.
#[inline(always)]
fn go_on(
    limits: &PathLimits,
    context: &VertexContext<'_>,
    shading: &ShadingPoint<'_, impl BsdfKind>,
    uc: f32,
    out: &mut ShadingOutput,
) {
    let (path, surface) = (context.path, shading.surface);
    let u = context
        .numbers
        .get_sample_2d(Dimension::at(path.depth, SampleUse::Bsdf));
    let Some(sample) = shading.bsdf.sample_prepared(&shading.prepared, shading.wo_local, uc, u) else {
        return;
    };
    let may_pass = path.last.bounces.transmission < limits.bounces.transmission;
    let Some((mut bounces, weight)) = limits.go_on(context, sample.lobe, sample.weight) else {
        return;
    };
    let transmitted = sample.lobe == Lobe::Transmission;
    out.set_first_lobes(|| {
        if transmitted {
            Lobes::Transmitted
        } else {
            Lobes::reflected(sample.weight, sample.diffuse)
        }
    });
    let media = if transmitted {
        media_behind(context, shading)
    } else {
        path.last.media
    };
    let is_passed_straight = sample.is_straight()
        && context.scene.shading.media.lets_shadow_rays_through()
        && !shading.bsdf.straight(shading.wo_local).is_black();
    if is_passed_straight {
        if !may_pass {
            return;
        }
        // Shadow rays of the last vertex cross the surface in the same way: only the origin of the ray changes.
        bounces.straight = bounces.straight.saturating_add(u8::from(path.depth > 1));
        let ray = Ray {
            tmin: surface.t,
            ..*context.ray
        };
        let last = BounceState {
            media,
            bounces,
            ..path.last
        };
        return out.pass_straight(ray, weight, last);
    }
    if path.last.bounces.exceed {
        return;
    }
    let (mut wi, mut pdf) = (shading.frame.to_world(sample.wi), sample.pdf);
    if shading.misses_far_side(wi, transmitted) {
        // The ray would hit the same point again and again. No light is sampled in the direction that replaces it.
        (wi, pdf) = (reflect(-wi, surface.ng), None);
    }
    let last = BounceState {
        pdf: pdf.into(),
        n: shading.horizon,
        media,
        bounces,
        first: FirstLobe::OfSample,
        lit_by: context.scene.lit_by(surface.object),
    };
    out.spawn_path(surface.spawn_ray(transmitted, wi), weight, last);
}

/// The passage of a shadow ray that is transmitted by the surface, or leaves on the viewer's side.
#[cold]
fn shadow_passage(
    limits: &PathLimits,
    context: &VertexContext<'_>,
    shading: &ShadingPoint<'_, impl BsdfKind>,
    transmitted: bool,
) -> ShadowPassage {
    let media = if transmitted {
        media_behind(context, shading)
    } else {
        context.path.last.media
    };
    limits.passage(context.path, media, transmitted)
}

/// The media on the other side of the surface from the path.
fn media_behind(context: &VertexContext<'_>, shading: &ShadingPoint<'_, impl BsdfKind>) -> MediumStack {
    let inwards = shading.wo_local.z > 0.0;
    context
        .scene
        .media_behind(context.path.last.media, shading.surface.material, inwards)
}
