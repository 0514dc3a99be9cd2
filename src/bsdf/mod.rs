//! How light scatters at a surface, by physics.

pub mod fresnel;
