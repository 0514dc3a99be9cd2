//! The plan of a job: its frames, their cameras and their files.

pub(super) mod cameras;
pub(super) mod denoise_options;
pub(super) mod encoding;
pub(super) mod existing;
pub(super) mod fit;
pub(super) mod frame_rate;
pub(super) mod if_busy;
pub(super) mod memory;
pub(super) mod metering;
pub(super) mod part;
pub(super) mod passes;
mod path_columns;
pub(super) mod path_size;
pub(super) mod patterns;
pub(super) mod picture;
pub mod range;
pub(super) mod request;
pub(super) mod rig;
mod sample_ranges;
pub(super) mod time_limit;
pub(super) mod turntable;
pub(super) mod two_eyes;
pub(super) mod values;
pub(super) mod view_cameras;
pub(super) mod views;

use std::{ops::RangeInclusive, path::PathBuf, sync::Arc};

use super::{
    Policy, Request,
    products::{
        coco::categories::CategoryKind,
        draws,
        metadata::{self, Sidecar},
    },
};
use crate::{
    assets::Files,
    camera::FrameCamera,
    compile::{
        self,
        default_scene::{ModelRun, normalise::ModelPlace},
    },
    describe::{FrameTime, SceneDesc, ValueSource, Values},
    error::Error,
    film::Film,
    math::{DAabb, DVec3},
    output::{self, Attribute, Coverage, Encoding, FilePattern, Format, FrameMetadata, LightType},
    render::{self, Content, Control, FrameScenes, Renderer},
    scene::Background,
    value::Exposure,
    warnings::Warnings,
};
use cameras::{JobCameras, cameras};
use denoise_options::{DenoisePlan, DenoiseSteps};
use frame_rate::fps;
use memory::KeptSums;
use patterns::Patterns;
use picture::PicturePlan;

/// A file to be written.
#[derive(Clone, Debug)]
pub struct PlannedFile {
    pub path: PathBuf,
    pub format: &'static dyn Format,
}

/// A frame to be rendered.
#[derive(Clone, Debug)]
pub struct PlannedFrame {
    pub number: i32,
    /// The frame's camera; for a turntable the start of the orbit.
    pub camera: FrameCamera,
    /// That of the second eye, where the picture shows both.
    pub second: Option<FrameCamera>,
    pub files: Vec<PlannedFile>,
}

/// Everything a job is going to do, decided and checked.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The frames that this job renders.
    pub frames: Vec<PlannedFrame>,
    /// The frames of all parts, where this job renders one of them.
    whole: Option<Vec<PlannedFrame>>,
    /// Frames that other jobs render, and that help to denoise those of this job.
    pub beside: Vec<PlannedFrame>,
    /// The frames that the job has without a range (`--range`). Where the scene moves, a range may go beyond them.
    pub extent: RangeInclusive<i64>,
    /// Whether other jobs render other frames of the sequence (`--range`, `--part`), whose files beside the pictures this job
    /// joins.
    pub is_chunk: bool,
    /// The first frame, whichever frames are rendered.
    pub first_frame: f64,
    /// The frames of a second of animations.
    pub fps: f64,
    /// The first position of the camera, whichever frames are rendered, in m.
    pub first_eye: Option<DVec3>,
    /// The file that the cameras come from.
    pub camera_path: Option<PathBuf>,
    /// The values of the scene that change over time.
    pub values: Option<Arc<Values>>,
    /// Whether models play animations.
    plays: bool,
    /// Whether every point of the picture has a camera ray, in all frames of the sequence, whichever are rendered.
    pub fills_film: bool,
    /// The place of a model by itself, if it is moved to have a common size.
    pub(super) model_place: Option<ModelPlace>,
    /// The run of a model by itself.
    pub(super) run: Option<Arc<ModelRun>>,
    pub picture: PicturePlan,
    pub files: FilePlan,
    pub policy: Policy,
    /// The sink of the job's warnings.
    pub warnings: Warnings,
}

/// The files of a job, their encoding, and the files beside its pictures.
#[derive(Clone, Debug)]
pub struct FilePlan {
    pub encoding: Encoding,
    /// The pattern of the pictures that the files beside them describe.
    pub picture: Option<FilePattern>,
    /// The files beside the pictures.
    pub sidecars: Vec<Sidecar>,
    /// What the categories of `coco.json` are named after.
    pub categories: CategoryKind,
    /// The file of the scene.
    pub scene: PathBuf,
    /// Whether the job renders a part of its frames or of their pixels, and keeps the labels of other pictures.
    pub keeps_labels: bool,
    /// The eye that their names have.
    pub eye: Option<&'static str>,
    /// A pattern with `{eye}`, where there is no eye: such a job has no files.
    pub lacks_eye: Option<String>,
    /// Files that the caller writes beside those.
    pub files_of_caller: Vec<PathBuf>,
    /// The denoising of the frames, if any.
    pub denoise: Option<DenoisePlan>,
    /// Whether other files than EXR files hold passes.
    pub has_arrays: bool,
    /// Whether PNG files hold the numbers of objects, of which they have 16 bits.
    pub has_png_ids: bool,
}

impl Plan {
    /// Decides what `request` means for the scene `desc`, which has its overrides, and reads the camera path by way of `inputs`.
    pub fn new(desc: &SceneDesc, request: &Request, inputs: &Files) -> Result<Self, Error> {
        let desc = &path_size::sized(desc.clone(), request, inputs)?;
        let tables = values::tables(Ok(desc), request, inputs)?;
        Self::of_loaded(desc, request, inputs, (&tables, None, None))
    }

    /// Does the same with these tables, the motion of a model by itself, and the bounds of what is visible, which views need.
    pub(super) fn of_loaded(
        desc: &SceneDesc,
        request: &Request,
        inputs: &Files,
        (tables, run, bounds): (&[ValueSource], Option<Arc<ModelRun>>, Option<DAabb>),
    ) -> Result<Self, Error> {
        two_eyes::check(request)?;
        let request = &*values::independent(request, tables);
        let patterns = Patterns::new(desc, request)?;
        let mut picture = PicturePlan::new(desc, request, &patterns.formats())?;
        let files = FilePlan::new(desc, request, &picture, &patterns)?;
        let values = values::values(desc, tables)?;
        let chooses = |path: &[String]| path.iter().any(|key| key == "animation");
        let plays =
            compile::plays_animations(desc) || values.iter().any(|values| values.keys().any(|(_, path)| chooses(path)));
        let moves = plays || values.iter().any(|values| values.moves_objects());
        picture.add_for_denoisers(moves, desc.has_catchers());
        let sums = KeptSums {
            moves: values.is_some() || plays,
            copies: request.policy.checkpoint.is_some() || request.policy.keep_sums || request.sample_ranges.is_some(),
        };
        memory::take(desc, &picture, sums, inputs.memory())?;
        let JobCameras {
            frames,
            seconds,
            beside,
            extent,
            first_frame,
            first_eye,
            metering,
            fills_film,
            ..
        } = cameras(
            desc,
            request,
            (values.as_deref(), run.as_deref()),
            (picture.camera, picture.settings.resolution, bounds),
            inputs,
        )?;
        let planned = |(number, camera)| PlannedFrame {
            number,
            camera,
            second: None,
            files: planned_files(&patterns.rendered, number),
        };
        let mut frames: Vec<PlannedFrame> = frames.into_iter().map(planned).collect();
        for (frame, second) in frames.iter_mut().zip(seconds) {
            frame.second = Some(second);
        }
        let mut beside: Vec<PlannedFrame> = beside.into_iter().map(planned).collect();
        if let Some(frame) = frames.first() {
            cameras::warn_of_missing_part(&frame.camera, picture.settings.resolution, &request.warnings);
        }
        metadata::check(&files.sidecars, frames.iter().map(|frame| &frame.camera))?;
        let numbers: Vec<i32> = frames.iter().map(|f| f.number).collect();
        let all: Vec<FilePattern> = patterns.all().cloned().collect();
        output::sequence::check_distinct(&all, &numbers)?;
        let (frames, whole) = match request.part {
            Some(part) => (part.choose(frames.clone()), Some(frames)),
            None => (frames, None),
        };
        if let (Some(whole), Some(options)) = (&whole, request.denoising()) {
            let reach = i32::try_from(options.temporal).unwrap_or(i32::MAX);
            let is_near = |number: i32, reach: i32| {
                let next = frames.partition_point(|frame| frame.number < number.saturating_sub(reach));
                let next = frames.get(next);
                next.is_some_and(|frame| frame.number <= number.saturating_add(reach))
            };
            beside.extend(whole.iter().filter(|frame| !is_near(frame.number, 0)).cloned());
            beside.retain(|frame| is_near(frame.number, reach));
        }
        picture.metering_camera = metering.filter(|_| desc.output.exposure == Exposure::Auto);
        Ok(Self {
            frames,
            whole,
            beside,
            extent,
            is_chunk: request.range.is_some() || request.part.is_some(),
            first_frame,
            fps: fps(request),
            first_eye,
            camera_path: request.camera_path.clone(),
            values,
            plays,
            fills_film,
            model_place: request.normalise.and_then(|_| ModelPlace::of(desc)),
            run,
            picture,
            files,
            policy: request.policy,
            warnings: request.warnings.clone(),
        })
    }

    /// Renders one frame, and writes nothing.
    ///
    /// # Errors
    /// The frame was cancelled, or a pass shows a light group that the scene does not have.
    pub fn render_frame<S: FrameScenes>(
        &self,
        renderer: &Renderer,
        scenes: &mut S,
        (frame, camera): (&PlannedFrame, &FrameCamera),
        control: &Control<'_>,
    ) -> Result<Film, S::Error> {
        let settings = render::Settings {
            noise_frame: self.picture.seed_mode.frame(frame.number),
            ..self.picture.settings.clone()
        };
        renderer.render_moving(scenes, camera, self.picture.integrator.as_dyn(), &settings, control)
    }

    /// The names of the values of the scene and what they are at a time, in TOML, with the time of animations; `None` where no
    /// value changes over time and no animation is played.
    pub fn moment(&self, time: impl Into<FrameTime>) -> Option<Vec<(&str, String)>> {
        let at = time.into();
        let values = self.values.iter().flat_map(|values| values.named_at(at));
        let time = self.plays.then(|| ("time", (at.time / self.fps).to_string()));
        (self.values.is_some() || self.plays).then(|| values.chain(time).collect())
    }

    /// Whether the job renders its frames, and does not only denoise them.
    pub fn renders(&self) -> bool {
        let denoise = self.files.denoise.as_ref();
        denoise.is_none_or(|denoise| denoise.steps != DenoiseSteps::Denoise)
    }

    /// Whether the sums of finished frames are kept.
    pub fn keeps_sums(&self) -> bool {
        let ranges = self.picture.settings.ranges;
        self.policy.keep_sums || ranges.is_some_and(|ranges| ranges.only.is_some())
    }

    /// The denoising that the job does, if any.
    pub fn denoises(&self) -> Option<&DenoisePlan> {
        let denoise = self.files.denoise.as_ref();
        denoise.filter(|denoise| denoise.steps != DenoiseSteps::Render)
    }

    /// The files that the job leaves of a frame.
    pub fn final_files(&self, frame: &PlannedFrame) -> Vec<PlannedFile> {
        match self.denoises() {
            Some(denoise) => planned_files(&denoise.clean, frame.number),
            None => frame.files.clone(),
        }
    }

    /// The frames of all parts of the job.
    pub fn all_frames(&self) -> &[PlannedFrame] {
        self.whole.as_deref().unwrap_or(&self.frames)
    }

    /// The path of a file beside the pictures; `None` where there are none.
    pub(super) fn sidecar_path(&self, sidecar: Sidecar) -> Option<PathBuf> {
        let first = self.all_frames().first()?;
        Some(sidecar.path(&self.files.picture.as_ref()?.path(first.number), self.files.eye))
    }

    /// The coverage of pictures by this plan. `fills_film` tells whether every point of the picture has a camera ray, in all
    /// frames.
    pub fn coverage(&self, background: &Background, fills_film: bool) -> Coverage {
        let fills_picture = background.visible && fills_film && self.picture.settings.content == Content::Light;
        if fills_picture || self.picture.is_beyond_alpha {
            Coverage::Full
        } else {
            Coverage::Partial
        }
    }

    /// The coverage of the pictures of all frames of the sequence, with the background of the scene file.
    pub(super) fn coverage_of_all(&self, background: &Background) -> Coverage {
        let hides = self.values.as_ref().is_some_and(|values| values.hides_background());
        self.coverage(background, self.fills_film && !hides)
    }

    /// The metadata of a frame's files, but for their fingerprint.
    pub fn metadata(&self, frame: i32) -> FrameMetadata {
        let mut metadata = FrameMetadata {
            working_space: self.picture.working_space,
            view: self.picture.view,
            exposure: self.picture.exposure,
            fps: self.picture.fps,
            ..FrameMetadata::new(frame, &self.picture.settings, self.picture.integrator.as_dyn())
        };
        let scene = Attribute::new("batch-render/scene", self.picture.scene.as_str());
        metadata.attributes.push(scene);
        let drawn = self.drawn_at(frame);
        metadata
            .attributes
            .extend(drawn.map(|drawn| Attribute::new(draws::VALUES, drawn)));
        metadata
    }

    /// The values that are drawn at random for a frame, as JSON; `None` where none are.
    pub fn drawn_at(&self, frame: i32) -> Option<String> {
        draws::text(self.values.as_deref(), frame)
    }
}

impl FilePlan {
    fn new(desc: &SceneDesc, request: &Request, picture: &PicturePlan, patterns: &Patterns) -> Result<Self, Error> {
        let Patterns { rendered, denoised, .. } = patterns;
        let formats = patterns.formats();
        let [width, height] = picture.size();
        let mut all = patterns.all().map(FilePattern::format).chain(formats.iter().copied());
        if let Some(format) = all.find(|format| width.max(height) > format.largest_side()) {
            let (name, most) = (format.name(), format.largest_side());
            let message = format!("a {name} file has at most {most} columns and rows, not {width}x{height}");
            return Err(Error::Usage(message));
        }
        let mut encoding = encoding::of(&desc.output, request.png_depth_unit, &picture.settings.passes, &formats)?;
        if patterns.has_arrays() && request.denoise.is_some() {
            // The arrays are made of the rendered EXR files.
            encoding.light = LightType::Float;
        }
        Ok(Self {
            encoding,
            picture: patterns.picture().cloned(),
            sidecars: Sidecar::with_sources(&request.metadata),
            categories: request.categories,
            scene: desc.source.path.clone(),
            keeps_labels: request.range.is_some() || request.part.is_some() || request.crop.is_some(),
            eye: patterns.eye,
            lacks_eye: patterns.lacks_eye.clone(),
            has_arrays: patterns.has_arrays(),
            has_png_ids: request.png_ids.is_some(),
            files_of_caller: request.files_of_caller.clone(),
            denoise: request.denoising().map(|options| DenoisePlan {
                options,
                steps: request.denoise_steps,
                noisy: rendered[0].clone(),
                clean: denoised.clone(),
            }),
        })
    }
}

fn planned_files(patterns: &[FilePattern], frame: i32) -> Vec<PlannedFile> {
    patterns
        .iter()
        .map(|p| PlannedFile {
            path: p.path(frame),
            format: p.format(),
        })
        .collect()
}
