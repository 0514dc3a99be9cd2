//! Lights of models, as scene files describe them.

use glam::DAffine3;

use crate::{
    assets::model::{ModelLight, ModelLightKind},
    light::{Falloff, LightDesc, point::PointDesc, spot::SpotDesc, sun::SunDesc},
    value::{Direction, NonNegative, Point, Positive, RgbFactor, Spanned},
};

fn unspanned<T>(value: T) -> Spanned<T> {
    Spanned::new(0..0, value)
}

/// The light of a model at `place` in the world; `None` where it does not shine.
pub(super) fn describe(light: &ModelLight, place: DAffine3) -> Option<LightDesc> {
    if light.strength.is_black() {
        return None;
    }
    let position = Point::new(place.translation);
    let direction = (-place.matrix3.z_axis).try_normalize().map(|d| Direction(d.as_vec3()));
    let strength = RgbFactor(light.strength);
    Some(match light.kind {
        ModelLightKind::Point => LightDesc::Point(PointDesc {
            position,
            intensity: strength,
            falloff: Falloff::InverseSquare,
        }),
        ModelLightKind::Spot { inner, outer } => LightDesc::Spot(SpotDesc {
            position: unspanned(position),
            target: None,
            direction: Some(unspanned(direction?)),
            cone_angle: unspanned(Positive(outer.to_degrees() as f32)),
            penumbra_angle: Some(unspanned(NonNegative((outer - inner).to_degrees() as f32))),
            intensity: strength,
            falloff: Falloff::InverseSquare,
        }),
        ModelLightKind::Sun => LightDesc::Sun(SunDesc {
            direction: direction?,
            irradiance: strength,
            angle: None,
        }),
    })
}
