//! Two pictures compared: errors of their numbers, and the difference that a viewer sees.
//!
//! One picture is the *reference*, the other the *test*. [`Comparison::new`] has all measures of a pair; [`pairs`] finds the pairs
//! of two folders, and [`compare_passes`] compares the passes of EXR files; [`heat::color`] shows a difference as a colour.

mod flip;
pub mod heat;
mod measures;
pub mod pairs;
mod passes;
mod picture;

use std::{
    io,
    path::{Path, PathBuf},
};

use crate::assets::{Files, image::ImageError};

pub use measures::{Comparison, Measures};
pub use passes::{ComparedPass, PassMeasures, compare_passes};
pub use picture::Picture;

/// Why two pictures cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    #[error(transparent)]
    Image(#[from] ImageError),
    #[error("the pictures differ in size: {}x{} and {}x{}", reference[0], reference[1], test[0], test[1])]
    Size { reference: [u32; 2], test: [u32; 2] },
    #[error("one picture holds light and the other display values: compare EXR with EXR, and PNG with PNG")]
    Range,
    #[error("one picture holds data in 16 bits and the other display values")]
    DataRange,
    #[error("the pictures hold other data: {reference} and {test}")]
    Data { reference: String, test: String },
    #[error("the data windows differ: {} and {}", window(reference), window(test))]
    Window {
        reference: ([u32; 2], [i64; 2]),
        test: ([u32; 2], [i64; 2]),
    },
    #[error("cannot read {}: {source}", path.display())]
    Read { source: io::Error, path: PathBuf },
}

fn window(([width, height], [x, y]): &([u32; 2], [i64; 2])) -> String {
    format!("{width}x{height} pixels at {x},{y}")
}

/// Compares the picture files `test` and `reference`.
///
/// EXR files are compared over their data windows, which have to be the same. A number of a picture that is `limit` or less away
/// from that of the reference is no difference in [`Measures::pixels`].
pub fn compare(reference: &Path, test: &Path, limit: f32, files: &Files) -> Result<Comparison, CompareError> {
    let reference = Picture::read(reference, files)?;
    let test = Picture::read(test, files)?;
    Comparison::new(&reference, &test, limit)
}

#[cfg(test)]
mod tests;
