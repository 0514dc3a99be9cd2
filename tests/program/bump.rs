//! Height maps of OBJ materials and of materials of scene files shade a flat surface as the surface that they describe.

use crate::common::Folder;

/// A square of 2 m that faces +z; its texture coordinates run from 0 to 1. `slope` tilts it about the y axis.
fn square(slope: f32, material: &str) -> String {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let positions = corners.map(|[x, y]: [f32; 2]| format!("v {x} {y} {}\n", slope * x));
    format!(
        "mtllib m.mtl\n{}vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl {material}\nf 1/1 2/2 3/3 4/4\n",
        positions.concat()
    )
}

/// The middle of the picture of a square with this material, slope and transform, from +z in slanting light.
fn middle(folder: &Folder, material: &str, slope: f32, objects: &[&str]) -> [f32; 3] {
    folder.write("a.obj", &square(slope, material));
    let objects: String = objects
        .iter()
        .map(|rest| format!("[[object]]\nshape.mesh = {{ file = \"a.obj\" }}\n{rest}\n"))
        .collect();
    let pixels = folder.render(&format!(
        "[render]\nwidth = 8\nheight = 8\nsamples = 4\nintegrator.path = {{ max_depth = 2 }}\n\
         [camera]\northographic = {{ eye = [0.1, 0.2, 5], target = [0.1, 0.2, 0], height = 0.4 }}\n\
         [[light]]\nsun = {{ direction = [-1, -0.5, -1], irradiance = [3, 3, 3], angle = 0 }}\n{objects}"
    ));
    pixels.iter().fold([0.0; 3], |sum, p| {
        [0, 1, 2].map(|k| sum[k] + p[k] / pixels.len() as f32)
    })
}

/// Pictures whose heights rise by 1 from left to right: in all channels, in the green one, and as colours of normals.
fn folder(slope: f32) -> Folder {
    let folder = Folder::new();
    let ramp = image::GrayImage::from_fn(256, 4, |x, _| image::Luma([x as u8]));
    ramp.save(folder.path("ramp.png")).expect("written");
    let green = image::RgbImage::from_fn(256, 4, |x, y| image::Rgb([(40 * y) as u8, x as u8, 0]));
    green.save(folder.path("green.png")).expect("written");
    let length = (1.0 + slope * slope).sqrt();
    let [x, z] = [-slope / length, 1.0 / length].map(|v| (255.0 * (0.5 + 0.5 * v)).round() as u8);
    let normals = image::RgbImage::from_pixel(4, 4, image::Rgb([x, 128, z]));
    normals.save(folder.path("normals.png")).expect("written");
    folder.write(
        "m.mtl",
        "newmtl plain\nKd 0.5 0.5 0.5\nnewmtl ramp\nKd 0.5 0.5 0.5\nmap_Bump ramp.png\n\
         newmtl weak\nKd 0.5 0.5 0.5\nbump -bm -0.25 ramp.png\n\
         newmtl green\nKd 0.5 0.5 0.5\nbump -imfchan g green.png\n\
         newmtl normals\nKd 0.5 0.5 0.5\nmap_Bump normals.png\n",
    );
    folder
}

/// The slope of the ramp: 256 texels of 1/255 each over 2 m.
const SLOPE: f32 = 256.0 / 255.0 / 2.0;

fn assert_close(a: [f32; 3], b: [f32; 3], tolerance: f32, what: &str) {
    let close = (0..3).all(|k| (a[k] / b[k] - 1.0).abs() < tolerance);
    assert!(close, "{what}: {a:?} instead of {b:?}");
}

#[test]
fn a_ramp_of_heights_shades_a_plane_as_the_tilted_plane() {
    let folder = folder(SLOPE);
    let flat = middle(&folder, "plain", 0.0, &[""]);
    for (material, slope) in [("ramp", SLOPE), ("weak", -0.25 * SLOPE), ("green", SLOPE)] {
        let tilted = middle(&folder, "plain", slope, &[""]);
        assert!(
            (tilted[0] / flat[0] - 1.0).abs() > 0.05,
            "{material}: the light tells nothing"
        );
        assert_close(middle(&folder, material, 0.0, &[""]), tilted, 0.004, material);
    }
}

#[test]
fn heights_grow_with_their_object() {
    let folder = folder(SLOPE);
    let tilted = middle(&folder, "plain", SLOPE, &[""]);
    let larger = "transform = { scale = 3 }";
    let behind = "transform = { translate = [0, 0, -9], scale = 3 }";
    for objects in [&[larger][..], &[larger, behind]] {
        assert_close(
            middle(&folder, "ramp", 0.0, objects),
            tilted,
            0.004,
            &objects.join(", "),
        );
    }
}

#[test]
fn heights_are_stretched_and_sheared_with_their_object() {
    let folder = folder(SLOPE);
    let shear = "matrix = [[1.2, 0.3, 0.4, 0], [0, 0.8, -0.2, 0], [0.3, 0.1, 2, 0], [0, 0, 0, 1]]";
    for map in [
        "scale = [1, 1, 1.6]",
        "scale = [4, 1, 1]",
        "rotate = [10, 20, 30]\nscale = [2, 1, 0.5]",
        shear,
    ] {
        let larger = format!("[object.transform]\n{map}\n");
        // A mesh that is used twice is not brought into the space of the scene.
        let behind = "transform = { translate = [0, 0, -90] }";
        for objects in [&[larger.as_str()][..], &[&larger, behind]] {
            let tilted = middle(&folder, "plain", SLOPE, objects);
            assert_close(
                middle(&folder, "ramp", 0.0, objects),
                tilted,
                0.004,
                &objects.join(", "),
            );
        }
        // The same for shapes.
        let bump = "bump = { height = \"texture.rise\", distance = 0.6 }";
        let [lifted, tilted] =
            [(0.0, bump), (0.3, "")].map(|(slope, more)| middle_of(MATERIALS[0], slope, more, &larger));
        assert_close(lifted, tilted, 0.004, map);
    }
}

#[test]
fn a_bump_that_holds_normals_is_a_normal_map() {
    let folder = folder(SLOPE);
    let tilted = middle(&folder, "plain", SLOPE, &[""]);
    assert_close(middle(&folder, "normals", 0.0, &[""]), tilted, 0.01, "normals");
}

/// Light from a sun, and light from everywhere, which a mirror shows.
const SUN: &str = "[[light]]\nsun = { direction = [-1, -0.5, -1], irradiance = [3, 3, 3], angle = 0 }\n";
const GRADIENT: &str = "[background]\ngradient = { up = [0.1, 0.2, 0.9], side = [0.5, 0.3, 0.2], down = 0.1 }\n";

/// Materials of scene files, each with its light.
const MATERIALS: [(&str, &str); 8] = [
    ("matte = { albedo = 0.5 }", SUN),
    ("matte = { albedo = 0.5, roughness = 0.7 }", SUN),
    (
        "phong = { color = [0.5, 0.4, 0.3], specular = 0.3, shininess = 4 }",
        SUN,
    ),
    ("metal = { preset = \"copper\", roughness = 0.6 }", SUN),
    ("glass = { roughness = 0.6 }", SUN),
    ("mirror = {}", GRADIENT),
    ("principled = { base_color = 0.5, roughness = 0.6 }", SUN),
    ("principled = { base_color = 0.5, roughness = 0.5, metallic = 1 }", SUN),
];

/// The direction in which the heights of the next function rise.
const UPHILL: [f32; 2] = [0.866_025_4, 0.5];

/// The middle of the picture of a square with this material and light, whose height rises by `slope`.
fn middle_of(material: (&str, &str), slope: f32, more: &str, object: &str) -> [f32; 3] {
    middle_by("path", material, slope, more, object)
}

/// The same by this integrator.
fn middle_by(integrator: &str, (material, light): (&str, &str), slope: f32, more: &str, object: &str) -> [f32; 3] {
    let corner = |[x, y]: [f32; 2]| format!("[{x}, {y}, {}]", slope * (UPHILL[0] * x + UPHILL[1] * y));
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner);
    let pixels = Folder::new().render(&format!(
        "[render]\nwidth = 8\nheight = 8\nsamples = 64\nintegrator.{integrator} = {{ max_depth = 2 }}\n\
         [camera]\northographic = {{ eye = [0.1, 0.2, 5], target = [0.1, 0.2, 0], height = 0.4 }}\n{light}\
         [texture.rise]\ngradient = {{}}\nmapping.object = {{ scale = 0.5, rotate = [0, 0, -30], offset = [0.5, 0, 0] }}\n\
         [material.m]\n{material}\n{more}\n\
         [[object]]\nmaterial = \"m\"\nshape.quad = {{ corners = [{}] }}\n{object}",
        corners.join(", ")
    ));
    pixels.iter().fold([0.0; 3], |sum, p| {
        [0, 1, 2].map(|k| sum[k] + p[k] / pixels.len() as f32)
    })
}

#[test]
fn whitted_shades_a_bump_as_the_tilted_surface() {
    for material in [MATERIALS[2], MATERIALS[5]] {
        let shaded = |slope, more| middle_by("whitted", material, slope, more, "");
        let bumped = shaded(0.0, "bump = { height = \"texture.rise\", distance = 0.6 }");
        let (flat, tilted) = (shaded(0.0, ""), shaded(0.3, ""));
        assert!(
            (tilted[0] / flat[0] - 1.0).abs() > 0.03,
            "{material:?}: the light tells nothing"
        );
        assert_close(bumped, tilted, 0.01, material.0);
    }
}

#[test]
fn a_bump_of_any_material_shades_as_the_tilted_surface() {
    for material in MATERIALS {
        let bumped = middle_of(
            material,
            0.0,
            "bump = { height = \"texture.rise\", distance = 0.6 }",
            "",
        );
        let (flat, tilted) = (middle_of(material, 0.0, "", ""), middle_of(material, 0.3, "", ""));
        let differs = (0..3).any(|k| (tilted[k] / flat[k] - 1.0).abs() > 0.03);
        assert!(differs, "{material:?}: the light tells nothing");
        assert_close(bumped, tilted, 0.01, material.0);
    }
}
