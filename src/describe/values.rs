//! Values of a scene file that change over time, by the names of their keys.
//!
//! A column of a [`ValueTable`] sets the key that its name is the path of. Numbers move along a [`Track`]; words, truths and whole
//! numbers hold. At a time the values are put into the tables of the file that have them, before these are read, as
//! [`Overrides`] are. So the parser of the file checks them, and errors name their cells.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::RangeInclusive,
    path::{Path, PathBuf},
    sync::Arc,
};

use glam::DQuat;

use super::{Diagnostics, Entity, Overrides, Part, PartsDesc, SceneDesc, names::Component, parts::part_of};
use crate::{
    assets::{
        camera_path::{ValueRow, ValueTable},
        motion::EditedParts,
    },
    math::track::Track,
    value::{OVERRIDES, Problem, Span},
};

/// A table of values and its file.
#[derive(Clone, Debug)]
pub struct ValueFile {
    pub path: PathBuf,
    pub table: ValueTable,
}

/// A file that a cell names.
#[derive(Clone, Debug)]
pub struct CellFile {
    pub path: PathBuf,
    /// The cell.
    pub origin: String,
}

/// The rows of a file.
#[derive(Clone, Debug)]
pub(super) struct FileRows {
    pub path: PathBuf,
    /// The line of the header.
    pub header: usize,
    pub rows: Vec<ValueRow>,
}

/// The values that change over time.
#[derive(Clone, Debug)]
pub struct Values {
    pub(super) files: Vec<FileRows>,
    pub(super) columns: Vec<Column>,
    /// The number of the overrides that hold at all times.
    pub(super) fixed: usize,
}

/// A value over time.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub name: String,
    /// The index of its file.
    pub file: usize,
    pub entity: Entity,
    /// The steps from the entity to the key.
    pub path: Vec<String>,
    pub component: Option<Component>,
    pub curve: Curve,
}

/// The curve of a value over time.
#[derive(Clone, Debug)]
pub(super) enum Curve {
    Number(Track<f64>),
    /// A component of a quaternion, whose columns share a track.
    Rotation(Arc<Track<DQuat>>, usize),
    /// Values in TOML that hold, by the frames from which on they do.
    Held(Vec<(f64, String)>),
}

impl Curve {
    /// The value at a time, in TOML.
    pub(super) fn at(&self, frame: f64) -> String {
        match self {
            Self::Number(track) => toml::Value::from(track.at(frame).unwrap_or_default()).to_string(),
            Self::Rotation(track, component) => {
                let rotation = track.at(frame).unwrap_or_default().to_array();
                toml::Value::from(rotation[*component]).to_string()
            }
            Self::Held(steps) => {
                let next = steps.partition_point(|(from, _)| *from <= frame);
                steps[next.saturating_sub(1)].1.clone()
            }
        }
    }
}

impl Values {
    /// The first and the last row, in whole frames.
    pub fn frames(&self) -> RangeInclusive<i64> {
        let rows = || {
            self.files
                .iter()
                .flat_map(|file| file.rows.first().into_iter().chain(file.rows.last()))
        };
        let first = rows().map(|row| row.frame).fold(f64::INFINITY, f64::min);
        let last = rows().map(|row| row.frame).fold(f64::NEG_INFINITY, f64::max);
        first.ceil() as i64..=last.floor() as i64
    }

    /// All values at a time in frames, in TOML.
    pub fn at(&self, frame: f64) -> Vec<String> {
        self.columns.iter().map(|column| column.curve.at(frame)).collect()
    }

    /// The names and the values at a time in frames.
    pub fn named_at(&self, frame: f64) -> impl Iterator<Item = (&str, String)> {
        self.columns
            .iter()
            .map(move |column| (column.name.as_str(), column.curve.at(frame)))
    }

    /// The keys of the values, each by the steps from its entity.
    pub fn keys(&self) -> impl Iterator<Item = (Entity, &[String])> {
        self.columns
            .iter()
            .map(|column| (column.entity, column.path.as_slice()))
    }

    /// The names of the values of the camera, each with the file that has it.
    pub fn of_camera(&self) -> impl Iterator<Item = (&str, &PathBuf)> {
        let of_camera = self.columns.iter().filter(|column| column.entity == Entity::Camera);
        of_camera.map(|column| (column.name.as_str(), &self.files[column.file].path))
    }

    /// The files of the tables.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|file| file.path.as_path())
    }

    /// The files that cells name, each once.
    pub fn files_in_cells(&self, desc: &SceneDesc) -> Vec<CellFile> {
        let mut files: BTreeMap<PathBuf, String> = BTreeMap::new();
        for column in self
            .columns
            .iter()
            .filter(|column| column.path.last().is_some_and(|step| step == "file"))
        {
            let Curve::Held(steps) = &column.curve else { continue };
            for (frame, text) in steps {
                let value: Option<toml::Value> = text.parse().ok();
                if let Some(name) = value.as_ref().and_then(toml::Value::as_str) {
                    let origin = || self.cell(column, *frame);
                    files.entry(desc.folder().join(name)).or_insert_with(origin);
                }
            }
        }
        files
            .into_iter()
            .map(|(path, origin)| CellFile { path, origin })
            .collect()
    }

    /// The columns that hold words, but for names of files: the entity, the index of the column, and the time in frames of the first
    /// cell with each word.
    pub fn words(&self) -> Vec<(Entity, usize, f64)> {
        let mut words = Vec::new();
        for (at, column) in self.columns.iter().enumerate() {
            let Curve::Held(steps) = &column.curve else { continue };
            if column.path.last().is_some_and(|step| step == "file") {
                continue;
            }
            let mut known = BTreeSet::new();
            let is_word = |text: &str| text.starts_with(['"', '\'']);
            let new = steps.iter().filter(|(_, text)| is_word(text) && known.insert(text));
            words.extend(new.map(|(frame, _)| (column.entity, at, *frame)));
        }
        words
    }

    /// The objects whose transforms have values.
    pub fn moved_objects(&self) -> BTreeSet<usize> {
        let moved = self
            .columns
            .iter()
            .filter(|column| column.path.first().is_some_and(|step| step == "transform"));
        moved.filter_map(|column| column.entity.object()).collect()
    }

    /// The nodes and materials of models that have values, by the indices of their objects.
    pub fn edited_parts(&self) -> BTreeMap<usize, EditedParts> {
        let mut edited: BTreeMap<usize, EditedParts> = BTreeMap::new();
        for column in &self.columns {
            if let (Some(object), Some(_)) = (column.entity.object(), part_of(&column.path)) {
                PartsDesc::add_to(edited.entry(object).or_default(), &column.path);
            }
        }
        edited
    }

    /// Checks the names of nodes and materials of models by `problem`, which finds that of a part of an object.
    ///
    /// # Errors
    /// Names are unknown.
    pub fn check_parts(
        &self,
        desc: &SceneDesc,
        problem: impl Fn(usize, Part, &str, Span) -> Option<Problem>,
    ) -> Result<(), Diagnostics> {
        let mut overrides = desc.source.overrides.clone();
        let mut problems = Vec::new();
        for (at, column) in self.columns.iter().enumerate() {
            let FileRows { path, header, .. } = &self.files[column.file];
            overrides.set_cell(&format!("{}:{header}: {}", path.display(), column.name), &column.name);
            if let (Some(object), Some((part, name))) = (column.entity.object(), part_of(&column.path)) {
                problems.extend(problem(object, part, name, self.span(at)));
            }
        }
        Diagnostics::new(&desc.source.clone().with(overrides), problems).map_or(Ok(()), Err)
    }

    /// Whether objects may move or deform.
    pub fn moves_objects(&self) -> bool {
        let looks = ["material", "visible"];
        self.keys().any(|(entity, path)| {
            entity.object().is_some() && !path.first().is_some_and(|step| looks.contains(&step.as_str()))
        })
    }

    /// Whether the visibility of the background has values.
    pub fn hides_background(&self) -> bool {
        let hides = |column: &Column| column.entity == Entity::Background && column.path == ["visible"];
        self.columns.iter().any(hides)
    }

    /// The overrides of `desc` with the origins of all values at a time in frames, to which the spans of values lead.
    pub(super) fn overrides_at(&self, desc: &SceneDesc, frame: f64) -> Overrides {
        let mut overrides = desc.source.overrides.clone();
        for column in &self.columns {
            overrides.set_cell(&self.cell(column, frame), &column.name);
        }
        overrides
    }

    /// The span of the values of a column.
    pub(super) fn span(&self, column: usize) -> Span {
        let start = OVERRIDES + self.fixed + column;
        start..start + 1
    }

    /// The origin of a problem at a time: the cell, or the frame where the problem is in the scene file.
    pub(super) fn origin_of(&self, problem: &Problem, frame: f64) -> String {
        let column = problem
            .span
            .as_ref()
            .and_then(|span| span.start.checked_sub(OVERRIDES + self.fixed));
        match column.and_then(|column| self.columns.get(column)) {
            Some(column) => self.cell(column, frame),
            None => format!("{}: frame {frame}", self.files[0].path.display()),
        }
    }

    /// The place of the value of a column at a time: its last cell up to then.
    fn cell(&self, column: &Column, frame: f64) -> String {
        let FileRows { path, rows, .. } = &self.files[column.file];
        let next = rows.partition_point(|row| row.frame <= frame).saturating_sub(1);
        let line = rows.get(next).map_or(1, |row| row.line);
        format!("{}:{line}: {}", path.display(), column.name)
    }
}

#[cfg(test)]
mod tests;
