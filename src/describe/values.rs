//! Values of a scene file that change over time or are drawn for each frame, by the names of their keys.
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

use super::{
    Diagnostics, Distribution, DrawKey, Entity, FrameTime, Overrides, Part, PartsDesc, SceneDesc, names::Component,
    parts::part_of,
};
use crate::{
    assets::{
        camera_path::{ValueRow, ValueTable},
        motion::EditedParts,
    },
    math::{sorting, track::Track},
    value::{OVERRIDES, Problem, Span},
};

/// The number of frames whose draws tell where a scene moves.
const SAMPLED_DRAWS: i64 = 64;

/// A table of values and its file.
#[derive(Clone, Debug)]
pub struct ValueFile {
    pub path: PathBuf,
    pub table: ValueTable,
}

/// The rows of a file.
#[derive(Clone, Debug)]
pub(super) struct FileRows {
    pub path: PathBuf,
    /// The line of the header.
    pub header: usize,
    /// None for values that are drawn.
    pub rows: Vec<ValueRow>,
    /// Whether only what it says of a frame counts for that, and no other part of its content.
    pub is_apart: bool,
}

/// The text of a word, which is in TOML.
fn plain(word: &str) -> Option<String> {
    match word.parse() {
        Ok(toml::Value::String(text)) => Some(text),
        _ => None,
    }
}

/// The steps at which keys end that name a file.
const FILES: [&str; 2] = ["file", "ies"];

/// A word in a column.
#[derive(Clone, Debug)]
pub struct Word {
    pub entity: Entity,
    /// The index of its column.
    pub column: usize,
    /// The time of the first cell that has it.
    pub time: FrameTime,
    /// In TOML.
    pub text: String,
    /// The place of its cell, or of its distribution.
    pub origin: String,
    /// The file that it names, if its column is one of files.
    pub file: Option<PathBuf>,
    /// Whether it is about the shape of an object: then other files may belong to its model.
    pub is_of_shape: bool,
    /// Whether it is drawn, and other values of the same entity are drawn as well.
    pub is_drawn_beside_others: bool,
}

/// The values that change from frame to frame.
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
    Random(RandomCurve),
}

/// A value that is drawn for each frame.
#[derive(Clone, Debug)]
pub(super) struct RandomCurve {
    pub key: DrawKey,
    pub distribution: Arc<Distribution>,
    /// The place of the distribution.
    pub origin: String,
}

impl Curve {
    /// The value at a time, in TOML.
    pub(super) fn at(&self, at: FrameTime) -> String {
        match self {
            Self::Number(track) => toml::Value::from(track.at(at.time).unwrap_or_default()).to_string(),
            Self::Rotation(track, component) => {
                let rotation = track.at(at.time).unwrap_or_default().to_array();
                toml::Value::from(rotation[*component]).to_string()
            }
            Self::Held(steps) => {
                let next = steps.partition_point(|(from, _)| *from <= at.time);
                steps[next.saturating_sub(1)].1.clone()
            }
            Self::Random(random) => random.distribution.draw(random.key, at.frame),
        }
    }

    /// The words that it holds, in TOML, each with the time of its cell; a word that is drawn has that of frame 1.
    pub(super) fn words(&self) -> impl Iterator<Item = (&str, FrameTime)> {
        let (held, distribution) = match self {
            Self::Held(steps) => (&steps[..], None),
            Self::Random(random) => (&[][..], Some(&random.distribution)),
            Self::Number(_) | Self::Rotation(..) => (&[][..], None),
        };
        let is_word = |text: &str| text.starts_with(['"', '\'']);
        let held = held.iter().map(|(time, text)| (text.as_str(), FrameTime::from(*time)));
        let drawn = distribution.into_iter().flat_map(|own| own.words());
        let held = held.filter(move |(text, _)| is_word(text));
        held.chain(drawn.map(|text| (text, FrameTime::from(1.0))))
    }
}

impl Values {
    /// The first and the last row, in whole frames; `None` where all values are drawn.
    pub fn frames(&self) -> Option<RangeInclusive<i64>> {
        let rows = || {
            self.files
                .iter()
                .flat_map(|file| file.rows.first().into_iter().chain(file.rows.last()))
        };
        rows().next()?;
        let first = rows().map(|row| row.frame).fold(f64::INFINITY, f64::min);
        let last = rows().map(|row| row.frame).fold(f64::NEG_INFINITY, f64::max);
        Some(first.ceil() as i64..=last.floor() as i64)
    }

    /// The frames among which those are that tell where a scene moves: of values that are drawn the first ones.
    pub fn sampled_frames(&self) -> RangeInclusive<i64> {
        self.frames().unwrap_or(1..=SAMPLED_DRAWS)
    }

    /// All values at a time, in TOML.
    pub fn at(&self, time: impl Into<FrameTime>) -> Vec<String> {
        let time = time.into();
        self.columns.iter().map(|column| column.curve.at(time)).collect()
    }

    /// The names and the values at a time.
    pub fn named_at(&self, time: impl Into<FrameTime>) -> impl Iterator<Item = (&str, String)> {
        let time = time.into();
        self.columns
            .iter()
            .map(move |column| (column.name.as_str(), column.curve.at(time)))
    }

    /// The names of the values that are drawn, and the draws of a frame, in TOML.
    pub fn drawn_at(&self, frame: i64) -> impl Iterator<Item = (&str, String)> {
        self.columns.iter().filter_map(move |column| match &column.curve {
            Curve::Random(random) => Some((column.name.as_str(), random.distribution.draw(random.key, frame))),
            _ => None,
        })
    }

    /// Whether the value of this name is drawn.
    pub fn draws(&self, name: &str) -> bool {
        let own = self.columns.iter().find(|column| column.name == name);
        own.is_some_and(|column| matches!(column.curve, Curve::Random(_)))
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

    /// The files that have values alone.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        let apart = self.files.iter().filter(|file| file.is_apart);
        apart.map(|file| file.path.as_path())
    }

    /// The words of columns, each once. Files are relative to the folder of `desc`.
    pub fn words(&self, desc: &SceneDesc) -> Vec<Word> {
        let mut words = Vec::new();
        for (at, column) in self.columns.iter().enumerate() {
            let names_files = column.path.last().is_some_and(|step| FILES.contains(&step.as_str()));
            let file = |text: &str| Some(desc.folder().join(plain(text).filter(|_| names_files)?));
            let is_drawn = |column: &Column| matches!(column.curve, Curve::Random(_));
            let is_other =
                |other: &Column| other.entity == column.entity && other.path != column.path && is_drawn(other);
            let is_of_shape = column.path.first().is_some_and(|step| step == "shape");
            let is_drawn_beside_others =
                (names_files || is_of_shape) && is_drawn(column) && self.columns.iter().any(is_other);
            let mut known = BTreeSet::new();
            let new = column.curve.words().filter(|(text, _)| known.insert(*text));
            words.extend(new.map(|(text, time)| Word {
                entity: column.entity,
                column: at,
                time,
                text: text.to_owned(),
                origin: self.origin_of_word(column, time),
                file: file(text),
                is_of_shape,
                is_drawn_beside_others,
            }));
        }
        words
    }

    /// The names of the models that columns have.
    pub fn model_files(&self) -> impl Iterator<Item = String> {
        let files = self
            .columns
            .iter()
            .filter(|column| column.path == ["shape", "mesh", "file"]);
        files.flat_map(|column| column.curve.words().filter_map(|(text, _)| plain(text)))
    }

    /// The objects whose meshes have values of this key.
    pub fn objects_with(&self, key: &str) -> BTreeSet<usize> {
        let of_key = self.keys().filter(|(_, path)| *path == ["shape", "mesh", key]);
        of_key.filter_map(|(entity, _)| entity.object()).collect()
    }

    /// The objects whose transforms have values.
    pub fn moved_objects(&self) -> BTreeSet<usize> {
        let moved = self
            .columns
            .iter()
            .filter(|column| column.path.first().is_some_and(|step| step == "transform"));
        sorting::ordered(moved.filter_map(|column| column.entity.object()))
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
            overrides.set_cell(&self.head(column), &column.name);
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

    /// Whether objects show other models from frame to frame, or other materials of these.
    pub fn changes_models(&self) -> bool {
        let mut of_objects = self.keys().filter(|(entity, _)| entity.object().is_some());
        of_objects.any(|(_, path)| path.last().is_some_and(|key| key == "file" || key == "variant"))
    }

    /// Whether the visibility of the background has values.
    pub fn hides_background(&self) -> bool {
        let hides = |column: &Column| column.entity == Entity::Background && column.path == ["visible"];
        self.columns.iter().any(hides)
    }

    /// The overrides of `desc` with the origins of all values at a time, to which the spans of values lead.
    pub(super) fn overrides_at(&self, desc: &SceneDesc, time: FrameTime) -> Overrides {
        let mut overrides = desc.source.overrides.clone();
        for column in &self.columns {
            overrides.set_cell(&self.cell(column, time), &column.name);
        }
        overrides
    }

    /// The same for words, one of which a draw may not be.
    pub(super) fn overrides_of_words(&self, desc: &SceneDesc, time: FrameTime) -> Overrides {
        let mut overrides = desc.source.overrides.clone();
        for column in &self.columns {
            overrides.set_cell(&self.origin_of_word(column, time), &column.name);
        }
        overrides
    }

    fn origin_of_word(&self, column: &Column, time: FrameTime) -> String {
        match column.curve {
            Curve::Random(_) => self.head(column),
            _ => self.cell(column, time),
        }
    }

    /// The span of the values of a column.
    pub(super) fn span(&self, column: usize) -> Span {
        let start = OVERRIDES + self.fixed + column;
        start..start + 1
    }

    /// The column whose value has a problem, if it is one of these.
    pub(super) fn column_of(&self, problem: &Problem) -> Option<usize> {
        let start = problem.span.as_ref()?.start;
        start
            .checked_sub(OVERRIDES + self.fixed)
            .filter(|at| *at < self.columns.len())
    }

    /// The origin of a problem at a time: the cell, or the frame where the problem is in the scene file.
    pub(super) fn origin_of(&self, problem: &Problem, time: FrameTime) -> String {
        match self.column_of(problem) {
            Some(column) => self.cell(&self.columns[column], time),
            None => format!("{}: frame {}", self.files[0].path.display(), time.time),
        }
    }

    /// The place of a column: its header, or its distribution.
    pub(super) fn head(&self, column: &Column) -> String {
        let FileRows { path, header, .. } = &self.files[column.file];
        match &column.curve {
            Curve::Random(random) => format!("{}: {}", random.origin, column.name),
            _ => format!("{}:{header}: {}", path.display(), column.name),
        }
    }

    /// The place of the value of a column at a time: its last cell up to then.
    fn cell(&self, column: &Column, time: FrameTime) -> String {
        if let Curve::Random(random) = &column.curve {
            let drawn = random.distribution.draw(random.key, time.frame);
            return format!("{}, where frame {} draws {drawn}", self.head(column), time.frame);
        }
        let FileRows { path, rows, .. } = &self.files[column.file];
        let next = rows.partition_point(|row| row.frame <= time.time).saturating_sub(1);
        let line = rows.get(next).map_or(1, |row| row.line);
        format!("{}:{line}: {}", path.display(), column.name)
    }
}

#[cfg(test)]
mod tests;
