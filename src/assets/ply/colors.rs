//! Colours of PLY files in any type of numbers.

use super::header::NumberType;
use crate::{
    assets::repair::color_range,
    math::{Vec3, Vec4, srgb},
};

/// The largest distance from the range that is not reported.
const TOLERANCE: f32 = 1e-3;

/// Makes raw numbers of this type linear, from 0 to 1; alpha is that already. Returns a fault where the numbers are not what
/// their type says. Whole numbers are display values of which the largest of their type is 1, floats are linear.
pub(super) fn linearize(colors: &mut [Vec4], number: NumberType) -> Option<String> {
    let (least, most, are_bytes) = color_range(colors.iter().flat_map(|c| c.truncate().to_array()));
    let map = |colors: &mut [Vec4], linear: &dyn Fn(f32) -> f32| {
        for color in colors.iter_mut().filter(|c| c.truncate().is_finite()) {
            let Vec3 { x, y, z } = color.truncate();
            *color = Vec3::new(linear(x), linear(y), linear(z)).extend(color.w);
        }
    };
    let display = |one: f32| move |v: f32| srgb::decode((v / one).clamp(0.0, 1.0));
    let outside = || format!("colours from {least} to {most} are cut to what their type allows");
    match number {
        NumberType::U8 => {
            map(colors, &|v| srgb::decode8(v as u8));
            None
        }
        NumberType::F32 | NumberType::F64 if are_bytes => {
            map(colors, &display(255.0));
            Some(format!(
                "colours are floats up to {most}: they are read as display values up to 255"
            ))
        }
        NumberType::F32 | NumberType::F64 => {
            map(colors, &|v| v.clamp(0.0, 1.0));
            let is_outside = least < -TOLERANCE || most > 1.0 + TOLERANCE;
            is_outside.then(|| format!("colours from {least} to {most} are cut to 0 and 1"))
        }
        // Scripts write colours of 8 bits in the type that is at hand.
        NumberType::I16 | NumberType::I32 | NumberType::U32 if most <= 255.0 && most > 0.0 => {
            map(colors, &display(255.0));
            Some(format!(
                "colours are wide numbers up to {most}: they are read as numbers up to 255"
            ))
        }
        _ => {
            map(colors, &display(number.one() as f32));
            (least < 0.0).then(outside)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The linear value of a gray number among others up to `most`, and whether there is a fault.
    fn gray(value: f32, most: f32, number: NumberType) -> (f32, bool) {
        let mut colors = [value, most].map(|v| Vec3::splat(v).extend(1.0));
        let fault = linearize(&mut colors, number);
        (colors[0].x, fault.is_some())
    }

    #[test]
    fn the_largest_number_of_a_type_is_one() {
        let half = srgb::decode(0.5);
        assert_eq!(gray(255.0, 255.0, NumberType::U8), (1.0, false));
        for (number, most) in [
            (NumberType::I8, 127.0),
            (NumberType::U16, 65_535.0),
            (NumberType::I16, 32_767.0),
            (NumberType::U32, u32::MAX as f32),
            (NumberType::I32, i32::MAX as f32),
        ] {
            let (linear, is_fault) = gray(most / 2.0, most, number);
            assert!((linear - half).abs() < 1e-6 && !is_fault, "{number:?}: {linear}");
        }
        assert_eq!(gray(0.25, 1.0, NumberType::F32), (0.25, false));
    }

    #[test]
    fn numbers_out_of_range_are_cut_and_said() {
        assert_eq!(gray(0.5, 2.0, NumberType::F32), (0.5, true));
        assert_eq!(gray(2.0, 2.5, NumberType::F32), (1.0, true));
        assert_eq!(gray(-0.5, 1.0, NumberType::F64), (0.0, true));
        assert_eq!(gray(-5.0, 127.0, NumberType::I8), (0.0, true));
        assert_eq!(gray(128.0, 255.0, NumberType::F32), (srgb::decode(128.0 / 255.0), true));
        assert_eq!(gray(128.0, 255.0, NumberType::I32), (srgb::decode(128.0 / 255.0), true));
    }
}
