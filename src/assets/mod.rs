//! Asset files: models, images, IES files and camera paths, read and validated. Meshes are subdivided and displaced here.

mod asset_error;
mod bare;
pub mod camera_path;
pub mod displacement;
mod edited;
pub mod files;
pub mod gltf;
mod gzip;
mod heights;
pub mod ies;
pub mod image;
mod load_model;
pub mod memory;
pub mod model;
pub mod model_format;
pub mod model_formats;
pub mod motion;
pub mod obj;
pub mod ply;
pub mod points;
mod repair;
pub mod stl;
pub mod store;
mod subdivision;
mod tangents;
mod views;

pub use asset_error::AssetError;
pub use files::{ContentHash, Files, SuppliedFile};
pub use memory::{MemoryBudget, MemoryKind, OverBudget};
pub use store::Store;
