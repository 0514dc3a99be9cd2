//! Conversion of primitives to meshes.

use std::collections::HashMap;

use ::gltf::json::{
    mesh::{Mode, Semantic},
    validation::Checked,
};

use super::{
    document::Document,
    error::GltfProblem,
    pose::{Pose, PrimitiveUse},
};
use crate::{
    assets::{
        model::{Model, Treatment, UvSet},
        motion::{Deform, MeshMotion, MeshShape},
        repair::{Repairs, repair},
        tangents,
    },
    math::{DVec2, Vec2, Vec3, Vec4},
    shape::mesh::{Mesh, Polygons, around_origin},
};

/// The identity of a mesh: primitives that name the same arrays in the same shape share one mesh.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Key {
    mode: u32,
    indices: Option<usize>,
    attributes: Attributes,
    deformed: Option<Deformed>,
    /// The texture coordinates for new tangents, if the file has no tangents.
    new_tangents: Option<UvSet>,
}

/// The accessors of a primitive that are read.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Attributes {
    pub positions: usize,
    pub normals: Option<usize>,
    pub tangents: Option<usize>,
    pub uvs: Option<usize>,
    pub second_uvs: Option<usize>,
    pub colors: Option<usize>,
}

/// A primitive that its node deforms. Its mesh is not shared.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Deformed {
    node: usize,
    mesh: usize,
    primitive: usize,
}

/// A mesh of the model.
pub(super) struct PlacedMesh {
    pub index: usize,
    pub has_colors: bool,
    /// Whether it is in the space of the model, not in that of its node.
    pub is_skinned: bool,
}

/// The meshes so far.
#[derive(Default)]
pub(super) struct Meshes {
    pub meshes: Vec<Mesh>,
    pub repairs: Repairs,
    /// The motion of those that deform.
    pub motions: Vec<MeshMotion>,
    known: HashMap<Key, Option<usize>>,
}

impl Meshes {
    /// The mesh of a primitive; `None` if it has no triangles, which is reported to `model`.
    pub fn place(
        &mut self,
        document: &Document<'_>,
        used: &PrimitiveUse<'_>,
        pose: &Pose<'_>,
        model: &mut Model,
    ) -> Result<Option<PlacedMesh>, GltfProblem> {
        let PrimitiveUse { primitive, uv_sets, .. } = used;
        let what = format!("primitive {} of mesh {}", used.index, used.mesh);
        let Checked::Valid(mode) = primitive.mode else {
            return Err(GltfProblem::broken(format!("{what} has an unknown mode")));
        };
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|a| a.value());
        let Some(positions) = attribute(Semantic::Positions) else {
            model.add_feature("no positions", "primitive", Treatment::Without("it is left out"));
            return Ok(None);
        };
        let shape = match mode {
            Mode::Points => Some("points"),
            Mode::Lines | Mode::LineLoop | Mode::LineStrip => Some("lines"),
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan => None,
        };
        if let Some(shape) = shape {
            model.add_feature(shape, "primitive", Treatment::Without("it is left out"));
        }
        let is_skinned = pose.skin(used.node).is_some();
        let is_bent = is_skinned || primitive.targets.as_ref().is_some_and(|t| !t.is_empty());
        let normals = attribute(Semantic::Normals);
        // Tangents without normals are useless.
        let own_tangents = normals.and_then(|_| attribute(Semantic::Tangents));
        let key = Key {
            mode: mode.as_gl_enum(),
            indices: primitive.indices.map(|i| i.value()),
            attributes: Attributes {
                positions,
                normals,
                tangents: own_tangents,
                uvs: attribute(Semantic::TexCoords(uv_sets.first)),
                second_uvs: uv_sets.second.and_then(|set| attribute(Semantic::TexCoords(set))),
                colors: attribute(Semantic::Colors(0)),
            },
            deformed: is_bent.then_some(Deformed {
                node: used.node,
                mesh: used.mesh,
                primitive: used.index,
            }),
            new_tangents: used.tangents.filter(|_| own_tangents.is_none()),
        };
        let has_colors = key.attributes.colors.is_some();
        let found = match self.known.get(&key) {
            Some(known) => *known,
            None => {
                let mut mesh = mesh(document, &key, mode).map_err(|e| e.within(&what))?;
                let deforms = is_bent && !mesh.triangles.is_empty();
                let deform = match deforms && pose.deforms(document, used)? {
                    true => Some(
                        pose.deform(document, used, mesh.positions.len())
                            .map_err(|e| e.within(&what))?,
                    ),
                    false => None,
                };
                if deforms && deform.is_none() {
                    pose.bend(document, used, &mut mesh).map_err(|e| e.within(&what))?;
                }
                let is_kept = |vertex: &u32| mesh.positions[*vertex as usize].is_finite();
                let mut vertices: Vec<u32> = (0..mesh.positions.len() as u32).filter(is_kept).collect();
                self.repairs += repair(&mut mesh);
                mesh.validate().map_err(|e| GltfProblem::broken(e).within(&what))?;
                if let Some(set) = key.new_tangents {
                    document.reserve(tangents::TRIANGLE_MEMORY * mesh.triangles.len() as u64)?;
                    for vertex in tangents::add(&mut mesh, set) {
                        vertices.push(vertices[vertex as usize]);
                    }
                    mesh.validate().map_err(|e| GltfProblem::broken(e).within(&what))?;
                }
                let at = (!mesh.triangles.is_empty()).then(|| {
                    self.meshes.push(mesh);
                    self.meshes.len() - 1
                });
                if let (Some(deform), Some(mesh)) = (deform, at) {
                    self.motions
                        .extend(self.motion(document, used, pose, (mesh, deform.gathered(&vertices))));
                }
                self.known.insert(key, at);
                at
            }
        };
        Ok(found.map(|index| PlacedMesh {
            index,
            has_colors,
            is_skinned,
        }))
    }

    /// The motion of a mesh, which deforms from now on.
    fn motion(
        &self,
        document: &Document<'_>,
        used: &PrimitiveUse<'_>,
        pose: &Pose<'_>,
        (mesh, deform): (usize, Deform),
    ) -> Option<MeshMotion> {
        let own = &self.meshes[mesh];
        let (weights, has_own_weights) = pose.weights(document, used);
        Some(MeshMotion {
            mesh,
            node: pose.moving.place_of(used.node)?,
            source: used.mesh,
            skin: pose.skin(used.node),
            weights,
            has_own_weights,
            deform: Deform {
                base: MeshShape::of(own),
                ..deform
            },
        })
    }
}

fn mesh(document: &Document<'_>, key: &Key, mode: Mode) -> Result<Mesh, GltfProblem> {
    let Attributes {
        positions,
        normals,
        tangents,
        uvs,
        second_uvs,
        colors,
    } = key.attributes;
    let count = document.count(positions)?;
    let indices = match key.indices {
        Some(indices) => document.indices(indices)?,
        None => {
            document.reserve(4 * count as u64)?;
            // The accessor's bytes are checked before its count is used.
            let positions = document.floats::<3>(positions)?.len();
            (0..u32::try_from(positions).map_err(|_| GltfProblem::broken("more than 2^32 vertices"))?).collect()
        }
    };
    // Unused arrays are checked, too.
    let positions = document.vectors(positions)?;
    let triangles = triangles(mode, &indices);
    let normals = normals.map_or(Ok(Vec::new()), |i| document.vectors(i))?;
    let coordinates = |set: Option<usize>| set.map_or(Ok(Default::default()), |i| coordinates(document, i));
    let ((first_origin, first), (second_origin, second)) = (coordinates(uvs)?, coordinates(second_uvs)?);
    let mesh = Mesh {
        positions,
        // An invalid normal becomes 0, which stands for that of the face.
        normals: normals.into_iter().map(Vec3::normalize_or_zero).collect(),
        uvs: first,
        second_uvs: second,
        uv_origins: [first_origin, second_origin],
        colors: colors.map_or(Ok(Vec::new()), |i| {
            Ok(bounded(vertex_colors(document, i)?, document.largest(i)?))
        })?,
        tangents: match tangents {
            None => Vec::new(),
            Some(index) => document.floats::<4>(index)?.into_iter().map(Vec4::from_array).collect(),
        },
        triangles,
        polygons: Polygons::default(),
    };
    // Including indices that are part of no triangle.
    if let Some(index) = indices.iter().find(|i| **i as usize >= mesh.positions.len()) {
        let vertices = mesh.positions.len();
        return Err(GltfProblem::broken(format!(
            "an index names vertex {index}, but there are only {vertices}"
        )));
    }
    Ok(mesh)
}

/// Reads texture coordinates and their origin; v points down in glTF.
fn coordinates(document: &Document<'_>, accessor: usize) -> Result<(Vec2, Vec<Vec2>), GltfProblem> {
    let pairs = document.floats::<2>(accessor)?;
    let flipped = pairs
        .iter()
        .map(|[u, v]| DVec2::new(f64::from(*u), 1.0 - f64::from(*v)));
    Ok(around_origin(flipped))
}

/// Reads linear colours; those without alpha are opaque.
fn vertex_colors(document: &Document<'_>, accessor: usize) -> Result<Vec<Vec4>, GltfProblem> {
    if document.width(accessor)? == 3 {
        let colors = document.floats::<3>(accessor)?;
        return Ok(colors.into_iter().map(|[r, g, b]| Vec4::new(r, g, b, 1.0)).collect());
    }
    let colors = document.floats::<4>(accessor)?;
    Ok(colors.into_iter().map(Vec4::from_array).collect())
}

/// Colours between 0 and 1, whatever type their numbers have; the lint reports those that the format forbids. What is not
/// finite stays so.
fn bounded(mut colors: Vec<Vec4>, largest: f32) -> Vec<Vec4> {
    for color in colors.iter_mut().filter(|c| c.is_finite()) {
        *color = (*color / largest).clamp(Vec4::ZERO, Vec4::ONE);
    }
    colors
}

fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    let triple = |t: &[u32]| [t[0], t[1], t[2]];
    match mode {
        Mode::Triangles => indices.chunks_exact(3).map(triple).collect(),
        // Every other triangle of a strip has the opposite winding.
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
