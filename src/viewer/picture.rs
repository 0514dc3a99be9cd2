//! Encoded pictures for pages.

use jpeg_encoder::{Encoder, ImageBuffer, JpegColorType, SamplingFactor, rgb_to_ycbcr};
use serde::Serialize;

use super::camera::{LensNumbers, ViewCamera};

/// The stage of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// At a lower resolution.
    Coarse,
    /// Some tiles have more samples than others.
    Part,
    /// All pixels have the same number of samples.
    Round,
    /// All samples: the pixels that the job writes.
    Final,
}

/// The header of a picture of the view.
#[derive(Clone, Debug, Serialize)]
pub struct ViewHeader {
    pub kind: &'static str,
    /// The number of its view, which increases with each change.
    pub version: u64,
    /// The page that requested this view, and the number of its message.
    pub client: u64,
    pub seq: u64,
    pub stage: Stage,
    pub mime: &'static str,
    pub width: u32,
    pub height: u32,
    /// The samples of each pixel, and their final number.
    pub samples: u32,
    pub of: u32,
    /// The time since the start of rendering this view, in ms.
    pub ms: f64,
    pub rays_per_second: f64,
    pub frame: f64,
    /// Whether the camera is that of the path at the frame.
    pub on_path: bool,
    pub camera: ViewCamera,
    /// All parameters of the lens.
    pub lens: LensNumbers,
}

/// The header of a picture of a job.
#[derive(Clone, Debug, Serialize)]
pub struct JobHeader {
    pub kind: &'static str,
    pub mime: &'static str,
    pub width: u32,
    pub height: u32,
    pub frame: i32,
    /// Whether the frame is finished.
    pub is_complete: bool,
}

/// An encoded picture with its header.
#[derive(Clone, Debug)]
pub struct Picture {
    /// The version of the view; 0 for that of a job.
    pub version: u64,
    pub stage: Stage,
    /// The length of the header's JSON as 4 bytes, little-endian, the JSON, and the file.
    message: Vec<u8>,
    file: usize,
}

impl Picture {
    pub fn of_view(header: &ViewHeader, file: &[u8]) -> Self {
        Self::new(header.version, header.stage, header, file)
    }

    pub fn of_job(header: &JobHeader, file: &[u8]) -> Self {
        Self::new(0, Stage::Part, header, file)
    }

    fn new(version: u64, stage: Stage, header: &impl Serialize, file: &[u8]) -> Self {
        let json = serde_json::to_vec(header).expect("a header is numbers and words");
        let mut message = Vec::with_capacity(4 + json.len() + file.len());
        message.extend_from_slice(&(json.len() as u32).to_le_bytes());
        message.extend_from_slice(&json);
        message.extend_from_slice(file);
        Self {
            version,
            stage,
            file: 4 + json.len(),
            message,
        }
    }

    /// The bytes of its message.
    pub fn message(&self) -> &[u8] {
        &self.message
    }

    /// The picture file alone; the header tells its type.
    pub fn file(&self) -> &[u8] {
        &self.message[self.file..]
    }
}

/// R, G and B of each pixel. With `Encoder::encode` the program would hold the encoders of eight other layouts, 0.2 MB.
struct Rows<'a> {
    rgb: &'a [u8],
    width: u16,
    height: u16,
}

impl ImageBuffer for Rows<'_> {
    fn get_jpeg_color_type(&self) -> JpegColorType {
        JpegColorType::Ycbcr
    }

    fn width(&self) -> u16 {
        self.width
    }

    fn height(&self) -> u16 {
        self.height
    }

    fn fill_buffers(&self, y: u16, buffers: &mut [Vec<u8>; 4]) {
        let bytes = 3 * usize::from(self.width);
        let row = self.rgb.chunks_exact(bytes).nth(usize::from(y)).unwrap_or_default();
        let pixels = || row.chunks_exact(3).map(|p| rgb_to_ycbcr(p[0], p[1], p[2]));
        buffers[0].extend(pixels().map(|(y, ..)| y));
        buffers[1].extend(pixels().map(|(_, cb, _)| cb));
        buffers[2].extend(pixels().map(|(.., cr)| cr));
    }
}

/// Encodes a JPEG file from R, G and B of each pixel. It is empty if a side is longer than the format allows.
pub fn jpeg(rgb: &[u8], [width, height]: [u32; 2], quality: u8) -> Vec<u8> {
    let mut file = Vec::with_capacity(rgb.len() / 8);
    let mut encoder = Encoder::new(&mut file, quality);
    // Chroma subsampling at lower quality.
    encoder.set_sampling_factor(match quality {
        90.. => SamplingFactor::F_1_1,
        _ => SamplingFactor::F_2_2,
    });
    let sides = [width, height].map(u16::try_from);
    if let [Ok(width), Ok(height)] = sides
        && encoder.encode_image(Rows { rgb, width, height }).is_err()
    {
        // If a picture cannot be encoded, the page keeps the last one.
        file.clear();
    }
    file
}
