//! Edits of a camera path file: cells, columns and why an edit is refused.

/// Why an edit was refused. The document is unchanged.
#[derive(Debug, thiserror::Error)]
pub enum EditError {
    #[error("frame {0} has no key")]
    NoKey(f64),
    #[error("frame {0} has a key already")]
    Taken(f64),
    #[error("the camera path gives {0} in another way")]
    OtherWay(&'static str),
    /// The problems that the file would have.
    #[error("{0}")]
    Invalid(String),
}

/// The new text of a cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CellChange {
    pub column: usize,
    pub text: String,
}

impl CellChange {
    pub fn number(column: usize, v: f64) -> Self {
        Self {
            column,
            text: number(v),
        }
    }
}

/// A new last column, with the values of the other keys.
#[derive(Debug)]
pub(super) struct AddedColumn {
    pub name: &'static str,
    pub others: Vec<Option<f64>>,
}

/// The shortest text that parses to `v`.
pub(super) fn number(v: f64) -> String {
    // Adding 0 turns -0 into 0.
    format!("{}", v + 0.0)
}
