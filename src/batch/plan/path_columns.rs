//! The columns of a camera path against the camera of the scene.

use std::path::Path;

use crate::{
    batch::Request,
    camera::{Lens, lens::Aperture, path::CameraPath},
    error::Error,
    warnings::WarningKind,
};

/// Refuses a path with lens columns that the scene's camera does not have.
pub(super) fn check_columns(file: &Path, path: &CameraPath, lens: &Lens) -> Result<(), Error> {
    let given = path.lens_at(path.first());
    let lens = given.intrinsics.base(lens);
    let columns = lens.unsupported_columns(&given);
    if columns.is_empty() {
        return Ok(());
    }
    Err(Error::Columns {
        path: file.to_owned(),
        camera: lens.name(),
        columns,
    })
}

/// Keys of a camera in scene files, and the columns of a camera path that replace them. A pose replaces its keys always.
const REPLACED: [(&[&str], &[&str]); 11] = [
    (&["eye", "target", "up"], &[]),
    (&["fov", "fov_x", "focal_length"], &["fov", "fov_x", "focal_length"]),
    (&["sensor_width", "sensor_height"], &["sensor_width", "sensor_height"]),
    (&["aperture_radius", "fstop"], &["aperture_radius", "fstop"]),
    (&["focus_distance"], &["focus_distance"]),
    (&["shift"], &["shift_x", "shift_y"]),
    (&["fx", "fy"], &["fx", "fy"]),
    (&["cx"], &["cx"]),
    (&["cy"], &["cy"]),
    (&["skew"], &["skew"]),
    (&["size"], &["width", "height"]),
];

/// Whether a value of this name is a part of the pose of the scene's camera.
pub(super) fn is_of_pose(name: &str) -> bool {
    let key = name.split('.').nth(2);
    REPLACED
        .iter()
        .any(|(keys, columns)| columns.is_empty() && key.is_some_and(|key| keys.contains(&key)))
}

/// The column of a camera path that replaces the value at the path `keys` of a scene file, or the
/// path itself; `None` if neither does.
pub(super) fn replacing(keys: &[impl AsRef<str>], path: &CameraPath) -> Option<String> {
    let [camera, _, key, ..] = keys else { return None };
    let row = REPLACED.iter().find(|(keys, _)| keys.contains(&key.as_ref()));
    let (_, columns) = row.filter(|_| camera.as_ref() == "camera")?;
    let given: Vec<_> = path.lens_at(path.first()).columns().collect();
    match columns.iter().find(|column| given.contains(column)) {
        Some(column) => Some(format!("the column `{column}` of the camera path")),
        None => columns.is_empty().then(|| "the camera path".to_owned()),
    }
}

/// Warns of overrides of the scene's camera that the path replaces again.
pub(super) fn warn_of_columns(file: &Path, path: &CameraPath, request: &Request) {
    for (origin, keys) in request.overrides.paths() {
        let Some(by) = replacing(keys, path) else { continue };
        let text = format!("{origin} has no effect, {by} replaces it: {}", file.display());
        let warnings = &request.warnings;
        warnings.add_topic(WarningKind::UNUSED_SETTING, "columns", origin, text);
    }
}

/// Warns if the calibrated cameras of a path replace a lens with depth of field.
pub(super) fn warn_of_lens(file: &Path, path: &CameraPath, lens: &Lens, request: &Request) {
    let is_open = match lens.parameters().aperture {
        Some(Aperture::Radius(radius)) => radius > 0.0,
        Some(Aperture::FStop(_)) => true,
        None => false,
    };
    if is_open && path.is_calibrated() {
        let text = format!(
            "the scene's camera has depth of field, the calibrated cameras that replace it have none: {}",
            file.display()
        );
        let warnings = &request.warnings;
        warnings.add_topic(WarningKind::UNUSED_SETTING, "aperture", file.display(), text);
    }
}
