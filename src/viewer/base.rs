//! The scene of a viewer, compiled once, and the plans of its looks.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use super::{keyframes::Keyframes, look::Look, options::ViewerOptions};
use crate::{
    assets::Files,
    batch::{InputHash, Job, Plan, Request},
    camera::{CameraDesc, FilmSize, Lens, LookAt},
    describe::SceneDesc,
    error::Error,
    math::DVec3,
    scene::Scene,
};

/// The scene, its description and the request of the job.
pub struct Base {
    pub scene: Scene,
    pub scene_path: PathBuf,
    pub desc: SceneDesc,
    pub request: Request,
    pub camera_path: PathBuf,
    pub command: fn(&[(&str, String)]) -> String,
    /// The hash of all that was loaded.
    pub inputs: InputHash,
    /// The plan of the job as it was requested.
    pub plan: Arc<Plan>,
    /// The lens of the scene's camera.
    pub lens: Lens,
    /// The scene's camera, if it has one.
    pub home: Option<(DVec3, LookAt)>,
    /// Taken by the session.
    pub keyframes: Option<Keyframes>,
    /// A suitable step of the camera, in m.
    pub step: f64,
}

impl Base {
    pub fn load(scene_path: &Path, request: &Request, options: &ViewerOptions) -> Result<Self, Error> {
        let mut request = request.clone();
        let keyframes = Keyframes::open(&options.camera_path, &request)?;
        // A job cannot read a file without keys.
        request.camera_path = keyframes.has_keys().then(|| options.camera_path.clone());
        let job = Job::open(scene_path, &request)?;
        let scene = job.compile()?;
        let plan = Arc::new(job.plan.metered(&scene, None)?);
        let camera = job.desc.camera.as_ref().map(|camera| camera.get_ref());
        let compiled = camera.and_then(|camera| camera.compile().ok());
        Ok(Self {
            step: step_of(&scene),
            scene,
            inputs: job.inputs(),
            scene_path: scene_path.to_owned(),
            lens: compiled.map_or_else(Lens::default, |camera| camera.lens),
            home: camera.map(CameraDesc::view),
            plan,
            desc: job.desc,
            request,
            camera_path: options.camera_path.clone(),
            command: options.command,
            keyframes: Some(keyframes),
        })
    }

    /// The look of the job as it was requested.
    pub fn look(&self) -> Look {
        Look::of_plan(&self.plan, &self.desc)
    }

    /// The plan of a look, without passes and files that its pictures do not show.
    pub fn plan(&self, look: &Look) -> Result<Plan, Error> {
        let request = Request {
            camera_path: self.request.camera_path.clone().filter(|_| self.home.is_none()),
            range: None,
            turntable: None,
            ..look.apply_all(&self.request)
        };
        Plan::new(&self.desc.with(&request.overrides)?, &request, &Files::default())
    }

    /// Columns and rows of the full picture.
    pub fn resolution(&self) -> FilmSize {
        self.plan.picture.settings.resolution
    }
}

/// About a hundredth of the scene's extent, as 1, 2 or 5 times a power of ten.
fn step_of(scene: &Scene) -> f64 {
    let bounds = scene.geometry.accel.geometry().world_bounds();
    let extent = f64::from((bounds.max - bounds.min).length());
    if !(extent.is_finite() && extent > 0.0) {
        return 0.1;
    }
    let wanted = extent / 100.0;
    let power = libm::pow(10.0, libm::floor(libm::log10(wanted)));
    let steps = [1.0, 2.0, 5.0, 10.0].map(|n| n * power);
    let nearest = |a: &&f64, b: &&f64| (*a / wanted - 1.0).abs().total_cmp(&(*b / wanted - 1.0).abs());
    steps.iter().min_by(nearest).copied().unwrap_or(power)
}
