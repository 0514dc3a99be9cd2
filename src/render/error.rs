//! The reasons why a frame was not rendered.

use super::control::Cancelled;
use crate::value::UnknownName;

/// Why a frame was not rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A pass shows a light group that the scene does not have.
    #[error(transparent)]
    Pass(#[from] UnknownName),
}
