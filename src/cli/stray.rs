//! The error of a word that clap takes for a command because a scene stands before it.

use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
};

use batch_render::value::UnknownName;
use clap::{
    CommandFactory, Error,
    error::{ContextKind, ContextValue, ErrorKind},
};

use super::args::Args;

/// Returns the error in other words, if a second word stands beside the scene: a command whose name is mistyped, or two scenes.
pub fn reworded(error: &Error) -> Option<Error> {
    let (ErrorKind::ArgumentConflict, ContextValue::String(second)) =
        (error.kind(), error.get(ContextKind::InvalidSubcommand)?)
    else {
        return None;
    };
    let mut command = Args::command();
    let words = std::env::args_os().take_while(|word| word != OsStr::new(second));
    let given = command.clone().ignore_errors(true).try_get_matches_from(words).ok()?;
    let first = given.get_one::<PathBuf>("scene")?.display().to_string();
    let names: Vec<_> = command
        .get_subcommands()
        .map(|command| command.get_name().to_owned())
        .collect();
    let unknown = UnknownName::new("command", &first, names.iter().map(String::as_str));
    let message = match unknown.suggestion() {
        Some(_) if !Path::new(&first).exists() => unknown.to_string(),
        _ => format!("a job has one scene, found `{first}` and `{second}`"),
    };
    Some(command.error(ErrorKind::ArgumentConflict, message))
}
