//! Writing files: headers, the table of blocks, and the blocks.

use std::io::Write;

use super::{
    blocks::{self, Block},
    header::{self, PartFacts},
    image::{Channel, Image},
};
use crate::{
    film::Window,
    math::sorting,
    output::{BlockShape, EncodeError, WriteReport, counting::Counting},
};

/// Writes `image` to `out`.
pub fn write(image: &Image, out: &mut dyn Write) -> Result<WriteReport, EncodeError> {
    let flags = match image.blocks {
        BlockShape::Lines => 0,
        BlockShape::Tiles => header::TILED,
    };
    write_file(&[("", *image)], flags, out)
}

/// Writes named images to `out`, as the parts of one file.
pub fn write_parts(parts: &[(&str, Image)], out: &mut dyn Write) -> Result<WriteReport, EncodeError> {
    write_file(parts, header::MULTI_PART, out)
}

fn write_file(parts: &[(&str, Image)], flags: u32, out: &mut dyn Write) -> Result<WriteReport, EncodeError> {
    let mut head = header::begin(parts.iter().flat_map(|(_, image)| header::names(image)), flags);
    let is_multi = flags & header::MULTI_PART != 0;
    let mut packed = Vec::new();
    for (name, image) in parts {
        let mut channels = image.channels.to_vec();
        sorting::sort_by_key(&mut channels, |c| c.name);
        check(image, &channels)?;
        let blocks = blocks::encode(image, &channels)?;
        let facts = is_multi.then_some(PartFacts {
            name,
            blocks: blocks.len() as u32,
        });
        head.extend(header::encode(image, &channels, facts)?);
        packed.push(blocks);
    }
    if is_multi {
        head.push(0);
    }

    let mut out = Counting { out, bytes: 0 };
    out.write_all(&head)?;
    let block_count: usize = packed.iter().map(Vec::len).sum();
    let before = |block: &Block| block.place.bytes().len() + if is_multi { 8 } else { 4 };
    let mut offset = (head.len() + 8 * block_count) as u64;
    let mut table = Vec::with_capacity(8 * block_count);
    for block in packed.iter().flatten() {
        table.extend_from_slice(&offset.to_le_bytes());
        offset += (before(block) + block.packed.len()) as u64;
    }
    out.write_all(&table)?;
    let mut report = WriteReport::default();
    for (part, block) in packed
        .iter()
        .enumerate()
        .flat_map(|(i, blocks)| blocks.iter().map(move |b| (i, b)))
    {
        if is_multi {
            out.write_all(&(part as i32).to_le_bytes())?;
        }
        out.write_all(&block.place.bytes())?;
        out.write_all(&(block.packed.len() as i32).to_le_bytes())?;
        out.write_all(&block.packed)?;
        report.clamped += block.clamped;
        report.nans += block.nans;
    }
    report.bytes = out.bytes;
    Ok(report)
}

/// Checks the limits of the format; `channels` are the image's channels, sorted.
fn check(image: &Image, channels: &[Channel]) -> Result<(), EncodeError> {
    // The limit of OpenEXR's own reader.
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
