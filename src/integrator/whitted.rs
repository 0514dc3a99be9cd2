//! Whitted's recursive ray tracer: local illumination, shadows, perfect mirrors and clear glass.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `max_depth` | longest path, in ray segments from the camera, at least 1 | | 5 |
//! | `ambient` | number or `[r, g, b]`: constant light from all directions | W m^-2 sr^-1 | 0 |
//!
//! ```toml
//! [render]
//! integrator.whitted = { max_depth = 5, ambient = 0.4 }
//! ```
//!
//! Lights without size (points, spots, suns without an `angle`) cast hard shadows, and each of them is sampled at every
//! surface. Of the others, each sun and each light with a surface is sampled once, and so is one emitting object, chosen by how
//! much light it may contribute: soft shadows, with noise that `samples` average out. An environment is visible and appears in
//! mirrors, but it does not light surfaces; `ambient` does that.
//!
//! Source: Whitted, "An improved illumination model for shaded display", CACM 23(6), 1980, doi:10.1145/358876.358882.

use serde::{Deserialize, Serialize};

use super::{
    BounceState, Bounces, FirstLobe, Integrator, Limit, LimitValue, Lobes, ShadingOutput, ShadowPassage, Tag, Vertex,
    VertexContext, max_depth,
};
use crate::{
    bsdf::fresnel::{dielectric, reflect, refract},
    light::LightSample,
    material::{FresnelMode, WhittedTerms},
    math::{Rgb, Vec2, Vec3, WorkingSpace, exponential},
    sampler::{Dimension, SampleUse},
    scene::{
        LightGroup, LightId, LightOrigin, LightSampleContext, RayKind, SurfaceInteraction,
        interaction::reflecting_normal, shading_frame::mapped_normal,
    },
    value::{Count, Problem, RgbFactor, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WhittedDesc {
    pub max_depth: Option<Spanned<Count>>,
    pub ambient: Option<RgbFactor>,
}

impl WhittedDesc {
    pub fn compile(&self) -> Result<Whitted, Problem> {
        Ok(Whitted {
            max_depth: max_depth(&self.max_depth, 5)?,
            ambient: self.ambient.map_or(Rgb::BLACK, |a| a.0),
        })
    }
}

#[derive(Clone, Copy, Debug, Serialize)]
pub struct Whitted {
    pub max_depth: u32,
    pub ambient: Rgb,
}

impl Integrator for Whitted {
    fn convert_colors(&mut self, space: WorkingSpace) {
        self.ambient = space.from_rec709(self.ambient);
    }

    #[inline(always)]
    fn vertex(&self, context: &VertexContext<'_>, out: &mut ShadingOutput) {
        let scene = context.scene;
        if !scene.lights.lamps().is_empty() {
            add_lamps(context, out);
        }
        let surface = match context.vertex {
            Vertex::Surface(surface, _) => surface,
            Vertex::Miss(_) if !context.arrives(LightOrigin::Background) => return,
            Vertex::Miss(light) => {
                return out.add_radiance(light.radiance, || scene.shading.light_groups.of_background());
            }
        };
        let mapped = mapped_normal(scene, surface).map(|ns| SurfaceInteraction { ns, ..*surface });
        let surface = mapped.as_ref().unwrap_or(surface);
        let terms = scene
            .material(surface.material)
            .whitted_terms(&scene.textures(), &surface.texture);
        // The geometric normal decides: at the silhouette of a smooth mesh the shading normal may point away.
        let is_behind = surface.ng.dot(surface.wo) < 0.0;
        let outward = surface.outward_normal();
        let n = if terms.two_sided && is_behind {
            -outward
        } else {
            outward
        };
        // Ambient light approximates the light of other surfaces.
        out.add_indirect(self.ambient * terms.ambient, || Tag {
            group: LightGroup::default(),
            lobes: Lobes::Reflected { diffuse: Rgb::WHITE },
        });
        if let Some(emission) = scene.material(surface.material).emission()
            && context.arrives(LightOrigin::Object(surface.object))
        {
            let l = emission.radiance(&scene.textures(), &surface.texture, surface.ng.dot(surface.wo));
            out.add_radiance(l, || scene.shading.light_groups.of_object(surface.object));
        }
        if context.path.depth >= self.max_depth {
            return;
        }
        let point = ShadedPoint {
            context,
            surface,
            n,
            is_lit_behind: is_behind && !terms.two_sided,
            terms: &terms,
        };
        for (light, id) in scene.lights.all().iter().zip(0..) {
            let u = if light.has_size() {
                let dimension = Dimension::at(context.path.depth, SampleUse::Bsdf);
                context.numbers.get_2d(dimension)
            } else {
                Vec2::splat(0.5)
            };
            if context.is_lit(surface.object, LightId(id))
                && let Some(sample) = light.sample(&scene.light_tables(LightId(id)), surface.p, u)
            {
                point.add_direct(&sample, LightId(id), out);
            }
        }
        point.add_emitter(out);
        if terms.transmit.is_black() {
            point.reflect(n, terms.reflect, out);
        } else {
            point.reflect_and_refract(out);
        }
    }

    fn limits(&self) -> Vec<Limit> {
        vec![Limit {
            name: "maxDepth",
            value: LimitValue::Count(self.max_depth),
        }]
    }
}

/// A surface whose material is known.
struct ShadedPoint<'a, 'b> {
    context: &'a VertexContext<'b>,
    surface: &'a SurfaceInteraction,
    /// The shading normal on the lit side.
    n: Vec3,
    /// Whether that side is not the viewer's.
    is_lit_behind: bool,
    terms: &'a WhittedTerms,
}

/// Adds the radiance of the lights with a surface that the ray meets before its vertex.
#[inline(never)]
fn add_lamps(context: &VertexContext<'_>, out: &mut ShadingOutput) {
    let scene = context.scene;
    let end = match context.vertex {
        Vertex::Surface(surface, _) => surface.t,
        Vertex::Miss(_) => context.ray.tmax,
    };
    for hit in scene.lamps_along(context.ray, end, context.path.depth == 1) {
        if context.arrives(LightOrigin::Light(hit.light)) {
            out.add_radiance(hit.radiance, || scene.group_of(hit.light));
        }
    }
}

impl ShadedPoint<'_, '_> {
    /// Continues the path along `wi`, unless its weight is 0.
    #[inline]
    fn spawn(&self, wi: Vec3, weight: Rgb, lobe: FirstLobe, out: &mut ShadingOutput) {
        if weight.is_black() {
            return;
        }
        let path = self.context.path;
        let last = BounceState {
            first: if path.depth == 1 { lobe } else { path.last.first },
            lit_by: self.context.scene.lit_by(self.surface.object),
            bounces: Bounces {
                ray: if lobe == FirstLobe::Transmitted {
                    RayKind::Transmission
                } else {
                    RayKind::Reflection
                },
                ..Bounces::default()
            },
            ..BounceState::default()
        };
        out.spawn_path(self.surface.spawn_ray(lobe == FirstLobe::Transmitted, wi), weight, last);
    }

    /// Continues the path in the mirror direction of the shading normal `n`.
    fn reflect(&self, n: Vec3, weight: Rgb, out: &mut ShadingOutput) {
        let SurfaceInteraction { ns, ng, wo, .. } = *self.surface;
        let n = if ns == ng {
            n
        } else {
            let side = |n: Vec3| if n.dot(wo) < 0.0 { -n } else { n };
            reflecting_normal(side(n), side(ng), wo)
        };
        self.spawn(reflect(wo, n), weight, FirstLobe::Reflected, out);
    }

    /// Spawns the reflected and the refracted ray of a clear surface, or only one under total internal reflection.
    fn reflect_and_refract(&self, out: &mut ShadingOutput) {
        let (surface, terms) = (self.surface, self.terms);
        let wo = surface.wo;
        let outward = surface.outward_normal();
        let (n, eta) = if outward.dot(wo) < 0.0 {
            (-outward, 1.0 / terms.ior)
        } else {
            (outward, terms.ior)
        };
        let through = refract(wo, n, eta);
        let reflected = match (terms.fresnel_mode, through) {
            (FresnelMode::Fixed, None) => terms.reflect + terms.transmit,
            (FresnelMode::Fixed, Some(_)) => terms.reflect,
            (FresnelMode::Fresnel, _) => terms.reflect * dielectric(n.dot(wo), eta),
        };
        self.reflect(n, reflected, out);
        if let Some(wi) = through {
            let transmitted = match terms.fresnel_mode {
                FresnelMode::Fixed => terms.transmit,
                FresnelMode::Fresnel => terms.transmit * (1.0 - dielectric(n.dot(wo), eta)),
            };
            self.spawn(wi, transmitted, FirstLobe::Transmitted, out);
        }
    }

    /// Adds the light of one sampled emitter, as an estimate of all of them.
    fn add_emitter(&self, out: &mut ShadingOutput) {
        let (context, p) = (self.context, self.surface.p);
        let (scene, depth) = (context.scene, context.path.depth);
        if scene.lights.emitters().count() == 0 {
            return;
        }
        let receiver = LightSampleContext { p, n: self.n };
        let u = context.numbers.get_third(Dimension::at(depth, SampleUse::Light)).f64();
        let Some(choice) = scene.lights.choose_emitter(scene.geometry.accel.simd(), &receiver, u) else {
            return;
        };
        if !context.is_lit(self.surface.object, choice.light) {
            return;
        }
        let u = context.numbers.get_2d(Dimension::at(depth, SampleUse::Light));
        if let Some(mut sample) = scene.sample_light(choice.light, p, u) {
            sample.li = sample.li / choice.pmf;
            self.add_direct(&sample, choice.light, out);
        }
    }

    /// Adds the light of a sample, if nothing blocks it.
    #[inline]
    fn add_direct(&self, sample: &LightSample, light: LightId, out: &mut ShadingOutput) {
        let (surface, terms) = (self.surface, self.terms);
        let cos = self.n.dot(sample.wi);
        if cos <= 0.0 {
            return;
        }
        let diffuse = terms.diffuse * cos;
        let mut weight = diffuse;
        if !terms.specular.is_black() {
            let highlight = reflect(sample.wi, self.n).dot(surface.wo).max(0.0);
            weight += terms.specular * exponential::pow(highlight, terms.shininess);
        }
        let l = match sample.pdf {
            None => sample.li * weight,
            Some(pdf) => sample.li * weight / pdf,
        };
        if !l.is_black() {
            let ray = surface.shadow_ray(self.is_lit_behind, sample.wi, sample.distance);
            out.add_shadow_ray(ray, l, ShadowPassage::default, || Tag {
                group: self.context.scene.group_of(light),
                lobes: Lobes::reflected(weight, diffuse),
            });
        }
    }
}
