//! Files of distributions, for models by themselves and for many scenes, and flags that change them.

use std::{io, path::Path};

use toml::de::{DeTable, DeValue};

use super::{
    Diagnostics, Error, Overrides, RandomDesc, Source, kind_tables::RANDOM, overrides::put, placed::placed,
    read::syntax_problem,
};
use crate::value::{Problem, Span, Spanned};

impl RandomDesc {
    /// Reads the file at `path`, whose bytes come from `read`, with those of the overrides that concern it.
    ///
    /// # Errors
    /// The file cannot be read, or its contents are invalid.
    pub fn load<'p, B: AsRef<[u8]>>(
        path: &'p Path,
        overrides: &Overrides,
        read: impl FnOnce(&'p Path) -> io::Result<B>,
    ) -> Result<Self, Error> {
        let shown = || path.display().to_string();
        let bytes = read(path).map_err(|cause| Error::ReadRandom { path: shown(), cause })?;
        let text = str::from_utf8(bytes.as_ref()).map_err(|_| Error::Encoding { path: shown() })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let source = Source::new(path.to_owned(), text).with(overrides.clone());
        let own = Self::of_source(&source).map_err(Error::Invalid)?;
        Ok(Self { is_apart: true, ..own })
    }

    /// The values that overrides alone draw, of the scene at `path`.
    ///
    /// # Errors
    /// An override is wrong.
    pub fn of_overrides(path: &Path, overrides: &Overrides) -> Result<Self, Diagnostics> {
        Self::of_source(&Source::new(path.to_owned(), "").with(overrides.clone()))
    }

    /// Reads a text that has the keys of the table alone.
    pub(super) fn of_source(source: &Source) -> Result<Self, Diagnostics> {
        let mut problems = Vec::new();
        let mut table = match DeTable::parse(&source.text) {
            Ok(table) => table.into_inner(),
            Err(error) => {
                problems.push(syntax_problem(&error, &source.text));
                DeTable::new()
            }
        };
        // In the file that is written for the table of a scene, its header may stand.
        if table.len() == 1
            && let Some(DeValue::Table(own)) = table.get_mut(RANDOM).map(Spanned::get_mut)
        {
            table = std::mem::take(own);
        }
        problems.extend(source.overrides.apply_to_random(&mut table));
        let own = Self::read(table, source, &mut problems);
        Diagnostics::new(source, problems).map_or(Ok(own), Err)
    }
}

impl Overrides {
    /// Puts the values that concern the table of distributions into it.
    fn apply_to_random<'i>(&'i self, table: &mut DeTable<'i>) -> Vec<Problem> {
        let of_random = |(path, value, span): (&'i [String], &'i str, Span)| match path {
            [first, path @ ..] if first == RANDOM && !path.is_empty() => Some((path, value, span)),
            _ => None,
        };
        let of_random = self.values().filter_map(of_random);
        let put_one = |(path, value, span): (&'i [String], &'i str, Span)| {
            let value = DeValue::parse(value).expect("the TOML crate has written it");
            let path: Vec<_> = path.iter().map(|step| step.as_str().into()).collect();
            put(table, (&path, None), placed(value.into_inner(), &span)).err()
        };
        of_random.filter_map(put_one).collect()
    }
}
