//! The factors of materials that animations and values over frames change.
//!
//! Source: Khronos, "KHR_animation_pointer", and the glTF 2.0 object model.

use crate::{
    material::{
        medium,
        principled::{AlphaMode, Principled},
    },
    math::{Rgb, exponential, keys::Keys},
    texture::{Color, Scalar},
};

/// A surface that changes over time.
#[derive(Clone, Copy, Debug)]
pub struct MaterialMotion {
    /// An index into [`Model::materials`](crate::assets::model::Model::materials).
    pub material: usize,
    pub surface: Principled,
    /// The colour of white light after this distance in the body, in m.
    pub attenuation: (Rgb, f32),
}

/// A factor of a material.
#[derive(Clone, Copy, Debug)]
pub struct Factor {
    /// The name of the value, which is that of the material `principled` where there is one.
    pub name: &'static str,
    /// The path in a material of a glTF file.
    pointer: &'static str,
    pub range: FactorRange,
    place: Place,
}

/// The numbers that a factor may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorRange {
    /// Three numbers of at least 0.
    Color,
    /// From 0 to 1.
    Unit,
    Any,
    AtLeast0,
    AtLeast1,
    Above0,
    /// An angle, which values give in degrees and files in radians.
    Angle,
}

/// The place of a factor in a surface.
#[derive(Clone, Copy, Debug)]
enum Place {
    /// A colour, if the surface shows it.
    Color(fn(&mut Principled) -> Option<&mut Color>),
    Scalar(fn(&mut Principled) -> &mut Scalar),
    Number(fn(&mut Principled, f32)),
    AttenuationColor,
    AttenuationDistance,
}

const fn factor(name: &'static str, pointer: &'static str, range: FactorRange, place: Place) -> Factor {
    Factor {
        name,
        pointer,
        range,
        place,
    }
}

const fn color(name: &'static str, pointer: &'static str, place: fn(&mut Principled) -> Option<&mut Color>) -> Factor {
    factor(name, pointer, FactorRange::Color, Place::Color(place))
}

const fn amount(name: &'static str, pointer: &'static str, place: fn(&mut Principled) -> &mut Scalar) -> Factor {
    factor(name, pointer, FactorRange::Unit, Place::Scalar(place))
}

const fn number(
    name: &'static str,
    pointer: &'static str,
    range: FactorRange,
    set: fn(&mut Principled, f32),
) -> Factor {
    factor(name, pointer, range, Place::Number(set))
}

/// The path of the base colour with its opacity.
const BASE_COLOR: &str = "pbrMetallicRoughness/baseColorFactor";

/// The opacity, which is the fourth number of the base colour.
const OPACITY: usize = 1;

/// All factors of materials. The first two have one path in a file.
static FACTORS: [Factor; 27] = [
    color("base_color", BASE_COLOR, |m| {
        Some(if m.is_unlit { &mut m.emissive } else { &mut m.base_color })
    }),
    amount("opacity", "", |m| &mut m.opacity),
    amount("metallic", "pbrMetallicRoughness/metallicFactor", |m| &mut m.metallic),
    amount("roughness", "pbrMetallicRoughness/roughnessFactor", |m| {
        &mut m.roughness
    }),
    color("emissive", "emissiveFactor", |m| {
        (!m.is_unlit).then_some(&mut m.emissive)
    }),
    number(
        "emissive_strength",
        "extensions/KHR_materials_emissive_strength/emissiveStrength",
        FactorRange::AtLeast0,
        |m, v| {
            if !m.is_unlit {
                m.emissive_strength = v.max(0.0);
            }
        },
    ),
    number("alpha_cutoff", "alphaCutoff", FactorRange::Unit, |m, v| {
        if let AlphaMode::Mask(cutoff) = &mut m.alpha_mode {
            *cutoff = v;
        }
    }),
    number("normal_scale", "normalTexture/scale", FactorRange::Any, |m, v| {
        m.normal_scale = v;
    }),
    number(
        "ior",
        "extensions/KHR_materials_ior/ior",
        FactorRange::AtLeast1,
        |m, v| {
            m.ior = v.max(1.0);
        },
    ),
    amount(
        "transmission",
        "extensions/KHR_materials_transmission/transmissionFactor",
        |m| &mut m.transmission,
    ),
    amount(
        "diffuse_transmission",
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor",
        |m| &mut m.diffuse_transmission,
    ),
    color(
        "diffuse_transmission_color",
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor",
        |m| Some(&mut m.diffuse_transmission_color),
    ),
    factor(
        "attenuation_color",
        "extensions/KHR_materials_volume/attenuationColor",
        FactorRange::Color,
        Place::AttenuationColor,
    ),
    factor(
        "attenuation_distance",
        "extensions/KHR_materials_volume/attenuationDistance",
        FactorRange::Above0,
        Place::AttenuationDistance,
    ),
    number(
        "dispersion",
        "extensions/KHR_materials_dispersion/dispersion",
        FactorRange::AtLeast0,
        |m, v| m.dispersion = v.max(0.0),
    ),
    amount("clearcoat", "extensions/KHR_materials_clearcoat/clearcoatFactor", |m| {
        &mut m.clearcoat
    }),
    amount(
        "clearcoat_roughness",
        "extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor",
        |m| &mut m.clearcoat_roughness,
    ),
    color("sheen_color", "extensions/KHR_materials_sheen/sheenColorFactor", |m| {
        Some(&mut m.sheen_color)
    }),
    amount(
        "sheen_roughness",
        "extensions/KHR_materials_sheen/sheenRoughnessFactor",
        |m| &mut m.sheen_roughness,
    ),
    amount("specular", "extensions/KHR_materials_specular/specularFactor", |m| {
        &mut m.specular
    }),
    color(
        "specular_color",
        "extensions/KHR_materials_specular/specularColorFactor",
        |m| Some(&mut m.specular_color),
    ),
    amount(
        "iridescence",
        "extensions/KHR_materials_iridescence/iridescenceFactor",
        |m| &mut m.iridescence,
    ),
    number(
        "iridescence_ior",
        "extensions/KHR_materials_iridescence/iridescenceIor",
        FactorRange::AtLeast1,
        |m, v| m.iridescence_ior = v.max(1.0),
    ),
    number(
        "iridescence_thickness_minimum",
        "extensions/KHR_materials_iridescence/iridescenceThicknessMinimum",
        FactorRange::AtLeast0,
        |m, v| m.iridescence_thickness[0] = v.max(0.0) * 1e-9,
    ),
    number(
        "iridescence_thickness",
        "extensions/KHR_materials_iridescence/iridescenceThicknessMaximum",
        FactorRange::AtLeast0,
        |m, v| m.iridescence_thickness[1] = v.max(0.0) * 1e-9,
    ),
    amount(
        "anisotropy",
        "extensions/KHR_materials_anisotropy/anisotropyStrength",
        |m| &mut m.anisotropy,
    ),
    number(
        "anisotropy_rotation",
        "extensions/KHR_materials_anisotropy/anisotropyRotation",
        FactorRange::Angle,
        |m, v| m.anisotropy_rotation = v,
    ),
];

impl Factor {
    /// The factor by this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        FACTORS.iter().find(|factor| factor.name == name)
    }

    /// The names of all factors.
    pub fn names() -> impl Iterator<Item = &'static str> {
        FACTORS.iter().map(|factor| factor.name)
    }
}

impl FactorRange {
    /// The numbers that are allowed, in words, if `v` is none of them.
    pub fn expected(self, v: f64) -> Option<&'static str> {
        let (is_in, what) = match self {
            _ if !(v as f32).is_finite() => (false, "a finite number"),
            Self::Color | Self::AtLeast0 => (v >= 0.0, "a number of at least 0"),
            Self::Unit => ((0.0..=1.0).contains(&v), "a number from 0 to 1"),
            Self::AtLeast1 => (v >= 1.0, "a number of at least 1"),
            Self::Above0 => (v > 0.0, "a number above 0"),
            Self::Any | Self::Angle => (true, ""),
        };
        (!is_in).then_some(what)
    }
}

/// The property of a material that a path in a file names.
#[derive(Clone, Copy, Debug)]
pub struct MaterialProperty {
    /// The number of numbers.
    pub width: usize,
    factor: &'static Factor,
}

impl MaterialProperty {
    /// The property at this path in a material of the file.
    pub fn of_path(path: &str) -> Option<Self> {
        let factor = FACTORS
            .iter()
            .find(|factor| factor.pointer == path && !path.is_empty())?;
        let width = match factor.range {
            _ if path == BASE_COLOR => 4,
            FactorRange::Color => 3,
            _ => 1,
        };
        Some(Self { width, factor })
    }
}

impl MaterialMotion {
    /// The motion of a surface that no file says more of than this.
    pub fn of_surface(material: usize, surface: Principled) -> Self {
        Self {
            material,
            surface,
            attenuation: (surface.absorption.map(|a| exponential::exp(-a)), 1.0),
        }
    }

    pub(super) fn animate(&mut self, property: MaterialProperty, keys: &Keys, time: f32) {
        let mut numbers = [0.0; 4];
        for (number, v) in numbers.iter_mut().zip(keys.at(time)) {
            *number = v as f32;
        }
        let [r, g, b, alpha] = numbers;
        self.set(property.factor, [r, g, b].map(Some));
        if property.width == 4 {
            self.set(&FACTORS[OPACITY], [Some(alpha), None, None]);
        }
    }

    /// Sets a factor to these numbers, of a colour to those that there are.
    pub(super) fn set(&mut self, factor: &Factor, numbers: [Option<f32>; 3]) {
        let first = numbers[0].unwrap_or_default();
        let merged = |old: Rgb| {
            let old = old.to_array();
            Rgb::from_array(std::array::from_fn(|i| numbers[i].unwrap_or(old[i]).max(0.0)))
        };
        match factor.place {
            Place::Color(place) => {
                if let Some(color) = place(&mut self.surface) {
                    *color = match *color {
                        Color::Constant(old) => Color::Constant(merged(old)),
                        Color::Texture(id) => Color::Tinted(id, merged(Rgb::WHITE)),
                        Color::Tinted(id, old) => Color::Tinted(id, merged(old)),
                    };
                }
            }
            Place::Scalar(place) => {
                let (Scalar::Constant(v) | Scalar::Texture(_, _, v) | Scalar::Inverted(_, _, v)) =
                    place(&mut self.surface);
                *v = first.clamp(0.0, 1.0);
            }
            Place::Number(set) => set(&mut self.surface, first),
            Place::AttenuationColor => {
                self.attenuation.0 = merged(self.attenuation.0);
                self.absorb();
            }
            Place::AttenuationDistance => {
                self.attenuation.1 = first;
                self.absorb();
            }
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_have_the_names_of_the_principled_material() {
        let page = include_str!("../../material/principled.rs");
        for name in Factor::names().filter(|name| *name != "iridescence_thickness_minimum") {
            assert!(page.contains(&format!("`{name}`")), "{name}");
        }
    }

    #[test]
    fn a_component_of_a_colour_keeps_the_others() {
        let surface = Principled::matte(Color::Constant(Rgb::new(0.1, 0.2, 0.3)));
        let mut motion = MaterialMotion::of_surface(0, surface);
        let base_color = Factor::named("base_color").expect("it is one");
        motion.set(base_color, [None, Some(0.7), None]);
        let Color::Constant(found) = motion.surface.base_color else {
            panic!("it has no texture");
        };
        assert_eq!(found.to_array(), [0.1, 0.7, 0.3]);
    }
}
