//! Views: the curves from scene-linear light to the display values of an 8-bit picture.
//!
//! A view is one row of a table: its name in scene files, its curve and whether the result is sRGB. Exposure, in
//! stops, is applied to the light before any curve. NaN is black.
//!
//! | name | curve |
//! |---|---|
//! | `raw` | values as they are, clamped to `[0, 1]` |
//! | `srgb` | the transfer function of IEC 61966-2-1, clamped to `[0, 1]` (the default) |
//! | `heat` | R + G as a colour from dark blue (0) over green (31) to red (1023 and more), by the logarithm |
//! | `signed` | half of the values plus one half: -1 is black, 1 white |
//! | `near` | R as gray, from white (0) to black (1023 and more), a tenth of it for every doubling of 1 + R |
//! | `fraction` | values less their whole part |
//! | `id` | a colour for each value of G; black where R is 0 |

use crate::math::{Rgb, hash, srgb, trig};

/// How light becomes display values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// The scene's numbers are display values already.
    Raw,
    #[default]
    Srgb,
    /// Counts, as colours.
    Heat,
    /// Numbers from -1 to 1.
    Signed,
    /// Distances.
    Near,
    /// Numbers of which the whole part does not matter.
    Fraction,
    /// Names, as colours.
    Id,
}

/// What a view is called and does.
struct Row {
    view: View,
    name: &'static str,
    /// Linear light, exposure applied, to 8-bit display values.
    curve: fn(Rgb) -> [u8; 3],
    tag: Tag,
}

/// Whether a picture may say that its values are sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tag {
    Srgb,
    Untagged,
}

impl View {
    const TABLE: &'static [Row; 7] = &[
        Row {
            view: Self::Raw,
            name: "raw",
            curve: |c| each(c, quantize),
            tag: Tag::Untagged,
        },
        Row {
            view: Self::Srgb,
            name: "srgb",
            curve: |c| each(c, srgb::encode8),
            tag: Tag::Srgb,
        },
        Row {
            view: Self::Heat,
            name: "heat",
            curve: heat,
            tag: Tag::Untagged,
        },
        Row {
            view: Self::Signed,
            name: "signed",
            curve: |c| each(c, |v| quantize(0.5 + 0.5 * v)),
            tag: Tag::Untagged,
        },
        Row {
            view: Self::Near,
            name: "near",
            curve: |c| [quantize(1.0 - trig::log2(1.0 + c.r.max(0.0)) / 10.0); 3],
            tag: Tag::Untagged,
        },
        Row {
            view: Self::Fraction,
            name: "fraction",
            curve: |c| each(c, |v| quantize(v - v.floor())),
            tag: Tag::Untagged,
        },
        Row {
            view: Self::Id,
            name: "id",
            curve: id,
            tag: Tag::Untagged,
        },
    ];

    /// The names of all views, in the order of the table.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Self::TABLE.iter().map(|row| row.name)
    }

    /// The view of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::TABLE.iter().find(|row| row.name == name).map(|row| row.view)
    }

    /// What scene files call it.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Whether its display values are sRGB.
    pub fn tag(self) -> Tag {
        self.row().tag
    }

    /// This view of light that is made `2^stops` times as bright.
    pub fn with_exposure(self, stops: f32) -> Display {
        Display {
            gain: if stops == 0.0 { 1.0 } else { trig::pow(2.0, stops) },
            curve: self.row().curve,
        }
    }

    fn row(self) -> &'static Row {
        // The table is in the order of the enum; a test holds it to that.
        &Self::TABLE[self as usize]
    }
}

/// A view with its exposure, ready for pixels.
#[derive(Clone, Copy, Debug)]
pub struct Display {
    gain: f32,
    curve: fn(Rgb) -> [u8; 3],
}

impl Display {
    /// The 8-bit display values of scene-linear `light`.
    pub fn rgb8(&self, light: Rgb) -> [u8; 3] {
        (self.curve)(light * self.gain)
    }
}

/// `v` clamped to `[0, 1]` and rounded to 8 bits, NaN as 0.
pub fn quantize(v: f32) -> u8 {
    // The cast saturates and takes NaN to 0.
    (v * 255.0).round() as u8
}

fn each(c: Rgb, f: impl Fn(f32) -> u8) -> [u8; 3] {
    c.to_array().map(f)
}

/// Dark blue, cyan, green, yellow, red: hue alone tells the order of magnitude, brightness is left to none.
const HEAT: [[f32; 3]; 6] = [
    [0.05, 0.05, 0.3],
    [0.1, 0.35, 0.9],
    [0.1, 0.75, 0.6],
    [0.4, 0.85, 0.2],
    [0.98, 0.8, 0.1],
    [0.85, 0.1, 0.05],
];

/// Ten doublings from the first colour to the last.
fn heat(counts: Rgb) -> [u8; 3] {
    let count = counts.r + counts.g;
    if count.is_nan() || count <= 0.0 {
        return each(Rgb::from_array(HEAT[0]), quantize);
    }
    let place = (trig::ln(1.0 + count) / (10.0 * std::f32::consts::LN_2)).min(1.0) * (HEAT.len() - 1) as f32;
    let i = (place as usize).min(HEAT.len() - 2);
    let f = place - i as f32;
    let (a, b) = (Rgb::from_array(HEAT[i]), Rgb::from_array(HEAT[i + 1]));
    each(a * (1.0 - f) + b * f, quantize)
}

/// Neither very dark nor very bright, so that no name looks like nothing.
fn id(c: Rgb) -> [u8; 3] {
    if c.r == 0.0 {
        return [0; 3];
    }
    let h = hash::mix32(c.g.to_bits());
    [h, h >> 8, h >> 16].map(|v| 48 + ((v & 0xff) * 3 / 4) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_no_light_have_their_own_curves() {
        let show = |view: View, r, g| view.with_exposure(0.0).rgb8(Rgb::new(r, g, 0.0));
        assert_eq!(show(View::Signed, -1.0, 1.0), [0, 255, 128]);
        assert_eq!(show(View::Fraction, -0.75, 7.5)[..2], [64, 128]);
        assert_eq!([0.0, 1.0, 1e10].map(|d| show(View::Near, d, 0.0)[0]), [255, 230, 0]);
        assert_eq!(show(View::Id, 0.0, 5.0), [0; 3]);
        assert_eq!(show(View::Id, 1.0, 5.0), show(View::Id, 2.0, 5.0));
        assert_ne!(show(View::Id, 1.0, 5.0), show(View::Id, 1.0, 6.0));
    }

    #[test]
    fn the_table_is_in_the_order_of_the_enum() {
        for row in View::TABLE {
            assert_eq!(row.view.name(), row.name);
            assert_eq!(View::from_name(row.name), Some(row.view));
        }
        assert_eq!(View::from_name("sRGB"), None);
    }

    #[test]
    fn raw_rounds_to_the_nearest_code() {
        let raw = View::Raw.with_exposure(0.0);
        assert_eq!(raw.rgb8(Rgb::new(0.5, 127.4 / 255.0, 1.0)), [128, 127, 255]);
        assert_eq!(raw.rgb8(Rgb::new(-3.0, 9.0, f32::NAN)), [0, 255, 0]);
        assert_eq!(raw.rgb8(Rgb::new(f32::INFINITY, f32::NEG_INFINITY, 0.0)), [255, 0, 0]);
    }

    #[test]
    fn srgb_shows_middle_gray_as_118() {
        assert_eq!(View::Srgb.with_exposure(0.0).rgb8(Rgb::gray(0.18)), [118; 3]);
        assert_eq!(View::Srgb.with_exposure(0.0).rgb8(Rgb::gray(f32::NAN)), [0; 3]);
    }

    #[test]
    fn one_stop_doubles_the_light() {
        for view in [View::Raw, View::Srgb] {
            for v in [0.0, 0.01, 0.2, 0.5] {
                let exposed = view.with_exposure(1.0).rgb8(Rgb::gray(v));
                assert_eq!(exposed, view.with_exposure(0.0).rgb8(Rgb::gray(2.0 * v)));
            }
        }
        assert_eq!(View::Raw.with_exposure(-2.0).rgb8(Rgb::gray(1.0)), [64; 3]);
    }
}
