//! Materials in pictures whose answer is known without them.

use crate::common::{Folder, stderr};
use batch_render::math::trig;

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
    assert!(said(1.25).contains("material `snow` reflects more light than it receives (albedo 1.25)"));
    assert!(!said(1.0).contains("snow"));
}

/// The middle of a flat square at the origin that faces the camera, under a lamp of radiance 1 that is seen in the
/// direction (sin `angle`, 0, cos `angle`) from it, and by nothing else.
fn under_a_lamp(angle: f32, material: &str) -> f32 {
    let (sin, cos) = trig::sin_cos(angle);
    let at = |along: f32, y: f32| [8.0 * sin + along * cos, y, 8.0 * cos - along * sin];
    let lamp = [at(0.5, -0.5), at(-0.5, -0.5), at(-0.5, 0.5), at(0.5, 0.5)];
    let pixels = Folder::new().render(&format!(
        "[render]\nwidth = 2\nheight = 2\nsamples = 64\nintegrator.path = {{ max_depth = 3 }}\n\
         [camera]\northographic = {{ eye = [0, 0, 5], target = [0, 0, 0], height = 0.01 }}\n\
         [texture.tilted]\nconstant = {{ color = [{}, 0.5, {}] }}\n[texture.steep]\nconstant = {{ color = [0.1, 0.4, 0.8] }}\n\
         [material.m]\nprincipled = {{ base_color = 0, specular = 0, clearcoat = 1, {material} }}\n\
         [material.lamp]\nemitter = {{ radiance = 1, two_sided = true }}\n\
         [[object]]\nmaterial = \"m\"\nshape.quad = {{ corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]] }}\n\
         [[object]]\nmaterial = \"lamp\"\nshape.quad = {{ corners = {lamp:?} }}\n",
        0.5 + 0.5 * trig::sin(TILT),
        0.5 + 0.5 * trig::cos(TILT),
    ));
    pixels.iter().map(|p| p[1]).sum::<f32>() / pixels.len() as f32
}

/// The angle by which the normal map `tilted` turns normals towards u.
const TILT: f32 = 0.35;

#[test]
fn a_coat_mirrors_by_its_own_normals_and_not_by_those_of_its_base() {
    let own = "clearcoat_normal = \"texture.tilted\"";
    let (base, other) = ("normal = \"texture.tilted\"", "normal = \"texture.steep\"");
    let grazing = (1.0 - trig::cos(TILT)).powi(5);
    let mirrored = |cos_term: f32| 0.04 + 0.96 * cos_term;
    for (angle, material, expected) in [
        (2.0 * TILT, own.to_owned(), mirrored(grazing)),
        (2.0 * TILT, format!("{own}, {base}"), mirrored(grazing)),
        (2.0 * TILT, format!("{own}, {other}"), mirrored(grazing)),
        (2.0 * TILT, base.to_owned(), 0.0),
        (2.0 * TILT, format!("{own}, clearcoat_normal_scale = 0"), 0.0),
        (0.3, own.to_owned(), 0.0),
    ] {
        let found = under_a_lamp(angle, &material);
        assert!(
            (found - expected).abs() < 1e-4,
            "{material}: {found} instead of {expected}"
        );
    }
    // The highlight of a rough coat is brightest where a smooth one mirrors.
    let rough = format!("{own}, clearcoat_roughness = 0.3");
    let [near, at, far] = [1.0, 2.0, 3.0].map(|k| under_a_lamp(k * TILT, &rough));
    assert!(at > 1.5 * near && at > 1.5 * far, "{near} {at} {far}");
}

/// The radiance of a brushed metal square in slanting sunlight, seen straight on. `corners` are those of the square, whose first
/// edge is the tangent.
fn brushed(keys: &str, corners: [[i32; 3]; 4]) -> f32 {
    let pixels = Folder::new().render(&format!(
        "[render]\nwidth = 2\nheight = 2\nsamples = 1\nintegrator.path = {{ max_depth = 2 }}\n\
         [camera]\northographic = {{ eye = [0, 0, 5], target = [0, 0, 0], height = 0.01 }}\n\
         [[light]]\nsun = {{ direction = [-0.4, -0.2, -1], irradiance = 3, angle = 0 }}\n\
         [texture.turned]\nconstant = {{ color = [0.9, 0.8, 0.25] }}\n\
         [material.m]\nprincipled = {{ base_color = 1, metallic = 1, roughness = 0.4, {keys} }}\n\
         [[object]]\nmaterial = \"m\"\nshape.quad = {{ corners = {corners:?} }}\n",
    ));
    pixels[0][1]
}

const FACING: [[i32; 3]; 4] = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]];

#[test]
fn the_direction_of_brushing_is_in_red_and_green_and_turns_with_the_rotation() {
    // The texture's direction (0.8, 0.6) is 36.87 degrees from the tangent, its strength is in blue.
    let map = "anisotropy_direction = \"texture.turned\"";
    for (mapped, turned) in [
        (
            format!("anisotropy = 0.7, {map}"),
            "anisotropy = 0.7, anisotropy_rotation = 36.869898",
        ),
        (
            format!("anisotropy = 0.7, {map}, anisotropy_rotation = 20"),
            "anisotropy = 0.7, anisotropy_rotation = 56.869898",
        ),
        (
            format!("anisotropy = \"texture.turned\", {map}"),
            "anisotropy = 0.25, anisotropy_rotation = 36.869898",
        ),
    ] {
        let (found, expected) = (brushed(&mapped, FACING), brushed(turned, FACING));
        assert!(
            (found / expected - 1.0).abs() < 1e-4,
            "{mapped}: {found} instead of {expected}"
        );
    }
    let straight = brushed("anisotropy = 0.7", FACING);
    let turned = brushed(&format!("anisotropy = 0.7, {map}"), FACING);
    assert!((turned / straight - 1.0).abs() > 0.1, "{turned} {straight}");
}

#[test]
fn brushing_turns_from_the_tangent_to_the_bitangent_on_both_sides() {
    let keys = |degrees: i32| format!("anisotropy = 0.7, anisotropy_rotation = {degrees}");
    // The tangent of the square that faces away is -x, so that y is to the other side of it.
    let away = [[1, -1, 0], [-1, -1, 0], [-1, 1, 0], [1, 1, 0]];
    let (found, expected) = (brushed(&keys(30), away), brushed(&keys(-30), FACING));
    assert!((found / expected - 1.0).abs() < 1e-4, "{found} instead of {expected}");
    let other = brushed(&keys(30), FACING);
    assert!((other / expected - 1.0).abs() > 0.1, "{other} {expected}");
}

#[test]
fn a_leaf_sends_its_part_of_the_light_to_each_side_by_lamberts_law() {
    let radiance = |sun: f32, keys: &str| {
        let pixels = Folder::new().render(&format!(
            "[render]\nwidth = 2\nheight = 2\nsamples = 64\nintegrator.path = {{ max_depth = 2 }}\n\
             [camera]\northographic = {{ eye = [0, 0, 5], target = [0, 0, 0], height = 0.01 }}\n\
             [[light]]\nsun = {{ direction = [0.6, 0, {}], irradiance = 3.1415927, angle = 0 }}\n\
             [texture.quarter]\nconstant = {{ color = [0.3, 0.4, 0.25] }}\n\
             [material.m]\nprincipled = {{ base_color = [0.5, 0.6, 0.1], specular = 0, {keys} }}\n\
             [[object]]\nmaterial = \"m\"\nshape.quad = {{ corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]] }}\n",
            0.8 * sun
        ));
        pixels[0]
    };
    let (front, back) = (-1.0, 1.0);
    let green = "diffuse_transmission_color = [0.2, 0.9, 0.4]";
    for (sun, keys, expected) in [
        (
            front,
            format!("diffuse_transmission = 0.25, {green}"),
            [0.3, 0.36, 0.06],
        ),
        (
            back,
            format!("diffuse_transmission = 0.25, {green}"),
            [0.04, 0.18, 0.08],
        ),
        (
            back,
            format!("diffuse_transmission = \"texture.quarter.b\", {green}"),
            [0.04, 0.18, 0.08],
        ),
        (back, "diffuse_transmission = 1".to_owned(), [0.8, 0.8, 0.8]),
        (back, green.to_owned(), [0.0, 0.0, 0.0]),
        // What is clear passes before it is diffuse, and the sun is not in the line of sight.
        (
            back,
            format!("transmission = 0.5, diffuse_transmission = 0.25, roughness = 0, {green}"),
            [0.02, 0.09, 0.04],
        ),
    ] {
        let found = radiance(sun, &keys);
        let is_right = (0..3).all(|k| (found[k] - expected[k]).abs() < 1e-3);
        assert!(is_right, "{keys}: {found:?} instead of {expected:?}");
    }
}

#[test]
fn a_prism_sends_each_channel_in_the_direction_of_its_index() {
    // A wedge: light goes straight through the face at z = 1 and meets the other one at 30 degrees.
    let (sin, cos) = trig::sin_cos(trig::radians(30.0));
    let (slope, slant) = (sin / cos, cos);
    let z = |x: f32| -slope * x;
    let wedge = format!(
        "v -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\nv -1 -1 {0}\nv 1 -1 {1}\nv 1 1 {1}\nv -1 1 {0}\n\
         f 1 2 3 4\nf 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n",
        z(-1.0),
        z(1.0)
    );
    let fresnel = |cos_i: f32, eta: f32| {
        let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (eta * eta)).sqrt();
        let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
        let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
        0.5 * (parallel * parallel + perpendicular * perpendicular)
    };
    let folder = Folder::new();
    folder.write("wedge.obj", &wedge);
    // An Abbe number of 5: red and blue are 0.1 apart.
    for (channel, ior) in [1.45_f32, 1.5, 1.55].into_iter().enumerate() {
        let angle = trig::asin(ior * 0.5) - trig::radians(30.0);
        let (sin, cos) = trig::sin_cos(angle);
        // The outward normal of the slanting face is (-tan 30, 0, -1), so light is bent towards x.
        let at = |along: f32, y: f32| [20.0 * sin + along * cos, y, along * sin - 20.0 * cos];
        let lamp = [at(-0.2, -0.2), at(0.2, -0.2), at(0.2, 0.2), at(-0.2, 0.2)];
        let pixels = folder.render(&format!(
            "[render]\nwidth = 2\nheight = 2\nsamples = 1024\nintegrator.path = {{ max_depth = 3 }}\n\
             [camera]\northographic = {{ eye = [0, 0, 5], target = [0, 0, 0], height = 0.01 }}\n\
             [material.prism]\nprincipled = {{ base_color = 1, transmission = 1, roughness = 0, ior = 1.5, thickness = 1, \
             dispersion = 4 }}\n[material.lamp]\nemitter = {{ radiance = 1, two_sided = true }}\n\
             [[object]]\nmaterial = \"prism\"\nshape.mesh = {{ file = \"wedge.obj\" }}\n\
             [[object]]\nmaterial = \"lamp\"\nshape.quad = {{ corners = {lamp:?} }}\n"
        ));
        let found = [0, 1, 2].map(|k| pixels.iter().map(|p| p[k]).sum::<f32>() / pixels.len() as f32);
        let passed = (1.0 - fresnel(1.0, ior)) * (1.0 - fresnel(slant, ior.recip()));
        for (k, found) in found.into_iter().enumerate() {
            let expected = if k == channel { passed } else { 0.0 };
            assert!(
                (found - expected).abs() < 0.03,
                "{ior}, channel {k}: {found} instead of {expected}"
            );
        }
    }
}

/// A ball of `material` beside a lamp and a floor, with more materials.
fn lit_ball(samples: u32, integrator: &str, material: &str, more: &str) -> Vec<[f32; 3]> {
    Folder::new().render(&format!(
        "[render]\nwidth = {SIDE}\nheight = {SIDE}\nsamples = {samples}\n{integrator}\n\
         [camera]\nperspective = {{ eye = [0, 0, 5], target = [0, 0, 0], fov = 30 }}\n\
         [background]\ncolor = [0.2, 0.3, 0.4]\n{more}\n{}\
         [[light]]\npoint = {{ position = [2, 3, 4], intensity = 30 }}\n",
        ball(material)
    ))
}

const PAINT: &str = "principled = { base_color = [0.7, 0.1, 0.05], roughness = 0.4, clearcoat = 1 }";
const STEEL: &str = "metal = { preset = \"iron\", roughness = 0.35 }";
const HALVES: &str = "[texture.halves]\nstripes = { a = 0, b = 1, width = 0.125 }\n";

fn paint_and_steel() -> String {
    format!("[material.paint]\n{PAINT}\n[material.steel]\n{STEEL}\n{HALVES}")
}

#[test]
fn a_mixture_of_all_or_nothing_has_the_bits_of_its_material() {
    let more = paint_and_steel();
    for integrator in [
        "integrator.path = { max_depth = 6 }",
        "integrator.whitted = { max_depth = 4 }",
    ] {
        for (factor, alone) in [("0", PAINT), ("1", STEEL)] {
            let mixed = format!("mix = {{ a = \"paint\", b = \"steel\", factor = {factor} }}");
            let mixed = lit_ball(4, integrator, &mixed, &more);
            assert_eq!(mixed, lit_ball(4, integrator, alone, &more), "{integrator} {alone}");
        }
        // A mixture of mixtures, and a texture that is 0 or 1.
        let within = format!(
            "{more}[material.inner]\nmix = {{ a = \"steel\", b = \"paint\", factor = \"texture.halves\" }}\n\
             [material.outer]\nmix = {{ a = \"inner\", b = \"paint\", factor = 0 }}\n"
        );
        let outer = lit_ball(
            4,
            integrator,
            "mix = { a = \"outer\", b = \"steel\", factor = 0 }",
            &within,
        );
        let inner = lit_ball(
            4,
            integrator,
            "mix = { a = \"steel\", b = \"paint\", factor = \"texture.halves\" }",
            &within,
        );
        let [paint, steel] = [PAINT, STEEL].map(|m| lit_ball(4, integrator, m, &within));
        assert_eq!(outer, inner);
        let which = |pixels: &[[f32; 3]]| inner.iter().zip(pixels).filter(|(a, b)| a == b).count();
        assert!(which(&paint) > SIDE * SIDE / 4 && which(&steel) > SIDE * SIDE / 4 && inner != paint && inner != steel);
    }
}

#[test]
fn a_mixture_reflects_the_weighted_sum_of_both() {
    let more = paint_and_steel();
    let integrator = "integrator.path = { max_depth = 2 }";
    let [paint, steel] = [PAINT, STEEL].map(|material| lit_ball(256, integrator, material, &more));
    for factor in [0.25, 0.7] {
        let mixed = format!("mix = {{ a = \"paint\", b = \"steel\", factor = {factor} }}");
        let mixed = lit_ball(1024, integrator, &mixed, &more);
        let mean =
            |pixels: &[[f32; 3]]| pixels.iter().flatten().map(|v| f64::from(*v)).sum::<f64>() / pixels.len() as f64;
        let expected = (1.0 - factor) * mean(&paint) + factor * mean(&steel);
        assert!(
            (mean(&mixed) / expected - 1.0).abs() < 3e-3,
            "{factor}: {} {expected}",
            mean(&mixed)
        );
    }
}

#[test]
fn a_tinted_metal_reflects_as_much_less() {
    let metal = |tint: &str| {
        let material = format!("metal = {{ eta = [2.7, 2.5, 2.3], k = [3.7, 3.4, 3.0], roughness = 0.3{tint} }}");
        render(16, &format!("{HALVES}{}", ball(&material)))
    };
    let (plain, tinted) = (metal(""), metal(", tint = [0.5, 0.25, 1]"));
    let middle = SIDE / 2 * SIDE + SIDE / 2;
    let gains = |channel: usize| tinted[middle][channel] / plain[middle][channel];
    // Light that bounces between the facets is tinted at each of them.
    for (channel, tint) in [0.5, 0.25, 1.0].into_iter().enumerate() {
        assert!(
            (gains(channel) / tint - 1.0).abs() < 0.02,
            "{channel}: {} {tint}",
            gains(channel)
        );
    }
    assert_eq!(metal(", tint = 1"), plain);
    assert_ne!(metal(", tint = \"texture.halves\""), plain);
}
