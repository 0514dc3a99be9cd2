//! The events of a job while it runs.

use std::{path::Path, time::Duration};

use serde::{Serialize, Serializer};

use super::{FrameFailure, Stale, as_text};
use crate::output::FrameImage;

/// An event of a job, in the order in which they come. Each frame ends with `FrameSkipped`, `FrameFailed` or `FrameWritten`: where
/// the job denoises its frames, once their denoised files are there. Its serialization is a line of `--progress json` but
/// for the scene, see docs/farm.md.
#[derive(Clone, Copy, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum JobEvent<'a> {
    /// A frame starts, the `index`th of `total` from 0.
    FrameStarted { frame: i32, index: usize, total: usize },
    /// A frame is rendered; its files are not yet written.
    FrameRendered {
        frame: i32,
        #[serde(rename = "seconds", serialize_with = "seconds")]
        took: Duration,
    },
    /// The files of a frame are there already as the job would write them.
    FrameSkipped { frame: i32 },
    /// A file of a frame is there, yet not as the job would write it: the frame is rendered again.
    FrameStale {
        frame: i32,
        #[serde(flatten)]
        stale: &'a Stale,
    },
    /// A frame failed; the job continues with the others.
    FrameFailed(&'a FrameFailure),
    /// A limit of time has left a frame with so many samples of each pixel.
    FrameCutShort { frame: i32, samples: u32 },
    /// The picture of a frame that is going to be written.
    #[serde(skip)]
    FrameImage { frame: i32, image: &'a FrameImage<'a> },
    /// A file is on disk.
    FileWritten {
        frame: i32,
        #[serde(serialize_with = "as_text::path")]
        file: &'a Path,
    },
    /// The fingerprint of the denoised files of a frame, which follow or are there already.
    #[serde(skip)]
    DenoisedFingerprint { frame: i32, fingerprint: &'a str },
    /// A denoised file is on disk.
    FrameDenoised {
        frame: i32,
        #[serde(serialize_with = "as_text::path")]
        file: &'a Path,
    },
    /// All files of a frame are on disk.
    FrameWritten { frame: i32 },
}

/// Receives the events of a job, from several threads.
pub trait Observer: Sync {
    fn event(&self, event: &JobEvent<'_>);
}

fn seconds<S: Serializer>(time: &Duration, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(time.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::batch::{FrameError, StaleReason};

    #[test]
    fn events_are_the_lines_that_programs_read() {
        let stale = Stale {
            path: PathBuf::from("f.exr"),
            reason: StaleReason::Missing,
        };
        let failure = FrameFailure {
            frame: 3,
            cause: FrameError::Panic("no".to_owned()),
        };
        let (frame, index, total, file) = (3, 0, 9, Path::new("f.exr"));
        let took = Duration::from_millis(1500);
        for (event, line) in [
            (
                JobEvent::FrameStarted { frame, index, total },
                r#"{"event":"frame_started","frame":3,"index":0,"total":9}"#,
            ),
            (
                JobEvent::FrameRendered { frame, took },
                r#"{"event":"frame_rendered","frame":3,"seconds":1.5}"#,
            ),
            (
                JobEvent::FrameSkipped { frame },
                r#"{"event":"frame_skipped","frame":3}"#,
            ),
            (
                JobEvent::FrameStale { frame, stale: &stale },
                r#"{"event":"frame_stale","file":"f.exr","frame":3,"reason":"is missing"}"#,
            ),
            (
                JobEvent::FrameFailed(&failure),
                r#"{"event":"frame_failed","frame":3,"reason":"it panicked: no"}"#,
            ),
            (
                JobEvent::FrameCutShort { frame, samples: 7 },
                r#"{"event":"frame_cut_short","frame":3,"samples":7}"#,
            ),
            (
                JobEvent::FileWritten { frame, file },
                r#"{"event":"file_written","file":"f.exr","frame":3}"#,
            ),
            (
                JobEvent::FrameDenoised { frame, file },
                r#"{"event":"frame_denoised","file":"f.exr","frame":3}"#,
            ),
            (
                JobEvent::FrameWritten { frame },
                r#"{"event":"frame_written","frame":3}"#,
            ),
        ] {
            let value = serde_json::to_value(event).expect("plain data");
            assert_eq!(value.to_string(), line);
        }
    }
}
