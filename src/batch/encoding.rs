//! The encoding of a job's files.

use super::{Request, names, passes::PassChoice};
use crate::{
    describe::SceneDesc,
    error::Error,
    output::{BlockShape, Compression, Contents, Encoding, FilePattern, LightType, Parts, PngBits},
    value::Problem,
};

/// The encoding of a request and a scene; `None` if a problem was recorded.
///
/// # Errors
/// The request has an unknown name.
pub(super) fn choose(
    desc: &SceneDesc,
    request: &Request,
    keep: &mut impl FnMut(Problem),
) -> Result<Option<Encoding>, Error> {
    let compression: Result<Option<Compression>, _> =
        names::choose("--compression", (&request.compression, &desc.output.compression))?;
    let light: Result<Option<LightType>, _> = names::choose("--exr-type", (&request.exr_type, &desc.output.exr_type))?;
    let bits: Result<Option<PngBits>, _> = names::choose("--png-bits", (&request.png_bits, &desc.output.png_bits))?;
    let mut ok = |problem: Problem| keep(problem);
    let (compression, light) = (compression.map_err(&mut ok).ok(), light.map_err(&mut ok).ok());
    let bits = bits.map_err(&mut ok).ok();
    let (Some(compression), Some(light), Some(bits)) = (compression, light, bits) else {
        return Ok(None);
    };
    Ok(Some(Encoding {
        compression: compression.unwrap_or_default(),
        light: light.unwrap_or_default(),
        parts: if request.multipart || desc.output.multipart {
            Parts::Many
        } else {
            Parts::One
        },
        blocks: if request.tiled || desc.output.tiled {
            BlockShape::Tiles
        } else {
            BlockShape::Lines
        },
        png: bits.unwrap_or_default(),
    }))
}

/// Refuses a compression that would change the passes of data of a file.
pub(super) fn check(encoding: Encoding, choice: &PassChoice, patterns: &[FilePattern]) -> Result<(), Error> {
    let is_written = patterns.iter().any(|p| p.format().contents() == Contents::Data);
    let mut data = choice.passes.iter().filter(|pass| !pass.spec().is_light());
    match data.next().filter(|_| is_written && encoding.compression.is_lossy()) {
        None => Ok(()),
        Some(pass) => Err(Error::Usage(encoding.compression.refusal(&pass.name()))),
    }
}
