//! Files other than the scene's own: what they hold, checked.

pub mod bitmaps;
pub mod camera_path;
pub mod gltf;
pub mod image;
pub mod model;
pub mod obj;
