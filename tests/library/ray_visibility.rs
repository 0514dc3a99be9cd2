//! Objects that only some rays meet, and holdouts: against the scene with the object and the scene without it.

use std::path::Path;

use batch_render::{
    batch::{Job, Request},
    describe::{self, Source},
    film::Film,
    render::Control,
};

/// A floor, and a ball beside a lamp; `render` stands in `[render]`, `floor` is its material, `ball` are keys of the ball.
fn shoot(render: &str, floor: &str, ball: &str) -> Film {
    let text = format!(
        r#"
[render]
width = 32
height = 24
samples = 4
filter = "box"
{render}
[output]
aovs = ["depth", "objectId"]
[camera]
perspective = {{ eye = [0, 3, 6], target = [0, 0.5, 0], fov = 45 }}
[background]
color = [0.1, 0.2, 0.3]
[material.floor]
{floor}
[material.ball]
matte = {{ albedo = [0.8, 0.2, 0.1] }}
[[object]]
material = "floor"
shape.quad = {{ corners = [[-9, 0, 9], [9, 0, 9], [9, 0, -9], [-9, 0, -9]] }}
[[object]]
name = "ball"
material = "ball"
shape.sphere = {{ center = [0, 0.8, 0], radius = 0.8 }}
{ball}
[[light]]
rect = {{ position = [2, 4, 1], target = [0, 0, 0], size = [1, 1], power = 90 }}
"#
    );
    let desc = describe::parse(Source::new(Path::new("scene.toml").into(), text)).unwrap_or_else(|e| panic!("{e}"));
    let job = Job::new(desc, &Request::default()).unwrap_or_else(|e| panic!("{e}"));
    let scene = job.compile().unwrap_or_else(|e| panic!("{e}"));
    job.render_frame(&mut job.scenes(scene), 0, &Control::default())
        .expect("a film")
}

const MATTE: &str = "matte = { albedo = 0.6 }";
const MIRROR: &str = "mirror = { reflectance = 0.9 }";
const DIRECT: &str = "integrator.path = { max_depth = 2, strategy = 'light' }";

/// The objects that pixels see, 1 for the floor and 2 for the ball.
fn ids(film: &Film) -> Vec<u32> {
    let values = &film.plane("objectId").expect("a pass").values;
    values.iter().map(|id| id.to_bits()).collect()
}

fn depths(film: &Film) -> &[f32] {
    &film.plane("depth").expect("a pass").values
}

/// The pixels whose samples all miss the ball: it and its edge are within a pixel of those whose centre sees it.
fn without_ball(full: &Film) -> Vec<usize> {
    let ids = ids(full);
    let sees = |x: i32, y: i32| (0..32).contains(&x) && (0..24).contains(&y) && ids[(y * 32 + x) as usize] == 2;
    let near = |x: i32, y: i32| (-1..=1).any(|i| (-1..=1).any(|k| sees(x + i, y + k)));
    let pixels: Vec<usize> = (0..32 * 24)
        .filter(|i| !near((i % 32) as i32, (i / 32) as i32))
        .collect();
    assert!(pixels.len() > 400 && pixels.len() < 32 * 24 - 40);
    pixels
}

fn same(a: &Film, b: &Film, pixels: &[usize]) -> usize {
    pixels.iter().filter(|&&i| a.beauty()[i] == b.beauty()[i]).count()
}

#[test]
fn an_object_that_no_ray_meets_is_not_there() {
    let hidden = "ray_visibility = { camera = false, diffuse = false, reflection = false, transmission = false, shadow = false }";
    for (render, floor) in [("", MATTE), ("", MIRROR), ("integrator.whitted = {}", MIRROR)] {
        let (hidden, gone) = (shoot(render, floor, hidden), shoot(render, floor, "visible = false"));
        assert_eq!(hidden.beauty(), gone.beauty());
        assert_eq!(ids(&hidden), ids(&gone));
    }
}

#[test]
fn the_camera_does_not_see_an_object_that_is_hidden_from_it_alone() {
    let (full, gone) = (shoot("", MATTE, ""), shoot("", MATTE, "visible = false"));
    let hidden = shoot("", MATTE, "ray_visibility.camera = false");
    assert_eq!((ids(&hidden), depths(&hidden)), (ids(&gone), depths(&gone)));
    // It throws its shadow and its red light.
    let around = without_ball(&full);
    assert_eq!(same(&hidden, &full, &around), around.len());
    assert!(same(&hidden, &gone, &around) < around.len() - 20);
}

#[test]
fn an_object_without_a_shadow_blocks_no_light() {
    let (full, gone) = (shoot(DIRECT, MATTE, ""), shoot(DIRECT, MATTE, "visible = false"));
    let lit = shoot(DIRECT, MATTE, "ray_visibility.shadow = false");
    let around = without_ball(&full);
    // The sky is found by chance alone: rays of the floor meet the ball.
    let below = |film: &Film| around.iter().map(|i| f64::from(film.beauty()[*i][0])).sum::<f64>();
    assert!(below(&lit) > below(&full) * 1.01 && below(&lit) <= below(&gone));
    let hidden = "ray_visibility = { shadow = false, diffuse = false }";
    assert_eq!(same(&shoot(DIRECT, MATTE, hidden), &gone, &around), around.len());
}

#[test]
fn mirrors_do_not_show_an_object_that_is_hidden_from_reflections() {
    let (full, gone) = (shoot("", MIRROR, ""), shoot("", MIRROR, "visible = false"));
    let hidden = shoot("", MIRROR, "ray_visibility.reflection = false");
    let around = without_ball(&full);
    assert_eq!(same(&hidden, &gone, &around), around.len());
    assert!(same(&full, &gone, &around) < around.len());
}

#[test]
fn what_lights_bring_does_not_depend_on_the_strategy_where_rays_meet_different_objects() {
    let mean = |strategy: &str, ball: &str| {
        let render = format!("integrator.path = {{ max_depth = 2, strategy = '{strategy}' }}");
        let film = shoot(&render, MATTE, ball);
        film.beauty().iter().map(|p| f64::from(p[1])).sum::<f64>()
    };
    for ball in ["ray_visibility.shadow = false", "ray_visibility.diffuse = false"] {
        let light = mean("light", ball);
        assert_eq!((mean("mis", ball), mean("bsdf", ball)), (light, light));
    }
}

#[test]
fn a_holdout_is_a_hole_in_the_picture_and_a_body_in_the_scene() {
    let (full, hole) = (shoot("", MATTE, ""), shoot("", MATTE, "holdout = true"));
    let around = without_ball(&full);
    assert_eq!(same(&hole, &full, &around), around.len());
    let mut inside = 0;
    for (i, id) in ids(&full).into_iter().enumerate().filter(|(_, id)| *id == 2) {
        assert_ne!(ids(&hole)[i], id);
        inside += usize::from(hole.beauty()[i] == [0.0; 4]);
    }
    assert!(inside > 30, "{inside}");
}
