//! Uncompressed films (YUV4MPEG2), which ffmpeg and encoders of films read.
//!
//! Their frames have 8 bits and the full resolution for colours too (4:4:4), by the matrix of BT.709 and in its limited range.
//! Source: ITU-R BT.709-6; the header is that of mjpegtools' yuv4mpeg(5).

use batch_render::{math::parallel, output::FrameImage};

/// The marks of a frame.
const FRAME: &[u8] = b"FRAME\n";

/// The first line of a film of this many columns and rows, at this rate in frames per second.
pub fn header([width, height]: [u32; 2], (frames, seconds): (i32, u32)) -> String {
    format!("YUV4MPEG2 W{width} H{height} F{frames}:{seconds} Ip A1:1 C444 XCOLORRANGE=LIMITED\n")
}

/// A frame over black.
pub fn frame(image: &FrameImage<'_>) -> Vec<u8> {
    let pixels = image.pixels_over_black();
    let mut bytes = vec![0; FRAME.len() + 3 * pixels.len()];
    let (mark, planes) = bytes.split_at_mut(FRAME.len());
    mark.copy_from_slice(FRAME);
    let planes = planes.chunks_exact_mut(pixels.len().max(1)).zip(PLANES);
    parallel::for_each(planes, |(plane, fill)| fill(plane, &pixels));
    bytes
}

/// A function that fills a plane with the codes of pixels.
type Fill = fn(&mut [u8], &[[u8; 3]]);

/// The planes of a frame: luma, and the chroma of blue and of red.
const PLANES: [Fill; 3] = [
    |plane, pixels| fill(plane, pixels, |rgb| 16 + (219 * luma(rgb) + WHITE / 2) / WHITE),
    |plane, pixels| fill(plane, pixels, |rgb| chroma(rgb, rgb[2], 2 * (ONE - BLUE))),
    |plane, pixels| fill(plane, pixels, |rgb| chroma(rgb, rgb[0], 2 * (ONE - RED))),
];

/// Fills a plane with the codes of pixels.
fn fill(plane: &mut [u8], pixels: &[[u8; 3]], code: impl Fn([u32; 3]) -> u32) {
    for (value, pixel) in plane.iter_mut().zip(pixels) {
        *value = code(pixel.map(u32::from)) as u8;
    }
}

/// The weights of red and blue in luma, in parts of [`ONE`].
const RED: u32 = 2126;
const BLUE: u32 = 722;
const ONE: u32 = 10_000;
/// The luma of white.
const WHITE: u32 = 255 * ONE;

/// The luma of a colour of 8 bits.
fn luma([r, g, b]: [u32; 3]) -> u32 {
    RED * r + (ONE - RED - BLUE) * g + BLUE * b
}

/// The code of the difference of a channel and luma, which is at most half of `range`, in parts of
/// [`ONE`]: the nearest whole number.
fn chroma(rgb: [u32; 3], channel: u32, range: u32) -> u32 {
    let middle = 128 * 255 * range + 255 * range / 2;
    (middle + 224 * ONE * channel - 224 * luma(rgb)) / (255 * range)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The codes of a colour.
    fn codes(rgb: [u8; 3]) -> [u8; 3] {
        PLANES.map(|fill| {
            let mut plane = [0];
            fill(&mut plane, &[rgb]);
            plane[0]
        })
    }

    #[test]
    fn grays_have_no_chroma_and_primaries_the_codes_of_the_standard() {
        for (rgb, code) in [
            ([0; 3], [16, 128, 128]),
            ([255; 3], [235, 128, 128]),
            ([128; 3], [126, 128, 128]),
            ([255, 0, 0], [63, 102, 240]),
            ([0, 255, 0], [173, 42, 26]),
            ([0, 0, 255], [32, 240, 118]),
        ] {
            assert_eq!(codes(rgb), code, "{rgb:?}");
        }
    }

    #[test]
    fn codes_are_the_nearest_to_those_of_the_standard() {
        let levels = || (0..=255_u8).step_by(5);
        for rgb in levels().flat_map(|r| levels().flat_map(move |g| levels().map(move |b| [r, g, b]))) {
            let [r, g, b] = rgb.map(|v| f64::from(v) / 255.0);
            let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
            let exact = [
                16.0 + 219.0 * y,
                128.0 + 224.0 * (b - y) / 1.8556,
                128.0 + 224.0 * (r - y) / 1.5748,
            ];
            for (code, exact) in codes(rgb).into_iter().zip(exact) {
                assert!((f64::from(code) - exact).abs() < 0.5 + 1e-9, "{rgb:?}");
            }
        }
    }
}
