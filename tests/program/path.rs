//! Pictures of the path integrator whose answer is known without it.

use crate::common::Folder;

const SIDE: usize = 24;
const MIDDLE: usize = SIDE / 2 * SIDE + SIDE / 2;
const CAMERA: &str = "[camera]\nperspective = { eye = [0, 0, 5], target = [0, 0, 0] }\n";

/// The pixels of a scene.
fn render(settings: &str, scene: &str) -> Vec<[f32; 3]> {
    Folder::new().render(&format!(
        "[render]\nwidth = {SIDE}\nheight = {SIDE}\n{settings}\n{scene}"
    ))
}

fn mean(pixels: &[[f32; 3]]) -> f32 {
    pixels.iter().map(|p| (p[0] + p[1] + p[2]) / 3.0).sum::<f32>() / pixels.len() as f32
}

#[test]
fn furnace_closed_sphere_equals_geometric_series() {
    // From inside of a sphere that shines with 0.5 and reflects 0.6: Le (1 - rho^n) / (1 - rho) for n segments.
    let scene = "[camera]\nperspective = { eye = [0.1, 0, 0.2], target = [0, 0, -1], fov = 60 }\n\
                 [material.wall]\nprincipled = { base_color = [0.6, 0.6, 0.6], roughness = 1, specular = 0, emissive = [0.5, 0.5, 0.5], two_sided = true }\n\
                 [[object]]\nmaterial = \"wall\"\nshape.sphere = { radius = 1 }\n";
    for (depth, tolerance) in [(1, 1e-3), (2, 0.01), (4, 0.01), (40, 0.01)] {
        let settings = format!("samples = 16\nintegrator.path = {{ max_depth = {depth} }}");
        let expected = 0.5 * (1.0 - 0.6_f32.powi(depth)) / (1.0 - 0.6);
        let found = mean(&render(&settings, scene));
        assert!(
            (found / expected - 1.0).abs() < tolerance,
            "depth {depth}: {found} is not {expected}"
        );
    }
}

#[test]
fn a_convex_matte_thing_under_a_constant_sky_reflects_its_albedo() {
    let scene = format!(
        "{CAMERA}[background]\ncolor = [0.8, 0.8, 0.8]\n[material.m]\nmatte = {{ albedo = [0.5, 0.5, 0.5] }}\n\
         [[object]]\nmaterial = \"m\"\nshape.sphere = {{ radius = 3 }}\n"
    );
    let pixels = render("samples = 16\nintegrator.path = { max_depth = 4 }", &scene);
    assert!(pixels.iter().all(|p| (p[0] - 0.4).abs() < 1e-3), "{:?}", pixels[MIDDLE]);
}

#[test]
fn smooth_glass_is_invisible_before_a_constant_background() {
    let scene = format!(
        "{CAMERA}[background]\ncolor = [0.5, 0.5, 0.5]\n[material.glass]\nglass = {{ ior = 1.5 }}\n\
         [[object]]\nmaterial = \"glass\"\nshape.sphere = {{ radius = 1 }}\n\
         [[object]]\nmaterial = \"glass\"\nshape.sphere = {{ radius = 0.5 }}\n"
    );
    let pixels = render(
        "samples = 16\nintegrator.path = { max_depth = 60, roulette_depth = 60 }",
        &scene,
    );
    assert!(pixels.iter().all(|p| (p[0] - 0.5).abs() < 1e-3), "{:?}", pixels[MIDDLE]);
}

#[test]
fn half_of_the_light_passes_what_is_half_opaque_and_so_does_its_shadow() {
    // A half opaque black square before the sky, and before a lamp whose light falls on a white floor.
    let veil = "[material.veil]\nprincipled = { base_color = [0, 0, 0], specular = 0, roughness = 1, alpha = \"blend\", opacity = 0.5 }\n\
                [[object]]\nmaterial = \"veil\"\n";
    let sky = format!(
        "{CAMERA}[background]\ncolor = [0.8, 0.8, 0.8]\n{veil}\
         shape.quad = {{ corners = [[-5, -5, 1], [5, -5, 1], [5, 5, 1], [-5, 5, 1]] }}\n"
    );
    let seen = mean(&render("samples = 256\nintegrator.path = { max_depth = 3 }", &sky));
    assert!((seen - 0.4).abs() < 0.01, "{seen}");
    let lit = |between: &str| {
        let scene = format!(
            "{CAMERA}[material.floor]\nmatte = {{ albedo = [1, 1, 1] }}\n[[object]]\nmaterial = \"floor\"\n\
             shape.quad = {{ corners = [[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]] }}\n\
             [[light]]\npoint = {{ position = [0, 0, 3], intensity = 10 }}\n{between}"
        );
        render("samples = 16\nintegrator.path = { max_depth = 2 }", &scene)[MIDDLE][0]
    };
    let square =
        "shape.quad = { corners = [[-0.2, -0.2, 2.9], [0.2, -0.2, 2.9], [0.2, 0.2, 2.9], [-0.2, 0.2, 2.9]] }\n";
    // Once on the way of the light, and once more before the camera.
    let (whole, veiled) = (lit(""), lit(&format!("{veil}{square}")));
    assert!((veiled / whole - 0.25).abs() < 0.04, "{veiled} of {whole}");
}

/// Two mirrors before a blue sky, and what else is there.
fn mirrors(more: &str) -> String {
    format!(
        "{CAMERA}[background]\ncolor = [0.3, 0.4, 0.5]\n[material.mirror]\nmirror = {{ reflectance = 0.8 }}\n\
         [[object]]\nmaterial = \"mirror\"\nshape.sphere = {{ center = [-0.6, 0, 0], radius = 0.6 }}\n\
         [[object]]\nmaterial = \"mirror\"\nshape.sphere = {{ center = [0.7, 0, 0.2], radius = 0.6 }}\n{more}"
    )
}

/// A scene with `samples` by paths and by Whitted's integrator, as deep, and nothing left to chance but glass.
fn by_path_and_whitted(samples: u32, scene: &str) -> [Vec<[f32; 3]>; 2] {
    [
        "path = { max_depth = 9, roulette_depth = 20 }",
        "whitted = { max_depth = 9 }",
    ]
    .map(|integrator| render(&format!("samples = {samples}\nintegrator.{integrator}"), scene))
}

#[test]
fn paths_agree_with_whitted_in_every_pixel_where_all_surfaces_are_mirrors() {
    let [path, whitted] = by_path_and_whitted(64, &mirrors(""));
    for (a, b) in path.iter().zip(&whitted) {
        assert!((a[2] - b[2]).abs() < 2e-3, "{a:?} {b:?}");
    }
}

#[test]
fn paths_agree_with_whitted_where_all_surfaces_are_mirrors_and_glass() {
    let glass = "[material.glass]\nglass = { ior = 1.5 }\n\
                 [[object]]\nmaterial = \"glass\"\nshape.sphere = { center = [0, 0.4, 1.4], radius = 0.5 }\n\
                 [[object]]\nmaterial = \"glass\"\nshape.cuboid = { min = [-0.5, -0.9, 1], max = [0.4, -0.4, 1.3] }\n";
    let [path, whitted] = by_path_and_whitted(1024, &mirrors(glass));
    // A path reflects or refracts by chance where Whitted's integrator does both, so blocks of 4x4 pixels are compared.
    const BLOCK: usize = 4;
    let block = |pixels: &[[f32; 3]], x: usize, y: usize| {
        let rows = (0..BLOCK).map(|row| &pixels[(y * BLOCK + row) * SIDE + x * BLOCK..][..BLOCK]);
        rows.flatten().map(|p| p[2]).sum::<f32>() / (BLOCK * BLOCK) as f32
    };
    let [without, _] = by_path_and_whitted(16, &mirrors(""));
    let mut changed = 0;
    for y in 0..SIDE / BLOCK {
        for x in 0..SIDE / BLOCK {
            let [a, b, none] = [&path, &whitted, &without].map(|pixels| block(pixels, x, y));
            assert!((a - b).abs() < 2e-3, "block {x}, {y}: {a} is not {b}");
            changed += usize::from((b - none).abs() > 0.01);
        }
    }
    assert!(changed >= 4, "the glass is seen in {changed} blocks");
}

#[test]
fn a_clamp_darkens_indirect_light_alone() {
    let scene = format!(
        "{CAMERA}[material.m]\nmatte = {{ albedo = [0.9, 0.9, 0.9] }}\n[material.lamp]\nemitter = {{ radiance = 50 }}\n\
         [[object]]\nmaterial = \"m\"\nshape.cuboid = {{ min = [-3, -3, -3], max = [3, 3, 6] }}\n\
         [[object]]\nmaterial = \"lamp\"\nshape.sphere = {{ center = [0, 2, 0], radius = 0.3 }}\n"
    );
    let with = |keys: &str| {
        mean(&render(
            &format!("samples = 32\nintegrator.path = {{ {keys} }}"),
            &scene,
        ))
    };
    assert_eq!(with("max_depth = 2"), with("max_depth = 2, clamp_indirect = 0.01"));
    let (free, clamped) = (with("max_depth = 6"), with("max_depth = 6, clamp_indirect = 0.1"));
    assert!(
        clamped < 0.9 * free && clamped > with("max_depth = 2"),
        "{clamped} {free}"
    );
}

#[test]
fn a_clamp_of_direct_light_limits_what_a_light_adds_at_the_first_surface() {
    // A wall with the light of one point light: albedo / pi * intensity * cos / d^2, which is 0.48 in the middle.
    let scene = format!(
        "{CAMERA}[material.m]\nmatte = {{ albedo = 0.5 }}\n[[light]]\npoint = {{ position = [0, 0, 2], intensity = [12, 6, 3] }}\n\
         [[object]]\nmaterial = \"m\"\nshape.quad = {{ corners = [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]] }}\n"
    );
    let with = |keys: &str| render(&format!("samples = 1\nintegrator.path = {{ {keys} }}"), &scene);
    let (free, clamped) = (with(""), with("clamp_direct = 0.2"));
    assert!((free[MIDDLE][0] - 0.5 / std::f32::consts::PI * 12.0 / 4.0).abs() < 0.02);
    let mut limited = 0;
    for (free, clamped) in free.iter().zip(&clamped) {
        let scale = (0.2 / free[0]).min(1.0);
        limited += usize::from(scale < 1.0);
        for c in 0..3 {
            assert!((clamped[c] - free[c] * scale).abs() < 2e-3, "{free:?} {clamped:?}");
        }
    }
    assert!((10..SIDE * SIDE).contains(&limited), "{limited}");
    assert_eq!(with("clamp_direct = 1"), free);
}

#[test]
fn a_clamp_of_direct_light_leaves_emitters_and_indirect_light_alone() {
    let scene = |lamp: &str| {
        format!(
            "{CAMERA}[material.m]\nmatte = {{ albedo = 0.7 }}\n[material.lamp]\nemitter = {{ radiance = 50 }}\n\
             [[object]]\nmaterial = \"m\"\nshape.cuboid = {{ min = [-3, -3, -3], max = [3, 3, 6] }}\n\
             [[object]]\nmaterial = \"lamp\"\nshape.sphere = {{ center = {lamp}, radius = 0.3 }}\n"
        )
    };
    let with = |keys: &str, lamp: &str| render(&format!("samples = 16\nintegrator.path = {{ {keys} }}"), &scene(lamp));
    let hidden = "[0, 2.5, 5.5]";
    let indirect = |clamp: &str| {
        let all = mean(&with(&format!("max_depth = 5{clamp}"), hidden));
        (all - mean(&with(&format!("max_depth = 2{clamp}"), hidden)), all)
    };
    let ((free, all), (clamped, fewer)) = (indirect(""), indirect(", clamp_direct = 0.01"));
    assert!((free - clamped).abs() < 1e-3 * free, "{free} {clamped}");
    assert!(fewer < 0.9 * all, "{fewer} {all}");
    assert!(with("max_depth = 2, clamp_direct = 0.01", "[0, 0, 0]")[MIDDLE][0] > 49.0);
}

/// The attribute `name` of the header of `file`.
fn attribute(folder: &Folder, file: &str, name: &str) -> Option<exr::meta::attribute::AttributeValue> {
    let meta = exr::meta::MetaData::read_from_file(folder.path(file), false).expect("an EXR");
    let header = &meta.headers[0];
    header
        .own_attributes
        .other
        .get(&exr::meta::attribute::Text::from(name))
        .cloned()
}

#[test]
fn a_file_names_the_limits_that_are_set() {
    use exr::meta::attribute::AttributeValue::{F32, I32};
    let folder = Folder::new();
    let scene = |keys: &str| format!("[render]\nwidth = 4\nheight = 4\nintegrator.path = {{ {keys} }}\n{CAMERA}");
    folder.write("free.toml", &scene(""));
    folder.write(
        "s.toml",
        &scene("max_depth = 6, clamp_direct = 7, clamp_indirect = 2.5, max_specular = 3"),
    );
    for name in ["free", "s"] {
        let (scene, file) = (format!("{name}.toml"), format!("{name}.exr"));
        folder.succeed(&[&scene, "--progress", "none", "-o", &file]);
    }
    let said = |file: &str, name: &str| attribute(&folder, file, &format!("batch-render/{name}"));
    assert_eq!(said("s.exr", "clampIndirect"), Some(F32(2.5)));
    assert_eq!(said("s.exr", "clampDirect"), Some(F32(7.0)));
    assert_eq!(said("free.exr", "clampDirect"), None);
    assert_eq!(said("s.exr", "maxDepth"), Some(I32(6)));
    assert_eq!(said("s.exr", "maxSpecular"), Some(I32(3)));
    assert_eq!(said("s.exr", "maxDiffuse"), None);
    assert_eq!(said("free.exr", "clampIndirect"), None);
    assert_eq!(said("free.exr", "maxDepth"), Some(I32(8)));
}

#[test]
fn infinite_samples_are_left_out_counted_and_reported_with_their_pixels_whatever_the_threads() {
    let folder = Folder::new();
    // What shines with 1e30 times 1e30 is seen in a few pixels left of the middle, and lights a wall behind it.
    folder.write(
        "s.toml",
        &format!(
            "[render]\nwidth = 24\nheight = 24\nsamples = 4\nintegrator.path = {{ max_depth = 1 }}\n{CAMERA}\
             [background]\ncolor = 0.5\n\
             [material.m]\nprincipled = {{ emissive = 1e30, emissive_strength = 1e30 }}\n\
             [[object]]\nmaterial = \"m\"\nshape.sphere = {{ center = [-0.5, 0, 0], radius = 0.1 }}\n"
        ),
    );
    let run = |threads: &str| {
        let file = format!("{threads}.exr");
        let output = folder.run(&["s.toml", "--progress", "none", "-t", threads, "-o", &file]);
        assert!(output.status.success());
        (crate::common::stderr(&output), folder.read(&file))
    };
    let one = run("1");
    assert!(
        one.0.contains("frame 1: ") && one.0.contains(" left out (not a number, or infinite)"),
        "{}",
        one.0
    );
    assert!(one.0.contains("column and row: (8, 11), (9, 11)"), "{}", one.0);
    assert!(one == run("2") && one == run("7"));
    let output = folder.run(&["s.toml", "-q", "-o", "q.exr"]);
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "errors alone are told"
    );
}
