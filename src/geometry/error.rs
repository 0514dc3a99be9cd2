//! Errors of a build.

use thiserror::Error;

/// The largest valid coordinate, in metres. A product of three coordinates is still finite.
pub const MAX_COORDINATE: f32 = 1e12;

/// The reason why a build or an update failed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum BuildError {
    #[error("primitive {prim} has a coordinate that is not a finite number")]
    NotFinite { prim: usize },
    #[error("primitive {prim} has a coordinate beyond {MAX_COORDINATE:e} m")]
    TooLarge { prim: usize },
    #[error("triangle {prim} names vertex {vertex}, but there are {vertices}")]
    NoSuchVertex { prim: usize, vertex: u32, vertices: usize },
    #[error("triangle {prim} and one that is not of its group have a vertex in common")]
    SharedVertex { prim: usize },
    #[error("group {group} is out of order or names what does not exist")]
    BadGroup { group: usize },
    #[error("instance {instance} names a group or a transform that does not exist")]
    BadInstance { instance: usize },
    #[error("instance {instance} reaches beyond {MAX_COORDINATE:e} m")]
    InstanceTooLarge { instance: usize },
    #[error("there is no {what} {index} to be moved")]
    NothingThere { what: &'static str, index: usize },
    #[error("vertex {vertex} would be at no finite place, or beyond {MAX_COORDINATE:e} m")]
    BadVertex { vertex: usize },
    #[error("{count} primitives are more than can be numbered")]
    TooMany { count: usize },
}

impl BuildError {
    /// The primitive that is at fault, where one is.
    pub fn prim(&self) -> Option<usize> {
        match self {
            Self::NotFinite { prim }
            | Self::TooLarge { prim }
            | Self::NoSuchVertex { prim, .. }
            | Self::SharedVertex { prim } => Some(*prim),
            _ => None,
        }
    }

    /// The instance that is at fault, where one is.
    pub fn instance(&self) -> Option<usize> {
        match self {
            Self::BadInstance { instance } | Self::InstanceTooLarge { instance } => Some(*instance),
            _ => None,
        }
    }
}
