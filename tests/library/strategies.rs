//! Light that does not depend on how it is looked for: with limits of bounces, through sheets, and beside them.

use std::path::Path;

use batch_render::{
    batch::{Job, Request},
    describe::{self, Source},
    render::Control,
};

const SIDE: u32 = 12;
const MATERIALS: &str = "
[material.white]
matte = { albedo = 0.8 }
[material.lamp]
emitter = { radiance = 1, two_sided = true }
[material.pane]
glass = { thin_walled = true, ior = 1.0001 }
";

/// The mean colour of a picture of 12x12 pixels.
fn mean(render: &str, scene: &str) -> [f64; 3] {
    let text = format!("[render]\nwidth = {SIDE}\nheight = {SIDE}\n{render}\n{MATERIALS}{scene}");
    let source = Source::new(Path::new("scene.toml").into(), text);
    let desc = describe::parse(source).unwrap_or_else(|e| panic!("{e}"));
    let job = Job::new(desc, &Request::default()).unwrap_or_else(|e| panic!("{e}"));
    let compiled = job.compile().unwrap_or_else(|e| panic!("{e}"));
    let film = job.render_frame(&mut job.scenes(compiled), 0, &Control::default());
    let film = film.expect("a film");
    let sum = |k: usize| film.beauty().iter().map(|p| f64::from(p[k])).sum::<f64>();
    [0, 1, 2].map(|k| sum(k) / f64::from(SIDE * SIDE))
}

/// The greens of the three strategies.
fn by_strategy(limits: &str, scene: &str) -> [f64; 3] {
    ["mis", "light", "bsdf"].map(|strategy| {
        mean(
            &format!("samples = 512\nintegrator.path = {{ {limits} strategy = '{strategy}' }}"),
            scene,
        )[1]
    })
}

#[track_caller]
fn agree(values: &[f64], tolerance: f64) {
    for value in values {
        assert!((value / values[0] - 1.0).abs() < tolerance, "{values:?}");
    }
}

const CAMERA: &str = "[camera]\nperspective = { eye = [0, 1, 3], target = [0, 0, 0], fov = 30 }\n";
const FLOOR: &str =
    "[[object]]\nmaterial = 'white'\nshape.quad = { corners = [[-5, 0, 5], [5, 0, 5], [5, 0, -5], [-5, 0, -5]] }\n";

/// A horizontal square of an edge of 4 m.
fn above(material: &str, height: f64) -> String {
    format!(
        "[[object]]\nmaterial = '{material}'\nshape.quad = {{ corners = [[-2, {height}, 2], [2, {height}, 2], [2, {height}, -2], [-2, {height}, -2]] }}\n"
    )
}

#[test]
fn a_limit_of_bounces_leaves_direct_light_whole() {
    let lit = format!("{CAMERA}{FLOOR}{}", above("lamp", 1.5));
    let whole = by_strategy("", &lit);
    let none = by_strategy("max_diffuse = 0, max_specular = 0, max_transmission = 0,", &lit);
    agree(&[whole, none].concat(), 0.01);
}

#[test]
fn strategies_agree_where_a_limit_ends_paths() {
    let wall = "[[object]]\nmaterial = 'white'\nshape.quad = { corners = [[-2, 0, -1], [2, 0, -1], [2, 2, -1], [-2, 2, -1]] }\n";
    let camera = CAMERA.replace("[0, 0, 0]", "[0, 0.5, 0]");
    let corner = format!("{camera}{FLOOR}{wall}{}", above("lamp", 2.0));
    let [one, two] = ["max_diffuse = 1,", "max_diffuse = 2,"].map(|limit| by_strategy(limit, &corner));
    agree(&one, 0.01);
    agree(&two, 0.01);
    assert!(two[0] > one[0] * 1.02, "{one:?} {two:?}");
    // The walls' light passes the panes that a limit lets it pass, whoever finds it.
    for limit in [0, 1, 2] {
        let panes = format!("{corner}{}{}", above("pane", 1.6), above("pane", 1.7));
        let found = by_strategy(&format!("max_transmission = {limit}, max_diffuse = 1,"), &panes);
        assert!(
            found.iter().all(|l| (l - found[0]).abs() < 0.01 * one[0]),
            "{limit}: {found:?}"
        );
        // Little light comes around two panes.
        assert_eq!(found[0] < 0.1 * one[0], limit < 2, "{limit}: {found:?}");
    }
}

#[test]
fn light_passes_a_sheet_of_any_material_that_does_not_refract() {
    let under = |material: &str| {
        let sheet = format!("[material.sheet]\n{material}\n{}", above("sheet", 1.4));
        // Somewhere else there is a pane that shadow rays pass.
        let pane = "[[object]]\nmaterial = 'pane'\nshape.quad = { corners = [[50, 0, 0], [51, 0, 0], [51, 1, 0], [50, 1, 0]] }\n";
        format!("{CAMERA}{FLOOR}{sheet}{}{pane}", above("lamp", 1.5))
    };
    let phong = by_strategy("", &under("phong = { color = 0, transmit = 1, ior = 1 }"));
    let glass = by_strategy("", &under("glass = { ior = 1 }"));
    agree(&[phong, glass].concat(), 0.01);
}

#[test]
fn a_light_in_the_plane_of_a_pane_is_seen_once() {
    for z in [0.0, 0.37, 12.3] {
        for [x, y, distance] in [[0.0, 0.0, 3.0], [0.7, 0.3, 2.1]] {
            let scene = format!(
                "[camera]\nperspective = {{ eye = [{x}, {y}, {}], target = [0, 0, {z}], fov = 20 }}\n\
                 [[object]]\nmaterial = 'pane'\nshape.quad = {{ corners = [[-5, -5, {z}], [5, -5, {z}], [5, 5, {z}], [-5, 5, {z}]] }}\n\
                 [[light]]\nrect = {{ position = [0, 0, {z}], direction = [0, 0, 1], size = [2, 2], radiance = 1, camera = true }}\n",
                z + distance
            );
            let seen = mean("samples = 16", &scene);
            assert!((seen[1] - 1.0).abs() < 1e-4, "{z}: {seen:?}");
        }
    }
}

#[test]
fn a_bubble_of_air_in_a_body_is_one_of_any_material() {
    let bubble = |material: &str| {
        let scene = format!(
            "[camera]\nperspective = {{ eye = [0, 0, 4], target = [0, 0, 0], fov = 30 }}\n\
             [background]\ngradient = {{ up = [3, 1, 0.1], side = 0.5, down = 0.05 }}\n\
             [material.body]\nglass = {{ ior = 1.33 }}\n[material.air]\n{material}\n\
             [[object]]\nmaterial = 'body'\nshape.sphere = {{ radius = 1 }}\n\
             [[object]]\nmaterial = 'air'\nshape.sphere = {{ radius = 0.6 }}\n"
        );
        mean("samples = 64\nintegrator.path = { max_depth = 12 }", &scene)
    };
    let air = bubble("glass = { ior = 1 }");
    let principled = bubble("principled = { base_color = 1, transmission = 1, roughness = 0, thickness = 1, ior = 1 }");
    for (a, b) in air.into_iter().zip(principled) {
        assert!((a / b - 1.0).abs() < 0.005, "{air:?} {principled:?}");
    }
}

#[test]
fn the_colours_of_a_film_are_the_same_in_every_working_space() {
    let ball = |space: &str| {
        mean(
            &format!("samples = 16\nworking_space = '{space}'"),
            "[camera]\nperspective = { eye = [0, 0, 4], target = [0, 0, 0], fov = 20 }\n[background]\ncolor = 1\n\
             [material.film]\nprincipled = { base_color = 0.9, metallic = 1, roughness = 0.3, iridescence = 1, iridescence_thickness = 300 }\n\
             [[object]]\nmaterial = 'film'\nshape.sphere = { radius = 1 }\n",
        )
    };
    let ([r, g, b], ap1) = (ball("rec709"), ball("acescg"));
    // Rec. 709 in AP1, both with their own white.
    let expected = [
        0.613097 * r + 0.339523 * g + 0.047379 * b,
        0.070194 * r + 0.916354 * g + 0.013452 * b,
        0.020616 * r + 0.109570 * g + 0.869815 * b,
    ];
    for (found, expected) in ap1.into_iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 2e-3, "{ap1:?} {expected}");
    }
    assert!((r - b).abs() > 0.02, "{r} {b}");
}

#[test]
fn a_light_before_a_surface_that_is_passed_is_seen_whole() {
    // A body of 1 m whose surface is passed with this probability, and in which half a metre halves light.
    let seen = |opacity: f64, z: f64| {
        mean(
            "samples = 64",
            &format!(
                "[camera]\nperspective = {{ eye = [0, 0, 4], target = [0, 0, 0], fov = 2 }}\n\
                 [material.body]\nprincipled = {{ base_color = 1, transmission = 1, roughness = 0, ior = 1, thickness = 1, \
                 attenuation_color = [0.25, 0.25, 0.25], attenuation_distance = 1, opacity = {opacity} }}\n\
                 [[object]]\nmaterial = 'body'\nshape.cuboid = {{ min = [-1, -1, -1], max = [1, 1, 0] }}\n\
                 [[light]]\nrect = {{ position = [0, 0, {z}], direction = [0, 0, 1], size = [1, 1], radiance = 1, camera = true }}\n"
            ),
        )[1]
    };
    for opacity in [1.0, 0.5, 0.1, 0.0] {
        for (z, expected) in [(2.0, 1.0), (-0.5, 0.5), (-2.0, 0.25)] {
            let found = seen(opacity, z);
            assert!((found / expected - 1.0).abs() < 2e-3, "{opacity} {z}: {found}");
        }
    }
}

#[test]
fn a_flat_emitter_does_not_light_itself() {
    let side = "corners = [[-1, 0, 1], [1, 0, 1], [1, 0.1, -1], [-1, 0.1, -1]]";
    let sheets = [
        format!("shape.quad = {{ {side} }}"),
        "shape.quad = { corners = [[-1, 0, 1], [1, 0, 1], [1.3, 0.1, -1], [-1, 0.1, -1]] }".to_owned(),
        "shape.quad = { corners = [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]] }\ntransform = { rotate = [3, 20, 7], translate = [0.1, 0.2, 0.3] }"
            .to_owned(),
        "shape.cuboid = { min = [-1, -1, -1], max = [1, 0, 1] }\ntransform.rotate = [3, 20, 7]".to_owned(),
        "shape.cylinder = { radius = 0.5, height = 1 }\ntransform.rotate = [31, 12, 7]".to_owned(),
        "shape.disk = { radius = 1, normal = [0.1, 1, 0.2] }".to_owned(),
    ];
    for sheet in sheets {
        let scene = format!(
            "[camera]\nperspective = {{ eye = [0, 2, 4], target = [0, 0, 0], fov = 20 }}\n\
             [material.hot]\nprincipled = {{ base_color = 0.8, specular = 0, roughness = 1, emissive = 1 }}\n\
             [[object]]\nmaterial = 'hot'\n{sheet}\n"
        );
        let [one, two] = [1, 4].map(|depth| {
            mean(
                &format!("samples = 64\nintegrator.path = {{ max_depth = {depth}, strategy = 'light' }}"),
                &scene,
            )[1]
        });
        assert!(one > 0.1, "{sheet}: {one}");
        assert!((two / one - 1.0).abs() < 1e-5, "{sheet}: {one} {two}");
    }
}

#[test]
fn a_rough_surface_between_equal_media_bends_no_light() {
    // Bright walls beside a dark gap, which the camera looks at through a body.
    let seen = |keys: &str| {
        let wall = |from: f64, to: f64| {
            format!(
                "[[object]]\nmaterial = 'lamp'\nshape.quad = {{ corners = [[{from}, -2, -2], [{to}, -2, -2], [{to}, 2, -2], [{from}, 2, -2]] }}\n"
            )
        };
        let scene = format!(
            "[camera]\nperspective = {{ eye = [0, 0, 4], target = [0, 0, 0], fov = 2 }}\n\
             [material.body]\nprincipled = {{ base_color = 1, transmission = 1, roughness = 0.7, {keys} }}\n\
             [[object]]\nmaterial = 'body'\nshape.sphere = {{ radius = 0.6 }}\n{}{}",
            wall(-2.0, -0.3),
            wall(0.3, 2.0)
        );
        mean("samples = 64\nintegrator.path = { max_depth = 12 }", &scene)[1]
    };
    let (equal, nearly, sheet) = (
        seen("ior = 1, thickness = 1"),
        seen("ior = 1.003, thickness = 1"),
        seen("ior = 1.5"),
    );
    assert!(equal < 0.01 && nearly < 0.01 && sheet > 0.2, "{equal} {nearly} {sheet}");
}
