//! Acceleration structures for ray casting.
//!
//! Rays are traced in batches, since batches are what makes tracing fast; no method takes a single
//! ray. All accelerators return the same bits. A hit's `t`, `u` and `v` come from the primitive's
//! one scalar routine, or from the same operations in the same order. Of two hits at the same `t`,
//! the primitive with the lower id wins. A box is culled only if it lies strictly farther than the
//! nearest hit so far. A hit is clipped to the bounds of its primitive (the module `slab` explains
//! why this is needed and why it is enough).
//!
//! | kind | what it is |
//! |---|---|
//! | `linear` | every primitive for every ray: the ground truth |
//! | `bvh2` | a binary tree and a scalar traversal |
//! | `wide` | an eight-wide tree and kernels for many rays at once: the default |

use std::sync::Arc;

use crate::{
    geometry::{BuildError, Geometry},
    simd::Isa,
};

mod accelerator;
mod build;
mod bvh2;
mod kernels;
mod linear;
#[cfg(test)]
mod tests;
mod wide;

pub use accelerator::{AccelKind, Accelerator, BatchLayout, BuildStats, RayBatch, RayCost, TreeId, UpdateReport};

/// The kind of accelerator and the SIMD level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildOptions {
    pub kind: AccelKind,
    pub simd: Isa,
}

impl From<AccelKind> for BuildOptions {
    /// Selects the best SIMD level of this processor.
    fn from(kind: AccelKind) -> Self {
        Self {
            kind,
            ..Self::default()
        }
    }
}

/// Builds an accelerator.
pub fn build(options: impl Into<BuildOptions>, geometry: Arc<Geometry>) -> Result<Box<dyn Accelerator>, BuildError> {
    let BuildOptions { kind, simd } = options.into();
    Ok(match kind {
        AccelKind::Linear => Box::new(linear::Linear::build(geometry, simd)?),
        AccelKind::Bvh2 => Box::new(bvh2::Bvh2::build(geometry, simd)?),
        AccelKind::Wide => Box::new(wide::Wide::build(geometry, simd)?),
    })
}

/// The most memory that [`build()`] takes, in bytes, measured with millions of spheres, triangles and instances.
pub fn build_bytes(geometry: &Geometry) -> u64 {
    const OF_PRIMITIVE: u64 = 210;
    const OF_INSTANCE: u64 = 340;
    geometry.prim_count() as u64 * OF_PRIMITIVE + geometry.instances.len() as u64 * OF_INSTANCE
}

/// A wide accelerator with the kernels of one SIMD level.
pub type AtLevel = (Isa, Box<dyn Accelerator>);

/// Builds one tree and returns it with the kernels of every SIMD level of this processor.
pub fn build_wide_levels(geometry: &Arc<Geometry>) -> Result<Vec<AtLevel>, BuildError> {
    let tree = wide::Wide::build(Arc::clone(geometry), Isa::best())?;
    let levels = Isa::available().into_iter();
    Ok(levels
        .map(|simd| (simd, Box::new(tree.with(simd)) as Box<dyn Accelerator>))
        .collect())
}
