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
//! surface. Of the others, each sun is sampled once, and so is one emitting surface, chosen by how much light it may
//! contribute: soft shadows, with noise that `samples` average out. An environment is visible and appears in mirrors, but it
//! does not light surfaces; `ambient` does that.
//!
//! Source: Whitted, "An improved illumination model for shaded display", CACM 23(6), 1980, doi:10.1145/358876.358882.

use serde::Deserialize;

use super::{Departures, Integrator, Limit, LimitValue, Onward, Vertex, Visit, max_depth};
use crate::{
    bsdf::fresnel::{dielectric, reflect, refract},
    light::{Light, LightSample},
    material::{Split, Terms},
    math::{Rgb, Vec2, Vec3, trig},
    sampler::{Dimension, Purpose},
    scene::{Receiver, Surface},
    value::{Problem, Spanned, Tint, Whole},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WhittedDesc {
    pub max_depth: Option<Spanned<Whole>>,
    pub ambient: Option<Tint>,
}

impl WhittedDesc {
    pub fn compile(&self) -> Result<Whitted, Problem> {
        Ok(Whitted {
            max_depth: max_depth(&self.max_depth, 5)?,
            ambient: self.ambient.map_or(Rgb::BLACK, |a| a.0),
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Whitted {
    pub max_depth: u32,
    pub ambient: Rgb,
}

impl Integrator for Whitted {
    #[inline(always)]
    fn vertex(&self, visit: &Visit<'_>, out: &mut Departures) {
        let scene = visit.scene;
        let surface = match visit.vertex {
            Vertex::Surface(surface, _) => surface,
            Vertex::Escape => return out.add(scene.escape(visit.ray.d)),
        };
        let terms = scene
            .material(surface.material)
            .terms(&scene.textures(), &surface.texture);
        // By the true side: at the rim of a smooth mesh the shading normal may point away.
        let n = if terms.two_sided && surface.ng.dot(surface.wo) < 0.0 {
            -surface.ns
        } else {
            surface.ns
        };
        out.add(self.ambient * terms.ambient);
        if let Some(emission) = scene.material(surface.material).emission() {
            out.add(emission.radiance(&scene.textures(), &surface.texture, surface.ng.dot(surface.wo)));
        }
        if visit.path.depth >= self.max_depth {
            return;
        }
        for light in scene.lights.all() {
            let u = match light {
                Light::Sun(sun) if sun.has_size() => visit.numbers.pair(Dimension::at(visit.path.depth, Purpose::Bsdf)),
                _ => Vec2::splat(0.5),
            };
            if let Some(sample) = light.sample(surface.p, u) {
                direct(&sample, surface, n, &terms, out);
            }
        }
        shining_surface(visit, surface, n, &terms, out);
        if terms.transmit.is_black() {
            go_on(surface, reflect(surface.wo, n), terms.reflect, out);
        } else {
            reflect_and_refract(surface, &terms, out);
        }
    }

    fn limits(&self) -> Vec<Limit> {
        vec![Limit {
            name: "maxDepth",
            value: LimitValue::Count(self.max_depth),
        }]
    }
}

/// Carries the path on along `wi`, if that counts at all.
#[inline]
fn go_on(surface: &Surface, wi: Vec3, weight: Rgb, out: &mut Departures) {
    if !weight.is_black() {
        out.go_on(surface.spawn_ray(wi), weight, Onward::default());
    }
}

/// The two rays that leave a clear surface; one under total reflection.
fn reflect_and_refract(surface: &Surface, terms: &Terms, out: &mut Departures) {
    let wo = surface.wo;
    let (n, eta) = if surface.ns.dot(wo) < 0.0 {
        (-surface.ns, 1.0 / terms.ior)
    } else {
        (surface.ns, terms.ior)
    };
    let through = refract(wo, n, eta);
    let reflected = match (terms.split, through) {
        (Split::Fixed, None) => terms.reflect + terms.transmit,
        (Split::Fixed, Some(_)) => terms.reflect,
        (Split::Fresnel, _) => terms.reflect * dielectric(n.dot(wo), eta),
    };
    go_on(surface, reflect(wo, n), reflected, out);
    if let Some(wi) = through {
        let passed = match terms.split {
            Split::Fixed => terms.transmit,
            Split::Fresnel => terms.transmit * (1.0 - dielectric(n.dot(wo), eta)),
        };
        go_on(surface, wi, passed, out);
    }
}

/// What one of the surfaces that shine brings for all of them.
fn shining_surface(visit: &Visit<'_>, surface: &Surface, n: Vec3, terms: &Terms, out: &mut Departures) {
    let (scene, depth) = (visit.scene, visit.path.depth);
    if scene.lights.emitters().count() == 0 {
        return;
    }
    let receiver = Receiver { p: surface.p, n };
    let u = visit.numbers.pair(Dimension::at(depth, Purpose::Choice)).x;
    let Some(choice) = scene.lights.choose_emitter(&receiver, u) else {
        return;
    };
    let u = visit.numbers.pair(Dimension::at(depth, Purpose::Light));
    if let Some(mut sample) = scene.sample_light(choice.light, surface.p, u) {
        sample.li = sample.li / choice.pmf;
        direct(&sample, surface, n, terms, out);
    }
}

/// What a light brings, if nothing is in the way.
#[inline]
fn direct(sample: &LightSample, surface: &Surface, n: Vec3, terms: &Terms, out: &mut Departures) {
    let cos = n.dot(sample.wi);
    if cos <= 0.0 {
        return;
    }
    let mut weight = terms.diffuse * cos;
    if !terms.specular.is_black() {
        let highlight = reflect(sample.wi, n).dot(surface.wo).max(0.0);
        weight += terms.specular * trig::pow(highlight, terms.shininess);
    }
    let l = match sample.pdf {
        None => sample.li * weight,
        Some(pdf) => sample.li * weight / pdf,
    };
    if !l.is_black() {
        out.shadow(surface.shadow_ray(sample.wi, sample.distance), l);
    }
}
