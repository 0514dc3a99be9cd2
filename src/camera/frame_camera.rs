//! The camera of one frame, which may move while the picture is taken.

use std::convert::Infallible;

use serde::Serialize;

use super::{
    Camera, FilmSize, StereoEye,
    shutter::{Readout, Shutter, Timing},
};
use crate::math::DVec3;

/// Segments of the time while the picture is taken.
const SEGMENTS: u32 = 16;

/// The steps in which the line of a rolling shutter is found that sees a point.
const LINE_STEPS: usize = 24;

/// A camera while the picture of a frame is taken: still, or moving.
///
/// A moving camera is exact at 17 times, evenly spaced from the shutter's opening to its closing,
/// and goes straight and at an even rate from each to the next. A turn by the angle a (radians)
/// between opening and closing strays from its arc by a^2/2048 of the radius at most, 0.4 mm in a
/// metre for 50 degrees, and the lines of sight by a^3/250,000 radians, a hundredth of a pixel
/// where the turn blurs over many.
#[derive(Clone, Debug, Serialize)]
pub enum PictureCamera {
    Still(Box<Camera>),
    Moving(Box<[Camera; SEGMENTS as usize + 1]>),
}

/// The camera of one frame.
///
/// With a rolling shutter, the picture is taken from the time at which the shutter opens for the first line of the sensor until
/// it closes for the last one.
#[derive(Clone, Debug, Serialize)]
pub struct FrameCamera {
    cameras: PictureCamera,
    neighbours: Neighbours,
    /// The time while the shutter is open, in frames.
    exposure: f64,
    #[serde(skip_serializing_if = "Readout::is_global")]
    readout: Readout,
    /// The time at which it opens, in frames from that of the picture. The cameras and the scene are those of its times already.
    #[serde(skip)]
    open: f64,
    /// The times at which the shutters of the frames before and after open, in the same way.
    #[serde(skip)]
    openings_around: [f64; 2],
}

/// The cameras of the frames before and after; `None` where there is no such frame. Without a rolling shutter they are still, as
/// their shutters open.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Neighbours {
    pub previous: Option<PictureCamera>,
    pub next: Option<PictureCamera>,
}

impl From<Camera> for PictureCamera {
    fn from(camera: Camera) -> Self {
        Self::Still(Box::new(camera))
    }
}

impl From<PictureCamera> for FrameCamera {
    fn from(cameras: PictureCamera) -> Self {
        Self {
            cameras,
            neighbours: Neighbours::default(),
            exposure: 0.0,
            readout: Readout::default(),
            open: 0.0,
            openings_around: [-1.0, 1.0],
        }
    }
}

impl From<Camera> for FrameCamera {
    fn from(camera: Camera) -> Self {
        Self::from(PictureCamera::from(camera))
    }
}

impl PictureCamera {
    /// Creates a moving camera, which is `at(u)` at the fraction `u`, from 0 to 1, of the time while the picture is taken.
    ///
    /// # Errors
    /// The first error of `at`.
    pub fn moving<E>(mut at: impl FnMut(f64) -> Result<Camera, E>) -> Result<Self, E> {
        let first = at(0.0)?;
        let mut cameras = Box::new([first; SEGMENTS as usize + 1]);
        for (i, camera) in cameras.iter_mut().enumerate().skip(1) {
            *camera = at(i as f64 / f64::from(SEGMENTS))?;
        }
        Ok(Self::Moving(cameras))
    }

    /// The camera at the fraction `time`, from 0 to 1, of the time while the picture is taken.
    #[inline]
    pub fn at(&self, time: f64) -> Camera {
        match self {
            Self::Still(camera) => **camera,
            Self::Moving(cameras) => {
                let along = time * f64::from(SEGMENTS);
                let i = (along as usize).min(SEGMENTS as usize - 1);
                cameras[i].between(&cameras[i + 1], along - i as f64)
            }
        }
    }

    /// Returns this camera with each of its cameras replaced.
    fn map<E>(&self, change: impl Fn(&Camera) -> Result<Camera, E>) -> Result<Self, E> {
        Ok(match self {
            Self::Still(camera) => Self::from(change(camera)?),
            Self::Moving(cameras) => {
                let mut changed = cameras.clone();
                for camera in &mut *changed {
                    *camera = change(camera)?;
                }
                Self::Moving(changed)
            }
        })
    }

    /// The place on the film, in pixels, of a point that is `point(time)` at the fraction `time` of `timing`, and its depth, as
    /// [`CameraKind::project`](super::CameraKind::project), seen as the shutter opens for its line.
    pub fn project(&self, point: impl Fn(f64) -> DVec3, (timing, film): (&Timing, FilmSize)) -> Option<DVec3> {
        let seen = |read: f64| {
            let time = timing.fraction(0.0, read);
            self.at(time).project(point(time))
        };
        if timing.readout.is_global() {
            return seen(0.0);
        }
        // The line that sees the point: it lies where the readout is when the line is read.
        let early = |read: f64| seen(read).map(|at| timing.readout.fraction([at.x, at.y], film) - read);
        let [mut low, mut high] = [0.0, 1.0];
        for _ in 0..LINE_STEPS {
            let middle = 0.5 * (low + high);
            match early(middle)? > 0.0 {
                true => low = middle,
                false => high = middle,
            }
        }
        seen(0.5 * (low + high))
    }
}

impl FrameCamera {
    /// Returns this camera between these frames.
    pub fn with_neighbours(self, neighbours: Neighbours) -> Self {
        Self { neighbours, ..self }
    }

    /// Returns this camera with these times. Those of the frames around it are the same.
    pub fn with_timing(self, timing: Timing) -> Self {
        let open = timing.shutter.open;
        Self {
            exposure: timing.exposure(),
            readout: timing.readout,
            open,
            openings_around: [open - 1.0, open + 1.0],
            ..self
        }
    }

    /// Returns this camera between frames whose shutters open at these times, in frames from that of the picture.
    pub fn with_openings_around(self, before: f64, after: f64) -> Self {
        Self {
            openings_around: [before, after],
            ..self
        }
    }

    /// The times at which the shutters of the frames before and after open, in frames from that of the picture.
    pub fn openings_around(&self) -> [f64; 2] {
        self.openings_around
    }

    pub fn timing(&self) -> Timing {
        Timing {
            shutter: Shutter {
                open: self.open,
                close: self.open + self.exposure,
            },
            readout: self.readout,
        }
    }

    /// The time at the fraction `u`, from 0 to 1, of the time while the picture is taken, in frames from that of the picture.
    pub fn shutter_time(&self, u: f64) -> f64 {
        self.open + self.duration() * u
    }

    /// The time of a pixel as a fraction of the time while the picture is taken, at the fraction `exposed` of its own exposure.
    #[inline]
    pub fn time_of_pixel(&self, exposed: f64, [x, y]: [i32; 2], film: FilmSize) -> f64 {
        if self.readout.is_global() {
            return exposed;
        }
        let center = [x, y].map(|at| f64::from(at) + 0.5);
        self.timing().fraction(exposed, self.readout.fraction(center, film))
    }

    /// The time while the shutter is open for a line of the picture, in frames; 0 without motion blur.
    pub fn exposure(&self) -> f64 {
        self.exposure
    }

    /// The time while the picture is taken, in frames; 0 if it shows a single time.
    pub fn duration(&self) -> f64 {
        self.exposure + self.readout.time
    }

    pub fn readout(&self) -> &Readout {
        &self.readout
    }

    pub fn neighbours(&self) -> &Neighbours {
        &self.neighbours
    }

    /// The camera while the picture is taken.
    pub fn cameras(&self) -> &PictureCamera {
        &self.cameras
    }

    /// Whether [`FrameCamera::camera`] reads `time`.
    #[inline]
    pub fn moves(&self) -> bool {
        matches!(self.cameras, PictureCamera::Moving(_))
    }

    /// Returns the camera at the fraction `time`, in `[0, 1)`, of the time while the picture is taken.
    #[inline]
    pub fn camera(&self, time: f32) -> Camera {
        self.cameras.at(f64::from(time))
    }

    /// Returns this camera moved by `by`, in m.
    pub fn moved(&self, by: DVec3) -> Self {
        let moved = self.map(|camera| Ok::<_, Infallible>(camera.moved(by)));
        moved.unwrap_or_else(|never| match never {})
    }

    /// Returns the camera of an eye beside this one.
    ///
    /// # Errors
    /// Why it has no such eye.
    pub fn of_eye(&self, eye: &StereoEye) -> Result<Self, &'static str> {
        self.map(|camera| camera.of_eye(eye))
    }

    /// Returns this camera with each of its cameras, and those of its neighbours, replaced.
    fn map<E>(&self, change: impl Fn(&Camera) -> Result<Camera, E>) -> Result<Self, E> {
        let of = |neighbour: &Option<PictureCamera>| neighbour.as_ref().map(|own| own.map(&change)).transpose();
        Ok(Self {
            cameras: self.cameras.map(&change)?,
            neighbours: Neighbours {
                previous: of(&self.neighbours.previous)?,
                next: of(&self.neighbours.next)?,
            },
            ..*self
        })
    }

    /// Whether its rays read numbers for the lens, at some time, see
    /// [`CameraKind::has_lens`](super::CameraKind::has_lens).
    pub fn has_lens(&self) -> bool {
        match &self.cameras {
            PictureCamera::Still(camera) => camera.has_lens(),
            PictureCamera::Moving(cameras) => cameras.iter().any(Camera::has_lens),
        }
    }

    /// Whether every place in the picture has a ray, see
    /// [`CameraKind::fills_film`](super::CameraKind::fills_film).
    pub fn fills_film(&self) -> bool {
        self.camera(0.0).fills_film()
    }
}
