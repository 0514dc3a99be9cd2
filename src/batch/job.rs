//! A job from its scene file to its last frame, for the program, other programs and tests.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, OnceLock},
    time::Instant,
};

use super::{
    CameraRig, Existing, InputHash, Inventory, JobEvent, Observer, Plan, PlannedFrame, Request, SceneFigures, Scenes,
    Stale, Summary, Survey,
    frame_scenes::{Failed, ScenesOfFrame},
    plan::{
        cameras::OwnCamera,
        fit::fitted,
        frame_rate::fps,
        path_size::sized,
        values::{of_parts, tables},
        view_cameras::view_bounds,
    },
    products::{denoise, denoised, sidecars, targets},
    resume::checkpoint,
    resume::job_lock::JobLock,
    run,
    scenes::{SceneSource, description_at, load_options, rebuilds},
};
use crate::{
    accel,
    assets::{
        AssetError, Files, MemoryBudget, MemoryKind, Store,
        camera_path::files_of,
        model_formats::{self, is_model},
    },
    camera::{FilmSize, FrameCamera, SceneCamera},
    compile::{
        self, LoadOptions, SceneMotion,
        default_scene::{self, ModelOptions, ModelRun},
    },
    describe::{self, SceneDesc, ValueSource, Values},
    error::Error,
    film::Film,
    output::png::data::MOST_IDS,
    render::{Control, Renderer},
    scene::{Scene, SceneBuildError, SceneBuilder},
};

mod words;

/// A scene and a request, checked against each other.
pub struct Job {
    store: Store,
    pub desc: SceneDesc,
    pub plan: Plan,
    /// The hash of the files of the whole scene, once it is loaded.
    inputs: OnceLock<InputHash>,
    /// The motion of the models of the scene, once it is loaded.
    motion: OnceLock<Arc<SceneMotion>>,
    /// The description and the values of the first frame, if the scene was loaded with these.
    first: OnceLock<(SceneDesc, Vec<String>)>,
}

impl Job {
    /// Reads the scene at `path`, a scene file or a model, and the camera path, and makes the plan for `request`.
    pub fn open(path: &Path, request: &Request) -> Result<Self, Error> {
        let store = store(request);
        if is_model(path) {
            let tables = of_parts(tables(Err(path), request, store.files())?, path, &store)?;
            let options = ModelOptions {
                overrides: &request.overrides,
                tables: &tables,
                fps: fps(request),
                camera: request.camera.as_deref(),
                variant: request.variant.as_deref(),
                light_units: request.light_units.unwrap_or_default(),
                animation: request.animation.as_ref(),
                point_radius: request.point_radius,
                ground: request.ground,
                normalise: request.normalise,
            };
            if request.normalise.is_some()
                && let Some(name) = mover(request, &tables)
            {
                return Err(Error::NormaliseMoved { name });
            }
            let (desc, run) = default_scene::describe(path, options, &store).map_err(|error| match error {
                // Flags made the choice.
                compile::Error::Assets(errors) if errors.iter().any(AssetError::is_choice) => {
                    Error::Usage(errors.to_string())
                }
                error => error.into(),
            })?;
            return Self::planned(store, desc, request, (&tables, run));
        }
        let desc = {
            if request.camera.is_some() {
                return Err(Error::CameraOfSceneFile);
            }
            if request.variant.is_some() {
                return Err(Error::VariantOfSceneFile);
            }
            if request.animation.is_some() {
                return Err(Error::AnimationOfSceneFile);
            }
            if request.light_units.is_some() {
                return Err(Error::LightUnitsOfSceneFile);
            }
            if request.point_radius.is_some() {
                return Err(Error::PointRadiusOfSceneFile);
            }
            if request.ground {
                return Err(Error::GroundOfSceneFile);
            }
            if request.normalise.is_some() {
                return Err(Error::NormaliseOfSceneFile);
            }
            let read = describe::load(path, &request.overrides, |p| store.files().read(p));
            match read {
                // A file with the ending of another program is refused as such, with advice, and not for its syntax.
                Err(describe::Error::Invalid(_) | describe::Error::Encoding { .. })
                    if model_formats::advice(path).is_some() =>
                {
                    let path = path.to_owned();
                    return Err(compile::Error::from(AssetError::UnknownModel { path }).into());
                }
                read => read?,
            }
        };
        Self::of_scene(store, desc, request)
    }

    /// A job of a parsed scene.
    pub fn new(desc: SceneDesc, request: &Request) -> Result<Self, Error> {
        let store = store(request);
        Self::of_scene(store, desc.with(&request.overrides)?, request)
    }

    fn of_scene(store: Store, desc: SceneDesc, request: &Request) -> Result<Self, Error> {
        let tables = tables(Ok(&desc), request, store.files())?;
        Self::planned(store, desc, request, (&tables, None))
    }

    /// The job of a description with these tables and the motion of a model by itself.
    fn planned(
        store: Store,
        desc: SceneDesc,
        request: &Request,
        (tables, run): (&[ValueSource], Option<ModelRun>),
    ) -> Result<Self, Error> {
        let desc = sized(desc, request, store.files())?;
        let moves = run.as_ref().is_some_and(ModelRun::moves_camera);
        let desc = match request.frame_to_fit {
            true => fitted(desc, request, &store, (tables, moves))?,
            false => desc,
        };
        let bounds = request
            .views
            .as_ref()
            .map(|_| view_bounds(&desc, &store, (tables, fps(request))));
        let loaded = (tables, run.map(Arc::new), bounds.transpose()?);
        let plan = Plan::of_loaded(&desc, request, store.files(), loaded)?;
        Ok(Self {
            store,
            desc,
            plan,
            inputs: OnceLock::new(),
            motion: OnceLock::new(),
            first: OnceLock::new(),
        })
    }

    /// The files that were read so far, with the hashes of their contents.
    pub fn files(&self) -> &Files {
        self.store.files()
    }

    /// The hash of all files that were read so far, which are those of the whole scene once it is loaded.
    pub fn inputs(&self) -> InputHash {
        let now = || {
            let tables = self.plan.values.iter().flat_map(|values| values.paths());
            let of_path = self.plan.camera_path.iter().flat_map(|path| files_of(path));
            let apart: Vec<PathBuf> = of_path.chain(tables.map(Path::to_owned)).collect();
            let apart: Vec<&Path> = apart.iter().map(PathBuf::as_path).collect();
            InputHash::new(&self.store, &self.desc.source, &apart)
        };
        self.inputs.get().copied().unwrap_or_else(now)
    }

    /// For each of these frames, the first file that is not what the job would write, if any; on the threads of the current rayon
    /// pool. Call it after [`Job::load`].
    ///
    /// # Errors
    /// The folder of the rendered files, or the filter, of a job that denoises cannot be read.
    pub fn stale(&self, frames: &[PlannedFrame]) -> Result<Vec<Option<Stale>>, Error> {
        let inputs = self.inputs();
        let rendered = Survey::new(&self.plan, frames, inputs).stale;
        denoised::stale((&self.plan, inputs), frames, rendered)
    }

    /// The number of missing or broken image files that placeholders replace.
    pub fn placeholders(&self) -> usize {
        self.store.replaced()
    }

    /// Loads all files of the scene and reports all their errors, on the threads of the current rayon pool. Builds no acceleration
    /// structure.
    pub fn load(&self) -> Result<SceneBuilder, Error> {
        let time = self.plan.first_frame / self.plan.fps;
        let values = self.plan.values.as_deref();
        let options = load_options(values, self.plan.first_eye, time);
        let first = description_at(&self.desc, values, self.plan.first_frame);
        let loaded = match first.and_then(|first| Some((self.load_first(&first.0, &options)?, first))) {
            Some((loaded, first)) => {
                let _ = self.first.set(first);
                Ok(loaded)
            }
            None => compile::load_moving(&self.desc, &self.store, &options),
        };
        // The scene has its own copy of the models.
        let is_played = loaded.as_ref().is_ok_and(|(_, motion)| !motion.is_still());
        if !is_played && !self.plan.values.as_deref().is_some_and(rebuilds) {
            self.store.forget_models();
        }
        let (scene, motion) = loaded?;
        if let Some(values) = self.plan.values.as_deref() {
            let problem = |object, part, name: &str, span| motion.part_problem(object, part, name, span);
            values
                .check_parts(&self.desc, problem)
                .map_err(compile::Error::Invalid)?;
        }
        let _ = self.motion.set(Arc::new(motion));
        self.check_words()?;
        // Frames may load other files of these later.
        let inputs = self.inputs();
        let _ = self.inputs.set(inputs);
        Ok(scene)
    }

    /// Loads the scene with the values of the first frame, around the origin that suits the scene of the file; `None` if that has
    /// no such scene, or if it has faults.
    fn load_first(&self, first: &SceneDesc, options: &LoadOptions) -> Option<(SceneBuilder, SceneMotion)> {
        let origin = compile::origin(&self.desc, &self.store, options).ok()?;
        let options = LoadOptions {
            origin: Some(origin),
            ..options.clone()
        };
        compile::load_moving(first, &self.store, &options).ok()
    }

    /// The scenes of the frames, made of that which [`Job::build`] returned.
    pub fn scenes(&self, scene: impl Into<Arc<Scene>>) -> Scenes<'_> {
        let source = SceneSource {
            desc: &self.desc,
            first: self.first.get(),
            store: &self.store,
            accel: self.plan.picture.accel,
            motion: self.motion.get().cloned().unwrap_or_default(),
            fps: self.plan.fps,
        };
        Scenes::moving(scene.into(), source, self.plan.values.as_deref())
    }

    /// Whether frames have different scenes, once the scene is loaded.
    pub fn moves(&self) -> bool {
        self.plan.values.is_some() || self.motion.get().is_some_and(|motion| !motion.is_still())
    }

    /// Whether values or animations move the scene's own camera.
    pub fn moves_camera(&self) -> bool {
        let by_values = |values: &Arc<Values>| values.of_camera().next().is_some();
        let by_run = |run: &Arc<ModelRun>| run.moves_camera();
        self.plan.values.as_ref().is_some_and(by_values) || self.plan.run.as_ref().is_some_and(by_run)
    }

    /// The scene's own camera at a time in frames, if it has one.
    ///
    /// # Errors
    /// Its values at this time are wrong.
    pub fn camera(&self, frame: f64) -> Result<Option<SceneCamera>, Error> {
        self.own_camera().at(frame)
    }

    /// The scene's own camera of a frame.
    ///
    /// # Errors
    /// The scene has no camera, or its values are wrong.
    pub fn frame_camera(&self, frame: i32, film: FilmSize) -> Result<FrameCamera, Error> {
        self.own_camera().frame_camera(f64::from(frame), film)
    }

    fn own_camera(&self) -> OwnCamera<'_> {
        let plan = &self.plan;
        let moving = (plan.values.as_deref(), plan.run.as_deref(), plan.fps);
        OwnCamera::new(&self.desc, moving, plan.picture.camera)
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
        if self.plan.files.has_png_ids && scene.mattes().parts().len() > MOST_IDS {
            let count = scene.mattes().parts().len();
            return Err(Error::Usage(format!(
                "--png-ids: the scene has {count} objects and nodes, and PNG files hold numbers up to {MOST_IDS}: use --aovs objectId"
            )));
        }
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
    /// The frame was cancelled, there is no scene at one of its times, or a pass shows a light group that the scene does not have.
    pub fn render_frame(&self, scenes: &mut Scenes<'_>, index: usize, control: &Control<'_>) -> Result<Film, Error> {
        let (plan, frame) = (&self.plan, &self.plan.frames[index]);
        let scene = match plan.picture.turntable {
            Some(_) => scenes.seek(plan.first_frame)?,
            None => scenes.current(),
        };
        let camera = CameraRig::new(plan, scene).camera(plan, frame);
        let mut of_frame = ScenesOfFrame {
            scenes,
            number: frame.number,
            camera: &camera,
        };
        let film = plan.render_frame(&Renderer::new(), &mut of_frame, (frame, &camera), control);
        film.map_err(|failed| match failed {
            Failed::Render(error) => error.into(),
            Failed::Scene(error) => error,
        })
    }

    /// Finds out, and changes nothing, whether a file that the job writes is one that it has read so far, is written twice, or
    /// exists and is to stay, and whether its filter can be loaded.
    pub fn compare_files(&self) -> Result<(), Error> {
        self.check_files()?;
        if let Some(denoise) = self.plan.denoises() {
            denoise::load(&denoise.options.filter)?;
        }
        Ok(())
    }

    /// Finds out the same, but for the filter.
    pub fn check_files(&self) -> Result<(), Error> {
        targets::refuse(&self.plan, self.files())
    }

    /// Renders all frames of `scene`, which [`Job::load`] returned, as [`run()`] does, and denoises them if the plan says so. Where
    /// the rendered files of all frames are whole and are to be kept, no acceleration structure is built.
    pub fn run(&self, scene: SceneBuilder, observer: &dyn Observer, control: &Control<'_>) -> Result<Summary, Error> {
        let start = Instant::now();
        self.compare_files()?;
        targets::check(&self.plan)?;
        let _lock = JobLock::new(&self.plan, control.cancel)?;
        // Another job may have written them meanwhile.
        self.check_files()?;
        sidecars::check(&self.plan)?;
        let coverage = self.plan.coverage_of_all(scene.background());
        let (plan, mut summary) = self.render(scene, observer, control)?;
        denoised::write((&plan, self.inputs(), coverage), &mut summary, observer, control.cancel)?;
        summary.wall = start.elapsed();
        Ok(summary)
    }

    /// Renders the frames. Returns the plan with the exposure that suits the scene.
    fn render(
        &self,
        scene: SceneBuilder,
        observer: &dyn Observer,
        control: &Control<'_>,
    ) -> Result<(Plan, Summary), Error> {
        let plan = &self.plan;
        let survey = match plan.policy.existing {
            Existing::Skip => Survey::new(plan, &plan.frames, self.inputs()),
            Existing::Overwrite | Existing::Fail => Survey::of_nothing(self.inputs()),
        };
        let is_there = |frame| !plan.renders() || survey.has(frame);
        // Files beside the pictures, and the exposure of denoised ones, need the scene.
        let needs_scene = plan.renders() && !plan.files.sidecars.is_empty()
            || plan.denoises().is_some() && plan.picture.metering_camera.is_some();
        if plan.frames.is_empty() || !needs_scene && (0..plan.frames.len()).all(is_there) {
            let is_final = plan.denoises().is_none();
            for frame in &plan.frames {
                if plan.policy.checkpoint.is_some() && plan.renders() {
                    checkpoint::remove(frame);
                }
                if is_final {
                    observer.event(&JobEvent::FrameSkipped { frame: frame.number });
                }
            }
            let summary = Summary {
                skipped: if is_final { plan.frames.len() } else { 0 },
                scene: SceneFigures::new(scene.geometry(), None),
                ..Summary::default()
            };
            return Ok((plan.clone(), summary));
        }
        let mut scenes = self.scenes(self.build(scene)?);
        let plan = plan.metered(scenes.seek(plan.first_frame)?, control.cancel)?;
        let summary = match plan.renders() {
            true => run(&plan, &mut scenes, &survey, observer, control)?,
            false => Summary::default(),
        };
        let geometry = &scenes.current().geometry.accel;
        let figures = SceneFigures::new(geometry.geometry(), Some(geometry.stats().build_time));
        let summary = Summary {
            scene: figures,
            ..summary
        };
        Ok((plan, summary))
    }
}

/// The value of overrides or tables that moves the object of a model by itself, if there is one.
fn mover(request: &Request, tables: &[ValueSource]) -> Option<String> {
    let is_place = |name: &String| {
        let keys: Vec<&str> = name.split('.').collect();
        let mut inner = keys.iter().skip(2);
        let inner = inner.find(|key| ["transform", "node"].contains(key));
        keys[0] == "transform" || keys[0] == "object" && inner == Some(&"transform")
    };
    let paths = request.overrides.paths().map(|(_, path)| path.join("."));
    let names = tables.iter().flat_map(ValueSource::names).map(str::to_owned);
    paths.chain(names).find(is_place)
}

fn store(request: &Request) -> Store {
    let memory = MemoryBudget::new(request.max_memory);
    let files = Files::new(request.allow_outside, memory)
        .with_warnings(request.warnings.clone())
        .with_supplied(request.supplied.clone());
    Store::new(request.missing_assets, files)
        .strict(request.strict)
        .texture_memory(request.texture_memory)
}
