//! Primitives to meshes.

use std::collections::HashMap;

use ::gltf::json::{
    mesh::{Mode, Primitive, Semantic},
    validation::Checked,
};

use super::{document::Document, error::GltfProblem};
use crate::{
    math::{Vec2, Vec3},
    shape::mesh::Mesh,
};

/// The identity of a mesh: primitives that name the same arrays share one mesh.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Key {
    mode: u32,
    indices: Option<usize>,
    positions: usize,
    normals: Option<usize>,
    uvs: Option<usize>,
}

/// The meshes so far.
#[derive(Default)]
pub(super) struct Meshes {
    pub meshes: Vec<Mesh>,
    known: HashMap<Key, Option<usize>>,
}

impl Meshes {
    /// The number of a primitive's mesh; `None` where it has no triangles. `uv_set` is the set of texture coordinates
    /// that its material reads.
    pub fn place(
        &mut self,
        document: &Document<'_>,
        primitive: &Primitive,
        uv_set: u32,
        what: &str,
    ) -> Result<Option<usize>, GltfProblem> {
        let Checked::Valid(mode) = primitive.mode else {
            return Err(GltfProblem::broken(format!("{what} has an unknown mode")));
        };
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|a| a.value());
        let Some(positions) = attribute(Semantic::Positions) else {
            tracing::warn!("{what} has no positions and is left out");
            return Ok(None);
        };
        let key = Key {
            mode: mode.as_gl_enum(),
            indices: primitive.indices.map(|i| i.value()),
            positions,
            normals: attribute(Semantic::Normals),
            uvs: attribute(Semantic::TexCoords(uv_set)),
        };
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let mesh = mesh(document, &key, mode).map_err(|e| e.within(what))?;
        let at = (!mesh.triangles.is_empty()).then(|| {
            self.meshes.push(mesh);
            self.meshes.len() - 1
        });
        self.known.insert(key, at);
        Ok(at)
    }
}

fn mesh(document: &Document<'_>, key: &Key, mode: Mode) -> Result<Mesh, GltfProblem> {
    let count = document.count(key.positions)?;
    let indices = match key.indices {
        Some(indices) => document.indices(indices)?,
        None => {
            document.reserve(4 * count as u64)?;
            // An accessor's bytes are checked before their number is believed.
            let positions = document.floats::<3>(key.positions)?.len();
            (0..u32::try_from(positions).map_err(|_| GltfProblem::broken("more than 2^32 vertices"))?).collect()
        }
    };
    let triangles = triangles(mode, &indices);
    if triangles.is_empty() {
        return Ok(Mesh::default());
    }
    let vec3 = |index| -> Result<Vec<Vec3>, GltfProblem> {
        Ok(document.floats::<3>(index)?.into_iter().map(Vec3::from_array).collect())
    };
    let normals = key.normals.map(vec3).transpose()?.unwrap_or_default();
    let uvs = match key.uvs {
        // glTF's v runs downwards.
        Some(index) => document
            .floats::<2>(index)?
            .into_iter()
            .map(|[u, v]| Vec2::new(u, 1.0 - v))
            .collect(),
        None => Vec::new(),
    };
    let mesh = Mesh {
        positions: vec3(key.positions)?,
        triangles,
        // A normal that is none is left to the face's.
        normals: normals.into_iter().map(Vec3::normalize_or_zero).collect(),
        uvs,
    };
    mesh.validate().map_err(GltfProblem::broken)?;
    Ok(mesh)
}

fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    let triple = |t: &[u32]| [t[0], t[1], t[2]];
    match mode {
        Mode::Triangles => indices.chunks_exact(3).map(triple).collect(),
        // Every other triangle of a strip is wound the other way round.
        Mode::TriangleStrip => (indices.windows(3).map(triple).enumerate())
            .map(|(i, [a, b, c])| if i % 2 == 0 { [a, b, c] } else { [b, a, c] })
            .collect(),
        Mode::TriangleFan => {
            let first = indices.first().copied().unwrap_or_default();
            let rest = indices.get(1..).unwrap_or_default();
            rest.windows(2).map(|w| [first, w[0], w[1]]).collect()
        }
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        let i = [0, 1, 2, 3, 4];
        assert_eq!(triangles(Mode::Triangles, &i), [[0, 1, 2]]);
        assert_eq!(triangles(Mode::TriangleStrip, &i), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
        assert_eq!(triangles(Mode::TriangleFan, &i), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        for mode in [Mode::TriangleFan, Mode::TriangleStrip, Mode::Triangles] {
            assert!(triangles(mode, &i[..2]).is_empty() && triangles(mode, &[]).is_empty());
        }
    }
}
