//! The camera of one frame, which may move while the shutter is open.

use serde::Serialize;

use super::Camera;
use crate::math::DVec3;

/// Segments of the time while the shutter is open.
const SEGMENTS: u32 = 16;

/// The camera of one frame: still, or moving while the shutter is open.
///
/// A moving camera is exact at 17 times, evenly spaced from the shutter's opening to its closing,
/// and goes straight and at an even rate from each to the next. A turn by the angle a (radians)
/// between opening and closing strays from its arc by a^2/2048 of the radius at most, 0.4 mm in a
/// metre for 50 degrees, and the lines of sight by a^3/250,000 radians, a hundredth of a pixel
/// where the turn blurs over many.
#[derive(Clone, Debug, Serialize)]
pub struct FrameCamera {
    cameras: Cameras,
    neighbours: Neighbours,
    /// The time while the shutter is open, in frames.
    exposure: f64,
    /// The time at which it opens, in frames from that of the picture. The cameras and the scene are those of its times already.
    #[serde(skip)]
    open: f64,
    /// The times at which the shutters of the frames before and after open, in the same way.
    #[serde(skip)]
    openings_around: [f64; 2],
}

/// The cameras of the frames before and after, as their shutters open; `None` where there is no such frame.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Neighbours {
    pub previous: Option<Camera>,
    pub next: Option<Camera>,
}

#[derive(Clone, Debug, Serialize)]
enum Cameras {
    Still(Box<Camera>),
    Moving(Box<[Camera; SEGMENTS as usize + 1]>),
}

impl From<Camera> for FrameCamera {
    fn from(camera: Camera) -> Self {
        Self::new(Cameras::Still(Box::new(camera)))
    }
}

impl FrameCamera {
    /// Creates a moving camera, which is `at(u)` at the fraction `u`, from 0 to 1, of the time
    /// while the shutter is open.
    ///
    /// # Errors
    /// The first error of `at`.
    pub fn moving<E>(mut at: impl FnMut(f64) -> Result<Camera, E>) -> Result<Self, E> {
        let first = at(0.0)?;
        let mut cameras = Box::new([first; SEGMENTS as usize + 1]);
        for (i, camera) in cameras.iter_mut().enumerate().skip(1) {
            *camera = at(i as f64 / f64::from(SEGMENTS))?;
        }
        Ok(Self::new(Cameras::Moving(cameras)))
    }

    fn new(cameras: Cameras) -> Self {
        Self {
            cameras,
            neighbours: Neighbours::default(),
            exposure: 0.0,
            open: 0.0,
            openings_around: [-1.0, 1.0],
        }
    }

    /// Returns this camera between these frames.
    pub fn with_neighbours(self, neighbours: Neighbours) -> Self {
        Self { neighbours, ..self }
    }

    /// Returns this camera with a shutter that is open between these times, in frames from that of the picture. Those of the frames
    /// around it open in the same way.
    pub fn with_shutter(self, open: f64, close: f64) -> Self {
        Self {
            exposure: close - open,
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

    /// The time at the fraction `u`, from 0 to 1, of the time while the shutter is open, in frames from that of the picture.
    pub fn shutter_time(&self, u: f64) -> f64 {
        self.open + self.exposure * u
    }

    /// The time while the shutter is open, in frames; 0 without motion blur.
    pub fn exposure(&self) -> f64 {
        self.exposure
    }

    pub fn neighbours(&self) -> &Neighbours {
        &self.neighbours
    }

    /// Whether [`FrameCamera::camera`] reads `time`.
    #[inline]
    pub fn moves(&self) -> bool {
        matches!(self.cameras, Cameras::Moving(_))
    }

    /// Returns the camera at the fraction `time`, in `[0, 1)`, of the time while the shutter is
    /// open.
    #[inline]
    pub fn camera(&self, time: f32) -> Camera {
        match &self.cameras {
            Cameras::Still(camera) => **camera,
            Cameras::Moving(cameras) => {
                let along = f64::from(time) * f64::from(SEGMENTS);
                let i = (along as usize).min(SEGMENTS as usize - 1);
                cameras[i].between(&cameras[i + 1], along - i as f64)
            }
        }
    }

    /// Returns this camera moved by `by`, in m.
    pub fn moved(&self, by: DVec3) -> Self {
        let Neighbours { previous, next } = self.neighbours;
        Self {
            cameras: match &self.cameras {
                Cameras::Still(camera) => Cameras::Still(Box::new(camera.moved(by))),
                Cameras::Moving(cameras) => Cameras::Moving(Box::new(cameras.map(|camera| camera.moved(by)))),
            },
            neighbours: Neighbours {
                previous: previous.map(|camera| camera.moved(by)),
                next: next.map(|camera| camera.moved(by)),
            },
            ..*self
        }
    }

    /// Whether its rays read numbers for the lens, at some time, see
    /// [`CameraKind::has_lens`](super::CameraKind::has_lens).
    pub fn has_lens(&self) -> bool {
        match &self.cameras {
            Cameras::Still(camera) => camera.has_lens(),
            Cameras::Moving(cameras) => cameras.iter().any(Camera::has_lens),
        }
    }

    /// Whether every place in the picture has a ray, see
    /// [`CameraKind::fills_film`](super::CameraKind::fills_film).
    pub fn fills_film(&self) -> bool {
        self.camera(0.0).fills_film()
    }
}
