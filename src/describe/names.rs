//! Names of values: paths of keys in a scene file, in which objects and lights go by their names and vectors by their components.
//!
//! `object.ball.transform.translate.x` is the first number of `translate` in the `transform` of the object that is named `ball`.

use std::borrow::Cow;

use toml::de::{DeTable, DeValue};

use super::{
    kind_tables::{RANDOM, is_kind},
    parts,
};
use crate::value::{Problem, Span, Spanned, UnknownName};

/// The tables whose keys are names that the scene file chooses.
const NAMED: [&str; 2] = ["material", "texture"];

/// The lists whose elements have names.
const LISTED: [&str; 2] = ["object", "light"];

/// The kind of a file with a text of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FileKind {
    #[default]
    Scene,
    /// A model by itself. The text is that of the scene that it stands for, and in no file.
    Model,
}

/// The names in the tables of a scene file.
pub(super) struct KnownNames {
    named: [Names; NAMED.len()],
    listed: [Names; LISTED.len()],
    kind: FileKind,
}

/// The names of the tables of one sort.
#[derive(Default)]
struct Names {
    names: Vec<String>,
    /// The keys of each table; empty where no name has a point in it.
    keys: Vec<Vec<String>>,
}

impl Names {
    fn new(named: Vec<(String, &Spanned<DeValue<'_>>)>) -> Self {
        let keys = |(_, table): &(String, &Spanned<DeValue<'_>>)| {
            let table = table.get_ref().as_table().into_iter();
            table
                .flat_map(|table| table.keys().map(|key| key.get_ref().to_string()))
                .collect()
        };
        let has_points = named.iter().any(|(name, _)| name.contains('.'));
        Self {
            keys: named.iter().filter(|_| has_points).map(keys).collect(),
            names: named.into_iter().map(|(name, _)| name).collect(),
        }
    }

    /// The name that `steps` begin with, by the number of its steps and its place. A name may have points in it: the longest one
    /// counts whose table has the next step as a key, or the longest one where none has.
    fn find(&self, steps: &[String]) -> Option<(usize, usize)> {
        let found = (1..=steps.len()).rev().filter_map(|count| {
            let name = steps[..count].join(".");
            Some((count, self.names.iter().position(|known| *known == name)?))
        });
        let has_next = |(count, at): &(usize, usize)| match (self.keys.get(*at), steps.get(*count)) {
            (Some(keys), Some(next)) => keys.contains(next),
            _ => false,
        };
        found.clone().find(has_next).or_else(|| found.clone().next())
    }
}

/// The keys of an object that go without its name where a model by itself is the only one.
const OF_MODEL: [&str; 3] = ["node", "material", "transform"];

impl KnownNames {
    /// The names in `table`, which is that of a whole file of this kind.
    pub fn new(table: &DeTable<'_>, kind: FileKind) -> Self {
        let get = |what: &str| table.get(what).map(Spanned::get_ref);
        Self {
            named: NAMED.map(|what| {
                let tables = get(what).and_then(DeValue::as_table).into_iter();
                let tables = tables.flat_map(DeTable::iter);
                Names::new(tables.map(|(key, table)| (key.get_ref().to_string(), table)).collect())
            }),
            listed: LISTED.map(|what| {
                let elements = get(what).and_then(DeValue::as_array).into_iter().flatten();
                let name = |element: &Spanned<DeValue<'_>>| {
                    let name = element.get_ref().as_table()?.get("name")?.get_ref().as_str()?;
                    Some(name.to_owned())
                };
                let numbered = |(element, number)| {
                    let name = name(element).unwrap_or_else(|| format!("{what} {number}"));
                    (name, element)
                };
                Names::new(elements.zip(1..).map(numbered).collect())
            }),
            kind,
        }
    }

    /// The paths that `path`, whose second step stands for any name, has with each of the names, but for that of the ground of a
    /// model by itself; `None` where the first is no table of the scene that has names.
    pub fn each(&self, path: &[String]) -> Option<Vec<Vec<String>>> {
        let [table, _, rest @ ..] = path else { return None };
        let tables = NAMED.iter().zip(&self.named).chain(LISTED.iter().zip(&self.listed));
        let (_, names) = tables.into_iter().find(|(what, _)| *what == table)?;
        let whole = |name: &String| [&[table.clone(), name.clone()], rest].concat();
        // Beside a model by itself there may be a ground.
        let count = match self.kind {
            FileKind::Model if table == "object" => 1,
            _ => usize::MAX,
        };
        Some(names.names.iter().take(count).map(whole).collect())
    }

    /// Returns `path` with each name as one step, and with the number of an element, from 0, in place of its
    /// name. `span` is that of the value.
    pub fn resolve<'p>(&self, path: &'p [String], span: &Span) -> Result<Vec<Cow<'p, str>>, Problem> {
        let numbered = match path.first() {
            Some(key)
                if self.kind == FileKind::Model && OF_MODEL.contains(&key.as_str()) && !self.is_supplied(path) =>
            {
                let object = ["object", "0"].map(Cow::Borrowed).into_iter();
                Ok(object
                    .chain(path.iter().map(|step| Cow::Borrowed(step.as_str())))
                    .collect())
            }
            _ => self.numbered(path, span),
        };
        numbered.map(parts::joined)
    }

    /// Whether the path begins with a material of the scene that a model by itself stands for, which goes before one of the model.
    fn is_supplied(&self, path: &[String]) -> bool {
        let named = NAMED.iter().zip(&self.named);
        let mut own = named.filter(|(what, _)| path.first().is_some_and(|key| key == **what));
        own.any(|(_, names)| names.find(&path[1..]).is_some())
    }

    fn numbered<'p>(&self, path: &'p [String], span: &Span) -> Result<Vec<Cow<'p, str>>, Problem> {
        let plain = || path.iter().map(|step| Cow::Borrowed(step.as_str())).collect();
        let [table, rest @ ..] = path else { return Ok(plain()) };
        let lists = LISTED.iter().zip(&self.listed).map(|(what, names)| (what, names, true));
        let tables = NAMED.iter().zip(&self.named).map(|(what, names)| (what, names, false));
        let Some((what, names, is_list)) = tables.chain(lists).find(|(what, ..)| *what == table) else {
            return Ok(plain());
        };
        let found = names.find(rest);
        let names = &names.names;
        let step = |(steps, at): (usize, usize)| {
            let step = if is_list { at.to_string() } else { names[at].clone() };
            let inner = rest[steps..].iter().map(|step| Cow::Borrowed(step.as_str()));
            [Cow::Borrowed(table.as_str()), Cow::Owned(step)]
                .into_iter()
                .chain(inner)
                .collect()
        };
        match (found, rest.first()) {
            (Some(found), _) => Ok(step(found)),
            // A table that has no names yet may get its first one.
            (None, Some(_)) if is_list && names.is_empty() => {
                let none =
                    UnknownName::new(what, &rest[0], []).with_fallback(Some(format!("the scene has no {what}s")));
                Err(none.at(span.clone()))
            }
            (None, Some(name)) if !(names.is_empty() || is_list && name.parse::<usize>().is_ok()) => {
                Err(unknown(what, rest, names).at(span.clone()))
            }
            (None, _) => Ok(plain()),
        }
    }
}

/// The unknown name that the path `steps` begins with, compared with known names of as many steps.
fn unknown(what: &str, steps: &[String], known: &[String]) -> UnknownName {
    let of = |count: usize| {
        let alike = known.iter().filter(|name| name.split('.').count() == count);
        UnknownName::new(what, &steps[..count].join("."), alike.map(String::as_str))
    };
    let similar = (1..=steps.len()).map(of).find(|unknown| unknown.suggestion().is_some());
    similar.unwrap_or_else(|| UnknownName::new(what, &steps[0], known.iter().map(String::as_str)))
}

/// The place in a list of numbers that a path ends with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Component {
    index: usize,
    /// The numbers of the list.
    count: usize,
    /// Whether those that are not given are the model's own, so that there need not be a list.
    is_partial: bool,
}

impl Component {
    /// The component that the path `[.., key, name]` names, if it names one, and not a key of a kind.
    pub fn of_path(path: &[Cow<'_, str>]) -> Option<Self> {
        let (index, count) = match path.last()?.as_ref() {
            "x" | "r" => (0, 3),
            "y" | "g" => (1, 3),
            "z" | "b" => (2, 3),
            "s" => (0, 2),
            "t" => (1, 2),
            _ => return None,
        };
        let [table @ .., kind, _] = path else { return None };
        // The settings of a job and distributions are no lists of numbers.
        let is_setting = matches!(table, [own] if own == "render" || own == "output")
            || matches!(table, [first, ..] if first == RANDOM);
        let is_component = !table.is_empty() && !is_setting && !is_kind(table, kind);
        is_component.then(|| Self {
            index,
            count,
            is_partial: parts::is_of_part(path),
        })
    }

    /// Its place in the list.
    pub fn index(self) -> usize {
        self.index
    }

    /// Whether it becomes a component of `old`, and not a key of a table.
    pub fn is_put_into(self, old: Option<&Spanned<DeValue<'_>>>) -> bool {
        old.map_or(!self.is_partial, |old| !old.get_ref().is_table())
    }

    /// Returns the list `old` of `key` with `new` as this component. The other components of a list that is not there are
    /// unset until others set them, see [`unset`], unless a transform has defaults for them.
    pub fn put<'i>(
        self,
        key: &str,
        old: Option<Spanned<DeValue<'i>>>,
        new: Spanned<DeValue<'i>>,
    ) -> Result<Spanned<DeValue<'i>>, Problem> {
        let span = new.span();
        let of = |value: DeValue<'i>| Spanned::new(span.clone(), value);
        let all = |value: Spanned<DeValue<'i>>| vec![value; self.count];
        let number = |text: &'static str| DeValue::parse(text).expect("a number").into_inner();
        let mut list: Vec<_> = match old.map(Spanned::into_inner) {
            Some(DeValue::Array(list)) => list.into_iter().collect(),
            Some(one @ (DeValue::Integer(_) | DeValue::Float(_))) => all(of(one)),
            None => all(of(match key {
                "translate" | "rotate" => number("0"),
                "scale" => number("1"),
                _ => DeValue::Boolean(false),
            })),
            Some(other) => {
                let message = format!("`{key}` has no components, it is of type {}", other.type_str());
                return Err(Problem::at(span, message));
            }
        };
        let count = list.len();
        let Some(component) = list.get_mut(self.index) else {
            return Err(Problem::at(span, format!("`{key}` has {count} numbers only")));
        };
        *component = new;
        Ok(of(DeValue::Array(list.into_iter().collect())))
    }
}

/// Returns the problem of a list of which a component was set, by `path` in `table`, and others have no value.
pub(super) fn unset(table: &DeTable<'_>, path: &[impl AsRef<str>], span: &Span) -> Option<Problem> {
    let (_, path) = path.split_last()?;
    let (first, inner) = path.split_first()?;
    let mut value = table.get(first.as_ref())?;
    for step in inner {
        value = match value.get_ref() {
            DeValue::Table(table) => table.get(step.as_ref())?,
            DeValue::Array(list) => list.get(step.as_ref().parse::<usize>().ok()?)?,
            _ => return None,
        };
    }
    let list = value.get_ref().as_array()?;
    let is_unset = |one: &Spanned<DeValue<'_>>| matches!(one.get_ref(), DeValue::Boolean(false));
    list.iter().any(is_unset).then(|| {
        let key = path[path.len() - 1].as_ref();
        let message = format!("the file has no `{key}`, and only some of its components are set");
        Problem::at(span.clone(), message).with_help("set all of them, or write it into the file")
    })
}
