//! Light linking: an object that a light does not light, against the scene without the light.

use std::path::Path;

use batch_render::{
    batch::{Job, Request},
    describe::{self, Source},
    film::Film,
    render::Control,
};

/// Two balls side by side and no floor, so that all light is direct; `left` are keys of the left ball, `lights` the lights.
fn describe_balls(
    render: &str,
    material: &str,
    left: &str,
    lights: &str,
) -> Result<describe::SceneDesc, describe::Diagnostics> {
    let text = format!(
        r#"
[render]
width = 32
height = 16
filter = "box"
{render}
[camera]
perspective = {{ eye = [0, 0, 8], target = [0, 0, 0], fov = 26 }}
[background]
color = 0.0
visible = false
group = "sky"
[material.ball]
{material}
[material.shine]
emitter = {{ radiance = 5 }}
[[object]]
name = "left"
material = "ball"
shape.sphere = {{ center = [-1.5, 0, 0], radius = 1 }}
{left}
[[object]]
material = "ball"
shape.sphere = {{ center = [1.5, 0, 0], radius = 1 }}
{lights}
"#
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.toml");
    describe::parse(Source::new(path, text))
}

fn try_shoot(render: &str, material: &str, left: &str, lights: &str) -> Result<Film, String> {
    let desc = describe_balls(render, material, left, lights).map_err(|e| e.to_string())?;
    let job = Job::new(desc, &Request::default()).map_err(|e| e.to_string())?;
    let scene = job.compile().map_err(|e| e.to_string())?;
    let film = job.render_frame(&mut job.scenes(scene), 0, &Control::default());
    Ok(film.expect("a film"))
}

fn shoot(render: &str, material: &str, left: &str, lights: &str) -> Film {
    try_shoot(render, material, left, lights).unwrap_or_else(|e| panic!("{e}"))
}

/// The mean light of the left and of the right half, the green channel.
fn halves(film: &Film) -> [f64; 2] {
    let half = |right: bool| {
        let pixels = film.beauty().iter().enumerate();
        let pixels = pixels.filter(|(i, _)| (i % 32 >= 16) == right);
        pixels.map(|(_, p)| f64::from(p[1])).sum::<f64>()
    };
    [half(false), half(true)]
}

const KEY: &str =
    "[[light]]\nname = 'key'\nrect = { position = [0, 4, 3], target = [0, 0, 0], size = [1, 1], power = 60 }";
const POINT: &str = "[[light]]\npoint = { position = [0, -3, 4], intensity = 6 }\ngroup = 'low'";
const SUN: &str = "[[light]]\nname = 'sun'\nsun = { direction = [0, -1, -2], irradiance = 0.5, angle = 5 }";
const LAMP: &str =
    "[[object]]\nname = 'lamp'\nmaterial = 'shine'\nshape.sphere = { center = [0, 2.5, 1], radius = 0.4 }";
const MATTE: &str = "matte = { albedo = 0.5 }";
const GLOSSY: &str = "principled = { base_color = 0.5, roughness = 0.3 }";

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.max(1e-9)
}

#[test]
fn a_light_that_is_left_out_leaves_the_object_as_without_it_and_others_as_with_it() {
    for (render, tolerance) in [
        ("samples = 64\nintegrator.path = { max_depth = 2 }", 0.02),
        (
            "samples = 64\nintegrator.path = { max_depth = 2, strategy = 'light' }",
            0.02,
        ),
        ("samples = 4\nintegrator.whitted = { max_depth = 2 }", 1e-4),
    ] {
        for (material, name, light, rest) in [
            (GLOSSY, "key", KEY, POINT),
            (MATTE, "sun", SUN, POINT),
            (GLOSSY, "low", POINT, KEY),
            (MATTE, "lamp", LAMP, POINT),
            (GLOSSY, "lamp", LAMP, SUN),
        ] {
            let both = format!("{light}\n{rest}");
            let linked = halves(&shoot(render, material, &format!("exclude_lights = ['{name}']"), &both));
            let [with, without] = [&both, rest].map(|lights| halves(&shoot(render, material, "", lights)));
            let case = format!("{render} {material} {name}: {linked:?} {with:?} {without:?}");
            assert!(near(linked[0], without[0], tolerance), "{case}");
            assert!(near(linked[1], with[1], tolerance), "{case}");
            assert!(with[0] > 1.05 * without[0], "{case}");
        }
    }
}

#[test]
fn all_lights_by_name_are_all_lights() {
    let render = "samples = 4\nintegrator.path = { max_depth = 3 }";
    let lights = format!("{KEY}\n{POINT}\n{SUN}\n{LAMP}");
    let [named, all] = ["lights = ['key', 'low', 'lamp', 'sun', 'sky']", ""].map(|left| {
        let film = shoot(render, GLOSSY, left, &lights);
        film.beauty().to_vec()
    });
    assert_eq!(named, all);
}

#[test]
fn an_object_without_lights_is_black_whichever_way_light_is_found() {
    let all = format!("{KEY}\n{POINT}\n{SUN}\n{LAMP}");
    for strategy in ["mis", "light", "bsdf"] {
        let render = format!("samples = 4\nintegrator.path = {{ max_depth = 2, strategy = '{strategy}' }}");
        for material in [MATTE, GLOSSY, "mirror = { reflectance = 0.9 }"] {
            let [dark, lit] = ["lights = []", ""].map(|left| halves(&shoot(&render, material, left, &all)));
            assert_eq!(dark[0], 0.0, "{strategy} {material}");
            assert!(lit[0] > 0.0, "{strategy} {material}");
        }
    }
}

#[test]
fn techniques_agree_where_lights_are_linked() {
    let mean = |strategy: &str| {
        let render = format!("samples = 512\nintegrator.path = {{ max_depth = 2, strategy = '{strategy}' }}");
        let linked = "exclude_lights = ['sun', 'lamp']";
        halves(&shoot(&render, GLOSSY, linked, &format!("{KEY}\n{SUN}\n{LAMP}")))
    };
    let [mis, light] = ["mis", "light"].map(mean);
    for (a, b) in mis.into_iter().zip(light) {
        assert!(near(a, b, 0.01), "{a} {b}");
    }
}

#[test]
fn a_group_is_meant_by_its_name_with_or_without_its_word() {
    let render = "samples = 4\nintegrator.path = { max_depth = 2 }";
    let lights = format!("{KEY}\n{POINT}");
    let [short, long] = ["low", "group:low"].map(|name| {
        let film = shoot(render, MATTE, &format!("exclude_lights = ['{name}']"), &lights);
        film.beauty().to_vec()
    });
    assert_eq!(short, long);
    let unnamed = shoot(render, MATTE, "exclude_lights = ['light 2']", &lights);
    assert_eq!(unnamed.beauty(), short);
    assert_ne!(shoot(render, MATTE, "", &lights).beauty(), short);
}

#[test]
fn an_unknown_light_is_an_error_with_the_nearest_name() {
    for (given, nearest) in [
        ("lights = ['kay']", "did you mean `key`?"),
        ("exclude_lights = ['group:lov']", "did you mean `group:low`?"),
        ("lights = ['back-ground']", "did you mean `background`?"),
    ] {
        let message = try_shoot("", MATTE, given, &format!("{KEY}\n{POINT}")).expect_err("unknown");
        assert!(
            message.contains("unknown light `") && message.contains(nearest),
            "{message}"
        );
    }
    // What emits no light is none.
    assert!(try_shoot("", MATTE, "lights = ['left']", KEY).is_err());
}
