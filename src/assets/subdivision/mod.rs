//! Subdivision surfaces: meshes whose faces are refined to a smooth surface, and their displacement.
//!
//! The rules are those of OpenSubdiv. Texture coordinates are as smooth but for seams and boundaries, which stay
//! (`FVAR_LINEAR_BOUNDARIES`, as in Blender); colours are interpolated linearly. Boundaries are smooth curves
//! (`VTX_BOUNDARY_EDGE_ONLY`, as in Blender) or have corners as well (`VTX_BOUNDARY_EDGE_AND_CORNER`). The vertices that are
//! left in the end are on the limit surface.
//!
//! `topology` refines faces and edges, `rules` the positions; `cage` makes a surface of meshes, `displaced` moves it, `triangles`
//! makes meshes of it, and `of_model` does so for the meshes of a model.

mod cage;
mod displaced;
mod of_model;
mod rules;
mod sets;
mod surface;
#[cfg(test)]
mod tests;
mod topology;
mod triangles;

pub use of_model::{SubdivisionProblem, subdivide};
