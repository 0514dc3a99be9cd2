//! What is traced: triangles, shapes and meshes that stand in the world many times, how they are numbered, what is refused,
//! and what a hit is.
//!
//! A hit counts inside its primitive's own box: the module `slab` says why that is needed, and why it is enough.

mod arrays;
pub(crate) mod check;
mod edit;
mod error;
mod ids;
pub(crate) mod padding;
pub(crate) mod slab;

pub use arrays::{Geometry, GroupInstance, MeshGroup, PlacedShape};
pub use edit::Edit;
pub use error::{BuildError, MAX_COORDINATE};
pub use ids::{Hit, InstanceId, PrimId};
pub use padding::MAX_MAGNIFICATION;
