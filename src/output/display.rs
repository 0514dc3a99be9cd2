//! Display values: the curves from the numbers of a film to the values of a picture, of 8 or 16 bits.
//!
//! Light is shown by a display transform, one row of a table: its name in scene files, its curve and whether the result is
//! sRGB. Exposure, in stops, is applied to the light before the curve. NaN is black.
//!
//! | `view` | curve |
//! |---|---|
//! | `raw` | values as they are, clamped to `[0, 1]` |
//! | `srgb` | the transfer function of IEC 61966-2-1, clamped to `[0, 1]` (the default) |
//! | `reinhard`, `aces`, `agx`, `neutral` | a tone curve, then that of `srgb` |
//!
//! Passes of data are shown as their row of the pass table says ([`Display`]).

use super::tone;
use crate::{
    film::passes::Display,
    math::{Rgb, WorkingSpace, exponential, hash, srgb},
};

/// A mapping of light to display values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DisplayTransform {
    /// The scene's numbers are display values already.
    Raw,
    #[default]
    Srgb,
    Reinhard,
    Aces,
    Agx,
    /// The neutral tone curve of Khronos.
    Neutral,
}

/// The name and the curve of a display transform.
struct TransformRow {
    transform: DisplayTransform,
    name: &'static str,
    curve: Curve,
    encoding: DisplayEncoding,
}

/// From the channels of a pixel, exposure applied, to display values before their encoding.
type Curve = fn([f32; 3]) -> [f32; 3];

/// Whether a picture may declare that its values are sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisplayEncoding {
    Srgb,
    Unspecified,
}

impl DisplayTransform {
    const TABLE: &'static [TransformRow; 6] = &[
        TransformRow {
            transform: Self::Raw,
            name: "raw",
            curve: |c| c,
            encoding: DisplayEncoding::Unspecified,
        },
        TransformRow {
            transform: Self::Srgb,
            name: "srgb",
            curve: |c| c,
            encoding: DisplayEncoding::Srgb,
        },
        TransformRow {
            transform: Self::Reinhard,
            name: "reinhard",
            curve: tone::reinhard,
            encoding: DisplayEncoding::Srgb,
        },
        TransformRow {
            transform: Self::Aces,
            name: "aces",
            curve: tone::aces,
            encoding: DisplayEncoding::Srgb,
        },
        TransformRow {
            transform: Self::Agx,
            name: "agx",
            curve: tone::agx,
            encoding: DisplayEncoding::Srgb,
        },
        TransformRow {
            transform: Self::Neutral,
            name: "neutral",
            curve: tone::neutral,
            encoding: DisplayEncoding::Srgb,
        },
    ];

    /// The names of all display transforms, in the order of the table.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Self::TABLE.iter().map(|row| row.name)
    }

    /// The display transform of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::TABLE.iter().find(|row| row.name == name).map(|row| row.transform)
    }

    /// Its name in scene files.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Whether its display values are sRGB.
    pub fn encoding(self) -> DisplayEncoding {
        self.row().encoding
    }

    fn row(self) -> &'static TransformRow {
        // The table is in the order of the enum; a test holds it to that.
        &Self::TABLE[self as usize]
    }
}

/// A curve with its exposure, ready for pixels.
#[derive(Clone, Copy, Debug)]
pub struct PixelDisplay {
    /// The space of the light; Rec. 709 for data.
    working_space: WorkingSpace,
    gain: f32,
    curve: Curve,
    encoding: DisplayEncoding,
}

impl PixelDisplay {
    /// The display of a pass: light by `transform`, made `2^exposure` times as bright; distances and counts scaled by the
    /// same factor; other data as it is. Light of another working space is converted to Rec. 709 first, and what that cannot show
    /// loses its channels below 0.
    pub fn new(display: Display, transform: DisplayTransform, exposure: f32, working_space: WorkingSpace) -> Self {
        let (curve, scaled): (Curve, _) = match display {
            Display::Light => (transform.row().curve, true),
            Display::Heat => (heat, true),
            Display::Near => (|[z, ..]| [1.0 - exponential::log2(1.0 + z.max(0.0)) / 10.0; 3], true),
            Display::Signed => (|c| c.map(|v| 0.5 + 0.5 * v), false),
            Display::Fraction => (|c| c.map(|v| v - v.floor()), false),
            Display::Id => (id, false),
        };
        let encoding = match display {
            Display::Light => transform.encoding(),
            _ => DisplayEncoding::Unspecified,
        };
        let gain = if scaled && exposure != 0.0 {
            exponential::pow(2.0, exposure)
        } else {
            1.0
        };
        Self {
            working_space: if display == Display::Light {
                working_space
            } else {
                WorkingSpace::Rec709
            },
            gain,
            curve,
            encoding,
        }
    }

    /// The 8-bit display values of a pixel.
    pub fn rgb8(&self, channels: [f32; 3]) -> [u8; 3] {
        let encode = match self.encoding {
            DisplayEncoding::Srgb => srgb::encode8,
            DisplayEncoding::Unspecified => quantize,
        };
        self.shown(channels).map(encode)
    }

    /// The 16-bit display values of a pixel.
    pub fn rgb16(&self, channels: [f32; 3]) -> [u16; 3] {
        let encode = match self.encoding {
            DisplayEncoding::Srgb => srgb::encode16,
            DisplayEncoding::Unspecified => quantize16,
        };
        self.shown(channels).map(encode)
    }

    /// The 8-bit display values of a pixel, each rounded up with a chance of what it lies above a code: `chances`, from 0 to
    /// 1, decide. Values that are codes stay what they are.
    pub fn rgb8_dithered(&self, channels: [f32; 3], chances: [f32; 3]) -> [u8; 3] {
        let codes = self.rgb16(channels).map(|v| f32::from(v) / 257.0);
        std::array::from_fn(|i| (codes[i] + chances[i]).floor().min(255.0) as u8)
    }

    /// The display values before their encoding.
    fn shown(&self, channels: [f32; 3]) -> [f32; 3] {
        let channels = match self.working_space {
            WorkingSpace::Rec709 => channels,
            space => space
                .to_rec709(Rgb::from_array(channels))
                .map(|v| v.max(0.0))
                .to_array(),
        };
        // Bits of whole numbers are not to be touched.
        let scaled = if self.gain == 1.0 {
            channels
        } else {
            channels.map(|v| v * self.gain)
        };
        (self.curve)(scaled)
    }
}

/// `v` clamped to `[0, 1]` and rounded to 8 bits, NaN as 0.
pub fn quantize(v: f32) -> u8 {
    // The cast saturates and takes NaN to 0.
    (v * 255.0).round() as u8
}

/// `v` clamped to `[0, 1]` and rounded to 16 bits, NaN as 0.
pub fn quantize16(v: f32) -> u16 {
    (v * 65535.0).round() as u16
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
fn heat([a, b, _]: [f32; 3]) -> [f32; 3] {
    let count = a + b;
    if count.is_nan() || count <= 0.0 {
        return HEAT[0];
    }
    let place = (exponential::ln(1.0 + count) / (10.0 * std::f32::consts::LN_2)).min(1.0) * (HEAT.len() - 1) as f32;
    let i = (place as usize).min(HEAT.len() - 2);
    let f = place - i as f32;
    let (a, b) = (Rgb::from_array(HEAT[i]), Rgb::from_array(HEAT[i + 1]));
    (a * (1.0 - f) + b * f).to_array()
}

/// A colour for the whole number whose bits the first channel has, neither very dark nor very bright; black for 0.
fn id([number, ..]: [f32; 3]) -> [f32; 3] {
    if number.to_bits() == 0 {
        return [0.0; 3];
    }
    let h = hash::mix32(number.to_bits());
    [h, h >> 8, h >> 16].map(|v| (48 + (v & 0xff) * 3 / 4) as f32 / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(transform: DisplayTransform, exposure: f32, l: f32) -> [u8; 3] {
        PixelDisplay::new(Display::Light, transform, exposure, WorkingSpace::Rec709).rgb8([l; 3])
    }

    #[test]
    fn passes_of_data_have_their_own_curves() {
        let show = |display, c| PixelDisplay::new(display, DisplayTransform::Srgb, 0.0, WorkingSpace::Rec709).rgb8(c);
        assert_eq!(show(Display::Signed, [-1.0, 1.0, 0.0]), [0, 255, 128]);
        assert_eq!(show(Display::Fraction, [-0.75, 7.5, 0.0])[..2], [64, 128]);
        let depth = [0.0, 1.0, 1e10].map(|z| show(Display::Near, [z, 0.0, 0.0])[0]);
        assert_eq!(depth, [255, 230, 0]);
        let number = |n| show(Display::Id, [f32::from_bits(n), 0.0, 0.0]);
        assert_eq!(number(0), [0; 3]);
        assert_ne!(number(5), number(6));
    }

    #[test]
    fn the_table_is_in_the_order_of_the_enum() {
        for row in DisplayTransform::TABLE {
            assert_eq!(row.transform.name(), row.name);
            assert_eq!(DisplayTransform::from_name(row.name), Some(row.transform));
        }
        assert_eq!(DisplayTransform::from_name("sRGB"), None);
    }

    #[test]
    fn raw_rounds_to_the_nearest_code() {
        let raw = PixelDisplay::new(Display::Light, DisplayTransform::Raw, 0.0, WorkingSpace::Rec709);
        assert_eq!(raw.rgb8([0.5, 127.4 / 255.0, 1.0]), [128, 127, 255]);
        assert_eq!(raw.rgb8([-3.0, 9.0, f32::NAN]), [0, 255, 0]);
        assert_eq!(raw.rgb8([f32::INFINITY, f32::NEG_INFINITY, 0.0]), [255, 0, 0]);
    }

    #[test]
    fn srgb_shows_middle_gray_as_118() {
        assert_eq!(light(DisplayTransform::Srgb, 0.0, 0.18), [118; 3]);
        assert_eq!(light(DisplayTransform::Srgb, 0.0, f32::NAN), [0; 3]);
    }

    #[test]
    fn sixteen_bits_are_the_same_picture_and_dithering_has_its_mean() {
        for row in DisplayTransform::TABLE {
            let display = PixelDisplay::new(Display::Light, row.transform, 0.0, WorkingSpace::Rec709);
            for l in [0.0, 0.013, 0.2, 0.7, 1.0, 30.0] {
                let (eight, sixteen) = (display.rgb8([l; 3])[0], display.rgb16([l; 3])[0]);
                let exact = f32::from(sixteen) / 257.0;
                assert!(
                    (f32::from(eight) - exact).abs() <= 0.51,
                    "{}: {eight} and {exact}",
                    row.name
                );
                let n = 4096;
                let dithered = (0..n).map(|i| display.rgb8_dithered([l; 3], [(i as f32 + 0.5) / n as f32; 3])[0]);
                let mean = dithered.map(f32::from).sum::<f32>() / n as f32;
                assert!((mean - exact).abs() < 1e-3, "{}: {mean} and {exact}", row.name);
            }
        }
    }

    #[test]
    fn one_stop_doubles_the_light() {
        for transform in DisplayTransform::TABLE.iter().map(|row| row.transform) {
            for l in [0.0, 0.01, 0.2, 0.5] {
                assert_eq!(light(transform, 1.0, l), light(transform, 0.0, 2.0 * l));
            }
        }
        assert_eq!(light(DisplayTransform::Raw, -2.0, 1.0), [64; 3]);
    }
}
