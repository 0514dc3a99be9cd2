//! Tables of values: columns that set values of a scene file, in a file of their own or beside those of a camera path.
//!
//! A column has the name of a value, such as `light.key.point.intensity`. The file has a column `frame`, or `time` with a frame
//! rate, and a row for every frame or keyframe; `interp` holds from its row to the next, as in a camera path. A comment
//! `# interp: NAME = linear` is the interpolation of one column, whatever the rows say. Empty cells say nothing.

use std::collections::HashMap;

use crate::{
    assets::camera_path::{CameraPathOptions, PathProblem, PathProblems},
    camera::path::Interp,
    value::UnknownName,
};

use super::{
    columns::{Columns, canonical, is_of_time, is_value_name},
    layout::clock,
    rows::{Cells, FrameOrder, interp_of},
    table::Table,
};

/// The most cells of a table.
const MAX_CELLS: usize = 20_000_000;

/// The content of a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueCell {
    Number(f64),
    Word(Box<str>),
}

/// A row of a table.
#[derive(Clone, Copy, Debug)]
pub struct ValueRow {
    /// The time, in frames.
    pub frame: f64,
    /// The line in the file, from 1.
    pub line: usize,
    /// The interpolation up to the next row.
    pub interp: Interp,
}

/// A column of a table.
#[derive(Clone, Debug)]
pub struct ValueColumn {
    /// The name of the value.
    pub name: String,
    /// The cells that are not empty, by their rows.
    pub cells: Vec<(u32, ValueCell)>,
    /// The interpolation of this column, in place of that of the rows.
    pub interp: Option<Interp>,
}

/// The values in a file.
#[derive(Clone, Debug)]
pub struct ValueTable {
    /// The line of the header, from 1.
    pub header: usize,
    /// In rising order of frames.
    pub rows: Vec<ValueRow>,
    pub columns: Vec<ValueColumn>,
}

/// The columns of a file that are values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueColumns {
    /// All but those of time and interpolation.
    All,
    /// Those whose names begin with a table of a scene file; the others are a camera path.
    BesideCamera,
}

impl ValueTable {
    /// Reads the values in the bytes of a CSV file. A table without columns of values has no rows.
    ///
    /// # Errors
    /// Up to 20 problems, each with its line and column.
    pub fn read(bytes: &[u8], which: ValueColumns, options: &CameraPathOptions) -> Result<Self, PathProblems> {
        let table = Table::read(bytes)?;
        let mut problems = PathProblems::default();
        let header = &table.header;
        let is_value = |word: &str| match which {
            ValueColumns::BesideCamera => is_value_name(word),
            ValueColumns::All => !word.is_empty() && !canonical(word).is_some_and(|name| is_of_time(&name)),
        };
        let indices: Vec<usize> = (0..header.cells.len())
            .filter(|i| is_value(&header.cells[*i]))
            .collect();
        let mut first: HashMap<&str, usize> = HashMap::new();
        for &i in &indices {
            let name = &header.cells[i];
            if let Some(other) = first.insert(name, i) {
                let message = format!("{name} is given twice: in columns {} and {}", other + 1, i + 1);
                problems.push(PathProblem::of_line(header.line, message));
            }
        }
        if indices.is_empty() {
            if which == ValueColumns::All {
                let message = "there is no column of a value, such as light.key.point.intensity";
                problems.push(PathProblem::of_line(header.line, message));
            }
            return Self::checked(problems, header.line, Vec::new(), Vec::new());
        }
        if indices.len().saturating_mul(table.rows.len()) > MAX_CELLS {
            let message = format!("the table has more than {MAX_CELLS} cells: split it, and render it in parts");
            return Err(PathProblem::of_file(message).into());
        }
        if table.rows.is_empty() {
            problems.push(PathProblem::of_file("there are no rows below the header"));
        }
        let names = Columns::of_time(header);
        let clock = clock(header, &names, options.fps, &mut problems);
        let mut columns: Vec<ValueColumn> = indices
            .iter()
            .map(|&i| ValueColumn {
                name: header.cells[i].to_owned(),
                cells: Vec::new(),
                interp: None,
            })
            .collect();
        set_interps(&table, &mut columns, &mut problems);
        let Some(clock) = clock else {
            return Self::checked(problems, header.line, Vec::new(), columns);
        };
        let mut rows: Vec<ValueRow> = Vec::with_capacity(table.rows.len());
        let mut order = FrameOrder::default();
        for row in &table.rows {
            let mut cells = Cells::new(header, row, &mut problems);
            if !cells.fit() {
                continue;
            }
            let Some(frame) = cells.frame(clock) else { continue };
            order.check(frame, &mut cells, clock);
            let interp = cells.interp(names.get("interp"));
            for (&i, column) in indices.iter().zip(&mut columns) {
                column
                    .cells
                    .extend(cells.value(i).map(|cell| (rows.len() as u32, cell)));
            }
            rows.push(ValueRow {
                frame,
                line: row.line,
                interp,
            });
        }
        columns.retain(|column| !column.cells.is_empty());
        Self::checked(problems, header.line, rows, columns)
    }

    fn checked(
        problems: PathProblems,
        header: usize,
        rows: Vec<ValueRow>,
        columns: Vec<ValueColumn>,
    ) -> Result<Self, PathProblems> {
        match problems.is_empty() {
            true => Ok(Self { header, rows, columns }),
            false => Err(problems),
        }
    }
}

impl Cells<'_> {
    /// The value in a cell; `None` if the cell is empty or no finite number.
    fn value(&mut self, column: usize) -> Option<ValueCell> {
        let (_, cell) = self.text(Some(column))?;
        match cell.parse::<f64>() {
            Ok(_) => self.number(column).map(ValueCell::Number),
            Err(_) => Some(ValueCell::Word(cell.into())),
        }
    }
}

/// Sets the interpolations that comments such as `# interp: NAME = linear` say.
fn set_interps(table: &Table, columns: &mut [ValueColumn], problems: &mut PathProblems) {
    for (line, comment) in &table.comments {
        let said = comment
            .split_once(':')
            .filter(|(key, _)| key.trim().eq_ignore_ascii_case("interp"));
        let Some((_, said)) = said else { continue };
        let Some((name, word)) = said.split_once('=') else {
            let message = "expected a line such as '# interp: light.key.point.intensity = linear'";
            problems.push(PathProblem::of_line(*line, message));
            continue;
        };
        let (name, word) = (name.trim(), word.trim());
        match interp_of(word) {
            Err(message) => problems.push(PathProblem::of_line(*line, message)),
            Ok(interp) => match columns.iter_mut().find(|column| column.name == name) {
                Some(column) => column.interp = Some(interp),
                None => {
                    let known = columns.iter().map(|column| column.name.as_str());
                    let unknown = UnknownName::new("column", name, known);
                    problems.push(PathProblem::of_line(*line, unknown.to_string()));
                }
            },
        }
    }
}
