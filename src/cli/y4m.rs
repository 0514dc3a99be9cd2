//! Uncompressed films (YUV4MPEG2), which ffmpeg and encoders of films read.
//!
//! Their frames have 8 bits and the full resolution for colours too (4:4:4), by the matrix of BT.709 and in its limited range. Source:
//! ITU-R BT.709-6; the header is that of mjpegtools' yuv4mpeg(5).

use batch_render::output::FrameImage;
use rayon::prelude::*;

use super::small_picture::picture;

/// The marks of a frame.
const FRAME: &[u8] = b"FRAME\n";

/// The first line of a film of this many columns and rows, at this rate in frames per second.
pub fn header([width, height]: [u32; 2], (frames, seconds): (i32, u32)) -> String {
    format!("YUV4MPEG2 W{width} H{height} F{frames}:{seconds} Ip A1:1 C444 XCOLORRANGE=LIMITED\n")
}

/// A frame over black.
pub fn frame(image: &FrameImage<'_>) -> Vec<u8> {
    let pixels: Vec<[u8; 3]> = picture(image).into_par_iter().map(ycbcr).collect();
    let planes = (0..3).flat_map(|channel| pixels.iter().map(move |pixel| pixel[channel]));
    FRAME.iter().copied().chain(planes).collect()
}

/// The luma and the chroma of a colour.
fn ycbcr(rgb: [u8; 3]) -> [u8; 3] {
    const RED: f32 = 0.2126;
    const BLUE: f32 = 0.0722;
    let [r, g, b] = rgb.map(|v| f32::from(v) / 255.0);
    let y = RED * r + (1.0 - RED - BLUE) * g + BLUE * b;
    let chroma = |v: f32, weight: f32| 128.0 + 224.0 * (v - y) / (2.0 - 2.0 * weight);
    [16.0 + 219.0 * y, chroma(b, BLUE), chroma(r, RED)].map(|v| v.round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(ycbcr(rgb), code, "{rgb:?}");
        }
    }
}
