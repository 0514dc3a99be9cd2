//! Lights of KHR_lights_punctual.

use ::gltf::json::Value;
use glam::DAffine3;

use super::{
    document::{Document, get},
    error::GltfProblem,
    features::LIGHTS,
};
use crate::{
    assets::{
        model::LightUnits,
        motion::{LightParameters, LightShape},
    },
    light::LUMENS_PER_WATT,
    value::one_line,
};

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
    pub fn divisor(&self) -> u32 {
        match self.units {
            LightUnits::Photometric => LUMENS_PER_WATT,
            LightUnits::Auto if self.is_of_blender() => LUMENS_PER_WATT,
            LightUnits::Auto | LightUnits::Unitless => 1,
        }
    }

    /// The treatment of the lights, in a sentence.
    pub fn treatment(&self) -> String {
        let done = match self.divisor() {
            1 => "its lights are taken as they are".to_owned(),
            divisor => format!("its lights are divided by {divisor} lm/W"),
        };
        let units = self.units.name();
        let generator = one_line(self.generator, 80);
        format!("{done} (light units `{units}`; the file was written by `{generator}`)")
    }

    /// The number of the light that a node carries, and its parameters.
    pub fn of_node(&self, node: usize) -> Result<Option<(usize, LightParameters)>, GltfProblem> {
        fn extension(value: &Value) -> Option<&Value> {
            value.get("extensions").and_then(|e| e.get(LIGHTS))
        }
        let carried = self.raw.get("nodes").and_then(|n| n.get(node)).and_then(extension);
        let Some(index) = carried.and_then(|e| e.get("light").and_then(Value::as_u64)) else {
            return Ok(None);
        };
        let lights = extension(self.raw).and_then(|e| e.get("lights").and_then(Value::as_array));
        let lights = lights.map_or(&[][..], Vec::as_slice);
        let index = usize::try_from(index).unwrap_or(usize::MAX);
        let light = get(lights, index, "light")?;
        let channel = |i: usize| light.get("color").and_then(|c| c.get(i)).and_then(Value::as_f64);
        let kind = match light.get("type").and_then(Value::as_str) {
            Some("point") => LightShape::Point,
            Some("directional") => LightShape::Sun,
            Some("spot") => self.spot(light.get("spot").unwrap_or(&Value::Null)),
            // The faults of the file tell it.
            _ => return Ok(None),
        };
        let light = LightParameters {
            kind,
            color: [0, 1, 2].map(|i| channel(i).unwrap_or(1.0)),
            intensity: number(light, "intensity", 1.0) / f64::from(self.divisor()),
        };
        let strength = light.light(DAffine3::IDENTITY).strength;
        if !strength.to_array().iter().all(|c| c.is_finite()) {
            return Err(GltfProblem::broken(format!("light {index} is infinitely bright")));
        }
        Ok(Some((index, light)))
    }

    fn spot(&self, spot: &Value) -> LightShape {
        LightShape::Spot {
            inner: number(spot, "innerConeAngle", 0.0),
            outer: number(spot, "outerConeAngle", std::f64::consts::FRAC_PI_4),
            is_of_blender: self.is_of_blender(),
        }
    }
}

fn number(from: &Value, key: &str, default: f64) -> f64 {
    from.get(key).and_then(Value::as_f64).unwrap_or(default)
}
