//! The contract of a format of model files.

use std::{error::Error, path::Path};

use super::{
    Files,
    model::{Model, ModelChoice},
};

/// A format of model files; the table of all is [`FORMATS`](super::model_formats::FORMATS).
pub trait ModelFormat: Sync {
    /// Endings of file names, without the point, in lower case.
    fn extensions(&self) -> &'static [&'static str];

    /// Whether its files may be packed by gzip, so that `.gz` follows their ending.
    fn may_be_packed(&self) -> bool {
        true
    }

    /// Whether a file can have several scenes and material variants, of which a [`ModelChoice`] chooses.
    fn has_choices(&self) -> bool {
        false
    }

    /// Whether the groups of an object have vertices in common, so that they are one surface.
    fn joins_groups(&self) -> bool {
        false
    }

    /// Loads the model at `path`. What the file has and is not rendered are features and faults of the model.
    fn load(&self, path: &Path, choice: &ModelChoice, files: &Files) -> Result<Model, Box<dyn ModelError>>;
}

/// Why a model was not loaded. The message names the file.
pub trait ModelError: Error + Send + Sync {
    /// The file of the model.
    fn path(&self) -> &Path;

    /// Whether a file could not be read at all, rather than understood.
    fn is_missing(&self) -> bool;

    /// Whether the choice does not fit the file, which is sound.
    fn is_choice(&self) -> bool {
        false
    }
}

impl<E: ModelError + 'static> From<E> for Box<dyn ModelError> {
    fn from(error: E) -> Self {
        Box::new(error)
    }
}
