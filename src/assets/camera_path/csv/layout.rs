//! The layout of a file: its columns, and the alternatives that they select.

use crate::{
    assets::camera_path::{CameraPathOptions, PathProblem, PathProblems},
    camera::{RotationOrder, intrinsics},
};

use super::{
    columns::Columns,
    table::{Row, Table},
};

/// The indices of columns.
#[derive(Debug)]
pub(super) struct Layout {
    pub clock: Clock,
    pub eye: [usize; 3],
    pub orientation: OrientationColumns,
    pub view: Option<(ViewKind, usize)>,
    pub sensor: Option<(SensorKind, usize)>,
    pub aperture: Option<(ApertureKind, usize)>,
    pub focus_distance: Option<usize>,
    pub shift: [Option<usize>; 2],
    /// In the order of [`intrinsics::COLUMNS`].
    pub intrinsics: [Option<usize>; intrinsics::COLUMNS.len()],
    pub shutter_open: Option<usize>,
    pub shutter_close: Option<usize>,
    pub readout: Option<usize>,
    /// The distance between the eyes, and that of convergence.
    pub stereo: [Option<usize>; 2],
    pub interp: Option<usize>,
    pub name: Option<usize>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Clock {
    Frame(usize),
    Time { column: usize, fps: f64 },
}

#[derive(Clone, Copy, Debug)]
pub(super) enum OrientationColumns {
    Target {
        target: [usize; 3],
        up: Option<[usize; 3]>,
        roll: Option<usize>,
    },
    Quaternion([usize; 4]),
    Euler {
        degrees: [usize; 3],
        order: RotationOrder,
    },
}

#[derive(Clone, Copy, Debug)]
pub(super) enum ViewKind {
    Vertical,
    Horizontal,
    FocalLength,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum SensorKind {
    Width,
    Height,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum ApertureKind {
    Radius,
    FStop,
}

impl Layout {
    pub fn read(table: &Table, options: &CameraPathOptions) -> Result<Self, PathProblems> {
        let mut problems = PathProblems::default();
        if table.header.is_of_numbers() {
            let message = "expected a header with the names of columns, found numbers";
            return Err(PathProblem::of_line(table.header.line, message).into());
        }
        let columns = Columns::read(&table.header, &mut problems);
        let mut finder = Finder {
            header: &table.header,
            columns: &columns,
            problems: &mut problems,
        };
        let clock = finder.clock(options.fps);
        let eye = finder.needed(["eye_x", "eye_y", "eye_z"]);
        let orientation = finder.orientation(table, options);
        let view = finder.one_of([
            ("fov", ViewKind::Vertical),
            ("fov_x", ViewKind::Horizontal),
            ("focal_length", ViewKind::FocalLength),
        ]);
        let sensor = finder.one_of([
            ("sensor_width", SensorKind::Width),
            ("sensor_height", SensorKind::Height),
        ]);
        let aperture = finder.one_of([
            ("fstop", ApertureKind::FStop),
            ("aperture_radius", ApertureKind::Radius),
        ]);
        // A width alone scales nothing.
        finder.group(["width", "height"]);
        let get = |name| columns.get(name);
        match (clock, eye, orientation) {
            (Some(clock), Some(eye), Some(orientation)) if problems.is_empty() => Ok(Self {
                clock,
                eye,
                orientation,
                view,
                sensor,
                aperture,
                focus_distance: get("focus_distance"),
                shift: [get("shift_x"), get("shift_y")],
                intrinsics: intrinsics::COLUMNS.each_ref().map(|column| get(column.name)),
                shutter_open: get("shutter_open"),
                shutter_close: get("shutter_close"),
                readout: get("readout"),
                stereo: [get("ipd"), get("convergence")],
                interp: get("interp"),
                name: get("name"),
            }),
            _ => Err(problems),
        }
    }
}

/// The column that tells the time of rows; `None` leaves a problem.
pub(super) fn clock(header: &Row, columns: &Columns, fps: Option<f64>, problems: &mut PathProblems) -> Option<Clock> {
    let mut finder = Finder {
        header,
        columns,
        problems,
    };
    finder.clock(fps)
}

/// Finds columns and reports contradictions.
struct Finder<'a> {
    header: &'a Row,
    columns: &'a Columns,
    problems: &'a mut PathProblems,
}

const TARGET: [&str; 3] = ["target_x", "target_y", "target_z"];
const QUATERNION: [&str; 4] = ["qx", "qy", "qz", "qw"];
const EULER: [&str; 3] = ["rot_x", "rot_y", "rot_z"];
const UP: [&str; 3] = ["up_x", "up_y", "up_z"];

impl Finder<'_> {
    fn problem(&mut self, message: impl Into<String>) {
        self.problems.push(PathProblem::of_line(self.header.line, message));
    }

    fn needed<const N: usize>(&mut self, names: [&str; N]) -> Option<[usize; N]> {
        self.columns.needed(self.header.line, names, self.problems)
    }

    fn group<const N: usize>(&mut self, names: [&str; N]) -> Option<[usize; N]> {
        self.columns.group(self.header.line, names, self.problems)
    }

    /// The name in the file of the first of these columns that exists.
    fn any_of(&self, names: &[&str]) -> Option<String> {
        let index = names.iter().find_map(|name| self.columns.get(name))?;
        Some(self.header.cells[index].to_owned())
    }

    fn is_meant(&self, names: &[&str]) -> bool {
        names.iter().any(|name| self.columns.is_meant(name))
    }

    fn one_of<T: Copy, const N: usize>(&mut self, alternatives: [(&str, T); N]) -> Option<(T, usize)> {
        let mut chosen: Option<(T, usize)> = None;
        for (name, kind) in alternatives {
            match (chosen, self.columns.get(name)) {
                (None, Some(index)) => chosen = Some((kind, index)),
                (Some((_, first)), Some(index)) => {
                    let (first, second) = (&self.header.cells[first], &self.header.cells[index]);
                    self.problem(format!(
                        "'{first}' and '{second}' say the same thing in two ways: keep one"
                    ));
                }
                (_, None) => {}
            }
        }
        chosen
    }

    fn clock(&mut self, fps: Option<f64>) -> Option<Clock> {
        if let Some(column) = self.columns.get("frame") {
            return Some(Clock::Frame(column));
        }
        let Some(column) = self.columns.get("time") else {
            if !self.is_meant(&["frame", "time"]) {
                let has_index = self.header.cells.get(0) == Some("");
                let hint = if has_index { ": column 1 has no name" } else { "" };
                self.problem(format!("missing column: frame, or time and a frame rate{hint}"));
            }
            return None;
        };
        match fps {
            Some(fps) if fps > 0.0 && fps.is_finite() => Some(Clock::Time { column, fps }),
            Some(fps) => {
                self.problem(format!("the frame rate {fps} is not a number above 0"));
                None
            }
            None => {
                self.problem("there is a time and no frame: say how many frames a second has, with --fps");
                None
            }
        }
    }

    fn orientation(&mut self, table: &Table, options: &CameraPathOptions) -> Option<OrientationColumns> {
        let ways: [&[&str]; 3] = [&TARGET, &QUATERNION, &EULER];
        let used: Vec<_> = ways.iter().filter_map(|names| self.any_of(names)).collect();
        match &used[..] {
            [] if ways.iter().any(|names| self.is_meant(names)) => return None,
            [] => {
                self.problem(
                    "nothing says which way the camera looks: \
                     expected target_x target_y target_z, qx qy qz qw, or rot_x rot_y rot_z",
                );
                return None;
            }
            [_] => {}
            [first, second, ..] => {
                let message = format!("'{first}' and '{second}' say in two ways which way the camera looks: keep one");
                self.problem(message);
                return None;
            }
        }
        let target = self.group(TARGET);
        let up = self.group(UP);
        let roll = self.columns.get("roll");
        if self.any_of(&TARGET).is_none()
            && let Some(idle) = self.any_of(&["up_x", "up_y", "up_z", "roll"])
        {
            self.problem(format!(
                "'{idle}' needs target_x target_y target_z: a rotation says it all"
            ));
        }
        let quaternion = self.group(QUATERNION).map(OrientationColumns::Quaternion);
        let euler = match self.group(EULER) {
            Some(degrees) => self
                .rotation_order(table, options)
                .map(|order| OrientationColumns::Euler { degrees, order }),
            None => None,
        };
        let target = target.map(|target| OrientationColumns::Target { target, up, roll });
        target.or(quaternion).or(euler)
    }

    fn rotation_order(&mut self, table: &Table, options: &CameraPathOptions) -> Option<RotationOrder> {
        if options.rotation_order.is_some() {
            return options.rotation_order;
        }
        let mut said: Option<(usize, RotationOrder)> = None;
        for (line, comment) in &table.comments {
            let Some(word) = order_in_comment(comment) else {
                continue;
            };
            match (word.parse::<RotationOrder>(), said) {
                (Err(e), _) => {
                    self.problems.push(PathProblem::of_line(*line, e.to_string()));
                    return None;
                }
                (Ok(order), Some((first, other))) if order != other => {
                    let message = format!("rotation order {order} after {other} on line {first}");
                    self.problems.push(PathProblem::of_line(*line, message));
                    return None;
                }
                (Ok(order), _) => said = Some((*line, order)),
            }
        }
        if said.is_none() {
            self.problem(
                "rot_x rot_y rot_z need a rotation order: \
                 write a line such as '# rotation_order: ZXY', or give it with --rotation-order",
            );
        }
        said.map(|(_, order)| order)
    }
}

/// The word after `rotation_order:` or a variant of it.
fn order_in_comment(comment: &str) -> Option<&str> {
    let (key, word) = comment.split_once([':', '='])?;
    let key: String = key.chars().filter(char::is_ascii_alphabetic).collect();
    let known = ["rotationorder", "rotorder", "rotateorder", "eulerorder"];
    known.contains(&key.to_ascii_lowercase().as_str()).then(|| word.trim())
}
