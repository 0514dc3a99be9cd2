//! The geometry that rays are traced against: triangles, shapes and instanced meshes, their ids,
//! their validation, and hits.
//!
//! A hit is clipped to the bounds of its primitive; the module `slab` explains why this is needed
//! and why it is enough.

mod arrays;
pub(crate) mod check;
mod edit;
mod error;
mod ids;
pub(crate) mod padding;
pub(crate) mod shape_block;
pub(crate) mod slab;

pub use arrays::{Geometry, GroupInstance, MeshGroup, PlacedShape};
pub use edit::Edit;
pub use error::{BuildError, MAX_COORDINATE};
pub use ids::{Hit, InstanceId, PrimId};
pub use padding::MAX_MAGNIFICATION;
