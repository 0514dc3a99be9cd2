//! A path tracer: all light, by following paths from the camera (the default).
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `max_depth` | longest path, in ray segments from the camera, at least 1 | | 8 |
//! | `max_diffuse`, `max_specular`, `max_transmission` | how many scattering events of the kind a path may have | | only `max_depth` |
//! | `roulette_depth` | segments after which Russian roulette may end dim paths; this adds no bias | | 5 |
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
//! transmission, whoever finds the light. Smooth meshes are shaded by their normals: rays leave from the curved surface that the
//! triangles approximate, which moves contact shadows by no more than its distance from the triangles, and normals whose mirror
//! image would lie below the triangles are turned. What a normal map would send below the surface is mirrored at it.
//!
//! EXR headers record the limits that are set (`batch-render/maxDepth`, `/maxDiffuse`, `/maxSpecular`, `/maxTransmission`,
//! `/clampDirect`, `/clampIndirect`). Both sides of a surface reflect. Radiance is not scaled by the square of the index of refraction
//! inside of media, as in the `whitted` integrator.
//!
//! Sources: Kajiya, "The Rendering Equation", SIGGRAPH 1986, doi:10.1145/15922.15902; for multiple importance sampling
//! Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, chapter 9; for Russian roulette Arvo and Kirk,
//! "Particle Transport and Image Synthesis", SIGGRAPH 1990, doi:10.1145/97880.97886; for shading normals Hanika, "Hacking the
//! Shadow Terminator", Ray Tracing Gems II, 2021, and Keller et al., "The Iray Light Transport Simulation and Rendering System",
//! 2017.

use serde::Deserialize;

use super::{
    BounceState, Bounces, FirstLobe, Integrator, Limit, LimitValue, Lobes, PathState, ShadingOutput, ShadowPassage,
    Stage, Tag, Vertex, VertexBatch, VertexContext,
    diffuse::{DiffuseBlock, DiffuseSurface},
    direct::{DirectLight, ShadingPoint, Strategy, sample_direct},
    max_depth,
};
use crate::{
    bsdf::{Bsdf, BsdfKind, BsdfVisitor, Lobe, folded::Folded, fresnel::reflect, layered::hero_channel::HeroChannel},
    geometry::Hit,
    light::environment::EnvironmentLight,
    material::{Emission, Material},
    math::{Frame, Ray, Rgb, Vec3},
    sampler::{Dimension, SampleUse},
    scene::{
        LightFamily, LightSampleContext, MediumStack, Scene, SurfaceInteraction,
        shading_frame::{ShadingFrame, shading_frame},
    },
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
    pub clamp_direct: Option<Positive>,
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
                straight: u8::MAX,
            },
            roulette_depth: self.roulette_depth.map_or(5, |d| d.0),
            clamp_direct: self.clamp_direct.map(|c| c.0),
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
    /// The most light by way of one surface and of more, in W m^-2 sr^-1.
    pub clamp_direct: Option<f32>,
    pub clamp_indirect: Option<f32>,
    pub strategy: Strategy,
}

/// The chance of survival in the roulette is never more, so that paths between mirrors end.
const MAX_SURVIVAL: f32 = 0.95;

impl Integrator for PathTracer {
    fn batched_dimensions(&self, scene: &Scene, depth: u32) -> Vec<SampleUse> {
        let goes_on = depth < self.max_depth;
        let drawn = [
            (
                SampleUse::Selection,
                goes_on && (scene.lights.has_choice() || scene.has_lobes()),
            ),
            (
                SampleUse::Light,
                goes_on && scene.lights.families().any(|f| f != LightFamily::Background),
            ),
            (SampleUse::Background, goes_on && scene.lights.background().is_some()),
            (SampleUse::Bsdf, goes_on),
            (SampleUse::Roulette, goes_on && depth >= self.roulette_depth),
        ];
        drawn.into_iter().filter(|(_, drawn)| *drawn).map(|(p, _)| p).collect()
    }

    fn shade_batch(&self, batch: &VertexBatch<'_>, out: &mut ShadingOutput) {
        let mut diffuse = DiffuseBlock::EMPTY;
        for k in 0..batch.len() {
            if k % DiffuseBlock::LEN == 0 && !batch.surfaces.is_empty() {
                out.clock.lap(Stage::Bsdf);
                diffuse.fill(batch, k, self.strategy);
                out.clock.lap(Stage::Light);
            }
            let context = batch.begin(k, out);
            self.shade(&context, diffuse.surface(k), out);
        }
    }

    #[inline(always)]
    fn vertex(&self, context: &VertexContext<'_>, out: &mut ShadingOutput) {
        self.shade(context, None, out);
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
        let clamp = |name, l: Option<f32>| {
            l.map(|l| Limit {
                name,
                value: LimitValue::Radiance(l),
            })
        };
        let all = [
            Some(depth),
            bounces("maxDiffuse", self.limits.diffuse),
            bounces("maxSpecular", self.limits.specular),
            bounces("maxTransmission", self.limits.transmission),
            clamp("clampDirect", self.clamp_direct),
            clamp("clampIndirect", self.clamp_indirect),
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
        if (material.normal_map().is_some() || coat.is_some()) && !bsdf.transmits() {
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
    /// Asks for light, and carries the path on; for `horizon` see [`ShadingPoint`].
    #[inline(always)]
    fn scatter(self, bsdf: &impl BsdfKind, frame: Frame, wo_local: Vec3, horizon: Vec3) {
        let Self {
            tracer,
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
        // What has but one direction is found this way alone.
        if !bsdf.is_delta() && !scene.lights.is_empty() {
            let how = DirectLight {
                strategy: tracer.strategy,
                clamp: |l| tracer.clamped(path, 1, l),
                passage: |transmitted| tracer.shadow_passage(context, &shading, transmitted),
            };
            sample_direct(context, &shading, &how, out);
        }
        let uc = if bsdf.has_lobes() {
            context
                .numbers
                .get_2d(Dimension::at(path.depth, SampleUse::Selection))
                .y
        } else {
            0.0
        };
        tracer.go_on(context, &shading, uc, out);
    }
}

impl PathTracer {
    /// Shades one vertex; `diffuse` is what is known of its surface if that is diffuse.
    #[inline(always)]
    fn shade(&self, context: &VertexContext<'_>, diffuse: Option<DiffuseSurface<'_>>, out: &mut ShadingOutput) {
        let (surface, hit) = match context.vertex {
            Vertex::Surface(surface, hit) => (surface, hit),
            Vertex::Miss(light) => return self.escape(context, &light, out),
        };
        let (scene, path) = (context.scene, context.path);
        if !path.last.media.is_empty() {
            out.attenuate(scene.transmittance(path.last.media, surface.t - context.ray.tmin));
        }
        let material = scene.material(surface.material);
        if let Some(emission) = material.emission() {
            self.emission(context, surface, hit, &emission, out);
        }
        if path.depth >= self.max_depth {
            return;
        }
        let mut bsdf = material.bsdf(&scene.textures(), &surface.texture);
        if let (Bsdf::Lambert(lambert), Some(diffuse)) = (&bsdf, diffuse) {
            return self.scatter_diffuse(context, surface, lambert.albedo, diffuse, out);
        }
        if let Bsdf::Layered(layered) = &mut bsdf
            && layered.disperses()
        {
            // The number that chooses the lobe chooses the channel as well.
            let choice = context.numbers.get_2d(Dimension::at(path.depth, SampleUse::Selection));
            if let Some(hero) = HeroChannel::choose(path.throughput, choice.y) {
                *layered = layered.for_channel(hero);
            }
        }
        if let Some(ior) = scene.ior_outside(path.last.media, surface.material) {
            bsdf = bsdf.immersed(ior);
        }
        bsdf.dispatch(Scatter {
            tracer: self,
            context,
            surface,
            material,
            out,
        });
    }

    /// Asks for light on a diffuse surface, and carries the path on.
    #[inline(always)]
    fn scatter_diffuse(
        &self,
        context: &VertexContext<'_>,
        surface: &SurfaceInteraction,
        albedo: Rgb,
        diffuse: DiffuseSurface<'_>,
        out: &mut ShadingOutput,
    ) {
        let (scene, path) = (context.scene, context.path);
        for light in diffuse.lights(albedo) {
            out.add_shadow_ray(
                light.shadow_ray,
                self.clamped(path, 1, light.l),
                || self.passage(context, path.last.media),
                || Tag {
                    group: scene.group_of(light.chosen.light),
                    lobes: Lobes::reflected(light.f_cos, light.f_cos),
                },
            );
        }
        let Some((ray, pdf)) = diffuse.ray().filter(|_| !albedo.is_black()) else {
            return;
        };
        let Some((bounces, weight)) = self.go_on_by(context, Lobe::Diffuse, albedo) else {
            return;
        };
        out.set_first_lobes(|| Lobes::reflected(albedo, albedo));
        let last = BounceState {
            pdf: Some(pdf).into(),
            n: surface.viewed_normal(),
            media: path.last.media,
            bounces,
            first: FirstLobe::OfSample,
        };
        out.spawn_path(ray, weight, last);
    }

    /// The bounces and the weight of the path if it goes on by `lobe`, where it does.
    #[inline(always)]
    fn go_on_by(&self, context: &VertexContext<'_>, lobe: Lobe, weight: Rgb) -> Option<(Bounces, Rgb)> {
        let path = context.path;
        let bounces = path.last.bounces.and(lobe, self.limits)?;
        if path.depth < self.roulette_depth {
            return Some((bounces, weight));
        }
        let survival = (path.throughput * weight).max_component().min(MAX_SURVIVAL);
        let u = context.numbers.get_2d(Dimension::at(path.depth, SampleUse::Roulette)).x;
        (u < survival).then(|| (bounces, weight / survival))
    }

    /// Adds the radiance of the background.
    fn escape(&self, context: &VertexContext<'_>, background: &EnvironmentLight, out: &mut ShadingOutput) {
        let (scene, path, w) = (context.scene, context.path, context.ray.d);
        if !path.last.media.is_empty() {
            out.attenuate(scene.transmittance(path.last.media, f32::INFINITY));
        }
        let l = background.radiance;
        if !l.is_black() {
            let weight = self.strategy.weight_of_bsdf(path.last.pdf, || background.pdf);
            out.add_radiance(self.clamped(path, 0, l * weight), || scene.light_groups.of_background());
        }
        if path.depth > 1 {
            // The camera does not see suns.
            for (sun, l, pdf) in scene.suns(&receiver(context), w) {
                let weight = self.strategy.weight_of_bsdf(path.last.pdf, || pdf);
                out.add_radiance(self.clamped(path, 0, l * weight), || scene.group_of(sun));
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
        out.add_radiance(self.clamped(path, 0, l * weight), || {
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
        let Some(sample) = shading.bsdf.sample_prepared(&shading.prepared, shading.wo_local, uc, u) else {
            return;
        };
        let Some((mut bounces, weight)) = self.go_on_by(context, sample.lobe, sample.weight) else {
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
        if sample.is_straight() && context.scene.media.lets_shadow_rays_through() {
            // Light that was asked for at the last vertex comes this way too: nothing changes but the beginning of the ray.
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
        let (mut wi, mut pdf) = (shading.frame.to_world(sample.wi), sample.pdf);
        if shading.misses_far_side(wi, transmitted) {
            // It would arrive at the same place for ever. No light is asked for along the way it takes instead.
            (wi, pdf) = (reflect(-wi, surface.ng), None);
        }
        let last = BounceState {
            pdf: pdf.into(),
            n: shading.horizon,
            media,
            bounces,
            first: FirstLobe::OfSample,
        };
        out.spawn_path(surface.spawn_ray(transmitted, wi), weight, last);
    }

    /// The passage of a shadow ray that leaves the surface through it, or on the side of the viewer.
    #[cold]
    fn shadow_passage(
        &self,
        context: &VertexContext<'_>,
        shading: &ShadingPoint<'_, impl BsdfKind>,
        transmitted: bool,
    ) -> ShadowPassage {
        let media = if transmitted {
            media_behind(context, shading)
        } else {
            context.path.last.media
        };
        self.passage(context, media)
    }

    /// The passage of a shadow ray that begins in `media`.
    #[cold]
    fn passage(&self, context: &VertexContext<'_>, media: MediumStack) -> ShadowPassage {
        let path = context.path;
        let transmissions = self.limits.transmission - path.last.bounces.transmission;
        ShadowPassage {
            media,
            surfaces: (self.max_depth - path.depth - 1).min(transmissions.into()),
        }
    }

    /// `l`, that `path` brings by way of `further` segments, scaled down where that is too much.
    fn clamped(&self, path: &PathState, further: u32, l: Rgb) -> Rgb {
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

/// The point for which light would have been sampled at the path's last vertex.
fn receiver(context: &VertexContext<'_>) -> LightSampleContext {
    LightSampleContext {
        p: context.ray.o,
        n: context.path.last.n,
    }
}

/// The media behind the surface, as the path sees it.
fn media_behind(context: &VertexContext<'_>, shading: &ShadingPoint<'_, impl BsdfKind>) -> MediumStack {
    let inwards = shading.wo_local.z > 0.0;
    context
        .scene
        .media_behind(context.path.last.media, shading.surface.material, inwards)
}
