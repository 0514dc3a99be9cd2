//! Files other than the scene's own: what they hold, checked.

pub mod camera_path;
pub mod files;
pub mod gltf;
pub mod image;
pub mod memory;
pub mod model;
pub mod obj;
pub mod store;

pub use files::{ContentHash, Files};
pub use gltf::GltfError;
pub use memory::{MemoryBudget, MemoryKind, OverBudget};
pub use store::{AssetError, Store};
