//! Pictures of Whitted's integrator whose answer is known without it.

use crate::common::Folder;

const SIDE: usize = 33;
const MIDDLE: usize = SIDE / 2 * SIDE + SIDE / 2;
const CAMERA: &str = "[camera]\nperspective = { eye = [0, 0, 5], target = [0, 0, 0] }\n";
const BACKGROUND: &str = "[background]\ncolor = [0.5, 0.5, 0.5]\n";
/// A white square that faces the camera, in a material named `m`.
const SQUARE: &str = "[[object]]\nmaterial = \"m\"\n\
                      shape.quad = { corners = [[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]] }\n";

/// The pixels of a scene.
fn render(settings: &str, scene: &str) -> Vec<[f32; 3]> {
    Folder::new().render(&format!(
        "[render]\nwidth = {SIDE}\nheight = {SIDE}\n{settings}\n{scene}"
    ))
}

fn is_near(found: [f32; 3], expected: f32) -> bool {
    found.iter().all(|v| (v - expected).abs() < 1e-3)
}

#[test]
fn smooth_glass_is_invisible_before_a_constant_background() {
    let shapes = [
        "sphere = { center = [-0.8, 0, 0], radius = 0.7 }",
        "sphere = { center = [-0.8, 0, 0], radius = 0.4 }",
        "disk = { center = [0.9, 0.7, 0], normal = [0.3, 0.2, 1], radius = 0.5 }",
        "cylinder = { base = [0.9, -0.9, 0], axis = [0.2, 1, 0.3], radius = 0.4, height = 0.9 }",
    ];
    let mut scene = format!("{CAMERA}{BACKGROUND}[material.glass]\nglass = {{ ior = 1.5 }}\n");
    for shape in shapes {
        scene += &format!("[[object]]\nmaterial = \"glass\"\nshape.{shape}\n");
    }
    let pixels = render("samples = 4\nintegrator.whitted = { max_depth = 20 }", &scene);
    // Light that is still inside after 20 segments is lost: the cylinder's corners trap some.
    let visible = pixels.iter().filter(|p| !is_near(**p, 0.5)).count();
    assert!(visible * 100 <= pixels.len(), "{visible} of {} pixels", pixels.len());
    assert!(pixels.iter().flatten().all(|v| *v <= 0.501), "glass gains nothing");
}

#[test]
fn a_mirror_before_a_constant_background_shows_it_times_its_reflectance() {
    let mirror = "[material.m]\nmirror = { reflectance = 0.8 }\n";
    let found = render("samples = 1", &format!("{CAMERA}{BACKGROUND}{mirror}{SQUARE}"))[MIDDLE];
    assert!(is_near(found, 0.4), "{found:?}");
}

#[test]
fn a_matte_surface_that_faces_a_sun_reflects_albedo_over_pi() {
    let matte = "[material.m]\nmatte = { albedo = [0.6, 0.6, 0.6] }\n";
    let sun = "[[light]]\nsun = { direction = [0, 0, -1], irradiance = 2 }\n";
    let found = render("samples = 1", &format!("{CAMERA}{matte}{SQUARE}{sun}"))[MIDDLE];
    assert!(is_near(found, 2.0 * 0.6 / std::f32::consts::PI), "{found:?}");
}

#[test]
fn max_depth_counts_segments_shadow_rays_included() {
    let phong = "[material.m]\nphong = { color = [1, 1, 1] }\n";
    let sun = "[[light]]\nsun = { direction = [0, 0, -1], irradiance = 0.25 }\n";
    let scene = format!("{CAMERA}{phong}{SQUARE}{sun}");
    let middle = |depth: u32| {
        let whitted = format!("samples = 1\nintegrator.whitted = {{ max_depth = {depth}, ambient = 0.125 }}");
        render(&whitted, &scene)[MIDDLE]
    };
    assert!(is_near(middle(1), 0.125));
    assert!(is_near(middle(2), 0.375));
}

#[test]
fn what_cannot_leave_a_phong_body_is_reflected_instead() {
    // The camera is inside, and its rays meet the face y = 0 at 60 degrees, beyond the critical 41.8.
    let scene = "[camera]\nperspective = { eye = [0, -1, 1.7320508], target = [0, 0, 0], fov = 10 }\n\
                 [material.clear]\nphong = { color = [0, 0, 0], transmit = 1, ior = 1.5 }\n\
                 [[object]]\nmaterial = \"clear\"\nshape.cuboid = { min = [-100, -100, -100], max = [100, 0, 100] }\n\
                 [material.bright]\nphong = { color = [1, 1, 1] }\n\
                 [[object]]\nmaterial = \"bright\"\nshape.sphere = { center = [0, -1, -1.7320508], radius = 0.3 }\n";
    let found = render(
        "samples = 1\nintegrator.whitted = { max_depth = 3, ambient = 0.75 }",
        scene,
    )[MIDDLE];
    assert!(is_near(found, 0.75), "{found:?}");
}
