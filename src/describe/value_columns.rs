//! The columns of tables of values: which keys they name, how they move, and whether their values are right.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    sync::Arc,
};

use toml::de::DeTable;

use super::{
    Entity, Error, FrameTime, PartsDesc, SceneDesc,
    cell_faults::Faults,
    drawn_columns::drawn_curve,
    kind_tables::another_kind,
    moving::MovingDesc,
    names::{Component, KnownNames},
    quaternions,
    random::is_wildcard,
    value_sources::{SourceColumn, ValueSource},
    values::{Column, Curve, FileRows, Values},
};
use crate::{
    assets::{
        camera_path::{ValueCell, ValueColumn, ValueTable},
        motion::EditedParts,
    },
    camera::Timing,
    math::{
        sorting,
        track::{Interp, Track},
    },
    value::Problem,
};

/// Keys that hold for the whole job, since names and numbers in files follow from them.
const FIXED: [&str; 2] = ["name", "group"];

impl Values {
    /// The values of these sources for the scene `desc`, but for those that its overrides set for the whole job.
    ///
    /// # Errors
    /// A name is unknown, or a value is wrong; the errors name the cells.
    pub fn new(desc: &SceneDesc, given: &[ValueSource]) -> Result<Self, Error> {
        let fixed = desc.source.overrides.paths().count();
        let mut values = Self {
            files: given.iter().map(FileRows::of_source).collect(),
            columns: Vec::new(),
            fixed,
        };
        let mut faults = Faults::new(desc);
        let document = desc.document();
        let known = KnownNames::new(&document, desc.source.kind);
        let key = |(_, path): (_, &[String])| {
            let (entity, key) = resolve(desc, &document, &known, path).ok()?;
            Some((entity, key.inner, path.join(".")))
        };
        let given = &with_all_names(desc, (&document, &known), given, &mut faults);
        let set_for_the_job: Vec<(Entity, Vec<String>, String)> =
            desc.source.overrides.paths().filter_map(key).collect();
        let mut sources: Vec<(&ValueTable, &ValueColumn)> = Vec::new();
        let mut names: HashMap<(Entity, Vec<String>), &str> = HashMap::new();
        // Columns of tables come before values that are drawn, as `sources` are those of the first ones.
        let (tables, drawn): (Vec<_>, Vec<_>) = given
            .iter()
            .enumerate()
            .partition(|(_, source)| matches!(source, ValueSource::Table(_)));
        for (file, source) in tables.into_iter().chain(drawn) {
            for (name, origin, column) in source.columns() {
                let steps: Vec<String> = name.split('.').map(str::to_owned).collect();
                let resolved = resolve(desc, &document, &known, &steps);
                let Ok((entity, path)) = resolved.map_err(|problem| faults.add(origin.clone(), problem)) else {
                    if faults.are_many() {
                        return faults.check().map(|()| values);
                    }
                    continue;
                };
                if let Some(other) = names.insert((entity, path.number()), name) {
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
                    .any(|(other, inner, _)| *other == entity && path.inner.starts_with(inner))
                {
                    continue;
                }
                let part = |(other, inner, _): &&(Entity, Vec<String>, String)| {
                    *other == entity && inner.starts_with(&path.inner)
                };
                if let Some((.., part)) = set_for_the_job.iter().find(part) {
                    let problem = Problem {
                        span: None,
                        message: format!("`{part}`, a part of this value, is set for the whole job"),
                        help: Some("set the whole value, or let the other parts change one by one".to_owned()),
                    };
                    faults.add(origin, problem);
                    continue;
                }
                let curve = match column {
                    SourceColumn::Table(table, column) => {
                        sources.push((table, column));
                        curve(table, column)
                    }
                    SourceColumn::Random(random, at) => drawn_curve(desc, random, at),
                };
                values.columns.push(Column {
                    name: name.to_owned(),
                    file,
                    component: path.component,
                    path: path.inner,
                    entity,
                    curve,
                });
            }
        }
        quaternions::join(&mut values, &sources, &mut faults);
        values.add_overlaps(&mut faults);
        faults.check()?;
        let unjudged = values.clone();
        let moving = MovingDesc::new(desc, &unjudged);
        for (at, source) in sources.iter().enumerate() {
            if matches!(values.columns[at].curve, Curve::Rotation(..)) {
                continue;
            }
            if let Some(held) = held(&moving, at, *source) {
                values.columns[at].curve = held;
            }
        }
        let mut faults = Faults::new(desc);
        let moving = MovingDesc::new(desc, &values);
        for (entity, frames) in judged_frames(&values, &sources) {
            // A wrong name is wrong in every row.
            let mut told: Vec<Problem> = Vec::new();
            for time in frames.into_iter().map(FrameTime::from) {
                let problems = moving.entity_at(entity, time).err().unwrap_or_default();
                for problem in problems {
                    if told.contains(&problem) || values.is_drawn(&problem) {
                        continue;
                    }
                    told.push(problem.clone());
                    faults.add(values.origin_of(&problem, time), problem);
                }
                if faults.are_many() {
                    return faults.check().map(|()| values.clone());
                }
            }
        }
        values.judge_distributions(&moving, &mut faults);
        faults.check()?;
        Ok(values)
    }

    /// Adds a fault for each column that sets a value, or a part of one, which another column sets as well.
    fn add_overlaps(&self, faults: &mut Faults<'_>) {
        let mut order: Vec<usize> = (0..self.columns.len()).collect();
        let key = |at: &usize| (self.columns[*at].entity, &self.columns[*at].path);
        sorting::sort_by(&mut order, |a, b| key(a).cmp(&key(b)));
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
            let of_file = match own.file == other.file {
                true => String::new(),
                false => format!(" of {}", self.files[other.file].path.display()),
            };
            let what = match other.curve {
                Curve::Random(_) => "draw",
                _ => "column",
            };
            let message = format!("the {what} `{}`{of_file} sets the same value", other.name);
            faults.add(self.head(own), Problem::at(0..0, message));
        }
    }
}

/// The sources with a draw for each thing that a `*` in a name stands for, but for values that have a source of their own.
fn with_all_names(
    desc: &SceneDesc,
    (document, known): (&DeTable<'_>, &KnownNames),
    given: &[ValueSource],
    faults: &mut Faults<'_>,
) -> Vec<ValueSource> {
    let key = |name: &str| {
        let steps: Vec<String> = name.split('.').map(str::to_owned).collect();
        let (entity, path) = resolve(desc, document, known, &steps).ok()?;
        Some((entity, path.number()))
    };
    let own: HashSet<_> = given
        .iter()
        .flat_map(ValueSource::given_names)
        .filter_map(key)
        .collect();
    let mut source = |source: &ValueSource| match source {
        ValueSource::Random(random) if random.has_wildcards() => {
            let expanded = random.expanded(|draw, steps| {
                let names: Vec<String> = known.each(steps)?.iter().map(|steps| steps.join(".")).collect();
                let found: Vec<_> = names.iter().filter_map(|name| Some((name, key(name)?))).collect();
                if found.is_empty() && !names.is_empty() {
                    let message = format!("no {} of the scene has this value", steps[0]);
                    faults.add(format!("{}: {}", draw.origin, draw.name), Problem::at(0..0, message));
                }
                let found = found.into_iter().filter(|(_, key)| !own.contains(key));
                Some(found.map(|(name, _)| name.clone()).collect())
            });
            ValueSource::Random(Arc::new(expanded))
        }
        other => other.clone(),
    };
    let all = given.iter().map(&mut source).collect();
    for left_out in given.iter().flat_map(ValueSource::left_out) {
        let problem = match is_wildcard(&left_out.name) {
            true if left_out.has_draw => None,
            true => Some(Problem::at(0..0, "no draw has this name")),
            false => {
                let steps: Vec<String> = left_out.name.split('.').map(str::to_owned).collect();
                resolve(desc, document, known, &steps).err()
            }
        };
        if let Some(problem) = problem {
            faults.add(format!("{}: {}", left_out.origin, left_out.name), problem);
        }
    }
    all
}

/// The curve of a column with numbers that are whole numbers, truths or names, which hold; `None` where its numbers move or all its
/// cells are words. A cell has the same meaning whatever the others of its column are.
fn held(moving: &MovingDesc<'_>, at: usize, (table, column): (&ValueTable, &ValueColumn)) -> Option<Curve> {
    let mut numbers = column.cells.iter().filter_map(|(_, cell)| match cell {
        ValueCell::Number(v) => Some(*v),
        ValueCell::Word(_) => None,
    });
    let float = |v: f64| toml::Value::from(v).to_string();
    let has_words = column.cells.iter().any(|(_, cell)| matches!(cell, ValueCell::Word(_)));
    let first = numbers.next()?;
    if !has_words && numbers.chain([first]).any(|v| moving.takes(at, &float(v))) {
        return None;
    }
    let mut known: BTreeMap<u64, String> = BTreeMap::new();
    let mut text = |v: f64| {
        let of_number = || {
            let whole = Some((v as i64).to_string()).filter(|_| v.fract() == 0.0 && v.abs() < 1e15);
            let truth = (v == 0.0 || v == 1.0).then(|| (v == 1.0).to_string());
            // A name that looks like a number.
            let name = whole
                .as_ref()
                .map(|whole| toml::Value::from(whole.as_str()).to_string());
            let mut meanings = [whole, truth, name].into_iter().flatten();
            meanings.find(|text| moving.takes(at, text)).unwrap_or_else(|| float(v))
        };
        known.entry(v.to_bits()).or_insert_with(of_number).clone()
    };
    let steps = column.cells.iter().map(|(row, cell)| {
        let text = match cell {
            ValueCell::Number(v) => text(*v),
            ValueCell::Word(word) => word_text(word),
        };
        (table.rows[*row as usize].frame, text)
    });
    Some(Curve::Held(steps.collect()))
}

/// The value of a word, in TOML.
fn word_text(word: &str) -> String {
    let truths = ["true", "false"];
    match truths.iter().find(|truth| word.eq_ignore_ascii_case(truth)) {
        Some(truth) => (*truth).to_owned(),
        None => toml::Value::from(word).to_string(),
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
        sorting::sort_by(frames, f64::total_cmp);
        frames.dedup();
    }
    frames
}

/// The rows at which a column is judged: those of its least and its largest number, since every range of valid numbers is an
/// interval, of its first number with a fraction, and the first of each different word.
fn judged_rows(column: &ValueColumn) -> Vec<u32> {
    let numbers = || {
        column.cells.iter().filter_map(|(row, cell)| match cell {
            ValueCell::Number(v) => Some((*v, *row)),
            ValueCell::Word(_) => None,
        })
    };
    let least = numbers().min_by(|a, b| a.0.total_cmp(&b.0));
    let most = numbers().max_by(|a, b| a.0.total_cmp(&b.0));
    // Where only whole numbers are valid.
    let fraction = numbers().find(|(v, _)| v.fract() != 0.0);
    let mut words = BTreeMap::new();
    for (row, cell) in &column.cells {
        if let ValueCell::Word(word) = cell {
            words.entry(word).or_insert(*row);
        }
    }
    let numbers = least.into_iter().chain(most).chain(fraction).map(|(_, row)| row);
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

impl KeyPath {
    /// The steps, with the place of a component in place of its name: `x` and `r` are the same number.
    fn number(&self) -> Vec<String> {
        let mut steps = self.inner.clone();
        if let (Some(component), Some(last)) = (self.component, steps.last_mut()) {
            *last = component.index().to_string();
        }
        steps
    }
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
    if entity == Entity::Camera && Timing::KEYS.contains(&inner[0]) {
        let problem = Problem::at(span, format!("`{}` holds for the whole job", inner[0]));
        return Err(problem.with_help("a camera path has the columns shutter_open, shutter_close and readout"));
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
        ValueCell::Word(word) => word_text(word),
    };
    Curve::Held(
        column
            .cells
            .iter()
            .map(|(row, cell)| (frame(row), text(cell)))
            .collect(),
    )
}
