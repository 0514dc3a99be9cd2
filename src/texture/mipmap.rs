//! Mip maps: copies of an image at lower resolutions.
//!
//! Each level is half as wide and half as high as the one before, rounded down, and at least 1. A
//! texel is the mean of the texels that it covers, in linear light. Along an axis with an odd
//! number of texels it covers two whole texels and fractions of their neighbours, so the mean of
//! the image is preserved. Levels of floats are floats. Those of other images are [`UnitFloat`]s in
//! linear light, so that the mean of a dark image does not round to 0. All levels together take a
//! third of the memory of the image, and two thirds of it where a number of the image is a byte.
//! Straight alpha is averaged like a colour. Where it is the opacity of the colours, they are weighed
//! by it: what cannot be seen has no colour.
//!
//! Source: Williams, "Pyramidal Parametrics", SIGGRAPH 1983, doi:10.1145/800059.801126; for odd
//! sizes Guthe and Heckbert, "Non-Power-of-Two Mipmapping", NVIDIA technical report, 2005.

use std::ops::Range;

use super::{
    Bitmap, Texture,
    bitmap::{Storage, is_alpha},
};
use crate::math::{UnitFloat, parallel, srgb};

/// Gives levels to the bitmaps that one of `textures` looks at from afar, on the threads of the
/// current rayon pool, and takes those of the others. Levels that are there stay.
pub fn add_levels(textures: &[Texture], bitmaps: &mut [Bitmap]) {
    let mut wanted = vec![false; bitmaps.len()];
    for texture in textures {
        if let Some(bitmap) = texture.pattern.filtered_bitmap() {
            wanted[bitmap.0 as usize] = true;
        }
    }
    parallel::for_each(bitmaps.iter_mut().zip(wanted), |(bitmap, is_wanted)| match is_wanted {
        true if bitmap.levels.is_empty() => build(bitmap),
        true => {}
        false => bitmap.levels = Vec::new(),
    });
}

/// Gives `bitmap` its levels.
pub fn build(bitmap: &mut Bitmap) {
    bitmap.levels.clear();
    let mut smaller = Smaller::new(bitmap);
    let mut levels = Vec::new();
    while smaller.halve() {
        let storage = match bitmap.storage {
            Storage::Float(_) => Storage::Float(smaller.values.clone()),
            _ => Storage::Unit(smaller.values.iter().map(|v| UnitFloat::new(*v)).collect()),
        };
        levels.push(smaller.picture(storage));
    }
    bitmap.levels = levels;
}

/// The picture at half of its size, `times` times over, or down to a single texel.
pub fn halved(bitmap: Bitmap, times: u32) -> Bitmap {
    let mut smaller = Smaller::new(&bitmap);
    let count = (0..times).take_while(|_| smaller.halve()).count();
    if count == 0 {
        return bitmap;
    }
    Bitmap {
        repaired: bitmap.repaired,
        negative: bitmap.negative,
        ..smaller.picture(stored_like(&bitmap.storage, bitmap.channels, &smaller.values))
    }
}

/// A picture that gets smaller and smaller.
struct Smaller<'a> {
    bitmap: &'a Bitmap,
    size: [u32; 2],
    /// Its numbers before they are rounded to bytes, so that errors do not add up; empty before the first step.
    values: Vec<f32>,
}

impl<'a> Smaller<'a> {
    fn new(bitmap: &'a Bitmap) -> Self {
        Self {
            bitmap,
            size: [bitmap.width, bitmap.height],
            values: Vec::new(),
        }
    }

    /// Halves it; returns whether it was more than a single texel.
    fn halve(&mut self) -> bool {
        if self.size == [1, 1] {
            return false;
        }
        let half = self.size.map(|n| (n / 2).max(1));
        let (bitmap, values) = (self.bitmap, &self.values);
        let how = (bitmap.channels, bitmap.weighs_by_alpha);
        self.values = shrink(self.size, half, how, &|first, row| match &values[..] {
            [] => read_linear(bitmap, first, row),
            values => row.copy_from_slice(&values[first..first + row.len()]),
        });
        self.size = half;
        true
    }

    /// The picture of this size, whose numbers are in `storage`.
    fn picture(&self, storage: Storage) -> Bitmap {
        Bitmap {
            weighs_by_alpha: self.bitmap.weighs_by_alpha,
            primaries: self.bitmap.primaries,
            ..Bitmap::new(self.size, self.bitmap.channels, storage)
        }
    }
}

/// Reads a row of numbers in linear light, from number `first` of the picture on.
fn read_linear(bitmap: &Bitmap, first: usize, row: &mut [f32]) {
    let range = first..first + row.len();
    let channels = bitmap.channels;
    let byte = |v: u8| f32::from(v) / 255.0;
    let word = |v: u16| f32::from(v) / 65535.0;
    match &bitmap.storage {
        Storage::Srgb8(v) => {
            let light = srgb::decoded();
            let codes = v[range].iter().enumerate();
            row.iter_mut().zip(codes).for_each(|(to, (i, v))| {
                *to = if is_alpha(i, channels) {
                    byte(*v)
                } else {
                    light[usize::from(*v)]
                };
            });
        }
        Storage::Linear8(v) => row.iter_mut().zip(&v[range]).for_each(|(to, v)| *to = byte(*v)),
        Storage::Srgb16(v) => {
            let light = srgb::decoded16();
            let codes = v[range].iter().enumerate();
            row.iter_mut().zip(codes).for_each(|(to, (i, v))| {
                *to = if is_alpha(i, channels) {
                    word(*v)
                } else {
                    light[usize::from(*v)]
                };
            });
        }
        Storage::Linear16(v) => row.iter_mut().zip(&v[range]).for_each(|(to, v)| *to = word(*v)),
        Storage::Unit(v) => row.iter_mut().zip(&v[range]).for_each(|(to, v)| *to = v.get()),
        Storage::Float(v) => row.copy_from_slice(&v[range]),
    }
}

fn stored_like(storage: &Storage, channels: usize, values: &[f32]) -> Storage {
    let byte = |v: f32| (v * 255.0).round() as u8;
    let word = |v: f32| (v * 65535.0).round() as u16;
    match storage {
        Storage::Srgb8(_) => {
            let code = |i: usize| {
                if is_alpha(i, channels) {
                    byte(values[i])
                } else {
                    srgb::encode8(values[i])
                }
            };
            Storage::Srgb8(parallel::table(values.len(), code))
        }
        Storage::Linear8(_) => Storage::Linear8(values.iter().map(|v| byte(*v)).collect()),
        Storage::Srgb16(_) => {
            let code = |i: usize| {
                if is_alpha(i, channels) {
                    word(values[i])
                } else {
                    srgb::encode16(values[i])
                }
            };
            Storage::Srgb16(parallel::table(values.len(), code))
        }
        Storage::Linear16(_) => Storage::Linear16(values.iter().map(|v| word(*v)).collect()),
        Storage::Unit(_) => Storage::Unit(values.iter().map(|v| UnitFloat::new(*v)).collect()),
        Storage::Float(_) => Storage::Float(values.to_vec()),
    }
}

/// The footprint of a texel along one axis: a run of texels, and the weights of the first, of each
/// within and of the last.
struct Span {
    texels: Range<usize>,
    first: f32,
    within: f32,
    last: f32,
}

impl Span {
    /// The spans of all `to` texels over `from`.
    fn all(from: u32, to: u32) -> Vec<Self> {
        let (from, to) = (u64::from(from), u64::from(to));
        (0..to)
            .map(|i| {
                // In units in which a texel of the larger level is `to` long, and one of the
                // smaller `from`.
                let (begin, end) = (i * from, (i + 1) * from);
                let texels = (begin / to) as usize..end.div_ceil(to) as usize;
                let part = |k: usize| {
                    let k = k as u64;
                    (end.min((k + 1) * to) - begin.max(k * to)) as f32 / from as f32
                };
                Self {
                    first: part(texels.start),
                    within: to as f32 / from as f32,
                    last: part(texels.end - 1),
                    texels,
                }
            })
            .collect()
    }

    #[inline]
    fn weight(&self, k: usize) -> f32 {
        if k == self.texels.start {
            self.first
        } else if k + 1 == self.texels.end {
            self.last
        } else {
            self.within
        }
    }
}

/// The numbers of a picture of size `from` as one of size `to`; `weighs_by_alpha` is that of the picture. `read` fills a
/// row with those from a number on.
fn shrink(
    from: [u32; 2],
    to: [u32; 2],
    (channels, weighs_by_alpha): (usize, bool),
    read: &(dyn Fn(usize, &mut [f32]) + Sync),
) -> Vec<f32> {
    let (columns, rows) = (Span::all(from[0], to[0]), Span::all(from[1], to[1]));
    let stride = from[0] as usize * channels;
    let mut out = vec![0.0; to[0] as usize * to[1] as usize * channels];
    let lines = out.chunks_exact_mut(to[0] as usize * channels).zip(&rows);
    parallel::for_each(lines, |(line, row)| {
        let mut source = vec![0.0; stride];
        let mut seen = vec![[0.0; 3]; if weighs_by_alpha { columns.len() } else { 0 }];
        for y in row.texels.clone() {
            read(y * stride, &mut source);
            let across = row.weight(y);
            for (i, (texel, column)) in line.chunks_exact_mut(channels).zip(&columns).enumerate() {
                for x in column.texels.clone() {
                    let weight = across * column.weight(x);
                    let numbers = &source[x * channels..][..channels];
                    for (sum, v) in texel.iter_mut().zip(numbers) {
                        *sum += weight * v;
                    }
                    if weighs_by_alpha {
                        let weight = weight * numbers[3];
                        for (sum, v) in seen[i].iter_mut().zip(numbers) {
                            *sum += weight * v;
                        }
                    }
                }
            }
        }
        for (texel, seen) in line.chunks_exact_mut(channels).zip(seen) {
            let alpha = texel[3];
            if alpha > 0.0 {
                texel
                    .iter_mut()
                    .zip(seen)
                    .for_each(|(color, seen)| *color = seen / alpha);
            }
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rgb, Vec2, hash};

    fn random(width: u32, height: u32) -> Bitmap {
        let value = |i: u32| hash::unit_f32(hash::mix32(i + 1));
        Bitmap::from_floats([width, height], 3, (0..width * height * 3).map(value).collect())
    }

    fn mean(bitmap: &Bitmap) -> Rgb {
        let mut sum = Rgb::BLACK;
        for y in 0..bitmap.height {
            for x in 0..bitmap.width {
                sum += bitmap.rgb(x, y);
            }
        }
        sum / (bitmap.width * bitmap.height) as f32
    }

    #[test]
    fn every_level_of_any_size_keeps_the_mean_of_the_texels() {
        for [w, h] in [[64, 64], [37, 23], [5, 1], [1, 9], [48, 3]] {
            let mut bitmap = random(w, h);
            build(&mut bitmap);
            let expected = mean(&bitmap);
            for level in &bitmap.levels {
                let there = mean(level);
                assert!((there - expected).map(f32::abs).max_component() < 2e-6, "{w}x{h}");
            }
        }
    }

    #[test]
    fn a_halved_picture_is_its_own_level() {
        let mut bitmap = random(37, 23);
        bitmap.repaired = 3;
        let original = bitmap.clone();
        build(&mut bitmap);
        for times in 1..9 {
            let expected = bitmap.level(times as usize);
            let found = halved(original.clone(), times);
            assert_eq!((found.repaired, &found.storage), (3, &expected.storage), "{times}");
        }
        assert_eq!(halved(original.clone(), 0), original);
    }

    #[test]
    fn levels_halve_down_to_a_single_texel_and_take_a_third_of_the_picture() {
        let mut bitmap = random(37, 23);
        build(&mut bitmap);
        let sizes: Vec<_> = bitmap.levels.iter().map(|l| [l.width, l.height]).collect();
        assert_eq!(sizes, [[18, 11], [9, 5], [4, 2], [2, 1], [1, 1]]);
        let mut square = random(64, 64);
        build(&mut square);
        let texels: u32 = square.levels.iter().map(|l| l.width * l.height).sum();
        assert_eq!(texels, (64 * 64 - 1) / 3);
    }

    #[test]
    fn a_texel_of_an_even_picture_is_the_mean_of_its_four() {
        let mut bitmap = random(8, 4);
        build(&mut bitmap);
        let four = [[4, 2], [5, 2], [4, 3], [5, 3]].map(|[x, y]| bitmap.rgb(x, y));
        let expected = four.into_iter().fold(Rgb::BLACK, |a, b| a + b) / 4.0;
        let there = bitmap.levels[0].rgb(2, 1);
        assert!((there - expected).map(f32::abs).max_component() < 1e-6);
    }

    #[test]
    fn a_constant_picture_is_constant_at_every_level_and_keeps_its_storage_when_halved() {
        for channels in [1, 3, 4] {
            for code in [0, 187, 255] {
                let bytes = vec![code; 13 * 7 * channels];
                for storage in [Storage::Srgb8(bytes.clone()), Storage::Linear8(bytes.clone())] {
                    let mut bitmap = Bitmap::new([13, 7], channels, storage);
                    match halved(bitmap.clone(), 2).storage {
                        Storage::Srgb8(v) | Storage::Linear8(v) => assert_eq!(v, vec![code; 3 * channels]),
                        other => panic!("{other:?}"),
                    }
                    build(&mut bitmap);
                    let expected = bitmap.rgb(0, 0).r;
                    for level in &bitmap.levels {
                        let there = level.rgb(0, 0).r;
                        // White and black are exact.
                        let bound = expected * (1.0 - expected) / 2048.0;
                        assert!((there - expected).abs() <= bound, "{code}: {there} is not {expected}");
                    }
                }
            }
        }
    }

    #[test]
    fn one_white_texel_of_a_million_keeps_its_light_at_every_level() {
        let side = 1024;
        let mut texels = vec![0; side * side];
        texels[side * 37 + 5] = 255;
        let words = texels.iter().map(|v| u16::from(*v) * 257).collect::<Vec<_>>();
        for storage in [
            Storage::Srgb8(texels.clone()),
            Storage::Linear8(texels),
            Storage::Srgb16(words.clone()),
            Storage::Linear16(words),
        ] {
            let mut bitmap = Bitmap::new([side as u32; 2], 1, storage);
            build(&mut bitmap);
            for level in &bitmap.levels {
                let light = mean(level).r * (side * side) as f32;
                assert!((light - 1.0).abs() < 1e-3, "{} texels: {light}", level.width);
            }
        }
    }

    #[test]
    fn black_and_white_mix_as_light_and_not_as_codes() {
        let mut bitmap = Bitmap::new([2, 1], 1, Storage::Srgb8(vec![0, 255]));
        build(&mut bitmap);
        assert_eq!(bitmap.levels[0].rgb(0, 0), Rgb::gray(0.5));
        assert_eq!(halved(bitmap, 1).storage, Storage::Srgb8(vec![188]));
    }

    #[test]
    fn what_cannot_be_seen_has_no_colour_in_smaller_copies_and_between_texels() {
        let leaf = [0.2, 0.8, 0.1, 1.0];
        let nothing = [0.0, 0.0, 0.0, 0.0];
        let half = [0.4, 0.4, 0.4, 0.5];
        let texels = [leaf, nothing, nothing, half, nothing, leaf, nothing, nothing].concat();
        let mut bitmap = Bitmap::from_floats([4, 2], 4, texels);
        bitmap.weighs_by_alpha = true;
        build(&mut bitmap);
        let close = |found: Rgb, expected: [f32; 3]| {
            let difference = found - Rgb::from_array(expected);
            assert!(difference.map(f32::abs).max_component() < 1e-6, "{found:?}");
        };
        let level = &bitmap.levels[0];
        close(level.rgb(0, 0), [0.2, 0.8, 0.1]);
        close(level.rgb(1, 0), [0.4; 3]);
        assert_eq!([level.alpha(0, 0), level.alpha(1, 0)], [0.5, 0.125]);
        // In the last one by the opacity of the four, 0.5 and 0.125.
        close(bitmap.levels[1].rgb(0, 0), [0.24, 0.72, 0.16]);
        let between = |columns: [u32; 2]| bitmap.blend(columns.map(Some), [Some(1), Some(1)], Vec2::new(0.25, 0.0));
        close(between([0, 1]), [0.2, 0.8, 0.1]);
        close(between([2, 3]), [0.4; 3]);
        // None is there: as if all were.
        close(between([1, 2]), [0.0; 3]);
    }
}
