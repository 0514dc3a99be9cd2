//! Cameras and lights of model files.

use glam::DAffine3;

use crate::math::Rgb;

/// A camera: it looks along its own -z, +y is up.
#[derive(Clone, Debug)]
pub struct ModelCamera {
    /// The name of its node, or its own; may be empty.
    pub name: String,
    pub model_from_camera: DAffine3,
    pub view: ModelView,
}

/// The view of a model's camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModelView {
    /// The angle over the picture's height, in radians.
    Perspective { fov: f64 },
    /// The height of the view, in m.
    Orthographic { height: f64 },
}

/// A light: it shines along its own -z.
#[derive(Clone, Copy, Debug)]
pub struct ModelLight {
    pub model_from_light: DAffine3,
    /// The intensity in W sr^-1; for a sun the irradiance on a surface that faces it, in W m^-2.
    pub strength: Rgb,
    pub kind: ModelLightKind,
}

/// The kind of a model's light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModelLightKind {
    Point,
    /// Half angles in radians: full light up to `inner`, none beyond `outer`.
    Spot {
        inner: f64,
        outer: f64,
    },
    Sun,
}
