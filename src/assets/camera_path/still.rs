//! The cameras of single frames, as files of other programs hold them.

use glam::{DMat3, DQuat, DVec3};

use super::keys::Intrinsics;
use crate::camera::{
    FilmSize, Lens, ViewDistortion,
    path::{CameraPath, CameraState},
};

/// The camera of one frame.
#[derive(Clone, Debug)]
pub struct Still {
    pub frame: i64,
    /// The name of the picture.
    pub name: Option<String>,
    /// In m.
    pub eye: DVec3,
    /// Unit vectors to the right, up and backwards: from camera to world.
    pub axes: DMat3,
    /// The angle over the picture's height in degrees, if it is known.
    pub fov: Option<f64>,
    /// The lens in pixels, if it is known; it has a centre.
    pub pixels: Option<Intrinsics>,
    /// Whether the lens was given in pixels.
    pub is_calibrated: bool,
    /// Whether the camera has depth of field, or a shutter that is open for a time.
    pub has_blur: bool,
}

impl Still {
    /// The map from the world to a camera that looks along its +z with +y down.
    pub fn extrinsics(&self) -> (DQuat, DVec3) {
        let to_camera = self.vision_axes().transpose();
        (upper(DQuat::from_mat3(&to_camera)), -(to_camera * self.eye))
    }

    /// The rotation of such a camera to the world.
    pub fn vision_rotation(&self) -> DQuat {
        upper(DQuat::from_mat3(&self.vision_axes()))
    }

    fn vision_axes(&self) -> DMat3 {
        let DMat3 { x_axis, y_axis, z_axis } = self.axes;
        DMat3::from_cols(x_axis, -y_axis, -z_axis)
    }

    /// The lens in pixels.
    ///
    /// # Errors
    /// It is not known; `format` needs it.
    pub fn lens(&self, format: &str) -> Result<&Intrinsics, String> {
        self.pixels.as_ref().ok_or_else(|| match self.fov {
            Some(_) => format!("{format} files have lenses in pixels: say the size of the pictures (--resolution)"),
            None => format!(
                "{format} files have lenses in pixels, and frame {} has no lens: name a file with one (--lens)",
                self.frame
            ),
        })
    }

    /// The angle over the height, in degrees.
    ///
    /// # Errors
    /// It is not known; `format` needs it.
    pub fn view(&self, format: &str) -> Result<f64, String> {
        self.fov.ok_or_else(|| {
            let frame = self.frame;
            match &self.pixels {
                Some(lens) if is_fisheye(lens) => format!("{format} files hold no fisheye, as frame {frame} has one"),
                Some(_) => format!("{format} files have angles of view: say the size of the pictures (--resolution)"),
                None => format!(
                    "{format} files have angles of view, and frame {frame} has none: name a file with a lens (--lens)"
                ),
            }
        })
    }
}

/// Returns the quaternion of the same rotation with `w` of at least 0.
fn upper(rotation: DQuat) -> DQuat {
    if rotation.w < 0.0 { -rotation } else { rotation }
}

fn is_fisheye(lens: &Intrinsics) -> bool {
    matches!(lens.distortion, ViewDistortion::OpenCvFisheye(_))
}

/// The cameras of these frames of a path, at pictures of this size.
///
/// # Errors
/// A frame has no camera.
pub fn stills(
    path: &CameraPath,
    frames: impl IntoIterator<Item = i64>,
    resolution: Option<FilmSize>,
) -> Result<Vec<Still>, String> {
    let still = |frame: i64| {
        let state = path.at(frame as f64).map_err(|error| error.to_string())?;
        let place = state.pose.world_from_camera();
        let pixels = pixels(&state, resolution);
        let is_open = state.shutter.is_some_and(|shutter| shutter.open != shutter.close);
        let rolls = state.readout.is_some_and(|time| time > 0.0);
        Ok(Still {
            frame,
            eye: place.translation,
            axes: place.matrix3,
            fov: fov(&state, pixels.as_ref(), resolution),
            pixels,
            is_calibrated: state.calibrated().is_some(),
            has_blur: state.lens.aperture.is_some() || state.lens.focus_distance.is_some() || is_open || rolls,
            name: state.name,
        })
    };
    frames.into_iter().map(still).collect()
}

fn fov(state: &CameraState, pixels: Option<&Intrinsics>, resolution: Option<FilmSize>) -> Option<f64> {
    use crate::camera::lens::FieldOfView::Vertical;
    if let (None, Some(Vertical(degrees))) = (state.calibrated(), state.lens.view) {
        return Some(degrees);
    }
    let lens = pixels.filter(|lens| !is_fisheye(lens))?;
    let height = lens
        .size
        .map(|size| size[1])
        .or(resolution.map(|size| f64::from(size[1])))?;
    Some(2.0 * libm::atan(0.5 * height / lens.focal[1]).to_degrees())
}

/// The lens in pixels, if it is known.
fn pixels(state: &CameraState, resolution: Option<FilmSize>) -> Option<Intrinsics> {
    let film = resolution.map(|size| size.map(f64::from));
    let Some(lens) = state.calibrated() else {
        state.lens.view?;
        let view = state.camera(&Lens::default(), resolution?).pinhole()?;
        return Some(Intrinsics {
            focal: view.focal,
            center: view.center.map(Some),
            skew: 0.0,
            size: film,
            distortion: ViewDistortion::None,
        });
    };
    let size = film.or(lens.size);
    let scale = |axis: usize| match (film, lens.size) {
        (Some(film), Some(size)) => film[axis] / size[axis],
        _ => 1.0,
    };
    let center = |axis: usize| match lens.center[axis] {
        Some(center) => Some(center * scale(axis)),
        None => size.map(|size| 0.5 * size[axis]),
    };
    Some(Intrinsics {
        focal: [0, 1].map(|axis| lens.focal[axis] * scale(axis)),
        center: [Some(center(0)?), Some(center(1)?)],
        skew: lens.skew * scale(0),
        size,
        distortion: lens.distortion.of_data_sets()?,
    })
}
