//! Pictures that are no light: depth, normals, parameters, names, and how much of the sky is seen.

mod common;

use std::{path::Path, sync::Arc};

use batch_render::{
    accel::AccelKind,
    batch::{Plan, Request},
    compile,
    describe::{self, Source},
    film::Film,
    math::Vec3,
    render::{self, Watch},
};
use common::Folder;

const SIDE: u32 = 16;
/// At (0, 0, 5), looking along -z; the picture's edges are at 45 degrees.
const CAMERA: &str = "[camera]\nperspective = { eye = [0, 0, 5], target = [0, 0, 0], fov = 90 }\n";
const MATERIAL: &str = "[material.m]\nmatte = { albedo = [0.5, 0.5, 0.5] }\n";

/// The picture of a scene by the integrator that `render` names.
fn shoot(render: &str, scene: &str) -> Film {
    let text = format!("[render]\nwidth = {SIDE}\nheight = {SIDE}\n{render}\n{MATERIAL}{scene}");
    let source = Source {
        path: Path::new("scene.toml").into(),
        text: Arc::from(text.as_str()),
    };
    let desc = describe::parse(source).unwrap_or_else(|e| panic!("{e}"));
    let scene = compile::scene(&desc, AccelKind::default()).unwrap_or_else(|e| panic!("{e}"));
    let plan = Plan::new(&desc, &Request::default()).unwrap_or_else(|e| panic!("{e}"));
    let camera = plan.frames[0].shot.camera(0.0);
    render::frame(&scene, &camera, &plan.integrator, &plan.settings, &Watch::default()).expect("a picture")
}

/// The direction of the ray through a pixel's centre, 1 m long along the line of sight.
fn through(pixel: usize) -> Vec3 {
    let at = |n: u32| (n as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
    Vec3::new(at(pixel as u32 % SIDE), -at(pixel as u32 / SIDE), -1.0)
}

#[test]
fn depth_and_distance_put_every_pixel_on_the_plane_that_it_sees() {
    let plane = "[[object]]\nmaterial = \"m\"\nshape.plane = { point = [0, 0, -3], normal = [0.2, 0.1, 1] }\n";
    // A lens and samples have no say.
    let camera = CAMERA.replace("fov", "aperture_radius = 0.2, fov");
    for camera in [CAMERA, &camera] {
        let film = shoot("samples = 16\nintegrator = \"depth\"", &format!("{camera}{plane}"));
        for (i, [depth, distance, _, alpha]) in film.pixels.iter().enumerate() {
            let at_one = through(i);
            let by_depth = Vec3::new(0.0, 0.0, 5.0) + at_one * *depth;
            let by_distance = Vec3::new(0.0, 0.0, 5.0) + at_one.normalize() * *distance;
            for p in [by_depth, by_distance] {
                let above = (p - Vec3::new(0.0, 0.0, -3.0)).dot(Vec3::new(0.2, 0.1, 1.0));
                assert!(above.abs() < 1e-4, "{i}: {p}");
            }
            assert_eq!(*alpha, 1.0);
        }
    }
}

#[test]
fn where_nothing_is_met_it_is_far_away_and_transparent() {
    let disk = "[[object]]\nmaterial = \"m\"\nshape.disk = { center = [0, 0, 0], normal = [0, 0, 1], radius = 2 }\n";
    let film = shoot("integrator = \"depth\"", &format!("{CAMERA}{disk}"));
    assert_eq!(film.pixels[0], [1e10, 1e10, 0.0, 0.0]);
    let middle = film.pixels[(SIDE / 2 * SIDE + SIDE / 2) as usize];
    assert_eq!((middle[0], middle[3]), (5.0, 1.0));
    let film = shoot("integrator = \"normals\"", &format!("{CAMERA}{disk}"));
    assert_eq!(film.pixels[0], [0.0; 4]);
}

#[test]
fn normals_are_the_authored_ones_in_world_space_with_their_signs() {
    for normal in [Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.48, 0.6, -0.64)] {
        let [x, y, z] = normal.to_array();
        let plane = format!(
            "[[object]]\nmaterial = \"m\"\nshape.plane = {{ point = [0, 0, -30], normal = [{x}, {y}, {z}] }}\n"
        );
        let film = shoot("integrator = \"normals\"", &format!("{CAMERA}{plane}"));
        let seen: Vec<_> = film.pixels.iter().filter(|p| p[3] == 1.0).collect();
        assert!(seen.len() > 100);
        for [r, g, b, _] in seen {
            assert!((Vec3::new(*r, *g, *b) - normal).length() < 1e-6);
        }
    }
}

#[test]
fn parameters_of_a_quad_run_from_corner_to_corner() {
    let quad = "[[object]]\nmaterial = \"m\"\n\
                shape.quad = { corners = [[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]] }\n";
    let film = shoot("integrator = \"uv\"", &format!("{CAMERA}{quad}"));
    for (i, [u, v, ..]) in film.pixels.iter().enumerate() {
        let d = through(i);
        assert!(
            (u - (0.5 + 0.5 * d.x)).abs() < 1e-5 && (v - (0.5 + 0.5 * d.y)).abs() < 1e-5,
            "{i}: {u} {v}"
        );
    }
}

#[test]
fn a_name_has_the_same_hash_in_every_scene_whatever_its_number_is() {
    let ball = |name: &str, x: i32| {
        format!(
            "[[object]]\nname = \"{name}\"\nmaterial = \"m\"\nshape.sphere = {{ center = [{x}, 0, 0], radius = 1 }}\n"
        )
    };
    let shot = |a: &str, b: &str| {
        let film = shoot(
            "integrator = \"object_id\"",
            &format!("{CAMERA}{}{}", ball(a, -2), ball(b, 2)),
        );
        let row = (SIDE / 2 * SIDE) as usize;
        let seen: Vec<[f32; 2]> = film.pixels[row..row + SIDE as usize]
            .iter()
            .filter(|p| p[3] > 0.0)
            .map(|p| [p[0], p[1]])
            .collect();
        (seen[0], seen[seen.len() - 1])
    };
    let (hello, bunny) = shot("hello", "bunny");
    assert_eq!([hello[0], bunny[0]], [1.0, 2.0]);
    assert_eq!([hello[1].to_bits(), bunny[1].to_bits()], [0x248b_fa47, 0x1385_1a76]);
    let (bunny_again, hello_again) = shot("bunny", "hello");
    assert_eq!([hello_again[1], bunny_again[1]], [hello[1], bunny[1]]);
    assert_eq!([hello_again[0], bunny_again[0]], [2.0, 1.0]);
}

/// How much of the sky the floor sees at the origin, where the camera looks at nothing else.
fn open_sky(integrator: &str, above: &str) -> f32 {
    let camera = "[camera]\nperspective = { eye = [0.2, 0.2, 0], target = [0, 0, 0], fov = 0.5 }\n";
    let floor = "[[object]]\nmaterial = \"m\"\nshape.plane = { point = [0, 0, 0], normal = [0, 1, 0] }\n";
    let above = format!("[[object]]\nmaterial = \"m\"\nshape.{above}\n");
    let film = shoot(
        &format!("samples = 32\nintegrator.occlusion = {{ {integrator} }}"),
        &format!("{camera}{floor}{above}"),
    );
    film.pixels.iter().map(|p| p[0]).sum::<f32>() / film.pixels.len() as f32
}

#[test]
fn occlusion_under_disks_planes_and_domes_has_its_analytic_value() {
    let disk = "disk = { center = [0, 1, 0], normal = [0, -1, 0], radius = 1 }";
    let ceiling = "plane = { point = [0, 1, 0], normal = [0, -1, 0] }";
    let dome = "sphere = { center = [0, 0, 0], radius = 1 }";
    // The form factor of a disk of radius r at height h is r^2 / (r^2 + h^2); a ceiling hides what is nearer than the
    // distance, up to the cosine h / distance.
    for (integrator, above, expected) in [
        ("samples = 4", disk, 0.5),
        ("samples = 4, distance = 2", ceiling, 0.25),
        ("samples = 2", ceiling, 0.0),
        ("distance = 0.999", ceiling, 1.0),
        ("distance = 0", dome, 0.0),
        ("distance = 0.9", dome, 1.0),
    ] {
        let found = open_sky(integrator, above);
        assert!(
            (found - expected).abs() < 0.01,
            "{integrator}, {above}: {found} for {expected}"
        );
    }
}

#[test]
fn files_hold_the_numbers_whole_and_pictures_show_them() {
    let folder = Folder::new();
    let scene = format!(
        "{CAMERA}{MATERIAL}[[object]]\nname = \"bunny\"\nmaterial = \"m\"\n\
         shape.disk = {{ center = [0, 0, 0], normal = [0, 0, 1], radius = 2 }}\n"
    );
    folder.write("s.toml", &scene);
    let common = ["--resolution", "16x16", "--progress", "none"];
    for (integrator, names) in [
        ("depth", &["depth.Z", "distance.Y"][..]),
        ("normals", &["N.X", "N.Y", "N.Z"]),
        ("uv", &["UV.U", "UV.V"]),
        ("object_id", &["objectId.Y", "objectHash.Y"]),
    ] {
        let args = ["s.toml", "--integrator", integrator, "-o", "f.exr", "-o", "f.png"];
        folder.succeed(&[&args[..], &common].concat());
        let image = exr::prelude::read_first_flat_layer_from_file(folder.path("f.exr")).expect("an EXR");
        for name in names {
            let channel = image
                .layer_data
                .channel_data
                .list
                .iter()
                .find(|c| c.name.to_string() == *name);
            let channel = channel.unwrap_or_else(|| panic!("{integrator}: no {name}"));
            let first: f32 = channel.sample_data.values_as_f32().next().expect("a pixel");
            let nothing = if integrator == "depth" { 1e10 } else { 0.0 };
            assert_eq!(first, nothing, "{name}");
        }
        let picture = image::load_from_memory(&folder.read("f.png"))
            .expect("a PNG")
            .into_rgba8();
        assert_eq!(picture.get_pixel(0, 0).0[3], 0, "{integrator}");
        assert_eq!(picture.get_pixel(8, 8).0[3], 255, "{integrator}");
    }
}
