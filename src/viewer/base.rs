//! The scene of a viewer, compiled when it is loaded, and the plans of its looks.

use std::{path::PathBuf, sync::Arc, time::SystemTime};

use super::{
    camera::ViewCamera, canvas::Canvas, input_files::InputFiles, look::Look, message::Hello, options::ViewerOptions,
    shown::Shown,
};
use crate::{
    assets::{Files, SuppliedFile},
    batch::{InputHash, Job, Plan, Request},
    camera::{CameraDesc, FilmSize, Lens, LensOverrides, LookAt, path::CameraPath},
    error::Error,
    film::passes::{BEAUTY, PASSES, PassSource},
    integrator::IntegratorDesc,
    math::DVec3,
    output::{Coverage, DisplayTransform},
    render,
    scene::{Background, Scene},
    value::UnknownName,
    warnings::Warnings,
};

/// The scene file of a viewer, and the request and the settings with which it is loaded.
pub struct Source {
    pub scene: PathBuf,
    pub request: Request,
    pub options: ViewerOptions,
    /// The threads of a job.
    pub threads: usize,
}

impl Source {
    /// Loads the scene with this camera path, if there is one, and collects the warnings about them in `warnings`.
    pub fn load(&self, path: Option<SuppliedFile>, warnings: Warnings) -> Result<Base, Error> {
        let request = Request {
            warnings,
            camera_path: path.as_ref().map(|(file, _)| file.clone()),
            ..self.request.clone()
        };
        let begun = SystemTime::now();
        let with_path = Request {
            supplied: path.clone(),
            ..request.clone()
        };
        let job = Job::open(&self.scene, &with_path)?;
        let mut scene = Arc::new(job.compile()?);
        let plan = match job.plan.picture.metering_camera {
            Some(_) if job.moves() => {
                let compiled = Arc::as_ptr(&scene);
                let mut scenes = job.scenes(scene);
                let plan = job.plan.metered(scenes.seek(job.plan.first_frame)?, None)?;
                scene = scenes.shared();
                if Arc::as_ptr(&scene) != compiled {
                    // A seeker begins with the scene that the job compiles.
                    scene = Arc::new(job.compile()?);
                }
                plan
            }
            _ => job.plan.metered(&scene, None)?,
        };
        let mut background = scene.shading.background.clone();
        background.visible &= !plan.values.as_ref().is_some_and(|values| values.hides_background());
        let mut manifest = job.files().manifest();
        // The session asks before it saves over a camera path that has changed.
        manifest.retain(|(path, _)| *path != self.options.camera_path);
        let camera = job.desc.camera.as_ref().map(|camera| camera.get_ref());
        let compiled = camera.and_then(|camera| camera.compile().ok());
        Ok(Base {
            step: step_of(&scene),
            groups: scene.shading.light_groups.names().to_vec(),
            background,
            shown: Shown::new(scene),
            inputs: job.inputs(),
            files: InputFiles::new(manifest, begun),
            lens: compiled.map_or_else(Lens::default, |camera| camera.lens),
            home: camera.map(CameraDesc::view),
            plan: Arc::new(plan),
            path,
            job,
            request,
        })
    }
}

/// The loaded scene, and the request of the job.
pub struct Base {
    /// The inputs from which the scenes of other frames are compiled.
    pub job: Job,
    pub shown: Shown,
    /// The light groups of the scene.
    groups: Vec<String>,
    /// The background, visible if it is so in all frames.
    background: Background,
    /// The camera path with which it was loaded.
    pub path: Option<SuppliedFile>,
    pub request: Request,
    /// The hash of all that was loaded.
    pub inputs: InputHash,
    /// The files that were read for the scene.
    pub files: InputFiles,
    /// The plan of the job as it was requested.
    pub plan: Arc<Plan>,
    /// The lens of the scene's camera.
    pub lens: Lens,
    /// The scene's camera, if it has one.
    pub home: Option<(DVec3, LookAt)>,
    /// A suitable step of the camera, in m.
    pub step: f64,
}

impl Base {
    /// The first message about the scene to the page `client`.
    pub fn hello(&self, client: u64) -> String {
        let passes: Vec<&str> = PASSES
            .iter()
            .filter(|pass| !matches!(pass.source, PassSource::Integrator | PassSource::LightGroup))
            .map(|pass| pass.name)
            .collect();
        let hello = Hello {
            t: "hello",
            client,
            scene: &self.job.desc.name(),
            resolution: self.resolution(),
            integrators: IntegratorDesc::NAMES,
            views: &DisplayTransform::ALL.map(DisplayTransform::name),
            passes: &[&[BEAUTY.name], &passes[..]].concat(),
            columns: self.lens.columns(),
            step: self.step,
            fps: self.request.fps.unwrap_or(24.0),
            frames: self.frames(),
            up: self.up().to_array(),
            has_home: self.home.is_some(),
            warnings: self.request.warnings.lines(),
        };
        serde_json::to_string(&hello).expect("a hello is numbers and words")
    }

    /// The first and the last frame of the job, if frames have different scenes.
    fn frames(&self) -> Option<[i32; 2]> {
        let frames = &self.plan.frames;
        let ends = [frames.first()?.number, frames.last()?.number];
        self.job.moves().then_some(ends)
    }

    /// The look of the job as it was requested.
    pub fn look(&self) -> Look {
        Look::of_plan(&self.plan, &self.job.desc)
    }

    /// The plan of a look, without passes and files that its pictures do not show.
    pub fn plan(&self, look: &Look) -> Result<Plan, Error> {
        let request = Request {
            camera_path: self.request.camera_path.clone().filter(|_| self.home.is_none()),
            values: None,
            random: None,
            range: None,
            turntable: None,
            views: None,
            ..look.apply_all(&self.request)
        };
        let mut desc = self.job.desc.with(&request.overrides)?;
        // The values are those that were read with the scene.
        (desc.values, desc.random) = (None, None);
        // The file on disk may have changed.
        let inputs = Files::default().with_supplied(self.path.clone());
        let mut plan = Plan::new(&desc, &request, &inputs)?;
        plan.values = self.plan.values.clone();
        Ok(plan)
    }

    /// A canvas for films of these settings of `plan`.
    ///
    /// # Errors
    /// A pass shows a light group that the scene does not have.
    pub fn canvas(&self, plan: &Plan, settings: &render::Settings, fills_film: bool) -> Result<Canvas, UnknownName> {
        Canvas::new(plan, settings, &self.groups, self.coverage(plan, fills_film))
    }

    /// The coverage of pictures by `plan`. `fills_film` tells whether every point of the picture has a camera ray.
    pub fn coverage(&self, plan: &Plan, fills_film: bool) -> Coverage {
        plan.coverage(&self.background, fills_film)
    }

    /// Columns and rows of the full picture.
    pub fn resolution(&self) -> FilmSize {
        self.plan.picture.settings.resolution
    }

    /// The scene's own camera at a frame.
    pub fn home_camera(&self, frame: i32) -> Option<ViewCamera> {
        let (eye, at) = self.home.as_ref()?;
        let moved = || {
            let camera = self.job.camera(f64::from(frame)).ok()??;
            let lens = camera.lens.parameters();
            // A view cannot give the angle of a wide fisheye, and keeps the lens.
            let lens = if lens == self.lens.parameters() || lens.flaw().is_some() {
                LensOverrides::default()
            } else {
                lens
            };
            Some(ViewCamera::of_pose(&camera.pose, lens, self.up(), self.distance()))
        };
        let moved = self.job.moves_camera().then(moved).flatten();
        Some(moved.unwrap_or_else(|| ViewCamera::new(*eye, at)))
    }

    /// The camera of a path at a frame; `None` outside of the path.
    pub fn camera_at(&self, path: Option<&CameraPath>, frame: f64) -> Option<ViewCamera> {
        let state = path?.at(frame).ok()?;
        Some(ViewCamera::of_state(&state, self.up(), self.distance()))
    }

    /// The up direction.
    fn up(&self) -> DVec3 {
        self.home.as_ref().map_or(DVec3::Y, |(_, at)| at.up)
    }

    /// The default distance of a target, in m.
    fn distance(&self) -> f64 {
        let of_home = |(eye, at): &(DVec3, LookAt)| eye.distance(at.target);
        self.home.as_ref().map_or(10.0 * self.step, of_home)
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
