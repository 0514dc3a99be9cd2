//! The figures of a finished job.

use std::time::Duration;

use super::FrameFailure;
use crate::{geometry::Geometry, render::InvalidSamples};

/// The figures of a finished job.
#[derive(Debug, Default)]
pub struct Summary {
    /// Frames rendered, whether they could be written or not.
    pub rendered: usize,
    /// The frames that are not on disk though they were to be.
    pub failures: Vec<FrameFailure>,
    /// Frames left out because their files were whole.
    pub skipped: usize,
    /// Rendering time of each frame, in order.
    pub frame_times: Vec<Duration>,
    /// From the first ray to the last file.
    pub wall: Duration,
    /// Rays traced for nearest hits and for shadows.
    pub rays: u64,
    /// Samples of all frames.
    pub samples: u64,
    /// Samples that came out as NaN or infinite, and were left out, of each frame that has such.
    pub invalid: Vec<(i32, InvalidSamples)>,
    /// Numbers beyond what a half float holds, and NaNs, in the files.
    pub clamped: u64,
    pub scene: SceneFigures,
}

/// The size of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneFigures {
    /// Triangles that are stored.
    pub triangles: usize,
    /// Primitives that are no triangles.
    pub shapes: usize,
    pub instances: usize,
    /// All primitives, those of instanced meshes once for each instance.
    pub instanced_primitives: u64,
    /// The time that building the acceleration structure took; `None` where no frame needed one.
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
        sorted.sort();
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
