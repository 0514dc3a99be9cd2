//! Editing of camera path files: rows are changed, added and removed, and all other text is kept.
//!
//! Comments, blank lines, the order and the names of columns, the separator and the other cells stay unchanged. An edit that would
//! make the file invalid is refused and changes nothing.

use std::sync::Arc;

use glam::DVec3;

use crate::{
    assets::camera_path::{CameraPathOptions, PathProblem, PathProblems},
    camera::{
        Lens, LookAt, Pose,
        path::{CameraPath, Orientation, PathKey, Rotation},
    },
};

use super::{
    edit::EditError,
    key_cells::{KeyCells, frame_cell},
    layout::Layout,
    lines::Lines,
    rows,
    table::Table,
};

/// The header of a new file.
const HEADER: &str = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n";

/// The text of a camera path file, its keys and the path through them.
#[derive(Debug)]
pub struct PathDocument {
    options: CameraPathOptions,
    lines: Lines,
    layout: Layout,
    /// The number of the line of each key, and the key.
    keys: Vec<(usize, PathKey)>,
    /// `None` without keys.
    path: Option<Arc<CameraPath>>,
}

impl PathDocument {
    /// A file with a header and no keys, with columns for targets.
    pub fn new(options: &CameraPathOptions) -> Self {
        Self::read(HEADER.as_bytes(), options).expect("the header has the columns that are needed")
    }

    /// Parses a file. A file without rows is a document without keys.
    ///
    /// # Errors
    /// Those of reading a camera path.
    pub fn read(bytes: &[u8], options: &CameraPathOptions) -> Result<Self, PathProblems> {
        let table = Table::read(bytes)?;
        let layout = Layout::read(&table, options)?;
        let keys = match table.rows.is_empty() {
            true => Vec::new(),
            false => rows::read(&table, &layout)?,
        };
        let path = (!keys.is_empty()).then(|| CameraPath::new(&keys)).transpose();
        Ok(Self {
            options: *options,
            lines: Lines::new(bytes, table.header.line, table.separator),
            path: path.map_err(|e| PathProblem::of_file(e.to_string()))?.map(Arc::new),
            keys: table.rows.iter().map(|row| row.line).zip(keys).collect(),
            layout,
        })
    }

    /// The bytes of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.lines.to_bytes()
    }

    /// The keys, in ascending order of frames.
    pub fn keys(&self) -> impl ExactSizeIterator<Item = &PathKey> {
        self.keys.iter().map(|(_, key)| key)
    }

    /// The path through the keys; `None` without keys.
    pub fn path(&self) -> Option<&Arc<CameraPath>> {
        self.path.as_ref()
    }

    /// Adds a key, or replaces that of the same frame, whose frame or time stays as it is written. The key looks at a target; in a
    /// file with rotations it becomes a rotation.
    ///
    /// New parameters of the lens become columns, in which the other keys get the values of `scene`, the lens of the scene. An
    /// interpolation or a name that the key does not have is not changed.
    ///
    /// # Errors
    /// The key cannot be part of this path.
    pub fn set(&mut self, key: &PathKey, scene: &Lens) -> Result<(), EditError> {
        let changes = self.changes(key, scene)?;
        let mut lines = self.lines.clone();
        for column in &changes.added {
            lines.add_column(column, self.keys.iter().map(|(line, _)| *line));
        }
        match self.line_of(key.frame) {
            Some(line) => lines.change(line, &changes.cells),
            None => {
                let before = self.before(key.frame);
                let like = before.or(self.keys.first().map(|(line, _)| *line));
                lines.insert(before.unwrap_or(lines.header()), like, &changes.cells);
            }
        }
        self.replace(&lines)
    }

    /// Moves the key of a frame to another frame, which has none.
    ///
    /// # Errors
    /// There is no such key, or the other frame has one.
    pub fn move_key(&mut self, from: f64, to: f64) -> Result<(), EditError> {
        let line = self.line_of(from).ok_or(EditError::NoKey(from))?;
        if from == to {
            return Ok(());
        }
        if self.line_of(to).is_some() {
            return Err(EditError::Taken(to));
        }
        let mut lines = self.lines.clone();
        lines.change(line, &[frame_cell(&self.layout, to)]);
        // A key that stays between its neighbours stays on its line.
        if self.before(to) != Some(line) && self.before(to) != self.before(from) {
            lines.move_line(line, self.before(to).unwrap_or(lines.header()));
        }
        self.replace(&lines)
    }

    /// Removes the key of a frame.
    ///
    /// # Errors
    /// There is no such key.
    pub fn remove(&mut self, frame: f64) -> Result<(), EditError> {
        let line = self.line_of(frame).ok_or(EditError::NoKey(frame))?;
        let mut lines = self.lines.clone();
        lines.remove(line);
        self.replace(&lines)
    }

    fn replace(&mut self, lines: &Lines) -> Result<(), EditError> {
        let changed = Self::read(&lines.to_bytes(), &self.options);
        *self = changed.map_err(|problems| EditError::Invalid(problems.messages()))?;
        Ok(())
    }

    fn line_of(&self, frame: f64) -> Option<usize> {
        let found = self.keys.iter().find(|(_, key)| key.frame == frame);
        found.map(|(line, _)| *line)
    }

    /// The line of the last key before a frame.
    fn before(&self, frame: f64) -> Option<usize> {
        let next = self.keys.partition_point(|(_, key)| key.frame < frame);
        Some(self.keys[next.checked_sub(1)?].0)
    }

    /// The angles at a frame on the straight line between the keys around it; `None` where keys have no angles.
    fn angles_near(&self, frame: f64) -> Option<DVec3> {
        let next = self.keys.partition_point(|(_, key)| key.frame <= frame);
        let angles = |i: usize| match self.keys.get(i)?.1.orientation {
            Orientation::Rotation(Rotation::Euler { degrees, .. }) => Some((self.keys[i].1.frame, degrees)),
            _ => None,
        };
        match (next.checked_sub(1).and_then(angles), angles(next)) {
            (Some((t0, before)), Some((t1, after))) => Some(before.lerp(after, (frame - t0) / (t1 - t0))),
            (before, after) => before.or(after).map(|(_, degrees)| degrees),
        }
    }

    fn changes(&self, key: &PathKey, scene: &Lens) -> Result<KeyCells<'_>, EditError> {
        let Orientation::Target { target, up, roll } = key.orientation else {
            return Err(EditError::OtherWay("the orientation"));
        };
        let at = LookAt {
            target,
            up: up.unwrap_or(DVec3::Y),
            roll: roll.unwrap_or(0.0),
        };
        let pose = Pose::look_at(key.eye, &at).map_err(|e| EditError::Invalid(e.to_string()))?;
        let state = |frame: f64| {
            let path = self.path.as_ref()?;
            path.at(frame.clamp(path.first(), path.last())).ok()
        };
        let mut cells = KeyCells::new(&self.layout, self.lines.columns(), self.keys.len());
        if self.line_of(key.frame).is_none() {
            cells.frame(key.frame);
        }
        cells.eye(key.eye);
        cells.orientation(&at, &pose, self.angles_near(key.frame));
        let lens_of = |key: &PathKey| state(key.frame).map_or(*scene, |s| s.apply(scene)).parameters();
        cells.lens(&key.lens, &|| self.keys().map(lens_of).collect())?;
        cells.words(key);
        Ok(cells)
    }
}

#[cfg(test)]
mod tests;
