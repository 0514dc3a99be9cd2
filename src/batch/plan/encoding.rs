//! The encoding of a job's files.

use crate::{
    describe::OutputDesc,
    error::Error,
    film::PassRequest,
    output::{BlockShape, Contents, DepthUnit, Encoding, FilePattern, Parts},
};

/// The encoding of files that a description asks for.
///
/// # Errors
/// The compression would change the data of a pass that the files hold.
pub(in crate::batch) fn of(
    desc: &OutputDesc,
    depth: DepthUnit,
    passes: &[PassRequest],
    patterns: &[FilePattern],
) -> Result<Encoding, Error> {
    let is_written = patterns.iter().any(|p| p.format().contents() == Contents::Data);
    let mut data = passes.iter().filter(|pass| !pass.spec().is_light());
    if let Some(pass) = data.next().filter(|_| is_written && desc.compression.is_lossy()) {
        return Err(Error::Usage(desc.compression.refusal(&pass.name())));
    }
    Ok(Encoding {
        compression: desc.compression,
        light: desc.exr_type,
        parts: if desc.multipart { Parts::Many } else { Parts::One },
        blocks: if desc.tiled {
            BlockShape::Tiles
        } else {
            BlockShape::Lines
        },
        png: desc.png_bits,
        depth,
    })
}
