//! Fingerprints: what a frame's files depend on, as a hash that they carry.
//!
//! A file whose fingerprint is that of a planned frame has the pixels that the job would write. It covers the contents of all
//! inputs (not their dates), the frame's camera, every setting that changes pixels, and the version of the program. Of the
//! camera path only the frame's own camera counts, so that a key that is changed touches the frames around it alone.

use std::{fmt::Write, path::Path};

use super::{Plan, PlannedFrame};
use crate::{
    assets::{ContentHash, Store},
    camera::{FrameCamera, Neighbours},
    describe::Source,
    film::{PassRequest, Window},
    output::{Attribute, FrameMetadata, camera_attributes},
    render::Settings,
};

/// Rises with every change of the program that changes pixels between two versions of the package.
const PICTURE_VERSION: u32 = 2;

/// The attribute of a file's own fingerprint.
pub const FINGERPRINT: &str = "batch-render/fingerprint";

/// The attribute of the fingerprint that all crops of a frame share.
pub const PICTURE: &str = "batch-render/picture";

/// The hash of all input files but the camera path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputHash(ContentHash);

impl InputHash {
    /// The hash of what `store` has loaded for the scene, also at which resolution, and of what overrides values of its file. Paths count as they are seen from
    /// the scene's folder, so that a project may be moved as a whole.
    pub fn new(store: &Store, scene: &Source, camera_path: Option<&Path>) -> Self {
        let home = scene.path.parent().unwrap_or(Path::new(""));
        let mut lines: Vec<String> = store
            .files()
            .manifest()
            .into_iter()
            .filter(|(path, _)| Some(path.as_path()) != camera_path)
            .map(|(path, hash)| {
                let name = path.strip_prefix(home).unwrap_or(&path);
                format!("{hash} {}\n", name.display())
            })
            .collect();
        lines.sort();
        lines.push(format!("{:?}", store.halved()));
        lines.push(scene.overrides.of_scene());
        Self(ContentHash::of(lines.concat().as_bytes()))
    }
}

/// The hashes of all that the files of a frame depend on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fingerprint {
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
    pub fn new(plan: &Plan, settings: &Settings, inputs: InputHash, (number, camera): (i32, &FrameCamera)) -> Self {
        let Settings {
            resolution,
            window,
            samples,
            seed,
            noise_frame: _,
            sampler,
            filter,
            content,
            passes,
            matte_ranks,
        } = settings;
        let motion = passes.iter().any(|pass| pass.spec().follows_motion());
        let neighbours = motion.then(|| camera.neighbours());
        let camera = camera.clone().with_neighbours(Neighbours::default());
        let mut text = format!("{PICTURE_VERSION} {}\n", env!("CARGO_PKG_VERSION"));
        let passes: Vec<String> = passes.iter().map(PassRequest::name).collect();
        let noise_frame = plan.picture.seed_mode.frame(number);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:?} {resolution:?} {} {seed} {noise_frame} {sampler:?} {filter:?} {content:?} {passes:?} {matte_ranks}",
            inputs.0, samples.max
        );
        // A metered exposure follows from the scene and the first camera.
        let (exposure, is_metered) = match &plan.picture.metering_camera {
            Some(camera) => (format!("{camera:?}"), true),
            None => (plan.picture.exposure.to_string(), false),
        };
        if let Some(mut adaptive) = samples.adaptive {
            if is_metered {
                adaptive.gain = 1.0;
            }
            let _ = writeln!(text, "{adaptive:?}");
        }
        let _ = writeln!(
            text,
            "{:?} {:?} {:?}",
            plan.picture.integrator, plan.picture.turntable, plan.picture.model
        );
        let _ = writeln!(text, "{number} {camera:?} {neighbours:?}");
        let _ = writeln!(
            text,
            "{:?} {:?} {} {:?} {:?}",
            plan.picture.shown, plan.picture.view, exposure, plan.picture.fps, plan.files.encoding
        );
        Self::of_window(ContentHash::of(text.as_bytes()).to_string(), *window)
    }

    /// The fingerprint of a part of the picture whose fingerprint is `picture`.
    pub fn of_window(picture: String, window: Window) -> Self {
        let Window { x0, y0, x1, y1 } = window;
        let file = ContentHash::of(format!("{picture} {x0},{y0},{x1},{y1}").as_bytes()).to_string();
        Self { picture, file }
    }

    /// The metadata of the files of frame number `frame` of `plan`, as `camera` sees it, with this fingerprint.
    pub fn metadata(&self, plan: &Plan, frame: i32, camera: &FrameCamera) -> FrameMetadata {
        let mut metadata = plan.metadata(frame);
        metadata.attributes.extend(camera_attributes(
            camera,
            plan.picture.settings.resolution,
            plan.picture.fps,
        ));
        metadata.attributes.extend([
            Attribute::new(FINGERPRINT, self.file.as_str()),
            Attribute::new(PICTURE, self.picture.as_str()),
        ]);
        metadata
    }
}
