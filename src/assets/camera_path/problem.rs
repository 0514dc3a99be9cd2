//! Errors in a camera path file, with their places.

use std::{
    fmt,
    path::{Path, PathBuf},
};

/// The number of problems that are kept; the others are only counted.
const KEPT: usize = 20;

/// Something wrong with a camera path's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PathProblem {
    /// The line, from 1; `None` for the whole file.
    pub line: Option<usize>,
    /// The column's name in the file.
    pub column: Option<String>,
    pub message: String,
}

impl PathProblem {
    /// A problem of the whole file.
    pub fn of_file(message: impl Into<String>) -> Self {
        Self {
            line: None,
            column: None,
            message: message.into(),
        }
    }

    /// A problem of one line.
    pub fn of_line(line: usize, message: impl Into<String>) -> Self {
        Self {
            line: Some(line),
            ..Self::of_file(message)
        }
    }

    /// A problem of one cell.
    pub fn of_cell(line: usize, column: &str, message: impl Into<String>) -> Self {
        Self {
            column: Some(column.to_owned()),
            ..Self::of_line(line, message)
        }
    }
}

/// The problems of one file, in the order of its lines: the first 20 of them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PathProblems {
    problems: Vec<PathProblem>,
    more: usize,
    /// The file that they are in, if it is another than the one that was read.
    file: Option<PathBuf>,
}

impl PathProblems {
    /// These as problems of another file, unless they are those of one already.
    pub(super) fn in_file(self, file: &Path) -> Self {
        let file = self.file.or_else(|| Some(file.to_owned()));
        Self { file, ..self }
    }

    pub(super) fn push(&mut self, problem: PathProblem) {
        if self.problems.len() < KEPT {
            self.problems.push(problem);
        } else {
            self.more += 1;
        }
    }

    /// Whether there is no problem.
    pub fn is_empty(&self) -> bool {
        self.problems.is_empty()
    }

    /// The first problems.
    pub fn iter(&self) -> impl Iterator<Item = &PathProblem> {
        self.problems.iter()
    }

    /// The number of problems beyond the first.
    pub fn more(&self) -> usize {
        self.more
    }

    /// The first problems without their places, separated by semicolons.
    pub fn messages(&self) -> String {
        let messages: Vec<_> = self.problems.iter().map(|problem| problem.message.as_str()).collect();
        messages.join("; ")
    }

    /// One line for each problem, `file:line: column: message`, and one that counts the rest.
    pub fn display<'a>(&'a self, path: &'a Path) -> impl fmt::Display + 'a {
        Listed { path, problems: self }
    }
}

struct Listed<'a> {
    path: &'a Path,
    problems: &'a PathProblems,
}

impl fmt::Display for Listed<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.problems.iter().enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            let file = self.problems.file.as_deref().unwrap_or(self.path);
            write!(f, "{}", file.display())?;
            if let Some(line) = problem.line {
                write!(f, ":{line}")?;
            }
            if let Some(column) = &problem.column {
                write!(f, ": {column}")?;
            }
            write!(f, ": {}", problem.message)?;
        }
        match self.problems.more {
            0 => Ok(()),
            more => write!(f, "\nand {more} more"),
        }
    }
}

impl From<PathProblem> for PathProblems {
    fn from(problem: PathProblem) -> Self {
        Self {
            problems: vec![problem],
            ..Self::default()
        }
    }
}
