//! Errors of words that clap or the renderer would tell of in other words than what the user did: mistyped commands, commands after
//! a scene, negative values, and texts that are not UTF-8.

use std::{ffi::OsString, path::Path};

use batch_render::value::UnknownName;
use clap::{
    CommandFactory, Error,
    error::{ContextKind, ErrorKind},
};

use super::{args::Args, arguments::arguments};

/// Returns the error in other words, if a text is not UTF-8.
pub fn reworded(error: &Error) -> Option<Error> {
    match error.kind() {
        ErrorKind::InvalidUtf8 => not_utf8(&arguments().collect::<Vec<_>>()),
        ErrorKind::UnknownArgument => negative(error, &arguments().collect::<Vec<_>>()),
        _ => None,
    }
}

/// Returns the error of a negative value behind an option that takes none, which is read as an option itself.
fn negative(error: &Error, words: &[OsString]) -> Option<Error> {
    let unknown = error.get(ContextKind::InvalidArg)?.to_string();
    let is_number = |word: &str| {
        word.strip_prefix('-')
            .is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
    };
    let words: Vec<&str> = words.iter().map_while(|word| word.to_str()).collect();
    let mut pairs = words.iter().zip(words.iter().skip(1));
    let is_meant = |(option, value): &(&&str, &&str)| {
        option.starts_with('-') && !option.contains('=') && is_number(value) && value.starts_with(&unknown)
    };
    let (option, value) = pairs.find(is_meant)?;
    let message = format!("`{value}` is read as an option: write a negative value of {option} as {option}={value}");
    Some(Args::command().error(ErrorKind::UnknownArgument, message))
}

/// Returns the error of a scene that is no file but the mistyped name of a command, or of a command after a scene.
pub fn mistyped_command<'a>(scenes: impl IntoIterator<Item = &'a Path>) -> Option<Error> {
    let mut scenes = scenes.into_iter();
    let first = scenes.next()?;
    let message = without_viewer(first)
        .or_else(|| mistyped(first))
        .or_else(|| scenes.find_map(|word| late_command(first, word)))?;
    Some(Args::command().error(ErrorKind::InvalidSubcommand, message))
}

/// The message of the viewer's command where the viewer is not built in.
fn without_viewer(word: &Path) -> Option<String> {
    let is_meant = cfg!(not(feature = "viewer")) && word == Path::new("fly") && !word.exists();
    is_meant.then(|| "this build of the program has no viewer, and so no command `fly`".to_owned())
}

/// The message of a word after the scene `first` that is no file but the name of a command.
fn late_command(first: &Path, word: &Path) -> Option<String> {
    let name = word.to_str()?;
    let is_command = Args::command().find_subcommand(name).is_some() && !word.exists();
    let first = first.display();
    is_command.then(|| format!("the command `{name}` stands before the scene, and not after `{first}`"))
}

/// The message of a word that is no file and is similar to the name of a command.
fn mistyped(word: &Path) -> Option<String> {
    let command = Args::command();
    let names = command.get_subcommands().map(|command| command.get_name());
    let unknown = UnknownName::new("command", word.to_str()?, names);
    let is_meant = unknown.suggestion().is_some() && !word.exists();
    is_meant.then(|| unknown.to_string())
}

/// Returns the error that names the first of these words that must be UTF-8 and is not.
fn not_utf8(words: &[OsString]) -> Option<Error> {
    let is_wrong = |word: &&OsString| word.to_str().is_none();
    let lossy = |word: &OsString| OsString::from(word.to_string_lossy().into_owned());
    // Some words are paths, which may be anything.
    let is_at_fault = |at: &usize| {
        let others = words.iter().enumerate();
        let words = others.map(|(i, word)| if i == *at { word.clone() } else { lossy(word) });
        let parsed = Args::command().try_get_matches_from(words);
        parsed.is_err_and(|e| e.kind() == ErrorKind::InvalidUtf8)
    };
    let candidates = words
        .iter()
        .enumerate()
        .filter(|(_, word)| is_wrong(word))
        .map(|(i, _)| i);
    let at = candidates.into_iter().find(is_at_fault)?;
    let text = words[at].to_string_lossy();
    let (flag, value) = match text.split_once('=').filter(|(flag, _)| flag.starts_with('-')) {
        Some((flag, value)) => (Some(flag.to_owned()), value),
        None => (
            words[at - 1]
                .to_str()
                .filter(|word| word.starts_with('-'))
                .map(str::to_owned),
            &*text,
        ),
    };
    let flag = flag.map(|flag| format!("{flag}: ")).unwrap_or_default();
    Some(Args::command().error(
        ErrorKind::InvalidUtf8,
        format!("{flag}expected UTF-8 text, found `{value}`"),
    ))
}
