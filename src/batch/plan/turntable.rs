//! Turntables: a camera orbit around a scene.

use std::str::FromStr;

use glam::{DQuat, DVec3};

use serde::Serialize;

use crate::{
    camera::{Camera, FilmSize, Pose, SceneCamera},
    math::transform::axis_rotation,
    scene::Scene,
};

/// The frames of an orbit and the angle between its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    pub frames: u32,
    /// Counterclockwise as seen from above.
    pub degrees: f64,
}

impl FromStr for Turn {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (frames, degrees) = text.split_once(':').unwrap_or((text, "360"));
        let frames = frames.trim().parse().ok().filter(|n| (1..=MOST_FRAMES).contains(n));
        let degrees = degrees.trim().parse().ok().filter(|d: &f64| d.is_finite());
        match (frames, degrees) {
            (Some(frames), Some(degrees)) => Ok(Self { frames, degrees }),
            (None, _) => Err(format!(
                "expected a number of frames from 1 to {MOST_FRAMES}, such as 48 or 48:180"
            )),
            (_, None) => Err("expected degrees after the colon, such as 48:180".to_owned()),
        }
    }
}

/// The most frames of an orbit.
const MOST_FRAMES: u32 = 1_000_000;

/// An orbit around the vertical axis through the centre of a scene, starting at a camera.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Turntable {
    pub start: SceneCamera,
    /// The number of frames of the orbit. The first is at the start, the last is one step before the end.
    pub frames: u32,
    /// The angle between the start and the end.
    pub degrees: f64,
}

/// The orbit of one scene.
#[derive(Clone, Copy, Debug)]
pub struct Orbit {
    turntable: Turntable,
    center: DVec3,
}

impl Turntable {
    /// The orbit around the bounded part of the scene. In a scene without bounds the camera turns in place.
    pub fn around(self, scene: &Scene) -> Orbit {
        let bounds = scene.geometry.accel.geometry().world_bounds();
        let center = if bounds.is_finite() {
            scene.origin + bounds.center().as_dvec3()
        } else {
            self.start.pose.eye()
        };
        Orbit {
            turntable: self,
            center,
        }
    }
}

impl Orbit {
    /// The camera of a frame, counted from 1, counterclockwise as seen from above.
    pub fn camera(&self, frame: i32, film: FilmSize) -> Camera {
        let Turntable { start, frames, degrees } = self.turntable;
        let turn = axis_rotation(1, degrees * f64::from(frame - 1) / f64::from(frames));
        let eye = self.center + turn * (start.pose.eye() - self.center);
        let axes = turn * start.pose.world_from_camera().matrix3;
        // Rotations always convert to a quaternion, so the fallback is not used.
        let pose = Pose::from_quaternion(eye, DQuat::from_mat3(&axes)).unwrap_or(start.pose);
        let pose = if frame == 1 { start.pose } else { pose };
        Camera::new(&pose, &start.lens, film)
    }
}
