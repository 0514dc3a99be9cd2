//! Animated GIF files: 256 colours for all frames, which are chosen by median cut, and ordered dithering, whose pattern rests.
//!
//! Source: "Graphics Interchange Format, Version 89a"; Heckbert, "Color Image Quantization for Frame Buffer Display", 1982,
//! <https://doi.org/10.1145/800064.801294>.

use std::io::{self, Write};

use batch_render::math::sorting;

/// The bits of each channel by which colours are counted.
const BITS: u32 = 5;
const LEVELS: usize = 1 << BITS;
const COLORS: usize = 256;

/// The two codes after those of the colours: the first empties the table of codes, the second ends the data.
const CLEAR: u16 = 256;
const END: u16 = 257;
/// The number of codes of at most 12 bits.
const MOST_CODES: usize = 4096;

/// The most columns and rows.
pub const MAX_SIDE: u32 = 0xffff;

/// The colours of a film, and for each cell of the cube of colours the number of the nearest one.
pub struct Palette {
    colors: Vec<[u8; 3]>,
    of_cell: Vec<u8>,
}

/// For each cell of the cube of colours the sums of red, green and blue of its pixels, and their number.
pub struct Histogram {
    cells: Vec<[u64; 4]>,
}

impl Histogram {
    pub fn new() -> Self {
        let cells = vec![[0; 4]; LEVELS.pow(3)];
        Self { cells }
    }

    /// Counts the pixels of a frame, as red, green and blue.
    pub fn add(&mut self, frame: &[u8]) {
        for pixel in frame.as_chunks::<3>().0 {
            let sums = &mut self.cells[cell(*pixel)];
            sums[3] += 1;
            for (sum, value) in sums.iter_mut().zip(pixel) {
                *sum += u64::from(*value);
            }
        }
    }

    /// The colours that suit what was counted.
    pub fn palette(&self) -> Palette {
        let used: Vec<usize> = (0..self.cells.len()).filter(|i| self.cells[*i][3] > 0).collect();
        let mut boxes = vec![used];
        while boxes.len() < COLORS {
            // The box with the longest side, times its pixels.
            let spread = |cells: &Vec<usize>| {
                let sides = (0..3).map(|channel| (side(cells, channel), channel));
                let (longest, channel) = sides
                    .max_by_key(|(side, channel)| (*side, 3 - channel))
                    .unwrap_or((0, 0));
                (longest as u64 * self.count(cells), channel)
            };
            let widest = (0..boxes.len()).map(|i| (spread(&boxes[i]), i));
            let Some(((size, channel), i)) = widest.max_by_key(|((size, _), i)| (*size, COLORS - i)) else {
                break;
            };
            if size == 0 {
                break;
            }
            let halves = self.split(std::mem::take(&mut boxes[i]), channel);
            let [first, second] = halves;
            boxes[i] = first;
            boxes.push(second);
        }
        let colors: Vec<[u8; 3]> = boxes.iter().map(|cells| self.mean(cells)).collect();
        let of_cell = (0..self.cells.len()).map(|cell| nearest(&colors, cell)).collect();
        Palette { colors, of_cell }
    }

    fn count(&self, cells: &[usize]) -> u64 {
        cells.iter().map(|cell| self.cells[*cell][3]).sum()
    }

    /// Two halves of a box, of about as many pixels.
    fn split(&self, mut cells: Vec<usize>, channel: usize) -> [Vec<usize>; 2] {
        sorting::sort_by_key(&mut cells, |cell| level(*cell, channel));
        let half = self.count(&cells) / 2;
        let (mut seen, mut at) = (0, 0);
        while at + 1 < cells.len() && (at == 0 || seen + self.cells[cells[at]][3] <= half) {
            seen += self.cells[cells[at]][3];
            at += 1;
        }
        let second = cells.split_off(at);
        [cells, second]
    }

    fn mean(&self, cells: &[usize]) -> [u8; 3] {
        let count = self.count(cells).max(1);
        std::array::from_fn(|channel| {
            let sum: u64 = cells.iter().map(|cell| self.cells[*cell][channel]).sum();
            ((sum + count / 2) / count) as u8
        })
    }
}

/// The cell of a colour.
fn cell(rgb: [u8; 3]) -> usize {
    rgb.into_iter()
        .fold(0, |cell, value| cell << BITS | usize::from(value >> (8 - BITS)))
}

/// The level of a channel in a cell.
fn level(cell: usize, channel: usize) -> usize {
    cell >> (BITS as usize * (2 - channel)) & (LEVELS - 1)
}

/// The difference between the highest and the lowest level of a channel.
fn side(cells: &[usize], channel: usize) -> usize {
    let levels = || cells.iter().map(|cell| level(*cell, channel));
    levels().max().unwrap_or(0) - levels().min().unwrap_or(0)
}

/// The number of the colour that is nearest to the middle of a cell.
fn nearest(colors: &[[u8; 3]], cell: usize) -> u8 {
    let middle: [i32; 3] = std::array::from_fn(|channel| (level(cell, channel) * 8 + 4) as i32);
    // Green counts most to the eye, and blue least.
    const WEIGHTS: [i32; 3] = [3, 6, 1];
    let distance = |color: &[u8; 3]| -> i32 {
        let parts = color.iter().zip(middle).zip(WEIGHTS);
        parts
            .map(|((value, middle), weight)| weight * (i32::from(*value) - middle).pow(2))
            .sum()
    };
    let number = (0..colors.len()).min_by_key(|i| distance(&colors[*i])).unwrap_or(0);
    number as u8
}

impl Palette {
    /// The numbers of the colours of a frame of so many columns.
    fn numbers(&self, frame: &[u8], columns: usize) -> Vec<u8> {
        // The order of thresholds in squares of four pixels.
        const ORDER: [[i16; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];
        let pixels = frame.as_chunks::<3>().0.iter().enumerate();
        let number = |(i, pixel): (usize, &[u8; 3])| {
            let shift = ORDER[i / columns % 4][i % columns % 4] - 8;
            self.of_cell[cell(pixel.map(|value| (i16::from(value) + shift).clamp(0, 255) as u8))]
        };
        pixels.map(number).collect()
    }
}

/// Writes a film of these frames of at most [`MAX_SIDE`] columns and rows, each of which is shown until the end that `end` tells
/// for its index, in hundredths of a second. It plays for ever.
pub fn write(
    out: &mut dyn Write,
    [width, height]: [u32; 2],
    palette: &Palette,
    end: impl Fn(usize) -> u64,
    frames: impl Iterator<Item = io::Result<Vec<u8>>>,
) -> io::Result<()> {
    let size = [width, height]
        .map(|side| (side.min(MAX_SIDE) as u16).to_le_bytes())
        .concat();
    out.write_all(b"GIF89a")?;
    out.write_all(&size)?;
    // A table of 256 colours of 8 bits.
    out.write_all(&[0xf7, 0, 0])?;
    let mut colors = palette.colors.clone();
    colors.resize(COLORS, [0; 3]);
    out.write_all(colors.as_flattened())?;
    out.write_all(b"\x21\xff\x0bNETSCAPE2.0\x03\x01\0\0\0")?;
    for (i, frame) in frames.enumerate() {
        let start = if i == 0 { 0 } else { end(i - 1) };
        let delay = u16::try_from(end(i) - start).unwrap_or(u16::MAX).max(1);
        let [low, high] = delay.to_le_bytes();
        // Frames stay where they are and nothing is transparent.
        out.write_all(&[0x21, 0xf9, 4, 4, low, high, 0, 0])?;
        out.write_all(&[0x2c, 0, 0, 0, 0])?;
        out.write_all(&size)?;
        out.write_all(&[0, 8])?;
        let packed = pack(&palette.numbers(&frame?, width as usize));
        for block in packed.chunks(255) {
            out.write_all(&[block.len() as u8])?;
            out.write_all(block)?;
        }
        out.write_all(&[0])?;
    }
    out.write_all(b";")
}

/// Bits that follow each other, from the lowest.
#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    rest: u32,
    count: u32,
}

impl Bits {
    fn put(&mut self, code: u16, size: u32) {
        self.rest |= u32::from(code) << self.count;
        self.count += size;
        while self.count >= 8 {
            self.bytes.push(self.rest as u8);
            self.rest >>= 8;
            self.count -= 8;
        }
    }
}

/// Packs numbers by the LZW of the format.
fn pack(numbers: &[u8]) -> Vec<u8> {
    // The code of each code with a number behind it; 0 is none.
    let mut longer = vec![0_u16; MOST_CODES * COLORS];
    let (mut bits, mut size, mut next) = (Bits::default(), 9, END + 1);
    bits.put(CLEAR, size);
    let mut numbers = numbers.iter();
    let mut code = numbers.next().map_or(END, |first| u16::from(*first));
    for &number in numbers {
        let place = usize::from(code) * COLORS + usize::from(number);
        if longer[place] != 0 {
            code = longer[place];
            continue;
        }
        bits.put(code, size);
        if usize::from(next) == MOST_CODES {
            bits.put(CLEAR, size);
            longer.fill(0);
            (size, next) = (9, END + 1);
        } else {
            if usize::from(next) == 1 << size {
                size += 1;
            }
            longer[place] = next;
            next += 1;
        }
        code = number.into();
    }
    bits.put(code, size);
    // A reader adds an entry to its table after the last code as well, so that the next code may have one bit more.
    if usize::from(next) == 1 << size && size < 12 {
        size += 1;
    }
    if code != END {
        bits.put(END, size);
    }
    bits.put(0, 7);
    bits.bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unpacks what `pack` has packed, as the format's document says.
    fn unpack(bytes: &[u8]) -> Vec<u8> {
        let bit = |i: usize| u16::from(bytes[i / 8] >> (i % 8) & 1);
        let (mut at, mut size, mut words, mut out) = (0, 9, Vec::<Vec<u8>>::new(), Vec::new());
        let mut last: Option<Vec<u8>> = None;
        loop {
            let code = (0..size).map(|i| bit(at + i) << i).sum::<u16>();
            at += size;
            match code {
                CLEAR => (size, words, last) = (9, Vec::new(), None),
                END => return out,
                _ => {
                    let known = match code {
                        0..=255 => Some(vec![code as u8]),
                        _ => words.get(usize::from(code) - 258).cloned(),
                    };
                    let word = known.unwrap_or_else(|| {
                        let last = last.clone().unwrap();
                        [&last[..], &last[..1]].concat()
                    });
                    if let Some(last) = &last
                        && words.len() + 258 < MOST_CODES
                    {
                        words.push([&last[..], &word[..1]].concat());
                    }
                    if words.len() + 258 == 1 << size && size < 12 {
                        size += 1;
                    }
                    out.extend(&word);
                    last = Some(word);
                }
            }
        }
    }

    #[test]
    fn numbers_come_back_whatever_their_pattern_and_length() {
        for length in [1, 2, 3, 255, 256, 257, 300, 511, 512, 513, 4000, 4096, 40_000] {
            let mixed = |i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8;
            for numbers in [
                (0..length).map(mixed).collect::<Vec<u8>>(),
                vec![7; length as usize],
                (0..length).map(|i| (i / 3 % 5) as u8).collect(),
            ] {
                assert!(unpack(&pack(&numbers)) == numbers, "{length}");
            }
        }
    }

    #[test]
    fn a_film_of_few_colors_keeps_them() {
        let colors = [[0, 0, 0], [255, 255, 255], [200, 30, 60], [10, 120, 240]];
        let frame: Vec<u8> = (0..400).flat_map(|i| colors[i % 4]).collect();
        let mut histogram = Histogram::new();
        histogram.add(&frame);
        let palette = histogram.palette();
        let mut found = palette.colors.clone();
        found.sort();
        found.dedup();
        let mut expected: Vec<[u8; 3]> = frame.as_chunks::<3>().0.to_vec();
        expected.sort();
        expected.dedup();
        assert_eq!(found, expected);
    }
}
