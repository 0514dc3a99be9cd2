//! Display values: from the numbers of a film to pixels of 8 or 16 bits.
//!
//! A display transform maps light; it is one row of a table with its name in scene files, its curve, and whether the result is
//! sRGB. Exposure, in stops, is applied before the curve. NaN is black.
//!
//! | `view` | curve |
//! |---|---|
//! | `raw` | values as they are, clamped to `[0, 1]` |
//! | `srgb` | the transfer function of IEC 61966-2-1, clamped to `[0, 1]` (the default) |
//! | `reinhard`, `aces`, `agx`, `neutral` | a tone curve, then that of `srgb` |
//!
//! The pass table tells how passes of data are shown ([`Display`]).

use super::tone;
use crate::{
    film::passes::Display,
    kind::named,
    math::{Rgb, WorkingSpace, exponential, hash, srgb},
};

named! {
    /// A mapping of light to display values.
    #[derive(Default)]
    pub enum DisplayTransform: "view" {
        /// The scene's numbers are display values already.
        Raw = "raw",
        #[default]
        Srgb = "srgb",
        Reinhard = "reinhard",
        Aces = "aces",
        Agx = "agx",
        /// The neutral tone curve of Khronos.
        Neutral = "neutral",
    }
}

/// A map from the channels of a pixel, after exposure, to display values before their encoding.
type Curve = fn([f32; 3]) -> [f32; 3];

/// Whether a picture may declare that its values are sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisplayEncoding {
    Srgb,
    Unspecified,
}

impl DisplayTransform {
    /// Whether its display values are sRGB.
    pub fn encoding(self) -> DisplayEncoding {
        match self {
            Self::Raw => DisplayEncoding::Unspecified,
            _ => DisplayEncoding::Srgb,
        }
    }

    fn curve(self) -> Curve {
        match self {
            Self::Raw | Self::Srgb => |c| c,
            Self::Reinhard => tone::reinhard,
            Self::Aces => tone::aces,
            Self::Agx => tone::agx,
            Self::Neutral => tone::neutral,
        }
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
    /// The display of a pass: light times `2^exposure`, mapped by `transform`; distances and counts times the same factor; other
    /// data unscaled. Light of another working space is converted to Rec. 709 first, and negative channels become 0.
    pub fn new(display: Display, transform: DisplayTransform, exposure: f32, working_space: WorkingSpace) -> Self {
        let (curve, scaled): (Curve, _) = match display {
            Display::Light => (transform.curve(), true),
            Display::Heat => (heat, true),
            Display::Near => (|[z, ..]| [1.0 - exponential::log2(1.0 + z.max(0.0)) / 10.0; 3], true),
            Display::Signed => (|c| c.map(|v| 0.5 + 0.5 * v), false),
            Display::Fraction => (|c| c.map(|v| v - v.floor()), false),
            Display::Share => (|[v, ..]| [v; 3], false),
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

    /// The factor of the exposure.
    pub fn gain(&self) -> f32 {
        self.gain
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

    /// The dithered 8-bit display values of a pixel: a value is rounded up if its fraction plus its number in `chances`, from 0 to
    /// 1, is at least 1, else down. Values that 8 bits represent exactly do not change where that number is below 1.
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
        // A multiplication would change the bits of integers.
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

/// Dark blue, cyan, green, yellow, red: the hue tells the order of magnitude.
const HEAT: [[f32; 3]; 6] = [
    [0.05, 0.05, 0.3],
    [0.1, 0.35, 0.9],
    [0.1, 0.75, 0.6],
    [0.4, 0.85, 0.2],
    [0.98, 0.8, 0.1],
    [0.85, 0.1, 0.05],
];

/// The colour of a cost by its log2(1 + cost), from 0 to 10.
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

/// A colour for an id (the bits of the first channel), neither very dark nor very bright; black for 0.
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
    fn names_have_small_letters() {
        assert!("sRGB".parse::<DisplayTransform>().is_err());
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
        for transform in DisplayTransform::ALL {
            let display = PixelDisplay::new(Display::Light, transform, 0.0, WorkingSpace::Rec709);
            for l in [0.0, 0.013, 0.2, 0.7, 1.0, 30.0] {
                let (eight, sixteen) = (display.rgb8([l; 3])[0], display.rgb16([l; 3])[0]);
                let exact = f32::from(sixteen) / 257.0;
                assert!(
                    (f32::from(eight) - exact).abs() <= 0.51,
                    "{transform}: {eight} and {exact}"
                );
                let n = 4096;
                let dithered = (0..n).map(|i| display.rgb8_dithered([l; 3], [(i as f32 + 0.5) / n as f32; 3])[0]);
                let mean = dithered.map(f32::from).sum::<f32>() / n as f32;
                assert!((mean - exact).abs() < 1e-3, "{transform}: {mean} and {exact}");
            }
        }
    }

    #[test]
    fn one_stop_doubles_the_light() {
        for transform in DisplayTransform::ALL {
            for l in [0.0, 0.01, 0.2, 0.5] {
                assert_eq!(light(transform, 1.0, l), light(transform, 0.0, 2.0 * l));
            }
        }
        assert_eq!(light(DisplayTransform::Raw, -2.0, 1.0), [64; 3]);
    }
}
