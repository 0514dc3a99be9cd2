//! The cameras of the frames of a job.

use std::{collections::BTreeSet, ops::RangeInclusive, path::Path};

use super::range::MAX_FRAMES;
use crate::{
    assets::{Files, camera_path},
    batch::{FrameRange, Request},
    camera::{Camera, FrameCamera, Lens, SceneCamera, path::CameraPath},
    describe::SceneDesc,
    error::Error,
    math::DVec3,
    warnings::WarningKind,
};

/// The longer side of the metered picture, in pixels, and its samples.
const SIDE: u32 = 96;

/// Columns and rows of the picture that is metered for one of this size.
pub(in crate::batch) fn metered_resolution(full: [u32; 2]) -> [u32; 2] {
    let longer = u64::from(full[0].max(full[1]).max(1));
    full.map(|n| ((u64::from(n) * u64::from(SIDE) / longer) as u32).max(1))
}

/// The cameras of a job.
pub(in crate::batch) struct JobCameras {
    /// The camera of each frame to be rendered, in rising order.
    pub frames: Vec<(i32, FrameCamera)>,
    /// Those of the frames that are not rendered and help to denoise others.
    pub beside: Vec<(i32, FrameCamera)>,
    /// The first frame, whichever frames are rendered.
    pub first_frame: f64,
    /// The first position of the camera, in m.
    pub first_eye: Option<DVec3>,
    /// The first camera, whichever frames are rendered, for the picture that is metered.
    pub metering: Option<FrameCamera>,
}

/// The cameras of the frames to be rendered.
pub(in crate::batch) fn cameras(
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
        let metering = Camera::new(&camera.pose, &camera.lens, metered_resolution(resolution));
        let camera = Camera::new(&camera.pose, &camera.lens, resolution);
        let (last, what) = match request.turntable {
            Some(last) => (last, format!("the turntable, which has frames 1 to {last}")),
            None => (1, "the scene's own camera, which has frame 1 only".to_owned()),
        };
        let all = 1..=i64::from(last);
        let frames = frames(request, all.clone(), &what)?;
        let of = |frame| (number(frame), FrameCamera::from(camera));
        return Ok(JobCameras {
            frames: frames.iter().map(of).collect(),
            beside: beside(request, &frames, &all).into_iter().map(of).collect(),
            first_frame: 1.0,
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
    warn_of_columns(file, &path, request);
    let first_eye = path.at(path.first()).ok().map(|first| first.pose.eye());
    let metering = path
        .frame_camera(*all.start() as f64, &lens, metered_resolution(resolution))
        .ok();
    let frames = frames(request, all.clone(), &what)?;
    let of = |frame: i64| {
        let camera = path.frame_camera(frame as f64, &lens, resolution);
        camera
            .map(|camera| (number(frame), camera))
            .map_err(|cause| Error::Pose { frame, cause })
    };
    Ok(JobCameras {
        frames: frames.iter().map(of).collect::<Result<_, _>>()?,
        // The job does not need those that have no camera.
        beside: beside(request, &frames, &all)
            .into_iter()
            .filter_map(|frame| of(frame).ok())
            .collect(),
        first_frame: *all.start() as f64,
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

/// Keys of a camera in scene files, and the columns of a camera path that replace them. A pose replaces its keys always.
const REPLACED: [(&[&str], &[&str]); 6] = [
    (&["eye", "target", "up"], &[]),
    (&["fov", "fov_x", "focal_length"], &["fov", "fov_x", "focal_length"]),
    (&["sensor_width", "sensor_height"], &["sensor_width", "sensor_height"]),
    (&["aperture_radius", "fstop"], &["aperture_radius", "fstop"]),
    (&["focus_distance"], &["focus_distance"]),
    (&["shift"], &["shift_x", "shift_y"]),
];

/// Warns of overrides of the scene's camera that the path replaces again.
fn warn_of_columns(file: &Path, path: &CameraPath, request: &Request) {
    let given: Vec<_> = path.lens_at(path.first()).columns().collect();
    for (origin, keys) in request.overrides.paths() {
        let [camera, _, key, ..] = keys else { continue };
        let row = REPLACED.iter().find(|(keys, _)| keys.contains(&key.as_str()));
        let Some((_, columns)) = row.filter(|_| camera == "camera") else {
            continue;
        };
        let by = match columns.iter().find(|column| given.contains(column)) {
            Some(column) => format!("the column `{column}` of the camera path"),
            None if columns.is_empty() => "the camera path".to_owned(),
            None => continue,
        };
        let text = format!("{origin} has no effect, {by} replaces it: {}", file.display());
        let warnings = &request.warnings;
        warnings.add_topic(WarningKind::UNUSED_SETTING, "columns", origin, text);
    }
}

/// The frames of the sequence that are not asked for and help to denoise those that are.
fn beside(request: &Request, frames: &FrameRange, all: &RangeInclusive<i64>) -> BTreeSet<i64> {
    let reach = match &request.denoise {
        Some(options) if request.range.is_some() => i64::from(options.temporal),
        _ => 0,
    };
    let near = frames.iter().flat_map(|frame| frame - reach..=frame + reach);
    near.filter(|frame| all.contains(frame) && !frames.contains(*frame))
        .collect()
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

#[cfg(test)]
mod tests {
    use super::metered_resolution as resolution;

    #[test]
    fn the_metered_picture_has_the_shape_of_the_whole() {
        assert_eq!(resolution([1920, 1080]), [96, 54]);
        assert_eq!(resolution([3, 3000]), [1, 96]);
        assert_eq!(resolution([16, 16]), [96, 96]);
    }
}
