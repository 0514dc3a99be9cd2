//! JPEG: pictures for displays, with 8 bits per channel, over black.
//!
//! Colours have the full resolution, and the quality is 95 of 100 unless another is given. The texts of PNG files are comments,
//! each a keyword, a zero byte and a value. The same picture has the same bytes everywhere.

use std::{
    io::{self, BufReader, Read, Seek, SeekFrom, Write},
    path::Path,
};

use image::{ExtendedColorType, codecs::jpeg::JpegEncoder};

use super::{
    Attribute, Contents, EncodeError, Encoding, FileFacts, Format, FrameImage, WriteReport,
    join::{CropFile, JoinError},
    png::{self, WINDOW, parse_window},
    seal,
};
use crate::film::Window;

/// The bytes that a segment holds beside its length.
const LONGEST: usize = 0xffff - 2;

const BEGIN: [u8; 2] = [0xff, 0xd8];
const END: [u8; 2] = [0xff, 0xd9];
const COMMENT: u8 = 0xfe;
/// The first segment of pixels.
const SCAN: u8 = 0xda;

/// The format.
#[derive(Debug)]
pub struct Jpg;

impl Format for Jpg {
    fn name(&self) -> &'static str {
        "jpg"
    }

    fn contents(&self) -> Contents {
        Contents::Picture
    }

    fn largest_side(&self) -> u32 {
        u16::MAX.into()
    }

    fn can_join(&self) -> bool {
        false
    }

    fn encode(&self, frame: &FrameImage, encoding: Encoding, out: &mut dyn Write) -> Result<WriteReport, EncodeError> {
        let window = frame.film.window;
        let (width, height) = (window.width(), window.height());
        let [Ok(columns), Ok(rows)] = [width, height].map(u16::try_from) else {
            return Err(EncodeError::Unfit(format!(
                "a JPEG picture of {width} x {height} pixels"
            )));
        };
        if window.area() == 0 {
            return Err(EncodeError::Unfit(format!("a picture of {width} x {height} pixels")));
        }
        let mut file = Vec::new();
        JpegEncoder::new_with_quality(&mut file, encoding.jpeg.get())
            .encode(
                frame.pixels_over_black().as_flattened(),
                columns.into(),
                rows.into(),
                ExtendedColorType::Rgb8,
            )
            .map_err(|error| EncodeError::Unfit(error.to_string()))?;
        // Readers expect the segment of JFIF at the beginning.
        let head = file
            .get(4..6)
            .map_or(0, |length| usize::from(u16::from_be_bytes([length[0], length[1]])));
        let (first, rest) = file.split_at(4 + head);
        let mut comments = Vec::new();
        put(&mut comments, &seal::attribute());
        for (key, text) in png::texts(frame).into_iter().filter(|(key, _)| key != seal::NAME) {
            put(&mut comments, &[key.as_bytes(), b"\0", text.as_bytes()].concat());
        }
        [first, &comments, rest]
            .into_iter()
            .try_for_each(|part| out.write_all(part))?;
        Ok(WriteReport {
            bytes: (file.len() + comments.len()) as u64,
            nans: png::nans(frame),
            ..WriteReport::default()
        })
    }

    fn facts(&self, path: &Path) -> Option<FileFacts> {
        facts(path).ok().flatten()
    }

    fn inspect(&self, path: &Path) -> Option<FileFacts> {
        let facts = self.facts(path)?;
        let is_whole = match seal::is_intact(path).ok()? {
            Some(is_intact) => is_intact,
            None => facts.version().is_none() && super::decoded(path).is_some(),
        };
        is_whole.then_some(facts)
    }

    fn join(&self, crops: &[CropFile], _: &[Attribute]) -> Result<Vec<u8>, JoinError> {
        let reason = "JPEG is lossy: its pixels, packed again, are not those of the whole picture";
        Err(JoinError::unfit(&crops[0], &reason))
    }
}

/// Appends a comment; one that is too long is left out.
fn put(bytes: &mut Vec<u8>, comment: &[u8]) {
    if comment.len() <= LONGEST {
        bytes.extend([0xff, COMMENT]);
        bytes.extend((comment.len() as u16 + 2).to_be_bytes());
        bytes.extend(comment);
    }
}

/// The facts in the segments before the pixels.
fn facts(path: &Path) -> io::Result<Option<FileFacts>> {
    let mut file = BufReader::new(super::facts::open(path)?);
    let (mut begin, mut end) = ([0; 2], [0; 2]);
    file.seek(SeekFrom::End(-2))?;
    file.read_exact(&mut end)?;
    file.seek(SeekFrom::Start(0))?;
    file.read_exact(&mut begin)?;
    if begin != BEGIN || end != END {
        return Ok(None);
    }
    let (mut size, mut attributes) = (None, Vec::new());
    loop {
        let mut head = [0; 4];
        file.read_exact(&mut head)?;
        let [mark, kind, length @ ..] = head;
        let Some(length) = u16::from_be_bytes(length).checked_sub(2).filter(|_| mark == 0xff) else {
            return Ok(None);
        };
        if kind == SCAN {
            break;
        }
        let mut segment = vec![0; length.into()];
        file.read_exact(&mut segment)?;
        match (kind, &segment[..]) {
            (COMMENT, comment) => attributes.extend(attribute(comment)),
            // The size is in the segments of all kinds of frames, which are these but for three of other tables.
            (0xc0..=0xcf, [_, h1, h0, w1, w0, ..]) if ![0xc4, 0xc8, 0xcc].contains(&kind) => {
                size = Some([[*w1, *w0], [*h1, *h0]].map(|side| u32::from(u16::from_be_bytes(side))));
            }
            _ => {}
        }
    }
    let told = attributes.iter().find(|a: &&Attribute| a.name == WINDOW);
    let told = told.and_then(|a| parse_window(&a.value.to_string()));
    Ok(size.map(|size| {
        let (window, resolution) = told.unwrap_or((Window::full(size), size));
        FileFacts {
            resolution,
            window,
            attributes,
        }
    }))
}

/// A comment of this program: a keyword and a value.
fn attribute(comment: &[u8]) -> Option<Attribute> {
    let at = comment.iter().position(|byte| *byte == 0)?;
    let (key, value) = (
        str::from_utf8(&comment[..at]).ok()?,
        str::from_utf8(&comment[at + 1..]).ok()?,
    );
    (key != seal::NAME).then(|| Attribute::new(key, value))
}
