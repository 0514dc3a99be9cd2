//! NPZ: a frame as arrays of NumPy, an array for each pass.
//!
//! A file is a ZIP archive of `.npy` files, as `numpy.savez` writes them. Its first array, `metadata`, is a JSON text with the
//! attributes of EXR files, and the names of mattes. Light and other measures are 32-bit floats and whole numbers are
//! `uint32`; every bit is kept. The same image gives the same bytes. The seal is a field of the first member's header, which
//! readers skip. A crop is an array of its own size, with its window in the metadata.

mod array;
mod file;
mod join;
mod metadata;
#[cfg(test)]
mod tests;
mod zip;

use std::{
    fs::File,
    io::{BufReader, Write},
    path::Path,
};

use super::{
    Attribute, Contents, EncodeError, Encoding, FileFacts, Format, FrameImage, WriteReport,
    join::{CropFile, JoinError},
    seal,
};
use crate::{
    film::{PixelType, Plane, passes::BEAUTY},
    math::parallel,
};

use array::{Array, Element};
use file::{open, write};
use metadata::METADATA;
use zip::Archive;

/// The array of the picture: premultiplied, scene-linear red, green and blue, and alpha.
const PICTURE: &str = "rgba";
/// The array of alpha where there is no picture.
const ALPHA: &str = "alpha";

/// The format.
#[derive(Debug)]
pub struct Npz;

impl Format for Npz {
    fn name(&self) -> &'static str {
        "npz"
    }

    fn contents(&self) -> Contents {
        Contents::Data
    }

    fn encode(&self, frame: &FrameImage, encoding: Encoding, out: &mut dyn Write) -> Result<WriteReport, EncodeError> {
        let window = frame.film.window;
        let (width, height) = (window.width() as usize, window.height() as usize);
        if window.area() == 0 {
            return Err(EncodeError::Unfit(format!("a picture of {width} x {height} pixels")));
        }
        let mut arrays = vec![Array::text(METADATA, metadata::text(frame))];
        for plane in frame.planes() {
            arrays.extend(arrays_of(plane, [height, width]));
        }
        if !frame.planes().iter().any(|plane| plane.spec.pass == BEAUTY) {
            let beauty = frame.film.beauty();
            let alpha = parallel::table(beauty.len(), |i| beauty[i][3].to_le_bytes());
            let shape = vec![height, width];
            arrays.push(Array::owned(ALPHA.to_owned(), Element::F32, shape, alpha));
        }
        Ok(WriteReport {
            bytes: write(arrays, encoding.npz, out)?,
            ..WriteReport::default()
        })
    }

    fn facts(&self, path: &Path) -> Option<FileFacts> {
        facts(&mut open(path).ok()?)
    }

    fn inspect(&self, path: &Path) -> Option<FileFacts> {
        inspect(path)
    }

    fn join(&self, crops: &[CropFile], own: &[Attribute]) -> Result<Vec<u8>, JoinError> {
        join::join(crops, own)
    }
}

/// The arrays of a plane of this many rows and columns.
fn arrays_of(plane: &Plane, size: [usize; 2]) -> Vec<Array<'_>> {
    let (spec, channels) = (&plane.spec, plane.spec.pass.channels.len());
    let last = (channels > 1).then_some(channels);
    let shape: Vec<usize> = size.into_iter().chain(last).collect();
    if spec.ranks > 0 {
        let shape = [&size[..], &[spec.ranks as usize]].concat();
        let coverage = format!("{}_coverage", spec.name);
        return vec![
            Array::owned(spec.name.clone(), Element::U32, shape.clone(), ranked(plane, 0)),
            Array::owned(coverage, Element::F32, shape, ranked(plane, 1)),
        ];
    }
    let element = match spec.pass.pixel {
        PixelType::Half | PixelType::Float => Element::F32,
        PixelType::Uint => Element::U32,
    };
    let name = if spec.pass == BEAUTY { PICTURE } else { &spec.name };
    // The integrator's picture has an alpha, which is none of its channels if it is not light.
    vec![if spec.width() == channels {
        Array::new(name, element, shape, plane.values.as_slice())
    } else {
        let pixels = plane.values.chunks_exact(spec.width());
        let values = pixels.flat_map(|pixel| &pixel[..channels]);
        let bytes = values.map(|v| v.to_le_bytes()).collect();
        Array::owned(name.to_owned(), element, shape, bytes)
    }]
}

/// The ids (0) or the coverages (1) of all ranks of each pixel.
fn ranked(plane: &Plane, first: usize) -> Vec<[u8; 4]> {
    let (step, ranks) = (plane.spec.step(), plane.spec.ranks as usize);
    let layers = plane.spec.width() / step;
    let layer = plane.values.len() / layers;
    parallel::table(layer / step * ranks, |i| {
        let (pixel, rank) = (i / ranks, i % ranks);
        plane.values[rank / 2 * layer + pixel * step + rank % 2 * 2 + first].to_le_bytes()
    })
}

/// The facts of a file by its metadata; of another program's file the size of its first picture.
fn facts(archive: &mut Archive<BufReader<File>>) -> Option<FileFacts> {
    let first = archive.members.first()?;
    let (name, is_small) = (first.name.clone(), first.size() <= metadata::LONGEST);
    let first = is_small.then(|| archive.read(0)).transpose().ok()?;
    let first = first.and_then(|bytes| Array::parse(&name, bytes));
    match first.and_then(|array| metadata::facts(&array)) {
        Some(facts) => Some(facts),
        None => (0..archive.members.len()).find_map(|i| {
            let bytes = archive.read(i).ok()?;
            let array = Array::parse(&archive.members[i].name, bytes)?;
            metadata::facts_of_shape(&array.shape)
        }),
    }
}

/// The facts of a file whose seal fits. In a file without a seal, of another program, all members must be readable.
fn inspect(path: &Path) -> Option<FileFacts> {
    let mut archive = open(path).ok()?;
    let facts = facts(&mut archive)?;
    let is_whole = match seal::is_intact(path).ok()? {
        Some(is_intact) => is_intact,
        None => facts.version().is_none() && (0..archive.members.len()).all(|i| archive.read(i).is_ok()),
    };
    is_whole.then_some(facts)
}
