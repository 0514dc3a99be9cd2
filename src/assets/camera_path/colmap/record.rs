//! The records of a reconstruction and their places.

use crate::assets::camera_path::PathProblem;

/// A picture of a reconstruction.
pub struct Picture {
    /// Its line, or its number from 1 in a binary file.
    pub place: Place,
    /// `w, x, y, z`.
    pub rotation: [f64; 4],
    pub translation: [f64; 3],
    pub camera: u32,
    pub name: String,
}

/// A place in a file.
#[derive(Clone, Copy)]
pub enum Place {
    Line(usize),
    /// The number of a record from 1, in a binary file.
    Record(usize),
}

impl Place {
    pub fn problem(self, message: impl Into<String>) -> PathProblem {
        match self {
            Self::Line(line) => PathProblem::of_line(line, message),
            Self::Record(number) => PathProblem::of_file(format!("record {number}: {}", message.into())),
        }
    }
}
