//! The figures of a job, as they go to files.

use batch_render::warnings::Warning;
use serde::Serialize;

/// All figures.
#[derive(Serialize)]
pub struct Report {
    pub version: &'static str,
    pub command: Vec<String>,
    pub scene: String,
    pub resolution: [u32; 2],
    /// The samples of each pixel; with adaptive sampling the most.
    pub samples: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_samples: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_threshold: Option<f32>,
    pub threads: usize,
    /// The number of frames of the job.
    pub total: usize,
    pub wall_s: f64,
    /// Whether the job has come to its end.
    pub is_finished: bool,
    pub inputs: Vec<Input>,
    pub warnings: Vec<Warning>,
    pub frames: Vec<Frame>,
}

#[derive(Serialize)]
pub struct Input {
    pub path: String,
    pub hash: String,
}

#[derive(Serialize)]
pub struct Frame {
    pub frame: i32,
    pub status: Status,
    /// Why it was rendered again, or failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    pub wall_s: f64,
    /// Processor time of all threads while it rendered, also that of writing the frame before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cpu_s: Option<f64>,
    pub samples: u64,
    /// Those of each pixel, where a limit of time has kept the frame from having all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samples_per_pixel: Option<u32>,
    pub segments: u64,
    pub shadow_rays: u64,
    /// The most that the process has had so far.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_memory_bytes: Option<u64>,
    pub files: Vec<String>,
    pub fingerprint: String,
}

#[derive(Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    Rendering,
    Rendered,
    Written,
    Skipped,
    Failed,
}
