//! The content of a PNG file, and its encoding.

use std::io::Write;

use crate::output::{EncodeError, counting::Counting};

/// The content of a file.
pub(super) struct Picture {
    pub size: [u32; 2],
    pub color: ::png::ColorType,
    pub depth: ::png::BitDepth,
    pub is_srgb: bool,
    pub texts: Vec<(String, String)>,
    /// Rows from the top; numbers of 16 bits are big-endian.
    pub bytes: Vec<u8>,
}

impl Picture {
    /// Writes the file; returns its size.
    pub fn write(self, out: &mut dyn Write) -> Result<u64, EncodeError> {
        let mut out = Counting { out, bytes: 0 };
        let [width, height] = self.size;
        let mut encoder = ::png::Encoder::new(&mut out, width, height);
        encoder.set_depth(self.depth);
        encoder.set_color(self.color);
        // 8 ms for 1080p; the default takes 15 times as long for 11 % less.
        encoder.set_compression(::png::Compression::Fast);
        if self.is_srgb {
            encoder.set_source_srgb(::png::SrgbRenderingIntent::Perceptual);
        }
        for (key, text) in self.texts {
            add_text(&mut encoder, key, text)?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.bytes)?;
        writer.finish()?;
        Ok(out.bytes)
    }
}

/// Adds ASCII as plain text and other text as UTF-8, because many readers decode the format's Latin-1 wrongly.
fn add_text<W: Write>(encoder: &mut ::png::Encoder<W>, key: String, text: String) -> Result<(), ::png::EncodingError> {
    if text.bytes().all(|b| matches!(b, b'\n' | b' '..=b'~')) {
        encoder.add_text_chunk(key, text)
    } else {
        encoder.add_itxt_chunk(key, text)
    }
}
