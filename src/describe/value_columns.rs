//! The columns of tables of values: which keys they name, how they move, and whether their values are right.

use std::collections::{BTreeMap, HashMap};

use toml::de::DeTable;

use super::{
    Entity, Error, PartsDesc, SceneDesc,
    cell_faults::Faults,
    kind_tables::another_kind,
    moving::MovingDesc,
    names::{Component, KnownNames},
    quaternions,
    values::{Column, Curve, FileRows, ValueFile, Values},
};
use crate::{
    assets::{
        camera_path::{ValueCell, ValueColumn, ValueTable},
        motion::EditedParts,
    },
    math::track::{Interp, Track},
    value::Problem,
};

/// Keys that hold for the whole job, since names and numbers in files follow from them.
const FIXED: [&str; 2] = ["name", "group"];

impl Values {
    /// The values of these files for the scene `desc`, but for those that its overrides set for the whole job.
    ///
    /// # Errors
    /// A name is unknown, or a value is wrong; the errors name the cells.
    pub fn new(desc: &SceneDesc, files: &[ValueFile]) -> Result<Self, Error> {
        let fixed = desc.source.overrides.paths().count();
        let mut values = Self {
            files: files
                .iter()
                .map(|file| FileRows {
                    path: file.path.clone(),
                    header: file.table.header,
                    rows: file.table.rows.clone(),
                })
                .collect(),
            columns: Vec::new(),
            fixed,
        };
        let mut faults = Faults::new(desc);
        let document = desc.document();
        let known = KnownNames::new(&document, desc.source.kind);
        let key = |(_, path): (_, &[String])| resolve(desc, &document, &known, path).ok();
        let set_for_the_job: Vec<(Entity, Vec<String>)> = (desc.source.overrides.paths().filter_map(key))
            .map(|(entity, path)| (entity, path.inner))
            .collect();
        let mut sources: Vec<(&ValueTable, &ValueColumn)> = Vec::new();
        let mut names: HashMap<(Entity, Vec<String>), &str> = HashMap::new();
        for (file, ValueFile { path, table }) in files.iter().enumerate() {
            for column in &table.columns {
                let origin = format!("{}:{}: {}", path.display(), table.header, column.name);
                let steps: Vec<String> = column.name.split('.').map(str::to_owned).collect();
                let resolved = resolve(desc, &document, &known, &steps);
                let Ok((entity, path)) = resolved.map_err(|problem| faults.add(origin.clone(), problem)) else {
                    continue;
                };
                if let Some(other) = names.insert((entity, path.inner.clone()), &column.name) {
                    let message = format!("`{other}` is the same value: give one of them");
                    let problem = Problem {
                        span: None,
                        message,
                        help: None,
                    };
                    faults.add(origin, problem);
                    continue;
                }
                if set_for_the_job
                    .iter()
                    .any(|(other, inner)| *other == entity && path.inner.starts_with(inner))
                {
                    continue;
                }
                values.columns.push(Column {
                    name: column.name.clone(),
                    file,
                    component: path.component,
                    path: path.inner,
                    entity,
                    curve: curve(table, column),
                });
                sources.push((table, column));
            }
        }
        quaternions::join(&mut values, &sources, &mut faults);
        values.add_overlaps(&sources, &mut faults);
        faults.check()?;
        for (at, (table, column)) in sources.iter().enumerate() {
            if let Some(held) = values.held(desc, at, table, column) {
                values.columns[at].curve = held;
            }
        }
        let mut faults = Faults::new(desc);
        let moving = MovingDesc::new(desc, &values);
        for (entity, frames) in judged_frames(&values, &sources) {
            for frame in frames {
                let problems = moving.entity(entity, &values.at(frame)).err().unwrap_or_default();
                for problem in problems {
                    faults.add(values.origin_of(&problem, frame), problem);
                }
                if faults.are_many() {
                    return faults.check().map(|()| values.clone());
                }
            }
        }
        faults.check()?;
        Ok(values)
    }

    /// Adds a fault for each column that sets a value, or a part of one, which another column sets as well.
    fn add_overlaps(&self, sources: &[(&ValueTable, &ValueColumn)], faults: &mut Faults<'_>) {
        let mut order: Vec<usize> = (0..self.columns.len()).collect();
        let key = |at: &usize| (self.columns[*at].entity, &self.columns[*at].path);
        order.sort_by(|a, b| key(a).cmp(&key(b)));
        // The column of a whole value comes right before those of its parts.
        let mut whole: Option<usize> = None;
        for at in order {
            let own = &self.columns[at];
            let other = whole.map(|whole| &self.columns[whole]);
            let overlaps = |other: &&Column| other.entity == own.entity && own.path.starts_with(&other.path);
            let Some(other) = other.filter(overlaps) else {
                whole = Some(at);
                continue;
            };
            let file = &self.files[own.file].path;
            let origin = format!("{}:{}: {}", file.display(), sources[at].0.header, own.name);
            let of_file = match own.file == other.file {
                true => String::new(),
                false => format!(" of {}", self.files[other.file].path.display()),
            };
            let message = format!("the column `{}`{of_file} sets the same value", other.name);
            faults.add(origin, Problem::at(0..0, message));
        }
    }

    /// The curve of a column of whole numbers, truths or names, which hold, if its key is one.
    fn held(&self, desc: &SceneDesc, at: usize, table: &ValueTable, column: &ValueColumn) -> Option<Curve> {
        let Curve::Number(_) = self.columns[at].curve else {
            return None;
        };
        let numbers = || {
            column.cells.iter().filter_map(|(row, cell)| match cell {
                ValueCell::Number(v) => Some((table.rows[*row as usize].frame, *v)),
                ValueCell::Word(_) => None,
            })
        };
        if numbers().any(|(_, v)| v.fract() != 0.0 || v.abs() > 1e15) {
            return None;
        }
        let least = numbers().map(|(_, v)| v).fold(f64::INFINITY, f64::min);
        let moving = MovingDesc::new(desc, self);
        let frame = numbers().next()?.0;
        let takes = |text: String| {
            let mut all = self.at(frame);
            all[at] = text;
            let problems = moving.entity(self.columns[at].entity, &all).err().unwrap_or_default();
            problems
                .iter()
                .all(|problem| problem.span.as_ref() != Some(&self.span(at)))
        };
        let whole = |v: f64| (v as i64).to_string();
        if takes(toml::Value::from(least).to_string()) {
            return None;
        }
        if takes(whole(least)) {
            let steps = numbers().map(|(frame, v)| (frame, whole(v)));
            return Some(Curve::Held(steps.collect()));
        }
        if numbers().all(|(_, v)| v == 0.0 || v == 1.0) && takes("true".to_owned()) {
            let steps = numbers().map(|(frame, v)| (frame, (v == 1.0).to_string()));
            return Some(Curve::Held(steps.collect()));
        }
        // A name that looks like a number.
        let name = |v: f64| toml::Value::from(whole(v)).to_string();
        takes(name(least)).then(|| Curve::Held(numbers().map(|(frame, v)| (frame, name(v))).collect()))
    }
}

/// The frames at which each entity is judged.
fn judged_frames(values: &Values, sources: &[(&ValueTable, &ValueColumn)]) -> BTreeMap<Entity, Vec<f64>> {
    let mut frames: BTreeMap<Entity, Vec<f64>> = BTreeMap::new();
    for (column, (table, source)) in values.columns.iter().zip(sources) {
        let judged = judged_rows(source)
            .into_iter()
            .map(|row| table.rows[row as usize].frame);
        frames.entry(column.entity).or_default().extend(judged);
    }
    for frames in frames.values_mut() {
        frames.sort_by(f64::total_cmp);
        frames.dedup();
    }
    frames
}

/// The rows at which a column is judged: those of its least and its largest number, since every range of valid numbers is an interval,
/// and the first of each different word.
fn judged_rows(column: &ValueColumn) -> Vec<u32> {
    let numbers = || {
        column.cells.iter().filter_map(|(row, cell)| match cell {
            ValueCell::Number(v) => Some((*v, *row)),
            ValueCell::Word(_) => None,
        })
    };
    let least = numbers().min_by(|a, b| a.0.total_cmp(&b.0));
    let most = numbers().max_by(|a, b| a.0.total_cmp(&b.0));
    let mut words = BTreeMap::new();
    for (row, cell) in &column.cells {
        if let ValueCell::Word(word) = cell {
            words.entry(word).or_insert(*row);
        }
    }
    let numbers = least.into_iter().chain(most).map(|(_, row)| row);
    numbers.chain(words.into_values()).collect()
}

/// The parts of the model of the first object that values by these names belong to. Names that are wrong belong to none.
pub fn edited_parts<'n>(desc: &SceneDesc, names: impl Iterator<Item = &'n str>) -> EditedParts {
    let document = desc.document();
    let known = KnownNames::new(&document, desc.source.kind);
    let mut edited = EditedParts::default();
    for name in names {
        let steps: Vec<String> = name.split('.').map(str::to_owned).collect();
        if let Ok((Entity::Object(0), path)) = resolve(desc, &document, &known, &steps) {
            PartsDesc::add_to(&mut edited, &path.inner);
        }
    }
    edited
}

/// A key in an entity.
struct KeyPath {
    inner: Vec<String>,
    component: Option<Component>,
}

/// Finds the key that the path `steps` names.
fn resolve(
    desc: &SceneDesc,
    document: &DeTable<'_>,
    known: &KnownNames,
    steps: &[String],
) -> Result<(Entity, KeyPath), Problem> {
    let span = 0..0;
    let path = known.resolve(steps, &span)?;
    if let Some(problem) = another_kind(document, &path, &span, desc.source.shown_text()) {
        return Err(problem);
    }
    let component = Component::of_path(&path);
    let words: Vec<&str> = path.iter().map(AsRef::as_ref).collect();
    let (entity, inner) = Entity::of_path(desc, &words).map_err(|message| Problem::at(span.clone(), message))?;
    if inner.is_empty() {
        return Err(Problem::at(span, "this is a table of values: name one of them"));
    }
    if let Some(fixed) = FIXED.iter().find(|fixed| inner == [**fixed]) {
        return Err(Problem::at(span, format!("`{fixed}` holds for the whole job")));
    }
    if entity == Entity::Camera && inner[0] == "shutter" {
        let problem = Problem::at(span, "`shutter` holds for the whole job");
        return Err(problem.with_help("a camera path has the columns shutter_open and shutter_close"));
    }
    let inner = inner.iter().map(|step| (*step).to_owned()).collect();
    Ok((entity, KeyPath { inner, component }))
}

/// The curve of a column: numbers move if all cells are numbers.
fn curve(table: &ValueTable, column: &ValueColumn) -> Curve {
    let frame = |row: &u32| table.rows[*row as usize].frame;
    let is_number = |(_, cell): &(u32, ValueCell)| matches!(cell, ValueCell::Number(_));
    if column.cells.iter().all(is_number) {
        let keys = column.cells.iter().map(|(row, cell)| {
            let own: Interp = table.rows[*row as usize].interp;
            let number = match cell {
                ValueCell::Number(v) => Some(*v),
                ValueCell::Word(_) => None,
            };
            (frame(row), number, column.interp.unwrap_or(own))
        });
        return Curve::Number(Track::new(keys));
    }
    let text = |cell: &ValueCell| match cell {
        ValueCell::Number(v) => toml::Value::from(*v).to_string(),
        ValueCell::Word(word) if word.eq_ignore_ascii_case("true") => "true".to_owned(),
        ValueCell::Word(word) if word.eq_ignore_ascii_case("false") => "false".to_owned(),
        ValueCell::Word(word) => toml::Value::from(&**word).to_string(),
    };
    Curve::Held(
        column
            .cells
            .iter()
            .map(|(row, cell)| (frame(row), text(cell)))
            .collect(),
    )
}
