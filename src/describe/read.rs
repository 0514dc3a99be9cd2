//! Parsing of TOML into a [`SceneDesc`]. Each entity is parsed by itself, so that all errors are found.

use std::{collections::HashSet, io, path::Path};

use serde::Deserialize;
use toml::de::{DeTable, DeValue};

use super::{
    Diagnostics, LIGHT_GROUP, OutputDesc, Overrides, RenderDesc, SceneDesc, Source,
    deserialize::FileValue,
    foreign,
    kind_tables::{self, KindTable, RANDOM, VALUES},
    random::RandomDesc,
    scene::*,
};
use crate::{
    camera::{CameraDesc, Shutter, Timing, shutter::MAX_READOUT},
    light::LightDesc,
    material::MaterialDesc,
    texture::{MappingDesc, PatternDesc, StTransformDesc},
    value::{List, Problem, Span, Spanned, UnknownName, kind_or_name, one_of},
};

/// Why a scene file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("cannot read scene: {cause}: {path}")]
    Read { path: String, cause: io::Error },
    #[error("the scene file is not UTF-8 text: {path}")]
    Encoding { path: String },
    #[error("cannot read the distributions: {cause}: {path}")]
    ReadRandom { path: String, cause: io::Error },
    #[error("{0}")]
    Invalid(Diagnostics),
}

/// Reads the scene file at `path`, whose bytes come from `read`, with these overrides.
pub fn load<'p, B: AsRef<[u8]>>(
    path: &'p Path,
    overrides: &Overrides,
    read: impl FnOnce(&'p Path) -> io::Result<B>,
) -> Result<SceneDesc, Error> {
    let shown = || path.display().to_string();
    let bytes = read(path).map_err(|cause| Error::Read { path: shown(), cause })?;
    let text = str::from_utf8(bytes.as_ref()).map_err(|_| Error::Encoding { path: shown() })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    parse(Source::new(path.to_owned(), text).with(overrides.clone())).map_err(Error::Invalid)
}

/// The tables of a scene file.
const TABLES: [&str; 9] = [
    "render",
    "camera",
    "background",
    "texture",
    "material",
    "object",
    "light",
    RANDOM,
    "output",
];

/// Reads a scene from text; paths in it are relative to the folder of `source.path`.
pub fn parse(source: Source) -> Result<SceneDesc, Diagnostics> {
    let Source { text, overrides, .. } = source.clone();
    let mut reader = Reader::new(&overrides, &text);
    let scene = match DeTable::parse(&text) {
        Ok(table) => {
            let mut table = table.into_inner();
            if let Some(foreign) = foreign_file(&table) {
                reader.problems.push(foreign);
                None
            } else {
                reader.problems = overrides.apply(&mut table, (source.kind, source.shown_text()));
                Some(reader.scene(table, source.clone()))
            }
        }
        Err(e) => {
            reader.problems.push(syntax_problem(&e, &text));
            None
        }
    };
    match (Diagnostics::new(&source, reader.problems), scene) {
        (None, Some(scene)) => Ok(scene),
        (Some(diagnostics), _) => Err(diagnostics),
        (None, None) => unreachable!("a file that cannot be parsed has a problem"),
    }
}

/// The problem of a file that has keys, and none that a scene file has or that resembles one.
fn foreign_file(table: &DeTable<'_>) -> Option<Problem> {
    let is_foreign = |key: &str| {
        !TABLES.contains(&key) && key != VALUES && UnknownName::new("key", key, TABLES).suggestion().is_none()
    };
    let first = table.keys().min_by_key(|key| key.span().start)?;
    if !table.keys().all(|key| is_foreign(key.get_ref())) {
        return None;
    }
    let help = format!("expected a table, {}", one_of(TABLES));
    Some(Problem::at(first.span(), "this file is no scene of batch-render").with_help(help))
}

impl SceneDesc {
    /// The table of the scene file with its overrides, which is valid.
    pub(super) fn document(&self) -> DeTable<'_> {
        let parsed = DeTable::parse(&self.source.text);
        let mut table = parsed.expect("the scene was read from it").into_inner();
        let shown = (self.source.kind, self.source.shown_text());
        self.source.overrides.apply(&mut table, shown);
        table
    }

    /// The same scene whose `[render]` and `[output]` have these overrides instead.
    ///
    /// # Errors
    /// An override is wrong.
    pub fn with(&self, overrides: &Overrides) -> Result<Self, Error> {
        if self.source.overrides == *overrides {
            return Ok(self.clone());
        }
        let source = self.source.clone().with(overrides.clone());
        let again = parse(source).map_err(Error::Invalid)?;
        Ok(Self {
            source: again.source,
            render: again.render,
            output: again.output,
            ..self.clone()
        })
    }
}

type Value<'i> = Spanned<DeValue<'i>>;

/// Reads the tables of a scene file, and collects what is wrong with them.
pub(super) struct Reader<'o> {
    pub problems: Vec<Problem>,
    /// Whether nodes of models may have a scale of 0, at times at which values flatten them.
    pub may_flatten: bool,
    overrides: &'o Overrides,
    text: &'o str,
}

impl<'o> Reader<'o> {
    /// A reader of the scene file `text` with these overrides.
    pub fn new(overrides: &'o Overrides, text: &'o str) -> Self {
        Self {
            problems: Vec::new(),
            may_flatten: false,
            overrides,
            text,
        }
    }
}

impl Reader<'_> {
    fn scene(&mut self, mut table: DeTable<'_>, source: Source) -> SceneDesc {
        for (key, _) in table.iter() {
            if !TABLES.contains(&key.get_ref().as_ref()) && key.get_ref() != VALUES {
                let unknown = UnknownName::new("key", key.get_ref(), TABLES);
                self.problems.push(unknown.at(key.span()));
            }
        }
        for name in ["render", "camera", "background", RANDOM, "output"] {
            if let Some((key, DeValue::Array(_))) = table.get_key_value(name).map(|(k, v)| (k, v.get_ref())) {
                self.misplaced(key.span(), "array", name);
                table.remove(name);
            }
        }
        let mut take = |name: &str| table.remove(name);
        let render = take("render").filter(|v| {
            let tables = [&kind_tables::INTEGRATOR, &kind_tables::SAMPLER, &kind_tables::FILTER];
            self.have_one_kind(v, &tables)
        });
        let render: RenderDesc = render.and_then(|v| self.entity(v)).unwrap_or_default();
        render.check(&mut self.problems);
        let values = take(VALUES).and_then(|v| self.entity(v));
        let random = take(RANDOM).and_then(|v| self.random(v, &source));
        let mut camera = take("camera");
        let timing = Timing::KEYS
            .iter()
            .filter_map(|key| Some((*key, take_key(camera.as_mut()?, key)?)));
        let timing: Vec<_> = timing.collect();
        // The camera of a path or of a model has no kind here.
        let is_alone =
            |v: &Value<'_>| !timing.is_empty() && matches!(v.get_ref(), DeValue::Table(table) if table.is_empty());
        let camera = camera.filter(|v| !is_alone(v)).and_then(|v| self.camera(v));
        let timing = self.timing(timing);
        let background = take("background").and_then(|v| self.entity(v)).unwrap_or_default();
        let output: OutputDesc = take("output").and_then(|v| self.entity(v)).unwrap_or_default();
        output.check(&mut self.problems);
        let textures = self.named(take("texture"), "texture", |r, name, v| r.texture(name, v));
        let materials = self.named(take("material"), "material", |r, name, v| r.material(name, v));
        let objects: Vec<ObjectDesc> = self.list(take("object"), "object", |r, v| r.object(v));
        let lights = self.list(take("light"), "light", |r, v| r.light(v));
        self.unique_names("object", objects.iter().map(|object| &object.name));
        self.unique_names("light", lights.iter().map(|light| &light.name));
        SceneDesc {
            source,
            values,
            random,
            render,
            camera,
            timing,
            background,
            textures,
            materials,
            objects,
            lights,
            output,
        }
    }

    /// Parses the table of values that are drawn.
    fn random(&mut self, value: Value<'_>, source: &Source) -> Option<RandomDesc> {
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(table) => Some(RandomDesc::read(table, source, &mut self.problems)),
            other => {
                self.misplaced(span, other.type_str(), RANDOM);
                None
            }
        }
    }

    /// Parses the table of a camera.
    pub fn camera(&mut self, mut value: Value<'_>) -> Option<Spanned<CameraDesc>> {
        let span = value.span();
        for key in Timing::KEYS {
            take_key(&mut value, key);
        }
        self.kind(value, &kind_tables::CAMERA).map(|c| Spanned::new(span, c))
    }

    /// Reads the value of a key that need not be there. What is wrong with it is collected.
    fn optional<'i, T: Deserialize<'i>>(&mut self, value: Option<Value<'i>>) -> Option<T> {
        value.and_then(|value| self.entity(value))
    }

    /// Parses the table of a material.
    pub fn material(&mut self, name: Spanned<String>, mut value: Value<'_>) -> Option<MaterialEntry> {
        let (backs, bump, normal) = (
            take_key(&mut value, "back_faces"),
            take_key(&mut value, "bump"),
            take_key(&mut value, "normal"),
        );
        let (back_faces, bump, normal) = (self.optional(backs), self.optional(bump), self.optional(normal));
        let material: MaterialDesc = self.kind(value, &kind_tables::MATERIAL)?;
        Some(MaterialEntry {
            name,
            back_faces,
            material,
            bump,
            normal,
        })
    }

    /// Parses the table of an object.
    pub fn object(&mut self, mut value: Value<'_>) -> Option<ObjectDesc> {
        let parts = self.parts(&mut value);
        let object = Some(value).filter(|v| self.have_one_kind(v, &[&kind_tables::SHAPE]))?;
        let object: ObjectDesc = self.entity(object)?;
        Some(ObjectDesc { parts, ..object })
    }

    /// Parses the table of a light.
    pub fn light(&mut self, mut value: Value<'_>) -> Option<LightEntry> {
        let span = value.span();
        let (name, group) = (take_key(&mut value, "name"), take_key(&mut value, "group"));
        let (name, group) = (name.and_then(|n| self.entity(n)), group.and_then(|g| self.entity(g)));
        let light: LightDesc = self.kind(value, &kind_tables::LIGHT)?;
        Some(LightEntry {
            span,
            name,
            group,
            light,
        })
    }

    /// Parses a table.
    pub fn entity<'i, T: Deserialize<'i>>(&mut self, value: Value<'i>) -> Option<T> {
        let span = value.span();
        T::deserialize(FileValue(value))
            .map_err(|e| self.problems.push(e.within(span).problem(self.overrides)))
            .ok()
    }

    /// Parses the keys of a camera's timing.
    fn timing(&mut self, keys: Vec<(&str, Value<'_>)>) -> Timing {
        let mut timing = Timing::default();
        for (key, value) in keys {
            match key {
                "shutter" => timing.shutter = self.shutter(value).unwrap_or_default(),
                "readout" => timing.readout.time = self.readout_time(value).unwrap_or_default(),
                _ => timing.readout.direction = self.entity(value).unwrap_or_default(),
            }
        }
        timing
    }

    /// Parses the time of a sensor's readout.
    fn readout_time(&mut self, value: Value<'_>) -> Option<f64> {
        let span = value.span();
        let time: f64 = self.entity(value)?;
        let is_valid = (0.0..=MAX_READOUT).contains(&time);
        if !is_valid {
            let message = format!("a readout takes from 0 to {MAX_READOUT} frames, not {time}");
            self.problems.push(Problem::at(span, message));
        }
        is_valid.then_some(time)
    }

    /// Parses the times at which a shutter opens and closes.
    fn shutter(&mut self, value: Value<'_>) -> Option<Shutter> {
        let span = value.span();
        let List([open, close]): List<f64, 2> = self.entity(value)?;
        let is_valid = open.is_finite() && close.is_finite() && open <= close;
        if !is_valid {
            let message = format!("a shutter closes after it opens, not at {close} after {open}");
            self.problems.push(Problem::at(span, message));
        }
        is_valid.then_some(Shutter { open, close })
    }

    /// Parses a table with one key, which names its kind.
    fn kind<'i, T: Deserialize<'i>>(&mut self, value: Value<'i>, table: &KindTable) -> Option<T> {
        if let Some(problem) = table.problem(&value, self.text) {
            self.problems.push(problem);
            return None;
        }
        kind_or_name(FileValue(value))
            .map_err(|e| self.problems.push(e.problem(self.overrides)))
            .ok()
    }

    /// Checks that the values of a table that these sorts of tables describe have one kind each.
    fn have_one_kind(&mut self, value: &Value<'_>, tables: &[&KindTable]) -> bool {
        let DeValue::Table(keys) = value.get_ref() else {
            return true;
        };
        let given = tables.iter().filter_map(|table| Some((table, keys.get(table.what)?)));
        let wrong: Vec<_> = given
            .filter_map(|(table, value)| table.problem(value, self.text))
            .collect();
        let all_right = wrong.is_empty();
        self.problems.extend(wrong);
        all_right
    }

    /// Parses the table of a texture.
    pub fn texture(&mut self, name: Spanned<String>, mut value: Value<'_>) -> Option<TextureEntry> {
        let span = value.span();
        let mut placed_by = Vec::new();
        let mut take = |key: &'static str| {
            let given = take_key(&mut value, key)?;
            placed_by.push(Spanned::new(given.span(), key));
            Some(given)
        };
        let [mapping, transform, warp] = ["mapping", "transform", "warp"].map(&mut take);
        let factor = take_key(&mut value, "factor");
        let mapping: MappingDesc = match mapping {
            Some(given) => self.kind(given, &kind_tables::MAPPING)?,
            None => MappingDesc::default(),
        };
        let transform: StTransformDesc = match transform {
            Some(given) => {
                if mapping.is_solid() {
                    let message = "`transform` is for the coordinates s and t alone";
                    let help = "give `mapping.object` or `mapping.world` a `scale`, `rotate` and `offset`";
                    self.problems.push(Problem::at(given.span(), message).with_help(help));
                }
                self.entity(given)?
            }
            None => StTransformDesc::default(),
        };
        let (warp, factor) = (self.optional(warp), self.optional(factor));
        let pattern: PatternDesc = self.kind(Spanned::new(span, value.into_inner()), &kind_tables::TEXTURE)?;
        Some(TextureEntry {
            name,
            pattern,
            mapping,
            transform,
            warp,
            factor,
            placed_by,
        })
    }

    /// `[what.NAME]` tables.
    fn named<T>(
        &mut self,
        value: Option<Value<'_>>,
        what: &str,
        mut read: impl FnMut(&mut Self, Spanned<String>, Value<'_>) -> Option<T>,
    ) -> Vec<T> {
        let Some(value) = value else { return Vec::new() };
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(table) => table
                .into_iter()
                .filter_map(|(key, value)| {
                    let name = Spanned::new(key.span(), key.get_ref().to_string());
                    self.check_name(what, &name);
                    read(self, name, value)
                })
                .collect(),
            other => {
                self.misplaced(span, other.type_str(), what);
                Vec::new()
            }
        }
    }

    /// `[[what]]` tables.
    fn list<'i, T>(
        &mut self,
        value: Option<Value<'i>>,
        what: &str,
        mut read: impl FnMut(&mut Self, Value<'i>) -> Option<T>,
    ) -> Vec<T> {
        let Some(value) = value else { return Vec::new() };
        let span = value.span();
        match value.into_inner() {
            DeValue::Array(array) => array.into_iter().filter_map(|v| read(self, v)).collect(),
            other => {
                self.misplaced(span, other.type_str(), what);
                Vec::new()
            }
        }
    }

    /// Adds the problem of a table `what` that is of the type `found` instead.
    fn misplaced(&mut self, span: Span, found: &str, what: &str) {
        let found = match found {
            "array" => "a list",
            "table" => "a single table",
            other => other,
        };
        let problem = Problem::at(span, format!("`{what}` cannot be {found}"));
        let help = foreign::table_help(what);
        self.problems.push(Problem { help, ..problem });
    }

    fn unique_names<'n>(&mut self, what: &str, names: impl Iterator<Item = &'n Option<Spanned<String>>>) {
        let mut seen = HashSet::new();
        for name in names.flatten() {
            self.check_name(what, name);
            if !seen.insert(name.get_ref().as_str()) {
                let message = format!("two {what}s are named `{}`", name.get_ref());
                self.problems.push(Problem::at(name.span(), message));
            }
            if name.get_ref().starts_with(LIGHT_GROUP) {
                let message = format!("a name of {what}s cannot begin with `{LIGHT_GROUP}`");
                let help = "light links mean a group of lights by it";
                self.problems.push(Problem::at(name.span(), message).with_help(help));
            }
        }
    }

    fn check_name(&mut self, what: &str, name: &Spanned<String>) {
        if name.get_ref().is_empty() {
            let message = format!("the name of the {what} is empty");
            self.problems.push(Problem::at(name.span(), message));
        }
    }
}

/// Converts an error of the syntax of `text`.
pub(super) fn syntax_problem(e: &toml::de::Error, text: &str) -> Problem {
    let message = e.message().lines().collect::<Vec<_>>().join(": ");
    let Some(span) = e.span() else {
        return Problem {
            span: None,
            message,
            help: None,
        };
    };
    let from = text[..span.start].rfind('\n').map_or(0, |n| n + 1);
    let line = text[from..].lines().next().unwrap_or_default();
    let name = &text[span.clone()];
    let (message, help) = match message.as_str() {
        "duplicate key" => {
            let help = foreign::table_help(name).filter(|_| line.trim_start().starts_with('['));
            (format!("the name `{name}` is used twice"), help)
        }
        _ => (message, foreign::decimal_comma(line)),
    };
    Problem {
        help,
        ..Problem::at(span, message)
    }
}

/// Takes a key out of a table.
fn take_key<'i>(value: &mut Value<'i>, key: &str) -> Option<Value<'i>> {
    match value.get_mut() {
        DeValue::Table(table) => table.remove(key),
        _ => None,
    }
}
