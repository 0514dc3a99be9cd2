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
#[derive(Clone)]
struct Crop {
    metadata: String,
    resolution: [u32; 2],
    /// All but the metadata.
    arrays: Vec<Array<'static>>,
    compression: NpzCompression,
}

/// The bytes of the file of the whole picture.
pub(super) fn join(crops: &[CropFile], own: &[Attribute]) -> Result<Vec<u8>, JoinError> {
    // The first crop without its pixels, and the pixels of the whole picture.
    let mut whole: Option<(Crop, Vec<Vec<u8>>)> = None;
    for crop in crops {
        let mut read = read(crop, own)?;
        let arrays: Vec<Array> = read.arrays.iter_mut().map(take).collect();
        let (first, whole) = whole.get_or_insert_with(|| {
            let pixels = read.resolution.map(|side| side as usize).iter().product::<usize>();
            let empty = arrays
                .iter()
                .map(|array| vec![0; pixels * array.pixel_size()])
                .collect();
            (read.clone(), empty)
        });
        let is_same =
            |(a, b): (&Array, &Array)| (&a.name, a.element, &a.shape[2..]) == (&b.name, b.element, &b.shape[2..]);
        let are_same = read.arrays.len() == first.arrays.len() && read.arrays.iter().zip(&first.arrays).all(is_same);
        if !are_same || read.metadata != first.metadata || read.compression != first.compression {
            return Err(JoinError::different(&crops[0], crop));
        }
        let width = first.resolution[0] as usize;
        let (x, y) = (crop.window.x0 as usize, crop.window.y0 as usize);
        for (array, pixels) in arrays.iter().zip(whole) {
            let pixel = array.pixel_size();
            let rows = array.bytes.chunks_exact(crop.window.width() as usize * pixel);
            for (line, row) in (y..).zip(rows) {
                pixels[(line * width + x) * pixel..][..row.len()].copy_from_slice(row);
            }
        }
    }
    let (first, whole) = whole.expect("there is a crop");
    let [width, height] = first.resolution.map(|side| side as usize);
    let arrays = first.arrays.into_iter().zip(whole).map(|(array, pixels)| Array {
        shape: [&[height, width], &array.shape[2..]].concat(),
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

/// Leaves an array without its numbers, and returns it with them.
fn take(array: &mut Array<'static>) -> Array<'static> {
    let bytes = std::mem::take(&mut array.bytes);
    Array { bytes, ..array.clone() }
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
