//! Whole pictures: the same light, however it is looked for.

use std::{path::Path, sync::Arc};

use batch_render::{
    batch::{Job, Request},
    describe::{self, Source},
    render::{Control, Renderer, StillScene},
};

const SIDE: u32 = 12;

/// A floor and a glossy ball under one or more lights.
const STAGE: &str = r#"
[camera]
perspective = { eye = [0, 3, 6], target = [0, 0.6, 0], fov = 45 }

[material.floor]
matte = { albedo = [0.6, 0.6, 0.6] }
[material.ball]
phong = { color = [0.5, 0.4, 0.3], specular = 0.4, shininess = 30, two_sided = true }
[material.lamp]
emitter = { radiance = [6, 5, 4], two_sided = true }
[material.front]
emitter = { radiance = "texture.board", scale = 5 }
[texture.board]
checker = { a = [1, 1, 1], b = [0.1, 0.2, 0.4], scale = 4 }

[[object]]
material = "floor"
shape.quad = { corners = [[-4, 0, 4], [4, 0, 4], [4, 0, -4], [-4, 0, -4]] }
[[object]]
material = "ball"
shape.sphere = { center = [0, 0.7, 0], radius = 0.7 }
"#;

const LIGHTS: [(&str, &str); 8] = [
    (
        "one lamp, stretched",
        r#"
[[object]]
material = "lamp"
shape.sphere = { radius = 0.4 }
transform = { translate = [1.2, 1.8, 0.5], rotate = [0, 0, 40], scale = [2, 0.5, 1] }
"#,
    ),
    (
        "a shape of each kind",
        r#"
[[object]]
material = "lamp"
shape.sphere = { center = [-2, 1, 0], radius = 0.3 }
[[object]]
material = "front"
shape.quad = { corners = [[-1, 2.5, -1], [1, 2.5, -1], [1, 2.5, 1], [-1, 2.5, 1]] }
[[object]]
material = "front"
shape.disk = { center = [2, 1.2, 0], normal = [-1, -0.2, 0], radius = 0.5 }
[[object]]
material = "lamp"
shape.cuboid = { min = [-0.3, -0.2, -0.3], max = [0.3, 0.2, 0.3] }
transform = { translate = [1.5, 0.4, 1.5], rotate = [0, 30, 20], scale = [1, 2, 0.7] }
[[object]]
material = "front"
shape.cylinder = { base = [-1.5, 0.1, 1.5], radius = 0.2, height = 0.6 }
[[object]]
material = "lamp"
shape.cone = { base = [-0.5, 0, -2], radius = 0.4, height = 0.8 }
"#,
    ),
    (
        "a sun with size and points",
        r#"
[[light]]
sun = { direction = [-0.3, -1, -0.4], irradiance = 2, angle = 30 }
[[light]]
point = { position = [2, 2, 2], intensity = 4 }
[[light]]
spot = { position = [-2, 3, 1], target = [0, 0, 0], cone_angle = 40, intensity = 8 }
[background]
color = [0.1, 0.2, 0.3]
"#,
    ),
    (
        "a light of each kind with a surface",
        r#"
[[light]]
rect = { position = [-1.5, 2.5, 1], target = [0, 0.5, 0], size = [1.5, 0.6], power = 30, temperature = 3500 }
[[light]]
disk = { position = [2, 1.5, 0], direction = [-1, -0.4, 0], radius = 0.5, power = 8, spread = 0.6, two_sided = true }
[[light]]
sphere = { position = [0.9, 0.4, 1.4], radius = 0.3, radiance = [1, 2, 3], camera = true }
[[light]]
tube = { from = [-1, 1.2, -1.5], to = [1, 2.2, -1.5], radius = 0.1, power = 20 }
[[light]]
spot = { position = [0, 3, 1], target = [0, 0, 0], cone_angle = 40, penumbra_angle = 20, power = 60, radius = 0.4 }
[[light]]
point = { position = [-2, 1.5, -1], intensity = 2, radius = 0.3, reflections = false }
"#,
    ),
    (
        "wide lamps with narrow beams",
        r#"
[[light]]
rect = { position = [0, 2.6, 0], direction = [0.1, -1, 0], size = [4, 4], power = 60, spread = 0.3 }
[[light]]
disk = { position = [-2.5, 1.2, 0.5], direction = [1, -0.1, 0], radius = 2, power = 30, spread = 0.25, two_sided = true }
"#,
    ),
    (
        "lamps of IES files",
        r#"
[[light]]
disk = { position = [-1.2, 1.6, 1], direction = [0.3, -1, 0], radius = 0.4, ies = "scenes/kinds/wall-washer.ies", power = 40 }
[[light]]
rect = { position = [1.6, 1.5, -0.5], direction = [-1, -0.6, 0.2], size = [0.8, 0.5], ies = "scenes/kinds/wall-washer.ies", power = 20, two_sided = true }
[[light]]
spot = { position = [0, 3, 1], target = [0, 0, 0], cone_angle = 40, ies = "scenes/kinds/wall-washer.ies", power = 90, radius = 0.4 }
[[light]]
point = { position = [-2, 1.5, -1], ies = "scenes/kinds/wall-washer.ies", power = 20 }
"#,
    ),
    (
        "lamps with pictures",
        r#"
[texture.stripes]
image = { file = "scenes/assignment/stripes.bmp", wrap = "clamp" }
[[light]]
rect = { position = [-1.5, 2, 1], target = [0, 0.5, 0], size = [1.5, 0.9], power = 40, texture = "texture.stripes" }
[[light]]
disk = { position = [1.6, 1.5, 0.4], direction = [-1, -0.5, 0], radius = 0.5, radiance = 5, spread = 0.8, texture = "texture.board", two_sided = true }
[[light]]
rect = { position = [0, 1.5, -1.6], direction = [0, -0.4, 1], size = [2, 1], radiance = 3, texture = "texture.stripes", reflections = false }
"#,
    ),
    (
        "an environment and a lamp",
        r#"
[background]
environment = { file = "scenes/assignment/stripes.bmp", intensity = 2, rotate = [0, 60, 0] }
[[object]]
material = "lamp"
shape.disk = { center = [-1, 2, 0], normal = [0, -1, 0], radius = 0.5 }
"#,
    ),
];

/// A job of the stage with these lights.
fn job(lights: &str, strategy: &str, seed: u32) -> Job {
    let text = format!(
        "[render]\nwidth = {SIDE}\nheight = {SIDE}\nsamples = 16\nseed = {seed}\n\
         integrator.path = {{ max_depth = 3, strategy = \"{strategy}\" }}\n{STAGE}{lights}"
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.toml");
    let desc = describe::parse(Source::new(path, text)).expect("a scene");
    Job::new(desc, &Request::default()).expect("a job")
}

/// The pixels' green at 16 samples.
fn render(lights: &str, strategy: &str, seed: u32) -> Vec<f64> {
    let job = job(lights, strategy, seed);
    let mut scenes = job.scenes(job.compile().expect("compiles"));
    let film = job.render_frame(&mut scenes, 0, &Control::default()).expect("a film");
    film.beauty().iter().map(|p| f64::from(p[1])).collect()
}

/// The means of the whole picture and of its quarters.
fn means(pixels: &[f64]) -> [f64; 5] {
    let mut sums = [0.0; 5];
    let half = SIDE as usize / 2;
    for (i, v) in pixels.iter().enumerate() {
        let (x, y) = (i % SIDE as usize, i / SIDE as usize);
        sums[0] += v / 4.0;
        sums[1 + usize::from(x >= half) + 2 * usize::from(y >= half)] += v;
    }
    sums.map(|s| s / (half * half) as f64)
}

/// Mean and variance of the mean over some pictures.
fn statistics(pictures: &[[f64; 5]], part: usize) -> (f64, f64) {
    let n = pictures.len() as f64;
    let mean = pictures.iter().map(|p| p[part]).sum::<f64>() / n;
    let squares = pictures.iter().map(|p| (p[part] - mean).powi(2)).sum::<f64>();
    (mean, squares / (n - 1.0) / n)
}

#[test]
fn every_strategy_renders_the_same_picture() {
    const SEEDS: u32 = 10;
    for (name, lights) in LIGHTS {
        let by = |strategy: &str, first: u32| -> Vec<_> {
            (first..first + SEEDS)
                .map(|seed| means(&render(lights, strategy, seed)))
                .collect()
        };
        let [mis, light, bsdf] = [by("mis", 0), by("light", 100), by("bsdf", 200)];
        for part in 0..5 {
            let (mean, variance) = statistics(&mis, part);
            for (other, found) in [("light", &light), ("bsdf", &bsdf)] {
                let (m, v) = statistics(found, part);
                let z = (mean - m).abs() / (variance + v).sqrt().max(1e-9);
                // Ten pictures: Student's t with about 18 degrees of freedom, 70 comparisons.
                assert!(z < 4.8, "{name}, part {part}: mis {mean}, {other} {m}, {z} deviations");
            }
        }
        assert!(statistics(&mis, 0).0 > 0.01, "{name} is lit");
    }
}

/// The same three objects: which of them shine depends on the materials.
const OBJECTS: &str = r#"
[[object]]
material = "a"
shape.sphere = { center = [-1.5, 1, 0.5], radius = 0.3 }
[[object]]
material = "b"
shape.quad = { corners = [[-1, 2.5, -1], [1, 2.5, -1], [1, 2.5, 1], [-1, 2.5, 1]] }
[[object]]
material = "c"
shape.disk = { center = [2, 1.2, 0], normal = [-1, -0.2, 0], radius = 0.5 }
"#;

/// Each with other analytic lights, emitters and another background.
const SHADINGS: [&str; 3] = [
    r#"
[background]
color = [0.1, 0.2, 0.3]
[material]
a.emitter = { radiance = [6, 5, 4] }
b.matte = { albedo = 0.5 }
c.matte = { albedo = 0.2 }
[[light]]
point = { position = [2, 2, 2], intensity = 4 }
"#,
    r#"
[background]
environment = { file = "scenes/assignment/stripes.bmp", intensity = 2 }
[material]
a.mirror = { reflectance = 0.9 }
b.emitter = { radiance = [1, 2, 3], two_sided = true }
c.emitter = { radiance = "texture.board", scale = 9 }
[[light]]
spot = { position = [-2, 3, 1], target = [0, 0, 0], cone_angle = 40, intensity = 8 }
[[light]]
sun = { direction = [-0.3, -1, -0.4], irradiance = 2, angle = 30 }
"#,
    r#"
[background]
color = [0.4, 0.4, 0.4]
[material]
a.matte = { albedo = 0.3 }
b.matte = { albedo = 0.5 }
c.matte = { albedo = 0.2 }
"#,
];

#[test]
fn a_scene_whose_shading_is_replaced_looks_like_one_compiled_with_that_shading() {
    let jobs = SHADINGS.map(|shading| job(&format!("{shading}{OBJECTS}"), "mis", 3));
    let compiled = jobs.each_ref().map(|job| job.compile().expect("compiles"));
    for from in &compiled {
        for (job, to) in jobs.iter().zip(&compiled) {
            let replaced = from.with_shading(Arc::clone(&to.shading)).expect("as many materials");
            assert_eq!(replaced.lights.count(), to.lights.count());
            let (frame, control) = (&job.plan.frames[0], Control::default());
            let of = |scene| {
                let still = &mut StillScene(scene);
                (job.plan).render_frame(&Renderer::new(), still, (frame, &frame.camera), &control)
            };
            let [found, expected] = [&replaced, to].map(|scene| of(scene).expect("a film"));
            assert!(found.beauty() == expected.beauty());
        }
    }
}

#[test]
fn a_rect_light_lights_as_a_quad_that_emits() {
    let rect =
        "[[light]]\nrect = { position = [0, 3, 0], direction = [0, -1, 0], size = [1.2, 1.2], radiance = [6, 5, 4] }\n";
    let quad = "[material.down]\nemitter = { radiance = [6, 5, 4] }\n[[object]]\nmaterial = 'down'\n\
                shape.quad = { corners = [[-0.6, 3, 0.6], [-0.6, 3, -0.6], [0.6, 3, -0.6], [0.6, 3, 0.6]] }\n";
    for strategy in ["mis", "light", "bsdf"] {
        assert_eq!(render(rect, strategy, 3), render(quad, strategy, 3), "{strategy}");
    }
}
