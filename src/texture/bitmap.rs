//! Images in memory.

use serde::Deserialize;

use crate::math::{Primaries, Rgb, UnitFloat, Vec2, srgb};

/// The value that replaces infinite texels: the largest half.
const MAX_TEXEL: f32 = 65504.0;

/// The fractions of 255: a division takes longer than a look-up.
const FRACTIONS: [f32; 256] = {
    let mut all = [0.0; 256];
    let mut i = 0;
    while i < 256 {
        all[i] = i as f32 / 255.0;
        i += 1;
    }
    all
};

/// The meaning of the numbers of an integer format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColorSpace {
    /// Colours as displays show them.
    #[default]
    Srgb,
    /// Data, or light: used as they are.
    Raw,
}

/// A decoded picture; its first row is the top one.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    /// In pixels, at least 1.
    pub width: u32,
    /// In pixels, at least 1.
    pub height: u32,
    /// Numbers of a pixel, next to each other: 1 (gray), 3 (RGB) or 4 (RGB and straight alpha).
    pub channels: usize,
    pub storage: Storage,
    /// Whether alpha is the opacity of the colours: what is not there has no colour, and does not mix with what is.
    pub weighs_by_alpha: bool,
    /// The primaries of colours in it.
    pub primaries: Primaries,
    /// Texels of the file that were NaN or infinite, and became 0 or +-65504.
    pub repaired: u64,
    /// Numbers of colours that are below 0.
    pub negative: u64,
    /// The same picture smaller and smaller, each level half as wide and half as high as the one
    /// before, down to a single texel; none where nobody looks from afar. See [`super::mipmap`].
    pub levels: Vec<Bitmap>,
}

/// The numbers of all pixels, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum Storage {
    /// Display values with sRGB's curve; alpha is without.
    Srgb8(Vec<u8>),
    /// Fractions of 255.
    Linear8(Vec<u8>),
    /// As [`Storage::Srgb8`], in 16 bits.
    Srgb16(Vec<u16>),
    /// Fractions of 65535.
    Linear16(Vec<u16>),
    /// Linear, from 0 to 1: levels of the formats above.
    Unit(Vec<UnitFloat>),
    /// Linear.
    Float(Vec<f32>),
}

impl Bitmap {
    /// A picture of Rec. 709 without levels.
    pub fn new([width, height]: [u32; 2], channels: usize, storage: Storage) -> Self {
        Self {
            width,
            height,
            channels,
            storage,
            weighs_by_alpha: false,
            primaries: Primaries::default(),
            repaired: 0,
            negative: 0,
            levels: Vec::new(),
        }
    }

    /// The linear colour of a texel; `x` from the left and `y` from the top must be inside.
    #[inline]
    pub fn rgb(&self, x: u32, y: u32) -> Rgb {
        let i = self.index(x, y);
        match &self.storage {
            _ if self.channels == 1 => Rgb::gray(self.linear(i)),
            Storage::Float(v) => {
                let texel = &v[i..i + 3];
                Rgb::new(texel[0], texel[1], texel[2])
            }
            _ => Rgb::new(self.linear(i), self.linear(i + 1), self.linear(i + 2)),
        }
    }

    /// The largest value of each channel; white for formats with values up to 1.
    pub fn max_value(&self) -> Rgb {
        match &self.storage {
            Storage::Float(_) => {
                let texels = (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
                texels.fold(Rgb::BLACK, |most, (x, y)| most.max(self.rgb(x, y)))
            }
            _ => Rgb::WHITE,
        }
    }

    /// The largest linear number of a row's texels from `x` to before `end`, alpha apart. Compares codes, of which it decodes one.
    pub fn max_of_row(&self, y: u32, [x, end]: [u32; 2]) -> f32 {
        fn most<T: Copy + PartialOrd + Default>(texels: &[T], channels: usize) -> T {
            let max = |a: T, b: &T| if *b > a { *b } else { a };
            match channels {
                4 => {
                    let colors = texels.chunks_exact(4).flat_map(|texel| &texel[..3]);
                    colors.fold(T::default(), max)
                }
                _ => texels.iter().fold(T::default(), max),
            }
        }
        let (run, n) = (self.index(x, y)..self.index(end, y), self.channels);
        match &self.storage {
            Storage::Srgb8(v) => srgb::decode8(most(&v[run], n)),
            Storage::Linear8(v) => FRACTIONS[usize::from(most(&v[run], n))],
            Storage::Srgb16(v) => srgb::decoded16()[usize::from(most(&v[run], n))],
            Storage::Linear16(v) => f32::from(most(&v[run], n)) / 65535.0,
            Storage::Unit(v) => most(&v[run], n).get(),
            Storage::Float(v) => most(&v[run], n),
        }
    }

    /// The linear colour of column `i` from the left and row `j` from the bottom, as textures
    /// count.
    #[inline]
    pub fn texel_from_bottom(&self, i: u32, j: u32) -> Rgb {
        self.rgb(i, self.height - 1 - j)
    }

    /// Four texels weighed, `f` for the second column and the second row; rows count from the
    /// bottom; `None` is black. The storage is matched once, not for every number.
    #[inline]
    pub fn blend(&self, columns: [Option<u32>; 2], rows: [Option<u32>; 2], f: Vec2) -> Rgb {
        match &self.storage {
            Storage::Srgb8(v) => {
                let table = srgb::decoded();
                self.blend_by(v, columns, rows, f, |v| table[usize::from(v)])
            }
            Storage::Linear8(v) => self.blend_by(v, columns, rows, f, |v| FRACTIONS[usize::from(v)]),
            Storage::Srgb16(v) => {
                let table = srgb::decoded16();
                self.blend_by(v, columns, rows, f, |v| table[usize::from(v)])
            }
            Storage::Linear16(v) => self.blend_by(v, columns, rows, f, |v| f32::from(v) / 65535.0),
            Storage::Unit(v) => self.blend_by(v, columns, rows, f, UnitFloat::get),
            Storage::Float(v) => self.blend_by(v, columns, rows, f, |v| v),
        }
    }

    /// Does the same for the numbers of the storage, each of which `decode` makes linear.
    #[inline(always)]
    fn blend_by<T: Copy>(
        &self,
        numbers: &[T],
        columns: [Option<u32>; 2],
        rows: [Option<u32>; 2],
        f: Vec2,
        decode: impl Fn(T) -> f32,
    ) -> Rgb {
        if self.weighs_by_alpha {
            return self.blend_by_alpha(columns, rows, f);
        }
        let mut sum = Rgb::BLACK;
        for (row, of_row) in [(rows[0], 1.0 - f.y), (rows[1], f.y)] {
            let Some(row) = row else { continue };
            let mut blended = Rgb::BLACK;
            for (column, of_column) in [(columns[0], 1.0 - f.x), (columns[1], f.x)] {
                let Some(column) = column else { continue };
                let at = self.index(column, self.height - 1 - row);
                blended += if self.channels == 1 {
                    Rgb::gray(decode(numbers[at]))
                } else {
                    let texel = &numbers[at..at + 3];
                    Rgb::new(decode(texel[0]), decode(texel[1]), decode(texel[2]))
                } * of_column;
            }
            sum += blended * of_row;
        }
        sum
    }

    /// Four texels weighed by their opacity as well; as if all were opaque where none is.
    fn blend_by_alpha(&self, columns: [Option<u32>; 2], rows: [Option<u32>; 2], f: Vec2) -> Rgb {
        let (mut sum, mut seen, mut weight) = (Rgb::BLACK, Rgb::BLACK, 0.0);
        for (row, of_row) in [(rows[0], 1.0 - f.y), (rows[1], f.y)] {
            for (column, of_column) in [(columns[0], 1.0 - f.x), (columns[1], f.x)] {
                let (Some(row), Some(column)) = (row, column) else {
                    continue;
                };
                let (x, y) = (column, self.height - 1 - row);
                let color = self.rgb(x, y) * (of_row * of_column);
                let alpha = self.alpha(x, y);
                sum += color;
                seen += color * alpha;
                weight += of_row * of_column * alpha;
            }
        }
        if weight > 0.0 { seen / weight } else { sum }
    }

    /// The picture itself (0) or one of its smaller copies; the smallest where `level` is beyond.
    #[inline]
    pub fn level(&self, level: usize) -> &Self {
        match level.min(self.levels.len()).checked_sub(1) {
            None => self,
            Some(at) => &self.levels[at],
        }
    }

    /// A placeholder for a missing image: squares of magenta and black.
    pub fn placeholder() -> Self {
        const SIDE: u32 = 16;
        const SQUARE: u32 = 2;
        let texel = |i: u32| {
            let (x, y) = (i % SIDE / SQUARE, i / SIDE / SQUARE);
            if (x + y).is_multiple_of(2) {
                [255, 0, 255]
            } else {
                [0; 3]
            }
        };
        let storage = Storage::Srgb8((0..SIDE * SIDE).flat_map(texel).collect());
        Self::new([SIDE; 2], 3, storage)
    }

    /// The opacity of a texel: 1 where the picture has no alpha.
    #[inline]
    pub fn alpha(&self, x: u32, y: u32) -> f32 {
        if self.channels < 4 {
            return 1.0;
        }
        let i = self.index(x, y) + 3;
        match &self.storage {
            Storage::Srgb8(v) | Storage::Linear8(v) => f32::from(v[i]) / 255.0,
            Storage::Srgb16(v) | Storage::Linear16(v) => f32::from(v[i]) / 65535.0,
            Storage::Unit(v) => v[i].get(),
            Storage::Float(v) => v[i],
        }
    }

    pub fn has_alpha(&self) -> bool {
        self.channels == 4
    }

    #[inline]
    fn index(&self, x: u32, y: u32) -> usize {
        (y as usize * self.width as usize + x as usize) * self.channels
    }

    #[inline]
    fn linear(&self, i: usize) -> f32 {
        match &self.storage {
            Storage::Srgb8(v) => srgb::decode8(v[i]),
            Storage::Linear8(v) => f32::from(v[i]) / 255.0,
            Storage::Srgb16(v) => srgb::decoded16()[usize::from(v[i])],
            Storage::Linear16(v) => f32::from(v[i]) / 65535.0,
            Storage::Unit(v) => v[i].get(),
            Storage::Float(v) => v[i],
        }
    }

    /// A picture of floats, its numbers finite.
    pub fn from_floats(size: [u32; 2], channels: usize, mut values: Vec<f32>) -> Self {
        let mut repaired = 0;
        for v in values.iter_mut().filter(|v| !v.is_finite()) {
            *v = if v.is_nan() { 0.0 } else { MAX_TEXEL.copysign(*v) };
            repaired += 1;
        }
        let is_negative = |(i, v): &(usize, &f32)| **v < 0.0 && !is_alpha(*i, channels);
        let negative = values.iter().enumerate().filter(is_negative).count() as u64;
        Self {
            repaired,
            negative,
            ..Self::new(size, channels, Storage::Float(values))
        }
    }
}

/// Whether number `i` of a picture is an opacity, which no curve applies to.
pub(super) fn is_alpha(i: usize, channels: usize) -> bool {
    channels == 4 && i % 4 == 3
}
