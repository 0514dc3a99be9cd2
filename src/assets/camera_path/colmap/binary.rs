//! Reconstructions as binary files, whose numbers are little-endian.

use std::collections::HashMap;

use super::{
    model::{CameraModel, FileCamera},
    record::{Picture, Place},
    written::Reconstruction,
};
use crate::assets::camera_path::{PathProblem, PathProblems};

/// The bytes of a point of an image: its place, and the number of the point of the world.
const POINT: u64 = 24;

/// A file that is read from its start.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The number of the record, from 1.
    record: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: u64) -> Result<&'a [u8], PathProblem> {
        let rest = &self.bytes[self.at..];
        let taken = usize::try_from(count).ok().and_then(|count| rest.get(..count));
        let taken =
            taken.ok_or_else(|| self.problem(format!("the file ends at byte {} within it", self.bytes.len())))?;
        self.at += taken.len();
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], PathProblem> {
        let taken = self.take(N as u64)?;
        Ok(taken.try_into().expect("as many bytes were taken"))
    }

    fn u32(&mut self) -> Result<u32, PathProblem> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, PathProblem> {
        self.array().map(u64::from_le_bytes)
    }

    fn f64s<const N: usize>(&mut self) -> Result<[f64; N], PathProblem> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f64::from_le_bytes(self.array()?);
        }
        Ok(numbers)
    }

    /// A text that ends with a zero.
    fn name(&mut self) -> Result<String, PathProblem> {
        let length = self.bytes[self.at..].iter().position(|byte| *byte == 0);
        let length = length.ok_or_else(|| self.problem("the name has no end"))?;
        let name = self.take(length as u64)?;
        self.at += 1;
        let name = str::from_utf8(name).map_err(|_| self.problem("the name is not UTF-8"))?;
        Ok(name.to_owned())
    }

    fn problem(&self, message: impl Into<String>) -> PathProblem {
        Place::Record(self.record).problem(message)
    }
}

/// The records of a file, as many as it says.
fn records<T>(bytes: &[u8], read: impl Fn(&mut Reader<'_>) -> Result<T, PathProblem>) -> Result<Vec<T>, PathProblems> {
    let (at, record) = (0, 0);
    let mut reader = Reader { bytes, at, record };
    let too_short = |_| PathProblem::of_file("the file has no number of records, which takes 8 bytes");
    let count = reader.u64().map_err(too_short)?;
    let mut all = Vec::new();
    for _ in 0..count {
        reader.record += 1;
        all.push(read(&mut reader)?);
    }
    Ok(all)
}

/// The number, the model, the size and the parameters of each camera.
pub fn cameras(bytes: &[u8]) -> Result<HashMap<u32, FileCamera>, PathProblems> {
    let cameras = records(bytes, |reader| {
        let id = reader.u32()?;
        let number = reader.u32()? as i32;
        let unknown = || reader.problem(format!("unknown camera model {number}"));
        let model = CameraModel::by_number(number).ok_or_else(unknown)?;
        let size = [reader.u64()?, reader.u64()?].map(|n| n as f64);
        let parameters = (0..model.parameters()).map(|_| reader.f64s().map(|[number]| number));
        let parameters = parameters.collect::<Result<_, _>>()?;
        let place = Place::Record(reader.record);
        Ok((
            id,
            FileCamera {
                place,
                model,
                size,
                parameters,
            },
        ))
    })?;
    Ok(cameras.into_iter().collect())
}

/// The number, the pose, the camera, the name and the points of each image.
pub fn images(bytes: &[u8]) -> Result<Vec<Picture>, PathProblems> {
    records(bytes, |reader| {
        reader.u32()?;
        let (rotation, translation) = (reader.f64s()?, reader.f64s()?);
        let (camera, name) = (reader.u32()?, reader.name()?);
        let points = reader.u64()?;
        reader.take(points.saturating_mul(POINT))?;
        Ok(Picture {
            place: Place::Record(reader.record),
            rotation,
            translation,
            camera,
            name,
        })
    })
}

/// The names and the bytes of the files.
pub fn files(all: &Reconstruction) -> [(&'static str, Vec<u8>); 3] {
    let count = |n: usize| (n as u64).to_le_bytes();
    let id = |i: usize| (i as u32 + 1).to_le_bytes();
    let mut images = count(all.shots.len()).to_vec();
    for (i, shot) in all.shots.iter().enumerate() {
        images.extend(id(i));
        images.extend(shot.pose.iter().flat_map(|number| number.to_le_bytes()));
        images.extend(id(shot.camera));
        images.extend(shot.name.bytes().filter(|byte| *byte != 0));
        images.push(0);
        images.extend(count(0));
    }
    let mut cameras = count(all.cameras.len()).to_vec();
    for (i, camera) in all.cameras.iter().enumerate() {
        cameras.extend(id(i));
        cameras.extend(camera.model.number.to_le_bytes());
        cameras.extend(camera.size.iter().flat_map(|side| (*side as u64).to_le_bytes()));
        cameras.extend(camera.parameters.iter().flat_map(|number| number.to_le_bytes()));
    }
    [
        ("cameras.bin", cameras),
        ("images.bin", images),
        ("points3D.bin", count(0).to_vec()),
    ]
}
