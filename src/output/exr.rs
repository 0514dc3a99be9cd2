//! OpenEXR: scanline or tiled files, with one part or several. This module compresses blocks with ZIPS, ZIP and not at all; codecs
//! of the `exr` crate do RLE, PIZ and DWAA.
//!
//! The same image gives the same bytes: attributes and channels are sorted by name, blocks are compressed by all threads but
//! written in order, and nothing depends on the time. Halves are rounded to the nearest, ties to even, after numbers beyond
//! +-65504 were clamped to it and NaN became 0; the report counts both. Float and uint channels keep every bit.
//!
//! Source: "OpenEXR File Layout" and "Technical Introduction to OpenEXR", <https://openexr.com/en/latest/>.

mod blocks;
mod codec;
mod compression;
mod cryptomatte;
mod file;
mod header;
mod headers;
mod image;
mod join;
#[cfg(test)]
mod tests;
mod whole;
mod write;

use std::{io::Write, path::Path};

use super::{
    Attribute, Contents, EncodeError, Encoding, FileFacts, Format, FrameImage, LightType, Parts, Shown, WriteReport,
    frame_attributes::attributes,
    join::{CropFile, JoinError},
};
use crate::film::{self, PixelType, Window, passes::BEAUTY};

pub use compression::Compression;
pub use file::{ExrFile, Numbers, Part as FilePart, Plane as FilePlane, ReadError};
pub use image::{Channel, ChannelData, Image, Samples};
pub use write::{write, write_parts};

/// The format, with the attributes that compositors look for.
///
/// `R G B A` and the frame's passes. Files with light declare the primaries of the working space and that it is scene-linear
/// (`chromaticities`, `colorInteropID`). With the view `raw` in Rec. 709 the numbers are display values, and `comments` says so.
#[derive(Debug)]
pub struct Exr;

impl Format for Exr {
    fn name(&self) -> &'static str {
        "exr"
    }

    fn contents(&self) -> Contents {
        Contents::Data
    }

    /// Readers of EXR seek in a file of their own.
    fn makes_streams(&self) -> bool {
        false
    }

    fn encode(&self, frame: &FrameImage, encoding: Encoding, out: &mut dyn Write) -> Result<WriteReport, EncodeError> {
        let layers = layers(frame, encoding);
        check_layers(frame, &layers, encoding)?;
        let common = attributes(frame);
        let with_own = |planes: &[film::Plane]| -> Vec<Attribute> {
            let own = planes.iter().flat_map(|plane| cryptomatte::attributes(&plane.spec));
            common.iter().cloned().chain(own).collect()
        };
        let image = |channels, attributes| Image {
            display: Window::full(frame.film.resolution),
            data: frame.film.window,
            channels,
            attributes,
            compression: encoding.compression,
            blocks: encoding.blocks,
        };
        if encoding.parts == Parts::One {
            let channels: Vec<Channel> = layers.iter().flat_map(Layer::channels).collect();
            return write(&image(&channels, &with_own(frame.planes())), out);
        }
        let planes = frame.planes().chunks(1);
        let parts: Vec<(Vec<Channel>, Vec<Attribute>)> = layers
            .iter()
            .zip(planes)
            .map(|(layer, plane)| (layer.channels().collect(), with_own(plane)))
            .collect();
        let parts = layers.iter().zip(&parts);
        let parts: Vec<(&str, Image)> = parts
            .map(|(layer, (channels, own))| (layer.name, image(channels, own)))
            .collect();
        write_parts(&parts, out)
    }

    fn loses_data(&self, encoding: Encoding) -> bool {
        encoding.compression.is_lossy()
    }

    fn facts(&self, path: &Path) -> Option<FileFacts> {
        whole::facts(path)
    }

    fn inspect(&self, path: &Path) -> Option<FileFacts> {
        whole::inspect(path)
    }

    fn join(&self, crops: &[CropFile], own: &[Attribute]) -> Result<Vec<u8>, JoinError> {
        join::join(crops, own)
    }
}

/// A plane of a frame, as it is stored.
struct Layer<'a> {
    name: &'a str,
    channels: Vec<(String, Samples<'a>)>,
}

impl Layer<'_> {
    fn channels(&self) -> impl Iterator<Item = Channel<'_>> {
        self.channels.iter().map(|(name, samples)| Channel {
            name,
            samples: *samples,
        })
    }
}

/// The layers of a frame, one for each of its planes; alpha is in the first.
fn layers<'a>(frame: &FrameImage<'a>, encoding: Encoding) -> Vec<Layer<'a>> {
    let first = &frame.film.planes()[0];
    let pixel = |plane: &film::Plane| match (plane.spec.pass.pixel, encoding.light) {
        (PixelType::Half, LightType::Float) => PixelType::Float,
        (pixel, _) => pixel,
    };
    let layer = |plane: &'a film::Plane| {
        let is_shown = frame.shown != Shown::All && plane.spec.pass.is_light();
        let names = if is_shown {
            ["R", "G", "B"].map(str::to_owned).to_vec()
        } else {
            plane.spec.channel_names()
        };
        let names = names.into_iter().enumerate();
        Layer {
            name: &plane.spec.name,
            channels: names.map(|(i, name)| (name, samples(pixel(plane), plane, i))).collect(),
        }
    };
    let mut layers: Vec<Layer> = frame.planes().iter().map(layer).collect();
    if frame.shown != Shown::All || first.spec.pass != BEAUTY {
        let alpha = if encoding.light == LightType::Float {
            PixelType::Float
        } else {
            PixelType::Half
        };
        layers[0].channels.push(("A".to_owned(), samples(alpha, first, 3)));
    }
    layers
}

/// Refuses layers whose names are too long for readers, and data that the compression would change.
fn check_layers(frame: &FrameImage, layers: &[Layer], encoding: Encoding) -> Result<(), EncodeError> {
    /// The longest name that every reader knows, in bytes.
    const LONGEST: usize = 31;
    let names = layers.iter().flat_map(|layer| &layer.channels).map(|(name, _)| name);
    if let Some(name) = names.into_iter().find(|name| name.len() > LONGEST) {
        return Err(EncodeError::Unfit(format!(
            "the channel `{name}` has a name of more than {LONGEST} bytes, which not every reader knows"
        )));
    }
    let mut data = frame.planes().iter().filter(|plane| !plane.spec.pass.is_light());
    match data.next().filter(|_| encoding.compression.is_lossy()) {
        None => Ok(()),
        Some(plane) => Err(EncodeError::Unfit(encoding.compression.refusal(&plane.spec.name))),
    }
}

/// One channel of a plane.
fn samples(pixel: PixelType, plane: &film::Plane, channel: usize) -> Samples<'_> {
    let (values, step) = (plane.values.as_slice(), plane.spec.step());
    let layer = values.len() / (plane.spec.width() / step);
    let first = channel / step * layer + channel % step;
    match pixel {
        PixelType::Half => Samples::Half(ChannelData { values, first, step }),
        PixelType::Float => Samples::Float(ChannelData { values, first, step }),
        PixelType::Uint => Samples::Uint(ChannelData {
            values: bytemuck::cast_slice(values),
            first,
            step,
        }),
    }
}
