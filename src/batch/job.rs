//! A job from its scene file to its last frame, for the program, other programs and tests.

use std::{path::Path, time::Instant};

use super::{
    CameraRig, Existing, FrameRange, InputHash, Inventory, JobEvent, Observer, Plan, Request, SceneFigures, Stale,
    Summary, Survey,
    products::denoise::{DenoiseObserver, DenoiseRequest, Helpers, denoise},
    products::targets,
    resume::checkpoint,
    resume::job_lock::JobLock,
    run,
};
use crate::{
    accel,
    assets::{
        AssetError, Files, MemoryBudget, MemoryKind, Store,
        model_formats::{self, is_model},
    },
    compile::{
        self, Instancing,
        default_scene::{self, ModelOptions},
    },
    describe::{self, SceneDesc},
    error::Error,
    film::Film,
    render::{Cancel, Control, RenderError, Renderer},
    scene::{Scene, SceneBuildError, SceneBuilder},
};

/// A scene and a request, checked against each other.
pub struct Job {
    store: Store,
    pub desc: SceneDesc,
    pub plan: Plan,
}

impl Job {
    /// Reads the scene at `path`, a scene file or a model, and the camera path, and makes the plan for `request`.
    pub fn open(path: &Path, request: &Request) -> Result<Self, Error> {
        let store = store(request);
        let desc = if is_model(path) {
            let options = ModelOptions {
                overrides: &request.overrides,
                camera: request.camera.as_deref(),
                variant: request.variant.as_deref(),
                light_units: request.light_units.unwrap_or_default(),
                point_radius: request.point_radius,
            };
            default_scene::describe(path, options, &store)?
        } else {
            if request.camera.is_some() {
                return Err(Error::CameraOfSceneFile);
            }
            if request.variant.is_some() {
                return Err(Error::VariantOfSceneFile);
            }
            if request.light_units.is_some() {
                return Err(Error::LightUnitsOfSceneFile);
            }
            if request.point_radius.is_some() {
                return Err(Error::PointRadiusOfSceneFile);
            }
            let read = describe::load(path, &request.overrides, |p| store.files().read(p));
            match read {
                // Nobody looks for the mistake in another program's file.
                Err(describe::Error::Invalid(_) | describe::Error::Encoding { .. })
                    if model_formats::advice(path).is_some() =>
                {
                    let path = path.to_owned();
                    return Err(compile::Error::Assets(vec![AssetError::UnknownModel { path }]).into());
                }
                read => read?,
            }
        };
        let plan = Plan::new(&desc, request, store.files())?;
        Ok(Self { store, desc, plan })
    }

    /// A job of a parsed scene.
    pub fn new(desc: SceneDesc, request: &Request) -> Result<Self, Error> {
        let store = store(request);
        let desc = desc.with(&request.overrides)?;
        let plan = Plan::new(&desc, request, store.files())?;
        Ok(Self { store, desc, plan })
    }

    /// The files that were read so far, with the hashes of their contents.
    pub fn files(&self) -> &Files {
        self.store.files()
    }

    /// The hash of all files that were read so far, which are those of the whole scene once it is loaded.
    pub fn inputs(&self) -> InputHash {
        InputHash::new(&self.store, &self.desc.source, self.plan.camera_path.as_deref())
    }

    /// For each frame, the first file that is not what the job would write, if any; on the threads of the current rayon pool. Call it
    /// after [`Job::load`].
    pub fn stale(&self) -> Vec<Option<Stale>> {
        Survey::new(&self.plan, self.inputs()).stale
    }

    /// The number of missing or broken image files that placeholders replace.
    pub fn placeholders(&self) -> usize {
        self.store.replaced()
    }

    /// Loads all files of the scene and reports all their errors, on the threads of the current rayon pool. Builds no acceleration
    /// structure.
    pub fn load(&self) -> Result<SceneBuilder, Error> {
        let scene = compile::load(&self.desc, &self.store, Instancing::default(), self.plan.first_eye);
        // The scene has its own copy of the models.
        self.store.forget_models();
        Ok(scene?)
    }

    /// The parts of the scene that [`Job::load`] returned.
    pub fn inventory(&self, scene: &SceneBuilder) -> Inventory {
        Inventory::new(scene, &self.store)
    }

    /// Checks whether an acceleration structure can be built for the scene that [`Job::load`] returned.
    pub fn check(&self, scene: &SceneBuilder) -> Result<(), Error> {
        self.check_tree(scene)?;
        Ok(scene.check().map_err(|cause| self.build_error(cause))?)
    }

    /// Loads the scene and builds its acceleration structure.
    pub fn compile(&self) -> Result<Scene, Error> {
        self.build(self.load()?)
    }

    /// Builds the acceleration structure of the scene that [`Job::load`] returned.
    pub fn build(&self, scene: SceneBuilder) -> Result<Scene, Error> {
        self.check_tree(&scene)?;
        let scene = scene
            .build(self.plan.picture.accel)
            .map_err(|cause| self.build_error(cause))?;
        compile::warn_dark_emitters(&scene, self.store.warnings());
        Ok(scene)
    }

    /// Checks whether there is memory for the acceleration structure.
    fn check_tree(&self, scene: &SceneBuilder) -> Result<(), Error> {
        let bytes = accel::build_bytes(scene.geometry());
        let memory = self.store.files().memory();
        memory.check(MemoryKind::Trees, bytes).map_err(|cause| {
            let path = self.desc.source.path.clone();
            compile::Error::Memory { cause, path }.into()
        })
    }

    fn build_error(&self, cause: SceneBuildError) -> compile::Error {
        compile::Error::Build {
            cause,
            path: self.desc.source.path.clone(),
        }
    }

    /// Renders the frame with this index in the plan, and writes nothing.
    ///
    /// # Errors
    /// A pass shows a light group that the scene does not have.
    pub fn render_frame(&self, scene: &Scene, index: usize) -> Result<Film, RenderError> {
        let (plan, frame) = (&self.plan, &self.plan.frames[index]);
        let camera = CameraRig::new(plan, scene).camera(plan, frame);
        plan.render_frame(&Renderer::new(), scene, (frame, &camera), &Control::default())
    }

    /// Finds out, and changes nothing, whether a file that the job writes is one that it has read so far, is written twice, or
    /// exists and is to stay.
    pub fn compare_files(&self) -> Result<(), Error> {
        targets::refuse(&self.plan, self.files())
    }

    /// Renders all frames of `scene`, which [`Job::load`] returned, as [`run`] does. Where the files of all frames are
    /// whole and are to be kept, no acceleration structure is built.
    pub fn run(&self, scene: SceneBuilder, observer: &dyn Observer, control: &Control<'_>) -> Result<Summary, Error> {
        let start = Instant::now();
        targets::check(&self.plan, self.files())?;
        let _lock = JobLock::new(&self.plan, control.cancel)?;
        let frames = &self.plan.frames;
        let survey = match self.plan.policy.existing {
            Existing::Skip => Survey::new(&self.plan, self.inputs()),
            Existing::Overwrite | Existing::Fail => Survey::of_nothing(self.inputs()),
        };
        // Files beside the pictures need the scene.
        let is_bare = self.plan.files.sidecars.is_empty();
        if frames.is_empty() || is_bare && (0..frames.len()).all(|frame| survey.has(frame)) {
            for frame in frames {
                if self.plan.policy.checkpoint.is_some() {
                    checkpoint::remove(frame);
                }
                observer.event(&JobEvent::FrameSkipped { frame: frame.number });
            }
            return Ok(Summary {
                skipped: frames.len(),
                wall: start.elapsed(),
                scene: SceneFigures::new(scene.geometry(), None),
                ..Summary::default()
            });
        }
        let scene = self.build(scene)?;
        let plan = self.plan.metered(&scene, control.cancel)?;
        let summary = run(&plan, &scene, &survey, observer, control)?;
        Ok(Summary {
            scene: SceneFigures::new(
                scene.geometry.accel.geometry(),
                Some(scene.geometry.accel.stats().build_time),
            ),
            ..summary
        })
    }

    /// Denoises the rendered frames of the plan, using these neighbouring frames; does nothing if the job does not denoise.
    ///
    /// # Errors
    /// Those of [`denoise`].
    pub fn denoise(
        &self,
        helpers: &Helpers,
        observer: &dyn DenoiseObserver,
        cancel: Option<&Cancel>,
    ) -> Result<(), Error> {
        let Some(plan) = &self.plan.files.denoise else {
            return Ok(());
        };
        if self.plan.frames.is_empty() {
            return Ok(());
        }
        targets::compare(&self.plan, self.files())?;
        let numbers = self.plan.frames.iter().map(|frame| i64::from(frame.number));
        for (input, output) in &plan.files {
            let request = DenoiseRequest {
                input: input.clone(),
                output: output.clone(),
                frames: Some(FrameRange::of(numbers.clone())),
                helpers: helpers.clone(),
                options: plan.options.clone(),
                skip_existing: self.plan.policy.existing == Existing::Skip,
                simd: self.plan.picture.accel.simd,
            };
            denoise(&request, observer, cancel)?;
        }
        Ok(())
    }
}

fn store(request: &Request) -> Store {
    let memory = MemoryBudget::new(request.max_memory);
    let files = Files::new(request.allow_outside, memory).with_warnings(request.warnings.clone());
    Store::new(request.missing_assets, files)
        .strict(request.strict)
        .texture_memory(request.texture_memory)
}
