//! The camera of a model by itself: one of the file, or one that frames the model.

use std::{f64::consts::PI, path::Path};

use glam::{DVec2, DVec3};

use crate::{
    assets::{
        AssetError,
        model::{ModelCamera, ModelView},
    },
    camera::{
        CameraDesc,
        orthographic::OrthographicDesc,
        perspective::{FovDegrees, PerspectiveDesc},
    },
    describe::{Overrides, Stage},
    math::{Aabb, DAabb, Vec3, origin},
    value::{Point, Positive, Spanned, one_line},
    warnings::{WarningKind, Warnings},
};

/// The vertical field of view of the default camera, in degrees.
const FOV: f64 = 35.0;
/// The direction of the default camera from the model: right, above and in front, a three-quarter view.
const FROM: DVec3 = DVec3::new(0.6, 0.36, 1.0);
/// The width of a full-frame sensor, in mm.
const SENSOR_WIDTH: f64 = 36.0;
/// The width of the picture relative to the model.
const MARGIN: f64 = 1.08;

/// The lens that flags give a camera.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StageLens {
    /// In mm, with a full-frame sensor.
    pub focal_length: Option<f64>,
    fstop: Option<f64>,
}

impl StageLens {
    pub fn new(overrides: &Overrides) -> Self {
        let of = |wanted| overrides.stage().filter(|(stage, _)| *stage == wanted).last();
        let number = |wanted| of(wanted).and_then(|(_, text)| text.parse().ok());
        Self {
            focal_length: number(Stage::Lens),
            fstop: number(Stage::FStop),
        }
    }
}

/// A camera that is supplied.
#[derive(Clone, Copy, Debug)]
pub(super) struct SuppliedCamera {
    eye: DVec3,
    target: DVec3,
    up: DVec3,
    lens: SuppliedLens,
    stage: StageLens,
}

#[derive(Clone, Copy, Debug)]
enum SuppliedLens {
    /// The vertical field of view, in degrees.
    Perspective(f64),
    /// The height of the view, in m.
    Orthographic(f64),
}

fn positive(v: f64) -> Spanned<Positive> {
    unspanned(Positive(v as f32))
}

fn unspanned<T>(value: T) -> Spanned<T> {
    Spanned::new(0..0, value)
}

impl SuppliedCamera {
    /// The same camera with this lens, if it has one.
    pub fn with(self, stage: StageLens) -> Self {
        Self { stage, ..self }
    }

    /// The kind in a scene file.
    pub fn kind(&self) -> &'static str {
        match self.lens {
            SuppliedLens::Perspective(_) => "perspective",
            SuppliedLens::Orthographic(_) => "orthographic",
        }
    }

    /// Its table in a scene file.
    pub fn toml(&self) -> String {
        let [eye, target, up] = [self.eye, self.target, self.up].map(|v| format!("{:?}", v.to_array()));
        let lens = match self.lens {
            SuppliedLens::Perspective(fov) => format!("fov = {fov:?}"),
            SuppliedLens::Orthographic(height) => format!("height = {height:?}"),
        };
        let kind = self.kind();
        format!("[camera.{kind}]\neye = {eye}\ntarget = {target}\nup = {up}\n{lens}\n")
    }

    pub fn desc(&self) -> CameraDesc {
        let (eye, target, up) = (Point::new(self.eye), Point::new(self.target), Point::new(self.up));
        match self.lens {
            SuppliedLens::Perspective(degrees) => CameraDesc::Perspective(PerspectiveDesc {
                eye,
                target: unspanned(target),
                up,
                fov: Some(unspanned(FovDegrees(degrees))).filter(|_| self.stage.focal_length.is_none()),
                blades: None,
                blade_rotation: None,
                fov_x: None,
                focal_length: self.stage.focal_length.map(positive),
                sensor_width: self.stage.focal_length.map(|_| positive(SENSOR_WIDTH)),
                sensor_fit: None,
                sensor_height: None,
                aperture_radius: None,
                fstop: self.stage.fstop.map(positive),
                focus_distance: None,
                shift: None,
            }),
            SuppliedLens::Orthographic(height) => CameraDesc::Orthographic(OrthographicDesc {
                eye,
                target: unspanned(target),
                up,
                height: Positive(height as f32),
                shift: None,
            }),
        }
    }
}

/// The default camera, which frames `bounds` in a picture of this ratio of its sides; with a lens of this
/// focal length, in mm, if one is given.
pub(super) fn framing(bounds: &DAabb, aspect: f64, focal_length: Option<f64>) -> SuppliedCamera {
    let origin = origin::of_box(bounds).unwrap_or_default();
    let bounds = bounds.relative_to(origin);
    let bounds = if bounds.is_finite() {
        bounds
    } else {
        Aabb::from_points([Vec3::NEG_ONE, Vec3::ONE])
    };
    let center = bounds.center().as_dvec3();
    let back = FROM.normalize();
    let right = DVec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let half_height = match focal_length {
        Some(mm) => 0.5 * SENSOR_WIDTH / (mm * aspect),
        None => libm::tan(0.5 * FOV.to_radians()),
    };
    let tan = DVec2::new(aspect, 1.0) * half_height / MARGIN;
    // A corner at x to the right and z towards the camera is visible if |x| <= (distance - z) tan.
    let distance = (0..8)
        .map(|i| {
            let corner = bounds.corner(i).as_dvec3() - center;
            let (x, y, z) = (corner.dot(right).abs(), corner.dot(up).abs(), corner.dot(back));
            z + (x / tan.x).max(y / tan.y)
        })
        .fold(0.0, f64::max);
    // A model that is a single point has no size.
    let distance = if distance > 0.0 { distance } else { 1.0 };
    let [eye, target] = [center + back * distance, center].map(|p| origin + p.as_vec3().as_dvec3());
    SuppliedCamera {
        eye,
        target,
        up: DVec3::Y,
        lens: SuppliedLens::Perspective(FOV),
        stage: StageLens::default(),
    }
}

/// The index of the camera of this name, or of this number from 0. Without a name it is the first,
/// with a warning if there are others.
pub(super) fn chosen(
    cameras: &[ModelCamera],
    name: Option<&str>,
    path: &Path,
    warnings: &Warnings,
) -> Result<Option<usize>, AssetError> {
    let names = || {
        let name = |(i, c): (usize, &ModelCamera)| match c.name.as_str() {
            "" => i.to_string(),
            name => format!("`{}`", one_line(name, 80)),
        };
        cameras.iter().enumerate().map(name).collect::<Vec<_>>().join(", ")
    };
    let Some(name) = name else {
        if cameras.len() > 1 {
            let (shown, names) = (path.display(), names());
            let text =
                format!("{shown}: there are several cameras ({names}), and the first is shown; --camera chooses one");
            warnings.add_topic(WarningKind::CHOICE, "cameras", shown, text);
        }
        return Ok((!cameras.is_empty()).then_some(0));
    };
    let by_number = || name.parse::<usize>().ok().filter(|number| *number < cameras.len());
    let found = cameras.iter().position(|c| c.name == name).or_else(by_number);
    found.map(Some).ok_or_else(|| AssetError::NoCamera {
        name: one_line(name, 80).into_owned(),
        known: if cameras.is_empty() { "none".to_owned() } else { names() },
        path: path.to_owned(),
    })
}

/// A camera of the model, whose centre is `center`; `None` if it is degenerate.
pub(super) fn own(camera: &ModelCamera, center: DVec3) -> Option<SuppliedCamera> {
    let place = camera.model_from_camera;
    let eye = place.translation;
    let forward = (-place.matrix3.z_axis).try_normalize()?;
    let up = place.matrix3.y_axis.try_normalize()?;
    let to_model = (center - eye).dot(forward);
    let distance = if to_model > 0.0 && to_model.is_finite() {
        to_model
    } else {
        1.0
    };
    let target = eye + forward * distance;
    if !eye.is_finite() || Point::new(eye) == Point::new(target) {
        return None;
    }
    let lens = match camera.view {
        ModelView::Perspective { fov } => SuppliedLens::Perspective((fov > 0.0 && fov < PI).then(|| fov.to_degrees())?),
        ModelView::Orthographic { height } => SuppliedLens::Orthographic(height),
    };
    Some(SuppliedCamera {
        eye,
        target,
        up,
        lens,
        stage: StageLens::default(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Lens};

    #[test]
    fn the_default_view_holds_the_whole_model_and_little_more() {
        let bounds = Aabb::from_points([Vec3::new(-1.0, 4.0, 0.0), Vec3::new(9.0, 5.0, 2.0)]);
        for aspect in [0.5, 1.0, 16.0 / 9.0] {
            let compiled = framing(&bounds.into(), aspect, None).desc().compile().unwrap();
            let to_camera = compiled.pose.world_from_camera().inverse();
            let tan = libm::tan(0.5 * FOV.to_radians());
            let reach = (0..8)
                .map(|i| {
                    let p = to_camera.transform_point3(bounds.corner(i).as_dvec3());
                    (p.x / (-p.z * tan * aspect)).abs().max((p.y / (-p.z * tan)).abs())
                })
                .fold(0.0, f64::max);
            assert!((reach * MARGIN - 1.0).abs() < 1e-3, "{aspect}: {reach}");
            assert!(matches!(compiled.lens, Lens::Perspective(_)));
            let _ = Camera::new(&compiled.pose, &compiled.lens, [16, 9]);
        }
    }
}
