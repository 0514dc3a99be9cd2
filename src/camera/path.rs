//! Camera paths: keys, and the camera at any time between the first and the last of them.
//!
//! A path with a key at every frame is those keys, bit for bit. Where frames are left out, their
//! neighbours are keyframes and the camera moves between them on curves:
//!
//! | what | smooth | linear |
//! |---|---|---|
//! | eye, target, up | centripetal Catmull-Rom, reached at the keys' own times | straight |
//! | rotation as a quaternion | slerp on the shorter arc | the same |
//! | rotation as angles | each angle is a monotone cubic, so 0 to 360 degrees is a full turn | each angle straight |
//! | focal length, also that of an angle | monotone cubic | straight |
//! | roll, the rest of the lens, shutter | monotone cubic | straight |
//!
//! Each optional quantity is a curve through the keys that give it. Before the first and after the
//! last of these keys it is constant. Times before the first or after the last key of the path are
//! errors. The intrinsics of calibrated cameras hold from their key to the next; those of columns are curves.

use std::{mem::discriminant, ops::RangeInclusive};

use glam::{DQuat, DVec3};

use super::{
    Camera, FilmSize, FrameCamera, Lens, LensOverrides, LookAt, Neighbours, Pose, PoseError, RotationOrder,
    frame_camera::PictureCamera,
    pinhole::PinholeLens,
    shutter::{Readout, Shutter, ShutterInterval, Timing},
    stereo::StereoEye,
};
pub use crate::math::track::Interp;
use crate::math::track::{Channel, Track};

mod lens_tracks;

use lens_tracks::LensTracks;

/// Frame numbers lie between minus this and this.
pub const MAX_FRAME: i64 = 1_000_000_000;

/// A rotation from camera to world, as given in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rotation {
    /// Not 0; it is normalized where it is used.
    Quaternion(DQuat),
    /// See [`Pose::from_euler`].
    Euler { degrees: DVec3, order: RotationOrder },
}

impl Rotation {
    /// The order of the angles; `None` for a quaternion.
    fn order(self) -> Option<RotationOrder> {
        match self {
            Self::Quaternion(_) => None,
            Self::Euler { order, .. } => Some(order),
        }
    }
}

/// The orientation of the camera, as given in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Orientation {
    /// See [`LookAt`]; the defaults are +y for `up` and 0 for `roll`.
    Target {
        target: DVec3,
        up: Option<DVec3>,
        roll: Option<f64>,
    },
    Rotation(Rotation),
}

/// One row of a camera path.
#[derive(Clone, Debug, PartialEq)]
pub struct PathKey {
    /// The time, in frames.
    pub frame: f64,
    /// In m.
    pub eye: DVec3,
    pub orientation: Orientation,
    pub lens: LensOverrides,
    /// The intrinsics in pixels, which replace the lens of the scene's camera.
    pub pinhole: Option<PinholeLens>,
    pub shutter: Option<Shutter>,
    /// The time of a sensor's readout, in frames, at least 0.
    pub readout: Option<f64>,
    /// The distance between the eyes of stereo, and that of convergence, in m, above 0.
    pub stereo: [Option<f64>; 2],
    /// The interpolation up to the next key.
    pub interp: Interp,
    /// The name of the shot that begins here, or of the picture.
    pub name: Option<String>,
}

/// The camera at one time of its path.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraState {
    /// The time, in frames.
    pub frame: f64,
    pub pose: Pose,
    /// The distance to the target, in m, on a path with targets.
    pub target_distance: Option<f64>,
    pub lens: LensOverrides,
    pub pinhole: Option<PinholeLens>,
    pub shutter: Option<Shutter>,
    /// The time of a sensor's readout, in frames.
    pub readout: Option<f64>,
    /// The last name at or before this time.
    pub name: Option<String>,
}

impl CameraState {
    /// Returns the lens of the scene's camera with the overrides of the path.
    pub fn apply(&self, scene: &Lens) -> Lens {
        self.base(scene).with_overrides(&self.lens, self.target_distance)
    }

    /// The lens of the scene's camera, or that of the intrinsics of the path in its place.
    pub fn base(&self, scene: &Lens) -> Lens {
        self.pinhole
            .map_or_else(|| self.lens.intrinsics.base(scene), Lens::from)
    }

    /// The intrinsics, if the path has a focal length in pixels.
    pub fn calibrated(&self) -> Option<PinholeLens> {
        self.pinhole.or_else(|| self.lens.intrinsics.lens())
    }

    /// Returns the camera for a film, with the overrides of the path applied to the scene's lens.
    pub fn camera(&self, scene: &Lens, film: FilmSize) -> Camera {
        Camera::new(&self.pose, &self.apply(scene), film)
    }
}

/// An error of a camera path or of a time on it. Times are in frames.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PathError {
    #[error("the camera path has no keys")]
    Empty,
    #[error("frame {0} is not a number between -{MAX_FRAME} and {MAX_FRAME}")]
    FrameNumber(f64),
    #[error("frame {frame} comes after frame {before}: frames must rise")]
    NotRising { frame: f64, before: f64 },
    #[error("frame {frame}: {what} is given in another way than before")]
    Mixed { frame: f64, what: &'static str },
    #[error("frame {frame}: {flaw}")]
    Lens { frame: f64, flaw: &'static str },
    #[error("frame {frame}: {source}")]
    Pose { frame: f64, source: PoseError },
    #[error("frame {frame} is outside of the camera path, which goes from {first} to {last}")]
    Outside { frame: f64, first: f64, last: f64 },
}

#[derive(Clone, Debug, PartialEq)]
enum OrientationTrack {
    Target {
        target: Track<DVec3>,
        up: Track<DVec3>,
        roll: Track<f64>,
    },
    Quaternion(Track<DQuat>),
    Euler {
        /// The angles about x, y and z, in degrees.
        angles: [Track<f64>; 3],
        order: RotationOrder,
    },
}

/// The motion of a camera through keys.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    first: f64,
    last: f64,
    eye: Track<DVec3>,
    orientation: OrientationTrack,
    lens: LensTracks,
    /// By the frame from which on they hold.
    pinholes: Vec<(f64, PinholeLens)>,
    shutter: Track<Shutter>,
    readout: Track<f64>,
    /// The distance between the eyes, and that of convergence, in m.
    stereo: [Track<f64>; 2],
    /// The timing where no key gives one.
    scene_timing: Timing,
    /// The times at which the camera jumps: those of the keys that follow a held one.
    cuts: Vec<f64>,
    /// By the frame from which on they hold.
    names: Vec<(f64, String)>,
    /// The frames of the keys, if these are pictures and nothing between them is meant.
    pictures: Option<Vec<i64>>,
}

impl CameraPath {
    /// The path through `keys`.
    ///
    /// # Errors
    /// There are no keys, frames do not rise or are out of range, keys face in different ways or
    /// say the view, the sensor or the aperture in different ways, a key gives no pose or no lens.
    pub fn new(keys: &[PathKey]) -> Result<Self, PathError> {
        let (Some(first), Some(last)) = (keys.first(), keys.last()) else {
            return Err(PathError::Empty);
        };
        check(keys)?;
        let lenses: Vec<_> = keys.iter().map(|k| (k.frame, k.lens, k.interp)).collect();
        let path = Self {
            first: first.frame,
            last: last.frame,
            eye: track(keys, |k| Some(k.eye)),
            orientation: orientation_track(keys),
            lens: LensTracks::new(&lenses),
            pinholes: held(keys, |k| k.pinhole),
            shutter: track(keys, |k| k.shutter),
            readout: track(keys, |k| k.readout),
            stereo: [0, 1].map(|i| track(keys, |k| k.stereo[i])),
            scene_timing: Timing::default(),
            cuts: keys
                .iter()
                .zip(&keys[1..])
                .filter(|(a, _)| a.interp == Interp::Step)
                .map(|(_, b)| b.frame)
                .collect(),
            names: held(keys, |k| k.name.clone()),
            pictures: None,
        };
        keys.iter().try_for_each(|k| path.pose(k.frame).map(drop))?;
        Ok(path)
    }

    /// Returns this path with the timing of the scene's camera, where no key gives one.
    pub fn with_scene_timing(self, scene_timing: Timing) -> Self {
        Self { scene_timing, ..self }
    }

    /// Returns this path as that of the pictures at `frames`, between which nothing is meant.
    pub fn of_pictures(self, frames: Vec<i64>) -> Self {
        let pictures = Some(frames);
        Self { pictures, ..self }
    }

    /// The frames of the pictures, in rising order, if the path is that of pictures.
    pub fn pictures(&self) -> Option<&[i64]> {
        self.pictures.as_deref()
    }

    /// The frames of the keys.
    pub fn keys(&self) -> impl Iterator<Item = f64> {
        self.eye.times()
    }

    /// Whether it has intrinsics that replace the lens of any scene.
    pub fn is_calibrated(&self) -> bool {
        !self.pinholes.is_empty() || self.lens_at(self.first).intrinsics.lens().is_some()
    }

    /// The sizes of the pictures for which the intrinsics of its keys hold, in pixels.
    pub fn sizes(&self) -> impl Iterator<Item = [f64; 2]> {
        let of_columns = self.keys().filter_map(|frame| self.lens_at(frame).intrinsics.size());
        self.pinholes.iter().filter_map(|(_, lens)| lens.size).chain(of_columns)
    }

    /// The place of an eye at a time in frames, by the distances of the path where it has them.
    pub fn eye_at(&self, frame: f64, eye: &StereoEye) -> StereoEye {
        let [ipd, convergence] = self.stereo.each_ref().map(|track| track.at(frame));
        StereoEye {
            offset: ipd.map_or(eye.offset, |ipd| (0.5 * ipd).copysign(eye.offset)),
            convergence: convergence.or(eye.convergence),
        }
    }

    /// The time of the first key, in frames.
    pub fn first(&self) -> f64 {
        self.first
    }

    /// The time of the last key, in frames.
    pub fn last(&self) -> f64 {
        self.last
    }

    /// All whole frames from the first key to the last; empty where both lie between the same two
    /// frames.
    pub fn frames(&self) -> RangeInclusive<i64> {
        // Whole numbers within MAX_FRAME.
        self.first.ceil() as i64..=self.last.floor() as i64
    }

    /// The camera at a time, in frames.
    ///
    /// # Errors
    /// The time is outside of the path, or the curves of eye and target meet there.
    pub fn at(&self, frame: f64) -> Result<CameraState, PathError> {
        if !(self.first..=self.last).contains(&frame) {
            return Err(PathError::Outside {
                frame,
                first: self.first,
                last: self.last,
            });
        }
        let (pose, target_distance) = self.pose(frame)?;
        Ok(CameraState {
            frame,
            pose,
            target_distance,
            lens: self.lens_at(frame),
            pinhole: last(&self.pinholes, frame).copied(),
            shutter: self.shutter.at(frame),
            readout: self.readout.at(frame),
            name: last(&self.names, frame).cloned(),
        })
    }

    /// Returns the lens overrides at a time in frames. A parameter that any key gives is given at
    /// all times.
    pub fn lens_at(&self, frame: f64) -> LensOverrides {
        self.lens.at(frame)
    }

    /// The times that the picture of `frame` sees, by the path's own shutter or, where it has none, by `otherwise`. They depend on the
    /// path and the frame alone, not on which frames are rendered. A picture belongs to one shot: the camera stands still before the
    /// first key and after the last one, beyond a cut, and in a picture of [`CameraPath::pictures`].
    ///
    /// # Errors
    /// As those of [`CameraPath::at`].
    fn shutter_interval(&self, frame: f64, otherwise: Timing) -> Result<ShutterInterval, PathError> {
        let state = self.at(frame)?;
        let timing = Timing {
            shutter: state.shutter.unwrap_or(otherwise.shutter),
            readout: Readout {
                time: state.readout.unwrap_or(otherwise.readout.time),
                ..otherwise.readout
            },
        };
        let is_picture = |pictures: &[i64]| frame.fract() == 0.0 && pictures.binary_search(&(frame as i64)).is_ok();
        let next = self.cuts.partition_point(|cut| *cut <= frame);
        Ok(ShutterInterval {
            frame,
            timing,
            begin: next.checked_sub(1).map_or(self.first, |i| self.cuts[i]),
            end: self.cuts.get(next).map_or(self.last, |cut| cut.next_down()),
            rests: self.pictures().is_some_and(is_picture),
        })
    }

    /// Returns the camera of `frame`, which may lie between two frames, while the shutter is open, with
    /// the lens of the scene, which is `lens(time)` at a time in frames, and the overrides of the path.
    ///
    /// # Errors
    /// As those of [`CameraPath::at`], and those of `lens`.
    pub fn frame_camera<E: From<PathError>>(
        &self,
        frame: f64,
        lens: impl Fn(f64) -> Result<Lens, E>,
        film: FilmSize,
    ) -> Result<FrameCamera, E> {
        // The camera while the picture of an interval is taken, or as its shutter opens.
        let taken = |interval: &ShutterInterval, at_opening: bool| {
            let camera = |u: f64| {
                let state = self.at(interval.time(u))?;
                Ok::<_, E>(state.camera(&lens(state.frame)?, film))
            };
            match at_opening || interval.time(0.0) == interval.time(1.0) {
                true => Ok(PictureCamera::from(camera(0.0)?)),
                false => PictureCamera::moving(camera),
            }
        };
        let interval = self.shutter_interval(frame, self.scene_timing)?;
        let open = interval.timing.shutter.open;
        // The camera of the frame that comes `by` frames later, and the time from this frame until its shutter opens.
        let neighbour = |by: f64| {
            // Nothing moves over a cut.
            let is_same_shot = (interval.begin..=interval.end).contains(&(frame + by));
            let its = self.shutter_interval(frame + by, self.scene_timing).ok();
            let seen = its.filter(|its| is_same_shot && self.at(its.time(0.0)).is_ok());
            let camera = seen.map(|its| taken(&its, its.timing.readout.is_global()));
            Ok::<_, E>((
                camera.transpose()?,
                its.map_or(open, |its| its.timing.shutter.open) + by,
            ))
        };
        let ((previous, before), (next, after)) = (neighbour(-1.0)?, neighbour(1.0)?);
        Ok(FrameCamera::from(taken(&interval, false)?)
            .with_timing(interval.timing)
            .with_openings_around(before, after)
            .with_neighbours(Neighbours { previous, next }))
    }

    /// The pose, and the distance to the target in m where there is one.
    fn pose(&self, frame: f64) -> Result<(Pose, Option<f64>), PathError> {
        let eye = self.eye.at(frame).expect("every key has an eye");
        let posed = match &self.orientation {
            OrientationTrack::Target { target, up, roll } => {
                let at = LookAt {
                    target: target.at(frame).expect("every key has a target"),
                    up: up.at(frame).unwrap_or(DVec3::Y),
                    roll: roll.at(frame).unwrap_or(0.0),
                };
                Pose::look_at(eye, &at).map(|pose| (pose, Some(eye.distance(at.target))))
            }
            OrientationTrack::Quaternion(rotation) => {
                let rotation = rotation.at(frame).expect("every key has a quaternion");
                Pose::from_quaternion(eye, rotation).map(|pose| (pose, None))
            }
            OrientationTrack::Euler { angles, order } => {
                let [x, y, z] = angles.each_ref().map(|a| a.at(frame).expect("every key has angles"));
                Pose::from_euler(eye, DVec3::new(x, y, z), *order).map(|pose| (pose, None))
            }
        };
        posed.map_err(|source| PathError::Pose { frame, source })
    }
}

fn check(keys: &[PathKey]) -> Result<(), PathError> {
    let limit = MAX_FRAME as f64;
    if let Some(key) = keys.iter().find(|k| !(-limit..=limit).contains(&k.frame)) {
        return Err(PathError::FrameNumber(key.frame));
    }
    if let Some((a, b)) = keys.iter().zip(&keys[1..]).find(|(a, b)| b.frame <= a.frame) {
        return Err(PathError::NotRising {
            frame: b.frame,
            before: a.frame,
        });
    }
    let flawed = keys.iter().find_map(|k| k.lens.flaw().map(|flaw| (k.frame, flaw)));
    if let Some((frame, flaw)) = flawed {
        return Err(PathError::Lens { frame, flaw });
    }
    uniform(keys, "the orientation", |k| Some(discriminant(&k.orientation)))?;
    uniform(keys, "the rotation", |k| match k.orientation {
        Orientation::Rotation(rotation) => Some(rotation.order()),
        Orientation::Target { .. } => None,
    })?;
    uniform(keys, "the view", |k| k.lens.view.as_ref().map(discriminant))?;
    uniform(keys, "the sensor", |k| k.lens.sensor.as_ref().map(discriminant))?;
    uniform(keys, "the aperture", |k| k.lens.aperture.as_ref().map(discriminant))
}

/// All keys that say something say the same kind of thing.
fn uniform<T: PartialEq>(
    keys: &[PathKey],
    what: &'static str,
    kind: impl Fn(&PathKey) -> Option<T>,
) -> Result<(), PathError> {
    let mut given = keys.iter().filter_map(|k| kind(k).map(|kind| (k.frame, kind)));
    let Some((_, first)) = given.next() else { return Ok(()) };
    match given.find(|(_, kind)| *kind != first) {
        Some((frame, _)) => Err(PathError::Mixed { frame, what }),
        None => Ok(()),
    }
}

fn track<T: Channel>(keys: &[PathKey], value: impl Fn(&PathKey) -> Option<T>) -> Track<T> {
    Track::new(keys.iter().map(|k| (k.frame, value(k), k.interp)))
}

/// The values of keys, each with the frame from which on it holds.
fn held<T>(keys: &[PathKey], value: impl Fn(&PathKey) -> Option<T>) -> Vec<(f64, T)> {
    let given = keys.iter().filter_map(|k| value(k).map(|value| (k.frame, value)));
    given.collect()
}

/// The last value at or before `frame`.
fn last<T>(held: &[(f64, T)], frame: f64) -> Option<&T> {
    let next = held.partition_point(|(from, _)| *from <= frame);
    next.checked_sub(1).map(|i| &held[i].1)
}

/// The curves of the orientations of `keys`, which are all of one kind.
fn orientation_track(keys: &[PathKey]) -> OrientationTrack {
    let angle = |axis: usize| {
        track(keys, |k| match k.orientation {
            Orientation::Rotation(Rotation::Euler { degrees, .. }) => Some(degrees[axis]),
            _ => None,
        })
    };
    let quaternion = |k: &PathKey| match k.orientation {
        Orientation::Rotation(Rotation::Quaternion(q)) => Some(q),
        _ => None,
    };
    let target = |k: &PathKey| match k.orientation {
        Orientation::Target { target, up, roll } => Some((target, up, roll)),
        Orientation::Rotation(_) => None,
    };
    match keys[0].orientation {
        Orientation::Rotation(Rotation::Euler { order, .. }) => OrientationTrack::Euler {
            angles: [0, 1, 2].map(angle),
            order,
        },
        Orientation::Rotation(Rotation::Quaternion(_)) => OrientationTrack::Quaternion(track(keys, quaternion)),
        Orientation::Target { .. } => OrientationTrack::Target {
            target: track(keys, |k| target(k).map(|(at, ..)| at)),
            up: track(keys, |k| target(k).and_then(|(_, up, _)| up)),
            roll: track(keys, |k| target(k).and_then(|(.., roll)| roll)),
        },
    }
}

#[cfg(test)]
mod tests;
