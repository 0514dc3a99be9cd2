//! Deformation of a document's meshes by skins and morph targets.
//!
//! Source: Khronos, "glTF 2.0 Specification", sections 3.7.2.2 and 3.7.3.

use std::cell::OnceCell;

use ::gltf::json::{
    mesh::{MorphTarget as TargetAccessors, Primitive, Semantic},
    scene::Node,
    validation::Checked,
};
use glam::DAffine3;

use super::{
    document::{Document, get},
    error::GltfProblem,
    moving::Moving,
    nodes::PlacedNode,
    textures::UvSets,
};
use crate::{
    assets::{
        model::UvSet,
        motion::{Deform, Influences, MeshShape, MorphTarget, Skin},
    },
    math::Vec3,
    shape::mesh::Mesh,
};

/// A primitive with its node.
pub(super) struct PrimitiveUse<'a> {
    pub primitive: &'a Primitive,
    /// The numbers of its node, its mesh, and itself in the mesh.
    pub node: usize,
    pub mesh: usize,
    pub index: usize,
    pub uv_sets: UvSets,
    /// The texture coordinates for tangents, if the material needs tangents.
    pub tangents: Option<UvSet>,
}

/// The nodes of a document with their transforms.
pub(super) struct Pose<'a> {
    nodes: &'a [Node],
    placed: &'a [PlacedNode],
    pub moving: &'a Moving,
    skins: Vec<OnceCell<Skin>>,
}

impl<'a> Pose<'a> {
    pub fn new(document: &'a Document<'_>, placed: &'a [PlacedNode], moving: &'a Moving) -> Self {
        Self {
            nodes: &document.root.nodes,
            placed,
            moving,
            skins: document.root.skins.iter().map(|_| OnceCell::new()).collect(),
        }
    }

    /// The skin of a node.
    pub fn skin(&self, node: usize) -> Option<usize> {
        self.nodes[node].skin.map(|s| s.value())
    }

    /// The skins that were used so far; others have no joints.
    pub fn into_skins(self) -> Vec<Skin> {
        let skin = |cell: OnceCell<Skin>| cell.into_inner().unwrap_or(Skin { joints: Vec::new() });
        self.skins.into_iter().map(skin).collect()
    }

    /// The weights of the morph targets at rest, and whether they are the node's own.
    pub fn weights(&self, document: &Document<'_>, used: &PrimitiveUse<'_>) -> (Vec<f32>, bool) {
        let own = self.nodes[used.node].weights.as_ref();
        let weights = own.or(document.root.meshes[used.mesh].weights.as_ref());
        (weights.cloned().unwrap_or_default(), own.is_some())
    }

    /// Whether the played animations deform a primitive.
    pub fn deforms(&self, document: &Document<'_>, used: &PrimitiveUse<'_>) -> Result<bool, GltfProblem> {
        let (_, has_own) = self.weights(document, used);
        let has_targets = used.primitive.targets.as_ref().is_some_and(|t| !t.is_empty());
        if has_targets && self.moving.is_weighted(used.node, used.mesh, has_own) {
            return Ok(true);
        }
        Ok(match self.skin(used.node) {
            Some(skin) => {
                let joints = &self.joints(document, skin)?.joints;
                joints.iter().any(|(node, _)| self.moving.moves(*node))
            }
            None => false,
        })
    }

    /// Applies morph targets and skinning to a mesh.
    pub fn bend(&self, document: &Document<'_>, used: &PrimitiveUse<'_>, mesh: &mut Mesh) -> Result<(), GltfProblem> {
        let deform = self.deform(document, used, mesh.positions.len())?;
        let deform = Deform {
            base: MeshShape::take(mesh),
            ..deform
        };
        let joints = self.skin(used.node).map(|skin| self.rest_joints(document, skin));
        let (weights, _) = self.weights(document, used);
        deform.shape(&weights, joints.transpose()?.as_deref()).apply(mesh);
        Ok(())
    }

    /// The joints of a skin.
    pub fn joints(&self, document: &Document<'_>, index: usize) -> Result<&Skin, GltfProblem> {
        let skin = get(&document.root.skins, index, "skin")?;
        let cell = &self.skins[index];
        if cell.get().is_none() {
            let inverse = match skin.inverse_bind_matrices {
                Some(accessor) => document.matrices(accessor.value())?,
                None => vec![DAffine3::IDENTITY; skin.joints.len()],
            };
            if inverse.len() < skin.joints.len() {
                return Err(GltfProblem::broken(format!(
                    "skin {index} has fewer inverse bind matrices than joints"
                )));
            }
            let place = |joint: usize| {
                let found = self.moving.place_of(joint);
                found.ok_or_else(|| GltfProblem::broken(format!("joint {joint} of skin {index} is not in the scene")))
            };
            let joints = skin.joints.iter().zip(inverse);
            let joints: Result<Vec<_>, _> = joints.map(|(j, inverse)| Ok((place(j.value())?, inverse))).collect();
            let _ = cell.set(Skin { joints: joints? });
        }
        Ok(cell.get().expect("it was just set"))
    }

    fn rest_joints(&self, document: &Document<'_>, skin: usize) -> Result<Vec<DAffine3>, GltfProblem> {
        let joints = self.joints(document, skin)?.joints.iter();
        Ok(joints
            .map(|(node, inverse)| self.placed[*node].model_from_node * *inverse)
            .collect())
    }

    /// Reads what deforms a primitive of so many vertices.
    pub fn deform(
        &self,
        document: &Document<'_>,
        used: &PrimitiveUse<'_>,
        vertices: usize,
    ) -> Result<Deform, GltfProblem> {
        let targets = used.primitive.targets.iter().flatten();
        let influences = match self.skin(used.node) {
            Some(skin) => Some(influences(
                document,
                used.primitive,
                (vertices, self.joints(document, skin)?.joints.len()),
            )?),
            None => None,
        };
        Ok(Deform {
            base: MeshShape::default(),
            targets: targets
                .map(|target| morph_target(document, target, vertices))
                .collect::<Result<_, _>>()?,
            influences,
        })
    }
}

/// Reads the joints of a primitive of so many vertices, of a skin of so many joints.
fn influences(
    document: &Document<'_>,
    primitive: &Primitive,
    (vertices, count): (usize, usize),
) -> Result<Influences, GltfProblem> {
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|a| a.value());
    let mut sets = Vec::new();
    for set in 0.. {
        let found = (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set)));
        let (Some(joints), Some(weights)) = found else {
            break;
        };
        let (joints, weights) = (document.floats::<4>(joints)?, document.floats::<4>(weights)?);
        if joints.len() != vertices || weights.len() != vertices {
            return Err(GltfProblem::broken(
                "the numbers of joints or weights differ from the number of vertices",
            ));
        }
        sets.push((joints, weights));
    }
    let per_vertex = 4 * sets.len();
    document.reserve((size_of::<(u32, f32)>() * per_vertex * vertices) as u64)?;
    let mut influences = Vec::with_capacity(per_vertex * vertices);
    for vertex in 0..vertices {
        for (joints, weights) in &sets {
            for (joint, weight) in joints[vertex].into_iter().zip(weights[vertex]) {
                if weight == 0.0 || !weight.is_finite() {
                    influences.push((0, 0.0));
                    continue;
                }
                if joint as usize >= count {
                    return Err(GltfProblem::broken(format!(
                        "there is no joint {joint}, there are {count}"
                    )));
                }
                influences.push((joint as u32, weight));
            }
        }
    }
    Ok(Influences {
        per_vertex,
        joints: influences,
    })
}

fn morph_target(
    document: &Document<'_>,
    target: &TargetAccessors,
    vertices: usize,
) -> Result<MorphTarget, GltfProblem> {
    let read = |accessor: Option<usize>| -> Result<Vec<Vec3>, GltfProblem> {
        let moves = accessor.map_or(Ok(Vec::new()), |accessor| document.vectors(accessor))?;
        if accessor.is_some() && moves.len() != vertices {
            return Err(GltfProblem::broken(
                "a morph target has more or fewer elements than there are vertices",
            ));
        }
        Ok(moves)
    };
    Ok(MorphTarget {
        positions: read(target.positions.map(|a| a.value()))?,
        normals: read(target.normals.map(|a| a.value()))?,
        tangents: read(target.tangents.map(|a| a.value()))?,
    })
}
