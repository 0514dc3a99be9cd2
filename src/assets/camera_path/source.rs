//! A file of cameras that is read, its numbers and its lines.

use std::{path::Path, sync::Arc};

use super::{CameraPathOptions, PathProblem, PathProblems};
use crate::{assets::Files, camera::path::MAX_FRAME, value::one_line};

/// The most characters of a cell that a message shows.
const MOST_SHOWN: usize = 80;

/// A file that is read.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    pub path: &'a Path,
    pub bytes: &'a [u8],
    pub options: &'a CameraPathOptions,
    /// Reads the files beside it.
    pub files: &'a Files,
}

impl<'a> Source<'a> {
    /// The text of the file without a byte order mark.
    pub(super) fn text(&self) -> Result<&'a str, PathProblem> {
        text(self.bytes)
    }

    /// The bytes of the file of this name beside it.
    pub(super) fn beside(&self, name: &str) -> Result<Arc<[u8]>, PathProblems> {
        let path = self.path.with_file_name(name);
        let missing = |error| PathProblems::from(PathProblem::of_file(format!("cannot read the file: {error}")));
        self.files.read(&path).map_err(|error| missing(error).in_file(&path))
    }
}

/// A text without a byte order mark.
pub(super) fn text(bytes: &[u8]) -> Result<&str, PathProblem> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    str::from_utf8(text).map_err(|error| {
        let line = line_at(text, error.valid_up_to());
        PathProblem::of_line(line, "the text is not UTF-8")
    })
}

/// The number of the line that the byte `at` is on.
pub(super) fn line_at(text: &[u8], at: usize) -> usize {
    1 + text[..at.min(text.len())].iter().filter(|byte| **byte == b'\n').count()
}

/// The words of a line.
pub(super) struct Words<'a> {
    pub line: usize,
    pub words: Vec<&'a str>,
}

/// The lines of a text that are neither empty nor comments, as words between blanks, commas or semicolons.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Words<'_>> {
    text.lines().enumerate().filter_map(words)
}

/// The words of the line with this index; `None` for a comment and an empty line.
fn words((i, text): (usize, &str)) -> Option<Words<'_>> {
    let is_gap = |c: char| c.is_whitespace() || c == ',' || c == ';';
    let words: Vec<&str> = text.split(is_gap).filter(|word| !word.is_empty()).collect();
    let is_comment = words.first().is_none_or(|first| first.starts_with('#'));
    (!is_comment).then_some(Words { line: i + 1, words })
}

impl Words<'_> {
    pub fn problem(&self, message: impl Into<String>) -> PathProblem {
        PathProblem::of_line(self.line, message)
    }

    /// The number of the word `column`, which is called `name`.
    pub fn number(&self, column: usize, name: &str) -> Result<f64, PathProblem> {
        let Some(word) = self.words.get(column) else {
            return Err(PathProblem::of_cell(self.line, name, "the number is missing"));
        };
        number(word).map_err(|message| PathProblem::of_cell(self.line, name, message))
    }

    /// The numbers of the words from `column` on.
    pub fn numbers<const N: usize>(&self, column: usize, names: [&str; N]) -> Result<[f64; N], PathProblem> {
        let mut numbers = [0.0; N];
        for (i, name) in names.iter().enumerate() {
            numbers[i] = self.number(column + i, name)?;
        }
        Ok(numbers)
    }

    /// The whole number of a frame.
    pub fn frame(&self, column: usize) -> Result<i64, PathProblem> {
        let frame = self.number(column, "frame")?;
        let is_frame = frame.fract() == 0.0 && frame.abs() <= MAX_FRAME as f64;
        let message = || format!("{frame} is not a whole number between -{MAX_FRAME} and {MAX_FRAME}");
        is_frame
            .then_some(frame as i64)
            .ok_or_else(|| PathProblem::of_cell(self.line, "frame", message()))
    }
}

/// A finite number, or what is wrong with it.
pub(super) fn number(word: &str) -> Result<f64, String> {
    let shown = || one_line(word, MOST_SHOWN);
    match word.parse::<f64>() {
        Ok(v) if !v.is_finite() => Err(format!("'{}' is not finite", shown())),
        Ok(v) if v.abs() > f64::from(f32::MAX) => Err(format!("'{}' is too large", shown())),
        Ok(v) => Ok(v),
        Err(_) => Err(format!("'{}' is not a number", shown())),
    }
}
