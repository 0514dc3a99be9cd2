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

/// The options of an object for the point lights and spots of its model.
#[derive(Clone, Copy, Debug)]
pub(super) struct LampOptions {
    /// In m.
    pub radius: Option<NonNegative>,
    /// The factor of their intensities.
    pub factor: f32,
}

/// The light of a model at `place` in the world, with these options unless it is a sun; `None` where it does not shine.
pub(super) fn describe(light: &ModelLight, place: DAffine3, lamps: LampOptions) -> Option<LightDesc> {
    let position = unspanned(Point::new(place.translation));
    let radius = lamps.radius.map(unspanned);
    let direction = (-place.matrix3.z_axis).try_normalize().map(|d| Direction(d.as_vec3()));
    let factor = match light.kind {
        ModelLightKind::Sun => 1.0,
        ModelLightKind::Point | ModelLightKind::Spot { .. } => lamps.factor,
    };
    let strength = light.strength * factor;
    if strength.is_black() {
        return None;
    }
    let strength = RgbFactor(strength);
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
