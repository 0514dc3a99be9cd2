//! Lights of KHR_lights_punctual.

use ::gltf::json::Value;
use glam::DAffine3;

use super::{
    document::{Document, get},
    error::GltfProblem,
    features::LIGHTS,
};
use crate::{
    assets::model::{LightUnits, ModelLight, ModelLightKind},
    math::Rgb,
    value::one_line,
};

/// The lumens that Blender's exporter writes for a watt: the luminous efficacy of green light.
const LUMENS_PER_WATT: f64 = 683.0;

/// The program that Blender's exporter says it is.
const BLENDER: &str = "Khronos glTF Blender I/O";

/// The lights of a document, and the meaning of their numbers.
pub(super) struct Lights<'a> {
    raw: &'a Value,
    units: LightUnits,
    generator: &'a str,
}

impl<'a> Lights<'a> {
    pub fn new(document: &'a Document<'_>, units: LightUnits) -> Self {
        let generator = document.raw.pointer("/asset/generator").and_then(Value::as_str);
        Self {
            raw: &document.raw,
            units,
            generator: generator.unwrap_or_default(),
        }
    }

    fn is_of_blender(&self) -> bool {
        self.generator.contains(BLENDER)
    }

    /// The number by which intensities and irradiances are divided.
    fn divisor(&self) -> f64 {
        match self.units {
            LightUnits::Photometric => LUMENS_PER_WATT,
            LightUnits::Auto if self.is_of_blender() => LUMENS_PER_WATT,
            LightUnits::Auto | LightUnits::Unitless => 1.0,
        }
    }

    /// The treatment of the lights, in a sentence.
    pub fn treatment(&self) -> String {
        let done = match self.divisor() {
            1.0 => "its lights are taken as they are".to_owned(),
            divisor => format!("its lights are divided by {divisor} lm/W"),
        };
        let units = self.units.name();
        let generator = one_line(self.generator, 80);
        format!("{done} (light units `{units}`; the file was written by `{generator}`)")
    }

    /// The light that a node carries.
    pub fn of_node(&self, node: usize, place: DAffine3) -> Result<Option<ModelLight>, GltfProblem> {
        fn extension(value: &Value) -> Option<&Value> {
            value.get("extensions").and_then(|e| e.get(LIGHTS))
        }
        let carried = self.raw.get("nodes").and_then(|n| n.get(node)).and_then(extension);
        let Some(index) = carried.and_then(|e| e.get("light").and_then(Value::as_u64)) else {
            return Ok(None);
        };
        let lights = extension(self.raw).and_then(|e| e.get("lights").and_then(Value::as_array));
        let lights = lights.map_or(&[][..], Vec::as_slice);
        let light = get(lights, usize::try_from(index).unwrap_or(usize::MAX), "light")?;
        let intensity = number(light, "intensity", 1.0).max(0.0) / self.divisor();
        let channel = |i: usize| light.get("color").and_then(|c| c.get(i)).and_then(Value::as_f64);
        let color = [0, 1, 2].map(|i| (channel(i).unwrap_or(1.0).max(0.0) * intensity) as f32);
        let kind = match light.get("type").and_then(Value::as_str) {
            Some("point") => ModelLightKind::Point,
            Some("directional") => ModelLightKind::Sun,
            Some("spot") => self.spot(light.get("spot").unwrap_or(&Value::Null)),
            // The faults of the file tell it.
            _ => return Ok(None),
        };
        if !color.iter().all(|c| c.is_finite()) {
            return Err(GltfProblem::broken(format!("light {index} is infinitely bright")));
        }
        Ok(Some(ModelLight {
            model_from_light: place,
            strength: Rgb::from_array(color),
            kind,
        }))
    }

    fn spot(&self, spot: &Value) -> ModelLightKind {
        let outer = number(spot, "outerConeAngle", std::f64::consts::FRAC_PI_4);
        let outer = outer.clamp(1e-4, std::f64::consts::FRAC_PI_2);
        let inner = number(spot, "innerConeAngle", 0.0).clamp(0.0, outer);
        let inner = if self.is_of_blender() {
            // Blender's blend is 1 - inner / outer, which Cycles takes as a part of the cosine.
            let cos = libm::cos(outer);
            libm::acos((cos + (1.0 - cos) * (1.0 - inner / outer)).min(1.0))
        } else {
            inner
        };
        ModelLightKind::Spot { inner, outer }
    }
}

fn number(from: &Value, key: &str, default: f64) -> f64 {
    from.get(key).and_then(Value::as_f64).unwrap_or(default)
}
