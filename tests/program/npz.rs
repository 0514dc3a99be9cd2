//! NPZ files: their arrays are the channels of the EXR files of the same job, and jobs trust them as they trust those.

use std::{collections::BTreeMap, fs};

use serde_json::Value;

use crate::common::{Folder, SMALL_PATH, SMALL_SCENE, repo_str};

/// The arrays of a file of stored members, by their names: the header of each and its data.
fn arrays(file: &[u8]) -> BTreeMap<String, (String, Vec<u8>)> {
    let number = |at: usize, length: usize| (0..length).rev().fold(0, |n, i| n << 8 | usize::from(file[at + i]));
    let (mut arrays, mut at) = (BTreeMap::new(), 0);
    while file[at..].starts_with(b"PK\x03\x04") {
        let (size, name, fields) = (number(at + 18, 4), number(at + 26, 2), number(at + 28, 2));
        let text = |from: usize, length: usize| String::from_utf8(file[from..from + length].to_vec()).expect("a text");
        let data = at + 30 + name + fields;
        assert_eq!((&file[data..data + 8], data % 64), (&b"\x93NUMPY\x01\0"[..], 0));
        let (header, array) = (number(data + 8, 2), data + 10 + number(data + 8, 2));
        let facts = text(data + 10, header).trim_end().to_owned();
        arrays.insert(text(at + 30, name), (facts, file[array..data + size].to_vec()));
        at = data + size;
    }
    assert!(file[at..].starts_with(b"PK\x01\x02"));
    arrays
}

/// Files of the same numbers.
const FILES: [&str; 6] = ["-o", "f.exr", "-o", "f.npz", "--exr-type", "float"];

/// The bits of the numbers of an array.
fn bits(array: &[u8]) -> Vec<u32> {
    let numbers = array.as_chunks().0.iter();
    numbers.map(|number| u32::from_le_bytes(*number)).collect()
}

/// The bits of the channels of an EXR file of floats.
fn channels(folder: &Folder, name: &str) -> BTreeMap<String, Vec<u32>> {
    let image = folder.open_exr(name);
    let list = image.layer_data[0].channel_data.list.iter();
    let bits = |data: &exr::prelude::FlatSamples| match data {
        exr::prelude::FlatSamples::F32(values) => values.iter().map(|v| v.to_bits()).collect(),
        exr::prelude::FlatSamples::U32(values) => values.clone(),
        exr::prelude::FlatSamples::F16(_) => panic!("a half"),
    };
    list.map(|channel| (channel.name.to_string(), bits(&channel.sample_data)))
        .collect()
}

#[test]
fn arrays_have_the_bits_of_the_channels_of_exr_files() {
    let folder = Folder::new();
    let passes = "depth,N,objectId,CryptoObject,diffuse_direct,UV,variance";
    let scene = repo_str("scenes/passes/scene.toml");
    let job = [&FILES[..], &[&scene, "--aovs", passes]].concat();
    let small = [
        "--resolution",
        "48x27",
        "--samples",
        "4",
        "--crop",
        "3,2,45,27",
        "--cryptomatte-levels",
        "4",
    ];
    folder.succeed(&[&job[..], &small].concat());
    let channels = channels(&folder, "f.exr");
    let channel = |name: &str| channels[name].clone();
    let arrays = arrays(&folder.read("f.npz"));
    let matte = |first: usize| {
        ["00.R", "00.B", "01.R", "01.B"].map(|c| {
            format!("CryptoObject{}", &c[..3]) + &"RGBA"[first + "RGBA".find(&c[3..]).expect("one of them")..][..1]
        })
    };
    let (ids, coverages) = (matte(0), matte(1));
    for (name, kind, shape, channels) in [
        ("rgba", "<f4", "25, 42, 4", &["R", "G", "B", "A"][..]),
        ("depth", "<f4", "25, 42", &["depth.Z"]),
        ("N", "<f4", "25, 42, 3", &["N.X", "N.Y", "N.Z"]),
        ("objectId", "<u4", "25, 42", &["objectId.Y"]),
        (
            "diffuse_direct",
            "<f4",
            "25, 42, 3",
            &["diffuse_direct.R", "diffuse_direct.G", "diffuse_direct.B"],
        ),
        ("UV", "<f4", "25, 42, 2", &["UV.U", "UV.V"]),
        (
            "variance",
            "<f4",
            "25, 42, 3",
            &["variance.R", "variance.G", "variance.B"],
        ),
        ("CryptoObject", "<u4", "25, 42, 4", &ids.each_ref().map(String::as_str)),
        (
            "CryptoObject_coverage",
            "<f4",
            "25, 42, 4",
            &coverages.each_ref().map(String::as_str),
        ),
    ] {
        let (facts, data) = &arrays[&format!("{name}.npy")];
        let expected = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}");
        assert_eq!(*facts, expected, "{name}");
        let numbers = bits(data);
        for (i, of_exr) in channels.iter().enumerate() {
            let of_npz: Vec<u32> = numbers.iter().skip(i).step_by(channels.len()).copied().collect();
            assert!(of_npz == channel(of_exr), "{name}: {of_exr}");
        }
    }
    assert_eq!(arrays.len(), 10);
    let metadata: Value = serde_json::from_slice(&arrays["metadata.npy"].1).expect("JSON");
    assert_eq!(metadata["window"], serde_json::json!([3, 2, 45, 27]));
    assert_eq!(metadata["resolution"], serde_json::json!([48, 27]));
    assert_eq!(metadata["worldToCamera"][3][3], 1.0);
    let ids = bits(&arrays["CryptoObject.npy"].1);
    for (name, id) in metadata["mattes"]["CryptoObject"].as_object().expect("names") {
        let id = id.as_u64().and_then(|id| u32::try_from(id).ok()).expect("a number");
        assert!(ids.contains(&id), "{name}");
    }
}

#[test]
fn arrays_of_denoised_frames_have_all_passes_of_the_denoised_exr_files() {
    let folder = Folder::new();
    let scene = repo_str("scenes/passes/scene.toml");
    let job = [&FILES[..], &[&scene, "--denoise"]].concat();
    let small = [
        "--aovs",
        "depth,objectId,CryptoObject,lightgroup",
        "--resolution",
        "24x16",
        "--samples",
        "4",
    ];
    folder.succeed(&[&job[..], &small].concat());
    let (channels, arrays) = (channels(&folder, "f.exr"), arrays(&folder.read("f.npz")));
    for (array, of_exr) in [
        ("rgba", &["R", "G", "B", "A"][..]),
        ("depth", &["depth.Z"]),
        ("objectId", &["objectId.Y"]),
        (
            "lightgroup_default",
            &["lightgroup_default.R", "lightgroup_default.G", "lightgroup_default.B"],
        ),
        ("beauty_a", &["beauty_a.R", "beauty_a.G", "beauty_a.B"]),
    ] {
        let numbers = bits(&arrays[&format!("{array}.npy")].1);
        for (i, name) in of_exr.iter().enumerate() {
            let of_npz: Vec<u32> = numbers.iter().skip(i).step_by(of_exr.len()).copied().collect();
            assert!(of_npz == channels[*name], "{name}");
        }
    }
    let metadata: Value = serde_json::from_slice(&arrays["metadata.npy"].1).expect("JSON");
    let mattes = metadata["mattes"]["CryptoObject"].as_object().expect("names");
    assert!(mattes.contains_key("floor") && arrays.contains_key("CryptoObject_coverage.npy"));
}

#[test]
fn arrays_of_denoised_frames_have_the_bits_of_floats_whatever_the_type_of_exr_files() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let job = ["s.toml", "--denoise", "--resolution", "16x12", "--samples", "4"];
    folder.succeed(&[&job[..], &["-o", "a.npz"]].concat());
    folder.succeed(&[&job[..], &["-o", "b.npz", "--exr-type", "float"]].concat());
    let (a, b) = (arrays(&folder.read("a.npz")), arrays(&folder.read("b.npz")));
    assert!(a["rgba.npy"] == b["rgba.npy"] && a["depth_mean.npy"] == b["depth_mean.npy"]);
}

#[test]
fn a_comment_of_denoised_display_values_is_said_once() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let job = [
        "s.toml",
        "--view",
        "raw",
        "--resolution",
        "16x12",
        "--samples",
        "4",
        "-o",
        "f.npz",
    ];
    let comments = || {
        let metadata = arrays(&folder.read("f.npz"))["metadata.npy"].1.clone();
        serde_json::from_slice::<Value>(&metadata).expect("JSON")["comments"].clone()
    };
    folder.succeed(&job);
    let plain = comments();
    folder.succeed(&[&job[..], &["--denoise"]].concat());
    assert!(plain.is_string());
    assert_eq!(comments(), plain);
}

const JOB: [&str; 9] = [
    "s.toml",
    "--frames",
    "path.csv",
    "-o",
    "f.#.npz",
    "--resolution",
    "16x12",
    "--aovs",
    "depth",
];

#[test]
fn frames_that_are_whole_are_skipped_and_others_rendered_anew_with_the_same_bytes() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    folder.write("path.csv", SMALL_PATH);
    folder.succeed(&JOB);
    let list = |more: &[&str]| folder.succeed(&[&JOB[..], &["--list-stale"], more].concat());
    assert_eq!(list(&["--threads", "1"]), "");
    assert_eq!(list(&["--npz-compression", "deflate"]).lines().count(), 5);
    assert_eq!(list(&["--seed", "8"]).lines().count(), 5);
    let whole: Vec<Vec<u8>> = (1..=5).map(|frame| folder.read(&format!("f.{frame}.npz"))).collect();
    let put = |frame: usize, bytes: &[u8]| fs::write(folder.path(&format!("f.{frame}.npz")), bytes).expect("written");
    put(1, &whole[0][..whole[0].len() - 1]);
    let mut flipped = whole[1].clone();
    flipped[2000] ^= 1;
    put(2, &flipped);
    put(3, b"");
    // An archive of another program.
    put(4, &[&b"PK\x05\x06"[..], &[0; 18]].concat());
    fs::remove_file(folder.path("f.5.npz")).expect("removed");
    let reasons = list(&[]);
    assert_eq!(reasons.matches("is incomplete or altered").count(), 4, "{reasons}");
    assert_eq!(reasons.matches("is missing").count(), 1, "{reasons}");
    folder.succeed(&[&JOB[..], &["--skip-existing"]].concat());
    for (frame, bytes) in (1..=5).zip(&whole) {
        assert!(folder.read(&format!("f.{frame}.npz")) == *bytes, "{frame}");
    }
}

#[test]
fn the_lossy_compression_of_exr_files_does_not_concern_arrays() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let job = [
        "s.toml",
        "--resolution",
        "16x12",
        "--aovs",
        "depth",
        "--compression",
        "dwaa",
    ];
    folder.succeed(&[&job[..], &["-o", "f.npz"]].concat());
    let said = folder.fail(2, &[&job[..], &["-o", "f.npz", "-o", "f.exr"]].concat());
    assert!(
        said.contains("the compression `dwaa` would ruin the data of the pass `depth`"),
        "{said}"
    );
}

#[test]
fn deflated_files_are_smaller() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let job = ["s.toml", "--resolution", "64x48", "--aovs", "objectId"];
    folder.succeed(&[&job[..], &["-o", "a.npz"]].concat());
    folder.succeed(&[&job[..], &["-o", "b.npz", "--npz-compression", "deflate"]].concat());
    assert!(folder.read("b.npz").len() < folder.read("a.npz").len() * 3 / 4);
    let said = folder.fail(2, &[&job[..], &["-o", "c.npz", "--npz-compression", "zip"]].concat());
    assert!(said.contains("--npz-compression: unknown compression `zip`"), "{said}");
}
