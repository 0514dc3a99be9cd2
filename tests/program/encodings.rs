//! The encodings of EXR files: compressions, types, parts and windows, through another reader.

use std::collections::BTreeMap;

use crate::common::{Folder, repo_str};
use exr::prelude::{FlatImage, FlatSamples, ReadChannels, ReadLayers, read};

const SMALL: [&str; 6] = ["--resolution", "48x27", "--samples", "4", "--progress", "none"];

/// The file that the scene of all passes becomes with these arguments.
fn render(args: &[&str]) -> FlatImage {
    let folder = Folder::new();
    let scene = repo_str("scenes/passes/scene.toml");
    folder.succeed(&[&[&scene, "-o", "f.exr"], args, &SMALL[..]].concat());
    let again = [&[&scene, "-o", "f.exr", "--skip-existing"], args, &SMALL[..4]].concat();
    let again = folder.succeed(&again);
    assert!(again.contains("skipped"), "the file is not known to be whole: {again}");
    let reader = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes();
    reader.pedantic().from_file(folder.path("f.exr")).expect("an EXR")
}

/// The bits of all channels by their names, whichever part they are in.
fn channels(image: &FlatImage) -> BTreeMap<String, Vec<u32>> {
    let list = image.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
    let bits = |samples: &FlatSamples| match samples {
        FlatSamples::F16(v) => v.iter().map(|v| u32::from(v.to_bits())).collect(),
        FlatSamples::F32(v) => v.iter().map(|v| v.to_bits()).collect(),
        FlatSamples::U32(v) => v.clone(),
    };
    list.map(|c| (c.name.to_string(), bits(&c.sample_data))).collect()
}

#[test]
fn every_lossless_compression_keeps_every_bit_of_every_layer() {
    let plain = channels(&render(&["--compression", "none"]));
    assert!(plain.len() > 60);
    for compression in ["zips", "zip", "piz", "rle"] {
        assert!(
            channels(&render(&["--compression", compression])) == plain,
            "{compression}"
        );
    }
}

#[test]
fn tiles_hold_the_same_as_lines_with_every_compression_and_in_parts() {
    let lines = channels(&render(&[]));
    for compression in ["none", "zips", "zip", "piz", "rle"] {
        let tiled = render(&["--tiled", "--compression", compression]);
        let blocks = tiled.layer_data[0].encoding.blocks;
        assert_eq!(
            blocks,
            exr::prelude::Blocks::Tiles(exr::prelude::Vec2(64, 64)),
            "{compression}"
        );
        assert!(channels(&tiled) == lines, "{compression}");
    }
    assert!(channels(&render(&["--tiled", "--multipart"])) == lines);
}

#[test]
fn parts_hold_the_same_layers_as_one_file_each_under_its_name() {
    let (one, many) = (render(&[]), render(&["--multipart"]));
    assert_eq!(one.layer_data.len(), 1);
    assert!(channels(&one) == channels(&many));
    let name = |layer: &exr::prelude::Layer<_>| layer.attributes.layer_name.as_ref().map(ToString::to_string);
    let names: Vec<String> = many.layer_data.iter().filter_map(name).collect();
    assert_eq!(names.len(), many.layer_data.len());
    assert_eq!(names[..2], ["beauty", "diffuse_direct"]);
    let mattes = many
        .layer_data
        .iter()
        .find(|layer| name(layer).as_deref() == Some("CryptoAsset"))
        .expect("the part");
    assert_eq!(mattes.channel_data.list.len(), 12);
    let crypto = |layer: &exr::prelude::Layer<_>| {
        let names = layer.attributes.other.keys();
        names
            .filter(|name| name.to_string().starts_with("cryptomatte/"))
            .count()
    };
    let counts: Vec<usize> = many.layer_data.iter().map(crypto).collect();
    assert_eq!((crypto(mattes), counts.iter().sum::<usize>()), (4, 12));
}

#[test]
fn floats_on_request_are_what_halves_were_rounded_from() {
    let (half, float) = (
        render(&["--aovs", "N"]),
        render(&["--aovs", "N", "--exr-type", "float"]),
    );
    let (halves, floats) = (
        &half.layer_data[0].channel_data.list,
        &float.layer_data[0].channel_data.list,
    );
    assert_eq!(halves.len(), 7);
    for (half, float) in halves.iter().zip(floats) {
        let (FlatSamples::F16(halves), FlatSamples::F32(floats)) = (&half.sample_data, &float.sample_data) else {
            panic!("{}: the types are wrong", half.name);
        };
        assert!(
            halves.iter().zip(floats).all(|(h, f)| *h == half::f16::from_f32(*f)),
            "{}",
            half.name
        );
    }
}

#[test]
fn overscan_surrounds_the_picture_and_leaves_its_bits() {
    let (plain, wide) = (
        render(&["--aovs", "depth"]),
        render(&["--aovs", "depth", "--overscan", "5"]),
    );
    let layer = &wide.layer_data[0];
    assert_eq!((layer.size.0, layer.size.1), (58, 37));
    let corner = layer.attributes.layer_position;
    assert_eq!((corner.0, corner.1), (-5, -5));
    assert_eq!(wide.attributes.display_window, plain.attributes.display_window);
    let wide = channels(&wide);
    for (name, own) in channels(&plain) {
        let inner = (5..32).flat_map(|y| wide[&name][y * 58 + 5..][..48].to_vec());
        assert!(inner.eq(own), "{name}");
    }
}

#[test]
fn a_lossy_compression_is_for_pictures_alone() {
    let plain = render(&["--aovs", "emission"]);
    let lossy = render(&["--aovs", "emission", "--compression", "dwaa"]);
    let values = |image: &FlatImage| -> Vec<f32> {
        let list = &image.layer_data[0].channel_data.list;
        list.iter()
            .flat_map(|c| c.sample_data.values_as_f32().collect::<Vec<_>>())
            .collect()
    };
    let (plain, lossy) = (values(&plain), values(&lossy));
    let off = plain
        .iter()
        .zip(&lossy)
        .map(|(a, b)| f64::from((a - b).abs() / (0.1 + a.abs())))
        .sum::<f64>();
    assert!(plain != lossy && off / (plain.len() as f64) < 0.02, "{off}");

    let folder = Folder::new();
    let scene = repo_str("scenes/passes/scene.toml");
    for pass in ["depth", "CryptoObject", "variance"] {
        let args = [&scene, "-o", "f.exr", "--compression", "dwaa", "--aovs"];
        let error = folder.fail(2, &[&args[..], &[pass]].concat());
        let expected = format!("the compression `dwaa` would ruin the data of the pass `{pass}`: use a lossless one");
        assert!(error.contains(&expected), "{error}");
    }
    assert!(folder.names().is_empty());
}

#[test]
fn wrong_names_and_windows_are_refused() {
    let folder = Folder::new();
    let scene = repo_str("scenes/passes/scene.toml");
    for (args, message) in [
        (
            &["--compression", "zisp"][..],
            "--compression: unknown compression `zisp`",
        ),
        (&["--exr-type", "double"], "--exr-type: unknown type `double`"),
        (&["--overscan", "4", "--crop", "0,0,4,4"], "cannot be used with"),
    ] {
        let error = folder.fail(2, &[&[scene.as_str(), "-o", "f.exr"], args].concat());
        assert!(error.contains(message), "{error}");
    }
}
