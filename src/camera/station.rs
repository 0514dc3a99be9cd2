//! The place and the axes of a camera whose rays leave its eye in all directions.

use glam::{DMat3, DVec3};

use serde::Serialize;

use super::{Pose, ViewMatrices, facts, lerp, unit_ray};
use crate::math::Ray;

/// The position and the orientation of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Station {
    eye: DVec3,
    /// From camera to world.
    axes: DMat3,
}

impl Station {
    pub fn new(pose: &Pose) -> Self {
        Self {
            eye: pose.eye(),
            axes: pose.world_from_camera().matrix3,
        }
    }

    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// From camera to world.
    pub fn axes(&self) -> DMat3 {
        self.axes
    }

    /// The unit direction of the line of sight.
    pub fn forward(&self) -> DVec3 {
        -self.axes.z_axis
    }

    /// The ray in the direction `d` of the camera's space.
    pub fn ray(&self, d: DVec3) -> Ray {
        unit_ray(self.eye, self.axes * d)
    }

    /// A point of the world in the camera's space.
    pub fn local(&self, p: DVec3) -> DVec3 {
        self.axes.transpose() * (p - self.eye)
    }

    pub fn matrices(&self) -> ViewMatrices {
        let DMat3 { x_axis, y_axis, z_axis } = self.axes;
        ViewMatrices {
            camera_from_world: facts::camera_from_world(self.eye, [x_axis, y_axis, -z_axis]),
            ndc_from_world: None,
        }
    }

    pub fn moved(&self, by: DVec3) -> Self {
        Self {
            eye: self.eye + by,
            ..*self
        }
    }

    /// The ray from a place of the camera's space in the direction `d` of that space.
    pub fn ray_from(&self, o: DVec3, d: DVec3) -> Ray {
        unit_ray(self.eye + self.axes * o, self.axes * d)
    }

    /// The station so many metres to the right.
    pub fn beside(&self, by: f64) -> Self {
        self.moved(self.axes.x_axis * by)
    }

    pub fn between(&self, to: &Self, u: f64) -> Self {
        Self {
            eye: lerp(self.eye, to.eye, u),
            axes: self.axes + (to.axes - self.axes) * u,
        }
    }
}
