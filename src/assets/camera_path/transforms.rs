//! `transforms.json` of NeRF programs, and camera paths of nerfstudio's viewer.
//!
//! A frame has a `transform_matrix` from camera to world, of 4 or 3 rows; the camera looks along its -z with +y up, lengths are
//! taken for metres. The intrinsics `fl_x`, `fl_y`, `cx`, `cy`, `w`, `h`, `camera_model` and the distortion `k1` to `k4`, `p1`,
//! `p2` are those of the file, or of a frame where it has its own; pixel centres are at .5. In place of focal lengths there may be
//! `camera_angle_x` or `camera_angle_y`, in radians. The number of a frame is its key `frame`, or as that of COLMAP's pictures from
//! `file_path`, in the order of the file.
//!
//! | `camera_model` | coefficients | read as |
//! |---|---|---|
//! | none, `OPENCV`, `PINHOLE`, `SIMPLE_PINHOLE` | `k1, k2, k3, p1, p2` | `opencv` |
//! | `OPENCV_FISHEYE`, or none with instant-ngp's `is_fisheye` | `k1, k2, k3, k4` | `kannala_brandt` |
//!
//! A camera path of nerfstudio has `camera_path`, a list of `camera_to_world` (16 numbers by rows) and `fov`, the angle over
//! the picture's height in degrees, and `render_width` and `render_height`. Its `camera_type` is `perspective`; others, such
//! as `equirectangular`, are refused.
//!
//! Source: Mildenhall et al., "NeRF", ECCV 2020, doi:10.1007/978-3-030-58452-8_24, with the keys of instant-ngp and nerfstudio
//! (docs.nerf.studio, "Data conventions").

use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Deserializer, de};

use super::{
    CameraPathFormat, PathProblem, PathProblems,
    held::{Holds, POSES, Target, Written},
    keys::{self, Frames, Intrinsics, Posed},
    source::{Source, line_at},
    still::Still,
};
use crate::{
    camera::{
        ViewDistortion,
        lens::FieldOfView,
        path::{CameraPath, MAX_FRAME},
    },
    value::one_line,
};

mod written;

/// The only type of cameras of a path of nerfstudio that is read.
const PERSPECTIVE: &str = "perspective";

pub use written::{CONVENTIONS, Frame, Transforms, model_name};

/// The intrinsics of a file or of a frame.
#[derive(Clone, Default, Deserialize)]
#[serde(default)]
struct Given {
    fl_x: Option<f64>,
    fl_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    w: Option<f64>,
    h: Option<f64>,
    camera_angle_x: Option<f64>,
    camera_angle_y: Option<f64>,
    camera_model: Option<String>,
    is_fisheye: Option<bool>,
    k1: Option<f64>,
    k2: Option<f64>,
    k3: Option<f64>,
    k4: Option<f64>,
    p1: Option<f64>,
    p2: Option<f64>,
}

#[derive(Deserialize)]
struct GivenFrame {
    file_path: Option<String>,
    frame: Option<i64>,
    transform_matrix: Matrix,
    #[serde(flatten)]
    own: Given,
}

/// A pose of a path of nerfstudio.
#[derive(Deserialize)]
struct Stop {
    camera_to_world: Matrix,
    fov: f64,
}

#[derive(Deserialize)]
#[serde(expecting = "an object with a list `frames` or `camera_path`")]
struct Document {
    frames: Option<Vec<GivenFrame>>,
    camera_path: Option<Vec<Stop>>,
    render_width: Option<f64>,
    render_height: Option<f64>,
    camera_type: Option<String>,
    #[serde(flatten)]
    common: Given,
}

/// A pose from camera to world.
struct Matrix(DQuat, DVec3);

/// Rows, or all numbers in a row.
#[derive(Deserialize)]
#[serde(untagged)]
enum Rows {
    Rows(Vec<[f64; 4]>),
    Flat(Vec<f64>),
}

impl<'de> Deserialize<'de> for Matrix {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let expected = || de::Error::custom("expected a matrix of 4 or 3 rows with 4 numbers each");
        let rows = match Rows::deserialize(deserializer).map_err(|_| expected())? {
            Rows::Rows(rows) => rows,
            Rows::Flat(flat) if !flat.len().is_multiple_of(4) => return Err(expected()),
            Rows::Flat(flat) => flat
                .chunks_exact(4)
                .map(|row| [row[0], row[1], row[2], row[3]])
                .collect(),
        };
        let ([x, y, z] | [x, y, z, [0.0, 0.0, 0.0, 1.0]]) = &rows[..] else {
            return Err(expected());
        };
        let row = |row: &[f64; 4]| DVec3::new(row[0], row[1], row[2]);
        let eye = DVec3::new(x[3], y[3], z[3]);
        if !keys::is_place(eye) {
            return Err(de::Error::custom("the position is not finite or too large"));
        }
        let matrix = DMat3::from_cols(row(x), row(y), row(z)).transpose();
        keys::rotation(&matrix)
            .map(|rotation| Self(rotation, eye))
            .map_err(de::Error::custom)
    }
}

pub(super) const FORMAT: CameraPathFormat = CameraPathFormat {
    name: "transforms",
    extensions: &["json"],
    names: &[],
    read,
    holds: Holds {
        names: true,
        view: true,
        center: true,
        pixels: true,
        distortion: |distortion| !matches!(distortion, ViewDistortion::OpenCv([_, _, _, _, _, others @ ..]) if *others != [0.0; 7]),
        ..POSES
    },
    write,
};

fn read(source: &Source<'_>) -> Result<CameraPath, PathProblems> {
    let text = source.text()?;
    let document: Document = serde_json::from_str(text).map_err(|error| {
        let message = error.to_string();
        // The place stands before the message.
        let message = message.split(" at line ").next().unwrap_or_default();
        PathProblem::of_line(error.line(), message)
    })?;
    if let Some(kind) = document.camera_type.filter(|kind| kind != PERSPECTIVE) {
        let at = text.find("\"camera_type\"").unwrap_or(0);
        let kind = one_line(&kind, 80);
        let message = format!(
            "the camera type `{kind}` is not read, expected {PERSPECTIVE}: a path of poses moves a camera of another kind, such as \
             `[camera] panorama`, from a CSV file"
        );
        return Err(PathProblem::of_line(line_at(text.as_bytes(), at), message).into());
    }
    match (document.frames, document.camera_path) {
        (Some(frames), None) if !frames.is_empty() => pictures(text, frames, &document.common),
        (None, Some(stops)) if !stops.is_empty() => {
            let size = document.render_width.zip(document.render_height);
            let posed = stops.into_iter().map(|stop| stop.posed(size));
            let posed = posed.collect::<Result<Vec<_>, _>>().map_err(PathProblem::of_file)?;
            let numbered = posed.into_iter().enumerate().map(|(i, posed)| ((i + 1) as f64, posed));
            keys::path(numbered, Frames::Way)
        }
        _ => Err(
            PathProblem::of_file("expected a list `frames`, or a list `camera_path`, with at least one camera").into(),
        ),
    }
}

fn pictures(text: &str, frames: Vec<GivenFrame>, common: &Given) -> Result<CameraPath, PathProblems> {
    let own: Option<Vec<i64>> = frames.iter().map(|frame| frame.frame).collect();
    let numbers = own.unwrap_or_else(|| keys::picture_frames(frames.iter().map(|frame| frame.file_path.as_deref())));
    let mut problems = PathProblems::default();
    let mut posed = Vec::with_capacity(frames.len());
    for (number, frame) in numbers.into_iter().zip(frames) {
        let Matrix(rotation, eye) = frame.transform_matrix;
        let mut camera = Posed::new(eye, rotation);
        let name = frame.file_path.unwrap_or_default();
        if let Err(message) = frame.own.or(common).apply(&mut camera) {
            // The key stands with the frame, or above all frames.
            let at = text.find(name.as_str()).filter(|_| !name.is_empty()).unwrap_or(0);
            problems.push(PathProblem::of_line(line_at(text.as_bytes(), at), message));
        }
        if !(-MAX_FRAME..=MAX_FRAME).contains(&number) {
            problems.push(PathProblem::of_file(format!("frame {number} is out of range")));
        }
        camera.name = Some(name).filter(|name| !name.is_empty());
        posed.push((number as f64, camera));
    }
    if problems.is_empty() {
        keys::path(posed, Frames::Pictures)
    } else {
        Err(problems)
    }
}

impl Stop {
    fn posed(self, size: Option<(f64, f64)>) -> Result<Posed, String> {
        let Matrix(rotation, eye) = self.camera_to_world;
        let given = Given {
            camera_angle_y: Some(self.fov.to_radians()),
            w: size.map(|size| size.0),
            h: size.map(|size| size.1),
            ..Given::default()
        };
        let mut posed = Posed::new(eye, rotation);
        given.apply(&mut posed).map(|()| posed)
    }
}

impl Given {
    /// These, with those of the file where they have none.
    fn or(self, common: &Self) -> Self {
        // Focal lengths or angles of the frame replace all of the file's.
        let has_focal = self
            .fl_x
            .or(self.fl_y)
            .or(self.camera_angle_x)
            .or(self.camera_angle_y)
            .is_some();
        let focal = |own: Option<f64>, other: Option<f64>| own.or(other.filter(|_| !has_focal));
        Self {
            fl_x: focal(self.fl_x, common.fl_x),
            fl_y: focal(self.fl_y, common.fl_y),
            camera_angle_x: focal(self.camera_angle_x, common.camera_angle_x),
            camera_angle_y: focal(self.camera_angle_y, common.camera_angle_y),
            cx: self.cx.or(common.cx),
            cy: self.cy.or(common.cy),
            w: self.w.or(common.w),
            h: self.h.or(common.h),
            camera_model: self.camera_model.or_else(|| common.camera_model.clone()),
            is_fisheye: self.is_fisheye.or(common.is_fisheye),
            k1: self.k1.or(common.k1),
            k2: self.k2.or(common.k2),
            k3: self.k3.or(common.k3),
            k4: self.k4.or(common.k4),
            p1: self.p1.or(common.p1),
            p2: self.p2.or(common.p2),
        }
    }

    /// The distortion of the lens.
    fn distortion(&self) -> Result<ViewDistortion, String> {
        let [k1, k2, k3, k4, p1, p2] =
            [self.k1, self.k2, self.k3, self.k4, self.p1, self.p2].map(Option::unwrap_or_default);
        let (unnamed, is_fisheye) = match self.is_fisheye {
            Some(true) => ("OPENCV_FISHEYE", true),
            _ => ("OPENCV", false),
        };
        match self.camera_model.as_deref().unwrap_or(unnamed) {
            model if is_fisheye && model != "OPENCV_FISHEYE" => Err(format!(
                "`is_fisheye` is true, but the camera model is {}",
                one_line(model, 80)
            )),
            "OPENCV" | "PINHOLE" | "SIMPLE_PINHOLE" if k4 != 0.0 => {
                Err("a fourth radial coefficient `k4` is rendered with OPENCV_FISHEYE only".to_owned())
            }
            "OPENCV" | "PINHOLE" | "SIMPLE_PINHOLE" => Ok(match [k1, k2, p1, p2, k3] == [0.0; 5] {
                true => ViewDistortion::None,
                false => ViewDistortion::OpenCv([k1, k2, p1, p2, k3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            }),
            "OPENCV_FISHEYE" => Ok(ViewDistortion::OpenCvFisheye([k1, k2, k3, k4])),
            other => Err(format!(
                "the camera model `{other}` is not rendered, expected OPENCV, OPENCV_FISHEYE, PINHOLE or SIMPLE_PINHOLE"
            )),
        }
    }

    /// Gives a camera its lens: in pixels where the file tells how many, else by its angle.
    fn apply(&self, camera: &mut Posed) -> Result<(), String> {
        let distortion = self.distortion()?;
        let angles = [self.camera_angle_x, self.camera_angle_y];
        if let Some(angle) = angles
            .iter()
            .flatten()
            .find(|a| !(**a > 0.0 && **a < std::f64::consts::PI))
        {
            return Err(format!("the camera angle {angle} is not above 0 and below pi"));
        }
        let of_angle = |size: Option<f64>, angle: Option<f64>| Some(0.5 * size? / libm::tan(0.5 * angle?));
        let x = self.fl_x.or_else(|| of_angle(self.w, self.camera_angle_x));
        let y = self.fl_y.or_else(|| of_angle(self.h, self.camera_angle_y));
        if let Some(first) = x.or(y) {
            let intrinsics = Intrinsics {
                focal: [first, y.unwrap_or(first)],
                center: [self.cx, self.cy],
                skew: 0.0,
                size: self.w.zip(self.h).map(|(w, h)| [w, h]),
                distortion,
            };
            camera.pinhole = Some(intrinsics.lens()?);
            return Ok(());
        }
        if distortion != ViewDistortion::None {
            return Err("a distortion needs `fl_x`, or `w` and `camera_angle_x`".to_owned());
        }
        camera.lens.view = match angles {
            [_, Some(angle)] => Some(FieldOfView::Vertical(angle.to_degrees())),
            [Some(angle), None] => Some(FieldOfView::Horizontal(angle.to_degrees())),
            [None, None] => None,
        };
        Ok(())
    }
}

fn write(target: &Target<'_>, cameras: &[Still]) -> Written {
    let file = Transforms::of_cameras(cameras)?;
    let text = serde_json::to_string_pretty(&file).expect("numbers and texts are JSON") + "\n";
    target.file(text)
}
