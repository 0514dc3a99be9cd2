//! The rest pose of a document's meshes: skins with the joints of the nodes, and morph targets with their weights.
//!
//! Source: Khronos, "glTF 2.0 Specification", sections 3.7.2.2 and 3.7.3.

use std::{cell::OnceCell, collections::HashMap};

use ::gltf::json::{
    mesh::{MorphTarget, Primitive, Semantic},
    scene::Node,
    validation::Checked,
};
use glam::{DAffine3, DMat3, DVec3};

use super::{
    document::{Document, get},
    error::GltfProblem,
    textures::UvSets,
};
use crate::{assets::model::UvSet, math::Vec3, shape::mesh::Mesh};

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
    /// The transforms of the scene's nodes.
    model_from_node: HashMap<usize, DAffine3>,
    /// The matrices of the joints of each skin.
    joints: Vec<OnceCell<Vec<DAffine3>>>,
}

impl<'a> Pose<'a> {
    pub fn new(document: &'a Document<'_>, placed: &[(usize, DAffine3)]) -> Self {
        Self {
            nodes: &document.root.nodes,
            model_from_node: placed.iter().copied().collect(),
            joints: document.root.skins.iter().map(|_| OnceCell::new()).collect(),
        }
    }

    /// The skin of a node.
    pub fn skin(&self, node: usize) -> Option<usize> {
        self.nodes[node].skin.map(|s| s.value())
    }

    /// Applies morph targets and skinning to a mesh.
    pub fn bend(&self, document: &Document<'_>, used: &PrimitiveUse<'_>, mesh: &mut Mesh) -> Result<(), GltfProblem> {
        let own = self.nodes[used.node].weights.as_ref();
        let weights = own.or(document.root.meshes[used.mesh].weights.as_ref());
        let targets = used.primitive.targets.iter().flatten();
        for (target, &weight) in targets.zip(weights.into_iter().flatten()) {
            if weight != 0.0 && weight.is_finite() {
                morph(document, target, weight, mesh)?;
            }
        }
        mesh.normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        if let Some(skin) = self.skin(used.node) {
            self.apply_skin(document, skin, used, mesh)?;
        }
        Ok(())
    }

    fn joints(&self, document: &Document<'_>, index: usize) -> Result<&[DAffine3], GltfProblem> {
        let skin = get(&document.root.skins, index, "skin")?;
        let cell = &self.joints[index];
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
                let found = self.model_from_node.get(&joint).copied();
                found.ok_or_else(|| GltfProblem::broken(format!("joint {joint} of skin {index} is not in the scene")))
            };
            let joints = skin.joints.iter().zip(inverse);
            let joints: Result<Vec<_>, _> = joints.map(|(j, inverse)| Ok(place(j.value())? * inverse)).collect();
            let _ = cell.set(joints?);
        }
        Ok(cell.get().expect("it was just set"))
    }

    fn apply_skin(
        &self,
        document: &Document<'_>,
        skin: usize,
        used: &PrimitiveUse<'_>,
        mesh: &mut Mesh,
    ) -> Result<(), GltfProblem> {
        let matrices = self.joints(document, skin)?;
        let mut sums = vec![(DAffine3::ZERO, 0.0); mesh.positions.len()];
        for set in 0.. {
            let attribute = |semantic| {
                used.primitive
                    .attributes
                    .get(&Checked::Valid(semantic))
                    .map(|a| a.value())
            };
            let (Some(joints), Some(weights)) = (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set)))
            else {
                break;
            };
            let (joints, weights) = (document.floats::<4>(joints)?, document.floats::<4>(weights)?);
            if joints.len() != sums.len() || weights.len() != sums.len() {
                return Err(GltfProblem::broken("there is not a joint for each vertex"));
            }
            for ((sum, joints), weights) in sums.iter_mut().zip(joints).zip(weights) {
                for (joint, weight) in joints.into_iter().zip(weights.map(f64::from)) {
                    if weight == 0.0 || !weight.is_finite() {
                        continue;
                    }
                    let matrix = get(matrices, joint as usize, "joint")?;
                    sum.0.matrix3 += matrix.matrix3 * weight;
                    sum.0.translation += matrix.translation * weight;
                    sum.1 += weight;
                }
            }
        }
        for (i, (matrix, weight)) in sums.into_iter().enumerate() {
            // Normalises weights, which exporters have rounded.
            let (m, t) = if weight > 0.0 {
                (matrix.matrix3 * weight.recip(), matrix.translation / weight)
            } else {
                (DMat3::IDENTITY, DVec3::ZERO)
            };
            mesh.positions[i] = (m * mesh.positions[i].as_dvec3() + t).as_vec3();
            let normals = DMat3::from_cols(
                m.y_axis.cross(m.z_axis),
                m.z_axis.cross(m.x_axis),
                m.x_axis.cross(m.y_axis),
            );
            if let Some(n) = mesh.normals.get_mut(i) {
                *n = (normals * n.as_dvec3()).normalize_or_zero().as_vec3();
            }
            if let Some(tangent) = mesh.tangents.get_mut(i) {
                let along = (m * tangent.truncate().as_dvec3()).normalize_or_zero();
                *tangent = along.as_vec3().extend(tangent.w);
            }
        }
        Ok(())
    }
}

/// Adds `weight` of a morph target.
fn morph(document: &Document<'_>, target: &MorphTarget, weight: f32, mesh: &mut Mesh) -> Result<(), GltfProblem> {
    let add = |to: &mut [Vec3], accessor: usize| {
        let moves = document.vectors(accessor)?;
        if moves.len() != to.len() {
            return Err(GltfProblem::broken("a morph target has not a number for each vertex"));
        }
        to.iter_mut().zip(moves).for_each(|(v, d)| *v += d * weight);
        Ok(())
    };
    if let Some(accessor) = target.positions {
        add(&mut mesh.positions, accessor.value())?;
    }
    if let Some(accessor) = target.normals.filter(|_| !mesh.normals.is_empty()) {
        add(&mut mesh.normals, accessor.value())?;
    }
    Ok(())
}
