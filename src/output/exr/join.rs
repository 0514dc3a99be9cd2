//! Joining crops: pixels are decoded, copied to the whole picture, and encoded in the same way.

use super::file::{ExrFile, Part};
use crate::output::{
    Attribute,
    join::{CropFile, JoinError, replace},
};

/// The bytes of the file of the whole picture.
pub(super) fn join(crops: &[CropFile], own: &[Attribute]) -> Result<Vec<u8>, JoinError> {
    let first = &crops[0];
    let mut whole = open(first)?;
    for crop in crops {
        let others = open(crop)?.parts;
        let is_same = |(a, b): (&Part, &Part)| {
            let common = |part: &Part| {
                let mut list = part.attributes.clone();
                replace(&mut list, own);
                list
            };
            a.name == b.name && (a.compression, a.blocks) == (b.compression, b.blocks) && common(a) == common(b)
        };
        if whole.parts.len() != others.len() || !whole.parts.iter().zip(&others).all(is_same) {
            return Err(JoinError::different(first, crop));
        }
    }
    for part in &mut whole.parts {
        part.data = part.display;
    }
    for crop in crops {
        let put = whole.put(&crop.path, crop.window);
        put.map_err(|error| JoinError::unfit(crop, &error))?;
    }
    for part in &mut whole.parts {
        replace(&mut part.attributes, own);
    }
    whole.encode().map_err(|error| JoinError::unfit(first, &error))
}

/// Opens the file of a crop, without its numbers.
fn open(crop: &CropFile) -> Result<ExrFile, JoinError> {
    let file = ExrFile::without_numbers(&crop.path).map_err(|error| JoinError::unfit(crop, &error))?;
    if file.parts.iter().any(|part| part.compression.is_lossy()) {
        let reason = "its compression is lossy: its pixels, packed again, are not those of the whole picture";
        return Err(JoinError::unfit(crop, &reason));
    }
    Ok(file)
}
