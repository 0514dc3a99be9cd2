//! A path tracer: all light, by following paths from the camera (the default).
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `max_depth` | longest path, in ray segments from the camera, at least 1 | | 8 |
//! | `max_diffuse`, `max_specular`, `max_transmission` | how many scattering events of the kind may lead on to other surfaces. The light that comes straight from lights and the background is scattered at each surface all the same: 0 leaves direct light | | only `max_depth` |
//! | `roulette_depth` | segments after which Russian roulette may end paths: those that carry less than a quarter of the light in proportion to it, and one in 50 others. This adds no bias | | 4 |
//! | `clamp_direct` | number above 0: limit of the light that comes from a light or the background by way of one surface alone | W m^-2 sr^-1 | no limit |
//! | `clamp_indirect` | number above 0: limit of a path's light after two surfaces or more. It trades fireflies for lost light | W m^-2 sr^-1 | no limit |
//! | `strategy` | `"mis"`, `"light"` or `"bsdf"`: how direct light is sampled. All converge to the same picture, with different noise | | `"mis"` |
//!
//! ```toml
//! [render]
//! integrator.path = { max_depth = 12 }
//! ```
//!
//! Shadow rays pass what bends no light, such as smooth thin panes (`glass`, `principled`); each pane counts as a segment and a
//! transmission, whoever finds the light. Smooth meshes are shaded by their normals, and shadows lie where the triangles have them:
//! only a ray that leaves below the plane of its own triangle starts above it, at most on the curved surface that the
//! triangles approximate. Normals whose mirror image would lie below the triangles are turned. What a normal map would send
//! below the surface is mirrored at it.
//!
//! EXR headers record the limits that are set (`batch-render/maxDepth`, `/maxDiffuse`, `/maxSpecular`, `/maxTransmission`,
//! `/clampDirect`, `/clampIndirect`). Both sides of a surface reflect, unless
//! its `back_faces` are not shaded. Radiance is not scaled by the square of the index of refraction
//! inside of media, as in the `whitted` integrator.
//!
//! Sources: Kajiya, "The Rendering Equation", SIGGRAPH 1986, doi:10.1145/15922.15902; for multiple importance sampling
//! Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, chapter 9; for Russian roulette Arvo and Kirk,
//! "Particle Transport and Image Synthesis", SIGGRAPH 1990, doi:10.1145/97880.97886; for shading normals Hanika, "Hacking the
//! Shadow Terminator", Ray Tracing Gems II, 2021, and Keller et al., "The Iray Light Transport Simulation and Rendering System",
//! 2017.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::{
    BounceState, Bounces, FirstLobe, Integrator, Limit, Lobes, ShadingOutput, Stage, Tag, Vertex, VertexBatch,
    VertexContext,
    diffuse::{DiffuseBlock, DiffuseSurface},
    direct::Strategy,
    max_depth,
    path_limits::PathLimits,
    reflected::{ReflectedLight, ReflectedPath},
    reflecting::{BlockSurface, ReflectingBlocks},
    scatter::Scatter,
};
use crate::{
    bsdf::{Bsdf, BsdfKind},
    geometry::Hit,
    light::environment::EnvironmentLight,
    material::{Emission, EmissionReach},
    sampler::{Dimension, Draw, SampleUse},
    scene::{LightFamily, LightOrigin, LightSampleContext, RayKind, Scene, SurfaceInteraction},
    value::{Count, Positive, Problem, Spanned},
};

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathDesc {
    pub max_depth: Option<Spanned<Count>>,
    pub max_diffuse: Option<Count>,
    pub max_specular: Option<Count>,
    pub max_transmission: Option<Count>,
    pub roulette_depth: Option<Count>,
    pub clamp_direct: Option<Positive>,
    pub clamp_indirect: Option<Positive>,
    #[serde(default)]
    pub strategy: Strategy,
}

impl PathDesc {
    pub fn compile(&self) -> Result<PathTracer, Problem> {
        let limit = |said: Option<Count>| said.map_or(u16::MAX, |n| n.0.min(u32::from(u16::MAX)) as u16);
        let limits = PathLimits {
            max_depth: max_depth(&self.max_depth, 8)?,
            bounces: Bounces {
                diffuse: limit(self.max_diffuse),
                specular: limit(self.max_specular),
                transmission: limit(self.max_transmission),
                straight: u8::MAX,
                exceed: false,
                ray: RayKind::default(),
            },
            roulette_depth: self.roulette_depth.map_or(4, |d| d.0),
            clamp_direct: self.clamp_direct.map(|c| c.0),
            clamp_indirect: self.clamp_indirect.map(|c| c.0),
        };
        Ok(PathTracer {
            limits,
            strategy: self.strategy,
        })
    }
}

#[derive(Clone, Copy, Debug, Serialize)]
pub struct PathTracer {
    pub limits: PathLimits,
    pub strategy: Strategy,
}

/// The precomputed shading of a vertex, if a block holds it.
#[derive(Clone, Copy, Default)]
struct KnownSurface<'a> {
    diffuse: Option<DiffuseSurface<'a>>,
    reflecting: Option<BlockSurface<'a>>,
    /// See [`ReflectingBlocks::left`].
    bsdf: Option<&'a Bsdf>,
}

impl Integrator for PathTracer {
    fn batched_draws(&self, scene: &Scene, depth: u32) -> Vec<Draw> {
        if depth >= self.limits.max_depth {
            return Vec::new();
        }
        let has_lamps = scene.lights.families().any(|f| f != LightFamily::Background);
        let (has_background, has_roulette) = (scene.lights.background().is_some(), depth >= self.limits.roulette_depth);
        let draw = |sample_use, third| Draw { sample_use, third };
        let draws = [
            has_lamps.then(|| draw(SampleUse::Light, scene.lights.has_choice())),
            has_background.then(|| draw(SampleUse::Background, false)),
            Some(draw(SampleUse::Bsdf, scene.has_lobes())),
            has_roulette.then(|| draw(SampleUse::Roulette, false)),
        ];
        draws.into_iter().flatten().collect()
    }

    fn shade_batch(&self, batch: &VertexBatch<'_>, out: &mut ShadingOutput) {
        let tracer = self.within(batch.scene);
        let mut diffuse = DiffuseBlock::EMPTY;
        let mut reflecting = ReflectingBlocks::of(batch.scene);
        for k in 0..batch.len() {
            if k % DiffuseBlock::LEN == 0 && !batch.surfaces.is_empty() {
                out.clock.lap(Stage::Bsdf);
                diffuse.fill(batch, k, tracer.strategy);
                out.clock.lap(Stage::Light);
                reflecting.fill(batch, k, tracer.strategy, self.limits.max_depth);
            }
            let context = batch.begin(k, out);
            let known = KnownSurface {
                diffuse: diffuse.surface(k),
                reflecting: reflecting.surface(k),
                bsdf: reflecting.left(k),
            };
            tracer.shade(&context, known, out);
        }
    }

    fn follows_one_direction(&self) -> bool {
        true
    }

    #[inline(always)]
    fn vertex(&self, context: &VertexContext<'_>, out: &mut ShadingOutput) {
        self.within(context.scene).shade(context, KnownSurface::default(), out);
    }

    fn limits(&self) -> Vec<Limit> {
        self.limits.named()
    }
}

impl PathTracer {
    /// The tracer of this scene's light.
    #[inline(always)]
    fn within(self, scene: &Scene) -> Self {
        let strategy = if scene.samples_lights_only() {
            Strategy::Light
        } else {
            self.strategy
        };
        Self { strategy, ..self }
    }

    /// Shades one vertex, whose shading is precomputed if it is `known`.
    #[inline(always)]
    fn shade(&self, context: &VertexContext<'_>, known: KnownSurface<'_>, out: &mut ShadingOutput) {
        let (surface, hit) = match context.vertex {
            Vertex::Surface(surface, hit) => (surface, hit),
            Vertex::Miss(light) => return self.escape(context, light, out),
        };
        let (scene, path) = (context.scene, context.path);
        if !scene.lights.lamps().is_empty() {
            self.lamps(context, surface.t, out);
        }
        if !path.last.media.is_empty() {
            out.attenuate(scene.transmittance(path.last.media, surface.t - context.ray.tmin));
        }
        let material = scene.material(surface.material);
        if let Some(emission) = material.emission() {
            self.emission(context, surface, hit, &emission, out);
        }
        if path.depth >= self.limits.max_depth {
            return;
        }
        if path.last.bounces.exceed {
            // It only looks for lights, and passes what shadow rays pass.
            let is_opaque = known.reflecting.is_some() || known.diffuse.is_some();
            if is_opaque || !scene.shading.media.lets_shadow_rays_through() {
                return;
            }
        }
        if let Some(known) = known.reflecting {
            return self.reflect(context, surface, (known.lights(surface), known.path(surface)), out);
        }
        if let Some(diffuse) = known.diffuse
            && let Some(albedo) = scene.bsdf(surface.material, &surface.texture).lambert_albedo()
        {
            let path = diffuse.path(albedo, surface.viewed_normal());
            return self.reflect(context, surface, (diffuse.lights(albedo), path), out);
        }
        // The number that selects the lobe also selects the channel.
        let choice = || {
            context
                .numbers
                .get_third(Dimension::at(path.depth, SampleUse::Bsdf))
                .f32()
        };
        let bsdf = match known.bsdf {
            Some(bsdf) if !bsdf.disperses() => Cow::Borrowed(bsdf),
            _ => scene.bsdf_for_path(surface, path.last.media, path.throughput, choice),
        };
        bsdf.dispatch(Scatter {
            limits: &self.limits,
            strategy: self.strategy,
            context,
            surface,
            material,
            out,
        });
    }

    /// Adds the shadow rays of an opaque surface, and continues the path.
    #[inline(always)]
    fn reflect(
        &self,
        context: &VertexContext<'_>,
        surface: &SurfaceInteraction,
        (lights, going_on): (impl Iterator<Item = ReflectedLight>, Option<ReflectedPath>),
        out: &mut ShadingOutput,
    ) {
        let (scene, path) = (context.scene, context.path);
        // Not a loop over `next`, which would store each light in memory.
        lights.for_each(|light| {
            if !context.is_lit(surface.object, light.chosen.light) {
                return;
            }
            out.add_shadow_ray(
                light.shadow_ray,
                self.limits.clamped(path, 1, light.l),
                || self.limits.passage(path, path.last.media, false),
                || Tag {
                    group: scene.group_of(light.chosen.light),
                    lobes: Lobes::reflected(light.f_cos, light.diffuse),
                },
            );
        });
        let Some(going_on) = going_on else { return };
        let Some((bounces, weight)) = self.limits.go_on(context, going_on.lobe, going_on.weight) else {
            return;
        };
        out.set_first_lobes(|| Lobes::reflected(going_on.weight, going_on.diffuse));
        let last = BounceState {
            pdf: Some(going_on.pdf).into(),
            n: going_on.n,
            media: path.last.media,
            bounces,
            first: FirstLobe::OfSample,
            lit_by: scene.lit_by(surface.object),
        };
        out.spawn_path(going_on.ray, weight, last);
    }

    /// Adds the radiance of the background, and of the lights before it.
    fn escape(&self, context: &VertexContext<'_>, background: &EnvironmentLight, out: &mut ShadingOutput) {
        let (scene, path, w) = (context.scene, context.path, context.ray.d);
        if !scene.lights.lamps().is_empty() {
            self.lamps(context, context.ray.tmax, out);
        }
        if context.ray.tmax.is_finite() {
            return;
        }
        if !path.last.media.is_empty() {
            out.attenuate(scene.transmittance(path.last.media, f32::INFINITY));
        }
        let l = background.radiance;
        if !l.is_black() && context.arrives(LightOrigin::Background) {
            let weight = self.strategy.weight_of_bsdf(path.last.pdf, || background.pdf);
            out.add_radiance(self.limits.clamped(path, 0, l * weight), || {
                scene.shading.light_groups.of_background()
            });
        }
        if path.depth > 1 || scene.lights.has_visible_suns() {
            for (sun, l, pdf) in scene.suns(&receiver(context), w) {
                let is_unseen = path.depth == 1 && !scene.lights.all()[sun.0 as usize].is_seen_by_camera();
                if is_unseen || !context.arrives(LightOrigin::Light(sun)) {
                    continue;
                }
                let weight = self.strategy.weight_of_bsdf(path.last.pdf, || pdf);
                out.add_radiance(self.limits.clamped(path, 0, l * weight), || scene.group_of(sun));
            }
        }
    }

    /// Adds the radiance of the lights with a surface that the ray meets before `end`.
    #[cold]
    #[inline(never)]
    fn lamps(&self, context: &VertexContext<'_>, end: f32, out: &mut ShadingOutput) {
        let (scene, path, ray) = (context.scene, context.path, context.ray);
        for hit in scene.lamps_along(ray, end, path.depth == 1) {
            if !context.arrives(LightOrigin::Light(hit.light)) {
                continue;
            }
            let density = || hit.pdf * scene.lights.pmf(&receiver(context), hit.light);
            let weight = self.strategy.weight_of_bsdf(path.last.pdf, density);
            let mut l = hit.radiance * weight;
            if !path.last.media.is_empty() {
                l *= scene.transmittance(path.last.media, hit.t - ray.tmin);
            }
            out.add_radiance(self.limits.clamped(path, 0, l), || scene.group_of(hit.light));
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
        let is_alone = emission.reach == EmissionReach::Nothing && path.last.pdf.get().is_some();
        if is_alone || !context.arrives(LightOrigin::Object(surface.object)) {
            return;
        }
        let front_cos = surface.ng.dot(surface.wo);
        let l = if path.last.pdf.get().is_none() {
            emission.radiance(&scene.textures(), &surface.texture, front_cos)
        } else {
            // Light sampling may find the same light, and reads textures at points.
            emission.radiance(&scene.textures(), &surface.texture.without_footprint(), front_cos)
        };
        if l.is_black() {
            return;
        }
        let weight = self
            .strategy
            .weight_of_bsdf(path.last.pdf, || scene.pdf_hit(&receiver(context), context.ray.d, hit));
        out.add_radiance(self.limits.clamped(path, 0, l * weight), || {
            scene.shading.light_groups.of_object(surface.object)
        });
    }
}

/// The point for which the path's last vertex sampled lights.
fn receiver(context: &VertexContext<'_>) -> LightSampleContext {
    LightSampleContext {
        p: context.ray.o,
        n: context.path.last.n,
    }
}
