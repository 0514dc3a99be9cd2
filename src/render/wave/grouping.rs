//! The order of a wave's vertices.

use crate::{
    geometry::{Hit, PrimId},
    material::BatchKind,
    scene::Scene,
};

/// Sorts hits by the kind of block that shades their surfaces.
#[derive(Default)]
pub(super) struct HitGrouping {
    kinds: Vec<BatchKind>,
    indices: Vec<u32>,
    prims: Vec<PrimId>,
}

impl HitGrouping {
    /// Sorts the indices of `hits` and their primitives; those of a kind stay in order. Blocks have lanes for surfaces of one kind,
    /// and compute as much for one of them as for all.
    pub fn sort(
        &mut self,
        scene: &Scene,
        hits: &[Option<Hit>],
        hit_indices: &mut Vec<u32>,
        hit_prims: &mut Vec<PrimId>,
    ) {
        let Self { kinds, indices, prims } = self;
        let kind = |hit: Hit| scene.batch_kind(scene.material_of(&hit));
        kinds.clear();
        kinds.extend(
            hit_indices
                .iter()
                .map(|&i| hits[i as usize].map_or(BatchKind::Alone, kind)),
        );
        let mut places = [0; BatchKind::COUNT];
        for kind in &*kinds {
            places[*kind as usize] += 1;
        }
        let mut first = 0;
        for place in &mut places {
            (*place, first) = (first, first + *place);
        }
        indices.resize(kinds.len(), 0);
        prims.resize(kinds.len(), PrimId::new(0));
        for (k, kind) in kinds.iter().enumerate() {
            let place = &mut places[*kind as usize];
            (indices[*place], prims[*place]) = (hit_indices[k], hit_prims[k]);
            *place += 1;
        }
        std::mem::swap(hit_indices, indices);
        std::mem::swap(hit_prims, prims);
    }
}
