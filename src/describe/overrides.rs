//! Overrides: values that replace those of a scene file.
//!
//! Flags, the looks of the viewer and callers of the library set keys of the description. The values are put into the table of
//! the file before it is read, so the parser of the file checks them as well. Their spans lie beyond every file and number the
//! overrides: wherever a value turns out to be wrong, the error names its origin, as in `--view: unknown view ...`.

use std::borrow::Cow;

use toml::de::{DeTable, DeValue};

use super::{
    kind_tables::{another_kind, kind_table},
    names::{Component, FileKind, KnownNames, unset},
    parts::QUATERNION,
    placed::placed,
    stage::Stage,
};
use crate::value::{OVERRIDES, Problem, Span, Spanned};

/// The number of samples where no scene file has one, in TOML.
const SAMPLES: &str = "64";

/// A value for a key of a scene file.
#[derive(Clone, Debug, PartialEq)]
struct Override {
    /// The names of the tables and of the key in them.
    path: Vec<String>,
    /// In TOML.
    value: String,
    /// The place where the value was given, such as `--samples`.
    origin: String,
    place: Place,
}

/// Who gives a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// A flag, or a caller of the library.
    Request,
    /// A cell, or a draw, of a file.
    Cell,
    /// A draw of a flag.
    Draw,
    /// A flag that sets more than one key.
    Stage(Stage),
}

/// Values that replace those of a scene file, in the order in which they are applied.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides(Vec<Override>);

impl Overrides {
    /// Adds a value for the key at this path, such as `render.samples`. Errors name the path.
    pub fn with(mut self, path: &str, value: impl Into<toml::Value>) -> Self {
        self.set(path, path, value);
        self
    }

    /// Adds a value for the key at this path. Errors name `origin`, such as `--samples`.
    pub fn set(&mut self, origin: &str, path: &str, value: impl Into<toml::Value>) {
        self.0.push(Override {
            path: path.split('.').map(str::to_owned).collect(),
            value: value.into().to_string(),
            origin: origin.to_owned(),
            place: Place::Request,
        });
    }

    /// Adds a value of the stage. Errors name `origin`, such as `--lens`.
    pub fn set_stage(&mut self, origin: &str, stage: Stage, value: impl Into<toml::Value>) {
        self.set(origin, &format!("stage.{}", stage.name()), value);
        if let Some(last) = self.0.last_mut() {
            last.place = Place::Stage(stage);
        }
    }

    /// The values of the stage, in TOML.
    pub fn stage(&self) -> impl Iterator<Item = (Stage, &str)> {
        self.0.iter().filter_map(|one| match one.place {
            Place::Stage(stage) => Some((stage, one.value.as_str())),
            Place::Request | Place::Cell | Place::Draw => None,
        })
    }

    /// Whether the value with this span is one of the stage.
    pub(super) fn is_of_stage(&self, span: &Span) -> bool {
        self.at(span).is_some_and(|one| matches!(one.place, Place::Stage(_)))
    }

    /// Adds the origin of the value `name`, whose cell or distribution has it: a place in a file, or
    /// after a flag that is among these.
    pub(super) fn set_cell(&mut self, origin: &str, name: &str) {
        // Those of files come after all flags.
        let mut flags = (self.0.iter()).take_while(|one| !matches!(one.place, Place::Cell | Place::Draw));
        let follows = |one: &Override| {
            let rest = origin.strip_prefix(&one.origin);
            rest.is_some_and(|rest| rest.starts_with(": "))
        };
        let place = match flags.any(follows) {
            true => Place::Draw,
            false => Place::Cell,
        };
        self.set(origin, name, true);
        if let Some(last) = self.0.last_mut() {
            last.place = place;
        }
    }

    /// Adds these after the own ones.
    pub fn extend(&mut self, others: Self) {
        self.0.extend(others.0);
    }

    /// The values that the settings of a job do not hold, as a text: those of the scene itself.
    pub fn of_scene(&self) -> String {
        let is_setting = |path: &[String]| match path {
            [table, key, ..] if table == "render" => key != "working_space",
            [table, ..] => table == "output",
            [] => false,
        };
        let of_scene = self.0.iter().filter(|one| !is_setting(&one.path));
        of_scene
            .map(|one| format!("{} = {}\n", one.path.join("."), one.value))
            .collect()
    }

    /// The origin and the path of each value.
    pub fn paths(&self) -> impl Iterator<Item = (&str, &[String])> {
        self.0.iter().map(|one| (one.origin.as_str(), one.path.as_slice()))
    }

    /// The path, the text in TOML and the span of each value.
    pub(super) fn values(&self) -> impl Iterator<Item = (&[String], &str, Span)> {
        let numbered = self.0.iter().zip(OVERRIDES..);
        numbered.map(|(one, start)| (one.path.as_slice(), one.value.as_str(), start..start + 1))
    }

    /// The origin of the value with this span, if it is an override's.
    pub(super) fn origin(&self, span: &Span) -> Option<&str> {
        Some(&self.at(span)?.origin)
    }

    /// Whether the value with this span is a request's, and no file's.
    pub(super) fn is_request(&self, span: &Span) -> bool {
        self.at(span).is_some_and(|one| one.place != Place::Cell)
    }

    /// The key whose override has the unknown name `word` at this span, if any.
    pub(super) fn named(&self, span: &Span, word: &str) -> Option<&str> {
        let path = &self.at(span)?.path;
        let is_kind = |at: usize| kind_table(&path[..at]).is_some();
        match path.iter().position(|key| key == word).is_some_and(is_kind) {
            true => Some("kind"),
            false => path.last().map(String::as_str),
        }
    }

    fn at(&self, span: &Span) -> Option<&Override> {
        self.0.get(span.start.checked_sub(OVERRIDES)?)
    }

    /// Puts the values into the table of a file of this kind, of which `text` is shown. Returns the problems
    /// of those that have no place in it.
    pub(super) fn apply<'i>(&'i self, table: &mut DeTable<'i>, (kind, text): (FileKind, &str)) -> Vec<Problem> {
        let (mut problems, mut components) = (Vec::new(), Vec::new());
        let known = KnownNames::new(table, kind);
        for (one, start) in self.0.iter().zip(OVERRIDES..) {
            let span = start..start + 1;
            if let Place::Stage(stage) = one.place {
                let value = DeValue::parse(&one.value).expect("the TOML crate has written it");
                problems.extend(stage.apply(table, placed(value.into_inner(), &span)).err());
                continue;
            }
            let path = known.resolve(&one.path, &span);
            let path = path.and_then(|path| match another_kind(table, &path, &span, text) {
                Some(problem) => Err(problem),
                None => Ok(path),
            });
            let value = DeValue::parse(&one.value).expect("the TOML crate has written it");
            let put = path.and_then(|path| {
                if change_kind(table, &path, value.get_ref(), &span) {
                    return Ok(());
                }
                let component = Component::of_path(&path);
                put(table, (&path, component), placed(value.into_inner(), &span))?;
                components.extend(component.map(|_| (path, span)));
                Ok(())
            });
            problems.extend(put.err());
        }
        problems.extend(components.iter().filter_map(|(path, span)| unset(table, path, span)));
        problems
    }
}

/// The value of a text: a number if it can be read as one.
pub fn number_or_text(text: &str) -> toml::Value {
    let number = text.parse::<i64>().map(toml::Value::from);
    let number = number.or_else(|_| text.parse::<f64>().map(toml::Value::from));
    number.unwrap_or_else(|_| text.into())
}

/// Sets the key at this path below `table`, and makes the tables that are missing on the way.
pub(super) fn put<'i>(
    table: &mut DeTable<'i>,
    (path, component): (&[Cow<'i, str>], Option<Component>),
    value: Spanned<DeValue<'i>>,
) -> Result<(), Problem> {
    let [key, inner @ ..] = path else { return Ok(()) };
    let span = value.span();
    let named = || Spanned::new(span.clone(), key.clone());
    if let (Some(component), [_]) = (component, inner)
        && component.is_put_into(table.get(key.as_ref()))
    {
        let old = table.remove(key.as_ref());
        table.insert(named(), component.put(key, old, value)?);
        return Ok(());
    }
    let Some(next) = inner.first() else {
        let old = table.remove(key.as_ref());
        let new = match old {
            Some(old) => merged(key, old, value),
            None => value,
        };
        table.insert(named(), new);
        return Ok(());
    };
    let (name, old) = table.remove_entry(key.as_ref()).unzip();
    let mut old = written_out(key, next, old, &span)?;
    let no_table = |what: &DeValue<'_>| {
        let message = format!("`{key}` is no table but of type {}", what.type_str());
        Err(Problem::at(span.clone(), message))
    };
    let result = match old.get_mut() {
        DeValue::Table(table) => put(table, (inner, component), value),
        DeValue::Array(list) => {
            let element = next.parse().ok().and_then(|n: usize| list.get_mut(n));
            match (element, &inner[1..]) {
                (Some(element), []) => {
                    *element = value;
                    Ok(())
                }
                (Some(element), path) => match element.get_mut() {
                    DeValue::Table(table) => put(table, (path, component), value),
                    element => no_table(element),
                },
                (None, _) => Err(Problem::at(
                    span.clone(),
                    format!("`{key}` has no element {next}, they count from 0"),
                )),
            }
        }
        other => no_table(other),
    };
    table.insert(name.unwrap_or_else(named), old);
    result
}

/// Gives the table at `path` another kind, if `new` is the name of one. The keys that all kinds have
/// stay. Returns whether that is so.
fn change_kind(table: &mut DeTable<'_>, path: &[Cow<'_, str>], new: &DeValue<'_>, span: &Span) -> bool {
    let Some((sort, kind)) = kind_table(path).zip(new.as_str()).filter(|(sort, kind)| sort.has(kind)) else {
        return false;
    };
    let [first, inner @ ..] = path else { return false };
    let mut value = table.get_mut(first.as_ref());
    for step in inner {
        value = match value.map(Spanned::get_mut) {
            Some(DeValue::Table(table)) => table.get_mut(step.as_ref()),
            Some(DeValue::Array(list)) => step.parse().ok().and_then(|at: usize| list.get_mut(at)),
            _ => None,
        };
    }
    let Some(DeValue::Table(own)) = value.map(Spanned::get_mut) else {
        return false;
    };
    if !own.contains_key(kind) {
        let others: Vec<_> = own
            .keys()
            .filter(|key| sort.has(key.get_ref()))
            .map(|key| key.get_ref().clone())
            .collect();
        for other in others {
            own.remove(other.as_ref());
        }
        let empty = Spanned::new(span.clone(), DeValue::Table(DeTable::new()));
        own.insert(Spanned::new(span.clone(), Cow::Owned(kind.to_owned())), empty);
    }
    true
}

/// Returns the value of `key` after `new` is applied: a number of `samples` is the most of them where they are adaptive, and a kind
/// that is named keeps its settings if it is the same.
fn merged<'i>(key: &str, mut old: Spanned<DeValue<'i>>, new: Spanned<DeValue<'i>>) -> Spanned<DeValue<'i>> {
    let DeValue::Table(table) = old.get_mut() else {
        return new;
    };
    match new.get_ref() {
        DeValue::Integer(_) if key == "samples" => {
            table.insert(Spanned::new(new.span(), Cow::Borrowed("max")), new);
            old
        }
        DeValue::String(kind) if table.len() == 1 && table.contains_key(kind.as_ref()) => old,
        _ => new,
    }
}

/// The value of `key` as a table that can hold `next`, where it is written shorter: a kind by its name, `samples` by a number.
fn written_out<'i>(
    key: &str,
    next: &str,
    old: Option<Spanned<DeValue<'i>>>,
    span: &Span,
) -> Result<Spanned<DeValue<'i>>, Problem> {
    let (name, value) = match old.as_ref().map(Spanned::get_ref) {
        None | Some(DeValue::Integer(_)) if key == "samples" && next == "min" => {
            let help = "--noise-threshold makes it adaptive";
            return Err(Problem::at(span.clone(), "the number of samples is fixed").with_help(help));
        }
        Some(DeValue::Integer(_)) if key == "samples" => (Cow::Borrowed("max"), old.expect("it is a number")),
        None if key == "samples" => {
            let number = DeValue::parse(SAMPLES).expect("a number");
            (Cow::Borrowed("max"), placed(number.into_inner(), span))
        }
        Some(DeValue::String(kind)) if kind == next => {
            let empty = DeValue::Table(DeTable::new());
            (kind.clone(), Spanned::new(span.clone(), empty))
        }
        // A quaternion takes the place of angles.
        Some(DeValue::Array(_)) if key == "rotate" && QUATERNION.contains(&next) => {
            return Ok(Spanned::new(span.clone(), DeValue::Table(DeTable::new())));
        }
        None => return Ok(Spanned::new(span.clone(), DeValue::Table(DeTable::new()))),
        Some(_) => return Ok(old.expect("it is there")),
    };
    let table = DeTable::from_iter([(Spanned::new(span.clone(), name), value)]);
    Ok(Spanned::new(span.clone(), DeValue::Table(table)))
}
