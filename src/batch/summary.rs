//! The summary of a finished job.

use std::time::Duration;

use super::FrameFailure;
use crate::{geometry::Geometry, math::sorting, render::InvalidSamples};

/// The summary of a finished job.
#[derive(Debug, Default)]
pub struct Summary {
    /// The number of rendered frames, including those that could not be written.
    pub rendered: usize,
    /// The failed frames.
    pub failures: Vec<FrameFailure>,
    /// The number of skipped frames.
    pub skipped: usize,
    /// The number of frames that this job has written: where it denoises them, the denoised ones.
    pub written: usize,
    /// Those among them that were denoised without a frame beside them, which failed.
    pub unhelped: usize,
    /// Frames of other jobs that would have helped to denoise those of this one, and are not there.
    pub missing: Vec<i32>,
    /// The frames of this job that they would have helped.
    pub unfinished: Vec<i32>,
    /// Frames of other jobs that were denoised before this one rendered frames that help them.
    pub outdated: Vec<i32>,
    /// Rendering time of each frame, in order.
    pub frame_times: Vec<Duration>,
    /// The time from the first ray to the last file.
    pub wall: Duration,
    /// The number of traced rays, including shadow rays.
    pub rays: u64,
    /// The number of samples of all frames.
    pub samples: u64,
    /// The samples with NaN or infinite values, which were left out, for each frame that has any.
    pub invalid: Vec<(i32, InvalidSamples)>,
    /// The numbers in files beyond the range of halves, and the NaNs.
    pub clamped: u64,
    pub scene: SceneFigures,
}

/// The size of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneFigures {
    /// The number of stored triangles.
    pub triangles: usize,
    /// The number of primitives that are no triangles.
    pub shapes: usize,
    pub instances: usize,
    /// The number of primitives, counting those of instances separately.
    pub instanced_primitives: u64,
    /// The time for building the acceleration structure; `None` if no frame needed one.
    pub build_time: Option<Duration>,
}

impl SceneFigures {
    pub(super) fn new(geometry: &Geometry, build_time: Option<Duration>) -> Self {
        Self {
            triangles: geometry.triangles.len(),
            shapes: geometry.shapes.len(),
            instances: geometry.instances.len(),
            instanced_primitives: geometry.instanced_prim_count(),
            build_time,
        }
    }
}

impl Summary {
    /// The median and the longest rendering time of a frame.
    pub fn median_and_worst(&self) -> Option<(Duration, Duration)> {
        let mut sorted = self.frame_times.clone();
        sorting::sort_by(&mut sorted, Ord::cmp);
        Some((*sorted.get(sorted.len() / 2)?, *sorted.last()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle_of_the_sorted_times() {
        let of = |ms: &[u64]| Summary {
            frame_times: ms.iter().map(|&m| Duration::from_millis(m)).collect(),
            ..Summary::default()
        };
        assert_eq!(of(&[]).median_and_worst(), None);
        let expected = (Duration::from_millis(2), Duration::from_millis(9));
        assert_eq!(of(&[9, 1, 2]).median_and_worst(), Some(expected));
    }
}
