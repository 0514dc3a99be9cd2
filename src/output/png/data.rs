//! Data as PNG files of 16 bits, in common encodings of data sets.
//!
//! | flag | pass | numbers |
//! |---|---|---|
//! | `--png-depth` | `depth` | gray, millimetres or another [`DepthUnit`] along the line of sight; 0 is nothing, 65535 is farther |
//! | `--png-normals` | `N` | red, green, blue are x, y, z in the world: 1 is -1, 32768 is 0, 65535 is 1; 0 0 0 is nothing |
//! | `--png-ids` | `objectId` | gray, the number of the object from 1; 0 is nothing |
//!
//! They hold the sample nearest to the pixel's centre.

use std::{io::Write, path::Path};

use super::{given_texts, inspect, join::join, own_texts, picture::Picture};
use crate::{
    film::Plane,
    output::{
        Attribute, Contents, CropFile, DepthUnit, EncodeError, Encoding, FileFacts, Format, FrameImage, JoinError,
        WriteReport,
    },
};

/// A kind of data file. File extensions do not select it, only flags.
#[derive(Debug)]
pub struct DataPng {
    pub flag: &'static str,
    /// The name of the files that no pattern names, without the frame's number.
    pub file: &'static str,
    /// The name of the pass.
    pub pass: &'static str,
    /// The encoding, for readers of the file.
    unit: fn(DepthUnit) -> String,
    color: ::png::ColorType,
    /// The numbers of all pixels.
    numbers: fn(&Plane, DepthUnit) -> Result<Numbers, EncodeError>,
}

/// The numbers of a file, and how many of them are too large for it.
struct Numbers {
    values: Vec<u16>,
    saturated: u64,
}

impl Numbers {
    fn new(values: Vec<u16>) -> Self {
        Self { values, saturated: 0 }
    }
}

pub static DEPTH: DataPng = DataPng {
    flag: "--png-depth",
    file: "depth",
    pass: "depth",
    unit: |unit| format!("{unit}; 0 is nothing, 65535 is farther"),
    color: ::png::ColorType::Grayscale,
    numbers: |plane, unit| {
        let background = plane.spec.pass.background;
        let number = |z: &f32| if *z < background { units(*z, unit) } else { 0 };
        let values: Vec<u16> = plane.values.iter().map(number).collect();
        let saturated = values.iter().filter(|v| **v == u16::MAX).count() as u64;
        Ok(Numbers { values, saturated })
    },
};

pub static NORMALS: DataPng = DataPng {
    flag: "--png-normals",
    file: "normals",
    pass: "N",
    unit: |_| "x, y, z in the world are (value - 32768) / 32767; 0 0 0 is nothing".to_owned(),
    color: ::png::ColorType::Rgb,
    numbers: |plane, _| {
        let pixels = plane.values.as_chunks::<3>().0.iter();
        Ok(Numbers::new(pixels.flat_map(direction).collect()))
    },
};

pub static IDS: DataPng = DataPng {
    flag: "--png-ids",
    file: "ids",
    pass: "objectId",
    unit: |_| "number of the object from 1; 0 is nothing".to_owned(),
    color: ::png::ColorType::Grayscale,
    numbers: |plane, _| {
        let number = |bits: &f32| {
            let id = bits.to_bits();
            u16::try_from(id).map_err(|_| EncodeError::Unfit(format!("the object number {id}, beyond 16 bits")))
        };
        let values: Result<_, EncodeError> = plane.values.iter().map(number).collect();
        Ok(Numbers::new(values?))
    },
};

impl Format for DataPng {
    fn name(&self) -> &'static str {
        "png"
    }

    fn contents(&self) -> Contents {
        Contents::Pass
    }

    fn encode(&self, frame: &FrameImage, encoding: Encoding, out: &mut dyn Write) -> Result<WriteReport, EncodeError> {
        let unfit = || EncodeError::Unfit(format!("the film has no pass `{}`", self.pass));
        let plane = frame.film.plane(self.pass).ok_or_else(unfit)?;
        let window = frame.film.window;
        let mut texts = own_texts(frame.film, frame.metadata);
        texts.extend(given_texts(frame.metadata));
        texts.push(("Pass".to_owned(), self.pass.to_owned()));
        texts.push(("Unit".to_owned(), (self.unit)(encoding.depth)));
        let Numbers { values, saturated } = (self.numbers)(plane, encoding.depth)?;
        let picture = Picture {
            size: [window.width(), window.height()],
            color: self.color,
            depth: ::png::BitDepth::Sixteen,
            is_srgb: false,
            texts,
            bytes: values.into_iter().flat_map(u16::to_be_bytes).collect(),
        };
        Ok(WriteReport {
            bytes: picture.write(out)?,
            saturated,
            ..WriteReport::default()
        })
    }

    fn facts(&self, path: &Path) -> Option<FileFacts> {
        super::facts(path).ok().flatten()
    }

    fn inspect(&self, path: &Path) -> Option<FileFacts> {
        inspect(path)
    }

    fn join(&self, crops: &[CropFile], own: &[Attribute]) -> Result<Vec<u8>, JoinError> {
        join(crops, own)
    }
}

/// The most objects that files of numbers hold.
pub const MOST_IDS: usize = u16::MAX as usize;

/// The warning of this many depths that are too large for their files.
pub fn saturation(count: u64, unit: DepthUnit) -> String {
    let farthest = (f32::from(u16::MAX) - 1.0) / unit.per_metre();
    let wider = match unit {
        DepthUnit::Millimetre => "; --png-depth-unit cm or m reaches farther",
        DepthUnit::Centimetre => "; --png-depth-unit m reaches farther",
        DepthUnit::Metre => "",
    };
    format!("{count} pixels of --png-depth are farther than {farthest} m and hold 65535{wider}")
}

/// Metres in this unit, at least 1 and at most 65535.
fn units(metres: f32, unit: DepthUnit) -> u16 {
    // The cast saturates.
    ((metres * unit.per_metre()).round() as u16).max(1)
}

/// A unit vector, with 0 at 32768; all zeros for the zero vector.
fn direction(v: &[f32; 3]) -> [u16; 3] {
    if *v == [0.0; 3] {
        return [0; 3];
    }
    v.map(|v| (32768.0 + (v.clamp(-1.0, 1.0) * 32767.0).round()) as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metres_become_millimetres_that_fit_and_are_never_nothing() {
        let found = [0.0, 0.0004, 1.0, 1.2346, 65.534, 70.0, f32::INFINITY].map(|m| units(m, DepthUnit::Millimetre));
        assert_eq!(found, [1, 1, 1000, 1235, 65534, 65535, 65535]);
        let found = [1.2346, 70.0].map(|m| [DepthUnit::Centimetre, DepthUnit::Metre].map(|unit| units(m, unit)));
        assert_eq!(found, [[123, 1], [7000, 70]]);
    }

    #[test]
    fn directions_lie_around_the_middle_and_come_back() {
        assert_eq!(direction(&[-1.0, 0.0, 1.0]), [1, 32768, 65535]);
        assert_eq!(direction(&[0.0; 3]), [0; 3]);
        let v = [0.6, -0.48, 0.64];
        for (v, code) in v.into_iter().zip(direction(&v)) {
            assert!(((f32::from(code) - 32768.0) / 32767.0 - v).abs() < 2e-5);
        }
    }
}
