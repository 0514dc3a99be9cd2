//! Conversion of cells to keys.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};

use crate::{
    assets::camera_path::{PathProblem, PathProblems},
    camera::{
        LensOverrides, Shutter,
        intrinsics::{COLUMNS, IntrinsicsOverrides},
        lens::{Aperture, FieldOfView, Sensor},
        path::{Interp, MAX_FRAME, Orientation, PathKey, Rotation},
        shutter::MAX_READOUT,
    },
    value::{UnknownName, one_line, one_of},
};

use super::{
    layout::{ApertureKind, Clock, Layout, OrientationColumns, SensorKind, ViewKind},
    table::{Row, Table},
};

/// The largest difference of a quaternion's length from 1.
const UNIT_TOLERANCE: f64 = 1e-3;

/// The most characters of a cell that a message shows.
const MOST_SHOWN: usize = 80;

/// The rounding of times that are given in milliseconds, in seconds.
const TIME_TOLERANCE: f64 = 0.5e-3;

/// The largest effect of rounding a time, in frames.
const FRAME_TOLERANCE: f64 = 0.05;

const INTERPS: &[(&str, Interp)] = &[
    ("smooth", Interp::Smooth),
    ("linear", Interp::Linear),
    ("hold", Interp::Step),
    ("spline", Interp::Smooth),
    ("catmull-rom", Interp::Smooth),
    ("step", Interp::Step),
    ("stepped", Interp::Step),
    ("constant", Interp::Step),
    ("cut", Interp::Step),
];

/// The keys of a table's rows.
pub(super) fn read(table: &Table, layout: &Layout) -> Result<Vec<PathKey>, PathProblems> {
    let mut problems = PathProblems::default();
    if table.rows.is_empty() {
        problems.push(PathProblem::of_file("there are no rows below the header"));
    }
    let mut keys = Vec::with_capacity(table.rows.len());
    let mut order = FrameOrder::default();
    for row in &table.rows {
        let mut cells = Cells::new(&table.header, row, &mut problems);
        if !cells.fit() {
            continue;
        }
        let frame = cells.frame(layout.clock);
        if let Some(frame) = frame {
            order.check(frame, &mut cells, layout.clock);
        }
        keys.extend(cells.key(layout, frame));
    }
    if problems.is_empty() { Ok(keys) } else { Err(problems) }
}

/// The frames so far, with their lines.
#[derive(Default)]
pub(super) struct FrameOrder {
    /// The lines of frames, by the bits of the frame.
    lines: BTreeMap<u64, usize>,
    previous: Option<(f64, usize)>,
}

impl FrameOrder {
    pub fn check(&mut self, frame: f64, cells: &mut Cells<'_>, clock: Clock) {
        let line = cells.row.line;
        let (Clock::Frame(column) | Clock::Time { column, .. }) = clock;
        // 0 and -0 are one frame.
        let first = *self.lines.entry((frame + 0.0).to_bits()).or_insert(line);
        match self.previous {
            _ if first != line => {
                cells.problem(column, format!("frame {frame} is on line {first} already"));
            }
            Some((before, above)) if frame < before => {
                let message = format!("frame {frame} comes after frame {before} of line {above}: frames must rise");
                cells.problem(column, message);
            }
            _ => {}
        }
        self.previous = Some((frame, line));
    }
}

/// The cells of one row. A cell that is wrong becomes a problem and is `None`.
pub(super) struct Cells<'a> {
    header: &'a Row,
    row: &'a Row,
    problems: &'a mut PathProblems,
}

impl<'a> Cells<'a> {
    pub fn new(header: &'a Row, row: &'a Row, problems: &'a mut PathProblems) -> Self {
        Self { header, row, problems }
    }

    fn problem(&mut self, column: usize, message: impl Into<String>) {
        let name = &self.header.cells[column];
        self.problems.push(PathProblem::of_cell(self.row.line, name, message));
    }

    /// Whether every cell has a column and every column a cell. Empty cells beyond the last column are allowed, because
    /// spreadsheets write them, and columns without a name before the first, because pandas writes its index there.
    pub fn fit(&mut self) -> bool {
        let names = &self.header.cells;
        let named = (1..=names.len()).rev().find(|n| !names[n - 1].is_empty()).unwrap_or(0);
        let index = names.iter().take_while(|name| name.is_empty()).count();
        let have = self.row.cells.len();
        let nameless = |i: usize| names.get(i).is_none_or(str::is_empty);
        let stray = (index..have).find(|i| nameless(*i) && !self.row.cells[*i].is_empty());
        let message = match stray {
            _ if have < named => format!("the row has {have} cells, the header {named}"),
            Some(i) => format!("cell {} ('{}') has no name in the header", i + 1, &self.row.cells[i]),
            None => return true,
        };
        self.problems.push(PathProblem::of_line(self.row.line, message));
        false
    }

    pub fn text(&self, column: Option<usize>) -> Option<(usize, &'a str)> {
        let column = column?;
        let cell = self.row.cells.get(column).unwrap_or_default();
        (!cell.is_empty()).then_some((column, cell))
    }

    /// The number in a cell; `None` if the cell is empty or invalid.
    pub fn number(&mut self, column: usize) -> Option<f64> {
        let (_, cell) = self.text(Some(column))?;
        let number = cell.parse::<f64>();
        let cell = one_line(cell, MOST_SHOWN);
        let wrong = match number {
            Ok(v) if !v.is_finite() => format!("'{cell}' is not finite"),
            Ok(v) if v.abs() > f64::from(f32::MAX) => format!("'{cell}' is too large"),
            Ok(v) => return Some(v),
            Err(_) if cell.replacen(',', ".", 1).parse::<f64>().is_ok() => {
                format!(
                    "'{cell}' is not a number: write {}, with a point",
                    cell.replacen(',', ".", 1)
                )
            }
            Err(_) => format!("'{cell}' is not a number"),
        };
        self.problem(column, wrong);
        None
    }

    /// The number in a cell that must not be empty.
    fn needed(&mut self, column: usize) -> Option<f64> {
        if self.text(Some(column)).is_none() {
            self.problem(column, "the cell is empty");
            return None;
        }
        self.number(column)
    }

    /// The numbers of cells that must not be empty; all of them are checked.
    fn all<const N: usize>(&mut self, columns: [usize; N]) -> Option<[f64; N]> {
        let numbers = columns.map(|column| self.needed(column));
        let complete = numbers.iter().all(Option::is_some);
        complete.then(|| numbers.map(Option::unwrap_or_default))
    }

    /// The number in an optional cell, which must satisfy a condition.
    fn checked(&mut self, column: Option<usize>, holds: impl Fn(f64) -> bool, what: &str) -> Option<f64> {
        let column = column?;
        let v = self.number(column)?;
        if holds(v) {
            return Some(v);
        }
        self.problem(column, format!("{v} is not {what}"));
        None
    }

    fn above_0(&mut self, column: usize) -> Option<f64> {
        self.checked(Some(column), |v| v > 0.0, "above 0")
    }

    pub fn frame(&mut self, clock: Clock) -> Option<f64> {
        let (column, frame) = match clock {
            Clock::Frame(column) => {
                let frame = self.needed(column)?;
                if frame.fract() != 0.0 {
                    self.problem(column, format!("{frame} is not a whole number"));
                    return None;
                }
                (column, frame)
            }
            Clock::Time { column, fps } => {
                let frame = self.needed(column)? * fps;
                let near = (frame - frame.round()).abs() <= FRAME_TOLERANCE.min(TIME_TOLERANCE * fps);
                (column, if near { frame.round() } else { frame })
            }
        };
        if frame.abs() <= MAX_FRAME as f64 {
            return Some(frame);
        }
        self.problem(
            column,
            format!("frame {frame} is out of range: frames lie between -{MAX_FRAME} and {MAX_FRAME}"),
        );
        None
    }

    fn key(&mut self, layout: &Layout, frame: Option<f64>) -> Option<PathKey> {
        let eye = self.all(layout.eye).map(DVec3::from_array);
        let orientation = self.orientation(layout.orientation, eye);
        let lens = self.lens(layout);
        let shutter = self.shutter(layout.shutter_open, layout.shutter_close);
        let readout = layout.readout.and_then(|column| self.readout(column));
        let stereo = layout.stereo.map(|column| self.above_0(column?));
        let interp = self.interp(layout.interp);
        let name = self.text(layout.name).map(|(_, name)| name.to_owned());
        Some(PathKey {
            frame: frame?,
            eye: eye?,
            orientation: orientation?,
            lens,
            pinhole: None,
            shutter,
            readout,
            stereo,
            interp,
            name,
        })
    }

    fn orientation(&mut self, columns: OrientationColumns, eye: Option<DVec3>) -> Option<Orientation> {
        match columns {
            OrientationColumns::Target { target, up, roll } => {
                let first = target[0];
                let target = self.all(target).map(DVec3::from_array);
                // If all cells of the up vector are empty, the row has none.
                let up = up.filter(|up| up.iter().any(|c| self.text(Some(*c)).is_some()));
                let up = up.and_then(|up| self.all(up)).map(DVec3::from_array);
                let roll = roll.and_then(|c| self.number(c));
                if eye.is_some() && eye == target {
                    self.problem(first, "the target is at the eye");
                }
                let target = target?;
                Some(Orientation::Target { target, up, roll })
            }
            OrientationColumns::Quaternion(columns) => {
                let [x, y, z, w] = self.all(columns)?;
                let q = DQuat::from_xyzw(x, y, z, w);
                let length = q.length();
                if (length - 1.0).abs() > UNIT_TOLERANCE {
                    let message = format!("the quaternion has length {length:.6}, expected 1 within {UNIT_TOLERANCE}");
                    self.problem(columns[0], message);
                    return None;
                }
                Some(Orientation::Rotation(Rotation::Quaternion(q)))
            }
            OrientationColumns::Euler { degrees, order } => {
                let degrees = DVec3::from_array(self.all(degrees)?);
                Some(Orientation::Rotation(Rotation::Euler { degrees, order }))
            }
        }
    }

    fn lens(&mut self, layout: &Layout) -> LensOverrides {
        let angle = "above 0 and below 180 degrees";
        let is_angle = |v: f64| v > 0.0 && v < 180.0;
        LensOverrides {
            view: layout.view.and_then(|(kind, column)| match kind {
                ViewKind::Vertical => self.checked(Some(column), is_angle, angle).map(FieldOfView::Vertical),
                ViewKind::Horizontal => self.checked(Some(column), is_angle, angle).map(FieldOfView::Horizontal),
                ViewKind::FocalLength => self.above_0(column).map(FieldOfView::FocalLength),
            }),
            sensor: layout.sensor.and_then(|(kind, column)| match kind {
                SensorKind::Width => self.above_0(column).map(Sensor::Width),
                SensorKind::Height => self.above_0(column).map(Sensor::Height),
            }),
            aperture: layout.aperture.and_then(|(kind, column)| match kind {
                ApertureKind::FStop => self.above_0(column).map(Aperture::FStop),
                ApertureKind::Radius => self
                    .checked(Some(column), |v| v >= 0.0, "at least 0")
                    .map(Aperture::Radius),
            }),
            focus_distance: layout.focus_distance.and_then(|column| self.above_0(column)),
            shift_x: layout.shift[0].and_then(|column| self.number(column)),
            shift_y: layout.shift[1].and_then(|column| self.number(column)),
            intrinsics: IntrinsicsOverrides(std::array::from_fn(|i| {
                let column = &COLUMNS[i];
                self.checked(layout.intrinsics[i], |v| column.takes(v), column.expected())
            })),
        }
    }

    fn shutter(&mut self, open_column: Option<usize>, close_column: Option<usize>) -> Option<Shutter> {
        let open = open_column.and_then(|c| self.number(c));
        let Some((column, _)) = self.text(close_column) else {
            if let (Some(column), Some(_)) = (open_column, open) {
                self.problem(column, "there is no shutter_close to go with it");
            }
            return None;
        };
        let (open, close) = (open.unwrap_or(0.0), self.number(column)?);
        if close < open {
            self.problem(column, format!("{close} is before the shutter opens, at {open}"));
            return None;
        }
        Some(Shutter { open, close })
    }

    fn readout(&mut self, column: usize) -> Option<f64> {
        let time = self.number(column)?;
        if !(0.0..=MAX_READOUT).contains(&time) {
            self.problem(
                column,
                format!("a readout takes from 0 to {MAX_READOUT} frames, not {time}"),
            );
            return None;
        }
        Some(time)
    }

    pub fn interp(&mut self, column: Option<usize>) -> Interp {
        let Some((column, word)) = self.text(column) else {
            return Interp::default();
        };
        interp_of(word).unwrap_or_else(|message| {
            self.problem(column, message);
            Interp::default()
        })
    }
}

/// The interpolation by its name, or what is wrong with it.
pub(super) fn interp_of(word: &str) -> Result<Interp, String> {
    let found = INTERPS.iter().find(|(name, _)| name.eq_ignore_ascii_case(word));
    found.map(|(_, interp)| *interp).ok_or_else(|| {
        let unknown = UnknownName::new("interpolation", word, INTERPS.iter().map(|(name, _)| *name));
        let known = one_of(["smooth", "linear", "hold"]);
        unknown.with_fallback(Some(format!("expected {known}"))).to_string()
    })
}
