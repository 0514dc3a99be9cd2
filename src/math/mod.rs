//! Numbers: the floor everything else stands on. Nothing here knows about scenes or files.

pub mod aabb;
pub mod block;
mod color_conversion;
pub mod cone;
pub mod daabb;
pub mod distribution;
mod divisor;
mod error_function;
pub mod exponential;
pub mod float;
pub mod frame;
pub mod hash;
pub mod keys;
pub mod origin;
pub mod parallel;
pub mod ray;
pub mod rgb;
mod runs;
mod sidedness;
pub mod srgb;
pub mod track;
pub mod transform;
pub mod trig;
mod unit_float;
mod vector;
pub mod warp;
mod working_space;

pub use aabb::Aabb;
pub use color_conversion::{ColorConversion, Primaries};
pub use cone::RayCone;
pub use daabb::DAabb;
pub use divisor::Divisor;
pub use error_function::erfcx;
pub use frame::Frame;
pub use glam::{DAffine2, DAffine3, DMat2, DMat3, DVec2, DVec3, Vec2, Vec3, Vec4};
pub use ray::Ray;
pub use rgb::Rgb;
pub use runs::Runs;
pub use sidedness::Sidedness;
pub use transform::Transform;
pub use unit_float::UnitFloat;
#[cfg(test)]
pub use vector::Plain;
pub use vector::{Dispatch, VectorLoop};
pub use warp::Sample2D;
pub use working_space::WorkingSpace;
