//! Shadow catchers over a plate, against the picture of the plate itself with the objects on it.

use std::path::Path;

use batch_render::{
    batch::{Job, Request},
    describe::{self, Source},
    film::Film,
    render::Control,
};

const WIDTH: usize = 32;
const HEIGHT: usize = 24;

/// A floor that fills the picture, and things on it.
struct Set<'a> {
    render: &'a str,
    light: &'a str,
    floor: &'a str,
    /// The keys of the floor and of the ball.
    role: &'a str,
    ball: &'a str,
}

const SET: Set<'static> = Set {
    render: "",
    light: CONSTANT,
    floor: MATTE,
    role: "",
    ball: "",
};

const MATTE: &str = "matte = { albedo = 0.5 }";
const GLOSSY: &str = "principled = { base_color = [0.3, 0.4, 0.5], roughness = 0.25 }";
const CATCHER: &str = "shadow_catcher = true";
const GONE: &str = "visible = false";

const CONSTANT: &str = "[background]\ncolor = [0.8, 0.8, 0.8]\nvisible = false";
const SKY: &str = "[background]\nenvironment = { file = 'scenes/kinds/sky.hdr' }\nvisible = false";
const RECT: &str =
    "[[light]]\nrect = { position = [2, 4, 1], target = [0, 0, 0], size = [1, 1], power = 90, camera = false }";

fn shoot(set: &Set<'_>) -> Film {
    shoot_crop(set, None)
}

fn shoot_crop(set: &Set<'_>, crop: Option<[u32; 4]>) -> Film {
    let Set {
        render,
        light,
        floor,
        role,
        ball,
    } = set;
    let filter = if render.contains("filter") {
        ""
    } else {
        "filter = 'box'"
    };
    let text = format!(
        r#"
[render]
width = {WIDTH}
height = {HEIGHT}
{filter}
{render}
[camera]
perspective = {{ eye = [0, 5, 4], target = [0, 0.3, 0], fov = 40 }}
{light}
[material.floor]
{floor}
[material.ball]
matte = {{ albedo = [0.8, 0.2, 0.1] }}
[[object]]
material = "floor"
shape.quad = {{ corners = [[-9, 0, 9], [9, 0, 9], [9, 0, -9], [-9, 0, -9]] }}
{role}
[[object]]
name = "ball"
material = "ball"
shape.sphere = {{ center = [0, 0.9, 0], radius = 0.8 }}
{ball}
"#
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.toml");
    let desc = describe::parse(Source::new(path, text)).unwrap_or_else(|e| panic!("{e}"));
    let request = Request {
        crop,
        ..Request::default()
    };
    let job = Job::new(desc, &request).unwrap_or_else(|e| panic!("{e}"));
    let scene = job.compile().unwrap_or_else(|e| panic!("{e}"));
    job.render_frame(&mut job.scenes(scene), 0, &Control::default())
        .expect("a film")
}

/// A picture over a plate, whose pixels `plate` returns.
fn over(picture: &Film, plate: impl Fn(usize) -> [f32; 4]) -> Vec<[f32; 3]> {
    let pixels = picture.beauty().iter().enumerate();
    let pixels = pixels.map(|(i, p)| std::array::from_fn(|c| p[c] + (1.0 - p[3]) * plate(i)[c]));
    pixels.collect()
}

/// The largest relative difference of the means of blocks of 8 x 8 pixels.
fn difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let mean = |picture: &[[f32; 3]], block: usize, c: usize| {
        let corner = block / (WIDTH / 8) * 8 * WIDTH + block % (WIDTH / 8) * 8;
        let pixels = (0..64).map(|i| f64::from(picture[corner + i / 8 * WIDTH + i % 8][c]));
        pixels.sum::<f64>() / 64.0
    };
    let all = (0..WIDTH * HEIGHT / 64).flat_map(|block| (0..3).map(move |c| (block, c)));
    let all = all.map(|(block, c)| (mean(a, block, c), mean(b, block, c)));
    all.map(|(a, b)| (a - b).abs() / b).fold(0.0, f64::max)
}

/// The pixels that show the floor alone.
fn floor_pixels(set: &Set<'_>) -> Vec<usize> {
    let objects = shoot(&Set {
        role: GONE,
        light: CONSTANT,
        ..*set
    });
    let is_floor = |i: &usize| objects.beauty()[*i][3] == 0.0;
    let pixels: Vec<usize> = (0..WIDTH * HEIGHT).filter(is_floor).collect();
    assert!(pixels.len() > WIDTH * HEIGHT / 2, "{}", pixels.len());
    pixels
}

fn rgb(film: &Film) -> Vec<[f32; 3]> {
    film.beauty().iter().map(|&[r, g, b, _]| [r, g, b]).collect()
}

/// Asserts that a catcher over the picture of the floor alone is the picture of the floor with the ball, and returns how far it is from it with
/// another seed for the floor.
fn assert_composes(samples: u32, set: Set<'_>) -> f64 {
    let render = format!("samples = {samples}\n{}", set.render);
    let set = Set { render: &render, ..set };
    let caught = shoot(&Set { role: CATCHER, ..set });
    let whole = rgb(&shoot(&set));
    let same = shoot(&Set { ball: GONE, ..set });
    // Where the ball covers a part of a pixel, the plate has other samples.
    let is_near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-5 * (1.0 + b);
    let pixels = over(&caught, |i| same.beauty()[i]);
    let pixels = pixels.iter().zip(&whole);
    let exact = pixels.filter(|(found, expected)| found.iter().zip(*expected).all(is_near));
    let exact = exact.count();
    assert!(exact > WIDTH * HEIGHT * 9 / 10, "{exact}");
    // Alpha and light are not those of an ordinary floor.
    let alphas: f32 = caught.beauty().iter().map(|p| p[3]).sum();
    assert!((1.0..0.6 * (WIDTH * HEIGHT) as f32).contains(&alphas), "{alphas}");
    let other_seed = format!("{render}\nseed = 7");
    let other = shoot(&Set {
        render: &other_seed,
        ball: GONE,
        ..set
    });
    difference(&over(&caught, |i| other.beauty()[i]), &whole)
}

#[test]
fn a_catcher_over_the_plate_is_the_plate_with_the_object_on_it() {
    for (samples, light) in [(64, CONSTANT), (256, SKY), (64, RECT)] {
        let difference = assert_composes(samples, Set { light, ..SET });
        assert!(difference < 0.01, "{light}: {difference}");
    }
    let sun = "[[light]]\nsun = { direction = [-1, -2, 1], irradiance = 2 }";
    assert!(assert_composes(8, Set { light: sun, ..SET }) < 0.01);
    for render in ["integrator.whitted = { ambient = 0.2 }", "integrator.occlusion = {}"] {
        let difference = assert_composes(
            8,
            Set {
                render,
                light: RECT,
                ..SET
            },
        );
        assert!(difference < 0.03, "{render}: {difference}");
    }
}

#[test]
fn a_catcher_catches_reflections_and_the_light_of_what_shines() {
    let glossy = assert_composes(
        64,
        Set {
            light: SKY,
            floor: GLOSSY,
            ..SET
        },
    );
    assert!(glossy < 0.01, "{glossy}");
    let shines = "[material.lamp]\nemitter = { radiance = [9, 6, 3] }\n[[object]]\nmaterial = 'lamp'\nshape.sphere = { center = [1.6, 0.5, 0], radius = 0.2 }";
    let set = Set {
        light: CONSTANT,
        ball: shines,
        ..SET
    };
    let render = "samples = 16";
    let caught = shoot(&Set {
        render,
        role: CATCHER,
        ..set
    });
    let without = shoot(&Set {
        ball: GONE,
        render,
        ..set
    });
    let (whole, bare) = (rgb(&shoot(&Set { render, ..set })), rgb(&without));
    // Where the lamp adds more than the ball takes, nothing of the plate is covered.
    let mut brighter = floor_pixels(&Set { render, ..set });
    brighter.retain(|&i| whole[i].iter().zip(bare[i]).all(|(a, b)| *a > 1.02 * b));
    assert!(brighter.len() > 40);
    assert!(
        brighter
            .iter()
            .all(|&i| caught.beauty()[i][3] == 0.0 && caught.beauty()[i][0] > 0.0)
    );
}

#[test]
fn a_gray_shadow_scales_any_plate_by_the_ratio_of_the_light() {
    let render = "samples = 16\nintegrator.path = { max_depth = 2 }";
    for light in [CONSTANT, RECT] {
        let set = Set { render, light, ..SET };
        let caught = shoot(&Set { role: CATCHER, ..set });
        let [with, without] = [set.ball, GONE].map(|ball| shoot(&Set { ball, ..set }));
        let plate = |i: usize| [0.2 + 0.02 * (i % 7) as f32, 0.4, 0.1, 1.0];
        let expected: Vec<[f32; 3]> = (0..WIDTH * HEIGHT)
            .map(|i| std::array::from_fn(|c| plate(i)[c] * with.beauty()[i][c] / without.beauty()[i][c]))
            .collect();
        let found = over(&caught, plate);
        let floor = floor_pixels(&set);
        let shaded = floor.iter().filter(|&&i| caught.beauty()[i][3] > 0.2).count();
        assert!(shaded > 20, "{shaded}");
        for i in floor {
            assert!(
                found[i].iter().zip(expected[i]).all(|(a, b)| (a - b).abs() < 1e-4),
                "{i}"
            );
        }
    }
}

#[test]
fn without_objects_a_catcher_is_exactly_nothing() {
    let lights = format!("{SKY}\n{RECT}");
    for render in [
        "samples = 7",
        "samples = 7\nintegrator.whitted = {}",
        "samples = 5\nfilter = 'mitchell'",
    ] {
        let set = Set {
            render,
            light: &lights,
            floor: GLOSSY,
            ball: GONE,
            ..SET
        };
        let caught = shoot(&Set { role: CATCHER, ..set });
        assert!(caught.beauty().iter().all(|p| *p == [0.0; 4]), "{render}");
        let floor = shoot(&set);
        assert!(floor.beauty().iter().all(|p| p[3] == 1.0) && floor.beauty().iter().any(|p| p[0] > 0.1));
    }
    // A ball that is a catcher as well is a part of the plate, with its shadow.
    let set = Set {
        render: "samples = 7",
        light: &lights,
        ball: CATCHER,
        role: CATCHER,
        ..SET
    };
    assert!(shoot(&set).beauty().iter().all(|p| *p == [0.0; 4]));
}

#[test]
fn a_catcher_shows_the_same_bits_in_crops_and_with_adaptive_samples() {
    let render = "samples = 16\nsampler = 'sobol'";
    let set = Set {
        light: SKY,
        role: CATCHER,
        ..SET
    };
    let full = shoot(&Set { render, ..set });
    let crop = shoot_crop(&Set { render, ..set }, Some([9, 5, 27, 20]));
    assert_eq!(crop.beauty().len(), 18 * 15);
    for (i, pixel) in crop.beauty().iter().enumerate() {
        assert_eq!(*pixel, full.beauty()[(i / 18 + 5) * WIDTH + i % 18 + 9]);
    }
    // Samples that no noise stops are those of a fixed number.
    let adaptive = "samples = { min = 4, max = 16, threshold = 1e-9 }";
    assert_eq!(
        shoot(&Set {
            render: adaptive,
            ..set
        })
        .beauty(),
        full.beauty()
    );
}

#[test]
fn a_background_that_the_camera_sees_is_the_plate() {
    const PLATE: [f32; 3] = [0.2, 0.5, 0.3];
    for light in [CONSTANT, SKY] {
        let set = Set {
            light,
            render: "samples = 4",
            ..SET
        };
        let [with, without] = [set.ball, GONE].map(|ball| rgb(&shoot(&Set { ball, ..set })));
        let light = format!("{}\nbackdrop = {PLATE:?}", light.replace("visible = false", ""));
        let shown = shoot(&Set {
            role: CATCHER,
            light: &light,
            ..set
        });
        assert!(shown.beauty().iter().all(|pixel| pixel[3] == 1.0));
        for i in floor_pixels(&set) {
            for (c, plate) in PLATE.into_iter().enumerate() {
                let (w, o) = (with[i][c], without[i][c]);
                let expected = plate * (w / o).min(1.0) + (w - o).max(0.0) * (plate / o).min(1.0);
                let found = shown.beauty()[i][c];
                assert!((found - expected).abs() < 1e-5, "{i}: {found} {expected}");
                // What nothing changes has the bits of the background.
                assert!(w != o || found == plate, "{i}: {found}");
            }
        }
    }
}

#[test]
fn shadows_of_coloured_lights_are_nowhere_brighter_than_the_plate() {
    let lamp = |x: f32, color: &str| format!("[[light]]\npoint = {{ position = [{x}, 3, 1], intensity = {color} }}\n");
    let lights = lamp(-2.0, "[30, 0.3, 0.3]") + &lamp(2.0, "[0.1, 0.4, 40]");
    for plate in [0.02, 0.9] {
        let light = format!("{lights}[background]\nbackdrop = {plate}");
        let shown = shoot(&Set {
            render: "samples = 4\nintegrator.path = { max_depth = 2 }",
            light: &light,
            role: CATCHER,
            ..SET
        });
        let floor = floor_pixels(&SET);
        let of_floor = || floor.iter().map(|&i| shown.beauty()[i]);
        assert!(of_floor().all(|p| p[..3].iter().all(|v| *v <= plate)));
        for c in [0, 2] {
            let shaded = of_floor().filter(|p| p[c] < 0.5 * plate && p[2 - c] > 0.99 * plate);
            assert!(shaded.count() > 10, "{plate} {c}");
        }
    }
}

#[test]
fn halves_of_the_samples_are_catchers_too() {
    let set = Set {
        light: RECT,
        role: CATCHER,
        ..SET
    };
    let text = "samples = 8\n[output]\naovs = ['denoise']";
    let film = shoot(&Set { render: text, ..set });
    let values = |name: &str| film.plane(name).expect("a pass").values.clone();
    let (a, b, alphas) = (values("beauty_a"), values("beauty_b"), values("alpha_halves"));
    let mut shaded = 0;
    for (i, pixel) in film.beauty().iter().enumerate() {
        let alpha = 0.5 * (alphas[2 * i] + alphas[2 * i + 1]);
        assert!((alpha - pixel[3]).abs() < 0.15, "{i}: {alpha} {}", pixel[3]);
        assert!(a[3 * i] <= 1.0 && b[3 * i] <= 1.0);
        let bare = pixel[3] == 0.0 && pixel[0] == 0.0;
        assert!(!bare || (a[3 * i] == 0.0 && alphas[2 * i] == 0.0), "{i}");
        shaded += usize::from(pixel[3] > 0.2);
    }
    assert!(shaded > 20);
}
