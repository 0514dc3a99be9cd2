//! A picture computed in ACEScg is that of Rec. 709 in other numbers, as long as light is a sum of products with gray.

use crate::common::{Folder, repo};
use batch_render::{
    batch::{Job, Request},
    describe::Overrides,
    film::Film,
    math::{Rgb, WorkingSpace},
    render::Control,
};

/// A scene of one material, `m`, under a sky.
fn scene(working_space: &str, sky: &str, material: &str, rest: &str) -> String {
    format!(
        "[render]\nwidth = 24\nheight = 16\nsamples = 4\nworking_space = \"{working_space}\"\n\
         integrator.path = {{ max_depth = 2 }}\n\
         [camera]\nperspective = {{ eye = [0, 0.4, 4], target = [0, 0, 0], fov = 30 }}\n\
         [background]\n{sky}\n[material.m]\n{material}\n\
         [[object]]\nmaterial = \"m\"\nshape.sphere = {{ center = [0, 0, 0], radius = 0.9 }}\n{rest}\n"
    )
}

fn film(folder: &Folder, text: &str) -> Film {
    let request = Request {
        overrides: Overrides::default().with("output.aovs", "albedo"),
        ..Request::default()
    };
    let job = Job::open(&folder.write("s.toml", text), &request).unwrap_or_else(|e| panic!("{e}"));
    let scene = job.compile().unwrap_or_else(|e| panic!("{e}"));
    job.render_frame(&mut job.scenes(scene), 0, &Control::default())
        .expect("a film")
}

/// The largest difference between the picture in ACEScg and the converted one in Rec. 709, relative to the brightest pixel.
fn difference(sky: &str, material: &str, rest: &str) -> f32 {
    let folder = Folder::new();
    folder.write(
        "ball.obj",
        "o a\nv -1 -1 0.95 1 0 0\nv 1 -1 0.95 0 1 0\nv 0 1 0.95 0 0 1\nf 1 2 3\n",
    );
    for (name, pixels) in [
        ("a.png", [[200, 30, 90], [20, 180, 250]]),
        ("b.png", [[0, 255, 0], [255, 0, 0]]),
    ] {
        image::RgbImage::from_fn(2, 1, |x, _| image::Rgb(pixels[x as usize]))
            .save(folder.path(name))
            .expect("a PNG");
    }
    std::fs::copy(repo("scenes/kinds/sky.hdr"), folder.path("sky.hdr")).expect("the sky");
    let [plain, ap1] = ["rec709", "acescg"].map(|space| film(&folder, &scene(space, sky, material, rest)));
    let colors = |film: &Film| -> Vec<Rgb> { film.beauty().iter().map(|[r, g, b, _]| Rgb::new(*r, *g, *b)).collect() };
    let (plain, ap1) = (colors(&plain), colors(&ap1));
    let brightest = ap1.iter().fold(0.0_f32, |m, c| m.max(c.max_component()));
    assert!(brightest > 0.05, "{material}: the picture is black");
    assert!(plain != ap1, "{material}: nothing is converted");
    let off = |(a, b): (&Rgb, &Rgb)| {
        (WorkingSpace::AcesCg.from_rec709(*a) - *b)
            .map(f32::abs)
            .max_component()
    };
    plain.iter().zip(&ap1).map(off).fold(0.0, f32::max) / brightest
}

const GRAY_SKY: &str = "color = 0.7";
const WHITE: &str = "matte = { albedo = 0.8 }";

#[test]
fn colours_of_materials_are_converted() {
    for material in [
        "matte = { albedo = [0.9, 0.2, 0.1] }",
        "mirror = { reflectance = [0.1, 0.8, 0.3] }",
        "emitter = { radiance = [3, 0.2, 0.1] }",
        "metal = { color = [0.9, 0.5, 0.2] }",
        "principled = { base_color = [0.1, 0.7, 0.2], metallic = 1, roughness = 0 }",
        "glass = { transmittance = 0, reflectance = [0.1, 0.2, 0.9], thin_walled = true }",
    ] {
        let off = difference(GRAY_SKY, material, "");
        assert!(off < 2e-5, "{material}: {off}");
    }
}

#[test]
fn measured_metals_keep_their_colour_but_for_a_fiftieth() {
    for preset in ["gold", "copper", "silver"] {
        let off = difference(GRAY_SKY, &format!("metal = {{ preset = \"{preset}\" }}"), "");
        assert!(off < 0.02, "{preset}: {off}");
    }
}

#[test]
fn textures_are_converted_where_they_hold_colours() {
    let material = "matte = { albedo = \"texture.t\" }";
    for pattern in [
        "image = { file = \"a.png\" }",
        "image = { file = \"a.png\", filter = \"nearest\" }",
        "constant = { color = [0.9, 0.1, 0.2] }",
        "checker = { a = [0.9, 0.1, 0.2], b = [0.1, 0.1, 0.8], scale = 4 }",
        "stripes = { a = [0.9, 0.1, 0.2], b = [0.1, 0.1, 0.8], width = 0.1 }",
    ] {
        let off = difference(
            GRAY_SKY,
            material,
            &format!("[texture.t]\n{pattern}\nmapping = \"uv\"\n"),
        );
        assert!(off < 2e-5, "{pattern}: {off}");
    }
}

#[test]
fn pictures_of_data_stay_as_they_are() {
    let folder = Folder::new();
    image::RgbImage::from_pixel(1, 1, image::Rgb([0, 255, 0]))
        .save(folder.path("data.png"))
        .expect("a PNG");
    let raw = "[texture.t]\nimage = { file = \"data.png\", color_space = \"raw\" }\nmapping = \"uv\"\n";
    let film = film(
        &folder,
        &scene("acescg", GRAY_SKY, "matte = { albedo = \"texture.t\" }", raw),
    );
    let [r, g, b] = film.plane("albedo").expect("a pass").values.as_chunks().0[24 * 8 + 12];
    assert!(r == 0.0 && (g - 1.0).abs() < 1e-6 && b == 0.0, "{r} {g} {b}");
}

#[test]
fn lights_and_skies_are_converted() {
    for (sky, light) in [
        ("color = [0.1, 0.2, 0.9]", ""),
        (
            "color = 0",
            "[[light]]\nsun = { direction = [-1, -1, -1], irradiance = [3, 0.5, 0.1] }\n",
        ),
        (
            "color = 0",
            "[[light]]\npoint = { position = [1, 2, 3], intensity = [0.5, 30, 2] }\n",
        ),
        (
            "color = 0",
            "[[light]]\nspot = { position = [1, 2, 3], target = [0, 0, 0], cone_angle = 30, intensity = [0.5, 3, 40] }\n",
        ),
    ] {
        let off = difference(sky, WHITE, light);
        assert!(off < 2e-5, "{sky} {light}: {off}");
    }
    // In a mirror: the directions that are sampled on matte surfaces depend on the colours of the sky.
    let off = difference(
        "environment = { file = \"sky.hdr\" }",
        "mirror = { reflectance = 1 }",
        "",
    );
    assert!(off < 2e-5, "sky.hdr: {off}");
    // Whitted's ambient light is a light, too.
    let folder = Folder::new();
    let ambient = |space: &str| {
        let path = "integrator.path = { max_depth = 2 }";
        let text = scene(space, "color = 0", WHITE, "");
        let text = text.replace(path, "integrator.whitted = { ambient = [0.9, 0.1, 0.1] }");
        film(&folder, &text).beauty()[24 * 8 + 12]
    };
    let ([r, g, b, _], found) = (ambient("rec709"), ambient("acescg"));
    let expected = WorkingSpace::AcesCg.from_rec709(Rgb::new(r, g, b)).to_array();
    assert!(
        (0..3).all(|i| (expected[i] - found[i]).abs() < 1e-6) && found[0] > 0.1,
        "{expected:?} {found:?}"
    );
}

#[test]
fn colours_of_models_are_converted() {
    let model = "[[object]]\nname = \"model\"\nshape.mesh = { file = \"ball.obj\" }\n";
    let off = difference(GRAY_SKY, WHITE, model);
    assert!(off < 2e-5, "{off}");
}

#[test]
fn files_tell_the_space_and_pictures_are_shown_in_rec_709() {
    let folder = Folder::new();
    for space in ["rec709", "acescg"] {
        let text = scene(space, GRAY_SKY, "matte = { albedo = [0.9, 0.2, 0.1] }", "");
        folder.write("s.toml", &text);
        for view in ["srgb", "raw", "aces"] {
            let (exr, png) = (format!("{space}.{view}.exr"), format!("{space}.{view}.png"));
            folder.succeed(&["s.toml", "-o", &exr, "-o", &png, "--view", view, "--progress", "none"]);
        }
    }
    let primaries = |name: &str| folder.open_exr(name).attributes.chromaticities;
    let red = primaries("acescg.srgb.exr").expect("chromaticities").red;
    assert_eq!((red.0, red.1), (0.713, 0.293));
    let id = |name: &str| {
        let image = folder.open_exr(name);
        let (shared, own) = (&image.attributes.other, &image.layer_data[0].attributes.other);
        let wanted = exr::prelude::Text::from("colorInteropID");
        let found = shared.get(&wanted).or(own.get(&wanted));
        found.map(|value| format!("{value:?}")).unwrap_or_default()
    };
    assert!(id("acescg.srgb.exr").contains("lin_ap1_scene") && id("rec709.srgb.exr").contains("lin_rec709_scene"));
    // The numbers of ACEScg are light whatever the view is.
    assert!(primaries("acescg.raw.exr").is_some() && primaries("rec709.raw.exr").is_none());
    for view in ["srgb", "raw", "aces"] {
        let picture = |space: &str| {
            let bytes = folder.read(&format!("{space}.{view}.png"));
            image::load_from_memory(&bytes).expect("a PNG").into_rgb8()
        };
        let (plain, ap1) = (picture("rec709"), picture("acescg"));
        let off = plain.iter().zip(ap1.iter()).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(off.expect("pixels") <= 1, "{view}: {off:?}");
    }
    folder.write("s.toml", &scene("acesgc", GRAY_SKY, WHITE, ""));
    let error = folder.fail(65, &["s.toml", "-o", "f.exr"]);
    assert!(error.contains("acesgc") && error.contains("acescg"), "{error}");
}
