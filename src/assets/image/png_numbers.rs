//! Numbers of data in PNG files of 16 bits, such as ids and depths. No display shows them.

use std::{fmt, io::Cursor};

/// What the numbers of a PNG file are: those of a file of 16 bits that is gray, or that has a text with their unit.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PngNumbers {
    /// The name of the pass, if the file tells it.
    pub pass: Option<String>,
    pub unit: Option<String>,
}

impl PngNumbers {
    /// Those of the file with these bytes; `None` of pictures for displays and of other formats.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        let reader = ::png::Decoder::new(Cursor::new(bytes)).read_info().ok()?;
        let info = reader.info();
        // The program writes these texts in ASCII.
        let text = |name: &str| {
            let mut texts = info.uncompressed_latin1_text.iter();
            texts.find(|text| text.keyword == name).map(|text| text.text.clone())
        };
        let [pass, unit] = ["Pass", "Unit"].map(text);
        let is_data = info.color_type == ::png::ColorType::Grayscale || unit.is_some();
        (info.bit_depth == ::png::BitDepth::Sixteen && is_data).then_some(Self { pass, unit })
    }

    /// Whether two files may hold the same quantity: where both name a pass or a unit, it is the same.
    pub fn may_be(&self, other: &Self) -> bool {
        let agree = |a: &Option<String>, b: &Option<String>| a.is_none() || b.is_none() || a == b;
        agree(&self.pass, &other.pass) && agree(&self.unit, &other.unit)
    }

    /// Whether they are names, of which no two are near each other.
    pub fn are_ids(&self) -> bool {
        self.pass.as_deref() == Some("objectId")
    }

    /// The number of a display value from 0 to 1: a component of normals, or the whole number that the file holds.
    pub fn decode(&self, v: f32) -> f32 {
        let whole = (v * 65535.0).round();
        match self.pass.as_deref() {
            Some("N") => (whole - 32768.0) / 32767.0,
            _ => whole,
        }
    }
}

impl fmt::Display for PngNumbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [pass, unit] = [&self.pass, &self.unit].map(|text| text.as_deref().unwrap_or("numbers"));
        write!(f, "{pass} ({unit})")
    }
}
