//! The scene from standard input (`batch-render - --input-format toml`).

use std::{
    io::{self, Read},
    path::{Path, PathBuf},
};

use batch_render::{
    assets::{SuppliedFile, model_formats::is_model},
    error::Error,
};

/// The name of the scene that stands for standard input.
pub const STANDARD_INPUT: &str = "-";

/// The ending of scene files.
const SCENE_FILE: &str = "toml";

/// Reads the name of a form: the ending that files of it have.
pub fn input_format(name: &str) -> Result<String, String> {
    match name == SCENE_FILE || is_model(&path(name)) {
        true => Ok(name.to_owned()),
        false => Err("expected toml, or the ending of a model, such as glb, obj, ply or stl".to_owned()),
    }
}

/// The path under which the scene is known, in the current folder, where the files are that it names.
fn path(format: &str) -> PathBuf {
    PathBuf::from(format!("stdin.{format}"))
}

/// Reads the scene if it is on standard input: its path and its content.
///
/// # Errors
/// Its form is not told, or told of a file; or it cannot be read.
pub fn read(scene: Option<&Path>, format: Option<&str>) -> Result<Option<SuppliedFile>, Error> {
    match (scene == Some(Path::new(STANDARD_INPUT)), format) {
        (false, None) => Ok(None),
        (true, Some(format)) => {
            let mut bytes = Vec::new();
            let read = io::stdin().lock().read_to_end(&mut bytes);
            read.map_err(Error::Stdin)?;
            Ok(Some((path(format), bytes.into())))
        }
        (true, None) => Err(Error::Usage(
            "the scene is `-`, standard input: --input-format tells its form, such as toml or glb".to_owned(),
        )),
        (false, Some(_)) => Err(Error::Usage(
            "--input-format is that of standard input (a scene `-`); files have it in their names".to_owned(),
        )),
    }
}
