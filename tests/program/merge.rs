//! Merging: crops of a frame become the file of the whole frame, byte for byte, or are refused by name.

use std::fs;

use crate::common::{Folder, SMALL_SCENE};

/// Three crops of a picture of 70 x 50 pixels.
const CROPS: [&str; 3] = ["0,0,33,50", "33,0,70,17", "33,17,70,50"];

/// Renders one frame whole to `whole.exr`, `whole.png` and `whole.npz`, and its crops to `crop0.exr` and so on.
fn rendered(more: &[&str]) -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SMALL_SCENE);
    let render = |name: &str, own: &[&str]| {
        let [exr, png, npz] = ["exr", "png", "npz"].map(|format| format!("{name}.{format}"));
        let job = ["s.toml", "-o", &exr, "-o", &png, "-o", &npz, "--samples", "2"];
        folder.succeed(&[&job[..], own, more].concat());
    };
    render("whole", &[]);
    for (i, crop) in CROPS.iter().enumerate() {
        render(&format!("crop{i}"), &["--crop", crop]);
    }
    folder
}

#[test]
fn crops_become_the_file_of_the_whole_frame_byte_for_byte() {
    let passes = "depth,N,CryptoObject,CryptoMaterial,diffuse_direct,objectId,sampleCount";
    for more in [
        &["--aovs", passes][..],
        &[
            "--aovs",
            passes,
            "--multipart",
            "--compression",
            "zip",
            "--exr-type",
            "float",
        ],
        &[
            "--compression",
            "piz",
            "--png-bits",
            "16",
            "--npz-compression",
            "deflate",
        ],
        &["--compression", "rle", "--png-bits", "8-dithered"],
        &["--compression", "none", "--show", "depth"],
    ] {
        let folder = rendered(more);
        for format in ["exr", "png", "npz"] {
            let crops = [2, 0, 1].map(|i| format!("crop{i}.{format}"));
            let out = format!("merged.{format}");
            let said = folder.succeed(&["merge", &out, &crops[0], &crops[1], &crops[2]]);
            assert_eq!(said, format!("{out}: merged from 3 crops\n"));
            let whole = folder.read(&format!("whole.{format}"));
            assert!(folder.read(&out) == whole, "{more:?}: {format}");
        }
    }
}

#[test]
fn a_whole_frame_may_be_merged_from_itself_and_skipped_afterwards() {
    let folder = rendered(&[]);
    folder.succeed(&["merge", "f.0001.exr", "whole.exr"]);
    assert!(folder.read("f.0001.exr") == folder.read("whole.exr"));
    let job = ["s.toml", "-o", "f.####.exr", "--samples", "2", "--list-stale"];
    assert_eq!(folder.succeed(&job), "");
}

#[test]
fn depth_pictures_are_merged_and_not_mixed_with_others() {
    let folder = rendered(&["--png-depth"]);
    let depth = |crop: &str, name: &str| {
        let job = ["s.toml", "-o", "x.exr", "--samples", "2", "--crop", crop];
        folder.succeed(&[&job[..], &[&format!("--png-depth={name}")]].concat());
    };
    depth("0,0,70,50", "depth.png");
    for (i, crop) in CROPS.iter().enumerate() {
        depth(crop, &format!("depth{i}.png"));
    }
    folder.succeed(&["merge", "merged.png", "depth0.png", "depth1.png", "depth2.png"]);
    assert!(folder.read("merged.png") == folder.read("depth.png"));
    let message = folder.fail(65, &["merge", "m.png", "crop0.png", "depth1.png", "crop2.png"]);
    assert!(
        message.contains("the files hold other layers or numbers than each other: crop0.png and depth1.png"),
        "{message}"
    );
}

#[test]
fn crops_that_do_not_make_the_frame_are_refused_by_name() {
    let folder = rendered(&[]);
    let job = [
        "s.toml",
        "-o",
        "seed.exr",
        "--samples",
        "2",
        "--seed",
        "8",
        "--crop",
        CROPS[2],
    ];
    folder.succeed(&job);
    fs::write(folder.path("cut.exr"), &folder.read("crop2.exr")[1..]).expect("written");
    image::RgbImage::new(37, 33)
        .save(folder.path("other.png"))
        .expect("written");
    folder.succeed(&["s.toml", "-o", "dwaa.exr", "--samples", "2", "--compression", "dwaa"]);
    for (code, args, expected) in [
        (
            65,
            &["m.exr", "crop0.exr", "crop1.exr"][..],
            "no file holds the crop 33,17,70,50 of the 70x50 picture",
        ),
        (
            65,
            &["m.exr", "crop0.exr", "crop1.exr", "crop2.exr", "crop1.exr"],
            "two files hold the crop 33,0,70,17: crop1.exr and crop1.exr",
        ),
        (
            65,
            &["m.exr", "crop0.exr", "crop1.exr", "seed.exr"],
            "the files are of different pictures, by their frames, inputs or settings: crop0.exr and seed.exr",
        ),
        (
            65,
            &["m.exr", "crop0.exr", "crop1.exr", "cut.exr"],
            "the file is incomplete or altered: cut.exr",
        ),
        (
            65,
            &["m.png", "crop0.png", "crop1.png", "other.png"],
            "the file was not written by this version of batch-render: other.png",
        ),
        (
            65,
            &["m.exr", "crop0.exr", "crop1.png"],
            "the file is png, and the merged one exr: merge files of one format: crop1.png",
        ),
        (
            65,
            &["m.exr", "dwaa.exr"],
            "its compression is lossy: its pixels, packed again, are not those of the whole picture: dwaa.exr",
        ),
        (
            66,
            &["m.exr", "crop0.exr", "none.exr"],
            "there is no such file: none.exr",
        ),
        (
            2,
            &["m.tif", "crop0.exr"],
            "the name of the merged file ends in .exr, .npz or .png: m.tif",
        ),
        (
            2,
            &["crop0.exr", "crop0.exr", "crop1.exr", "crop2.exr"],
            "the output crop0.exr is a file that the job reads: crop0.exr",
        ),
    ] {
        let message = folder.fail(code, &[&["merge"], args].concat());
        assert!(message.contains(expected), "{args:?}: {message}");
    }
    assert!(!folder.path("m.exr").exists() && !folder.path("m.png").exists());
}
