//! The cameras of a sequence as a reconstruction of COLMAP, in its form of texts: `cameras.txt`, `images.txt` and
//! a `points3D.txt` without points.

use crate::assets::camera_path::{colmap, transforms::Transforms};

/// The names and the texts of the files.
pub(super) fn files(transforms: &Transforms) -> [(&'static str, String); 3] {
    let stills: Vec<_> = transforms.frames.iter().map(|frame| transforms.still(frame)).collect();
    colmap::texts(&stills).expect("frames of the file have lenses in pixels and a size")
}
