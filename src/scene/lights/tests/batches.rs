//! Lamps sampled for many surfaces at once.

use super::*;
use crate::{
    light::point::PointLight,
    material::matte::Matte,
    sampler::UnitBits,
    scene::{LightNumbers, LightSamples, SurfaceInteraction},
    texture::{Mapping, Pattern, Texture, checker::Checker},
};

/// A white ball under lamps; the second triangle has a texture.
fn ball(lamps: &[(&str, Option<Transform>)], triangles: &[[Vec3; 3]], points: &[Vec3]) -> Scene {
    let mut builder = dark();
    let front = builder.material(lamp());
    let both = builder.material(shining(Color::Constant(Rgb::gray(3.0)), Sidedness::Both));
    for (i, (shape, transform)) in lamps.iter().enumerate() {
        add(&mut builder, shape, *transform, if i % 2 == 0 { front } else { both });
    }
    let squares = Checker {
        colors: [Rgb::gray(2.0), Rgb::BLACK],
        scale: 3.0,
    };
    let squares = builder.texture(Texture::new(Mapping::Uv, Pattern::Checker(squares)));
    let checkered = builder.material(shining(Color::Texture(squares), Sidedness::Front));
    for (corners, material) in triangles.iter().zip([both, checkered]) {
        let mesh = Mesh {
            positions: corners.to_vec(),
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        builder.mesh("mesh", mesh, material).expect("valid");
    }
    let white = builder.material(Material::Matte(Matte::smooth(Color::Constant(Rgb::WHITE))));
    add(&mut builder, "sphere = { radius = 1 }", None, white);
    for &p in points {
        builder.light(Light::Point(PointLight::new(p, Rgb::WHITE)));
    }
    builder.build(AccelKind::Linear).expect("a scene")
}

/// Places all over the ball, and fewer than fill the last block.
fn surfaces(scene: &Scene) -> Vec<SurfaceInteraction> {
    let rays: Vec<Ray> = (0..403)
        .map(|i| {
            let w = warp::square_to_hemisphere(numbers(5, i)[0]) * if i % 2 == 0 { 1.0 } else { -1.0 };
            Ray::new(w * 1.1, -w)
        })
        .collect();
    let mut hits = vec![None; rays.len()];
    scene.geometry.accel.nearest(&rays, &mut hits);
    let surface = |(ray, hit): (&Ray, &Option<_>)| Some(scene.surface(ray, hit.as_ref()?));
    rays.iter().zip(&hits).filter_map(surface).collect()
}

#[test]
fn lamps_for_many_surfaces_are_those_for_single_ones() {
    // Sampled by area and by solid angle, of no light inside of blocks, and turned.
    let near = "quad = { corners = [[-1, 1.2, -1], [1, 1.2, -1], [1, 1.2, 1], [-1, 1.2, 1]] }";
    let small = "quad = { corners = [[0, -4, 0], [0, -4, 0.5], [0.5, -4, 0.5], [0.5, -4, 0]] }";
    let skew = "quad = { corners = [[3, 0, 0], [3, 1, 0.5], [3, 1, 2], [3, 0, 1.5]] }";
    let sphere = "sphere = { center = [0, 0, 5], radius = 0.5 }";
    let inside = "sphere = { radius = 1.5 }";
    let triangle = [-1.5, 6.0].map(|y| [Vec3::new(-2.0, y, 1.0), Vec3::new(1.0, y, -1.0), Vec3::new(1.5, y, 2.0)]);
    let turned = place([-3.0, 0.0, 0.0], [10.0, 0.0, 70.0], [1.0; 3]);
    let all = [
        (near, None),
        (small, None),
        (skew, None),
        (sphere, None),
        (small, turned),
    ];
    let scenes = [
        ball(&all, &triangle, &[Vec3::new(0.0, 3.0, 3.0)]),
        ball(&all[..1], &[], &[]),
        ball(&all[1..2], &[], &[]),
        ball(&all[3..4], &[], &[]),
        ball(&[(near, None), (inside, None)], &[], &[]),
        ball(&[], &triangle, &[]),
        ball(&[], &[], &[Vec3::new(0.0, 3.0, 3.0)]),
    ];
    for scene in &scenes {
        let surfaces = surfaces(scene);
        assert!(surfaces.len() > 400);
        let count = 0..surfaces.len() as u32;
        let choices: Vec<_> = count
            .clone()
            .map(|i| UnitBits((numbers(6, i)[0].x * 4_294_967_296.0) as u32))
            .collect();
        let points: Vec<_> = count.map(|i| numbers(6, i)[1]).collect();
        let mut samples = LightSamples::default();
        let drawn = LightNumbers {
            choices: Some(&choices),
            points: &points,
        };
        scene.sample_lights(Plain, &surfaces, drawn, &mut samples);
        let mut lit = 0;
        for (k, surface) in surfaces.iter().enumerate() {
            let at = LightSampleContext {
                p: surface.p,
                n: surface.viewed_normal(),
            };
            let choice = scene.lights.choose(Plain, LightFamily::Finite, &at, choices[k].f64());
            let expected = choice.and_then(|c| Some((c, scene.sample_light(c.light, at.p, points[k])?)));
            let sample = samples.get(LightFamily::Finite, k);
            assert_eq!(sample.expect("the ball reflects light"), expected);
            lit += u32::from(expected.is_some());
        }
        assert!(lit > 50, "{lit} lit");
    }
}

/// Large and tilted lamps near what they light, needles too, also turned and stretched; by one sample and in blocks.
#[test]
fn no_lamp_of_a_quad_hides_its_own_light() {
    let lamps = [
        (
            [
                [-60.0, 10.0, -40.0],
                [40.0, 50.0, -60.0],
                [60.0, -10.0, 40.0],
                [-40.0, -50.0, 60.0],
            ],
            None,
        ),
        (
            [
                [0.5, 26.0, 33.0],
                [0.5, -26.0, -33.0],
                [0.5, -78.0, -99.0],
                [0.5, -26.0, -33.25],
            ],
            None,
        ),
        (
            [
                [-30.0, 0.0, -30.0],
                [-30.0, 0.0, 30.0],
                [30.0, 0.0, 30.0],
                [30.0, 0.0, -30.0],
            ],
            place([0.3, -0.4, 0.1], [20.0, 45.0, 53.0], [2.0, 1.0, 0.5]),
        ),
        (
            [
                [0.0, 26.08479, 33.0],
                [0.0, -26.08479, -33.0],
                [0.0, -77.80479, -99.0],
                [0.0, -25.63521, -33.0],
            ],
            place([-0.416, -0.47466, 0.053], [-19.788, -45.4, 53.302], [2.0, 1.0, 0.5]),
        ),
    ];
    for (corners, transform) in lamps {
        let mut builder = dark();
        let material = builder.material(shining(Color::Constant(Rgb::WHITE), Sidedness::Both));
        add(
            &mut builder,
            &format!("quad = {{ corners = {corners:?} }}"),
            transform,
            material,
        );
        let scene = builder.build(AccelKind::default()).expect("a scene");
        let (mut count, mut hidden) = (0, 0);
        for i in 0..4000 {
            let [at, u] = numbers(12, i);
            let from = Vec3::new(at.x - 0.5, at.y + 0.2, at.x * at.y - 0.3);
            let Some(sample) = scene.sample_light(LightId(0), from, u) else {
                continue;
            };
            let mut blocked = [false];
            let ray = Ray::segment(from, sample.wi * sample.distance, 1.0);
            scene.geometry.accel.occluded(&[ray], &mut blocked);
            (count, hidden) = (count + 1, hidden + u32::from(blocked[0]));
        }
        assert!(count > 1000 && hidden == 0, "{corners:?}: {hidden} of {count}");
    }
}
