//! The encoding of a job's files.

use crate::{
    describe::OutputDesc,
    error::Error,
    film::PassRequest,
    output::{BlockShape, DepthUnit, Encoding, Format, Parts},
};

/// The encoding of files that a description asks for.
///
/// # Errors
/// The compression would change the data of a pass that the files hold.
pub(in crate::batch) fn of(
    desc: &OutputDesc,
    depth: DepthUnit,
    passes: &[PassRequest],
    formats: &[&dyn Format],
) -> Result<Encoding, Error> {
    let encoding = Encoding {
        compression: desc.compression,
        light: desc.exr_type,
        parts: if desc.multipart { Parts::Many } else { Parts::One },
        blocks: if desc.tiled {
            BlockShape::Tiles
        } else {
            BlockShape::Lines
        },
        png: desc.png_bits,
        jpeg: desc.jpeg_quality,
        npz: desc.npz_compression,
        depth,
    };
    let loses_data = formats.iter().any(|format| format.loses_data(encoding));
    let mut data = passes.iter().filter(|pass| !pass.spec().is_light());
    match data.next().filter(|_| loses_data) {
        Some(pass) => Err(Error::Usage(desc.compression.refusal(&pass.name()))),
        None => Ok(encoding),
    }
}
