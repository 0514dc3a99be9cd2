//! Materials in pictures whose answer is known without them.

mod common;

use common::{Folder, stderr};

const SIDE: usize = 24;

/// The pixels of a scene that is seen by a camera at (0, 0, 5) and stands in a white furnace.
fn render(samples: u32, scene: &str) -> Vec<[f32; 3]> {
    Folder::new().render(&format!(
        "[render]\nwidth = {SIDE}\nheight = {SIDE}\nsamples = {samples}\nintegrator.path = {{ max_depth = 60 }}\n\
         [camera]\nperspective = {{ eye = [0, 0, 5], target = [0, 0, 0], fov = 24 }}\n\
         [background]\ncolor = [1, 1, 1]\n{scene}"
    ))
}

fn ball(material: &str) -> String {
    format!(
        "[material.m]\n{material}\n[[object]]\nmaterial = \"m\"\nshape.sphere = {{ center = [0, 0, 0], radius = 1.2 }}\n"
    )
}

#[test]
fn white_balls_are_invisible_in_a_white_furnace() {
    for material in [
        "metal = { color = 1, roughness = 0.7 }",
        "glass = { roughness = 0.4 }",
        "glass = { roughness = 0.6, thin_walled = true }",
        "matte = { albedo = 1, roughness = 1 }",
        "principled = { base_color = 1, roughness = 0.3 }",
        "principled = { base_color = 1, metallic = 0.5, roughness = 0.8, clearcoat = 1, sheen_color = 1, sheen_roughness = 0.5 }",
        "principled = { base_color = 1, transmission = 0.8, roughness = 0.5, thickness = 1 }",
    ] {
        let pixels = render(64, &ball(material));
        let mean = pixels.iter().flatten().sum::<f32>() / (3 * SIDE * SIDE) as f32;
        assert!((mean - 1.0).abs() < 0.015, "{material}: {mean}");
    }
}

#[test]
fn a_body_dims_what_is_behind_it_by_beers_law() {
    let cube = "[[object]]\nmaterial = \"m\"\nshape.cuboid = { min = [-2, -2, -1], max = [2, 2, 1] }\n";
    for material in [
        "glass = { ior = 1, absorption = [0.5, 0.1, 0] }",
        "principled = { base_color = 1, ior = 1.0011, specular = 0, transmission = 1, roughness = 0, thickness = 2, \
         attenuation_color = [0.60653066, 0.9048374, 1], attenuation_distance = 1 }",
    ] {
        let pixels = render(4, &format!("[material.m]\n{material}\n{cube}"));
        let [r, g, b] = pixels[SIDE / 2 * SIDE + SIDE / 2];
        let expected = [0.367_879_44, 0.818_730_8, 1.0];
        for (is, should) in [r, g, b].into_iter().zip(expected) {
            assert!((is - should).abs() < 5e-3, "{material}: {is} {should}");
        }
    }
}

#[test]
fn plastic_of_the_first_ray_tracers_sends_back_no_more_than_arrives() {
    let plastic = "phong = { color = 0.9, specular = 1, shininess = 20, reflect = 0.8 }";
    let pixels = render(64, &ball(plastic));
    assert!(pixels.iter().flatten().sum::<f32>() / (3 * SIDE * SIDE) as f32 <= 1.0);
    let glass = "phong = { color = 0, transmit = 0.5, reflect = 0.5, ior = 1.5 }";
    let pixels = render(64, &ball(glass));
    let mean = pixels.iter().flatten().sum::<f32>() / (3 * SIDE * SIDE) as f32;
    assert!((mean - 1.0).abs() < 0.01, "{mean}");
}

#[test]
fn a_material_that_makes_light_is_warned_of_by_name() {
    let folder = Folder::new();
    let scene = |albedo: f32| {
        format!(
            "[render]\nwidth = 8\nheight = 8\nsamples = 1\n[camera]\nperspective = {{ eye = [0, 0, 5], target = [0, 0, 0] }}\n\
             [material.snow]\nmatte = {{ albedo = {albedo} }}\n"
        )
    };
    let said = |albedo: f32| {
        folder.write("s.toml", &scene(albedo));
        stderr(&folder.run(&["s.toml", "--progress", "none", "-o", "f.png"]))
    };
    assert!(said(1.25).contains("material `snow` sends back more light than arrives, 1.25 of it"));
    assert!(!said(1.0).contains("snow"));
}
