//! The pictures of a scene, loaded side by side.

use std::path::PathBuf;

use rayon::prelude::*;

use super::image::{self, ImageError};
use crate::texture::{Bitmap, bitmap::ColorSpace};

/// A picture and how to read its numbers.
pub type Request = (PathBuf, ColorSpace);

/// Loads all pictures, in order; or says what is wrong with each that cannot be loaded.
pub fn load(requests: &[Request]) -> Result<Vec<Bitmap>, Vec<ImageError>> {
    let loaded: Vec<_> = requests
        .par_iter()
        .map(|(path, space)| image::load(path, *space))
        .collect();
    let (mut bitmaps, mut errors) = (Vec::new(), Vec::new());
    for result in loaded {
        match result {
            Ok(bitmap) => bitmaps.push(bitmap),
            Err(e) => errors.push(e),
        }
    }
    if errors.is_empty() { Ok(bitmaps) } else { Err(errors) }
}
