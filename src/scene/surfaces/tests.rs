//! Surfaces of parallelograms, which rays are traced against as triangles.

use super::*;
use crate::{
    accel::AccelKind,
    material::{Material, matte::Matte},
    math::{
        DVec3, Plain, Rgb,
        hash::{pcg4d, unit_f32},
    },
    scene::{Background, SceneBuilder},
    shape::ShapeDesc,
    texture::{Color, Mapping, Pattern, Texture, checker::Checker},
};

const CORNERS: [Vec3; 4] = [
    Vec3::new(0.0, 0.0, 0.0),
    Vec3::new(2.0, 0.5, 0.0),
    Vec3::new(2.25, 1.75, 1.0),
    Vec3::new(0.25, 1.25, 1.0),
];

/// A parallelogram, plain or with a texture.
fn scene(transform: Option<Transform>, is_textured: bool) -> Scene {
    scene_of(CORNERS, transform, is_textured)
}

fn scene_of(corners: [Vec3; 4], transform: Option<Transform>, is_textured: bool) -> Scene {
    let mut builder = SceneBuilder::new(Background::new(Rgb::BLACK));
    let squares = Checker {
        colors: [Rgb::gray(0.3), Rgb::gray(0.7)],
        scale: 3.0,
    };
    let squares = builder.texture(Texture::new(Mapping::Uv, Pattern::Checker(squares)));
    let color = if is_textured {
        Color::Texture(squares)
    } else {
        Color::Constant(Rgb::WHITE)
    };
    let material = builder.material(Material::Matte(Matte::smooth(color)));
    let corners = corners.map(|c| format!("{:?}", c.to_array())).join(", ");
    let desc: ShapeDesc = toml::from_str(&format!("quad = {{ corners = [{corners}] }}")).expect("a shape");
    let shape = desc.compile(DVec3::ZERO).expect("valid");
    builder.shape("quad", shape, transform, material);
    builder.build(AccelKind::default()).expect("a scene")
}

/// Rays from both sides to places all over the quad, and the parameters of these.
fn rays(transform: Option<Transform>) -> Vec<(Ray, Vec2)> {
    let [a, b, _, d] = CORNERS;
    let in_world = |p: Vec3| transform.map_or(p, |t| t.point_to_world(p));
    let n = (b - a).cross(d - a).normalize();
    (0..400)
        .map(|i| {
            let at = |k: f32| (i as f32 * k).fract().clamp(0.001, 0.999);
            let uv = Vec2::new(at(0.618_034), at(0.754_877));
            let to = a + (b - a) * uv.x + (d - a) * uv.y;
            let side = if i % 2 == 0 { 2.0 } else { -2.0 };
            let from = to + n * side + Vec3::new(at(0.3), at(0.7), at(0.9));
            let (from, to) = (in_world(from), in_world(to));
            (Ray::new(from, to - from), uv)
        })
        .collect()
}

fn places() -> [Option<Transform>; 3] {
    let turn = |scale| Transform::from_parts(DVec3::new(0.3, -0.2, 0.5), DVec3::new(20.0, 40.0, 60.0), scale);
    [None, turn(DVec3::splat(1.5)), turn(DVec3::new(1.0, -0.5, 2.0))]
}

#[test]
fn a_place_on_a_parallelogram_is_that_of_its_parameters() {
    let [a, b, _, d] = CORNERS;
    for transform in places() {
        let local_normal = (b - a).cross(d - a).normalize();
        let normal = transform.map_or(local_normal, |t| t.normal_to_world(local_normal).normalize());
        for is_textured in [false, true] {
            let scene = scene(transform, is_textured);
            for (ray, uv) in rays(transform) {
                let mut hits = [None];
                scene.geometry.accel.nearest(&[ray], &mut hits);
                let surface = scene.surface(&ray, &hits[0].expect("the quad"));
                let found = surface.texture.uv;
                assert!((found - uv).abs().max_element() < 2e-6, "{found} {uv}");
                let local = a + (b - a) * found.x + (d - a) * found.y;
                let p = transform.map_or(local, |t| t.point_to_world(local));
                assert!((surface.p - p).length() < 1e-6, "{} {p}", surface.p);
                assert!((surface.ng - normal).length() < 1e-6);
            }
        }
    }
}

#[test]
fn many_places_on_a_parallelogram_are_those_one_by_one() {
    for transform in places() {
        for is_textured in [false, true] {
            let scene = scene(transform, is_textured);
            let rays: Vec<Ray> = rays(transform).into_iter().map(|(ray, _)| ray).collect();
            let mut hits = vec![None; rays.len()];
            scene.geometry.accel.nearest(&rays, &mut hits);
            let hits: Vec<Hit> = hits.into_iter().map(|hit| hit.expect("the quad")).collect();
            let prims: Vec<PrimId> = hits.iter().map(|hit| hit.prim).collect();
            let mut many = Surfaces::default();
            scene.surfaces(Plain, 0..rays.len(), &prims, |i| (&rays[i], &hits[i]), &mut many);
            for (i, found) in many.interactions.iter().enumerate() {
                let alone = scene.surface(&rays[i], &hits[i]);
                assert_eq!((found.p, found.ng, found.wo), (alone.p, alone.ng, alone.wo));
                assert_eq!(
                    (found.ray_origins, found.texture.uv),
                    (alone.ray_origins, alone.texture.uv)
                );
            }
        }
    }
}

/// Rays that leave, also all but along the plane, of tilted and level quads, small and large, near and far.
#[test]
fn rays_that_leave_a_parallelogram_never_meet_it_again() {
    let mut random = 0;
    let mut unit = || {
        random += 1;
        unit_f32(pcg4d([random, 5, 9, 2])[0]) - 0.5
    };
    for round in 0..600 {
        let scale = [1.0, 1e-3, 1e4, 30.0][round % 4];
        let center = [0.0, 1.0, 1e3][round / 4 % 3] * scale;
        let mut vec = |size: f32| Vec3::new(unit(), unit(), unit()) * (size * scale);
        let (a, mut e, mut f) = (vec(1.0) + center, vec(2.0), vec(2.0));
        if round % 5 == 0 {
            (e.y, f.y) = (0.0, 0.0);
        }
        let corners = [a, a + e, a + e + f, a + f];
        let transform = [
            None,
            Transform::from_parts(DVec3::splat(0.3), DVec3::new(20.0, 40.0, 60.0), DVec3::ONE),
        ][round / 2 % 2];
        let scene = scene_of(corners, transform, false);
        let ng = e.cross(f).normalize();
        for i in 0..20 {
            let uv = Vec2::new(unit() + 0.5, unit() + 0.5);
            let to = a + e * uv.x + f * uv.y;
            let from = to + (ng * if i % 2 == 0 { 1.0 } else { -1.0 } + Vec3::new(unit(), unit(), unit())) * scale;
            let [from, to] = [from, to].map(|p| transform.map_or(p, |t| t.point_to_world(p)));
            let ray = Ray::new(from, to - from);
            let mut hits = [None];
            scene.geometry.accel.nearest(&[ray], &mut hits);
            let Some(hit) = hits[0] else { continue };
            let surface = scene.surface(&ray, &hit);
            let d = Vec3::new(unit(), unit(), unit()).normalize();
            let grazing = d - surface.ng * (d.dot(surface.ng) * 0.9999);
            for w in [d, grazing] {
                let is_above = w.dot(surface.ng) > 0.0;
                let origin = surface.ray_origins[usize::from(!is_above)];
                scene.geometry.accel.nearest(&[Ray::new(origin, w)], &mut hits);
                assert_eq!(hits[0], None, "{corners:?} {transform:?} {w}");
            }
        }
    }
}
