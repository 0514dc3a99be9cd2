//! The lines of a file, and edits of single cells.

use super::edit::{AddedColumn, CellChange, number};

/// The lines of a file. Numbers of lines count from 1.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    has_mark: bool,
    lines: Vec<String>,
    end: &'static str,
    header: usize,
    separator: char,
}

const MARK: &[u8] = b"\xef\xbb\xbf";

impl Lines {
    /// The lines of a file that was read: its text is UTF-8.
    pub fn new(bytes: &[u8], header: usize, separator: u8) -> Self {
        let text = String::from_utf8_lossy(bytes.strip_prefix(MARK).unwrap_or(bytes));
        let end = if text.contains("\r\n") { "\r\n" } else { "\n" };
        let text = text.replace("\r\n", "\n").replace('\r', "\n");
        let mut lines: Vec<String> = text.split('\n').map(str::to_owned).collect();
        // A final line end does not start another line.
        if lines.last().is_some_and(String::is_empty) {
            lines.pop();
        }
        Self {
            has_mark: bytes.starts_with(MARK),
            lines,
            end,
            header,
            separator: char::from(separator),
        }
    }

    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = if self.has_mark { MARK.to_vec() } else { Vec::new() };
        for line in &self.lines {
            bytes.extend_from_slice(line.as_bytes());
            bytes.extend_from_slice(self.end.as_bytes());
        }
        bytes
    }

    /// The line of the header.
    pub fn header(&self) -> usize {
        self.header
    }

    /// The number of columns of the header.
    pub fn columns(&self) -> usize {
        self.cells(self.header).len()
    }

    /// Adds a column at the end. `rows` are the lines of the keys.
    pub fn add_column(&mut self, column: &AddedColumn, rows: impl Iterator<Item = usize>) {
        let columns = self.columns();
        let is_spaced = self.cells(self.header).last().is_some_and(|cell| cell.starts_with(' '));
        let space = if is_spaced { " " } else { "" };
        self.lines[self.header - 1] += &format!("{}{space}{}", self.separator, column.name);
        for (line, value) in rows.zip(&column.others) {
            let mut cells = self.cells(line);
            // Cells beyond those of the header are empty.
            cells.resize(columns, String::new());
            cells.push(value.map_or_else(String::new, |v| format!("{space}{}", number(v))));
            self.set_cells(line, &cells);
        }
    }

    /// Changes cells of a line and leaves the others.
    pub fn change(&mut self, line: usize, changes: &[CellChange]) {
        let mut cells = self.cells(line);
        cells.resize(cells.len().max(self.columns()), String::new());
        self.apply(&mut cells, changes);
        self.set_cells(line, &cells);
    }

    /// Inserts a row after the line `after`, with the spaces of the row `like`.
    pub fn insert(&mut self, after: usize, like: Option<usize>, changes: &[CellChange]) {
        let blank = |cell: String| match cell.starts_with(' ') {
            true => " ".repeat(cell.chars().count()),
            false => String::new(),
        };
        let cells = like.map(|like| self.cells(like).into_iter().map(blank));
        let mut cells: Vec<String> = cells.into_iter().flatten().collect();
        cells.resize(self.columns(), String::new());
        self.apply(&mut cells, changes);
        self.lines.insert(after, self.joined(&cells));
    }

    pub fn remove(&mut self, line: usize) {
        self.lines.remove(line - 1);
    }

    /// Moves a line to the place after another one.
    pub fn move_line(&mut self, line: usize, after: usize) {
        let row = self.lines.remove(line - 1);
        let after = if line <= after { after - 1 } else { after };
        self.lines.insert(after, row);
    }

    fn apply(&self, cells: &mut [String], changes: &[CellChange]) {
        for change in changes {
            let cell = &mut cells[change.column];
            let width = if cell.starts_with(' ') { cell.chars().count() } else { 0 };
            let text = self.quoted(&change.text);
            if text.starts_with('"') {
                // Quotes count at the beginning of a cell only.
                *cell = text;
                continue;
            }
            // A number as wide as its cell keeps one leading space.
            let space = if width > 0 && text.chars().count() >= width {
                " "
            } else {
                ""
            };
            *cell = format!("{space}{text:>width$}");
        }
    }

    fn quoted(&self, text: &str) -> String {
        if text.contains([self.separator, '"']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    }

    /// The cells of a line, including spaces and quotes.
    fn cells(&self, line: usize) -> Vec<String> {
        let (mut cells, mut cell, mut in_quotes) = (Vec::new(), String::new(), false);
        for c in self.lines[line - 1].chars() {
            if c == self.separator && !in_quotes {
                cells.push(std::mem::take(&mut cell));
                continue;
            }
            // Quotes only count at the start of a cell.
            if c == '"' && (cell.is_empty() || cell.starts_with('"')) {
                in_quotes = !in_quotes;
            }
            cell.push(c);
        }
        cells.push(cell);
        cells
    }

    fn set_cells(&mut self, line: usize, cells: &[String]) {
        self.lines[line - 1] = self.joined(cells);
    }

    fn joined(&self, cells: &[String]) -> String {
        cells.join(self.separator.encode_utf8(&mut [0; 4]))
    }
}
