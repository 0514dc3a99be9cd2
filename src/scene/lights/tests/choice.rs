//! Which light is chosen.

use super::*;
use crate::{
    light::{
        Falloff, LightDesc, LightFind, Profile,
        environment::Environment,
        point::PointLight,
        profile::{Measurement, Photometry, Symmetry},
        spot::SpotLight,
        sun::SunLight,
    },
    math::{DMat3, DVec3, WorkingSpace},
    texture::Bitmap,
};

/// A sky of radiance 0.5 with a part that is 20 times as bright, at -z.
fn sky() -> Background {
    let texel = |i: u32| if i % 16 == 8 && i / 16 == 3 { 10.0 } else { 0.5 };
    let values = (0..16 * 8).flat_map(|i| [texel(i); 3]).collect();
    let picture = Bitmap::from_floats([16, 8], 3, values);
    Background::environment(Environment::new(&picture, WorkingSpace::Rec709, 1.0, DMat3::IDENTITY))
}

/// A lamp of type C that shines down into 50 degrees, with a little light upwards.
fn downlight() -> Profile {
    Profile::new(&Measurement {
        photometry: Photometry::C,
        vertical: vec![0.0, 30.0, 50.0, 130.0, 180.0],
        horizontal: vec![0.0, 90.0, 180.0],
        symmetry: Symmetry::Mirrored,
        candela: [[4000.0, 3000.0, 0.0, 0.0, 200.0], [4000.0, 1000.0, 0.0, 0.0, 200.0]]
            .into_iter()
            .chain([[4000.0, 2000.0, 0.0, 0.0, 200.0]])
            .flatten()
            .collect(),
    })
}

/// Lights of every kind.
fn all_kinds() -> Scene {
    let mut builder = SceneBuilder::new(sky());
    let (lamp, both) = (
        builder.material(lamp()),
        builder.material(shining(Color::Constant(Rgb::gray(5.0)), Sidedness::Both)),
    );
    for (i, shape) in (0..).zip(SHAPES) {
        let at = place(
            [f64::from(i) - 4.0, 2.0, -1.0],
            [20.0 * f64::from(i), 5.0, 0.0],
            [0.5; 3],
        );
        add(&mut builder, shape, at, if i % 2 == 0 { lamp } else { both });
    }
    let mesh = Mesh {
        positions: [[3.0, 3.0, 0.0], [4.0, 3.0, 0.0], [4.0, 3.0, 2.0], [3.0, 4.0, 2.0]]
            .map(Vec3::from)
            .into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    builder.mesh("mesh", mesh, both).expect("valid");
    for i in 0..4 {
        let p = Vec3::new(2.0 * i as f32 - 3.0, 3.0, 1.0);
        builder.light(Light::Point(PointLight::new(p, Rgb::gray(1.0 + i as f32))));
    }
    builder.light(Light::Point(PointLight {
        falloff: Falloff::None,
        ..PointLight::new(Vec3::new(0.0, 9.0, 0.0), Rgb::gray(0.1))
    }));
    builder.light(Light::Spot(SpotLight {
        point: PointLight::new(Vec3::new(0.0, 4.0, 0.0), Rgb::gray(9.0)),
        axis: -Vec3::Y,
        cos_outer: 0.6,
        cos_inner: 0.9,
    }));
    for text in [
        "rect = { position = [2, 3, 1], target = [0, 0, 0], size = [1, 2], power = 30, spread = 0.5 }",
        "point = { position = [-2, 2, 0], power = 50, radius = 0.4 }",
    ] {
        let lamp: LightDesc = toml::from_str(text).expect("a light");
        builder.light(lamp.compile(&LightFind::nothing(DVec3::ZERO)).expect("valid"));
    }
    let profile = builder.profile(downlight());
    for text in [
        "point = { position = [-1, 2.5, 1], ies = '' }",
        "spot = { position = [1, 2.5, 1], ies = '', direction = [0.3, -1, 0], cone_angle = 60, radius = 0.1 }",
        "disk = { position = [0, 2.5, -1], ies = '', direction = [0, -1, 0.3], radius = 0.4, power = 20 }",
    ] {
        let lamp: LightDesc = toml::from_str(text).expect("a light");
        let find = LightFind {
            profile: &|_| Ok(profile),
            ..LightFind::nothing(DVec3::ZERO)
        };
        builder.light(lamp.compile(&find).expect("valid"));
    }
    let sun = SunLight::new(Vec3::new(0.6, -0.8, 0.0), Rgb::gray(0.5));
    builder.light(Light::Sun(sun));
    builder.light(Light::Sun(sun.with_angle(0.2)));
    builder.build(AccelKind::Linear).expect("a scene")
}

/// Places on, above and below a floor, with normals up, aslant and none.
fn receivers() -> impl Iterator<Item = LightSampleContext> {
    (0..40).map(|i| {
        let [a, b] = numbers(71, i);
        let n = Vec3::new(b.x - 0.5, b.y - 0.2, a.x - 0.5);
        LightSampleContext {
            p: Vec3::new(10.0 * a.x - 5.0, 3.0 * a.y * a.y - 0.5, 6.0 * b.x - 3.0),
            n: if i % 5 == 0 { Vec3::ZERO } else { n.normalize() },
        }
    })
}

#[test]
fn lights_of_every_kind_are_chosen_as_often_as_their_probability_says() {
    let scene = all_kinds();
    let count = scene.lights.count();
    assert_eq!(count, 13 + 9 + 2 + 1);
    for at in receivers() {
        let draws = 4000;
        let mut found = vec![0_u32; count as usize];
        let mut none = 0;
        for (family, i) in LightFamily::ALL
            .into_iter()
            .flat_map(|f| (0..draws).map(move |i| (f, i)))
        {
            match scene
                .lights
                .choose(Plain, family, &at, (f64::from(i) + 0.5) / f64::from(draws))
            {
                Some(choice) => {
                    found[choice.light.0 as usize] += 1;
                    assert_eq!(choice.pmf, scene.lights.pmf(&at, choice.light));
                }
                None => none += 1,
            }
        }
        // Each family is certain, or none of it is chosen.
        let mut sum = f64::from(none) / f64::from(draws);
        for (light, found) in (0..).map(LightId).zip(found) {
            let pmf = f64::from(scene.lights.pmf(&at, light));
            sum += pmf;
            assert!(
                (pmf * f64::from(draws) - f64::from(found)).abs() < 3.0,
                "{light:?}: {pmf} {found}"
            );
        }
        assert!((sum - 3.0).abs() < 0.005, "{sum}");
    }
}

#[test]
fn a_light_that_brings_something_always_has_a_chance() {
    let scene = all_kinds();
    for at in receivers() {
        for light in (0..scene.lights.count()).map(LightId) {
            let brings = (0..60).any(|i| {
                let sample = scene.sample_light(light, at.p, numbers(72, i)[0]);
                sample.is_some_and(|s| at.n == Vec3::ZERO || at.n.dot(s.wi) > 0.0)
            });
            assert!(!brings || scene.lights.pmf(&at, light) > 0.0, "{light:?} at {at:?}");
        }
    }
}

#[test]
fn the_sky_and_suns_with_size_bring_the_same_however_they_are_looked_for() {
    let mut builder = SceneBuilder::new(sky());
    builder.light(Light::Sun(
        SunLight::new(Vec3::new(0.6, -0.8, 0.0), Rgb::gray(2.0)).with_angle(0.3),
    ));
    let scene = builder.build(AccelKind::Linear).expect("a scene");
    for n in [Vec3::Y, Vec3::new(-0.6, 0.0, -0.8), Vec3::new(0.79, 0.61, 0.0)] {
        let n = n.normalize();
        let [light, cosine, both] = irradiances(&scene, &LightSampleContext { p: Vec3::ZERO, n }, 20_000);
        assert!(cosine.z(&both) < 4.5, "{cosine:?} {both:?}");
        assert!(both.variance() < cosine.variance());
        // Light sampling alone leaves out what is no brighter than the mean.
        assert!(light.mean() < both.mean());
    }
}

#[test]
fn a_sky_and_a_lamp_together_are_no_noisier_than_each_alone() {
    // A lamp that is off hides the same part of the sky.
    let scene = |background: Background, radiance: f32| {
        let mut builder = SceneBuilder::new(background);
        let material = builder.material(shining(Color::Constant(Rgb::gray(radiance)), Sidedness::Front));
        let transform = place([0.3, 1.5, 0.0], [0.0; 3], [1.0; 3]);
        add(&mut builder, SHAPES[2], transform, material);
        builder.build(AccelKind::Linear).expect("a scene")
    };
    let dark = || Background::new(Rgb::BLACK);
    for at in [floor(0.0), floor(2.0)] {
        // By light sampling, and by both techniques.
        let variances = |scene: &Scene| {
            let [light, _, both] = irradiances(scene, &at, 40_000);
            [light.variance(), both.variance()]
        };
        let (sky, lamp, together) = (
            variances(&scene(sky(), 0.0)),
            variances(&scene(dark(), 2.0)),
            variances(&scene(sky(), 2.0)),
        );
        for ((together, sky), lamp) in together.into_iter().zip(sky).zip(lamp) {
            assert!(together <= 1.15 * (sky + lamp), "{together} of {sky} and {lamp}");
        }
    }
}

#[test]
fn a_constant_sky_is_no_light() {
    let scene = SceneBuilder::new(Background::new(Rgb::WHITE))
        .build(AccelKind::Linear)
        .expect("a scene");
    let at = floor(0.0);
    let chosen = LightFamily::ALL.map(|family| scene.lights.choose(Plain, family, &at, 0.3));
    assert_eq!((scene.lights.count(), chosen), (0, [None; 3]));
    assert_eq!(scene.pdf_background(&at, Vec3::Y), 0.0);
    let [_, cosine, both] = irradiances(&scene, &at, 200);
    assert!((cosine.mean() / PI - 1.0).abs() < 1e-6 && (both.mean() / PI - 1.0).abs() < 1e-6);
}

#[test]
fn the_only_light_is_certain() {
    let scene = shape_scene(SHAPES[0], None, lamp());
    let choice = scene
        .lights
        .choose(Plain, LightFamily::Finite, &floor(0.0), 0.7)
        .expect("a light");
    assert_eq!((choice.light, choice.pmf), (LightId(0), 1.0));
}

/// A thousand small lamps of different strength under a ceiling of 30 m x 30 m.
fn hall() -> Scene {
    let mut builder = dark();
    let lamps = [0.5, 2.0, 20.0].map(|l| builder.material(shining(Color::Constant(Rgb::gray(l)), Sidedness::Front)));
    for i in 0..1000 {
        let [a, b] = numbers(73, i);
        let at = place(
            [f64::from(30.0 * a.x - 15.0), 3.0, f64::from(30.0 * a.y - 15.0)],
            [0.0; 3],
            [0.1; 3],
        );
        add(
            &mut builder,
            "disk = { normal = [0, -1, 0], radius = 1 }",
            at,
            lamps[(b.x * 3.0) as usize],
        );
    }
    builder.build(AccelKind::Wide).expect("a scene")
}

#[test]
fn among_a_thousand_lamps_the_tree_is_far_less_noisy_than_equal_chances() {
    let scene = hall();
    let (mut by_tree, mut by_chance) = (0.0, 0.0);
    for x in [-8.0, 0.0, 5.0] {
        let at = LightSampleContext {
            p: Vec3::new(x, 0.0, x * 0.5),
            n: Vec3::Y,
        };
        let (mut tree, mut chance) = (Estimate::default(), Estimate::default());
        for i in 0..8000 {
            let [u, v] = numbers(74, i);
            let irradiance = |light: LightId| {
                let sample = scene.sample_light(light, at.p, u);
                sample.map_or(0.0, |s| {
                    f64::from(s.li.g * s.wi.y.max(0.0) / s.pdf.expect("it has size"))
                })
            };
            let choice = scene
                .lights
                .choose(Plain, LightFamily::Finite, &at, v.x.into())
                .expect("a light");
            tree.add(irradiance(choice.light) / f64::from(choice.pmf));
            chance.add(irradiance(LightId((v.y * 1000.0) as u32)) * 1000.0);
        }
        assert!(tree.z(&chance) < 4.5, "{tree:?} {chance:?}");
        by_tree += tree.variance();
        by_chance += chance.variance();
    }
    assert!(by_tree * 8.0 < by_chance, "{by_tree} {by_chance}");
}

#[test]
fn lamps_that_move_shine_from_where_they_are() {
    let mut builder = dark();
    let material = builder.material(lamp());
    let desc: ShapeDesc = toml::from_str(SHAPES[0]).expect("a shape");
    let shape = desc.compile(DVec3::ZERO).expect("valid");
    let object = builder.shape("lamp", shape, place([0.0, 2.0, 0.0], [0.0; 3], [1.0; 3]), material);
    let other = builder.shape("other", shape, place([9.0, 2.0, 0.0], [0.0; 3], [1.0; 3]), material);
    let mut scene = builder.build(AccelKind::Linear).expect("a scene");
    let there = place([-9.0, 3.0, 0.0], [0.0; 3], [1.0; 3]).expect("a place");
    let motion = crate::scene::SceneUpdate {
        transforms: vec![(object, there)],
        ..Default::default()
    };
    scene.apply(&motion).expect("it can be moved");
    let at = LightSampleContext {
        p: Vec3::new(-9.0, 0.0, 0.0),
        n: Vec3::Y,
    };
    assert!(scene.lights.pmf(&at, LightId(0)) > 0.9, "{object:?} {other:?}");
    assert!(agrees(
        &irradiance_of(&scene, &at, 2000),
        2.0 * PI * (0.25 / 9.0 + 0.25 / (324.0 + 4.0) * 2.0 / 328.0_f64.sqrt())
    ));
}

#[test]
fn instances_that_shine_are_met_by_chance_and_counted_once() {
    let mut builder = dark();
    let (lamp, floor_material) = (
        builder.material(lamp()),
        builder.material(shining(Color::Constant(Rgb::BLACK), Sidedness::Both)),
    );
    let triangle = |y: f32| Mesh {
        positions: vec![
            Vec3::new(-1.0, y, -1.0),
            Vec3::new(1.0, y, -1.0),
            Vec3::new(0.0, y, 1.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    builder.mesh("baked", triangle(3.0), lamp).expect("valid");
    let group = builder.group(vec![(triangle(1.0), floor_material)]).expect("valid");
    let there = place([1.0, 1.0, 0.0], [0.0; 3], [1.0; 3]).expect("a place");
    builder.instance("shared", group, there, Some(lamp));
    let scene = builder.build(AccelKind::Linear).expect("a scene");
    assert_eq!(scene.lights.count(), 1);
    let [light, cosine, both] = irradiances(&scene, &floor(0.3), 8000);
    assert!(
        cosine.z(&both) < 4.5 && light.mean() < both.mean(),
        "{light:?} {cosine:?} {both:?}"
    );
}
