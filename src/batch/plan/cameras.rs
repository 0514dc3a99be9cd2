//! The cameras of the frames of a job.

use std::{collections::BTreeSet, ops::RangeInclusive, path::Path};

use super::{
    frame_rate::fps,
    path_columns::{check_columns, is_of_pose, replacing, warn_of_columns, warn_of_lens},
    range::{MAX_FRAME, MAX_FRAMES},
    view_cameras::ViewCameras,
};
use crate::{
    assets::{Files, camera_path},
    batch::{FrameRange, Request, Turn},
    camera::{
        Camera, FilmSize, FrameCamera, Lens, Neighbours, PictureCamera, SceneCamera, StereoEye, Timing,
        path::{CameraPath, PathError},
    },
    compile::{self, default_scene::ModelRun},
    describe::{FrameTime, MovingDesc, SceneDesc, Values},
    error::Error,
    math::{DAabb, DVec3, sorting},
    warnings::{WarningKind, Warnings},
};

/// The longer side of the metered picture, in pixels.
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
    /// Those of the second eyes of these frames, where a picture shows both.
    pub seconds: Vec<FrameCamera>,
    /// Those of the frames that are not rendered and help to denoise others.
    pub beside: Vec<(i32, FrameCamera)>,
    /// The frames without a range.
    pub extent: RangeInclusive<i64>,
    /// The first frame, whichever frames are rendered.
    pub first_frame: f64,
    /// The first position of the camera, in m.
    pub first_eye: Option<DVec3>,
    /// The first camera, whichever frames are rendered, for the picture that is metered.
    pub metering: Option<FrameCamera>,
    /// Whether every point of the picture has a camera ray, in all frames, whichever are rendered.
    pub fills_film: bool,
    /// The camera path, until the eyes of its frames are known.
    path: Option<CameraPath>,
}

/// The cameras of the frames to be rendered: those of an eye if the request names one.
pub(in crate::batch) fn cameras(
    desc: &SceneDesc,
    request: &Request,
    values: (Option<&Values>, Option<&ModelRun>),
    own: (Option<SceneCamera>, [u32; 2], Option<DAabb>),
    inputs: &Files,
) -> Result<JobCameras, Error> {
    let mut cameras = middle_cameras(desc, request, values, own, inputs)?;
    let path = cameras.path.take();
    let of_eye = |frame: i32, camera: &FrameCamera, eye: &StereoEye| {
        let refused = |why| Error::Usage(format!("--stereo: {why}"));
        let of_path = path.as_ref().map(|path| path.eye_at(f64::from(frame), eye));
        camera.of_eye(of_path.as_ref().unwrap_or(eye)).map_err(refused)
    };
    if let Some(second) = &request.second_eye {
        let frames = cameras.frames.iter();
        let seconds = frames.map(|(frame, camera)| of_eye(*frame, camera, &second.eye));
        cameras.seconds = seconds.collect::<Result<_, _>>()?;
    }
    if let Some(eye) = &request.stereo {
        for (frame, camera) in cameras.frames.iter_mut().chain(&mut cameras.beside) {
            *camera = of_eye(*frame, camera, eye)?;
        }
    }
    Ok(cameras)
}

/// The cameras in the middle between the eyes.
fn middle_cameras(
    desc: &SceneDesc,
    request: &Request,
    (values, run): (Option<&Values>, Option<&ModelRun>),
    (scene_camera, resolution, bounds): (Option<SceneCamera>, [u32; 2], Option<DAabb>),
    inputs: &Files,
) -> Result<JobCameras, Error> {
    if let Some(views) = &request.views {
        let unknown = || Error::Usage("--views: the bounds of the scene are not known".to_owned());
        let bounds = bounds.ok_or_else(unknown)?;
        refuse_camera_values(values, is_of_pose, "the views")?;
        let first = scene_camera.ok_or_else(|| no_camera(desc))?;
        let views = ViewCameras::new(views, bounds, first, resolution)?;
        let own = OwnCamera::new(desc, (values, None, fps(request)), scene_camera);
        return of_views(request, (&views, &own), (desc.timing, resolution));
    }
    let own = OwnCamera::new(desc, (values, run, fps(request)), scene_camera);
    let Some(file) = &request.camera_path else {
        let of_table = values.and_then(Values::frames);
        let (all, what) = match (request.turntable, run.and_then(|run| run.end), of_table) {
            (Some(Turn { frames, .. }), ..) => (
                1..=i64::from(frames),
                format!("the turntable, which has frames 1 to {frames}"),
            ),
            (None, Some(end), _) => (0..=last_frame(end, fps(request)), "the animations".to_owned()),
            (None, None, Some(frames)) => (frames, "the table of values".to_owned()),
            (None, None, None) => (1..=1, "the scene's own camera, which has frame 1 only".to_owned()),
        };
        if request.turntable.is_some() {
            refuse_camera_values(values, |_| true, "the turntable")?;
        }
        let first = *all.start() as f64;
        let camera = own.at(first)?.ok_or_else(|| no_camera(desc))?;
        // Values and poses are held before their first and after their last key.
        let there = match request.turntable {
            None if own.is_among_moving => -MAX_FRAME..=MAX_FRAME,
            _ => all.clone(),
        };
        let frames = frames(request, (&all, &there), &what)?;
        let of = |frame| Ok((number(frame), own.frame_camera(frame as f64, resolution)?));
        return Ok(JobCameras {
            frames: frames.iter().map(of).collect::<Result<_, Error>>()?,
            seconds: Vec::new(),
            beside: beside(request, &frames, &there)
                .into_iter()
                .map(of)
                .collect::<Result<_, Error>>()?,
            first_frame: first,
            first_eye: scene_camera.map(|camera| camera.pose.eye()),
            metering: Some(FrameCamera::from(Camera::new(
                &camera.pose,
                &camera.lens,
                metered_resolution(resolution),
            ))),
            fills_film: own.fills_film(&all, resolution),
            extent: all,
            path: None,
        });
    };
    let options = request.path_options(scene_camera.map(|camera| camera.pose));
    let path = camera_path::load(file, None, &options, inputs)?.with_scene_timing(desc.timing);
    let all = path.frames();
    let what = format!("the camera path, which has frames {} to {}", all.start(), all.end());
    let lens = scene_camera.map_or_else(Lens::default, |c| c.lens);
    check_columns(file, &path, &lens)?;
    warn_of_columns(file, &path, request);
    warn_of_lens(file, &path, &lens, request);
    for (name, table) in values.into_iter().flat_map(Values::of_camera) {
        let keys: Vec<&str> = name.split('.').collect();
        if let Some(other) = replacing(&keys, &path) {
            return Err(Error::SetTwice {
                path: table.clone(),
                name: name.to_owned(),
                other,
                is_drawn: values.is_some_and(|values| values.draws(name)),
            });
        }
    }
    let first_eye = path.at(path.first()).ok().map(|first| first.pose.eye());
    let first = *all.start();
    let lens_at = |frame: f64| match own.at(frame) {
        Ok(camera) => Ok(camera.map_or_else(Lens::default, |c| c.lens)),
        Err(error) => Err(NoFrameCamera::Lens(error)),
    };
    let metering = match path.frame_camera(first as f64, lens_at, metered_resolution(resolution)) {
        Err(NoFrameCamera::Lens(error)) => return Err(error),
        camera => camera.ok(),
    };
    // A lens without distortion at the keys of the path has none between them.
    let fills_film = {
        let times: Box<dyn Iterator<Item = f64>> = match own.moving.is_some() {
            true => Box::new(counted(&all)),
            false => Box::new(path.keys()),
        };
        let mut cameras = times.filter_map(|time| {
            let state = path.at(time).ok()?;
            let lens = lens_at(state.frame).ok()?;
            Some(state.camera(&lens, resolution))
        });
        cameras.all(|camera| camera.fills_film())
    };
    let frames = match (path.pictures(), &request.range) {
        (Some(pictures), None) => FrameRange::of(pictures.iter().copied()),
        _ => frames(request, (&all, &all), &what)?,
    };
    let of = |frame: i64| {
        let camera = path.frame_camera(frame as f64, lens_at, resolution);
        camera
            .map(|camera| (number(frame), camera))
            .map_err(|error| match error {
                NoFrameCamera::Path(cause) => Error::Pose { frame, cause },
                NoFrameCamera::Lens(error) => error,
            })
    };
    Ok(JobCameras {
        frames: frames.iter().map(of).collect::<Result<_, _>>()?,
        seconds: Vec::new(),
        // The job does not need those that have no camera.
        beside: beside(request, &frames, &all)
            .into_iter()
            .filter_map(|frame| of(frame).ok())
            .collect(),
        first_frame: *all.start() as f64,
        extent: all,
        first_eye,
        metering,
        fills_film,
        path: Some(path),
    })
}

/// The cameras of views, which rest, with the lens of the scene's own camera at their frames.
fn of_views(
    request: &Request,
    (views, own): (&ViewCameras, &OwnCamera<'_>),
    (timing, resolution): (Timing, [u32; 2]),
) -> Result<JobCameras, Error> {
    let all = views.frames();
    let what = format!("the views, which are frames {} to {}", all.start(), all.end());
    let frames = frames(request, (&all, &all), &what)?;
    let view = |frame: i64| {
        let own = own.at(frame as f64)?;
        views.camera(frame, own.map(|own| own.lens).as_ref())
    };
    let of = |frame: i64| {
        let SceneCamera { pose, lens } = view(frame)?;
        let camera = FrameCamera::from(Camera::new(&pose, &lens, resolution));
        Ok::<_, Error>((number(frame), camera.with_timing(timing)))
    };
    let first = view(*all.start())?;
    let metered = Camera::new(&first.pose, &first.lens, metered_resolution(resolution));
    Ok(JobCameras {
        frames: frames.iter().map(of).collect::<Result<_, _>>()?,
        seconds: Vec::new(),
        beside: beside(request, &frames, &all)
            .into_iter()
            .map(of)
            .collect::<Result<_, _>>()?,
        first_frame: *all.start() as f64,
        fills_film: own.fills_film(&all, resolution),
        extent: all,
        first_eye: Some(first.pose.eye()),
        metering: Some(FrameCamera::from(metered)),
        path: None,
    })
}

fn no_camera(desc: &SceneDesc) -> Error {
    let path = desc.source.path.clone();
    Error::NoCamera { path }
}

/// Refuses values of the camera over time, those whose name `is_one`, where `other` moves it.
fn refuse_camera_values(values: Option<&Values>, is_one: fn(&str) -> bool, other: &str) -> Result<(), Error> {
    match values.and_then(|values| values.of_camera().find(|(name, _)| is_one(name))) {
        None => Ok(()),
        Some((name, table)) => Err(Error::SetTwice {
            path: table.clone(),
            name: name.to_owned(),
            other: other.to_owned(),
            is_drawn: values.is_some_and(|values| values.draws(name)),
        }),
    }
}

/// The first frame at or after `end`, in s, whose time in single precision reaches it.
fn last_frame(end: f64, fps: f64) -> i64 {
    let last = (end * fps).ceil().clamp(0.0, MAX_FRAME as f64);
    let reaches = |frame: f64| frame / fps >= end || (frame / fps) as f32 >= end as f32;
    if last > 0.0 && reaches(last - 1.0) {
        last as i64 - 1
    } else {
        last as i64
    }
}

/// Warns if the model of the lens has no rays for a part of the picture.
pub(in crate::batch) fn warn_of_missing_part(camera: &FrameCamera, resolution: FilmSize, warnings: &Warnings) {
    let part = camera.camera(0.0).missing_part(resolution);
    if part > 0.0 {
        let percent = (100.0 * part).max(0.1);
        let text =
            format!("the distortion of the camera has no ray for {percent:.1} % of the picture, which is empty there");
        warnings.add(WarningKind::EMPTY_PART, "camera", text);
    }
}

/// Why a frame of a camera path has no camera.
enum NoFrameCamera {
    Path(PathError),
    /// A value of the scene's lens is wrong.
    Lens(Error),
}

impl From<PathError> for NoFrameCamera {
    fn from(error: PathError) -> Self {
        Self::Path(error)
    }
}

/// The camera of a model by itself that moves with its node.
struct MovedCamera<'a> {
    run: &'a ModelRun,
    fps: f64,
    desc: &'a SceneDesc,
    /// The values of the model over time.
    parts: Option<MovingDesc<'a>>,
}

impl MovedCamera<'_> {
    /// The camera at a time, if it is not degenerate then.
    fn at(&self, time: FrameTime) -> Option<SceneCamera> {
        let of_values = self.parts.as_ref().and_then(|parts| parts.object(0, time));
        let object = of_values.as_ref().or(self.desc.objects.first());
        let parts = object.map(|object| object.parts.clone()).unwrap_or_default();
        self.run.camera(time.time / self.fps, &parts)?.compile().ok()
    }
}

/// The scene's own camera, whose values may change over time.
pub(in crate::batch) struct OwnCamera<'a> {
    run: Option<MovedCamera<'a>>,
    still: Option<SceneCamera>,
    timing: Timing,
    /// Whether other values of the scene change over time.
    is_among_moving: bool,
    moving: Option<MovingDesc<'a>>,
    /// The scene file.
    path: &'a Path,
}

impl<'a> OwnCamera<'a> {
    pub fn new(
        desc: &'a SceneDesc,
        (values, run, fps): (Option<&'a Values>, Option<&'a ModelRun>, f64),
        still: Option<SceneCamera>,
    ) -> Self {
        let of_camera = values.filter(|values| values.of_camera().next().is_some());
        Self {
            run: run.filter(|run| run.moves_camera()).map(|run| MovedCamera {
                run,
                fps,
                desc,
                parts: values.map(|values| MovingDesc::new(desc, values)),
            }),
            still,
            timing: desc.timing,
            is_among_moving: values.is_some() || compile::plays_animations(desc),
            moving: of_camera.map(|values| MovingDesc::new(desc, values)),
            path: &desc.source.path,
        }
    }

    /// The camera at a time.
    pub fn at(&self, time: impl Into<FrameTime>) -> Result<Option<SceneCamera>, Error> {
        let time = time.into();
        match (&self.moving, &self.run) {
            // Values take the place of the node.
            (Some(moving), _) => moving.camera(time).map_err(Error::Invalid),
            (None, Some(run)) => Ok(run.at(time).or(self.still)),
            (None, None) => Ok(self.still),
        }
    }

    /// Whether every point of a picture of this size has a camera ray in all these frames.
    fn fills_film(&self, frames: &RangeInclusive<i64>, film: FilmSize) -> bool {
        let fills = |time: f64| match self.at(time) {
            Ok(Some(camera)) => Camera::new(&camera.pose, &camera.lens, film).fills_film(),
            Ok(None) | Err(_) => true,
        };
        // Only values change the lens.
        match self.moving {
            Some(_) => counted(frames).all(fills),
            None => fills(*frames.start() as f64),
        }
    }

    /// The camera of a frame. Where the scene moves, it has those of the frames around it beside it.
    ///
    /// # Errors
    /// The scene has no camera, or values of it are wrong.
    pub fn frame_camera(&self, frame: f64, film: FilmSize) -> Result<FrameCamera, Error> {
        let at = |time: FrameTime| {
            let camera = self.at(time)?.ok_or_else(|| Error::NoCamera {
                path: self.path.to_owned(),
            })?;
            Ok::<_, Error>(Camera::new(&camera.pose, &camera.lens, film))
        };
        let timing = self.timing;
        let moves = (self.moving.is_some() || self.run.is_some()) && timing.duration() > 0.0;
        // The camera while the picture of a frame is taken, or as its shutter opens.
        let taken = |frame: f64, at_opening: bool| {
            let time = |u: f64| FrameTime {
                time: frame + (timing.shutter.open + timing.duration() * u),
                frame: frame.floor() as i64,
            };
            match moves && !at_opening {
                true => PictureCamera::moving(|u| at(time(u))),
                false => at(time(0.0)).map(PictureCamera::from),
            }
        };
        let camera = FrameCamera::from(taken(frame, false)?).with_timing(timing);
        if !self.is_among_moving {
            return Ok(camera);
        }
        let neighbour = |by: f64| taken(frame + by, timing.readout.is_global()).map(Some);
        let (previous, next) = (neighbour(-1.0)?, neighbour(1.0)?);
        Ok(camera.with_neighbours(Neighbours { previous, next }))
    }
}

/// The times of the first [`MAX_FRAMES`] of these frames.
fn counted(frames: &RangeInclusive<i64>) -> impl Iterator<Item = f64> + use<> {
    frames.clone().take(MAX_FRAMES).map(|frame| frame as f64)
}

/// The frames of the sequence that are not asked for and help to denoise those that are.
fn beside(request: &Request, frames: &FrameRange, all: &RangeInclusive<i64>) -> BTreeSet<i64> {
    let reach = match request.denoising() {
        Some(options) if request.range.is_some() => i64::from(options.temporal),
        _ => 0,
    };
    let near = frames.iter().flat_map(|frame| frame - reach..=frame + reach);
    sorting::ordered(near.filter(|frame| all.contains(frame) && !frames.contains(*frame)))
}

/// The frames that were asked for, all of them `there`; `all` of them if none were asked for.
fn frames(
    request: &Request,
    (all, there): (&RangeInclusive<i64>, &RangeInclusive<i64>),
    what: &str,
) -> Result<FrameRange, Error> {
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
    match range.iter().find(|f| !there.contains(f)) {
        Some(outside) => Err(Error::Usage(format!("--range: frame {outside} is outside of {what}"))),
        None => Ok(range.clone()),
    }
}

/// Frames lie within [`MAX_FRAME`], which is less than 2^31.
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

    #[test]
    fn a_run_ends_at_the_first_frame_that_reaches_its_last_key() {
        for frames in 0..2000_u32 {
            // The time of a key in a file.
            let end = f64::from((f64::from(frames) / 24.0) as f32);
            assert_eq!(super::last_frame(end, 24.0), i64::from(frames));
        }
        assert_eq!(super::last_frame(1.01, 24.0), 25);
        assert_eq!(super::last_frame(1e9, 24.0), super::MAX_FRAME);
    }
}
