//! Pictures in memory.

use crate::math::{Rgb, trig};

/// A picture, row by row from the top, in scene-linear colour.
#[derive(Clone, Debug)]
pub struct Bitmap {
    width: u32,
    height: u32,
    texels: Texels,
}

/// Eight bits a channel are kept as they are, with the table that makes them linear: a quarter of the memory.
#[derive(Clone, Debug)]
enum Texels {
    Bytes { rgb: Vec<[u8; 3]>, linear: Box<[f32; 256]> },
    Floats(Vec<[f32; 3]>),
}

impl Bitmap {
    /// From bytes; `None` unless there are `width * height` of them, and at least one.
    pub fn from_bytes(width: u32, height: u32, rgb: Vec<[u8; 3]>, linear: [f32; 256]) -> Option<Self> {
        fits(width, height, rgb.len()).then(|| Self {
            width,
            height,
            texels: Texels::Bytes {
                rgb,
                linear: Box::new(linear),
            },
        })
    }

    /// From scene-linear numbers; `None` unless there are `width * height` of them, and at least one.
    pub fn from_f32(width: u32, height: u32, rgb: Vec<[f32; 3]>) -> Option<Self> {
        fits(width, height, rgb.len()).then_some(Self {
            width,
            height,
            texels: Texels::Floats(rgb),
        })
    }

    pub fn width(&self) -> u32 {
        self.width
    }

    pub fn height(&self) -> u32 {
        self.height
    }

    /// Column `i` from the left, row `j` from the bottom.
    #[inline]
    pub fn texel_from_bottom(&self, i: u32, j: u32) -> Rgb {
        let at = (self.height - 1 - j) as usize * self.width as usize + i as usize;
        match &self.texels {
            Texels::Bytes { rgb, linear } => Rgb::from_array(rgb[at].map(|b| linear[b as usize])),
            Texels::Floats(rgb) => Rgb::from_array(rgb[at]),
        }
    }
}

fn fits(width: u32, height: u32, len: usize) -> bool {
    len > 0 && len as u64 == u64::from(width) * u64::from(height)
}

/// The bytes of a picture whose numbers are used as they are: 0 to 1.
pub fn raw_table() -> [f32; 256] {
    std::array::from_fn(|b| b as f32 / 255.0)
}

/// The bytes of an sRGB picture made scene-linear. Source: IEC 61966-2-1:1999.
pub fn srgb_table() -> [f32; 256] {
    raw_table().map(|v| {
        if v <= 0.04045 {
            v / 12.92
        } else {
            trig::pow((v + 0.055) / 1.055, 2.4)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_runs_from_black_to_white_through_middle_gray() {
        let t = srgb_table();
        assert_eq!((t[0], t[255]), (0.0, 1.0));
        assert!((t[188] - 0.5029).abs() < 1e-3);
    }

    #[test]
    fn a_bitmap_needs_a_texel_for_every_place() {
        assert!(Bitmap::from_f32(2, 2, vec![[0.0; 3]; 3]).is_none());
        assert!(Bitmap::from_f32(0, 0, vec![]).is_none());
    }
}
