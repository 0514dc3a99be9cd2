//! Trajectories of the TUM RGB-D benchmark: a line for every pose.
//!
//! `timestamp tx ty tz qx qy qz qw`: seconds, the eye in metres, and the rotation from camera to world. The camera looks along its
//! +z with +y down, as OpenCV's does. `#` begins a comment.
//!
//! With a frame rate a timestamp is the frame `timestamp * fps`, as in `camera_path.csv`; where that is beyond the numbers of
//! frames, as with times of a clock, times count from the first. Without a rate, timestamps that are whole numbers are frames, and
//! otherwise the lines are counted from 1.
//!
//! Source: Sturm et al., "A Benchmark for the Evaluation of RGB-D SLAM Systems", IROS 2012,
//! doi:10.1109/IROS.2012.6385773, "File Formats" of the data set.

use std::fmt::Write as _;

use glam::DVec3;

use super::{
    CameraPathFormat, PathProblem, PathProblems,
    held::{POSES, Target, Written},
    keys::{self, Frames, Posed},
    source::{self, Source, Words},
    still::Still,
};
use crate::camera::path::{CameraPath, MAX_FRAME};

/// The rounding of times, in s, and its largest effect, in frames, as those of `camera_path.csv`.
const ROUNDED_TIME: f64 = 0.5e-3;
const ROUNDED: f64 = 0.05;

pub(super) const FORMAT: CameraPathFormat = CameraPathFormat {
    name: "tum",
    extensions: &["tum", "txt"],
    names: &[],
    read,
    holds: POSES,
    write,
};

fn read(source: &Source<'_>) -> Result<CameraPath, PathProblems> {
    let (mut poses, mut problems) = (Vec::<(f64, Posed)>::new(), PathProblems::default());
    for words in source::lines(source.text()?) {
        match pose(&words) {
            Ok((time, _)) if poses.last().is_some_and(|(before, _)| *before >= time) => {
                let message = format!("{time} comes after {}: times must rise", poses[poses.len() - 1].0);
                problems.push(PathProblem::of_cell(words.line, "timestamp", message));
            }
            Ok(pose) => poses.push(pose),
            Err(problem) => problems.push(problem),
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let times: Vec<f64> = poses.iter().map(|(time, _)| *time).collect();
    let frames = frames(&times, source.options.fps);
    keys::path(
        frames.into_iter().zip(poses).map(|(frame, (_, posed))| (frame, posed)),
        Frames::Way,
    )
}

/// The frames of these times.
fn frames(times: &[f64], fps: Option<f64>) -> Vec<f64> {
    let is_frame = |t: &f64| t.abs() <= MAX_FRAME as f64;
    match (fps, times.first()) {
        (Some(fps), Some(first)) => {
            let start = if times.iter().all(|t| is_frame(&(t * fps))) {
                0.0
            } else {
                *first
            };
            let whole = |frame: f64| {
                let nearest = frame.round();
                let is_near = (frame - nearest).abs() <= ROUNDED.min(ROUNDED_TIME * fps);
                if is_near { nearest } else { frame }
            };
            times.iter().map(|t| whole((t - start) * fps)).collect()
        }
        _ if times.iter().all(|t| t.fract() == 0.0 && is_frame(t)) => times.to_vec(),
        _ => (1..=times.len()).map(|i| i as f64).collect(),
    }
}

fn pose(words: &Words<'_>) -> Result<(f64, Posed), PathProblem> {
    let found = words.words.len();
    if found != 8 {
        return Err(words.problem(format!(
            "the line has {found} words, expected timestamp, tx, ty, tz, qx, qy, qz and qw"
        )));
    }
    let [time, x, y, z] = words.numbers(0, ["timestamp", "tx", "ty", "tz"])?;
    let rotation = words.numbers(4, ["qx", "qy", "qz", "qw"])?;
    let rotation = keys::unit_quaternion(rotation).map_err(|message| words.problem(message))?;
    Ok((time, Posed::of_vision(DVec3::new(x, y, z), rotation)))
}

/// Times are those of the frame rate, and numbers of frames without one.
fn write(target: &Target<'_>, cameras: &[Still]) -> Written {
    let mut text = "# timestamp tx ty tz qx qy qz qw\n".to_owned();
    for camera in cameras {
        write!(text, "{}", camera.frame as f64 / target.fps.unwrap_or(1.0)).expect("a text grows");
        let rotation = camera.vision_rotation().to_array();
        for number in camera.eye.to_array().into_iter().chain(rotation) {
            write!(text, " {}", number + 0.0).expect("a text grows");
        }
        text.push('\n');
    }
    target.file(text)
}

#[cfg(test)]
mod tests {
    use super::frames;

    #[test]
    fn times_are_frames_by_the_rate_by_themselves_or_by_their_order() {
        assert_eq!(frames(&[0.0, 0.5, 1.0], Some(24.0)), [0.0, 12.0, 24.0]);
        assert_eq!(frames(&[1_311_868_164.0, 1_311_868_164.5], Some(30.0)), [0.0, 15.0]);
        assert_eq!(frames(&[3.0, 4.0, 9.0], None), [3.0, 4.0, 9.0]);
        assert_eq!(frames(&[1_311_868_164.25, 1_311_868_164.5], None), [1.0, 2.0]);
        assert!(frames(&[], Some(24.0)).is_empty());
    }
}
