//! Files other than the scene's own: what they hold, checked.

mod bare;
pub mod camera_path;
pub mod files;
pub mod gltf;
mod gzip;
pub mod image;
pub mod memory;
pub mod model;
pub mod obj;
pub mod ply;
pub mod points;
pub mod stl;
pub mod store;
mod tangents;

pub use bare::BareMeshError;
pub use files::{ContentHash, Files};
pub use gltf::GltfError;
pub use memory::{MemoryBudget, MemoryKind, OverBudget};
pub use store::{AssetError, Store};
