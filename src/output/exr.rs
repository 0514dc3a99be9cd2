//! OpenEXR: single-part scanline files, written by ourselves with no compression, ZIPS or ZIP.
//!
//! The same image gives the same bytes: attributes and channels are sorted by name, blocks are compressed by all threads but
//! written in order, and nothing depends on the time. Halves are rounded to the nearest, ties to even, after numbers beyond
//! +-65504 were clamped to it and NaN became 0; the report counts both. Float and uint channels keep every bit.
//!
//! Source: "OpenEXR File Layout" and "Technical Introduction to OpenEXR", <https://openexr.com/en/latest/>.

mod blocks;
mod compression;
mod cryptomatte;
mod header;
mod image;
#[cfg(test)]
mod tests;
mod whole;

use std::{io::Write, path::Path};

use super::{
    Attribute, Contents, DisplayTransform, EncodeError, Encoding, FileFacts, Format, FrameImage, Shown, Value,
    WriteReport, counting::Counting,
};
use crate::film::{self, PixelType, Window, passes::BEAUTY};

pub use compression::Compression;
pub use image::{Channel, ChannelData, Image, Samples};

/// The format, with the attributes that compositors look for.
///
/// `R G B A` and the frame's passes. Files with light say Rec. 709 primaries and scene-linear (`chromaticities`,
/// `colorInteropID`), unless the view is `raw`, whose numbers are display values and whose `comments` say so.
#[derive(Debug)]
pub struct Exr;

impl Format for Exr {
    fn name(&self) -> &'static str {
        "exr"
    }

    fn contents(&self) -> Contents {
        Contents::Data
    }

    fn encode(&self, frame: &FrameImage, encoding: Encoding, out: &mut dyn Write) -> Result<WriteReport, EncodeError> {
        let channels = channels(frame);
        let channels: Vec<Channel> = channels
            .iter()
            .map(|(name, samples)| Channel {
                name,
                samples: *samples,
            })
            .collect();
        let film = frame.film;
        let image = Image {
            display: Window::full(film.resolution),
            data: film.window,
            channels: &channels,
            attributes: &attributes(frame),
            compression: encoding.compression,
        };
        write(&image, out)
    }

    fn inspect(&self, path: &Path) -> Option<FileFacts> {
        whole::inspect(path)
    }
}

/// The channels of a frame with their names.
fn channels<'a>(frame: &FrameImage<'a>) -> Vec<(String, Samples<'a>)> {
    let planes = frame.film.planes();
    let alpha = || ("A".to_owned(), samples(PixelType::Half, &planes[0], 3));
    let of_plane = |plane: &'a film::Plane| {
        let names = plane.spec.channel_names().into_iter().enumerate();
        names.map(|(i, name)| (name, samples(plane.spec.pass.pixel, plane, i)))
    };
    match frame.shown {
        Shown::All => {
            let has_alpha = planes[0].spec.pass == BEAUTY;
            let all = planes.iter().flat_map(of_plane);
            all.chain((!has_alpha).then(alpha)).collect()
        }
        Shown::Plane(shown) if planes[shown].spec.pass.is_light() => {
            let plane = &planes[shown];
            let channel = |(i, name): (usize, &str)| (name.to_owned(), samples(plane.spec.pass.pixel, plane, i));
            let light = ["R", "G", "B"].into_iter().enumerate().map(channel);
            light.chain([alpha()]).collect()
        }
        Shown::Plane(shown) => of_plane(&planes[shown]).chain([alpha()]).collect(),
    }
}

/// One channel of a plane.
fn samples(pixel: PixelType, plane: &film::Plane, channel: usize) -> Samples<'_> {
    let (first, step) = (channel, plane.spec.width());
    let values = plane.values.as_slice();
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

/// The attributes of a frame, besides those that the format requires.
fn attributes(frame: &FrameImage) -> Vec<Attribute> {
    const REC_709: [f32; 8] = [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290];
    const DISPLAY_VALUES: &str = "the numbers are display values, not scene-linear light";
    let metadata = frame.metadata;
    let version = env!("CARGO_PKG_VERSION");
    let mut list = vec![
        Attribute::new("software", format!("batch-render {version}")),
        Attribute::new("batch-render/version", version),
        Attribute::new("batch-render/frame", metadata.frame),
        Attribute::new("batch-render/samples", count(metadata.samples)),
        Attribute::new("batch-render/seed", count(metadata.seed)),
        Attribute::new("batch-render/sampler", metadata.sampler),
        Attribute::new("imageCounter", metadata.frame),
    ];
    if let Some((numerator, denominator)) = metadata.fps {
        list.push(Attribute::new(
            "framesPerSecond",
            Value::Rational { numerator, denominator },
        ));
    }
    if frame.has_light() {
        if metadata.view == DisplayTransform::Raw {
            list.push(Attribute::new("comments", DISPLAY_VALUES));
        } else {
            list.push(Attribute::new("chromaticities", Value::Chromaticities(REC_709)));
            list.push(Attribute::new("colorInteropID", "lin_rec709_scene"));
        }
    }
    for plane in frame.planes() {
        list.extend(cryptomatte::attributes(&plane.spec));
    }
    for given in &metadata.attributes {
        match list.iter_mut().find(|a| a.name == given.name) {
            Some(own) if own.name == "comments" => own.value = format!("{}\n{DISPLAY_VALUES}", given.value).into(),
            Some(own) => own.value = given.value.clone(),
            None => list.push(given.clone()),
        }
    }
    list
}

/// A whole number as an `int`, or as a string where it is too large for one.
fn count(n: u32) -> Value {
    i32::try_from(n).map_or_else(|_| n.to_string().into(), Value::Int)
}

/// Writes `image` to `out`.
pub fn write(image: &Image, out: &mut dyn Write) -> Result<WriteReport, EncodeError> {
    let mut channels = image.channels.to_vec();
    channels.sort_by_key(|c| c.name);
    check(image, &channels)?;
    let header = header::encode(image, &channels)?;
    let blocks = blocks::encode(image, &channels);

    let mut out = Counting { out, bytes: 0 };
    out.write_all(&header)?;
    let mut offset = (header.len() + 8 * blocks.len()) as u64;
    let mut table = Vec::with_capacity(8 * blocks.len());
    for block in &blocks {
        table.extend_from_slice(&offset.to_le_bytes());
        offset += block.packed.len() as u64 + 8;
    }
    out.write_all(&table)?;
    let mut report = WriteReport::default();
    for block in &blocks {
        out.write_all(&block.y.to_le_bytes())?;
        out.write_all(&(block.packed.len() as i32).to_le_bytes())?;
        out.write_all(&block.packed)?;
        report.clamped += block.clamped;
        report.nans += block.nans;
    }
    report.bytes = out.bytes;
    Ok(report)
}

/// Holds `image` to the format's bounds; `channels` are its channels, sorted.
fn check(image: &Image, channels: &[Channel]) -> Result<(), EncodeError> {
    // What OpenEXR's own reader refuses.
    const FARTHEST: i64 = i32::MAX as i64 / 2;
    let unfit = |reason: String| Err(EncodeError::Unfit(reason));
    for window in [image.display, image.data] {
        let Window { x0, y0, x1, y1 } = window;
        let (width, height) = (window.width(), window.height());
        if x0 >= x1 || y0 >= y1 {
            return unfit(format!("a window of {width} x {height} pixels"));
        }
        for (min, end) in [(x0, x1), (y0, y1)] {
            if i64::from(min) <= -FARTHEST || i64::from(end) > FARTHEST {
                return unfit(format!("a window of {width} x {height} pixels from {x0}, {y0}"));
            }
        }
    }
    if channels.is_empty() {
        return unfit("no channels".to_owned());
    }
    if let Some(pair) = channels.windows(2).find(|pair| pair[0].name == pair[1].name) {
        return unfit(format!("two channels '{}'", pair[0].name));
    }
    if let Some(short) = channels.iter().find(|c| !c.samples.holds(image.data.area())) {
        return unfit(format!("channel '{}' has fewer numbers than pixels", short.name));
    }
    let bytes_per_pixel: usize = channels.iter().map(|c| c.samples.bytes_per_sample()).sum();
    let pixels = image.data.width() as usize * image.compression.lines_per_block() as usize;
    if pixels
        .checked_mul(bytes_per_pixel)
        .is_none_or(|n| n > i32::MAX as usize)
    {
        return unfit(format!(
            "lines of {} pixels of {bytes_per_pixel} bytes",
            image.data.width()
        ));
    }
    Ok(())
}
