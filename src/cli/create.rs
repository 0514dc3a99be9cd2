//! Errors of files and folders that the program creates.

use std::{io, path::Path};

use batch_render::{
    error::Error,
    output::{Obstacle, OutputError, atomic},
};

/// Returns the error of a file or folder that cannot be created, which has the exit code of such outputs.
pub fn cannot_create(source: io::Error, path: &Path) -> Error {
    Error::Output(OutputError::Create {
        source: atomic::folder_problem(source, path),
        path: path.to_owned(),
        obstacle: Obstacle::Folder,
    })
}
