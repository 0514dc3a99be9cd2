//! The camera of the view, in messages and camera paths.

use serde::{Deserialize, Serialize};

use crate::{
    camera::{
        FilmSize, FrameCamera, Lens, LensOverrides, LookAt, Pose, Timing,
        lens::{Aperture, FieldOfView, Sensor},
        path::{CameraPath, CameraState, Interp, Orientation, PathError, PathKey},
    },
    math::DVec3,
};

/// A still camera: a key of a camera path without its frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewCamera {
    /// In m, in the world.
    pub eye: [f64; 3],
    /// In m, in the world.
    pub target: [f64; 3],
    pub up: [f64; 3],
    /// In degrees.
    #[serde(default)]
    pub roll: f64,
    /// The parameters that differ from the lens of the scene.
    #[serde(default)]
    pub lens: LensNumbers,
}

/// Parameters of a lens under the names of the columns of camera paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LensNumbers {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fov: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fov_x: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focal_length: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor_width: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor_height: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aperture_radius: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fstop: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focus_distance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shift_x: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shift_y: Option<f64>,
}

impl LensNumbers {
    /// The parameters; of alternatives the first.
    pub fn overrides(&self) -> LensOverrides {
        let angle = self.fov.map(FieldOfView::Vertical);
        let angle = angle.or(self.fov_x.map(FieldOfView::Horizontal));
        LensOverrides {
            view: angle.or(self.focal_length.map(FieldOfView::FocalLength)),
            sensor: self
                .sensor_width
                .map(Sensor::Width)
                .or(self.sensor_height.map(Sensor::Height)),
            aperture: self
                .fstop
                .map(Aperture::FStop)
                .or(self.aperture_radius.map(Aperture::Radius)),
            focus_distance: self.focus_distance,
            shift_x: self.shift_x,
            shift_y: self.shift_y,
            ..LensOverrides::default()
        }
    }
}

impl From<LensOverrides> for LensNumbers {
    fn from(lens: LensOverrides) -> Self {
        let mut numbers = Self {
            focus_distance: lens.focus_distance,
            shift_x: lens.shift_x,
            shift_y: lens.shift_y,
            ..Self::default()
        };
        match lens.view {
            Some(FieldOfView::Vertical(v)) => numbers.fov = Some(v),
            Some(FieldOfView::Horizontal(v)) => numbers.fov_x = Some(v),
            Some(FieldOfView::FocalLength(v)) => numbers.focal_length = Some(v),
            None => {}
        }
        match lens.sensor {
            Some(Sensor::Width(v) | Sensor::LongSide(v)) => numbers.sensor_width = Some(v),
            Some(Sensor::Height(v)) => numbers.sensor_height = Some(v),
            None => {}
        }
        match lens.aperture {
            Some(Aperture::Radius(v)) => numbers.aperture_radius = Some(v),
            Some(Aperture::FStop(v)) => numbers.fstop = Some(v),
            None => {}
        }
        numbers
    }
}

impl ViewCamera {
    /// The camera at `eye` that looks at a target.
    pub fn new(eye: DVec3, at: &LookAt) -> Self {
        Self {
            eye: eye.to_array(),
            target: at.target.to_array(),
            up: at.up.to_array(),
            roll: at.roll,
            lens: LensNumbers::default(),
        }
    }

    /// The camera of a path at a time. It looks at a target at the path's distance, or at `distance`, with the roll relative to
    /// `up`.
    pub fn of_state(state: &CameraState, up: DVec3, distance: f64) -> Self {
        let distance = state.target_distance.or(state.lens.focus_distance).unwrap_or(distance);
        Self::of_pose(&state.pose, state.lens, up, distance)
    }

    /// The camera at a pose that looks at a target at this distance, with the roll relative to `up`.
    pub fn of_pose(pose: &Pose, lens: LensOverrides, up: DVec3, distance: f64) -> Self {
        let at = LookAt {
            target: pose.eye() + pose.forward() * distance,
            up,
            roll: 0.0,
        };
        let roll = Pose::look_at(pose.eye(), &at).map_or(0.0, |level| {
            let up = pose.up();
            libm::atan2(-up.dot(level.right()), up.dot(level.up())).to_degrees()
        });
        // Removes rounding errors.
        let rounded = |v: f64| (v * 1e9).round() / 1e9;
        let at = LookAt {
            target: at.target.to_array().map(rounded).into(),
            roll: rounded(roll),
            ..at
        };
        Self {
            lens: lens.into(),
            ..Self::new(pose.eye(), &at)
        }
    }

    /// Whether its numbers are within the bounds of camera path files.
    pub fn is_bounded(&self) -> bool {
        let lens = &self.lens;
        let lens = [
            lens.focus_distance,
            lens.focal_length,
            lens.aperture_radius,
            lens.fstop,
            lens.shift_x,
            lens.shift_y,
        ];
        let vectors = [self.eye, self.target, self.up];
        let mut numbers = vectors
            .into_iter()
            .flatten()
            .chain([self.roll])
            .chain(lens.into_iter().flatten());
        numbers.all(|v| v.abs() <= f64::from(f32::MAX))
    }

    /// The key of the camera at a frame.
    pub fn key(&self, frame: f64) -> PathKey {
        PathKey {
            frame,
            eye: DVec3::from_array(self.eye),
            orientation: Orientation::Target {
                target: DVec3::from_array(self.target),
                up: Some(DVec3::from_array(self.up)),
                roll: Some(self.roll),
            },
            lens: self.lens.overrides(),
            pinhole: None,
            shutter: None,
            readout: None,
            stereo: [None; 2],
            interp: Interp::default(),
            name: None,
        }
    }

    /// The state of the camera: that of a path with this single key.
    ///
    /// # Errors
    /// The pose or the lens is invalid.
    pub fn state(&self, frame: f64) -> Result<CameraState, PathError> {
        CameraPath::new(&[self.key(frame)])?.at(frame)
    }

    /// The camera for a film: that of a path with this single key, with the lens and the timing of the scene.
    ///
    /// # Errors
    /// The pose or the lens is invalid.
    pub fn frame_camera(
        &self,
        frame: f64,
        (lens, timing): (&Lens, Timing),
        film: FilmSize,
    ) -> Result<FrameCamera, PathError> {
        let path = CameraPath::new(&[self.key(frame)])?.with_scene_timing(timing);
        path.frame_camera(frame, |_| Ok(*lens), film)
    }
}
