//! The plan of a job: its frames, their cameras and their files.

use std::{
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

use super::{
    FrameRange, Policy, Request, Turntable,
    denoise_options::DenoisePlan,
    encoding, frame_rate, memory,
    metadata::{self, Sidecar},
    metering, names,
    passes::PassChoice,
    patterns::Patterns,
    range::MAX_FRAMES,
    samples,
};
use crate::{
    accel::BuildOptions,
    assets::{Files, camera_path},
    camera::{Camera, FrameCamera, Lens, SceneCamera, path::CameraPath},
    describe::{Diagnostics, SceneDesc},
    error::Error,
    film::{Film, Window, coverage::DEFAULT_RANKS},
    integrator::{BuiltIn, IntegratorDesc},
    math::{DVec3, WorkingSpace},
    output::{self, Attribute, Coverage, DisplayTransform, Encoding, FilePattern, Format, FrameMetadata, Shown},
    render::{self, Content, Control, RenderError, Renderer, SampleBudget},
    sampler::{Sampler, SeedMode},
    scene::Scene,
    shape::mesh::LightUnits,
    value::{Exposure, Problem, UnknownName},
    warnings::Warnings,
};

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
    pub files: Vec<PlannedFile>,
}

/// Everything a job is going to do, decided and checked.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The frames that this job renders.
    pub frames: Vec<PlannedFrame>,
    /// The frames of all parts, where this job renders one of them.
    whole: Option<Vec<PlannedFrame>>,
    /// Whether other jobs render other frames of the sequence (`--range`, `--part`), whose files beside the pictures this job
    /// joins.
    pub is_chunk: bool,
    /// The first position of the camera, whichever frames are rendered, in m.
    pub first_eye: Option<DVec3>,
    /// The file that the cameras come from.
    pub camera_path: Option<PathBuf>,
    pub picture: PicturePlan,
    pub files: FilePlan,
    pub policy: Policy,
    /// Where the job's warnings go.
    pub warnings: Warnings,
}

/// What all frames show.
#[derive(Clone, Debug)]
pub struct PicturePlan {
    /// The name of the scene's file.
    pub scene: String,
    /// The radius in m of the points of a model that is the scene, the variant of its materials, and the unit of its lights.
    pub model: (Option<f32>, Option<String>, Option<LightUnits>),
    /// Moves the camera once the scene is known.
    pub turntable: Option<Turntable>,
    /// Frames per second, as a fraction.
    pub fps: Option<(i32, u32)>,
    pub accel: BuildOptions,
    pub integrator: BuiltIn,
    /// The settings of every frame, but for its number.
    pub settings: render::Settings,
    pub seed_mode: SeedMode,
    /// The primaries of the light.
    pub working_space: WorkingSpace,
    /// The planes of each film that go into its files.
    pub shown: Shown,
    pub view: DisplayTransform,
    /// The exposure of pictures, in stops; 0 until the scene is metered, if that decides.
    pub exposure: f32,
    /// The camera of the picture that decides about the exposure, where one does.
    pub metering_camera: Option<FrameCamera>,
}

/// How the files of a job are written, and those beside its pictures.
#[derive(Clone, Debug)]
pub struct FilePlan {
    pub encoding: Encoding,
    /// The pattern of the pictures that the files beside them describe.
    pub picture: Option<FilePattern>,
    /// The files beside the pictures.
    pub sidecars: Vec<Sidecar>,
    /// Files that the caller writes beside those.
    pub files_of_caller: Vec<PathBuf>,
    /// The denoising of the frames, if any.
    pub denoise: Option<DenoisePlan>,
}

impl Plan {
    /// Decides what `request` means for the scene `desc`, and reads the camera path by way of `inputs`.
    pub fn new(desc: &SceneDesc, request: &Request, inputs: &Files) -> Result<Self, Error> {
        let mut settings = settings(desc, request)?;
        let sidecars: Result<Vec<Sidecar>, UnknownName> = request.metadata.iter().map(|name| name.parse()).collect();
        let sidecars = sidecars.map_err(|unknown| Error::Usage(format!("--metadata: {unknown}")))?;
        let patterns = Patterns::new(desc, request)?;
        let picture = patterns.picture().cloned();
        let Patterns {
            rendered: patterns,
            denoised,
        } = patterns;
        let mut problems = Vec::new();
        let mut keep = |p: Problem| problems.push(p);
        let described = integrator(desc, request)?;
        let mut integrator = described.compile().map_err(&mut keep).ok();
        if let Some(BuiltIn::Whitted(whitted)) = &mut integrator {
            whitted.ambient = desc.render.working_space.from_rec709(whitted.ambient);
        }
        let camera = match desc.camera.as_ref().map(|c| c.get_ref().compile()) {
            None => None,
            Some(Ok(camera)) => Some(camera),
            Some(Err(several)) => {
                several.into_iter().for_each(&mut keep);
                None
            }
        };
        let view = names::choose("--view", (&request.view, &desc.output.view));
        let view = view?.map_err(&mut keep).ok();
        let encoding = encoding::choose(desc, request, &mut keep)?;
        let choice = match PassChoice::of_request(request, &patterns)? {
            Some(choice) => Ok(choice),
            None => PassChoice::of_scene(desc, request, &patterns),
        };
        let choice = choice.map_err(|several| several.into_iter().for_each(&mut keep)).ok();
        if let Some(diagnostics) = Diagnostics::new(&desc.source, problems) {
            return Err(Error::Invalid(diagnostics));
        }
        let (Some(integrator), Some(view), Some(encoding), Some(mut choice)) = (integrator, view, encoding, choice)
        else {
            unreachable!("what did not compile left a problem");
        };
        for (format, _) in request.png_data() {
            choice.add(format.pass);
        }
        if request.denoise.is_some() {
            choice.add_denoise();
        }
        encoding::check(encoding, &choice, &patterns)?;
        let shown = set_passes(&mut settings, choice, (described.name(), &integrator))?;
        memory::take(
            desc,
            &settings,
            (&integrator, request.policy.checkpoint),
            inputs.memory(),
        )?;
        let turntable = request
            .turntable
            .zip(camera)
            .map(|(frames, start)| Turntable { start, frames });
        let cameras = cameras(desc, request, camera, settings.resolution, inputs)?;
        if request.denoise.is_some() && settings.samples.max < 2 {
            let message = "--denoise compares two halves of the samples: render with 2 or more";
            return Err(Error::Usage(message.to_owned()));
        }
        let denoise = request.denoise.clone().map(|options| DenoisePlan {
            options,
            files: patterns.iter().cloned().zip(denoised).collect(),
        });
        let frames = cameras
            .frames
            .into_iter()
            .map(|(number, camera)| PlannedFrame {
                number,
                camera,
                files: files(&patterns, number),
            })
            .collect::<Vec<_>>();
        metadata::check(&sidecars, frames.iter().map(|frame| &frame.camera))?;
        let numbers: Vec<i32> = frames.iter().map(|f| f.number).collect();
        output::sequence::check_distinct(&patterns, &numbers)?;
        let (frames, whole) = match request.part {
            Some(part) => (part.choose(frames.clone()), Some(frames)),
            None => (frames, None),
        };
        let exposure = exposure(desc, request);
        let scene = desc.source.path.file_name().unwrap_or_default();
        Ok(Self {
            frames,
            whole,
            is_chunk: request.range.is_some() || request.part.is_some(),
            first_eye: cameras.first_eye,
            camera_path: request.camera_path.clone(),
            picture: PicturePlan {
                scene: scene.to_string_lossy().into_owned(),
                model: (request.point_radius, request.variant.clone(), request.light_units),
                turntable,
                fps: request.fps.map(frame_rate::rational),
                accel: request.accel,
                integrator,
                settings,
                seed_mode: request.seed_mode.unwrap_or(desc.render.seed_mode),
                working_space: desc.render.working_space,
                shown,
                view: view.unwrap_or_default(),
                exposure: exposure.stops().unwrap_or_default(),
                metering_camera: (exposure == Exposure::Auto).then_some(cameras.metering).flatten(),
            },
            files: FilePlan {
                encoding,
                sidecars,
                picture,
                files_of_caller: request.files_of_caller.clone(),
                denoise,
            },
            policy: request.policy,
            warnings: request.warnings.clone(),
        })
    }

    /// Renders one frame, and writes nothing.
    ///
    /// # Errors
    /// The frame was cancelled, or a pass shows a light group that the scene does not have.
    pub fn render_frame(
        &self,
        renderer: &Renderer,
        scene: &Scene,
        (frame, camera): (&PlannedFrame, &FrameCamera),
        control: &Control<'_>,
    ) -> Result<Film, RenderError> {
        let settings = render::Settings {
            noise_frame: self.picture.seed_mode.frame(frame.number),
            ..self.picture.settings.clone()
        };
        renderer.render(scene, camera, self.picture.integrator.as_dyn(), &settings, control)
    }

    /// The frames of all parts of the job.
    pub fn all_frames(&self) -> &[PlannedFrame] {
        self.whole.as_deref().unwrap_or(&self.frames)
    }

    /// The path of a file beside the pictures; `None` where there are none.
    pub(super) fn sidecar_path(&self, sidecar: Sidecar) -> Option<PathBuf> {
        let first = self.all_frames().first()?;
        Some(sidecar.path(&self.files.picture.as_ref()?.path(first.number)))
    }

    /// The coverage of pictures by this plan. `fills_film` tells whether every point of the picture has a camera ray, in all
    /// frames.
    pub fn coverage(&self, scene: &Scene, fills_film: bool) -> Coverage {
        if scene.shading.background.visible && fills_film && self.picture.settings.content == Content::Light {
            Coverage::Full
        } else {
            Coverage::Partial
        }
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
        metadata
    }
}

/// Lets films hold the chosen passes. Returns what of them files show.
fn set_passes(
    settings: &mut render::Settings,
    mut choice: PassChoice,
    integrator: (&str, &BuiltIn),
) -> Result<Shown, Error> {
    choice.fit_to(integrator, settings.samples.time.is_some())?;
    settings.content = choice.content();
    settings.passes = choice.passes;
    if settings.content == Content::FirstHits {
        settings.samples = SampleBudget::fixed(1);
        settings.filter = None;
    }
    if integrator.1.as_dyn().wants_cost() {
        // What is counted is not shown as light is.
        settings.samples.adaptive = None;
    }
    // The first plane is what the integrator computes.
    Ok(if choice.is_shown { Shown::Plane(1) } else { Shown::All })
}

fn settings(desc: &SceneDesc, request: &Request) -> Result<render::Settings, Error> {
    let said = [desc.render.width.get_ref().0, desc.render.height.get_ref().0];
    let resolution = request.resolution.unwrap_or(said);
    let window = match request.crop {
        None => overscanned(resolution, request.overscan),
        Some([x0, y0, x1, y1]) if x1 <= resolution[0] && y1 <= resolution[1] && x0 < x1 && y0 < y1 => {
            Window::sized([x0 as i32, y0 as i32], [x1 - x0, y1 - y0])
        }
        Some([x0, y0, x1, y1]) => {
            let [w, h] = resolution;
            return Err(Error::Usage(format!(
                "the crop {x0},{y0},{x1},{y1} reaches outside of the {w}x{h} picture"
            )));
        }
    };
    let budget = samples::budget(desc, request, exposure(desc, request).stops().unwrap_or_default())?;
    let samples = budget.max;
    check_size(resolution)?;
    let filter = match &desc.render.filter {
        None if samples == 1 => None,
        filter => Some(filter.clone().unwrap_or_default().compile()),
    };
    let sampler = match &desc.render.sampler {
        None => Sampler::default_for(samples),
        Some(said) => said.compile(samples).map_err(|p| Error::Usage(p.message))?,
    };
    Ok(render::Settings {
        resolution,
        window,
        samples: budget,
        seed: request.seed.unwrap_or(desc.render.seed.0),
        noise_frame: 0,
        sampler,
        filter,
        content: Content::Light,
        passes: Vec::new(),
        matte_ranks: request
            .cryptomatte_levels
            .or(desc.output.cryptomatte_levels.as_ref().map(|n| n.get_ref().0))
            .unwrap_or(DEFAULT_RANKS),
    })
}

/// The exposure of pictures.
fn exposure(desc: &SceneDesc, request: &Request) -> Exposure {
    request.exposure.or(desc.output.exposure).unwrap_or_default()
}

/// The picture with so many more columns and rows beyond each edge.
fn overscanned([width, height]: [u32; 2], overscan: u32) -> Window {
    let first = -i64::from(overscan).min(i64::from(MAX_SIDE)) as i32;
    let size = [width, height].map(|n| n.saturating_add(2 * overscan.min(MAX_SIDE)));
    Window::sized([first; 2], size)
}

fn check_size([width, height]: [u32; 2]) -> Result<(), Error> {
    if width > MAX_SIDE || height > MAX_SIDE {
        let message = format!("a picture has at most {MAX_SIDE} columns and rows, not {width}x{height}");
        return Err(Error::Usage(message));
    }
    Ok(())
}

/// The columns and rows that the coordinates of film and files can hold.
const MAX_SIDE: u32 = 1 << 24;

fn integrator(desc: &SceneDesc, request: &Request) -> Result<IntegratorDesc, Error> {
    let said = desc.render.integrator.clone();
    let Some(name) = &request.integrator else {
        return said
            .map_or_else(|| IntegratorDesc::by_name("path"), Ok)
            .map_err(Error::Usage);
    };
    match said {
        Some(said) if said.name() == name => Ok(said),
        _ => IntegratorDesc::by_name(name).map_err(|e| Error::Usage(format!("--integrator: {e}"))),
    }
}

fn files(patterns: &[FilePattern], frame: i32) -> Vec<PlannedFile> {
    patterns
        .iter()
        .map(|p| PlannedFile {
            path: p.path(frame),
            format: p.format(),
        })
        .collect()
}

/// The cameras of a job.
struct JobCameras {
    /// The camera of each frame to be rendered, in rising order.
    frames: Vec<(i32, FrameCamera)>,
    /// The first position of the camera, in m.
    first_eye: Option<DVec3>,
    /// The first camera, whichever frames are rendered, for the picture that is metered.
    metering: Option<FrameCamera>,
}

/// The cameras of the frames to be rendered.
fn cameras(
    desc: &SceneDesc,
    request: &Request,
    scene_camera: Option<SceneCamera>,
    resolution: [u32; 2],
    inputs: &Files,
) -> Result<JobCameras, Error> {
    let Some(file) = &request.camera_path else {
        let camera = scene_camera.ok_or_else(|| Error::NoCamera {
            path: desc.source.path.clone(),
        })?;
        let eye = camera.pose.eye();
        let metering = Camera::new(&camera.pose, &camera.lens, metering::resolution(resolution));
        let camera = Camera::new(&camera.pose, &camera.lens, resolution);
        let (last, what) = match request.turntable {
            Some(last) => (last, format!("the turntable, which has frames 1 to {last}")),
            None => (1, "the scene's own camera, which has frame 1 only".to_owned()),
        };
        let frames = frames(request, 1..=i64::from(last), &what)?;
        let cameras = frames.iter().map(|f| (number(f), FrameCamera::from(camera)));
        return Ok(JobCameras {
            frames: cameras.collect(),
            first_eye: Some(eye),
            metering: Some(FrameCamera::from(metering)),
        });
    };
    let options = camera_path::CameraPathOptions {
        fps: request.fps,
        rotation_order: request.rotation_order,
    };
    let path = camera_path::load(file, None, &options, inputs)?;
    let all = path.frames();
    let what = format!("the camera path, which has frames {} to {}", all.start(), all.end());
    let lens = scene_camera.map_or_else(Lens::default, |c| c.lens);
    check_columns(file, &path, &lens)?;
    let metering = path
        .frame_camera(*all.start(), &lens, metering::resolution(resolution))
        .ok();
    let first_eye = path.at(path.first()).ok().map(|first| first.pose.eye());
    let frames = frames(request, all, &what)?
        .iter()
        .map(|frame| {
            let camera = path.frame_camera(frame, &lens, resolution);
            camera
                .map(|camera| (number(frame), camera))
                .map_err(|cause| Error::Pose { frame, cause })
        })
        .collect::<Result<_, _>>()?;
    Ok(JobCameras {
        frames,
        first_eye,
        metering,
    })
}

/// A path that says of the lens what the scene's camera has not is wrong about one of the two.
fn check_columns(file: &Path, path: &CameraPath, lens: &Lens) -> Result<(), Error> {
    let columns = lens.unsupported_columns(&path.lens_at(path.first()));
    if columns.is_empty() {
        return Ok(());
    }
    Err(Error::Columns {
        path: file.to_owned(),
        camera: lens.name(),
        columns,
    })
}

/// The frames that were asked for, all of them among those that there are.
fn frames(request: &Request, all: RangeInclusive<i64>, what: &str) -> Result<FrameRange, Error> {
    let Some(range) = &request.range else {
        return FrameRange::all(*all.start(), *all.end()).ok_or_else(|| {
            let message = if all.is_empty() {
                "the camera path has no whole frame".to_owned()
            } else {
                format!("a job has at most {MAX_FRAMES} frames, choose some of {what} (--range)")
            };
            Error::Usage(message)
        });
    };
    match range.iter().find(|f| !all.contains(f)) {
        Some(outside) => Err(Error::Usage(format!("--range: frame {outside} is outside of {what}"))),
        None => Ok(range.clone()),
    }
}

/// Frames lie within [`MAX_FRAME`](crate::camera::path::MAX_FRAME), which is less than 2^31.
fn number(frame: i64) -> i32 {
    i32::try_from(frame).expect("ranges and paths keep frames within their limit")
}
