//! Tests that start the program, or make scenes by the library, in temporary folders: one test program, so that it is linked once.

#[path = "../common/mod.rs"]
mod common;

mod adaptive;
mod animation;
mod assignment;
mod batches;
mod bits;
mod bump;
mod cells;
mod chunks;
mod cli;
mod closed_room;
mod components;
mod copies;
mod cryptomatte;
mod cube;
mod datasets;
mod denoise;
#[cfg(unix)]
mod denoise_jobs;
mod docs;
mod encodings;
mod far;
mod far_uvs;
mod farm;
mod float_pictures;
mod hostile;
mod instances;
mod interrupts;
mod job;
mod job_ends;
mod layers;
mod materials;
mod media;
mod merge;
mod messages;
mod model;
mod model_lights;
mod model_values;
mod motion;
mod normals;
mod outputs;
mod parts;
mod path;
mod points;
mod preview;
mod readme;
mod resume;
mod rounds;
mod sight;
mod targets;
mod textures;
mod values;
mod whitted;
mod working_space;
