//! Samples to pixels, and pixels to what a display shows.

pub mod view;
