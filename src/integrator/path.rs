//! A path tracer: all light, by following paths from the camera (the default).
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `max_depth` | longest path, in ray segments from the camera, at least 1 | | 8 |
//! | `max_diffuse`, `max_specular`, `max_transmission` | how many scattering events of the kind a path may have | | only `max_depth` |
//! | `roulette_depth` | segments after which Russian roulette may end dim paths; this adds no bias | | 5 |
//! | `clamp_indirect` | number above 0: limit of a path's light after two surfaces or more. It trades fireflies for lost light | W m^-2 sr^-1 | no limit |
//! | `strategy` | `"mis"`, `"light"` or `"bsdf"`: how direct light is sampled. All converge to the same picture, with different noise | | `"mis"` |
//!
//! ```toml
//! [render]
//! integrator.path = { max_depth = 12 }
//! ```
//!
//! EXR headers record the limits that are set (`batch-render/maxDepth`, `/maxDiffuse`, `/maxSpecular`, `/maxTransmission`,
//! `/clampIndirect`). Both sides of a surface reflect. Radiance is not scaled by the square of the index of refraction
//! inside of media, as in the `whitted` integrator.
//!
//! Sources: Kajiya, "The Rendering Equation", SIGGRAPH 1986, doi:10.1145/15922.15902; for multiple importance sampling
//! Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, chapter 9; for Russian roulette Arvo and Kirk,
//! "Particle Transport and Image Synthesis", SIGGRAPH 1990, doi:10.1145/97880.97886.

use std::cell::LazyCell;

use serde::Deserialize;

use super::{
    BounceState, Bounces, FirstLobe, Integrator, Limit, LimitValue, Lobes, PathState, ShadingOutput, Vertex,
    VertexContext,
    direct::{ShadingPoint, Strategy, sample_direct},
    max_depth,
};
use crate::{
    bsdf::{BsdfKind, BsdfSample, BsdfVisitor, Lobe},
    geometry::Hit,
    material::{Emission, Material, MaterialId},
    math::{Frame, Rgb, Vec3, trig},
    sampler::{Dimension, SampleUse},
    scene::{LightSampleContext, Scene, SurfaceInteraction},
    value::{Count, Positive, Problem, Spanned},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathDesc {
    pub max_depth: Option<Spanned<Count>>,
    pub max_diffuse: Option<Count>,
    pub max_specular: Option<Count>,
    pub max_transmission: Option<Count>,
    pub roulette_depth: Option<Count>,
    pub clamp_indirect: Option<Positive>,
    #[serde(default)]
    pub strategy: Strategy,
}

impl PathDesc {
    pub fn compile(&self) -> Result<PathTracer, Problem> {
        let limit = |said: Option<Count>| said.map_or(u16::MAX, |n| n.0.min(u32::from(u16::MAX)) as u16);
        Ok(PathTracer {
            max_depth: max_depth(&self.max_depth, 8)?,
            limits: Bounces {
                diffuse: limit(self.max_diffuse),
                specular: limit(self.max_specular),
                transmission: limit(self.max_transmission),
            },
            roulette_depth: self.roulette_depth.map_or(5, |d| d.0),
            clamp_indirect: self.clamp_indirect.map(|c| c.0),
            strategy: self.strategy,
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct PathTracer {
    pub max_depth: u32,
    /// The largest number of departures by a lobe of each kind.
    pub limits: Bounces,
    pub roulette_depth: u32,
    /// In W m^-2 sr^-1.
    pub clamp_indirect: Option<f32>,
    pub strategy: Strategy,
}

/// The chance of survival in the roulette is never more, so that paths between mirrors end.
const MAX_SURVIVAL: f32 = 0.95;

impl Integrator for PathTracer {
    fn batched_dimensions(&self, scene: &Scene, depth: u32) -> Vec<SampleUse> {
        let goes_on = depth < self.max_depth;
        let drawn = [
            (SampleUse::Selection, goes_on && scene.lights.has_choice()),
            (SampleUse::Light, goes_on && !scene.lights.is_empty()),
            (SampleUse::Bsdf, goes_on),
            (SampleUse::Roulette, goes_on && depth >= self.roulette_depth),
        ];
        drawn.into_iter().filter(|(_, drawn)| *drawn).map(|(p, _)| p).collect()
    }

    #[inline(always)]
    fn vertex(&self, context: &VertexContext<'_>, out: &mut ShadingOutput) {
        let (surface, hit) = match context.vertex {
            Vertex::Surface(surface, hit) => (surface, hit),
            Vertex::Miss => return self.escape(context, out),
        };
        let (scene, path) = (context.scene, context.path);
        if let Some(medium) = path.last.medium {
            let absorption = scene.material(medium).absorption();
            out.attenuate(absorption.map(|a| trig::exp(-a * surface.t)));
        }
        let material = scene.material(surface.material);
        if let Some(emission) = material.emission() {
            self.emission(context, surface, hit, &emission, out);
        }
        if path.depth >= self.max_depth {
            return;
        }
        let bsdf = material.bsdf(&scene.textures(), &surface.texture);
        bsdf.dispatch(Scatter {
            tracer: self,
            context,
            surface,
            material,
            out,
        });
    }

    fn limits(&self) -> Vec<Limit> {
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
        let clamp = self.clamp_indirect.map(|l| Limit {
            name: "clampIndirect",
            value: LimitValue::Radiance(l),
        });
        let all = [
            Some(depth),
            bounces("maxDiffuse", self.limits.diffuse),
            bounces("maxSpecular", self.limits.specular),
            bounces("maxTransmission", self.limits.transmission),
            clamp,
        ];
        all.into_iter().flatten().collect()
    }
}

/// The scattering of a path at a surface, once the type of its BSDF is known.
struct Scatter<'a, 'b> {
    tracer: &'a PathTracer,
    context: &'a VertexContext<'b>,
    surface: &'a SurfaceInteraction,
    material: &'a Material,
    out: &'a mut ShadingOutput,
}

impl BsdfVisitor for Scatter<'_, '_> {
    /// Asks for light, and carries the path on.
    fn visit(self, bsdf: &impl BsdfKind) {
        let Self {
            tracer,
            context,
            surface,
            material,
            out,
        } = self;
        let (scene, path) = (context.scene, context.path);
        let frame = shading_frame(context, surface, material, bsdf);
        let shading = ShadingPoint {
            surface,
            frame,
            bsdf,
            wo_local: frame.to_local(surface.wo),
        };
        // Drawn once, and only where there is something to choose.
        let choice = LazyCell::new(|| context.numbers.get_2d(Dimension::at(path.depth, SampleUse::Selection)));
        // What has but one direction is found this way alone.
        if !bsdf.is_delta() && !scene.lights.is_empty() {
            let clamp = |l| tracer.clamped(path, path.depth + 1, l);
            sample_direct(context, &shading, || choice.x, tracer.strategy, clamp, out);
        }
        let uc = if bsdf.has_lobes() { choice.y } else { 0.0 };
        tracer.go_on(context, &shading, uc, out);
    }
}

impl PathTracer {
    /// Adds the radiance of the background.
    fn escape(&self, context: &VertexContext<'_>, out: &mut ShadingOutput) {
        let (scene, path, w) = (context.scene, context.path, context.ray.d);
        if let Some(medium) = path.last.medium {
            let absorption = scene.material(medium).absorption();
            out.attenuate(absorption.map(|a| if a > 0.0 { 0.0 } else { 1.0 }));
        }
        let l = scene.background_radiance(w);
        if !l.is_black() {
            let weight = self
                .strategy
                .weight_of_bsdf(path.last.pdf, || scene.pdf_background(&receiver(context), w));
            out.add_radiance(self.clamped(path, path.depth, l * weight), || {
                scene.light_groups.of_background()
            });
        }
        if path.depth > 1 {
            // The camera does not see suns.
            for (sun, l, pdf) in scene.suns(&receiver(context), w) {
                let weight = self.strategy.weight_of_bsdf(path.last.pdf, || pdf);
                out.add_radiance(self.clamped(path, path.depth, l * weight), || scene.group_of(sun));
            }
        }
    }

    /// Adds the emission of the surface.
    fn emission(
        &self,
        context: &VertexContext<'_>,
        surface: &SurfaceInteraction,
        hit: &Hit,
        emission: &Emission,
        out: &mut ShadingOutput,
    ) {
        let (scene, path) = (context.scene, context.path);
        let l = emission.radiance(&scene.textures(), &surface.texture, surface.ng.dot(surface.wo));
        if l.is_black() {
            return;
        }
        let weight = self
            .strategy
            .weight_of_bsdf(path.last.pdf, || scene.pdf_hit(&receiver(context), context.ray.d, hit));
        out.add_radiance(self.clamped(path, path.depth, l * weight), || {
            scene.light_groups.of_object(surface.object)
        });
    }

    /// Carries the path on in a direction that the surface chooses, `uc` the lobe.
    #[inline(always)]
    fn go_on(
        &self,
        context: &VertexContext<'_>,
        shading: &ShadingPoint<'_, impl BsdfKind>,
        uc: f32,
        out: &mut ShadingOutput,
    ) {
        let (path, surface) = (context.path, shading.surface);
        let u = context
            .numbers
            .get_sample_2d(Dimension::at(path.depth, SampleUse::Bsdf));
        let Some(sample) = shading.bsdf.sample(shading.wo_local, uc, u) else {
            return;
        };
        let wi = shading.frame.to_world(sample.wi);
        let Some(bounces) = self.count(path.last.bounces, sample.lobe) else {
            return;
        };
        if !shading.is_consistent_side(wi, sample.wi) {
            return;
        }
        let mut weight = sample.weight;
        if path.depth >= self.roulette_depth {
            let survival = (path.throughput * weight).max_component().min(MAX_SURVIVAL);
            if context.numbers.get_2d(Dimension::at(path.depth, SampleUse::Roulette)).x >= survival {
                return;
            }
            weight = weight / survival;
        }
        let last = BounceState {
            pdf: sample.pdf,
            n: shading.receiver().n,
            medium: medium_after(context, shading, &sample),
            bounces,
            first: FirstLobe::OfSample,
        };
        out.set_first_lobes(|| match sample.lobe {
            Lobe::Transmission => Lobes::Transmitted,
            Lobe::Diffuse | Lobe::Specular => Lobes::reflected(sample.weight, sample.diffuse),
        });
        out.spawn_path(surface.spawn_ray(wi), weight, last);
    }

    /// One more bounce, if it is allowed.
    fn count(&self, mut bounces: Bounces, lobe: Lobe) -> Option<Bounces> {
        let (count, limit) = match lobe {
            Lobe::Diffuse => (&mut bounces.diffuse, self.limits.diffuse),
            Lobe::Specular => (&mut bounces.specular, self.limits.specular),
            Lobe::Transmission => (&mut bounces.transmission, self.limits.transmission),
        };
        if *count >= limit {
            return None;
        }
        *count += 1;
        Some(bounces)
    }

    /// `l`, that `path` brings by way of `segments` segments, scaled down where that is too much.
    fn clamped(&self, path: &PathState, segments: u32, l: Rgb) -> Rgb {
        let Some(limit) = self.clamp_indirect.filter(|_| segments > 2) else {
            return l;
        };
        let brought = (path.throughput * l).max_component();
        if brought > limit { l * (limit / brought) } else { l }
    }
}

/// The point for which light would have been sampled at the path's last vertex.
fn receiver(context: &VertexContext<'_>) -> LightSampleContext {
    LightSampleContext {
        p: context.ray.o,
        n: context.path.last.n,
    }
}

/// The medium that the path is in behind `sample`.
#[inline(always)]
fn medium_after(
    context: &VertexContext<'_>,
    shading: &ShadingPoint<'_, impl BsdfKind>,
    sample: &BsdfSample,
) -> Option<MaterialId> {
    if sample.lobe != Lobe::Transmission {
        return context.path.last.medium;
    }
    let material = shading.surface.material;
    let enters = sample.wi.z < 0.0;
    (enters && !context.scene.material(material).absorption().is_black()).then_some(material)
}

/// The shading frame: about the normal on the side of the viewer, or as authored where light passes through.
#[inline(always)]
fn shading_frame(
    context: &VertexContext<'_>,
    surface: &SurfaceInteraction,
    material: &Material,
    bsdf: &impl BsdfKind,
) -> Frame {
    let front = surface.ng.dot(surface.wo) >= 0.0;
    let frame = if material.normal_map().is_some() || bsdf.reads_tangent() {
        let Frame { s, t, n } = turned_frame(context.scene, surface, material);
        // Number by number: what a call has left in memory as a whole would keep the frame there.
        let [s, t, n] = [s, t, n].map(|v| Vec3::new(v.x, v.y, v.z));
        Frame { s, t, n }
    } else {
        surface.frame
    };
    let sign = if front || bsdf.transmits() { 1.0 } else { -1.0 };
    Frame {
        s: frame.s,
        t: frame.t * sign,
        n: frame.n * sign,
    }
}

/// A frame about the shading normal, or about the one that a map tells where it is seen; its first axis follows the texture's.
#[inline(never)]
fn turned_frame(scene: &Scene, surface: &SurfaceInteraction, material: &Material) -> Frame {
    let authored = surface.frame.n;
    let base = tangent_frame(surface, authored);
    let Some(map) = material.normal_map() else {
        return base;
    };
    let n = map.normal(&scene.textures(), &surface.texture);
    let handed = base.t.dot(surface.dpdv) < 0.0;
    let n = Vec3::new(n.x, if handed { -n.y } else { n.y }, n.z);
    let world = base.to_world(n).normalize_or(authored);
    tangent_frame(
        surface,
        if surface.is_consistent_normal(world) {
            world
        } else {
            authored
        },
    )
}

/// A frame about `n` whose first axis follows the texture's.
fn tangent_frame(surface: &SurfaceInteraction, n: Vec3) -> Frame {
    let s = surface.dpdu - n * n.dot(surface.dpdu);
    match s.try_normalize() {
        Some(s) => Frame { s, t: n.cross(s), n },
        None => Frame::from_normal(n),
    }
}
