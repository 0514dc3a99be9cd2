//! The kinds of files beside the pictures of a job.
//!
//! | name | file | content |
//! |---|---|---|
//! | `transforms` | `transforms.json` | the camera of each frame, as NeRF programs read it |
//! | `colmap` | `sparse/0/cameras.txt`, `images.txt` and `points3D.txt`, and `transforms.json` | the same cameras, as COLMAP reads them |
//! | `coco` | `coco.json` | boxes and masks of the objects in each picture, as COCO has them |
//! | `ids` | `ids.json` | the names of objects and materials by the numbers of `objectId` and `materialId` |
//!
//! They are written to the folder of the pictures. With stereo their names have the eye, `transforms.left.json` and `sparse/left`,
//! unless the folder of the pictures has it: the files of the other eye stay. Source of the first: Mildenhall et al., "NeRF", ECCV
//! 2020, doi:10.1007/978-3-030-58452-8_24, with the keys of instant-ngp and Nerfstudio.

use std::path::{Path, PathBuf};

use crate::{
    assets::camera_path::transforms::model_name,
    camera::{CalibratedView, FrameCamera, ViewDistortion},
    error::Error,
    kind::named,
};

named! {
    /// A file beside the pictures.
    pub enum Sidecar: "metadata" {
        Transforms = "transforms",
        Colmap = "colmap",
        Coco = "coco",
        Ids = "ids",
    }
}

impl Sidecar {
    /// The path of the file, or of the main one, beside a picture. With an eye it is that of its pictures alone.
    pub fn path(self, picture: &Path, eye: Option<&str>) -> PathBuf {
        let ending = eye.map_or_else(String::new, |eye| format!(".{eye}"));
        picture.with_file_name(match self {
            Self::Colmap => format!("sparse/{}/images.txt", eye.unwrap_or("0")),
            Self::Transforms | Self::Coco | Self::Ids => {
                format!("{}{ending}.json", self.name())
            }
        })
    }

    /// These with those that they are made from.
    pub(in crate::batch) fn with_sources(list: &[Self]) -> Vec<Self> {
        let mut all = list.to_vec();
        if all.contains(&Self::Colmap) && !all.contains(&Self::Transforms) {
            all.push(Self::Transforms);
        }
        all
    }
}

/// Checks whether the files can be made for these cameras.
pub(in crate::batch) fn check<'a>(
    sidecars: &[Sidecar],
    cameras: impl Iterator<Item = &'a FrameCamera>,
) -> Result<(), Error> {
    match sidecars.contains(&Sidecar::Transforms) {
        true => camera_model(cameras).map(drop),
        false => Ok(()),
    }
}

/// The `camera_model` of a file with these cameras.
///
/// # Errors
/// A camera has no model, or they have no common one.
pub(super) fn camera_model<'a>(cameras: impl Iterator<Item = &'a FrameCamera>) -> Result<&'static str, Error> {
    let mut common = None;
    for camera in cameras {
        let model = model_name(&calibrated(camera)?.distortion);
        let joined = common.map_or(Some(model), |common| common_model(common, model));
        common = Some(joined.ok_or_else(|| {
            let message = "--metadata transforms: readers take one camera model for all frames, and some of these are fisheyes: \
                           render those by themselves, into a folder of their own";
            Error::Usage(message.to_owned())
        })?);
    }
    Ok(common.unwrap_or(model_name(&ViewDistortion::None)))
}

/// The camera model of a file with frames of both: OPENCV has PINHOLE as a special case. `None` if readers of either would take some
/// frames wrong.
pub(super) fn common_model<'a>(a: &'a str, b: &'a str) -> Option<&'a str> {
    match (a, b) {
        _ if a == b => Some(a),
        ("PINHOLE", "OPENCV") | ("OPENCV", "PINHOLE") => Some("OPENCV"),
        _ => None,
    }
}

/// The view of a camera when its shutter opens.
pub(in crate::batch) fn calibrated(camera: &FrameCamera) -> Result<CalibratedView, Error> {
    let message = "--metadata transforms: only perspective cameras have focal lengths, and pinholes without skew, with \
                   `kannala_brandt` or up to five numbers of `opencv`: leave out `transforms`, and `colmap`, which is made from it; \
                   convert-camera writes other lenses of a camera path as COLMAP";
    // Readers of `transforms.json` take a fourth coefficient of the radius for another model.
    let is_known = |view: &CalibratedView| match view.distortion {
        ViewDistortion::OpenCv([_, _, _, _, _, others @ ..]) => others == [0.0; 7],
        ViewDistortion::None | ViewDistortion::OpenCvFisheye(_) => true,
    };
    let view = camera.camera(0.0).calibrated().filter(is_known);
    view.ok_or_else(|| Error::Usage(message.to_owned()))
}
