//! Light in the inside of bodies and through clear walls, where the answer is known without the renderer.

use crate::common::Folder;
use batch_render::math::exponential::exp;

const SIDE: usize = 12;
const SKY: &str = "[background]\ncolor = [1, 1, 1]\n";
const NIGHT: &str = "[background]\ncolor = [0, 0, 0]\n";
const CAMERA: &str = "[camera]\nperspective = { eye = [0, 0, 9], target = [0, 0, -1], fov = 0.2 }\n";
/// Bodies that bend nothing.
const BODIES: &str = "[material.beer]\nglass = { ior = 1, absorption = [0.1, 0.5, 1] }\n\
                      [material.air]\nglass = { ior = 1 }\n";

/// The mean of the picture.
fn render(integrator: &str, samples: u32, scene: &str) -> [f32; 3] {
    let pixels = Folder::new().render(&format!(
        "[render]\nwidth = {SIDE}\nheight = {SIDE}\nsamples = {samples}\nintegrator.path = {{ {integrator} }}\n{scene}"
    ));
    [0, 1, 2].map(|c| pixels.iter().map(|p| p[c]).sum::<f32>() / pixels.len() as f32)
}

fn sphere(material: &str, radius: f32) -> String {
    format!("[[object]]\nmaterial = \"{material}\"\nshape.sphere = {{ radius = {radius} }}\n")
}

#[track_caller]
fn assert_near(found: [f32; 3], expected: [f32; 3], tolerance: f32) {
    for (f, e) in found.into_iter().zip(expected) {
        assert!((f / e - 1.0).abs() < tolerance, "{found:?} is not {expected:?}");
    }
}

/// The transmittance of so many metres of beer.
fn behind_beer(metres: f32) -> [f32; 3] {
    [0.1, 0.5, 1.0].map(|a| exp(-a * metres))
}

#[test]
fn light_in_an_absorbing_body_is_absorbed_on_its_way_by_every_strategy() {
    // A lamp of 10 W m^-2 sr^-1 and a white patch in the middle of a ball of 3 m, seen from 6 m above.
    let scene = "[camera]\nperspective = { eye = [0, 6, 6], target = [0, 0, 0], fov = 0.5 }\n\
                 [material.w]\nglass = { ior = 1, absorption = 1 }\n[[object]]\nmaterial = \"w\"\nshape.sphere = { radius = 3 }\n\
                 [material.m]\nmatte = { albedo = 1 }\n[[object]]\nmaterial = \"m\"\n\
                 shape.quad = { corners = [[-0.1, 0, 0.1], [0.1, 0, 0.1], [0.1, 0, -0.1], [-0.1, 0, -0.1]] }\n\
                 [material.lamp]\nemitter = { radiance = 10 }\n[[object]]\nmaterial = \"lamp\"\n\
                 shape.sphere = { center = [0, 1.5, 0], radius = 0.5 }\n";
    // By numbers: the integral over the lamp's disk of exp(-t) cos, and exp(-3) on the way to the camera.
    let expected = {
        let (steps, sin_max) = (10_000, 1.0_f32 / 3.0);
        let irradiance: f32 = (0..steps)
            .map(|i| {
                let (sin, d) = ((i as f32 + 0.5) / steps as f32 * sin_max, sin_max / steps as f32);
                let t = 1.5 * (1.0 - sin * sin).sqrt() - (0.25 - 2.25 * sin * sin).sqrt();
                10.0 * exp(-t) * 2.0 * sin * d
            })
            .sum();
        irradiance * exp(-3.0)
    };
    for (strategy, samples) in [("mis", 64), ("light", 64), ("bsdf", 4096)] {
        let how = format!("max_depth = 4, strategy = \"{strategy}\"");
        assert_near(render(&how, samples, &format!("{NIGHT}{scene}")), [expected; 3], 0.01);
    }
}

#[test]
fn behind_a_bubble_the_liquid_absorbs_again() {
    let (beer, air) = (sphere("beer", 2.0), sphere("air", 1.0));
    // Nothing is left to chance.
    let how = "max_depth = 8, roulette_depth = 8";
    let seen = |bodies: &str| render(how, 4, &format!("{SKY}{CAMERA}{BODIES}{bodies}"));
    assert_near(seen(&beer), behind_beer(4.0), 2e-3);
    assert_near(seen(&format!("{beer}{air}")), behind_beer(2.0), 2e-3);
    // Beer, air, and beer again in the middle.
    let drop = sphere("beer", 0.5);
    assert_near(seen(&format!("{beer}{air}{drop}")), behind_beer(3.0), 2e-3);
}

#[test]
fn a_camera_in_a_body_sees_through_what_is_left_of_it() {
    let scene = |bodies: &str| {
        format!(
            "{SKY}[camera]\nperspective = {{ eye = [0, 0, 0.2], target = [0, 0, -1], fov = 0.2 }}\n{BODIES}{bodies}"
        )
    };
    let (beer, air) = (sphere("beer", 2.0), sphere("air", 1.0));
    let seen = |bodies: &str| render("max_depth = 8", 4, &scene(bodies));
    assert_near(seen(&beer), behind_beer(2.2), 2e-3);
    assert_near(seen(&format!("{air}{beer}")), behind_beer(1.0), 2e-3);
}

#[test]
fn where_bodies_overlap_the_higher_priority_fills_the_place() {
    // 1 m of glass, and 1.5 m of water that reaches half a metre into it.
    let scene = |priority: i32| {
        format!(
            "{SKY}{CAMERA}[material.glass]\nglass = {{ ior = 1, absorption = [0.1, 0.5, 1], priority = {priority} }}\n\
             [material.water]\nglass = {{ ior = 1, absorption = [1, 0, 0] }}\n\
             [[object]]\nmaterial = \"glass\"\nshape.cuboid = {{ min = [-1, -1, 0], max = [1, 1, 1] }}\n\
             [[object]]\nmaterial = \"water\"\nshape.cuboid = {{ min = [-1, -1, -1], max = [1, 1, 0.5] }}\n"
        )
    };
    let expected = |glass: f32, water: f32| [0.1 * glass + water, 0.5 * glass, glass].map(|x| exp(-x));
    let seen = |priority| render("max_depth = 8", 4, &scene(priority));
    assert_near(seen(1), expected(1.0, 1.0), 2e-3);
    assert_near(seen(-1), expected(0.5, 1.5), 2e-3);
    // Of equals the one that was entered last.
    assert_near(seen(0), expected(0.5, 1.5), 2e-3);
}

#[test]
fn a_body_of_the_index_of_its_surroundings_is_not_seen() {
    let seen = |more: &str| {
        let scene = format!(
            "{CAMERA}[background]\ncolor = [0.2, 0.5, 0.8]\n[material.water]\nglass = {{ ior = 1.33 }}\n\
             [material.jelly]\nglass = {{ ior = 1.33, roughness = 0.5 }}\n{}{more}",
            sphere("water", 2.0)
        )
        .replace("fov = 0.2", "fov = 30");
        render("max_depth = 20", 64, &scene)
    };
    assert_near(seen(&sphere("jelly", 1.0)), seen(""), 2e-3);
}

#[test]
fn a_lamp_lights_through_a_clear_pane_as_without_it_but_for_what_the_pane_reflects() {
    let lit = |pane: &str| {
        let scene = format!(
            "{NIGHT}{CAMERA}[material.floor]\nmatte = {{ albedo = 1 }}\n[[object]]\nmaterial = \"floor\"\n\
             shape.quad = {{ corners = [[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]] }}\n\
             [[light]]\npoint = {{ position = [0.001, 0, 20], intensity = 100 }}\n{pane}"
        );
        render("max_depth = 3", 4, &scene)
    };
    let pane = |material: &str| {
        format!(
            "[material.pane]\n{material}\n[[object]]\nmaterial = \"pane\"\n\
             shape.quad = {{ corners = [[-5, -5, 10], [5, -5, 10], [5, 5, 10], [-5, 5, 10]] }}\n"
        )
    };
    let without = lit("");
    // 4 % at each side, and what goes to and fro between them.
    let passes = 1.0 - 2.0 * 0.04 / 1.04;
    for (material, tint) in [
        (
            "glass = { thin_walled = true, transmittance = [0.9, 1, 0.8] }",
            [0.9, 1.0, 0.8],
        ),
        ("glass = { thin_walled = true }", [1.0; 3]),
    ] {
        let expected = [0, 1, 2].map(|c| without[c] * tint[c] * passes);
        assert_near(lit(&pane(material)), expected, 2e-3);
    }
    // What bends light still blocks the lamp, which no path can find.
    assert_eq!(lit(&pane("glass = { ior = 1.5 }")), [0.0; 3]);
}

#[test]
fn strategies_agree_on_a_room_behind_a_window_at_every_depth() {
    let scene = "[camera]\nperspective = { eye = [0, 1.2, 3.5], target = [0, 1, 0], fov = 50 }\n\
                 [material.w]\nmatte = { albedo = 0.7 }\n\
                 [material.pane]\nglass = { thin_walled = true, transmittance = [0.9, 1, 0.8] }\n\
                 [material.lamp]\nemitter = { radiance = 10 }\n\
                 [[object]]\nmaterial = \"w\"\nshape.quad = { corners = [[-3, 0, 3], [3, 0, 3], [3, 0, -3], [-3, 0, -3]] }\n\
                 [[object]]\nmaterial = \"pane\"\nshape.quad = { corners = [[-2, 2, -2], [2, 2, -2], [2, 2, 2], [-2, 2, 2]] }\n\
                 [[object]]\nmaterial = \"pane\"\nshape.quad = { corners = [[-2, 2.2, -2], [2, 2.2, -2], [2, 2.2, 2], [-2, 2.2, 2]] }\n\
                 [[object]]\nmaterial = \"lamp\"\nshape.quad = { corners = [[-2, 3, -2], [2, 3, -2], [2, 3, 2], [-2, 3, 2]] }\n";
    for depth in [3, 4, 5, 8] {
        let seen = |strategy: &str, samples| {
            let how = format!("max_depth = {depth}, strategy = \"{strategy}\"");
            render(&how, samples, &format!("{NIGHT}{scene}"))
        };
        let by_light = seen("light", 512);
        assert_near(seen("mis", 512), by_light, 0.01);
        assert_near(seen("bsdf", 4096), by_light, 0.02);
    }
}
