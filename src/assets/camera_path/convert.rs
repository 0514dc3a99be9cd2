//! Camera paths of one format as files of another.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use super::{
    CameraPathError, CameraPathFormat, CameraPathOptions,
    held::{self, Target},
    load,
    still::{Still, stills},
};
use crate::{
    assets::Files,
    camera::{FilmSize, Pose, path::CameraPath},
    math::{DVec3, sorting},
};

/// The most frames that are written.
const MOST_FRAMES: i64 = 1_000_000;

/// The options of a conversion.
#[derive(Clone, Debug, Default)]
pub struct Conversion {
    pub options: CameraPathOptions,
    /// The size of the pictures, for lenses that are given by their angles.
    pub resolution: Option<FilmSize>,
    /// A file whose first lens is that of all cameras.
    pub lens: Option<PathBuf>,
}

/// The result of a conversion.
#[derive(Debug)]
pub struct Converted {
    /// The files with their contents.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    pub frames: usize,
    /// The properties of the cameras that the format cannot store, in words.
    pub lost: Option<String>,
}

/// Converts the cameras of the file `from` to the format of the file `to`, and writes nothing.
///
/// # Errors
/// The file cannot be read, or the other format cannot hold its cameras.
pub fn convert(from: &Path, to: &Path, settings: &Conversion, files: &Files) -> Result<Converted, CameraPathError> {
    let format = CameraPathFormat::of_path(to).or_else(|| match to.extension() {
        // A folder that is not there yet.
        None => CameraPathFormat::by_name("colmap"),
        Some(_) => None,
    });
    let format = format.ok_or_else(|| CameraPathError::UnknownFormat { path: to.to_owned() })?;
    let unfit = |path: &Path| {
        let path = path.to_owned();
        move |cause| CameraPathError::Unfit { cause, path }
    };
    let path = load(from, None, &settings.options, files)?;
    let frames = frames(&path).map_err(unfit(from))?;
    let mut cameras = stills(&path, frames, settings.resolution).map_err(unfit(from))?;
    if let Some(file) = &settings.lens {
        let lens = lens(
            &load(
                file,
                None,
                &CameraPathOptions {
                    pose: Some(Pose::at(DVec3::ZERO)),
                    ..settings.options
                },
                files,
            )?,
            settings.resolution,
        );
        let lens = lens.ok_or_else(|| unfit(file)("the file has no lens".to_owned()))?;
        for camera in &mut cameras {
            (camera.fov, camera.pixels) = (lens.fov, lens.pixels);
        }
    }
    if cameras.is_empty() {
        return Err(unfit(from)("the file has no camera at a whole frame".to_owned()));
    }
    name_all_or_none(&mut cameras);
    let target = Target {
        path: to,
        fps: settings.options.fps,
        rotation_order: settings.options.rotation_order,
    };
    let mut lost = held::lost(&cameras, format.holds);
    // A size that was said is known.
    lost.retain(|part| settings.resolution.is_none() || *part != held::SIZE);
    Ok(Converted {
        files: (format.write)(&target, &cameras).map_err(unfit(to))?,
        frames: cameras.len(),
        lost: (!lost.is_empty()).then(|| format!("{} files do not hold {}: left out", format.name, lost.join(", "))),
    })
}

/// The frames that are written: the pictures of the file, or all frames of a motion, as they are rendered. Programs that read the
/// other format have curves of their own between the frames that a file leaves out.
fn frames(path: &CameraPath) -> Result<Vec<i64>, String> {
    if let Some(pictures) = path.pictures() {
        return Ok(pictures.to_vec());
    }
    let all = path.frames();
    match all.end() - all.start() < MOST_FRAMES {
        true => Ok(all.collect()),
        false => Err(format!("there are more than {MOST_FRAMES} frames")),
    }
}

/// Takes the names away unless each picture has one of its own: those of shots are no names of pictures.
fn name_all_or_none(cameras: &mut [Still]) {
    let names: BTreeSet<&str> = sorting::ordered(cameras.iter().filter_map(|camera| camera.name.as_deref()));
    if names.len() < cameras.len() {
        cameras.iter_mut().for_each(|camera| camera.name = None);
    }
}

/// The first camera of a path, if it has a lens.
fn lens(path: &CameraPath, resolution: Option<FilmSize>) -> Option<Still> {
    let frames = path.keys().next().map(|first| first.ceil() as i64);
    let first = stills(path, frames, resolution).ok()?.into_iter().next()?;
    (first.fov.is_some() || first.pixels.is_some()).then_some(first)
}
