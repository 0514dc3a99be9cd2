//! A camera while its shutter is open.

use super::Camera;

/// Stretches that the time between the shutter's opening and closing is cut into.
const SEGMENTS: u32 = 16;

/// The cameras of one picture: one that stands still, or one that moves while the shutter is open.
///
/// A moving camera is exact at 17 times, evenly spaced from the shutter's opening to its closing, and goes straight and at
/// an even rate from each to the next. A turn by the angle a (radians) between opening and closing strays from its arc
/// by a^2/2048 of the radius at most, 0.4 mm in a metre for 50 degrees, and the lines of sight by a^3/250,000 radians,
/// a hundredth of a pixel where the turn blurs over many.
#[derive(Clone, Debug)]
pub struct FrameCamera(Cameras);

#[derive(Clone, Debug)]
enum Cameras {
    Still(Camera),
    Moving(Box<[Camera; SEGMENTS as usize + 1]>),
}

impl From<Camera> for FrameCamera {
    fn from(camera: Camera) -> Self {
        Self(Cameras::Still(camera))
    }
}

impl FrameCamera {
    /// The picture of a camera that is `at(u)` when the part `u`, from 0 to 1, of the time between opening and closing
    /// has passed.
    ///
    /// # Errors
    /// The first of `at`.
    pub fn moving<E>(mut at: impl FnMut(f64) -> Result<Camera, E>) -> Result<Self, E> {
        let first = at(0.0)?;
        let mut cameras = Box::new([first; SEGMENTS as usize + 1]);
        for (i, camera) in cameras.iter_mut().enumerate().skip(1) {
            *camera = at(i as f64 / f64::from(SEGMENTS))?;
        }
        Ok(Self(Cameras::Moving(cameras)))
    }

    /// Whether [`FrameCamera::camera`] reads `time`.
    #[inline]
    pub fn moves(&self) -> bool {
        matches!(self.0, Cameras::Moving(_))
    }

    /// The camera when the part `time`, in `[0, 1)`, of the time between opening and closing has passed.
    #[inline]
    pub fn camera(&self, time: f32) -> Camera {
        match &self.0 {
            Cameras::Still(camera) => *camera,
            Cameras::Moving(cameras) => {
                let along = f64::from(time) * f64::from(SEGMENTS);
                let i = (along as usize).min(SEGMENTS as usize - 1);
                cameras[i].between(&cameras[i + 1], along - i as f64)
            }
        }
    }

    /// Whether its rays read numbers for the lens, at some time, see [`CameraKind::has_lens`](super::CameraKind::has_lens).
    pub fn has_lens(&self) -> bool {
        match &self.0 {
            Cameras::Still(camera) => camera.has_lens(),
            Cameras::Moving(cameras) => cameras.iter().any(Camera::has_lens),
        }
    }

    /// Whether every place in the picture has a ray, see [`CameraKind::fills_film`](super::CameraKind::fills_film).
    pub fn fills_film(&self) -> bool {
        self.camera(0.0).fills_film()
    }
}
