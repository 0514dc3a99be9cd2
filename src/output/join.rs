//! Joining crops: the files of parts of a picture become one file.

use std::{
    fmt,
    path::{Path, PathBuf},
};

use super::Attribute;
use crate::film::Window;

/// A complete file with a part of a picture.
#[derive(Clone, Debug)]
pub struct CropFile {
    pub path: PathBuf,
    pub window: Window,
}

/// Why crops were not joined.
#[derive(Debug, thiserror::Error)]
pub enum JoinError {
    #[error("there is no such file: {}", path.display())]
    Missing { path: PathBuf },
    #[error("the file is {found}, and the merged one {expected}: merge files of one format: {}", path.display())]
    OtherFormat {
        found: &'static str,
        expected: &'static str,
        path: PathBuf,
    },
    #[error("the file is incomplete or altered: {}", path.display())]
    Damaged { path: PathBuf },
    #[error("the file is denoised: join the crops with noise, and denoise the whole: {}", path.display())]
    Denoised { path: PathBuf },
    #[error("the file was not written by this version of batch-render: {}", path.display())]
    Foreign { path: PathBuf },
    #[error("the files are of different pictures, by their frames, inputs or settings: {} and {}", first.display(), second.display())]
    OtherPicture { first: PathBuf, second: PathBuf },
    #[error("the file reaches beyond its picture, so it is no crop: {}", path.display())]
    Overscan { path: PathBuf },
    #[error("two files hold the crop {}: {} and {}", Edges(window), first.display(), second.display())]
    Overlap {
        window: Window,
        first: PathBuf,
        second: PathBuf,
    },
    #[error("no file holds the crop {} of the {}x{} picture", Edges(window), resolution[0], resolution[1])]
    Gap { window: Window, resolution: [u32; 2] },
    /// The file has changed since it was inspected, or cannot be read.
    #[error("cannot read the pixels: {reason}: {}", path.display())]
    Unreadable { reason: String, path: PathBuf },
    #[error("the files hold other layers or numbers than each other: {} and {}", first.display(), second.display())]
    Different { first: PathBuf, second: PathBuf },
    #[error("{reason}: {}", path.display())]
    Unfit { reason: String, path: PathBuf },
}

/// A window as `--crop` takes it.
struct Edges<'a>(&'a Window);

impl fmt::Display for Edges<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Window { x0, y0, x1, y1 } = self.0;
        write!(f, "{x0},{y0},{x1},{y1}")
    }
}

impl JoinError {
    pub(super) fn unreadable(path: &Path, reason: &impl ToString) -> Self {
        Self::Unreadable {
            reason: reason.to_string(),
            path: path.to_owned(),
        }
    }

    pub(super) fn different(first: &CropFile, second: &CropFile) -> Self {
        Self::Different {
            first: first.path.clone(),
            second: second.path.clone(),
        }
    }

    pub(super) fn unfit(crop: &CropFile, error: &impl ToString) -> Self {
        Self::Unfit {
            reason: error.to_string(),
            path: crop.path.clone(),
        }
    }
}

/// Replaces the values of those `attributes` that have a name in `own`.
pub(super) fn replace(attributes: &mut [Attribute], own: &[Attribute]) {
    for attribute in attributes {
        if let Some(other) = own.iter().find(|other| other.name == attribute.name) {
            attribute.value = other.value.clone();
        }
    }
}

/// Checks that crops cover each pixel of a picture once.
pub(super) fn check_cover(resolution: [u32; 2], crops: &[CropFile]) -> Result<(), JoinError> {
    let picture = Window::full(resolution);
    for (i, crop) in crops.iter().enumerate() {
        if common(crop.window, picture) != Some(crop.window) {
            return Err(JoinError::Overscan {
                path: crop.path.clone(),
            });
        }
        let both = |other: &CropFile| Some((common(crop.window, other.window)?, other.path.clone()));
        if let Some((window, first)) = crops[..i].iter().find_map(both) {
            return Err(JoinError::Overlap {
                window,
                first,
                second: crop.path.clone(),
            });
        }
    }
    match gap(picture, crops) {
        None => Ok(()),
        Some(window) => Err(JoinError::Gap { window, resolution }),
    }
}

/// The intersection of two windows; `None` if it is empty.
fn common(a: Window, b: Window) -> Option<Window> {
    let (x0, y0) = (a.x0.max(b.x0), a.y0.max(b.y0));
    let (x1, y1) = (a.x1.min(b.x1), a.y1.min(b.y1));
    (x0 < x1 && y0 < y1).then(|| Window::new(x0, y0, x1, y1))
}

/// A part of a picture that no crop covers: the first from the top, and from the left there.
fn gap(picture: Window, crops: &[CropFile]) -> Option<Window> {
    let edges = |of: fn(&Window) -> [i32; 2]| {
        let windows = crops.iter().map(|crop| &crop.window).chain([&picture]);
        let mut edges: Vec<i32> = windows.flat_map(of).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    };
    let (columns, rows) = (edges(|w| [w.x0, w.x1]), edges(|w| [w.y0, w.y1]));
    for row in rows.windows(2) {
        let is_open = |column: &[i32]| {
            let cell = Window::new(column[0], row[0], column[1], row[1]);
            crops.iter().all(|crop| common(crop.window, cell).is_none())
        };
        let mut open = columns.windows(2).skip_while(|column| !is_open(column));
        if let Some(first) = open.next() {
            let last = open.take_while(|column| is_open(column)).last().unwrap_or(first);
            return Some(Window::new(first[0], row[0], last[1], row[1]));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crops(windows: &[[i32; 4]]) -> Vec<CropFile> {
        let crop = |(i, [x0, y0, x1, y1]): (usize, &[i32; 4])| CropFile {
            path: i.to_string().into(),
            window: Window::new(*x0, *y0, *x1, *y1),
        };
        windows.iter().enumerate().map(crop).collect()
    }

    fn message(windows: &[[i32; 4]]) -> Option<String> {
        check_cover([8, 6], &crops(windows))
            .err()
            .map(|error| error.to_string())
    }

    #[test]
    fn gaps_and_overlaps_are_named_as_crops() {
        let ([a, b], [c, d]) = ([[0, 0, 3, 6], [3, 0, 8, 2]], [[3, 2, 5, 6], [5, 2, 8, 6]]);
        assert_eq!(message(&[d, a, c, b]), None);
        assert_eq!(
            message(&[a, b, d]).as_deref(),
            Some("no file holds the crop 3,2,5,6 of the 8x6 picture")
        );
        assert_eq!(
            message(&[a, b]).as_deref(),
            Some("no file holds the crop 3,2,8,6 of the 8x6 picture")
        );
        assert_eq!(
            message(&[a, b, c, [4, 1, 8, 6]]).as_deref(),
            Some("two files hold the crop 4,1,8,2: 1 and 3")
        );
        assert_eq!(
            message(&[[-1, 0, 8, 6]]).as_deref(),
            Some("the file reaches beyond its picture, so it is no crop: 0")
        );
    }
}
