//! Reconstructions of COLMAP: `cameras` and `images`, as texts (`.txt`) or binary (`.bin`), in one folder.
//!
//! Poses map the world to a camera that looks along its +z with +y down, as a quaternion w, x, y, z and a translation. Intrinsics
//! are in pixels with pixel centres at .5. Points are not read. A picture is a frame: the last number of its name, if every picture
//! has one of its own, else its place in the order of names, from 1.
//!
//! | model | read as |
//! |---|---|
//! | `SIMPLE_PINHOLE`, `PINHOLE` | no distortion |
//! | `SIMPLE_RADIAL`, `RADIAL`, `OPENCV`, `FULL_OPENCV` | `opencv` |
//! | `SIMPLE_FISHEYE`, `FISHEYE`, `SIMPLE_RADIAL_FISHEYE`, `RADIAL_FISHEYE`, `OPENCV_FISHEYE` | `kannala_brandt` |
//! | others | an error |
//!
//! Source: Schönberger and Frahm, "Structure-from-Motion Revisited", CVPR 2016; colmap.github.io,
//! "Output Format" and "Camera Models".

use std::collections::HashMap;

use glam::DVec3;

use super::{
    CameraPathFormat, PathProblem, PathProblems,
    held::{Holds, Numbers, Target, Written},
    keys::{self, Frames, Posed},
    source::Source,
    still::Still,
};
use crate::{
    camera::{ViewDistortion, path::CameraPath, pinhole::PinholeLens},
    math::sorting,
    value::one_line,
};

mod binary;
mod model;
mod record;
mod text;
mod written;

use model::FileCamera;
use record::Picture;
use written::Reconstruction;

/// The most characters of a name that a message shows.
const MOST_SHOWN: usize = 80;

/// The files that a reconstruction with this file consists of: images and cameras.
pub(super) fn file_names(is_binary: bool) -> [&'static str; 2] {
    match is_binary {
        true => ["images.bin", "cameras.bin"],
        false => ["images.txt", "cameras.txt"],
    }
}

pub(super) const FORMAT: CameraPathFormat = CameraPathFormat {
    name: "colmap",
    extensions: &["bin", "txt"],
    names: &[
        "images.bin",
        "images.txt",
        "cameras.bin",
        "cameras.txt",
        "points3D.bin",
        "points3D.txt",
    ],
    read,
    holds: Holds {
        numbers: Numbers::InNames,
        names: true,
        view: true,
        center: true,
        pixels: true,
        skew: false,
        distortion: |distortion| !matches!(distortion, ViewDistortion::OpenCv([.., s1, s2, s3, s4]) if [*s1, *s2, *s3, *s4] != [0.0; 4]),
    },
    write,
};

fn read(source: &Source<'_>) -> Result<CameraPath, PathProblems> {
    let is_binary = source.path.extension().is_some_and(|ending| ending == "bin");
    let [images, cameras] = file_names(is_binary);
    let (images_path, cameras_path) = (source.path.with_file_name(images), source.path.with_file_name(cameras));
    let (images, cameras) = (source.beside(images)?, source.beside(cameras)?);
    let read_cameras = if is_binary { binary::cameras } else { text::cameras };
    let cameras = read_cameras(&cameras).map_err(|problems| problems.in_file(&cameras_path))?;
    let read_images = if is_binary { binary::images } else { text::images };
    let found = read_images(&images).and_then(|mut pictures| {
        sorting::sort_by(&mut pictures, |a, b| a.name.cmp(&b.name));
        posed(pictures, &cameras)
    });
    let (posed, wrong_camera) = found.map_err(|problems| problems.in_file(&images_path))?;
    if let Some(problem) = wrong_camera {
        return Err(PathProblems::from(problem).in_file(&cameras_path));
    }
    let names = posed.iter().map(|posed| posed.name.as_deref());
    let frames = keys::picture_frames(names);
    keys::path(
        frames.into_iter().map(|frame| frame as f64).zip(posed),
        Frames::Pictures,
    )
    .map_err(|problems| problems.in_file(&images_path))
}

/// The cameras of the pictures, and what is wrong with one that a picture has.
fn posed(
    pictures: Vec<Picture>,
    cameras: &HashMap<u32, FileCamera>,
) -> Result<(Vec<Posed>, Option<PathProblem>), PathProblems> {
    let (mut problems, mut wrong_camera) = (PathProblems::default(), None);
    let mut lenses: HashMap<u32, Option<PinholeLens>> = HashMap::new();
    let mut all = Vec::with_capacity(pictures.len());
    for picture in pictures {
        let name = || one_line(&picture.name, MOST_SHOWN);
        let Some(camera) = cameras.get(&picture.camera) else {
            let message = format!("`{}`: there is no camera {}", name(), picture.camera);
            problems.push(picture.place.problem(message));
            continue;
        };
        let lens = *lenses.entry(picture.camera).or_insert_with(|| match camera.lens() {
            Ok(lens) => Some(lens),
            Err(message) => {
                wrong_camera.get_or_insert(camera.place.problem(message));
                None
            }
        });
        let [w, x, y, z] = picture.rotation;
        let numbers = picture.rotation.iter().chain(&picture.translation);
        let rotation = match numbers.into_iter().all(|v| v.abs() <= f64::from(f32::MAX)) {
            true => keys::unit_quaternion([x, y, z, w]),
            false => Err("a number is not finite or too large".to_owned()),
        };
        match rotation {
            Ok(rotation) => all.push(Posed {
                pinhole: lens,
                name: Some(picture.name),
                ..Posed::of_extrinsics(rotation, DVec3::from_array(picture.translation))
            }),
            Err(message) => problems.push(picture.place.problem(format!("`{}`: {message}", name()))),
        }
    }
    if all.is_empty() && problems.is_empty() {
        problems.push(PathProblem::of_file("there are no images"));
    }
    if problems.is_empty() {
        Ok((all, wrong_camera))
    } else {
        Err(problems)
    }
}

fn write(target: &Target<'_>, cameras: &[Still]) -> Written {
    let is_binary = target.path.extension().is_some_and(|ending| ending == "bin");
    let files = Reconstruction::new(cameras)?;
    let files = if is_binary {
        binary::files(&files)
    } else {
        text::files(&files).map(|(name, text)| (name, text.into_bytes()))
    };
    // A path without an ending is a folder.
    let path = |name: &str| match target.path.extension() {
        Some(_) if !target.path.is_dir() => target.path.with_file_name(name),
        _ => target.path.join(name),
    };
    Ok(files.map(|(name, bytes)| (path(name), bytes)).into())
}

/// The names and the texts of the files of cameras, which have lenses in pixels.
///
/// # Errors
/// A camera has no lens in pixels.
pub fn texts(cameras: &[Still]) -> Result<[(&'static str, String); 3], String> {
    Reconstruction::new(cameras).map(|all| text::files(&all))
}
