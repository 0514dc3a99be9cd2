//! Lights and cameras that animations change, by KHR_animation_pointer.
//!
//! Source: Khronos, "KHR_animation_pointer", and the glTF 2.0 object model.

use glam::DAffine3;

use crate::{
    assets::views::{ModelLight, ModelLightKind, ModelView},
    math::{Rgb, keys::Keys},
};

/// The parameters of a light.
#[derive(Clone, Copy, Debug)]
pub struct LightParameters {
    pub kind: LightShape,
    pub color: [f64; 3],
    /// In W sr^-1, or W m^-2 of a sun.
    pub intensity: f64,
}

/// The kind of a light. Angles are half angles in radians as they are in the file.
#[derive(Clone, Copy, Debug)]
pub enum LightShape {
    Point,
    Sun,
    Spot {
        inner: f64,
        outer: f64,
        /// Whether the soft edge is that of Blender.
        is_of_blender: bool,
    },
}

/// A parameter of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightProperty {
    Color,
    /// The number in the file is divided by this whole number of lumens per watt.
    Intensity {
        divisor: u32,
    },
    InnerCone,
    OuterCone,
}

impl LightParameters {
    pub(super) fn set(&mut self, property: LightProperty, keys: &Keys, time: f32) {
        match (property, &mut self.kind) {
            (LightProperty::Color, _) => self.color = keys.array(time),
            (LightProperty::Intensity { divisor }, _) => {
                let [intensity] = keys.array(time);
                self.intensity = intensity / f64::from(divisor);
            }
            (LightProperty::InnerCone, LightShape::Spot { inner, .. }) => [*inner] = keys.array(time),
            (LightProperty::OuterCone, LightShape::Spot { outer, .. }) => [*outer] = keys.array(time),
            (LightProperty::InnerCone | LightProperty::OuterCone, LightShape::Point | LightShape::Sun) => {}
        }
    }

    /// The light at this place.
    pub fn light(&self, model_from_light: DAffine3) -> ModelLight {
        let intensity = self.intensity.max(0.0);
        let color = self.color.map(|channel| (channel.max(0.0) * intensity) as f32);
        ModelLight {
            model_from_light,
            strength: Rgb::from_array(color),
            kind: self.kind.model_kind(),
        }
    }
}

impl LightShape {
    fn model_kind(self) -> ModelLightKind {
        match self {
            Self::Point => ModelLightKind::Point,
            Self::Sun => ModelLightKind::Sun,
            Self::Spot {
                inner,
                outer,
                is_of_blender,
            } => {
                let outer = outer.clamp(1e-4, std::f64::consts::FRAC_PI_2);
                let inner = inner.clamp(0.0, outer);
                let inner = if is_of_blender {
                    // Blender's blend is 1 - inner / outer, which Cycles takes as a part of the cosine.
                    let cos = libm::cos(outer);
                    libm::acos((cos + (1.0 - cos) * (1.0 - inner / outer)).min(1.0))
                } else {
                    inner
                };
                ModelLightKind::Spot { inner, outer }
            }
        }
    }
}

/// A parameter of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraProperty {
    Fov,
    HalfHeight,
}

impl CameraProperty {
    pub(super) fn set(self, view: &mut ModelView, keys: &Keys, time: f32) {
        let [number] = keys.array(time);
        match (self, view) {
            (Self::Fov, ModelView::Perspective { fov }) if number > 0.0 && number < std::f64::consts::PI => {
                *fov = number
            }
            (Self::HalfHeight, ModelView::Orthographic { height }) if number != 0.0 => *height = 2.0 * number.abs(),
            _ => {}
        }
    }
}
