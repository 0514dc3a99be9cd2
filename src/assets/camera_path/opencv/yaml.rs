//! The part of YAML that OpenCV writes: keys without indentation, with a scalar, a list in brackets or a matrix.

use crate::{
    assets::camera_path::{PathProblem, source},
    value::one_line,
};

/// The entries of a file, in their order.
pub struct Document<'a> {
    entries: Vec<Entry<'a>>,
}

/// A key with all that follows up to the next.
pub struct Entry<'a> {
    key: &'a str,
    line: usize,
    /// The rest of the line of the key.
    value: &'a str,
    /// The lines below it, each with its number.
    below: Vec<(usize, &'a str)>,
}

impl<'a> Document<'a> {
    pub fn new(text: &'a str) -> Self {
        let mut entries: Vec<Entry<'a>> = Vec::new();
        for (i, line) in text.lines().enumerate() {
            let is_head = line.starts_with(['%', '#']) || line.starts_with("---") || line.starts_with("...");
            if is_head || line.trim().is_empty() {
                continue;
            }
            let is_key = line.starts_with(|c: char| c.is_alphabetic() || c == '_' || c == '"');
            match (line.split_once(':'), entries.last_mut()) {
                (Some((key, value)), _) if is_key => entries.push(Entry {
                    key: key.trim().trim_matches('"'),
                    line: i + 1,
                    value: value.trim(),
                    below: Vec::new(),
                }),
                (_, Some(entry)) => entry.below.push((i + 1, line.trim())),
                (_, None) => {}
            }
        }
        Self { entries }
    }

    /// The first entry with this key, in any case.
    pub fn find(&self, key: &str) -> Option<&Entry<'a>> {
        self.entries.iter().find(|entry| entry.key.eq_ignore_ascii_case(key))
    }
}

impl Entry<'_> {
    pub fn problem(&self, message: impl Into<String>) -> PathProblem {
        PathProblem::of_cell(self.line, self.key, message)
    }

    /// A scalar.
    pub fn word(&self) -> &str {
        self.value.trim_matches(['"', '\''])
    }

    pub fn number(&self) -> Result<f64, PathProblem> {
        source::number(self.word()).map_err(|message| self.problem(message))
    }

    /// The rows and columns of a matrix, and its numbers; a list is one row.
    pub fn matrix(&self) -> Result<([usize; 2], Vec<f64>), PathProblem> {
        if self.value.starts_with('[') {
            let numbers = self.list(self.line, self.value, 0)?;
            return Ok(([1, numbers.len()], numbers));
        }
        let side = |name: &str| {
            let found = self.part(name).map(|(_, line, value)| (line, value.parse::<usize>()));
            match found {
                Some((_, Ok(count))) => Ok(count),
                Some((line, Err(_))) => Err(PathProblem::of_cell(
                    line,
                    self.key,
                    format!("`{name}` is not a whole number"),
                )),
                None => Err(self.problem(format!(
                    "expected a matrix with `rows`, `cols` and `data`, `{name}` is missing"
                ))),
            }
        };
        // One row of an array without columns.
        let of_array = match self.part("sizes") {
            Some((i, line, value)) => Some(self.list(line, value, i + 1)?),
            None => None,
        };
        let size = match of_array.as_deref() {
            None => [side("rows")?, side("cols")?],
            Some([count]) => [1, *count as usize],
            Some(_) => return Err(self.problem("expected an array of one dimension, or a matrix")),
        };
        let numbers = match self.part("data") {
            Some((i, line, value)) => self.list(line, value, i + 1)?,
            None => return Err(self.problem("expected a matrix with `rows`, `cols` and `data`, `data` is missing")),
        };
        if size[0].checked_mul(size[1]) != Some(numbers.len()) {
            let [rows, columns] = size;
            return Err(self.problem(format!("a matrix of {rows}x{columns} has {} numbers", numbers.len())));
        }
        Ok((size, numbers))
    }

    /// The index of the line below that has this key, its number and its value.
    fn part(&self, name: &str) -> Option<(usize, usize, &str)> {
        let of_line = |(i, (line, text)): (usize, &(usize, &'_ str))| {
            let (key, _) = text.split_once(':')?;
            (key.trim() == name).then_some((i, *line))
        };
        let (i, line) = self.below.iter().enumerate().find_map(of_line)?;
        let (_, value) = self.below[i].1.split_once(':')?;
        Some((i, line, value.trim()))
    }

    /// The numbers of a list that begins with `first` on this line, and goes on below from the line with index `next`.
    fn list(&self, line: usize, first: &str, next: usize) -> Result<Vec<f64>, PathProblem> {
        let mut numbers = Vec::new();
        let Some(first) = first.strip_prefix('[') else {
            return Err(PathProblem::of_cell(
                line,
                self.key,
                format!("expected a list in brackets, found '{}'", one_line(first, 80)),
            ));
        };
        let rest = self.below.iter().skip(next).copied();
        for (line, text) in std::iter::once((line, first)).chain(rest) {
            let (inside, is_end) = match text.split_once(']') {
                Some((inside, _)) => (inside, true),
                None => (text, false),
            };
            for word in inside.split(',').map(str::trim).filter(|word| !word.is_empty()) {
                let number = source::number(word);
                numbers.push(number.map_err(|message| PathProblem::of_cell(line, self.key, message))?);
            }
            if is_end {
                return Ok(numbers);
            }
        }
        Err(PathProblem::of_cell(line, self.key, "the list has no end"))
    }
}
