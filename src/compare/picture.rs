//! Pictures as they are compared.

use std::path::Path;

use crate::{
    assets::{
        Files, MemoryKind,
        image::{EncodedImage, ImageError, ImageRequest, PictureWindow, PngNumbers},
        model::ImageSource,
    },
    math::{Rgb, srgb},
    texture::{
        Bitmap,
        bitmap::{ColorSpace, Storage},
    },
};

/// A picture: of light (EXR, Radiance HDR), of data (PNG files of numbers) or of display values (all others).
#[derive(Clone, Debug)]
pub struct Picture {
    /// Columns and rows: those of the data window of EXR.
    pub size: [u32; 2],
    pub window: PictureWindow,
    /// Whether its numbers are light, which has no upper bound. Display values are from 0 to 1 and have sRGB's curve.
    pub is_light: bool,
    /// The meaning of the numbers of data. They are whole numbers, or components of vectors from -1 to 1.
    pub data: Option<PngNumbers>,
    /// The numbers of the file, row by row from the top. Colours of EXR are multiplied by alpha.
    pub pixels: Vec<Rgb>,
    /// The opacity of each pixel; empty for a picture without.
    pub alpha: Vec<f32>,
    /// Numbers that were NaN or infinite in the file; they are 0 or +-65504 here.
    pub not_finite: u64,
}

impl Picture {
    /// Reads a picture file of any format that textures can have.
    pub fn read(path: &Path, files: &Files) -> Result<Self, ImageError> {
        let request = ImageRequest::new(ImageSource::File(path.to_owned()), ColorSpace::Raw);
        let encoded = EncodedImage::read(&request, files)?;
        let (bitmap, window) = encoded.decode_data(files.memory())?;
        files.memory().release(MemoryKind::Images);
        let mut picture = Self::of(&bitmap, window);
        picture.data = encoded.png_numbers();
        if let Some(numbers) = &picture.data {
            for pixel in &mut picture.pixels {
                *pixel = pixel.map(|v| numbers.decode(v));
            }
        }
        Ok(picture)
    }

    fn of(bitmap: &Bitmap, window: PictureWindow) -> Self {
        let places = || (0..bitmap.height).flat_map(|y| (0..bitmap.width).map(move |x| (x, y)));
        Self {
            size: [bitmap.width, bitmap.height],
            window,
            is_light: matches!(bitmap.storage, Storage::Float(_)),
            data: None,
            pixels: places().map(|(x, y)| bitmap.rgb(x, y)).collect(),
            alpha: if bitmap.has_alpha() {
                places().map(|(x, y)| bitmap.alpha(x, y)).collect()
            } else {
                Vec::new()
            },
            not_finite: bitmap.repaired,
        }
    }

    /// The opacity of pixel `i`.
    pub(super) fn alpha(&self, i: usize) -> f32 {
        self.alpha.get(i).copied().unwrap_or(1.0)
    }

    /// The linear light that a display shows of it; of a picture of light, its numbers.
    pub(super) fn linear(&self) -> Vec<Rgb> {
        if self.is_light {
            return self.pixels.clone();
        }
        self.pixels.iter().map(|pixel| pixel.map(srgb::decode)).collect()
    }
}
