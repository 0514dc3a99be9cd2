//! Parsing of a file into a header and rows of cells, with line numbers.

use csv::{ReaderBuilder, StringRecord};

use crate::assets::camera_path::PathProblem;

/// A file's cells.
#[derive(Debug)]
pub(super) struct Table {
    pub header: Row,
    pub rows: Vec<Row>,
    pub separator: u8,
    /// The text of comments, without their `#`.
    pub comments: Vec<(usize, String)>,
}

/// One line's cells, without the spaces around them.
#[derive(Debug, Default)]
pub(super) struct Row {
    /// From 1.
    pub line: usize,
    pub cells: StringRecord,
}

impl Table {
    pub fn read(bytes: &[u8]) -> Result<Self, PathProblem> {
        let text = decode(bytes)?.replace("\r\n", "\n").replace('\r', "\n");
        let mut comments = Vec::new();
        // The reader's own line numbers are wrong after blank lines.
        let mut lines = Vec::new();
        let mut body = String::with_capacity(text.len());
        let mut separator = None;
        for (line, content) in (1..).zip(text.split('\n')) {
            if let Some(comment) = content.trim_start().strip_prefix('#') {
                comments.push((line, comment.trim().to_owned()));
            } else if let (true, Some(said)) = (lines.is_empty(), separator_line(content)) {
                separator = Some(said);
            } else if let Some(control) = content.chars().find(|c| c.is_control() && *c != '\t') {
                let message = format!(
                    "the control character U+{:04X} is no text: remove it",
                    u32::from(control)
                );
                return Err(PathProblem::of_line(line, message));
            } else if !content.trim().is_empty() {
                lines.push(line);
                body.push_str(content);
                body.push('\n');
            }
        }
        let header = body.lines().next().unwrap_or_default();
        let separator = separator.unwrap_or_else(|| delimiter(header));
        if !header.as_bytes().contains(&separator) && header.split_whitespace().nth(1).is_some() {
            let message = "the cells are separated by blanks: separate them by commas";
            return Err(PathProblem::of_line(lines[0], message));
        }
        let mut rows = cells(&body, &lines, separator)?;
        let Some(first) = rows.first() else {
            return Err(PathProblem::of_file("the file is empty: expected a header and rows"));
        };
        let header = match commented_header(&comments, first, separator) {
            Some(header) => header,
            None => rows.remove(0),
        };
        Ok(Self {
            header: header.with_unnamed_columns(),
            rows,
            separator,
            comments,
        })
    }
}

impl Row {
    /// Whether all cells that are not empty are numbers.
    pub fn is_of_numbers(&self) -> bool {
        let mut filled = self.cells.iter().filter(|cell| !cell.is_empty());
        filled.all(|cell| cell.parse::<f64>().is_ok())
    }

    /// The header in which the names that pandas gives to columns without a name, such as `Unnamed: 0`, are empty.
    fn with_unnamed_columns(mut self) -> Self {
        let name = |cell| if str::starts_with(cell, "Unnamed: ") { "" } else { cell };
        self.cells = self.cells.iter().map(name).collect();
        self
    }
}

/// Returns the header that a comment above `first` holds, as `numpy.savetxt` writes it: `first` has numbers,
/// and the comment a name for each.
fn commented_header(comments: &[(usize, String)], first: &Row, separator: u8) -> Option<Row> {
    if !first.is_of_numbers() {
        return None;
    }
    let above = comments.iter().rev().filter(|(line, _)| *line < first.line);
    let mut headers = above.filter_map(|(line, text)| cells(text, &[*line], separator).ok()?.pop());
    headers
        .find(|row| row.cells.len() == first.cells.len() && row.cells.iter().all(|cell| cell.parse::<f64>().is_err()))
}

fn decode(bytes: &[u8]) -> Result<&str, PathProblem> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(PathProblem::of_file("the file is UTF-16: save it as UTF-8"));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    str::from_utf8(bytes).map_err(|e| {
        let line = 1 + bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count();
        PathProblem::of_line(line, "the text is not UTF-8")
    })
}

/// Returns the delimiter of a header: the candidate that occurs most often.
fn delimiter(header: &str) -> u8 {
    let count = |delimiter: u8| header.bytes().filter(|b| *b == delimiter).count();
    let mut best = b',';
    for other in [b';', b'\t'] {
        if count(other) > count(best) {
            best = other;
        }
    }
    best
}

/// Returns the separator that a line such as `sep=;` before the header names, as Excel writes it.
fn separator_line(line: &str) -> Option<u8> {
    let line = line.trim_end_matches(' ').trim_matches('"');
    let (key, separator) = line.split_at_checked(4)?;
    match separator.as_bytes() {
        [separator @ (b',' | b';' | b'\t')] if key.eq_ignore_ascii_case("sep=") => Some(*separator),
        _ => None,
    }
}

/// The rows of `body`, without those whose cells are all empty: spreadsheets write them.
fn cells(body: &str, lines: &[usize], separator: u8) -> Result<Vec<Row>, PathProblem> {
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(separator)
        .from_reader(body.as_bytes());
    let mut rows = Vec::with_capacity(lines.len());
    for (record, line) in reader.records().zip(lines) {
        let mut cells = record.map_err(|e| PathProblem::of_line(*line, e.to_string()))?;
        // After a line end within a cell, lines and records would no longer correspond.
        if cells.iter().any(|cell| cell.contains('\n')) {
            return Err(PathProblem::of_line(
                *line,
                "a quoted cell does not end on its line: is a quote missing?",
            ));
        }
        cells.trim();
        if cells.iter().any(|cell| !cell.is_empty()) {
            rows.push(Row { line: *line, cells });
        }
    }
    Ok(rows)
}
