//! Joining crops: pixels are decoded, copied to the whole picture, and encoded in the same way.

use std::io::BufReader;

use super::{
    facts::{WINDOW, facts},
    picture::Picture,
};
use crate::output::{
    Attribute,
    join::{CropFile, JoinError, replace},
};

/// A decoded file.
#[derive(Clone, PartialEq)]
struct Crop {
    color: ::png::ColorType,
    depth: ::png::BitDepth,
    is_srgb: bool,
    /// The columns and rows of the whole picture.
    resolution: [u32; 2],
    /// In the order of the file, without the crop's window.
    texts: Vec<Attribute>,
    bytes: Vec<u8>,
}

/// The bytes of the file of the whole picture.
pub(super) fn join(crops: &[CropFile], own: &[Attribute]) -> Result<Vec<u8>, JoinError> {
    // The first crop without its pixels, and the bytes of the whole picture.
    let mut whole: Option<(Crop, Vec<u8>)> = None;
    for crop in crops {
        let mut read = read(crop, own)?;
        let pixels = std::mem::take(&mut read.bytes);
        let pixel = read.color.samples() * if read.depth == ::png::BitDepth::Sixteen { 2 } else { 1 };
        let [width, height] = read.resolution.map(|side| side as usize);
        let (first, bytes) = whole.get_or_insert_with(|| (read.clone(), vec![0; width * height * pixel]));
        if read != *first {
            return Err(JoinError::different(&crops[0], crop));
        }
        let (x, y) = (crop.window.x0 as usize, crop.window.y0 as usize);
        let rows = pixels.chunks_exact(crop.window.width() as usize * pixel);
        for (line, row) in (y..).zip(rows) {
            bytes[(line * width + x) * pixel..][..row.len()].copy_from_slice(row);
        }
    }
    let (first, bytes) = whole.expect("there is a crop");
    let picture = Picture {
        size: first.resolution,
        color: first.color,
        depth: first.depth,
        is_srgb: first.is_srgb,
        texts: first.texts.into_iter().map(|a| (a.name, a.value.to_string())).collect(),
        bytes,
    };
    let mut file = Vec::new();
    let written = picture.write(&mut file);
    written.map_err(|error| JoinError::unfit(&crops[0], &error))?;
    Ok(file)
}

fn read(crop: &CropFile, own: &[Attribute]) -> Result<Crop, JoinError> {
    let unreadable = |error: &dyn ToString| JoinError::unreadable(&crop.path, &error.to_string());
    let facts = facts(&crop.path).map_err(|error| unreadable(&error))?;
    let facts = facts.ok_or_else(|| unreadable(&"it is no PNG"))?;
    let mut texts = facts.attributes;
    texts.retain(|text| text.name != WINDOW);
    replace(&mut texts, own);
    let file = crate::output::facts::open(&crop.path).map_err(|error| unreadable(&error))?;
    let mut reader = ::png::Decoder::new(BufReader::new(file))
        .read_info()
        .map_err(|error| unreadable(&error))?;
    let size = reader
        .output_buffer_size()
        .ok_or_else(|| unreadable(&"it is too large"))?;
    let mut bytes = vec![0; size];
    let frame = reader.next_frame(&mut bytes).map_err(|error| unreadable(&error))?;
    if [frame.width, frame.height] != [crop.window.width(), crop.window.height()] {
        return Err(unreadable(&"it has changed"));
    }
    Ok(Crop {
        color: frame.color_type,
        depth: frame.bit_depth,
        is_srgb: reader.info().srgb.is_some(),
        resolution: facts.resolution,
        texts,
        bytes,
    })
}
