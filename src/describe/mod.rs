//! Descriptions: a scene file as it was written, checked value by value, and everything wrong with it at once.
//!
//! Reading ends in a [`SceneDesc`], in which every number is sound by itself; whether names exist and shapes close is
//! for `compile` to say, in the same words: [`Diagnostics`] point into the file.

mod diagnostics;
mod light_group;
mod read;
mod samples;
mod scene;
mod settings;

pub use diagnostics::{Diagnostics, Source};
pub use light_group::LightGroupName;
pub use read::{Error, load, parse};
pub use samples::{AdaptiveDesc, SamplesDesc};
pub use scene::{BackgroundDesc, LightEntry, MaterialEntry, ObjectDesc, SceneDesc, TextureEntry, TransformDesc};
pub use settings::{CRYPTOMATTE_LEVELS, OneOrMany, OutputDesc, RenderDesc, are_cryptomatte_levels};
