//! Jobs: which frames, from what, to where.

pub mod range;
