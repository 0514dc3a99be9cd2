//! Files for people who make data sets: depth in millimetres, and pictures of 16 bits.

mod common;

use common::{Folder, repo_str};

const SMALL: [&str; 6] = ["--resolution", "48x27", "--samples", "4", "--progress", "none"];

#[test]
fn depth_in_millimetres_is_the_pass_and_nothing_is_0() {
    let folder = Folder::new();
    let scene = repo_str("scenes/passes/scene.toml");
    folder.succeed(
        &[
            &[&scene, "-o", "f.exr", "-o", "f.png", "--png-depth", "--aovs", "N"],
            &SMALL[..],
        ]
        .concat(),
    );
    assert_eq!(folder.names(), ["depth.0001.png", "f.exr", "f.png"]);
    let depth = image::load_from_memory(&folder.read("depth.0001.png"))
        .expect("a PNG")
        .into_luma16();
    let image = exr::prelude::read_all_flat_layers_from_file(folder.path("f.exr")).expect("an EXR");
    let list = &image.layer_data[0].channel_data.list;
    let z = list
        .iter()
        .find(|c| c.name.to_string() == "depth.Z")
        .expect("the pass is in the film");
    for (pixel, z) in depth.pixels().zip(z.sample_data.values_as_f32()) {
        let expected = if z > 1e9 { 0.0 } else { (z * 1000.0).round() };
        assert_eq!(f32::from(pixel.0[0]), expected);
    }
    assert!(depth.pixels().any(|p| p.0[0] == 0) && depth.pixels().any(|p| p.0[0] > 3000));
    let again = [&[&scene, "-o", "f.exr", "--png-depth", "--skip-existing"], &SMALL[..4]].concat();
    let again = folder.succeed(&again);
    assert!(again.contains("skipped"), "{again}");
    let error = folder.fail(2, &[&scene, "-o", "f.exr", "--png-depth=depth.exr"]);
    assert!(
        error.contains("--png-depth: expected a pattern that ends in .png, found `depth.exr`"),
        "{error}"
    );
}

#[test]
fn pictures_of_16_bits_and_dithered_ones_are_the_same_picture() {
    let folder = Folder::new();
    let scene = repo_str("scenes/passes/scene.toml");
    let picture = |name: &str, bits: &str| {
        folder.succeed(&[&[&scene, "-o", name, "--png-bits", bits], &SMALL[..]].concat());
        image::load_from_memory(&folder.read(name)).expect("a PNG")
    };
    let (eight, sixteen) = (picture("8.png", "8"), picture("16.png", "16"));
    assert_eq!(sixteen.color(), image::ColorType::Rgba16);
    let dithered = picture("d.png", "8-dithered").into_rgba8();
    assert_eq!(dithered, picture("again.png", "8-dithered").into_rgba8());
    let mut changed = 0;
    for ((a, b), c) in eight
        .into_rgba8()
        .iter()
        .zip(sixteen.into_rgba16().iter())
        .zip(dithered.iter())
    {
        let exact = f32::from(*b) / 257.0;
        assert!((f32::from(*a) - exact).abs() < 0.51 && (f32::from(*c) - exact).abs() < 1.0);
        changed += usize::from(a != c);
    }
    assert!(changed > 100);
    let error = folder.fail(2, &[&scene, "-o", "f.png", "--png-bits", "12"]);
    assert!(error.contains("--png-bits: unknown bits `12`"), "{error}");
}

#[test]
fn every_view_is_a_picture_of_its_own() {
    let folder = Folder::new();
    let scene = repo_str("scenes/passes/scene.toml");
    let views = ["raw", "srgb", "reinhard", "aces", "agx", "neutral"];
    let pictures = views.map(|view| {
        folder.succeed(&[&[&scene, "-o", "f.png", "--view", view, "--exposure", "1"], &SMALL[..]].concat());
        image::load_from_memory(&folder.read("f.png"))
            .expect("a PNG")
            .into_rgba8()
    });
    for (i, picture) in pictures.iter().enumerate() {
        assert!(pictures[..i].iter().all(|other| other != picture), "{}", views[i]);
    }
}
