//! `transforms.json` as it is written, and read again where several jobs write it.

use std::{borrow::Cow, collections::BTreeMap};

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{
    assets::camera_path::{keys::Intrinsics, still::Still},
    camera::ViewDistortion,
};

/// The conventions of the file, in words.
pub const CONVENTIONS: &str = "transform_matrix is camera to world, in metres; the camera looks along its -z, +y is up; \
     lengths of intrinsics are in pixels, and pixel centres are at .5; cameras are those at which shutters open";

/// The content of `transforms.json`.
#[derive(Serialize, Deserialize)]
pub struct Transforms {
    pub conventions: Cow<'static, str>,
    pub camera_model: Cow<'static, str>,
    /// The place of a model by itself that was moved to have a common size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model_place: Option<Value>,
    pub w: u32,
    pub h: u32,
    pub frames: Vec<Frame>,
}

/// The camera of a frame, camera to world: it looks along its -z with +y up.
#[derive(Serialize, Deserialize)]
pub struct Frame {
    pub file_path: String,
    pub frame: i32,
    pub fl_x: f64,
    pub fl_y: f64,
    pub cx: f64,
    pub cy: f64,
    pub camera_angle_x: f64,
    pub camera_angle_y: f64,
    /// The size of the picture, where it is not that of the first.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub w: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub h: Option<u32>,
    #[serde(flatten)]
    pub distortion: Coefficients,
    pub transform_matrix: [[f64; 4]; 4],
    /// The values that were drawn for the picture, by their names.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub values: Option<BTreeMap<String, Value>>,
}

/// Coefficients under their names.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Coefficients {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k1: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k2: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k3: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub k4: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p1: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p2: Option<f64>,
}

impl From<ViewDistortion> for Coefficients {
    fn from(distortion: ViewDistortion) -> Self {
        let radial = |k1, k2, k3| Self {
            k1: Some(k1),
            k2: Some(k2),
            k3: Some(k3),
            ..Self::default()
        };
        match distortion {
            ViewDistortion::None => Self::default(),
            // Cameras with the other terms are refused.
            ViewDistortion::OpenCv([k1, k2, p1, p2, k3, ..]) => Self {
                p1: Some(p1),
                p2: Some(p2),
                ..radial(k1, k2, k3)
            },
            ViewDistortion::OpenCvFisheye([k1, k2, k3, k4]) => Self {
                k4: Some(k4),
                ..radial(k1, k2, k3)
            },
        }
    }
}

/// The name of a distortion as `camera_model`.
pub fn model_name(distortion: &ViewDistortion) -> &'static str {
    match distortion {
        ViewDistortion::None => "PINHOLE",
        ViewDistortion::OpenCv(_) => "OPENCV",
        ViewDistortion::OpenCvFisheye(_) => "OPENCV_FISHEYE",
    }
}

impl Coefficients {
    /// The distortion of a camera of this model.
    fn distortion(&self, model: &str) -> ViewDistortion {
        let [k1, k2, k3, k4, p1, p2] =
            [self.k1, self.k2, self.k3, self.k4, self.p1, self.p2].map(Option::unwrap_or_default);
        match model {
            "OPENCV" => ViewDistortion::OpenCv([k1, k2, p1, p2, k3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            "OPENCV_FISHEYE" => ViewDistortion::OpenCvFisheye([k1, k2, k3, k4]),
            _ => ViewDistortion::None,
        }
    }
}

impl Frame {
    /// # Errors
    /// The camera has no lens in pixels, or no size.
    pub fn new(still: &Still) -> Result<Self, String> {
        let lens = still.lens("transforms")?;
        let size = lens
            .size
            .ok_or("transforms files have the size of pictures: say it (--resolution)")?;
        let (DMat3 { x_axis, y_axis, z_axis }, eye) = (still.axes, still.eye);
        let row = |i: usize| [x_axis[i], y_axis[i], z_axis[i], eye[i]];
        let ([fl_x, fl_y], [cx, cy]) = (lens.focal, lens.center.map(Option::unwrap_or_default));
        let angle = |axis: usize| 2.0 * libm::atan(0.5 * size[axis] / lens.focal[axis]);
        Ok(Self {
            file_path: still.name.clone().unwrap_or_else(|| format!("{:04}.png", still.frame)),
            frame: still.frame as i32,
            fl_x,
            fl_y,
            cx,
            cy,
            camera_angle_x: angle(0),
            camera_angle_y: angle(1),
            w: None,
            h: None,
            distortion: lens.distortion.into(),
            transform_matrix: [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
            values: None,
        })
    }
}

impl Transforms {
    /// The file of these cameras.
    ///
    /// # Errors
    /// A camera has no lens in pixels or no size, or the cameras have several models.
    pub fn of_cameras(cameras: &[Still]) -> Result<Self, String> {
        let mut frames: Vec<Frame> = cameras.iter().map(Frame::new).collect::<Result<_, _>>()?;
        let lenses: Vec<&Intrinsics> = cameras.iter().filter_map(|camera| camera.pixels.as_ref()).collect();
        let distorted = lenses.iter().map(|lens| model_name(&lens.distortion));
        // A camera without distortion has coefficients of 0 beside others.
        let mut models: Vec<&str> = distorted.filter(|model| *model != "PINHOLE").collect();
        models.dedup();
        let model = match models[..] {
            [] => "PINHOLE",
            [model] if model == "OPENCV" || lenses.iter().all(|lens| lens.distortion != ViewDistortion::None) => model,
            _ => return Err("transforms files have cameras of one model, and these have several".to_owned()),
        };
        let size = |lens: &Intrinsics| lens.size.unwrap_or_default().map(|n| n as u32);
        let [w, h] = lenses.first().map(|lens| size(lens)).unwrap_or_default();
        for (frame, lens) in frames.iter_mut().zip(lenses) {
            let own = size(lens);
            if own != [w, h] {
                [frame.w, frame.h] = own.map(Some);
            }
        }
        Ok(Self {
            conventions: CONVENTIONS.into(),
            camera_model: model.into(),
            model_place: None,
            w,
            h,
            frames,
        })
    }

    /// The camera of a frame.
    pub fn still(&self, frame: &Frame) -> Still {
        let matrix = &frame.transform_matrix;
        let column = |i: usize| DVec3::new(matrix[0][i], matrix[1][i], matrix[2][i]);
        // Rounding errors of turned cameras are not those of other lenses.
        let pixels = |v: f64| (v * 1e9).round() / 1e9;
        Still {
            frame: frame.frame.into(),
            name: Some(frame.file_path.clone()),
            eye: column(3),
            axes: DMat3::from_cols(column(0), column(1), column(2)),
            fov: None,
            pixels: Some(Intrinsics {
                focal: [frame.fl_x, frame.fl_y].map(pixels),
                center: [frame.cx, frame.cy].map(|c| Some(pixels(c))),
                skew: 0.0,
                size: Some([self.w, self.h].map(f64::from)),
                distortion: frame.distortion.distortion(&self.camera_model),
            }),
            is_calibrated: true,
            has_blur: false,
        }
    }
}
