//! Files: what can be loaded.

pub mod image;
