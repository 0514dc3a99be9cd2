//! Sources of values that change from frame to frame: tables, and distributions.

use std::{path::Path, sync::Arc};

use super::{
    DrawDesc, RandomDesc,
    random::LeftOut,
    values::{FileRows, ValueFile},
};
use crate::assets::camera_path::{ValueColumn, ValueTable};

/// A source of values that change from frame to frame.
#[derive(Clone, Debug)]
pub enum ValueSource {
    Table(ValueFile),
    Random(Arc<RandomDesc>),
}

impl ValueSource {
    /// The file that has it.
    pub fn path(&self) -> &Path {
        match self {
            Self::Table(file) => &file.path,
            Self::Random(random) => &random.path,
        }
    }

    /// The names of its values.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let (columns, draws) = match self {
            Self::Table(file) => (&file.table.columns[..], &[][..]),
            Self::Random(random) => (&[][..], &random.draws[..]),
        };
        let columns = columns.iter().map(|column| column.name.as_str());
        columns.chain(draws.iter().map(|draw| draw.name.as_str()))
    }

    /// The values that are not drawn.
    pub(super) fn left_out(&self) -> &[LeftOut] {
        match self {
            Self::Table(_) => &[],
            Self::Random(random) => &random.left_out,
        }
    }

    /// The names of all values, with those that are not drawn.
    pub(super) fn given_names(&self) -> impl Iterator<Item = &str> {
        self.names()
            .chain(self.left_out().iter().map(|left_out| left_out.name.as_str()))
    }

    /// The names of the columns, the place of each, and the columns.
    pub(super) fn columns(&self) -> Vec<(&str, String, SourceColumn<'_>)> {
        match self {
            Self::Table(ValueFile { path, table }) => {
                let place = |name: &str| format!("{}:{}: {name}", path.display(), table.header);
                let columns = table.columns.iter();
                columns
                    .map(|own| (own.name.as_str(), place(&own.name), SourceColumn::Table(table, own)))
                    .collect()
            }
            Self::Random(random) => {
                let place = |draw: &DrawDesc| format!("{}: {}", draw.origin, draw.name);
                let draws = random.draws.iter().enumerate();
                draws
                    .map(|(at, own)| (own.name.as_str(), place(own), SourceColumn::Random(random, at)))
                    .collect()
            }
        }
    }
}

impl FileRows {
    pub(super) fn of_source(source: &ValueSource) -> Self {
        match source {
            ValueSource::Table(ValueFile { path, table }) => Self {
                path: path.clone(),
                header: table.header,
                rows: table.rows.clone(),
                is_apart: true,
            },
            ValueSource::Random(random) => Self {
                path: random.path.clone(),
                header: 1,
                rows: Vec::new(),
                is_apart: random.is_apart,
            },
        }
    }
}

/// The source of the values of a column.
pub(super) enum SourceColumn<'s> {
    Table(&'s ValueTable, &'s ValueColumn),
    /// The index of the value among those that are drawn.
    Random(&'s RandomDesc, usize),
}
