//! Fingerprints: what a frame's files depend on, as a hash that they carry.
//!
//! A file whose fingerprint is that of a planned frame has the pixels that the job would write. It covers the contents of all
//! inputs (not their dates), the frame's camera, every setting that changes pixels, and the version of the program. Of the
//! camera path only the frame's own camera counts, so that a key that is changed touches the frames around it alone.

use std::path::Path;

use serde::Serialize;

use crate::{
    assets::{ContentHash, Store},
    batch::{Plan, PlannedFrame, Turntable, frame_scenes::time_in_frames},
    camera::{FrameCamera, Neighbours, SecondEye},
    compile::default_scene::normalise::Normalise,
    describe::Source,
    film::{PassRequest, Window},
    filter::Filter,
    integrator::BuiltIn,
    math::sorting,
    output::{Attribute, DisplayTransform, Encoding, FrameMetadata, Shown, camera_attributes},
    render::{AdaptiveSampling, Content, SampleRanges, SceneTime, Settings, moment_times},
    sampler::Sampler,
    shape::mesh::{AnimationChoice, LightUnits},
};

/// Rises with every change of the program that changes pixels between two versions of the package.
const PICTURE_VERSION: u32 = 17;

/// The version of the package.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The attribute of a file's own fingerprint.
pub const FINGERPRINT: &str = "batch-render/fingerprint";

/// The attribute of the fingerprint that all crops of a frame share.
pub const PICTURE: &str = "batch-render/picture";

/// The attribute of the arrangement of two eyes in one picture.
const EYES: &str = "batch-render/eyes";

/// The attribute of the fingerprint that all frames of a scene share.
pub const SCENE: &str = "batch-render/inputs";

/// The hash of all input files but the camera path and tables of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputHash(ContentHash);

impl InputHash {
    /// The hash of what `store` has loaded for the scene, also at which resolution, and of what overrides values of its file. Files
    /// `apart` are left out: a frame takes what they say of it into its own fingerprint. Paths count as they are seen from the
    /// scene's folder, so that a project may be moved as a whole.
    pub fn new(store: &Store, scene: &Source, apart: &[&Path]) -> Self {
        let home = scene.path.parent().unwrap_or(Path::new(""));
        let mut files: Vec<(String, String)> = store
            .files()
            .manifest()
            .into_iter()
            .filter(|(path, _)| !apart.contains(&path.as_path()))
            .map(|(path, hash)| {
                let name = path.strip_prefix(home).unwrap_or(&path);
                let name = name.display().to_string();
                // The same on every system.
                (
                    hash.to_string(),
                    if cfg!(windows) { name.replace('\\', "/") } else { name },
                )
            })
            .collect();
        sorting::sort_by(&mut files, Ord::cmp);
        let (halved, overrides) = (store.halved(), scene.overrides.of_scene());
        let text = serde_json::to_vec(&HashedInputs {
            files,
            halved,
            overrides,
        })
        .expect("names and numbers are JSON");
        Self(ContentHash::of(&text))
    }
}

/// The input files of a scene, by hash and name, and how often each image was halved.
#[derive(Serialize)]
struct HashedInputs {
    files: Vec<(String, String)>,
    halved: Vec<Vec<u32>>,
    /// The overrides of values of the scene file.
    overrides: String,
}

/// All that the picture of a frame depends on. Its JSON is hashed, which is the same text on every machine. A field or variant that
/// is renamed or moved gives the frames that have it other fingerprints, so that finished ones are rendered again. So does a new
/// field, but for frames where it is skipped as `None`, `false` or empty.
#[derive(Serialize)]
struct Hashed<'a> {
    picture_version: u32,
    package_version: &'a str,
    inputs: String,
    resolution: [u32; 2],
    samples: u32,
    /// Those for which textures are filtered, if they are others.
    #[serde(skip_serializing_if = "Option::is_none")]
    planned_samples: Option<u32>,
    adaptive: Option<AdaptiveSampling>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ranges: Option<SampleRanges>,
    seed: u32,
    noise_frame: i32,
    sampler: &'a Sampler,
    filter: &'a Option<Filter>,
    content: Content,
    passes: Vec<String>,
    matte_ranks: u32,
    integrator: &'a BuiltIn,
    turntable: Option<Turntable>,
    point_radius: Option<f32>,
    variant: &'a Option<String>,
    /// The unit of a model's lights, and its ground and size.
    #[serde(skip_serializing_if = "Option::is_none")]
    light_units: Option<LightUnits>,
    #[serde(skip_serializing_if = "Option::is_none")]
    placed: Option<(bool, Option<Normalise>)>,
    /// The animations of a model by itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    animation: &'a Option<AnimationChoice>,
    frame: i32,
    /// `None` for what all frames share.
    camera: Option<FrameCamera>,
    /// Whether only cameras of other frames leave a part of the picture empty.
    #[serde(skip_serializing_if = "<&bool as std::ops::Not>::not")]
    others_lack_rays: bool,
    /// The second eye, which follows from it and this, and its place in the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    second_eye: Option<SecondEye>,
    /// The neighbouring frames, if a pass follows motion.
    neighbours: Option<Neighbours>,
    /// The values of the scene at the frame, if any change over time.
    #[serde(skip_serializing_if = "Option::is_none")]
    moment: Option<Moment<'a>>,
    /// Those at the later moments of the shutter, and at the neighbouring frames if a pass follows motion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    further_moments: Vec<Moment<'a>>,
    /// Whether a scene that may move in the frame is rendered in the rounds of a time limit, which add its samples in another order.
    #[serde(skip_serializing_if = "<&bool as std::ops::Not>::not")]
    in_rounds: bool,
    /// Those at the frame that the exposure suits.
    #[serde(skip_serializing_if = "Option::is_none")]
    metered_moment: Option<Moment<'a>>,
    shown: Shown,
    view: DisplayTransform,
    exposure: Exposure<'a>,
    fps: Option<(i32, u32)>,
    encoding: Encoding,
}

/// The names of the values of a scene with what they are at a time.
type Moment<'a> = Vec<(&'a str, String)>;

/// The values of the scene as the shutter of a frame opens, and those of the other times that it shows.
fn moments<'a>(
    plan: &'a Plan,
    settings: &Settings,
    follows_motion: bool,
    (number, camera): (i32, &FrameCamera),
) -> (Option<Moment<'a>>, Vec<Moment<'a>>) {
    let at = |time| plan.moment(time_in_frames(number, camera, time));
    let within = moment_times(settings, camera).filter(|_| camera.duration() > 0.0);
    let around = [SceneTime::Before, SceneTime::After]
        .into_iter()
        .filter(|_| follows_motion);
    (at(SceneTime::OPENING), within.chain(around).filter_map(at).collect())
}

#[derive(Serialize)]
enum Exposure<'a> {
    Stops(f32),
    Metered(&'a FrameCamera),
}

impl<'a> Hashed<'a> {
    /// The inputs of a frame, or without one, those of all frames of `plan`.
    fn new(
        version: &'a str,
        plan: &'a Plan,
        settings: &'a Settings,
        inputs: InputHash,
        frame: Option<(i32, &FrameCamera)>,
    ) -> Self {
        let Settings {
            resolution,
            window: _,
            samples,
            planned_samples,
            ranges,
            seed,
            noise_frame: _,
            sampler,
            filter,
            content,
            passes,
            matte_ranks,
        } = settings;
        let motion = passes.iter().any(|pass| pass.spec().follows_motion());
        let picture = &plan.picture;
        let (mut adaptive, mut exposure) = (samples.adaptive, Exposure::Stops(picture.exposure));
        if let Some(camera) = &picture.metering_camera {
            // It follows from the scene and this camera.
            exposure = Exposure::Metered(camera);
            adaptive = adaptive.map(|rule| AdaptiveSampling { gain: 1.0, ..rule });
        }
        let metered = picture.metering_camera.as_ref().map(|_| plan.first_frame);
        let moments = frame.map(|frame| moments(plan, settings, motion, frame));
        let (moment, further) = moments.unwrap_or_default();
        let may_move = moment.is_some() && frame.is_some_and(|(_, camera)| camera.duration() > 0.0);
        let (number, camera) = frame.unzip();
        let number = number.unwrap_or(0);
        Self {
            picture_version: PICTURE_VERSION,
            package_version: version,
            inputs: inputs.0.to_string(),
            resolution: *resolution,
            samples: samples.max,
            planned_samples: (*planned_samples != samples.max).then_some(*planned_samples),
            adaptive,
            ranges: *ranges,
            seed: *seed,
            noise_frame: picture.seed_mode.frame(number),
            sampler,
            filter,
            content: *content,
            passes: passes.iter().map(PassRequest::name).collect(),
            matte_ranks: *matte_ranks,
            integrator: &picture.integrator,
            turntable: picture.turntable,
            point_radius: picture.model.0,
            variant: &picture.model.1,
            light_units: picture.model.2,
            placed: Some(picture.placed).filter(|placed| *placed != (false, None)),
            animation: &picture.animation,
            frame: number,
            camera: camera.map(|camera| camera.clone().with_neighbours(Neighbours::default())),
            others_lack_rays: !plan.fills_film && camera.is_some_and(FrameCamera::fills_film),
            second_eye: picture.second_eye,
            neighbours: camera.filter(|_| motion).map(|camera| camera.neighbours().clone()),
            moment,
            further_moments: further,
            in_rounds: may_move && samples.time.is_some(),
            metered_moment: metered.and_then(|first| plan.moment(first)),
            shown: picture.shown,
            view: picture.view,
            exposure,
            fps: picture.fps,
            encoding: plan.files.encoding,
        }
    }
}

fn hash(hashed: &impl Serialize) -> String {
    let text = serde_json::to_vec(hashed).expect("names and numbers are JSON");
    ContentHash::of(&text).to_string()
}

/// The hashes of all that the files of a frame depend on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fingerprint {
    /// The hash of what is shown and how it is lit, which frames with other cameras share.
    pub scene: String,
    /// The hash of the whole frame, which its crops share.
    pub picture: String,
    /// The hash of the files with this crop.
    pub file: String,
}

impl Fingerprint {
    /// The fingerprint of a frame of `plan`.
    pub fn of_frame(plan: &Plan, inputs: InputHash, frame: &PlannedFrame) -> Self {
        Self::new(plan, &plan.picture.settings, inputs, (frame.number, &frame.camera))
    }

    /// The fingerprint of frame number `number` as `camera` sees it, rendered by `plan` with these settings.
    pub fn new(plan: &Plan, settings: &Settings, inputs: InputHash, frame: (i32, &FrameCamera)) -> Self {
        Self::by_version(VERSION, plan, settings, inputs, frame)
    }

    /// The hash of what the samples of a frame depend on: but for their number, or those of the range with this number.
    pub fn of_sums(plan: &Plan, inputs: InputHash, frame: &PlannedFrame, range: Option<u32>) -> String {
        let mut settings = plan.picture.settings.clone();
        match (settings.ranges, range) {
            (Some(ranges), Some(index)) => settings.ranges = Some(ranges.only(index)),
            _ => settings.samples.max = 0,
        }
        Self::new(plan, &settings, inputs, (frame.number, &frame.camera)).file
    }

    /// The hash of all that the files of all frames of `plan` depend on, but for their numbers and cameras.
    pub fn of_job(plan: &Plan, inputs: InputHash) -> String {
        let settings = &plan.picture.settings;
        let shared = hash(&Hashed::new(VERSION, plan, settings, inputs, None));
        Self::of_window(&shared, settings.window)
    }

    /// The fingerprint that this version of the package gives.
    fn by_version(
        version: &str,
        plan: &Plan,
        settings: &Settings,
        inputs: InputHash,
        frame: (i32, &FrameCamera),
    ) -> Self {
        let hashed = Hashed::new(version, plan, settings, inputs, Some(frame));
        let whole = hash(&hashed);
        Self {
            scene: match &hashed.moment {
                None => hash(&(&hashed.inputs, &plan.picture.integrator, &plan.picture.model)),
                Some(moment) => hash(&(&hashed.inputs, &plan.picture.integrator, &plan.picture.model, moment)),
            },
            file: Self::of_window(&whole, settings.window),
            picture: whole,
        }
    }

    /// The hash of the files of a part of the picture whose fingerprint is `picture`.
    pub fn of_window(picture: &str, window: Window) -> String {
        let Window { x0, y0, x1, y1 } = window;
        ContentHash::of(format!("{picture} {x0},{y0},{x1},{y1}").as_bytes()).to_string()
    }

    /// The metadata of the files of frame number `frame` of `plan`, as `camera` sees it, with this fingerprint.
    pub fn metadata(&self, plan: &Plan, frame: i32, camera: &FrameCamera) -> FrameMetadata {
        let mut metadata = plan.metadata(frame);
        let (resolution, fps) = (plan.picture.settings.resolution, plan.picture.fps);
        match plan.picture.second_eye {
            // They are of one camera.
            Some(second) => metadata.attributes.push(Attribute::new(EYES, second.layout.name())),
            None => metadata.attributes.extend(camera_attributes(camera, resolution, fps)),
        }
        metadata.attributes.extend([
            Attribute::new(FINGERPRINT, self.file.as_str()),
            Attribute::new(PICTURE, self.picture.as_str()),
            Attribute::new(SCENE, self.scene.as_str()),
        ]);
        metadata
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        assets::Files,
        batch::Request,
        describe::{self, Overrides},
    };

    const SCENE: &str = "[render]\nwidth = 16\nheight = 12\nsamples = { min = 16, max = 64, threshold = 0.02 }\nseed = 5\n\
        [camera]\nperspective = { eye = [0, 1, 5], target = [0, 0.5, 0], fstop = 2.8, focus_distance = 4 }\n\
        [output]\nview = \"agx\"\naovs = [\"forward\", \"N\"]\n";

    fn plan() -> Plan {
        let desc = describe::load(Path::new("s.toml"), &Overrides::default(), |_| Ok(SCENE)).expect("a scene");
        let request = Request {
            turntable: Some("3".parse().expect("a number of frames")),
            ..Request::default()
        };
        Plan::new(&desc, &request, &Files::default()).expect("a plan")
    }

    /// Frames that were rendered before are rendered again where this test has to be changed.
    #[test]
    fn the_fingerprint_of_a_fixed_job_is_a_constant_on_every_machine() {
        let plan = plan();
        let inputs = InputHash(ContentHash::of(b"inputs"));
        let PlannedFrame { number, camera, .. } = &plan.frames[1];
        let of =
            |version: &str| Fingerprint::by_version(version, &plan, &plan.picture.settings, inputs, (*number, camera));
        assert_eq!(of("1.2.3").picture, "69198a3afc8e86f13635ef4c31c3985a");
        assert_ne!(of("1.2.4").picture, of("1.2.3").picture);
    }

    /// The fingerprints of the scenes of two frames of a camera that rests.
    fn scenes(animation: &str) -> [String; 2] {
        let mesh = format!("[[object]]\nshape.mesh = {{ file = \"a.glb\", animation = {animation} }}\n");
        let text = format!("{SCENE}{mesh}");
        let desc = describe::load(Path::new("s.toml"), &Overrides::default(), |_| Ok(text)).expect("a scene");
        let plan = Plan::new(&desc, &Request::default(), &Files::default()).expect("a plan");
        let inputs = InputHash(ContentHash::of(b"inputs"));
        [1, 2]
            .map(|frame| Fingerprint::new(&plan, &plan.picture.settings, inputs, (frame, &plan.frames[0].camera)).scene)
    }

    #[test]
    fn frames_in_which_a_model_plays_an_animation_do_not_show_the_same_scene() {
        let [first, second] = scenes("\"Walk\"");
        assert_ne!(first, second);
        let [first, second] = scenes("[]");
        assert_eq!(first, second);
    }
}
