//! Requests: the settings of a job beside its scene. Command lines and callers fill in a [`Request`].

use std::{path::PathBuf, time::Duration};

use crate::{
    accel::BuildOptions,
    assets::{SuppliedFile, camera_path::CameraPathOptions, store::MissingAssets},
    batch::{
        DenoiseOptions, DenoiseSteps, Existing, FrameRange, IfBusy, JobPart, OnFailure, Turn, Views,
        products::{coco::categories::CategoryKind, metadata::Sidecar},
    },
    camera::{Pose, RotationOrder, SecondEye, StereoEye},
    compile::default_scene::normalise::Normalise,
    describe::Overrides,
    output::{
        DepthUnit, Format,
        png::data::{DEPTH, DataPng, IDS, NORMALS},
    },
    render::SampleRanges,
    shape::mesh::{AnimationChoice, LightUnits},
    warnings::Warnings,
};

/// The frames that a caller takes by [`JobEvent::FrameImage`](crate::batch::JobEvent::FrameImage). A job whose
/// frames are taken needs no files.
#[derive(Clone, Copy, Debug, Default)]
pub enum TakenFrames {
    #[default]
    None,
    /// Pictures for displays.
    Pictures,
    /// Files of this format.
    Files(&'static dyn Format),
}

impl TakenFrames {
    /// Whether there are any.
    pub(in crate::batch) fn are_any(self) -> bool {
        !matches!(self, Self::None)
    }
}

/// The settings of a job.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Values for keys of the scene file.
    pub overrides: Overrides,
    /// An input file that is not on disk, such as the scene.
    pub supplied: Option<SuppliedFile>,
    /// The frames that the caller takes.
    pub taken: TakenFrames,
    pub camera_path: Option<PathBuf>,
    /// The file of values that change over time, in place of the scene's.
    pub values: Option<PathBuf>,
    /// The file of distributions that values are drawn from for each frame, in place of the scene's.
    pub random: Option<PathBuf>,
    /// The name, or the number from 0, of a camera of the model that is the scene.
    pub camera: Option<String>,
    /// The name of a material variant of the model that is the scene.
    pub variant: Option<String>,
    /// The unit of its lights, if not that of the program that wrote it.
    pub light_units: Option<LightUnits>,
    /// The animations that are played of the model that is the scene.
    pub animation: Option<AnimationChoice>,
    /// Instead of a camera path: frames of an orbit around the scene.
    pub turntable: Option<Turn>,
    /// Instead of a camera path: views of all of the scene. [`Job`](crate::batch::Job) finds out where it is; a plan by itself
    /// does not, and is refused.
    pub views: Option<Views>,
    /// The eye that the cameras are those of.
    pub stereo: Option<StereoEye>,
    /// The other eye, where each picture shows both.
    pub second_eye: Option<SecondEye>,
    /// Whether the scene's camera is moved along its line of sight until the scene fits into the picture.
    pub frame_to_fit: bool,
    /// Whether a model that is the scene stands on a ground.
    pub ground: bool,
    /// The unit shape that a model by itself is scaled to.
    pub normalise: Option<Normalise>,
    pub range: Option<FrameRange>,
    /// The share of these frames that this job renders.
    pub part: Option<JobPart>,
    pub policy: Policy,
    /// The time that each frame has; it gets fewer samples where that is too short.
    pub time_limit: Option<Duration>,
    /// Columns and rows x0, y0, x1, y1; the last two are not rendered.
    pub crop: Option<[u32; 4]>,
    /// Patterns of PNG files of depth, of normals, and of the numbers of objects. An empty one names files beside the pictures.
    pub png_depth: Option<String>,
    pub png_normals: Option<String>,
    pub png_ids: Option<String>,
    pub png_depth_unit: DepthUnit,
    /// The denoising that follows once all frames are there; the job's files are the denoised ones then.
    pub denoise: Option<DenoiseOptions>,
    /// The steps of such a job.
    pub denoise_steps: DenoiseSteps,
    /// The files with metadata beside the pictures.
    pub metadata: Vec<Sidecar>,
    /// What the categories of `coco.json` are named after.
    pub categories: CategoryKind,
    /// Files that the caller writes beside the job's own. None of them may be a file that the job reads or writes.
    pub files_of_caller: Vec<PathBuf>,
    /// The ranges of the samples whose sums are added, and the one that is rendered.
    pub sample_ranges: Option<SampleRanges>,
    /// Columns and rows beyond each edge of the picture.
    pub overscan: u32,
    pub accel: BuildOptions,
    pub fps: Option<f64>,
    pub rotation_order: Option<RotationOrder>,
    /// The memory limit of the job in bytes; `None` is no limit.
    pub max_memory: Option<u64>,
    /// Bytes that all images may take, beyond which larger ones are loaded at a lower resolution; `None` is no limit.
    pub texture_memory: Option<u64>,
    pub missing_assets: MissingAssets,
    /// Whether a model is refused if a part of it would not be rendered.
    pub strict: bool,
    /// Whether models may name files outside of their folders.
    pub allow_outside: bool,
    /// The radius in m of the points of a model that is the scene.
    pub point_radius: Option<f32>,
    /// The sink of the job's warnings: a clone of it reads them, also those of a job that cannot be opened.
    pub warnings: Warnings,
}

/// The policy of a job, whatever it renders.
#[derive(Clone, Copy, Debug, Default)]
pub struct Policy {
    pub existing: Existing,
    pub on_failure: OnFailure,
    /// The number of further attempts to write a file.
    pub retries: u32,
    /// Whether the job waits where another one writes the same files.
    pub if_busy: IfBusy,
    /// The time between two checkpoints of a frame; `None` for none.
    pub checkpoint: Option<Duration>,
    /// Whether the sums of finished frames are kept beside their files, so that a later job can add samples.
    pub keep_sums: bool,
}

impl Request {
    /// The settings for reading a camera path, with the pose of the scene's camera.
    pub(crate) fn path_options(&self, pose: Option<Pose>) -> CameraPathOptions {
        CameraPathOptions {
            fps: self.fps,
            rotation_order: self.rotation_order,
            pose,
        }
    }

    /// The denoising that is asked for. Views in a row are no neighbours in time, so that none helps another.
    pub(in crate::batch) fn denoising(&self) -> Option<DenoiseOptions> {
        let options = self.denoise.clone()?;
        let temporal = if self.views.is_none() { options.temporal } else { 0 };
        Some(DenoiseOptions { temporal, ..options })
    }

    /// The PNG files of data that are asked for, with their patterns.
    pub(in crate::batch) fn png_data(&self) -> impl Iterator<Item = (&'static DataPng, &String)> {
        let data = [
            (&DEPTH, &self.png_depth),
            (&NORMALS, &self.png_normals),
            (&IDS, &self.png_ids),
        ];
        data.into_iter()
            .filter_map(|(format, pattern)| Some((format, pattern.as_ref()?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_in_a_row_do_not_help_to_denoise_each_other() {
        let denoise = DenoiseOptions {
            temporal: 2,
            filter: Default::default(),
        };
        let sequence = Request {
            denoise: Some(denoise),
            ..Request::default()
        };
        let views = Request {
            views: Some(Views {
                sets: Vec::new(),
                fit: 1.0,
            }),
            ..sequence.clone()
        };
        let temporal = |request: &Request| request.denoising().map(|options| options.temporal);
        assert_eq!([temporal(&sequence), temporal(&views)], [Some(2), Some(0)]);
    }
}
