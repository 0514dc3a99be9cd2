//! The primaries of an EXR file's colours.
//!
//! Sources: OpenEXR, "Standard Attributes" (`chromaticities`), and Color Interop Forum, "An ID for Color Interop"
//! (`colorInteropID`), of which the linear spaces are known here.

use ::exr::meta::{
    attribute::{AttributeValue, Chromaticities, Text},
    header::{ImageAttributes, LayerAttributes},
};

use crate::math::{Primaries, WorkingSpace};

const D65: [f32; 2] = [0.3127, 0.3290];

/// The linear spaces by their names: red, green, blue, each x and y; the white is D65.
const SPACES: [(&str, [f32; 6]); 4] = [
    ("lin_rec2020_scene", [0.708, 0.292, 0.170, 0.797, 0.131, 0.046]),
    ("lin_p3d65_scene", [0.680, 0.320, 0.265, 0.690, 0.150, 0.060]),
    ("lin_adobergb_scene", [0.64, 0.33, 0.21, 0.71, 0.15, 0.06]),
    ("lin_ciexyzd65_scene", [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
];

/// ACES 2065-1.
const AP0: [f32; 8] = [0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.0770, 0.32168, 0.33767];

/// The primaries that the attributes name; those of Rec. 709 where there are none. The name of a space counts before its numbers.
pub(super) fn named(image: &ImageAttributes, layer: &LayerAttributes) -> Primaries {
    let key = Text::from("colorInteropID");
    let id = match layer.other.get(&key).or_else(|| image.other.get(&key)) {
        Some(AttributeValue::Text(id)) => id.to_string(),
        _ => String::new(),
    };
    by_id(&id).unwrap_or_else(|| image.chromaticities.map_or_else(Primaries::default, by_numbers))
}

fn by_id(id: &str) -> Option<Primaries> {
    match id {
        "lin_rec709_scene" => Some(Primaries::default()),
        "lin_ap1_scene" => Some(Primaries(WorkingSpace::AcesCg.chromaticities())),
        "lin_ap0_scene" => Some(Primaries(AP0)),
        id => {
            let [rx, ry, gx, gy, bx, by] = SPACES.iter().find(|(name, _)| *name == id)?.1;
            Some(Primaries([rx, ry, gx, gy, bx, by, D65[0], D65[1]]))
        }
    }
}

fn by_numbers(c: Chromaticities) -> Primaries {
    let [r, g, b, w] = [c.red, c.green, c.blue, c.white];
    Primaries([r.0, r.1, g.0, g.1, b.0, b.1, w.0, w.1])
}
