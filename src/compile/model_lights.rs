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

/// The light of a model at `place` in the world, a ball of this radius unless it is a sun; `None` where it does not shine.
pub(super) fn describe(light: &ModelLight, place: DAffine3, radius: Option<NonNegative>) -> Option<LightDesc> {
    if light.strength.is_black() {
        return None;
    }
    let position = unspanned(Point::new(place.translation));
    let radius = radius.map(unspanned);
    let direction = (-place.matrix3.z_axis).try_normalize().map(|d| Direction(d.as_vec3()));
    let strength = RgbFactor(light.strength);
    Some(match light.kind {
        ModelLightKind::Point => LightDesc::Point(PointDesc {
            radius,
            ..PointDesc::new(position, strength)
        }),
        ModelLightKind::Spot { inner, outer } => LightDesc::Spot(SpotDesc {
            position,
            target: None,
            direction: Some(unspanned(direction?)),
            cone_angle: unspanned(Positive(outer.to_degrees() as f32)),
            penumbra_angle: Some(unspanned(NonNegative((outer - inner).to_degrees() as f32))),
            intensity: Some(strength),
            power: None,
            ies: None,
            up: None,
            temperature: None,
            exposure: None,
            radius,
            camera: false,
            reflections: None,
            falloff: Falloff::InverseSquare,
        }),
        ModelLightKind::Sun => LightDesc::Sun(SunDesc {
            direction: direction?,
            irradiance: strength,
            temperature: None,
            exposure: None,
            angle: None,
            limb_darkening: false,
            camera: false,
        }),
    })
}
