//! Small capital letters, three by five dots each.

use image::{Rgb, RgbImage};

/// The size of a dot, in pixels.
const DOT: u32 = 2;
const INK: Rgb<u8> = Rgb([230, 230, 230]);

/// The characters with their five rows from the top, three dots each, left to right.
const GLYPHS: [(char, [u8; 5]); 41] = [
    ('A', [0b010, 0b101, 0b111, 0b101, 0b101]),
    ('B', [0b110, 0b101, 0b110, 0b101, 0b110]),
    ('C', [0b011, 0b100, 0b100, 0b100, 0b011]),
    ('D', [0b110, 0b101, 0b101, 0b101, 0b110]),
    ('E', [0b111, 0b100, 0b110, 0b100, 0b111]),
    ('F', [0b111, 0b100, 0b110, 0b100, 0b100]),
    ('G', [0b011, 0b100, 0b101, 0b101, 0b011]),
    ('H', [0b101, 0b101, 0b111, 0b101, 0b101]),
    ('I', [0b111, 0b010, 0b010, 0b010, 0b111]),
    ('J', [0b001, 0b001, 0b001, 0b101, 0b010]),
    ('K', [0b101, 0b101, 0b110, 0b101, 0b101]),
    ('L', [0b100, 0b100, 0b100, 0b100, 0b111]),
    ('M', [0b101, 0b111, 0b111, 0b101, 0b101]),
    ('N', [0b110, 0b101, 0b101, 0b101, 0b101]),
    ('O', [0b010, 0b101, 0b101, 0b101, 0b010]),
    ('P', [0b110, 0b101, 0b110, 0b100, 0b100]),
    ('Q', [0b010, 0b101, 0b101, 0b111, 0b011]),
    ('R', [0b110, 0b101, 0b110, 0b101, 0b101]),
    ('S', [0b011, 0b100, 0b010, 0b001, 0b110]),
    ('T', [0b111, 0b010, 0b010, 0b010, 0b010]),
    ('U', [0b101, 0b101, 0b101, 0b101, 0b111]),
    ('V', [0b101, 0b101, 0b101, 0b101, 0b010]),
    ('W', [0b101, 0b101, 0b111, 0b111, 0b101]),
    ('X', [0b101, 0b101, 0b010, 0b101, 0b101]),
    ('Y', [0b101, 0b101, 0b010, 0b010, 0b010]),
    ('Z', [0b111, 0b001, 0b010, 0b100, 0b111]),
    ('0', [0b111, 0b101, 0b101, 0b101, 0b111]),
    ('1', [0b010, 0b110, 0b010, 0b010, 0b111]),
    ('2', [0b110, 0b001, 0b010, 0b100, 0b111]),
    ('3', [0b110, 0b001, 0b010, 0b001, 0b110]),
    ('4', [0b101, 0b101, 0b111, 0b001, 0b001]),
    ('5', [0b111, 0b100, 0b110, 0b001, 0b110]),
    ('6', [0b011, 0b100, 0b111, 0b101, 0b111]),
    ('7', [0b111, 0b001, 0b010, 0b010, 0b010]),
    ('8', [0b111, 0b101, 0b111, 0b101, 0b111]),
    ('9', [0b111, 0b101, 0b111, 0b001, 0b110]),
    ('.', [0b000, 0b000, 0b000, 0b000, 0b010]),
    ('-', [0b000, 0b000, 0b111, 0b000, 0b000]),
    ('_', [0b000, 0b000, 0b000, 0b000, 0b111]),
    ('/', [0b001, 0b001, 0b010, 0b100, 0b100]),
    (' ', [0b000; 5]),
];

/// Writes a line of text whose upper left corner is `at`; characters without a glyph are left out.
pub fn write(sheet: &mut RgbImage, at: [u32; 2], text: &str) {
    for (i, c) in text.chars().enumerate() {
        let glyph = GLYPHS.iter().find(|(known, _)| *known == c.to_ascii_uppercase());
        for (row, dots) in glyph.iter().flat_map(|(_, rows)| rows.iter().enumerate()) {
            for column in (0..3).filter(|column| dots >> (2 - column) & 1 == 1) {
                let x = at[0] + DOT * (4 * i as u32 + column);
                let y = at[1] + DOT * row as u32;
                for (dx, dy) in (0..DOT * DOT).map(|k| (k % DOT, k / DOT)) {
                    if let Some(pixel) = sheet.get_pixel_mut_checked(x + dx, y + dy) {
                        *pixel = INK;
                    }
                }
            }
        }
    }
}
