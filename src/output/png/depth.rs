//! Depth as a gray PNG of 16 bits, in millimetres, as data sets have it.
//!
//! 0 where nothing is seen. 65535 stands for all that is farther away than 65.534 m. It is the pass `depth`, along the line of
//! sight, of the sample nearest to the pixel's centre.

use std::{io::Write, path::Path};

use super::{given_texts, inspect, join::join, own_texts, picture::Picture};
use crate::output::{
    Attribute, Contents, CropFile, EncodeError, Encoding, FileFacts, Format, FrameImage, JoinError, WriteReport,
};

/// The name of the pass that the files show.
pub const PASS: &str = "depth";

/// The format, which no ending asks for.
#[derive(Debug)]
pub struct DepthPng;

impl Format for DepthPng {
    fn name(&self) -> &'static str {
        "png"
    }

    fn contents(&self) -> Contents {
        Contents::Picture
    }

    fn encode(&self, frame: &FrameImage, _: Encoding, out: &mut dyn Write) -> Result<WriteReport, EncodeError> {
        let unfit = || EncodeError::Unfit(format!("the film has no pass `{PASS}`"));
        let depth = frame.film.plane(PASS).ok_or_else(unfit)?;
        let window = frame.film.window;
        let mut texts = own_texts(frame.film, frame.metadata);
        texts.extend(given_texts(frame.metadata));
        texts.push(("Pass".to_owned(), PASS.to_owned()));
        texts.push(("Unit".to_owned(), "mm; 0 is nothing, 65535 is farther".to_owned()));
        let background = depth.spec.pass.background;
        let millimetres = |z: &f32| if *z < background { millimetres(*z) } else { 0 };
        let picture = Picture {
            size: [window.width(), window.height()],
            color: ::png::ColorType::Grayscale,
            depth: ::png::BitDepth::Sixteen,
            is_srgb: false,
            texts,
            bytes: depth.values.iter().flat_map(|z| millimetres(z).to_be_bytes()).collect(),
        };
        Ok(WriteReport {
            bytes: picture.write(out)?,
            ..WriteReport::default()
        })
    }

    fn inspect(&self, path: &Path) -> Option<FileFacts> {
        inspect(path)
    }

    fn join(&self, crops: &[CropFile], own: &[Attribute]) -> Result<Vec<u8>, JoinError> {
        join(crops, own)
    }
}

/// Metres as millimetres, at least 1 and at most 65535.
fn millimetres(metres: f32) -> u16 {
    // The cast saturates.
    ((metres * 1000.0).round() as u16).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metres_become_millimetres_that_fit_and_are_never_nothing() {
        let found = [0.0, 0.0004, 1.0, 1.2346, 65.534, 70.0, f32::INFINITY].map(millimetres);
        assert_eq!(found, [1, 1, 1000, 1235, 65534, 65535, 65535]);
    }
}
