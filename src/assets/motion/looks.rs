//! Materials, lights and cameras that animations change, by KHR_animation_pointer.
//!
//! Source: Khronos, "KHR_animation_pointer", and the glTF 2.0 object model.

use glam::DAffine3;

use crate::{
    assets::views::{ModelLight, ModelLightKind, ModelView},
    material::{medium, principled::Principled},
    math::{Rgb, keys::Keys},
    texture::{Color, Scalar},
};

/// A surface that animations change.
#[derive(Clone, Copy, Debug)]
pub struct MaterialMotion {
    /// An index into [`Model::materials`](crate::assets::model::Model::materials).
    pub material: usize,
    pub surface: Principled,
    /// The colour of white light after this distance in the body, in m.
    pub attenuation: (Rgb, f32),
}

/// Sets the property of a surface to numbers.
type Change = fn(&mut MaterialMotion, [f32; 4]);

/// The change of a surface by numbers.
#[derive(Clone, Copy, Debug)]
pub struct MaterialProperty {
    /// The number of numbers.
    pub width: usize,
    change: Change,
}

/// The properties of materials by their paths in a material.
const PROPERTIES: [(&str, usize, Change); 26] = [
    ("pbrMetallicRoughness/baseColorFactor", 4, |m, v| {
        let surface = &mut m.surface;
        let color = if surface.is_unlit {
            &mut surface.emissive
        } else {
            &mut surface.base_color
        };
        tint(color, v);
        set_factor(&mut surface.opacity, v[3]);
    }),
    ("pbrMetallicRoughness/metallicFactor", 1, |m, v| {
        set_factor(&mut m.surface.metallic, v[0])
    }),
    ("pbrMetallicRoughness/roughnessFactor", 1, |m, v| {
        set_factor(&mut m.surface.roughness, v[0])
    }),
    ("emissiveFactor", 3, |m, v| {
        if !m.surface.is_unlit {
            tint(&mut m.surface.emissive, v);
        }
    }),
    ("alphaCutoff", 1, |m, v| {
        if let crate::material::principled::AlphaMode::Mask(cutoff) = &mut m.surface.alpha_mode {
            *cutoff = v[0];
        }
    }),
    ("normalTexture/scale", 1, |m, v| m.surface.normal_scale = v[0]),
    (
        "extensions/KHR_materials_emissive_strength/emissiveStrength",
        1,
        |m, v| {
            if !m.surface.is_unlit {
                m.surface.emissive_strength = v[0].max(0.0);
            }
        },
    ),
    ("extensions/KHR_materials_ior/ior", 1, |m, v| {
        m.surface.ior = v[0].max(1.0)
    }),
    ("extensions/KHR_materials_transmission/transmissionFactor", 1, |m, v| {
        set_factor(&mut m.surface.transmission, v[0]);
    }),
    (
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor",
        1,
        |m, v| {
            set_factor(&mut m.surface.diffuse_transmission, v[0]);
        },
    ),
    (
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor",
        3,
        |m, v| {
            tint(&mut m.surface.diffuse_transmission_color, v);
        },
    ),
    ("extensions/KHR_materials_volume/attenuationColor", 3, |m, v| {
        m.attenuation.0 = Rgb::new(v[0], v[1], v[2]);
        m.absorb();
    }),
    ("extensions/KHR_materials_volume/attenuationDistance", 1, |m, v| {
        m.attenuation.1 = v[0];
        m.absorb();
    }),
    ("extensions/KHR_materials_dispersion/dispersion", 1, |m, v| {
        m.surface.dispersion = v[0].max(0.0)
    }),
    ("extensions/KHR_materials_clearcoat/clearcoatFactor", 1, |m, v| {
        set_factor(&mut m.surface.clearcoat, v[0])
    }),
    (
        "extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor",
        1,
        |m, v| {
            set_factor(&mut m.surface.clearcoat_roughness, v[0]);
        },
    ),
    ("extensions/KHR_materials_sheen/sheenColorFactor", 3, |m, v| {
        tint(&mut m.surface.sheen_color, v)
    }),
    ("extensions/KHR_materials_sheen/sheenRoughnessFactor", 1, |m, v| {
        set_factor(&mut m.surface.sheen_roughness, v[0])
    }),
    ("extensions/KHR_materials_specular/specularFactor", 1, |m, v| {
        set_factor(&mut m.surface.specular, v[0])
    }),
    ("extensions/KHR_materials_specular/specularColorFactor", 3, |m, v| {
        tint(&mut m.surface.specular_color, v)
    }),
    ("extensions/KHR_materials_iridescence/iridescenceFactor", 1, |m, v| {
        set_factor(&mut m.surface.iridescence, v[0])
    }),
    ("extensions/KHR_materials_iridescence/iridescenceIor", 1, |m, v| {
        m.surface.iridescence_ior = v[0].max(1.0)
    }),
    (
        "extensions/KHR_materials_iridescence/iridescenceThicknessMinimum",
        1,
        |m, v| {
            m.surface.iridescence_thickness[0] = v[0].max(0.0) * 1e-9;
        },
    ),
    (
        "extensions/KHR_materials_iridescence/iridescenceThicknessMaximum",
        1,
        |m, v| {
            m.surface.iridescence_thickness[1] = v[0].max(0.0) * 1e-9;
        },
    ),
    ("extensions/KHR_materials_anisotropy/anisotropyStrength", 1, |m, v| {
        set_factor(&mut m.surface.anisotropy, v[0])
    }),
    ("extensions/KHR_materials_anisotropy/anisotropyRotation", 1, |m, v| {
        m.surface.anisotropy_rotation = v[0]
    }),
];

fn tint(color: &mut Color, [r, g, b, _]: [f32; 4]) {
    let factor = Rgb::from_array([r, g, b].map(|v| v.max(0.0)));
    *color = match *color {
        Color::Constant(_) => Color::Constant(factor),
        Color::Texture(id) | Color::Tinted(id, _) => Color::Tinted(id, factor),
    };
}

fn set_factor(scalar: &mut Scalar, factor: f32) {
    let (Scalar::Constant(v) | Scalar::Texture(_, _, v) | Scalar::Inverted(_, _, v)) = scalar;
    *v = factor.clamp(0.0, 1.0);
}

impl MaterialProperty {
    /// The property at this path in a material of the file.
    pub fn of_path(path: &str) -> Option<Self> {
        let row = PROPERTIES.iter().find(|(known, ..)| *known == path);
        row.map(|&(_, width, change)| Self { width, change })
    }
}

impl MaterialMotion {
    pub(super) fn set(&mut self, property: MaterialProperty, keys: &Keys, time: f32) {
        let mut numbers = [0.0; 4];
        for (number, v) in numbers.iter_mut().zip(keys.at(time)) {
            *number = v as f32;
        }
        (property.change)(self, numbers);
    }

    fn absorb(&mut self) {
        let (color, distance) = self.attenuation;
        let is_clear = !(distance > 0.0 && distance.is_finite());
        self.surface.absorption = if is_clear {
            Rgb::BLACK
        } else {
            medium::absorption(color, distance)
        };
    }
}

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
