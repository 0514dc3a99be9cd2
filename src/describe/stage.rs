//! The stage of a scene: the light around it, its sun and the lens of its camera, which single flags set whatever the file says.
//!
//! A value of the stage is more than that of one key: a lens of 50 mm takes the place of a field of view, and a map of the
//! environment that of a colour.

use std::borrow::Cow;

use toml::de::{DeArray, DeTable, DeValue};

use super::placed::placed;
use crate::{
    camera::Timing,
    math::{DVec3, transform::axis_rotation},
    value::{Problem, Span, Spanned},
};

/// A value of the stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The path of an environment map, which starts at the current folder.
    Environment,
    /// The colour that the camera sees in place of the background.
    Backdrop,
    /// The direction of the sun, and perhaps its irradiance: see [`Stage::sun`].
    Sun,
    /// The focal length, in mm, with a sensor that is 36 mm wide.
    Lens,
    /// The f-number of the lens.
    FStop,
}

/// The irradiance and the angular diameter of a sun in a scene that has none, in W m^-2 and degrees.
const NEW_IRRADIANCE: &str = "2.2";
const NEW_ANGLE: &str = "0.53";

/// The width of the sensor, in mm.
const SENSOR_WIDTH: &str = "36.0";

impl Stage {
    /// All values, in the order in which flags set them.
    pub const ALL: [Self; 5] = [Self::Environment, Self::Backdrop, Self::Sun, Self::Lens, Self::FStop];

    /// The name after `stage.`, by which requests keep it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Environment => "environment",
            Self::Backdrop => "backdrop",
            Self::Sun => "sun",
            Self::Lens => "lens",
            Self::FStop => "fstop",
        }
    }

    /// The value of a sun in the direction of an azimuth and an elevation, in degrees. The azimuth 0 is +z, 90
    /// is +x, and the elevation 90 is +y.
    pub fn sun(azimuth: f64, elevation: f64, irradiance: Option<f64>) -> toml::Value {
        let light = axis_rotation(1, azimuth) * axis_rotation(0, -elevation) * -DVec3::Z;
        let direction = toml::Value::from(light.to_array().to_vec());
        [direction]
            .into_iter()
            .chain(irradiance.map(toml::Value::from))
            .collect::<Vec<_>>()
            .into()
    }

    /// Sets the value in the table of a scene file.
    pub(super) fn apply<'i>(self, table: &mut DeTable<'i>, value: Spanned<DeValue<'i>>) -> Result<(), Problem> {
        let span = value.span();
        match self {
            Self::Environment => {
                let background = made(table, "background", &span)?;
                for key in ["color", "sky", "gradient", "environment", "backdrop"] {
                    background.remove(key);
                }
                let file = DeTable::from_iter([(key("file", &span), value)]);
                background.insert(key("environment", &span), Spanned::new(span, DeValue::Table(file)));
            }
            Self::Backdrop => {
                let background = made(table, "background", &span)?;
                background.remove("visible");
                background.remove("backdrop");
                background.insert(key("backdrop", &span), value);
            }
            Self::Sun => return sun(table, value),
            Self::Lens => {
                let camera = perspective(table, &span, "a focal length")?;
                for key in [
                    "fov",
                    "fov_x",
                    "focal_length",
                    "sensor_width",
                    "sensor_height",
                    "sensor_fit",
                ] {
                    camera.remove(key);
                }
                camera.insert(key("focal_length", &span), value);
                camera.insert(key("sensor_width", &span), constant(SENSOR_WIDTH, &span));
            }
            Self::FStop => {
                let camera = perspective(table, &span, "an aperture")?;
                for key in ["aperture_radius", "fstop"] {
                    camera.remove(key);
                }
                camera.insert(key("fstop", &span), value);
            }
        }
        Ok(())
    }
}

fn key<'i>(name: &'static str, span: &Span) -> Spanned<Cow<'i, str>> {
    Spanned::new(span.clone(), Cow::Borrowed(name))
}

fn constant<'i>(text: &'static str, span: &Span) -> Spanned<DeValue<'i>> {
    let value = DeValue::parse(text).expect("numbers are TOML");
    placed(value.into_inner(), span)
}

/// The table `name`, which is made if there is none.
fn made<'t, 'i>(table: &'t mut DeTable<'i>, name: &'static str, span: &Span) -> Result<&'t mut DeTable<'i>, Problem> {
    let empty = || Spanned::new(span.clone(), DeValue::Table(DeTable::new()));
    match table.entry(key(name, span)).or_insert_with(empty).get_mut() {
        DeValue::Table(table) => Ok(table),
        other => Err(Problem::at(
            span.clone(),
            format!("`{name}` is no table but of type {}", other.type_str()),
        )),
    }
}

/// The table of the perspective camera of a scene, which has `what`.
fn perspective<'t, 'i>(table: &'t mut DeTable<'i>, span: &Span, what: &str) -> Result<&'t mut DeTable<'i>, Problem> {
    let Some(DeValue::Table(camera)) = table.get_mut("camera").map(Spanned::get_mut) else {
        return Err(Problem::at(span.clone(), "the scene file has no camera with a lens"));
    };
    let kind = camera
        .keys()
        .map(|key| key.get_ref().to_string())
        .find(|key| !Timing::KEYS.contains(&key.as_str()));
    match camera.get_mut("perspective").map(Spanned::get_mut) {
        Some(DeValue::Table(lens)) => Ok(lens),
        _ => {
            let kind = kind.unwrap_or_else(|| "unknown".to_owned());
            let message = format!("only a perspective camera has {what}, the scene's is `{kind}`");
            Err(Problem::at(span.clone(), message))
        }
    }
}

/// Turns the only sun of a scene, or adds one; `value` is what [`Stage::sun`] returns.
fn sun<'i>(table: &mut DeTable<'i>, value: Spanned<DeValue<'i>>) -> Result<(), Problem> {
    let span = value.span();
    let DeValue::Array(given) = value.into_inner() else {
        return Err(Problem::at(span, "expected a direction, and perhaps an irradiance"));
    };
    let background = table
        .get("background")
        .and_then(|background| background.get_ref().as_table());
    if background.is_some_and(|background| background.contains_key("sky")) {
        let message = "the sun of this scene is part of its `sky`, and --sun turns suns that are lights";
        let help = "turn it with --set background.sky.elevation=E and --set background.sky.azimuth=A; A is 180 minus the azimuth of --sun";
        return Err(Problem::at(span, message).with_help(help));
    }
    let mut given = given.into_iter();
    let (direction, irradiance) = (given.next(), given.next());
    let empty = || Spanned::new(span.clone(), DeValue::Array(DeArray::new()));
    let lights = table.entry(key("light", &span)).or_insert_with(empty);
    let DeValue::Array(lights) = lights.get_mut() else {
        return Err(Problem::at(span, "`light` is no list"));
    };
    let suns = lights.iter_mut().filter_map(|light| match light.get_mut() {
        DeValue::Table(light) => light.get_mut("sun"),
        _ => None,
    });
    let mut suns: Vec<_> = suns.collect();
    match &mut suns[..] {
        [] => {
            let mut sun = DeTable::new();
            sun.insert(key("irradiance", &span), constant(NEW_IRRADIANCE, &span));
            sun.insert(key("angle", &span), constant(NEW_ANGLE, &span));
            turn(&mut sun, direction, irradiance, &span);
            let sun = Spanned::new(span.clone(), DeValue::Table(sun));
            let mut light = DeTable::new();
            light.insert(key("sun", &span), sun);
            lights.push(Spanned::new(span, DeValue::Table(light)));
        }
        [sun] => {
            if let DeValue::Table(sun) = sun.get_mut() {
                turn(sun, direction, irradiance, &span);
            }
        }
        suns => {
            let message = format!("the scene has {} suns, and this flag turns one", suns.len());
            let help = "--set light.NAME.sun.direction=[x,y,z] turns that of this name";
            return Err(Problem::at(span, message).with_help(help));
        }
    }
    Ok(())
}

/// Gives the table of a sun a direction and an irradiance, where these are given.
fn turn<'i>(
    sun: &mut DeTable<'i>,
    direction: Option<Spanned<DeValue<'i>>>,
    irradiance: Option<Spanned<DeValue<'i>>>,
    span: &Span,
) {
    if let Some(direction) = direction {
        sun.remove("direction");
        sun.insert(key("direction", span), direction);
    }
    if let Some(irradiance) = irradiance {
        for key in ["irradiance", "exposure"] {
            sun.remove(key);
        }
        sun.insert(key("irradiance", span), irradiance);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn azimuth_0_is_towards_the_viewer_and_90_to_the_right() {
        let direction = |azimuth, elevation| Stage::sun(azimuth, elevation, None).to_string();
        for (at, expected) in [
            ((0.0, 0.0), [0.0, 0.0, -1.0]),
            ((90.0, 0.0), [-1.0, 0.0, 0.0]),
            ((0.0, 90.0), [0.0, -1.0, 0.0]),
        ] {
            assert_eq!(
                direction(at.0, at.1).replace('-', ""),
                format!("[{expected:?}]").replace('-', "")
            );
        }
        let toml::Value::Array(all) = Stage::sun(30.0, 45.0, Some(3.0)) else {
            panic!("it is a list");
        };
        let direction: Vec<f64> = all[0].clone().try_into().expect("three numbers");
        let (h, expected) = (0.5_f64.sqrt(), [0.5, 0.0, 0.75_f64.sqrt()]);
        for (found, expected) in direction.iter().zip([-h * expected[0], -h, -h * expected[2]]) {
            assert!((found - expected).abs() < 1e-15, "{direction:?}");
        }
        assert_eq!(all[1].as_float(), Some(3.0));
    }
}
