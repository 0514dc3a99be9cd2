//! Tabulated albedos of rough surfaces, for multiple scattering and for layers.
//!
//! The facets of [`super::microfacet`] scatter once; light that bounces between them is lost, up to
//! two thirds of the light. Divided by the albedo of white facets, a lobe loses nothing: it is as
//! strong as all bounces together, in the shape of the first. The same albedos share light out
//! between layers. Source: Turquin, "Practical multiple scattering compensation for microfacet
//! models", 2019; Kulla and Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH
//! 2017 course.
//!
//! Each distribution of facets has tables of its own: those of Beckmann lose more light where they are rough, and less where they
//! are smooth. Layers have the facets of GGX alone.
//!
//! Tables are linear between their nodes. That of isotropic facets, which most pictures use, is
//! compiled in: `cargo test --lib write_the_table -- --ignored` writes it. The rows of the others
//! are integrated on first use, in a few milliseconds, always to the same bits. What they say is
//! never less than the truth, so that no light is gained, and more by no more than a hundredth, two
//! of brushed facets at grazing angles (tested).

mod anisotropic;
mod beckmann;
mod brushed;
mod dielectric;
mod integral;
mod isotropic;
mod mean;
mod mirrors;
mod schlick;
mod sheen;
mod table;

pub use dielectric::{ClearAlbedo, ClearFacets, ClearTable, clear};
pub use mean::schlick_mean;
pub use mirrors::MirrorFacets;
pub use schlick::{AlbedoBlock, FacetAlbedo};
pub use sheen::raw_sheen;
