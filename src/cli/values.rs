//! The values of flags, as they are typed.

use std::time::Duration;

use batch_render::{describe::Stage, math::srgb, shape::mesh::LightUnits};
use clap::builder::{PossibleValuesParser, TypedValueParser};

/// Reads the name of a unit of lights.
pub fn light_units() -> impl TypedValueParser<Value = LightUnits> {
    PossibleValuesParser::new(LightUnits::ALL.map(LightUnits::name))
        .map(|name| name.parse().expect("a possible value is the name of one"))
}

/// Reads the path of a key and its value, in TOML or as a text.
pub fn assignment(text: &str) -> Result<(String, toml::Value), String> {
    let (key, value) = text
        .split_once('=')
        .ok_or("expected NAME=VALUE, such as camera.perspective.fov=40")?;
    let (key, value) = (key.trim(), value.trim());
    if key.split('.').any(str::is_empty) {
        return Err("expected the path of a key before the =, such as render.seed".into());
    }
    Ok((key.to_owned(), value.parse().unwrap_or_else(|_| value.into())))
}

/// Reads a colour: a number, three numbers of linear light, or six hexadecimal digits of sRGB.
pub fn color(text: &str) -> Result<toml::Value, String> {
    let wrong = || "expected a number, R,G,B (linear light) or #rrggbb (sRGB), each of at least 0".to_owned();
    if let Some(digits) = text.trim().strip_prefix('#') {
        let number = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6);
        let [_, codes @ ..] = number.ok_or_else(wrong)?.to_be_bytes();
        return Ok(codes.map(|code| f64::from(srgb::decode8(code))).to_vec().into());
    }
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    match numbers.filter(|numbers| numbers.iter().all(|v| *v >= 0.0)).as_deref() {
        Some(&[gray]) => Ok(gray.into()),
        Some(numbers @ [_, _, _]) => Ok(numbers.to_vec().into()),
        _ => Err(wrong()),
    }
}

/// Reads the direction of a sun and perhaps its irradiance.
pub fn sun(text: &str) -> Result<toml::Value, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    match numbers.as_deref() {
        Some(&[_, elevation] | &[_, elevation, _]) if !(-90.0..=90.0).contains(&elevation) => {
            Err("the elevation lies between -90 and 90 degrees".into())
        }
        Some(&[azimuth, elevation]) => Ok(Stage::sun(azimuth, elevation, None)),
        Some(&[azimuth, elevation, irradiance]) if irradiance >= 0.0 => {
            Ok(Stage::sun(azimuth, elevation, Some(irradiance)))
        }
        _ => Err("expected AZIMUTH,ELEVATION in degrees, and perhaps ,IRRADIANCE of at least 0".into()),
    }
}

/// Reads a number of at least 0.
pub fn not_negative(text: &str) -> Result<f64, String> {
    number(text)
        .filter(|v| *v >= 0.0)
        .ok_or_else(|| "expected a number of at least 0".into())
}

/// Reads frames per second, which metadata have as a fraction.
pub fn frame_rate(text: &str) -> Result<f64, String> {
    number(text)
        .filter(|v| (0.001..=1e6).contains(v))
        .ok_or_else(|| "expected a number from 0.001 to 1000000".into())
}

/// Reads a number above 0.
pub fn positive(text: &str) -> Result<toml::Value, String> {
    let value = number(text).filter(|v| *v > 0.0);
    value
        .map(toml::Value::from)
        .ok_or_else(|| "expected a number above 0".into())
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|v: &f64| v.is_finite())
}

/// Reads a size in pixels, such as `1280x720`.
pub fn resolution(text: &str) -> Result<[u32; 2], String> {
    let parsed = text
        .split_once(['x', 'X'])
        .and_then(|(w, h)| Some([w.trim().parse().ok()?, h.trim().parse().ok()?]));
    match parsed {
        None => Err("expected WIDTHxHEIGHT, such as 1280x720".into()),
        Some([0, _] | [_, 0]) => Err("a picture has at least 1x1 pixels".into()),
        Some(size) => Ok(size),
    }
}

/// Reads the corners of a window, `X0,Y0,X1,Y1`.
pub fn crop(text: &str) -> Result<[u32; 4], String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok([x0, y0, x1, y1]),
        Ok([_, _, _, _]) => Err("nothing is left: X1 must exceed X0, and Y1 exceed Y0".into()),
        _ => Err("expected four whole numbers X0,Y0,X1,Y1".into()),
    }
}

/// Reads a radius in metres.
pub fn radius(text: &str) -> Result<f32, String> {
    let radius = text.parse::<f32>().ok().filter(|r| *r > 0.0 && r.is_finite());
    radius.ok_or_else(|| "expected a number above 0, in metres".into())
}

/// The least size without a unit, in bytes: a smaller number lacks its unit.
const SMALLEST_PLAIN: u64 = 1 << 20;

/// Reads a size in bytes, such as `512M` or `8G`.
pub fn size(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let scale = match text[digits.len()..]
        .to_ascii_uppercase()
        .trim_end_matches("IB")
        .trim_end_matches('B')
    {
        "" => 0,
        "K" => 10,
        "M" => 20,
        "G" => 30,
        "T" => 40,
        _ => return Err("expected a size such as 512M or 8G".into()),
    };
    let value: u64 = digits
        .parse()
        .map_err(|_| "expected a size such as 512M or 8G".to_owned())?;
    if digits == text && value < SMALLEST_PLAIN {
        return Err(format!("the unit is missing: write {digits}G or {digits}M"));
    }
    value
        .checked_mul(1 << scale)
        .ok_or_else(|| "the size is too large".into())
}

/// A time such as `90`, `60s`, `10m` or `1h30m`, above 0; a number alone is seconds.
pub fn duration(text: &str) -> Result<Duration, String> {
    let wrong = || "expected a time above 0, such as 60s, 10m or 1h30m".to_owned();
    if let Some(milliseconds) = text.strip_suffix("ms").and_then(|number| number.parse::<f64>().ok()) {
        let seconds = milliseconds / 1000.0;
        return Err(format!("the units are s, m and h: write {seconds}s for {text}"));
    }
    let mut seconds = 0.0;
    for part in text.split_inclusive(|c: char| c.is_ascii_alphabetic()) {
        let number = part.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        let scale = match &part[number.len()..] {
            "" | "s" => 1.0,
            "m" => 60.0,
            "h" => 3600.0,
            _ => return Err(wrong()),
        };
        seconds += number.parse::<f64>().map_err(|_| wrong())? * scale;
    }
    let time = Duration::try_from_secs_f64(seconds).map_err(|_| wrong())?;
    Some(time).filter(|time| !time.is_zero()).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_windows_are_read_as_typed() {
        assert_eq!(size("8G"), Ok(8 << 30));
        assert_eq!(size("512MiB"), Ok(512 << 20));
        assert_eq!(size("8589934592"), Ok(8 << 30));
        assert_eq!(size("16B"), Ok(16));
        assert_eq!(size("8"), Err("the unit is missing: write 8G or 8M".into()));
        assert!(size("lots").is_err());
        let seconds = |text| duration(text).map(|time| time.as_secs_f64());
        assert_eq!(
            ["90", "60s", "10m", "1h30m", "0.5s"].map(seconds),
            [90.0, 60.0, 600.0, 5400.0, 0.5].map(Ok)
        );
        for wrong in ["", "0s", "-1s", "5ms", "ten", "inf"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
        let advice = "the units are s, m and h: write 0.05s for 50ms";
        assert_eq!(duration("50ms"), Err(advice.to_owned()));
        assert_eq!(resolution("640x480"), Ok([640, 480]));
        assert!(resolution("0x480").is_err());
        let assigned = |text| assignment(text).expect("a key and a value").1;
        assert_eq!(assigned("a.b = [1, 2]"), toml::Value::from(vec![1, 2]));
        assert_eq!(assigned("a=b=c"), "b=c".into());
        assert!(assignment("a").is_err() && assignment("a..b=1").is_err());
        let numbers = |text| color(text).map(|color| color.to_string());
        assert_eq!(numbers("0.18"), Ok("0.18".into()));
        assert_eq!(numbers("1,0.5,0"), Ok("[1.0, 0.5, 0.0]".into()));
        assert_eq!(numbers("#ff00ff"), Ok("[1.0, 0.0, 1.0]".into()));
        for wrong in ["-1", "1,2", "#fff", "#12345z", "white", "nan"] {
            assert!(color(wrong).is_err(), "{wrong}");
        }
        assert!(sun("10,45").is_ok() && sun("-10,45,3").is_ok());
        for wrong in ["10", "10,91", "1,2,3,4", "1,2,-3", "north,45"] {
            assert!(sun(wrong).is_err(), "{wrong}");
        }
        assert!(positive("50").is_ok() && positive("0").is_err() && positive("inf").is_err());
        assert_eq!(crop("1,2,3,4"), Ok([1, 2, 3, 4]));
        assert!(crop("3,2,3,4").is_err());
    }
}
