//! Joining crops: their pixels are copied to the arrays of the whole picture, which are packed in the same way.

use std::borrow::Cow;

use super::{
    array::Array,
    file::{open, write},
    metadata,
};
use crate::{
    film::Window,
    output::{
        Attribute, NpzCompression,
        join::{CropFile, JoinError},
    },
};

/// The arrays of a file, and how they are packed.
struct Crop {
    metadata: String,
    resolution: [u32; 2],
    /// All but the metadata.
    arrays: Vec<Array<'static>>,
    compression: NpzCompression,
}

/// The bytes of the file of the whole picture.
pub(super) fn join(crops: &[CropFile], own: &[Attribute]) -> Result<Vec<u8>, JoinError> {
    let first = read(&crops[0], own)?;
    let [width, height] = first.resolution.map(|side| side as usize);
    let mut whole: Vec<(Array, Vec<u8>)> = Vec::new();
    for array in &first.arrays {
        let shape = [&[height, width], &array.shape[2..]].concat();
        let pixels = vec![0; width * height * array.pixel_size()];
        whole.push((
            Array {
                shape,
                bytes: Cow::Borrowed(&[]),
                ..array.clone()
            },
            pixels,
        ));
    }
    for crop in crops {
        let other = read(crop, own)?;
        let is_same =
            |(a, b): (&Array, &Array)| (&a.name, a.element, &a.shape[2..]) == (&b.name, b.element, &b.shape[2..]);
        let are_same = other.arrays.len() == first.arrays.len() && other.arrays.iter().zip(&first.arrays).all(is_same);
        if !are_same || other.metadata != first.metadata || other.compression != first.compression {
            return Err(JoinError::different(&crops[0], crop));
        }
        for (array, (_, pixels)) in other.arrays.iter().zip(&mut whole) {
            let pixel = array.pixel_size();
            let (x, y) = (crop.window.x0 as usize, crop.window.y0 as usize);
            let rows = array.bytes.chunks_exact(crop.window.width() as usize * pixel);
            for (line, row) in (y..).zip(rows) {
                pixels[(line * width + x) * pixel..][..row.len()].copy_from_slice(row);
            }
        }
    }
    let arrays = whole.into_iter().map(|(array, pixels)| Array {
        bytes: Cow::Owned(pixels),
        ..array
    });
    let arrays = [Array::text(metadata::METADATA, first.metadata)]
        .into_iter()
        .chain(arrays)
        .collect();
    let mut file = Vec::new();
    let written = write(arrays, first.compression, &mut file);
    written.map_err(|error| JoinError::unfit(&crops[0], &error))?;
    Ok(file)
}

fn read(crop: &CropFile, own: &[Attribute]) -> Result<Crop, JoinError> {
    let unreadable = |error: &dyn ToString| JoinError::unreadable(&crop.path, &error.to_string());
    let mut archive = open(&crop.path).map_err(|error| unreadable(&error))?;
    let mut arrays = Vec::new();
    for i in 0..archive.members.len() {
        let bytes = archive.read(i).map_err(|error| unreadable(&error))?;
        let array = Array::parse(&archive.members[i].name, bytes);
        arrays.push(array.ok_or_else(|| unreadable(&"it has an array that is empty or of another program"))?);
    }
    let changed = || unreadable(&"it has changed");
    if arrays.is_empty() {
        return Err(changed());
    }
    let described = arrays.remove(0);
    let facts = metadata::facts(&described)
        .filter(|facts| facts.window == crop.window)
        .ok_or_else(changed)?;
    let Window { x0, y0, x1, y1 } = crop.window;
    let size = [(y1 - y0) as usize, (x1 - x0) as usize];
    if !arrays.iter().all(|array| array.shape.starts_with(&size)) {
        return Err(changed());
    }
    // The text of the metadata always becomes smaller.
    let is_deflated = archive.members.first().is_some_and(|first| first.is_deflated());
    Ok(Crop {
        metadata: metadata::joined(&described, own).ok_or_else(changed)?,
        resolution: facts.resolution,
        arrays,
        compression: match is_deflated {
            true => NpzCompression::Deflate,
            false => NpzCompression::None,
        },
    })
}
