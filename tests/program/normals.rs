//! Shading normals that are not those of the triangles: they neither darken a surface nor cut facets out of it.

use std::{f32::consts::PI, fmt::Write};

use crate::common::Folder;
use batch_render::math::{
    Vec2,
    trig::{cos, sin},
};

const WIDTH: usize = 80;
const HEIGHT: usize = 60;
/// The width and height of pictures of a box.
const BOX: usize = 60;
/// The width of their pixels in m.
const PIXEL: f32 = 2.4 / BOX as f32;
const CAMERA: &str = "[camera]\nperspective = { eye = [0, 0.6, 5], target = [0, 0, 0], fov = 30 }\n";
const SUN: &str =
    "[background]\ncolor = [0, 0, 0]\n[[light]]\nsun = { direction = [-1, -0.4, -0.3], irradiance = 3 }\n";

/// A smooth ball of few triangles, as an OBJ file, with normals outwards (1) or inwards (-1).
fn ball_with_normals(side: f32) -> String {
    let (around, down) = (12, 8);
    let mut text = String::new();
    for ring in 0..=down {
        for i in 0..=around {
            let (theta, phi) = (PI * ring as f32 / down as f32, 2.0 * PI * i as f32 / around as f32);
            let [x, y, z] = [sin(theta) * cos(phi), cos(theta), -sin(theta) * sin(phi)];
            let [nx, ny, nz] = [x, y, z].map(|v| v * side);
            writeln!(text, "v {x} {y} {z}\nvn {nx} {ny} {nz}").expect("a string");
        }
    }
    for ring in 0..down {
        for i in 1..=around {
            let (a, b) = (ring * (around + 1) + i, (ring + 1) * (around + 1) + i);
            let corners = [a, b, b + 1, a + 1].map(|v| format!("{v}//{v}"));
            writeln!(text, "f {}", corners.join(" ")).expect("a string");
        }
    }
    text
}

/// The picture of a smooth ball of few triangles, by a program with these further arguments.
fn render_ball(render: &str, material: &str, world: &str, args: &[&str]) -> Vec<[f32; 3]> {
    render_mesh(&ball_with_normals(1.0), render, material, world, args)
}

fn render_mesh(obj: &str, render: &str, material: &str, world: &str, args: &[&str]) -> Vec<[f32; 3]> {
    let folder = Folder::new();
    folder.write("ball.obj", obj);
    folder.write(
        "s.toml",
        &format!(
            "[render]\nwidth = {WIDTH}\nheight = {HEIGHT}\n{render}\n{CAMERA}{world}\n\
             [material.m]\n{material}\n[[object]]\nmaterial = \"m\"\nshape.mesh = {{ file = \"ball.obj\" }}\n"
        ),
    );
    folder.succeed(&[&["s.toml", "--progress", "none", "-o", "f.exr"], args].concat());
    pixels(&folder)
}

/// The colours or normals of the picture "f.exr".
fn pixels(folder: &Folder) -> Vec<[f32; 3]> {
    let image = exr::prelude::read_first_flat_layer_from_file(folder.path("f.exr")).expect("an EXR");
    let channels = &image.layer_data.channel_data.list;
    let colors = [["R", "G", "B"], ["N.X", "N.Y", "N.Z"]];
    let plane = |name: &str| channels.iter().find(|c| c.name.eq(name));
    let found = colors.into_iter().find(|names| plane(names[0]).is_some());
    let [r, g, b] = found.expect("three channels").map(|name| {
        let samples = &plane(name).expect("a channel").sample_data;
        samples.values_as_f32().collect::<Vec<_>>()
    });
    r.iter().zip(&g).zip(&b).map(|((r, g), b)| [*r, *g, *b]).collect()
}

fn path(samples: u32, settings: &str) -> String {
    format!("samples = {samples}\nintegrator.path = {{ {settings} }}")
}

#[test]
fn a_smooth_ball_of_few_triangles_is_lit_as_its_normals_say() {
    let whitted = "samples = 1\nintegrator.whitted = { max_depth = 2, ambient = 0 }";
    for render in [&path(1, "max_depth = 2"), whitted] {
        let material = "matte = { albedo = 0.8 }";
        let seen = render_ball(render, material, SUN, &[]);
        let normals = render_ball(render, material, SUN, &["--show", "N"]);
        let sun = [1.0, 0.4, 0.3].map(|x: f32| x / 1.25_f32.sqrt());
        let mut lit = 0;
        for (seen, n) in seen.iter().zip(&normals) {
            let cos = n[0] * sun[0] + n[1] * sun[1] + n[2] * sun[2];
            // At the outline normals that point away are turned to the camera.
            let to_eye = [-n[0], 0.6 - n[1], 5.0 - n[2]];
            if n[0] * to_eye[0] + n[1] * to_eye[1] + n[2] * to_eye[2] < 0.1 {
                continue;
            }
            let expected = 3.0 * 0.8 / PI * cos.max(0.0);
            assert!(
                (seen[0] - expected).abs() < 2e-3,
                "{render}: {seen:?} is not {expected} at {n:?}"
            );
            lit += usize::from(cos > 0.0);
        }
        assert!(lit > 500, "{lit}");
    }
}

#[test]
fn normals_the_wrong_way_round_change_nothing() {
    let whitted = "samples = 4\nintegrator.whitted = { max_depth = 4, ambient = 0 }";
    for render in [path(4, "max_depth = 4"), whitted.to_owned()] {
        for material in [
            "matte = { albedo = 0.8 }",
            "mirror = { reflectance = 1 }",
            "glass = { ior = 1.5 }",
        ] {
            let seen = |side| render_mesh(&ball_with_normals(side), &render, material, SUN, &[]);
            assert!(seen(1.0) == seen(-1.0), "{render}, {material}");
        }
    }
}

#[test]
fn a_smooth_ball_of_few_triangles_loses_no_light_in_a_white_furnace() {
    let white = "[background]\ncolor = [1, 1, 1]\n";
    for (material, least) in [
        ("mirror = { reflectance = 1 }", 0.98),
        ("matte = { albedo = 1 }", 0.98),
        // These have noise.
        ("metal = { color = [1, 1, 1], edge = [1, 1, 1], roughness = 0.1 }", 0.95),
        ("principled = { base_color = 1, metallic = 1, roughness = 0.1 }", 0.95),
        ("principled = { base_color = 1, metallic = 1, roughness = 0 }", 0.98),
        // Total reflection must not hold light inside.
        ("glass = { ior = 1.5 }", 0.9),
        (
            "principled = { base_color = 1, transmission = 1, roughness = 0, thickness = 1 }",
            0.9,
        ),
    ] {
        let seen = render_ball(&path(32, "max_depth = 64"), material, white, &[]);
        let darkest = seen.iter().map(|p| p[0]).fold(f32::INFINITY, f32::min);
        assert!(darkest >= least, "{material}: {darkest}");
    }
}

/// A box of 2 m with eight corners, smooth or not, seen from above, of an object with this `transform`.
fn render_box(smooth: &str, transform: &str, world: &str, args: &[&str]) -> Vec<[f32; 3]> {
    let corners = [
        "-1 -1 -1", "1 -1 -1", "-1 1 -1", "1 1 -1", "-1 -1 1", "1 -1 1", "-1 1 1", "1 1 1",
    ];
    let faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"];
    let lines = |kind: &str, of: &[&str]| of.iter().map(|line| format!("{kind} {line}\n")).collect::<String>();
    let folder = Folder::new();
    folder.write(
        "box.obj",
        &format!("{}s {smooth}\n{}", lines("v", &corners), lines("f", &faces)),
    );
    let scene = format!(
        "[render]\nwidth = {BOX}\nheight = {BOX}\nsamples = 4\nintegrator.path = {{ max_depth = 2 }}\n[camera]\n\
         orthographic = {{ eye = [0, 6, 0], target = [0, 0, 0], up = [0, 0, -1], height = 2.4 }}\n\
         [background]\ncolor = [0, 0, 0]\n{world}\n[material.m]\nmatte = {{ albedo = 0.8 }}\n\
         [[object]]\nmaterial = \"m\"\nshape.mesh = {{ file = \"box.obj\" }}\n{transform}\n"
    );
    folder.write("s.toml", &scene);
    folder.succeed(&[&["s.toml", "--progress", "none", "-o", "f.exr"], args].concat());
    pixels(&folder)
}

/// The x and z of the middle of pixel `i` of a box.
fn place(i: usize) -> Vec2 {
    Vec2::new((i % BOX) as f32 + 0.5, (i / BOX) as f32 + 0.5) * PIXEL - 1.2
}

#[test]
fn the_shadow_on_a_smooth_box_is_that_on_a_flat_box() {
    let slab = "[[object]]\nmaterial = \"m\"\nshape.cuboid = { min = [-0.3, 1.2, -0.3], max = [0.3, 1.3, 0.3] }\n";
    let sun = format!("{slab}[[light]]\nsun = {{ direction = [-1, -1, 0], irradiance = 3 }}\n");
    // A box out of sight makes both instances of a mesh.
    let copy =
        "[[object]]\nmaterial = \"m\"\nshape.mesh = { file = \"box.obj\" }\ntransform = { translate = [9, 0, 0] }\n";
    for (transform, world) in [
        ("", sun.clone()),
        ("transform = { scale = [-1, 1, 1] }", sun.clone()),
        ("", format!("{sun}{copy}")),
        ("transform = { scale = [-1, 1, 1] }", format!("{sun}{copy}")),
    ] {
        let smooth = render_box("1", transform, &world, &[]);
        let flat = render_box("off", transform, &world, &[]);
        let normals = render_box("1", transform, &world, &["--show", "N"]);
        let mut shaded = 0;
        for i in 0..BOX * BOX {
            let cos = (normals[i][0] + normals[i][1]) / 2.0_f32.sqrt();
            let of_flat = 3.0 * 0.8 / PI / 2.0_f32.sqrt();
            // A pixel at the rim of the shadow is lit in part, one at the rim of the slab shows two surfaces, and beside the box
            // there is nothing.
            let visible = flat[i][0] / of_flat;
            let from_slab = place(i).abs().max_element() - 0.3;
            if (visible - 0.5).abs() < 0.49 || from_slab.abs() < PIXEL || normals[i] == [0.0; 3] {
                continue;
            }
            let expected = 3.0 * 0.8 / PI * cos.max(0.0) * visible.round();
            assert!(
                (smooth[i][0] - expected).abs() < 0.01,
                "{transform}: {:?} at {i} is not {expected}",
                smooth[i]
            );
            shaded += usize::from(visible < 0.01 && cos > 0.1);
        }
        assert!(shaded > 60, "{shaded}");
    }
}

#[test]
fn a_smooth_box_is_lit_by_a_lamp_close_to_it() {
    let lamp = "[[light]]\npoint = { position = [0, 1.4, 0], intensity = 0.5 }\n";
    let smooth = render_box("1", "", lamp, &[]);
    let normals = render_box("1", "", lamp, &["--show", "N"]);
    for (i, (seen, n)) in smooth.iter().zip(&normals).enumerate() {
        let [x, z] = place(i).to_array();
        let distance2 = x * x + z * z + 0.16;
        // At the rim pixels hold several faces.
        if x.abs().max(z.abs()) > 0.95 {
            continue;
        }
        let cos = (0.4 * n[1] - x * n[0] - z * n[2]) / distance2.sqrt();
        let expected = 0.8 / PI * 0.5 / distance2 * cos.max(0.0);
        assert!(
            (seen[0] - expected).abs() < 0.02,
            "{seen:?} at {x}, {z} is not {expected}"
        );
    }
}

#[test]
fn a_strong_normal_map_loses_no_light_in_a_white_furnace() {
    for material in [
        "metallic = 1, roughness = 0",
        "metallic = 1, roughness = 0.3",
        "metallic = 0, roughness = 1, specular = 0",
        "metallic = 0, roughness = 0.4",
    ] {
        let scene = format!(
            "[render]\nwidth = {WIDTH}\nheight = {HEIGHT}\nsamples = 64\nintegrator.path = {{ max_depth = 8 }}\n{CAMERA}\
             [background]\ncolor = [1, 1, 1]\n[texture.n]\n\
             checker = {{ a = [0.98, 0.5, 0.6], b = [0.02, 0.3, 0.55], scale = 20 }}\n\
             [material.m]\nprincipled = {{ base_color = 1, normal = \"texture.n\", {material} }}\n\
             [[object]]\nmaterial = \"m\"\nshape.sphere = {{ radius = 1 }}\n"
        );
        let pixels = Folder::new().render(&scene);
        let darkest = pixels.iter().map(|p| p[0]).fold(f32::INFINITY, f32::min);
        let brightest = pixels.iter().map(|p| p[0]).fold(0.0, f32::max);
        assert!(
            darkest >= 0.9 && brightest < 1.1,
            "{material}: {darkest} to {brightest}"
        );
    }
}

#[test]
fn strategies_agree_on_normal_maps_and_smooth_meshes() {
    let map = "[texture.n]\nchecker = { a = [0.9, 0.5, 0.7], b = [0.2, 0.3, 0.6], scale = 20 }\n";
    // The means of rough glass by light sampling alone are off by 0.5 % in 2048 samples.
    for (material, samples) in [
        (
            "principled = { base_color = 0.8, normal = \"texture.n\", metallic = 1, roughness = 0.5 }",
            512,
        ),
        (
            "principled = { base_color = 0.8, normal = \"texture.n\", roughness = 0.7 }",
            512,
        ),
        ("glass = { roughness = 0.4 }", 2048),
    ] {
        let lamp = format!(
            "{map}[background]\ncolor = [0, 0, 0]\n[material.lamp]\nemitter = {{ radiance = 10 }}\n\
             [[object]]\nmaterial = \"lamp\"\nshape.sphere = {{ center = [2, 4, 1], radius = 2.5 }}\n"
        );
        let mean = |strategy: &str| {
            let how = path(samples, &format!("max_depth = 6, strategy = \"{strategy}\""));
            let seen = render_ball(&how, material, &lamp, &[]);
            seen.iter().map(|p| p[0]).sum::<f32>() / seen.len() as f32
        };
        let expected = mean("mis");
        for strategy in ["light", "bsdf"] {
            let off = mean(strategy) / expected - 1.0;
            assert!(off.abs() < 0.02, "{material}, {strategy}: {off}");
        }
    }
}
