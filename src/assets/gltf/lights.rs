//! Lights of KHR_lights_punctual.

use ::gltf::json::Value;
use glam::DAffine3;

use super::{
    document::{Document, get},
    error::GltfProblem,
};
use crate::{
    assets::model::{ModelLight, ModelLightKind},
    math::Rgb,
};

/// The light of KHR_lights_punctual that a node carries.
pub(super) fn light(document: &Document<'_>, node: usize, place: DAffine3) -> Result<Option<ModelLight>, GltfProblem> {
    const NAME: &str = "KHR_lights_punctual";
    fn extension(value: &Value) -> Option<&Value> {
        value.get("extensions").and_then(|e| e.get(NAME))
    }
    let carried = document.raw.get("nodes").and_then(|n| n.get(node)).and_then(extension);
    let Some(index) = carried.and_then(|e| e.get("light").and_then(Value::as_u64)) else {
        return Ok(None);
    };
    let lights = extension(&document.raw).and_then(|e| e.get("lights").and_then(Value::as_array));
    let lights = lights.map_or(&[][..], Vec::as_slice);
    let light = get(lights, usize::try_from(index).unwrap_or(usize::MAX), "light")?;
    let number = |from: &Value, key: &str, default: f64| from.get(key).and_then(Value::as_f64).unwrap_or(default);
    let intensity = number(light, "intensity", 1.0).max(0.0) as f32;
    let channel = |i: usize| light.get("color").and_then(|c| c.get(i)).and_then(Value::as_f64);
    let color = [0, 1, 2].map(|i| channel(i).unwrap_or(1.0).max(0.0) as f32 * intensity);
    let kind = match light.get("type").and_then(Value::as_str) {
        Some("point") => ModelLightKind::Point,
        Some("directional") => ModelLightKind::Sun,
        Some("spot") => {
            let spot = light.get("spot").unwrap_or(&Value::Null);
            let outer = number(spot, "outerConeAngle", std::f64::consts::FRAC_PI_4);
            let outer = outer.clamp(1e-4, std::f64::consts::FRAC_PI_2);
            let inner = number(spot, "innerConeAngle", 0.0).clamp(0.0, outer);
            ModelLightKind::Spot { inner, outer }
        }
        other => {
            return Err(GltfProblem::broken(format!(
                "light {index} is of an unknown type: {}",
                other.unwrap_or("none")
            )));
        }
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
