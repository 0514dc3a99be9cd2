//! The scene of a model file. Missing parts have defaults.

use std::{f64::consts::PI, path::Path, sync::Arc};

use glam::{DVec2, DVec3};

use super::Error;
use crate::{
    assets::{
        AssetError, Store,
        model::{LightUnits, Model, ModelCamera, ModelChoice, ModelView},
        motion::{EditedParts, ModelEdits},
        store::ModelRequest,
    },
    camera::{
        CameraDesc,
        orthographic::OrthographicDesc,
        perspective::{FovDegrees, PerspectiveDesc},
    },
    describe::{self, BackgroundDesc, LightEntry, ObjectDesc, Overrides, PartsDesc, SceneDesc, Source},
    light::{LightDesc, sun::SunDesc},
    math::{Aabb, DAabb, Rgb, Vec3, origin},
    shape::{
        ShapeDesc,
        mesh::{AnimationChoice, MeshDesc, Playback, Repeat},
    },
    value::{Direction, NonNegative, Point, Positive, RgbFactor, Spanned, one_line},
    warnings::{WarningKind, Warnings},
};

/// The vertical field of view of the default camera, in degrees.
const FOV: f64 = 35.0;
/// The direction of the default camera from the model: right, above and in front, a three-quarter view.
const FROM: DVec3 = DVec3::new(0.6, 0.36, 1.0);
/// The width of the picture relative to the model.
const MARGIN: f64 = 1.08;

/// The number of steps of a run at whose ends its bounds are computed.
const RUN_SAMPLES: u32 = 64;

/// The direction of the sun's light, over the left shoulder of that camera.
const SUN: Vec3 = Vec3::new(0.35, -1.0, -0.75);
const SUN_IRRADIANCE: f32 = 2.2;
/// The angular diameter of the real sun, in degrees.
const SUN_ANGLE: f32 = 0.53;
/// The radiance of the constant sky. With the sun it makes a white surface about 0.9 bright.
const BACKGROUND: f32 = 0.25;

fn unspanned<T>(value: T) -> Spanned<T> {
    Spanned::new(0..0, value)
}

/// The choices about a model that is the scene.
#[derive(Clone, Copy, Debug)]
pub struct ModelOptions<'a> {
    /// Values for keys of the scene file that there might be.
    pub overrides: &'a Overrides,
    /// The name of a camera of the file; `None` for the first.
    pub camera: Option<&'a str>,
    /// The name of a material variant; `None` for the default materials.
    pub variant: Option<&'a str>,
    /// The unit of its lights.
    pub light_units: LightUnits,
    /// The animations that are played.
    pub animation: Option<&'a AnimationChoice>,
    /// The radius of points, in m.
    pub point_radius: Option<f32>,
}

/// One run of the animations that a model by itself plays.
pub struct ModelRun {
    /// The time of the last key, in s.
    pub end: f64,
    /// The model with its camera that moves, and the centre of the model.
    camera: Option<(Arc<Model>, usize, DVec3)>,
}

impl ModelRun {
    /// Whether the camera of the scene moves.
    pub fn moves_camera(&self) -> bool {
        self.camera.is_some()
    }

    /// The camera at `time`, in s, if it moves and is not degenerate then.
    pub fn camera(&self, time: f64) -> Option<CameraDesc> {
        let (model, camera, center) = self.camera.as_ref()?;
        let pose = model.pose(&Playback::default(), &ModelEdits::default(), time)?;
        own_camera(&pose.cameras[*camera], *center)
    }
}

/// The bounds of a model in all poses of its run, or at rest.
fn bounds_of_run(model: &Model) -> DAabb {
    let Some(motion) = &model.motion else {
        return model.bounds();
    };
    let at = |i: u32| {
        let time = f64::from(motion.end()) * f64::from(i) / f64::from(RUN_SAMPLES);
        model
            .posed(motion.pose(&Playback::default(), &ModelEdits::default(), time))
            .bounds()
    };
    (0..=RUN_SAMPLES).map(at).fold(DAabb::EMPTY, DAabb::union)
}

/// The scene of the model at `path`, and the run of its animations, if it plays any.
pub fn describe(path: &Path, options: ModelOptions<'_>, store: &Store) -> Result<(SceneDesc, Option<ModelRun>), Error> {
    let source = Source::new(path.to_owned(), "").with(options.overrides.clone());
    let desc = describe::parse(source).map_err(Error::Invalid)?;
    let [width, height] = desc.render.resolution().map(f64::from);
    let model = store.model(&ModelRequest {
        path: path.to_owned(),
        choice: ModelChoice {
            scene: None,
            variant: options.variant.map(str::to_owned),
            lights: Some(true),
            light_units: options.light_units,
            animation: options.animation.cloned(),
            edited: EditedParts::default(),
        },
    })?;
    let mut objects = Vec::new();
    if model.is_empty() {
        let path = path.display();
        let text = format!("the model has no triangles, there is nothing to see: {path}");
        store.warnings().add(WarningKind::EMPTY_MODEL, path, text);
    } else {
        objects.push(object(path, options));
    }
    let bounds = bounds_of_run(&model);
    let origin = origin::of_box(&bounds).unwrap_or_default();
    let near = bounds.relative_to(origin);
    let center = origin + near.center().as_dvec3();
    let chosen = chosen_camera(&model.cameras, options.camera, path, store.warnings())?;
    let camera = chosen.and_then(|chosen| own_camera(&model.cameras[chosen], center));
    let moves = |camera: &usize| model.motion.as_ref().is_some_and(|motion| motion.moves_camera(*camera));
    let moving = chosen
        .filter(|_| desc.camera.is_none() && camera.is_some())
        .filter(moves);
    let run = model.motion.as_ref().map(|motion| ModelRun {
        end: motion.end().into(),
        camera: moving.map(|camera| (Arc::clone(&model), camera, center)),
    });
    // A file with lights gets no others.
    let is_lit = model.lights.iter().any(|light| !light.strength.is_black());
    let desc = SceneDesc {
        camera: desc.camera.or_else(|| {
            let camera = camera.unwrap_or_else(|| framing(origin, &near, width / height));
            Some(unspanned(camera))
        }),
        background: BackgroundDesc {
            color: Some(RgbFactor(Rgb::gray(if is_lit { 0.0 } else { BACKGROUND }))),
            ..BackgroundDesc::default()
        },
        objects,
        lights: if is_lit { Vec::new() } else { vec![daylight()] },
        ..desc
    };
    Ok((desc, run))
}

fn object(path: &Path, options: ModelOptions<'_>) -> ObjectDesc {
    let name = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    ObjectDesc {
        name: Some(unspanned(name(path.file_stem()))),
        material: None,
        shape: unspanned(ShapeDesc::Mesh(MeshDesc {
            file: unspanned(name(path.file_name())),
            scene: None,
            variant: options.variant.map(str::to_owned),
            lights: Some(true),
            light_units: options.light_units,
            animation: options.animation.cloned(),
            start: None,
            speed: None,
            repeat: Repeat::Once,
            radius: options.point_radius.map(Positive),
        })),
        transform: None,
        visible: true,
        group: None,
        parts: PartsDesc::default(),
    }
}

fn daylight() -> LightEntry {
    LightEntry {
        span: 0..0,
        name: None,
        group: None,
        light: LightDesc::Sun(SunDesc {
            direction: Direction(SUN.normalize()),
            irradiance: RgbFactor(Rgb::gray(SUN_IRRADIANCE)),
            angle: Some(unspanned(NonNegative(SUN_ANGLE))),
        }),
    }
}

/// A perspective camera at `eye` (m) with a vertical field of view in degrees.
fn perspective(eye: DVec3, target: DVec3, up: DVec3, degrees: f64) -> CameraDesc {
    CameraDesc::Perspective(PerspectiveDesc {
        eye: Point::new(eye),
        target: unspanned(Point::new(target)),
        up: Point::new(up),
        fov: Some(unspanned(FovDegrees(degrees))),
        blades: None,
        blade_rotation: None,
        fov_x: None,
        focal_length: None,
        sensor_width: None,
        sensor_fit: None,
        sensor_height: None,
        aperture_radius: None,
        fstop: None,
        focus_distance: None,
        shift: None,
    })
}

/// The default camera, which frames `bounds`, relative to `origin`.
fn framing(origin: DVec3, bounds: &Aabb, aspect: f64) -> CameraDesc {
    let bounds = if bounds.is_finite() {
        *bounds
    } else {
        Aabb::from_points([Vec3::NEG_ONE, Vec3::ONE])
    };
    let center = bounds.center().as_dvec3();
    let back = FROM.normalize();
    let right = DVec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let tan = DVec2::new(aspect, 1.0) * libm::tan(0.5 * FOV.to_radians()) / MARGIN;
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
    perspective(eye, target, DVec3::Y, FOV)
}

/// The index of the camera of this name, or of this number from 0. Without a name it is the first, with a warning if there are others.
fn chosen_camera(
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
fn own_camera(camera: &ModelCamera, center: DVec3) -> Option<CameraDesc> {
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
    let (from, to) = (Point::new(eye), Point::new(target));
    if !eye.is_finite() || from == to {
        return None;
    }
    match camera.view {
        ModelView::Perspective { fov } => (fov < PI).then(|| perspective(eye, target, up, fov.to_degrees())),
        ModelView::Orthographic { height } => Some(CameraDesc::Orthographic(OrthographicDesc {
            eye: from,
            target: unspanned(to),
            up: Point::new(up),
            height: Positive(height as f32),
            shift: None,
        })),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Lens};

    #[test]
    fn the_default_view_holds_the_whole_model_and_little_more() {
        let bounds = Aabb::from_points([Vec3::new(-1.0, 4.0, 0.0), Vec3::new(9.0, 5.0, 2.0)]);
        for aspect in [0.5, 1.0, 16.0 / 9.0] {
            let compiled = framing(DVec3::ZERO, &bounds, aspect).compile().unwrap();
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
