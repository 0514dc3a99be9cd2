//! The pictures of two folders, by their names.

use std::{
    collections::BTreeSet,
    fs, io,
    path::{Path, PathBuf},
};

use crate::{assets::image, render::SampleRanges};

/// The pictures of two folders: their paths below the folder, in order.
#[derive(Debug, Default)]
pub struct Pairs {
    /// Pictures that both have.
    pub both: Vec<PathBuf>,
    /// Pictures of the reference that the test lacks.
    pub missing: Vec<PathBuf>,
    /// Pictures of the test without a reference.
    pub added: Vec<PathBuf>,
    /// The number of NPZ files in both, which are not compared.
    pub arrays: usize,
}

impl Pairs {
    /// Lists the pictures in two folders and the folders in them. Files whose names begin with a dot are left out, and so are those
    /// of ranges of samples that only one of the two has: they are parts of a picture.
    pub fn of(reference: &Path, test: &Path) -> io::Result<Self> {
        let mut arrays = 0;
        let [reference, test] = [pictures(reference, &mut arrays)?, pictures(test, &mut arrays)?];
        let only = |one: &BTreeSet<PathBuf>, other| {
            one.difference(other)
                .filter(|path| !is_of_range(path))
                .cloned()
                .collect()
        };
        Ok(Self {
            both: reference.intersection(&test).cloned().collect(),
            missing: only(&reference, &test),
            added: only(&test, &reference),
            arrays,
        })
    }
}

/// Whether a picture is in the folder of a range of samples.
fn is_of_range(path: &Path) -> bool {
    let folder = path.parent().and_then(Path::file_name);
    folder
        .and_then(|name| name.to_str())
        .is_some_and(SampleRanges::is_folder)
}

/// Lists the pictures below a folder, and counts the NPZ files.
fn pictures(root: &Path, arrays: &mut usize) -> io::Result<BTreeSet<PathBuf>> {
    let mut found = BTreeSet::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(root.join(&folder))? {
            let entry = entry?;
            let name = entry.file_name();
            let path = folder.join(&name);
            if name.as_encoded_bytes().starts_with(b".") {
                continue;
            }
            // Links to folders are not followed: they may lead back.
            match entry.file_type()? {
                kind if kind.is_dir() => folders.push(path),
                _ if image::has_a_picture_ending(&path) => drop(found.insert(path)),
                _ => {
                    *arrays += usize::from(
                        path.extension()
                            .is_some_and(|ending| ending.eq_ignore_ascii_case("npz")),
                    )
                }
            }
        }
    }
    Ok(found)
}
