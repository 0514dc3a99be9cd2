//! The picture that all frames of a job show: the integrator, the passes and the settings of the renderer.

use super::{frame_rate, passes::PassChoice, sample_ranges};
use crate::{
    accel::BuildOptions,
    batch::{Request, Turntable},
    camera::{FrameCamera, SceneCamera, SecondEye, StereoEye, stereo::Side},
    compile::default_scene::normalise::Normalise,
    describe::{Diagnostics, SceneDesc},
    error::Error,
    film::{
        PassRequest, PassSpec, Window,
        coverage::DEFAULT_RANKS,
        passes::{COVERAGE, PASSES, PassSource},
    },
    integrator::BuiltIn,
    math::{WorkingSpace, exponential},
    output::{DisplayTransform, Format, Shown},
    render::{self, AdaptiveSampling, Content, SampleBudget},
    sampler::{Sampler, SeedMode},
    shape::mesh::{AnimationChoice, LightUnits},
    value::Problem,
};

/// The settings of the picture, which all frames share.
#[derive(Clone, Debug)]
pub struct PicturePlan {
    /// The name of the scene's file.
    pub scene: String,
    /// The radius in m of the points of a model that is the scene, the variant of its materials, and the unit of its lights.
    pub model: (Option<f32>, Option<String>, Option<LightUnits>),
    /// Whether it stands on a ground, and the unit shape that it is scaled to.
    pub placed: (bool, Option<Normalise>),
    /// The scene's own camera.
    pub camera: Option<SceneCamera>,
    /// Moves the camera once the scene is known.
    pub turntable: Option<Turntable>,
    /// The eye that the cameras are those of.
    pub stereo: Option<StereoEye>,
    /// The other eye, where each picture shows both.
    pub second_eye: Option<SecondEye>,
    /// Frames per second, as a fraction.
    pub fps: Option<(i32, u32)>,
    /// The animations that a model by itself plays.
    pub animation: Option<AnimationChoice>,
    pub accel: BuildOptions,
    pub integrator: BuiltIn,
    /// The settings of every frame, but for its number.
    pub settings: render::Settings,
    pub seed_mode: SeedMode,
    /// The numbers of lights of the scene file itself: of those before and of those after the lights of models.
    pub own_lights: [usize; 2],
    /// The primaries of the light.
    pub working_space: WorkingSpace,
    /// Whether denoisers read the files.
    pub(super) serves_denoisers: bool,
    /// The planes of each film that go into its files.
    pub shown: Shown,
    /// Whether these are of surfaces that the alpha of the picture leaves out.
    pub(super) is_beyond_alpha: bool,
    pub view: DisplayTransform,
    /// The exposure of pictures, in stops; 0 until the scene is metered, if that decides.
    pub exposure: f32,
    /// The camera of the picture that decides about the exposure, where one does.
    pub metering_camera: Option<FrameCamera>,
}

impl PicturePlan {
    /// The picture of a scene whose frames have these formats.
    pub(in crate::batch) fn new(desc: &SceneDesc, request: &Request, formats: &[&dyn Format]) -> Result<Self, Error> {
        let mut settings = settings(desc, request)?;
        let (integrator, camera, mut choice) = compile(desc, request, formats)?;
        for (format, _) in request.png_data() {
            choice.add(format.pass);
        }
        if request.denoise.is_some() {
            choice.add_denoise();
            if settings.samples.max < 2 {
                let message = "--denoise compares two halves of the samples: render with 2 or more";
                return Err(Error::Usage(message.to_owned()));
            }
        }
        choice.fit_to((desc.render.integrator.name(), &integrator))?;
        let is_mean = |pass: &PassRequest| matches!(pass.spec().source, PassSource::Mean(_));
        let is_beyond_alpha = choice.is_shown && choice.passes.iter().any(is_mean) && desc.has_catchers();
        let is_by_halves = choice.passes.iter().any(|pass| pass.spec().is_by_halves());
        settings.samples.doubles = is_by_halves && request.time_limit.is_some();
        let content = choice.content();
        if content == Content::FirstHits {
            settings.samples = SampleBudget::fixed(1);
            settings.filter = None;
        }
        if integrator.as_dyn().wants_cost() {
            // What is counted is not shown as light is.
            settings.samples.adaptive = None;
        }
        let scene = desc.source.path.file_name().unwrap_or_default();
        let turntable = request.turntable.zip(camera).map(|(turn, start)| Turntable {
            start,
            frames: turn.frames,
            degrees: turn.degrees,
        });
        Ok(Self {
            scene: scene.to_string_lossy().into_owned(),
            model: (request.point_radius, request.variant.clone(), request.light_units),
            placed: (request.ground, request.normalise),
            camera,
            turntable,
            stereo: request.stereo,
            second_eye: request.second_eye,
            fps: request.fps.map(frame_rate::rational),
            animation: request.animation.clone(),
            accel: request.accel,
            integrator,
            settings: render::Settings {
                content,
                passes: choice.passes,
                ..settings
            },
            seed_mode: desc.render.seed_mode,
            own_lights: [desc.lights.len(), usize::from(desc.background.sky.is_some())],
            working_space: desc.render.working_space,
            serves_denoisers: choice.serves_denoisers && !choice.is_all,
            // The first plane is what the integrator computes.
            shown: if choice.is_shown { Shown::Plane(1) } else { Shown::All },
            is_beyond_alpha,
            view: desc.output.view,
            exposure: desc.output.exposure.stops().unwrap_or_default(),
            metering_camera: None,
        })
    }
}

impl PicturePlan {
    /// The columns and rows of the files.
    pub fn size(&self) -> [u32; 2] {
        self.with_eyes([self.settings.window.width(), self.settings.window.height()])
    }

    /// The eye in stereo that the pictures are those of; `None` where a picture shows both.
    pub fn eye(&self) -> Option<Side> {
        let eye = self.stereo.filter(|_| self.second_eye.is_none());
        eye.map(|eye| eye.side())
    }

    /// The columns and rows of the whole picture.
    pub fn resolution(&self) -> [u32; 2] {
        self.with_eyes(self.settings.resolution)
    }

    /// The columns and rows of a picture of all eyes, of each of which it is so many.
    fn with_eyes(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        let [x, y] = self.second_eye.map_or([1, 1], |second| second.layout.factors());
        [width.saturating_mul(x), height.saturating_mul(y)]
    }

    /// The most samples of a frame.
    pub fn max_samples(&self) -> u64 {
        self.settings.max_samples() * self.eyes()
    }

    /// The number of eyes that a picture shows.
    pub(super) fn eyes(&self) -> u64 {
        if self.second_eye.is_some() { 2 } else { 1 }
    }

    /// Adds the passes that denoisers read of some scenes only, unless the films have them: motion vectors where objects move, and
    /// the coverage where shadow catchers are.
    pub(super) fn add_for_denoisers(&mut self, moves: bool, has_catchers: bool) {
        if !self.serves_denoisers {
            return;
        }
        let is_read = |spec: &&PassSpec| moves && spec.follows_motion() || has_catchers && spec.name == COVERAGE;
        let read = PASSES.iter().filter(is_read).map(PassRequest::Pass);
        let passes = &mut self.settings.passes;
        let missing: Vec<PassRequest> = read.filter(|pass| !passes.contains(pass)).collect();
        passes.extend(missing);
    }
}

/// Compiles what a description says of the picture, or finds all that is wrong with it.
fn compile(
    desc: &SceneDesc,
    request: &Request,
    formats: &[&dyn Format],
) -> Result<(BuiltIn, Option<SceneCamera>, PassChoice), Error> {
    let mut problems = Vec::new();
    let mut keep = |several: Vec<Problem>| problems.extend(several);
    let integrator = desc.render.integrator.compile();
    let integrator = integrator.map_err(|problem| keep(vec![problem])).ok();
    let camera = desc.camera.as_ref().map(|camera| camera.get_ref().compile());
    let camera = camera.transpose().map_err(&mut keep).ok();
    let choice = PassChoice::new(desc, request, formats).map_err(&mut keep).ok();
    if let (Some(mut integrator), Some(camera), Some(choice)) = (integrator, camera, choice) {
        integrator.convert_colors(desc.render.working_space);
        return Ok((integrator, camera, choice));
    }
    let problems = Diagnostics::new(&desc.source, problems).expect("what did not compile left a problem");
    Err(Error::Invalid(problems))
}

/// The settings of the renderer, without passes.
fn settings(desc: &SceneDesc, request: &Request) -> Result<render::Settings, Error> {
    let resolution = desc.render.resolution();
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
    let described = desc.render.samples.get_ref();
    let samples = described.max();
    let adaptive = described.adaptive().map(|own| AdaptiveSampling {
        min: own.min.get_ref().0.min(samples),
        threshold: own.threshold.0,
        gain: exponential::pow(2.0, desc.output.exposure.stops().unwrap_or_default()),
    });
    check_size(resolution)?;
    let filter = match &desc.render.filter {
        None if samples == 1 => None,
        filter => Some(filter.clone().unwrap_or_default().compile()),
    };
    // Samples that may follow are of the same sequence.
    let planned = if request.policy.keep_sums {
        MOST_SAMPLES.max(samples)
    } else {
        samples
    };
    let sampler = match &desc.render.sampler {
        None => Sampler::default_for(planned),
        Some(said) => said.compile(planned).map_err(|p| Error::Usage(p.message))?,
    };
    if let Some(ranges) = request.sample_ranges {
        sample_ranges::check(ranges, samples, adaptive.is_some(), request)?;
    }
    let levels = desc.output.cryptomatte_levels.as_ref();
    Ok(render::Settings {
        resolution,
        window,
        samples: SampleBudget {
            adaptive,
            time: request.time_limit,
            ..SampleBudget::fixed(samples)
        },
        planned_samples: planned,
        ranges: request.sample_ranges,
        seed: desc.render.seed.0,
        noise_frame: 0,
        sampler,
        filter,
        content: Content::Light,
        passes: Vec::new(),
        matte_ranks: levels.map_or(DEFAULT_RANKS, |levels| levels.get_ref().0),
    })
}

/// The samples of a pixel that samplers spread evenly where more may follow in a later job.
const MOST_SAMPLES: u32 = 1 << 16;

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
