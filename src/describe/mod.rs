//! Descriptions: the parsed form of scene files, with all problems reported together.
//!
//! In a [`SceneDesc`] every value is valid by itself. `compile` checks whether names exist and values fit together, with the same
//! [`Diagnostics`], which point into the file.

mod cell_faults;
mod deserialize;
mod diagnostics;
mod drawn_columns;
mod entity;
mod foreign;
mod frame_time;
mod kind_tables;
mod light_group;
mod moving;
mod names;
mod object_parts;
mod object_transform;
mod overrides;
mod part_tables;
mod parts;
mod placed;
mod quaternions;
mod random;
mod random_file;
mod read;
mod rotation;
mod samples;
mod scene;
mod settings;
mod stage;
mod value_columns;
mod value_sources;
mod values;
mod wording;

pub use diagnostics::{Diagnostics, Source};
pub use entity::Entity;
pub use frame_time::FrameTime;
pub use light_group::{LIGHT_GROUP, LightGroupName};
pub use moving::MovingDesc;
pub use names::FileKind;
pub use object_parts::ObjectPartDesc;
pub use object_transform::TransformDesc;
pub use overrides::{Overrides, number_or_text};
pub use parts::{Part, PartsDesc};
pub use random::{Distribution, DrawDesc, DrawKey, RandomDesc};
pub use read::{Error, load, parse};
pub use samples::{AdaptiveDesc, SamplesDesc};
pub use scene::{BackgroundDesc, LightEntry, MaterialEntry, ObjectDesc, SceneDesc, TextureEntry};
pub use settings::{CRYPTOMATTE_LEVELS, OneOrMany, OutputDesc, RenderDesc, are_cryptomatte_levels};
pub use stage::Stage;
pub use value_columns::edited_parts;
pub use value_sources::ValueSource;
pub use values::{ValueFile, Values, Word};
