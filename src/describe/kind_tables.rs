//! Tables of which one key names a kind, as those of integrators, cameras and materials.

use super::foreign;
use crate::{
    camera::{CameraDesc, Timing},
    filter::FilterDesc,
    integrator::IntegratorDesc,
    light::LightDesc,
    material::MaterialDesc,
    math::sorting,
    sampler::SamplerDesc,
    shape::ShapeDesc,
    texture::{MappingDesc, PatternDesc},
    value::{Problem, Span, Spanned, UnknownName, is_override},
};
use toml::de::{DeTable, DeValue};

/// The key of a scene file that names a table of values.
pub(super) const VALUES: &str = "values";

/// The table of a scene file that has the distributions of values that are drawn.
pub(super) const RANDOM: &str = "random";

/// A sort of table of which one key names a kind.
pub(super) struct KindTable {
    /// The noun of the kinds, such as "light".
    pub what: &'static str,
    /// The names of the kinds.
    kinds: &'static [&'static str],
    /// The keys that may stand beside the one that names the kind.
    beside: &'static [&'static str],
}

const fn table(what: &'static str, kinds: &'static [&'static str]) -> KindTable {
    KindTable {
        what,
        kinds,
        beside: &[],
    }
}

pub(super) static CAMERA: KindTable = KindTable {
    beside: Timing::KEYS,
    ..table("camera", CameraDesc::NAMES)
};
pub(super) static FILTER: KindTable = table("filter", FilterDesc::NAMES);
pub(super) static INTEGRATOR: KindTable = table("integrator", IntegratorDesc::NAMES);
pub(super) static MAPPING: KindTable = table("mapping", MappingDesc::NAMES);
pub(super) static MATERIAL: KindTable = KindTable {
    beside: &["back_faces", "bump", "normal"],
    ..table("material", MaterialDesc::NAMES)
};
pub(super) static SAMPLER: KindTable = table("sampler", SamplerDesc::NAMES);
pub(super) static SHAPE: KindTable = table("shape", ShapeDesc::NAMES);
pub(super) static LIGHT: KindTable = KindTable {
    beside: &["name", "group"],
    ..table("light", LightDesc::NAMES)
};
pub(super) static TEXTURE: KindTable = KindTable {
    beside: &["mapping", "transform", "warp", "factor"],
    ..table("texture", PatternDesc::NAMES)
};

/// The names of the kinds of all tables.
#[cfg(test)]
pub(super) fn all() -> Vec<&'static [&'static str]> {
    let tables = [
        &CAMERA,
        &FILTER,
        &INTEGRATOR,
        &MAPPING,
        &MATERIAL,
        &SAMPLER,
        &SHAPE,
        &LIGHT,
        &TEXTURE,
    ];
    tables.map(|table| table.kinds).to_vec()
}

/// Returns the sort of the table at a path of keys, if one of its keys names a kind.
pub(super) fn kind_table(path: &[impl AsRef<str>]) -> Option<&'static KindTable> {
    let path: Vec<&str> = path.iter().map(AsRef::as_ref).collect();
    match *path {
        ["render", "integrator"] => Some(&INTEGRATOR),
        ["render", "sampler"] => Some(&SAMPLER),
        ["render", "filter"] => Some(&FILTER),
        ["camera"] => Some(&CAMERA),
        ["light", _] => Some(&LIGHT),
        ["material", _] => Some(&MATERIAL),
        ["object", _, "shape"] => Some(&SHAPE),
        ["texture", _] => Some(&TEXTURE),
        ["texture", _, "mapping"] => Some(&MAPPING),
        _ => None,
    }
}

/// Whether `name` is that of a kind in the table at a path of keys.
pub(super) fn is_kind(path: &[impl AsRef<str>], name: &str) -> bool {
    kind_table(path).is_some_and(|table| table.kinds.contains(&name))
}

impl KindTable {
    /// Whether `name` is that of one of its kinds.
    pub fn has(&self, name: &str) -> bool {
        self.kinds.contains(&name)
    }

    /// Returns the problem of a table that does not name one kind. `text` is the scene file.
    pub fn problem(&self, value: &Spanned<DeValue<'_>>, text: &str) -> Option<Problem> {
        let what = self.what;
        let DeValue::Table(table) = value.get_ref() else {
            return None;
        };
        let mut keys: Vec<_> = table.keys().collect();
        sorting::sort_by_key(&mut keys, |key| key.span().start);
        keys.retain(|key| !self.beside.contains(&key.get_ref().as_ref()));
        let (kinds, others): (Vec<_>, Vec<_>) = keys
            .into_iter()
            .partition(|key| self.kinds.contains(&key.get_ref().as_ref()));
        match (&kinds[..], &others[..]) {
            ([], []) => Some(Problem::at(value.span(), format!("this {what} has no kind"))),
            ([first, second, ..], _) => {
                let (place, first, other) = (place(text, &first.span()), first.get_ref(), second.get_ref());
                let message = format!("only one kind of {what} can be chosen, found `{first}`{place} and `{other}`");
                Some(Problem::at(second.span(), message))
            }
            ([kind], [other, ..]) => {
                let (kind, key) = (kind.get_ref(), other.get_ref());
                let help = match key.as_ref() {
                    VALUES => format!("`{VALUES}` stands before the first table of the file"),
                    _ => format!("if it is a key of the {what}, it goes into its table: {kind} = {{ {key} = .. }}"),
                };
                let known = self.beside.iter().chain(self.kinds).copied();
                let names: Vec<&str> = known.clone().collect();
                let unknown = UnknownName::new("key", key, known).with_fallback(Some(help));
                let problem = unknown.at(other.span());
                Some(Problem {
                    help: foreign::help(key, &names).or(problem.help),
                    ..problem
                })
            }
            _ => None,
        }
    }

    /// The kind that a value names, and its place.
    fn kind_of<'a>(&self, value: &'a Spanned<DeValue<'_>>) -> Option<(&'a str, Span)> {
        match value.get_ref() {
            DeValue::String(kind) => Some((kind.as_ref(), value.span())),
            DeValue::Table(table) => {
                let mut kinds = table.keys().filter(|key| self.kinds.contains(&key.get_ref().as_ref()));
                kinds.next().map(|key| (key.get_ref().as_ref(), key.span()))
            }
            _ => None,
        }
    }
}

/// Returns the problem of an override at `path` that belongs to another kind than the table has. It does not replace the
/// kind: a single key would drop all that the file says of it.
pub(super) fn another_kind(table: &DeTable<'_>, path: &[impl AsRef<str>], span: &Span, text: &str) -> Option<Problem> {
    let path: Vec<&str> = path.iter().map(AsRef::as_ref).collect();
    let mut value = table.get(*path.first()?)?;
    for (n, &key) in path.iter().enumerate().skip(1) {
        if let Some(sort) = kind_table(&path[..n])
            && sort.kinds.contains(&key)
            && let Some((kind, kind_span)) = sort.kind_of(value).filter(|(kind, _)| *kind != key)
        {
            let message = format!("the {} is `{kind}`{}, not `{key}`", sort.what, place(text, &kind_span));
            let help = format!("to replace it, set {}={key} before", path[..n].join("."));
            return Some(Problem::at(span.clone(), message).with_help(help));
        }
        value = match value.get_ref() {
            DeValue::Table(table) => table.get(key)?,
            DeValue::Array(list) => list.get(key.parse::<usize>().ok()?)?,
            _ => return None,
        };
    }
    None
}

/// The line of a span in the file, in parentheses; nothing for the span of an override.
fn place(text: &str, span: &Span) -> String {
    let before = text.get(..span.start).filter(|_| !is_override(span));
    let line = before.map(|before| 1 + before.matches('\n').count());
    line.map(|line| format!(" (line {line})")).unwrap_or_default()
}
