//! Morph targets and skinning.
//!
//! Source: Khronos, "glTF 2.0 Specification", sections 3.7.2.2 and 3.7.3.

use glam::{DAffine3, DMat3, DVec3};

use crate::{
    math::{Vec3, Vec4, parallel},
    shape::mesh::Mesh,
};

/// The displacements of a morph target for each vertex; arrays may be empty.
#[derive(Clone, Debug, Default)]
pub struct MorphTarget {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub tangents: Vec<Vec3>,
}

/// The joints of each vertex.
#[derive(Clone, Debug, Default)]
pub struct Influences {
    /// The number of joints of a vertex.
    pub per_vertex: usize,
    /// A joint of the skin and its weight. Those without a weight are of joint 0.
    pub joints: Vec<(u32, f32)>,
}

/// The vertices of a mesh before it is deformed, and what deforms it.
#[derive(Clone, Debug, Default)]
pub struct Deform {
    pub base: MeshShape,
    pub targets: Vec<MorphTarget>,
    pub influences: Option<Influences>,
}

/// The arrays of a mesh that are deformed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshShape {
    pub positions: Vec<Vec3>,
    /// See [`Mesh::normals`].
    pub normals: Vec<Vec3>,
    /// See [`Mesh::tangents`].
    pub tangents: Vec<Vec4>,
}

impl MeshShape {
    /// Takes the arrays of a mesh.
    pub fn take(mesh: &mut Mesh) -> Self {
        Self {
            positions: std::mem::take(&mut mesh.positions),
            normals: std::mem::take(&mut mesh.normals),
            tangents: std::mem::take(&mut mesh.tangents),
        }
    }

    /// A copy of the arrays of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        Self {
            positions: mesh.positions.clone(),
            normals: mesh.normals.clone(),
            tangents: mesh.tangents.clone(),
        }
    }

    /// Replaces the arrays of a mesh.
    pub fn apply(self, mesh: &mut Mesh) {
        mesh.positions = self.positions;
        mesh.normals = self.normals;
        mesh.tangents = self.tangents;
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.positions[..]) + size_of_val(&self.normals[..]) + size_of_val(&self.tangents[..])
    }
}

impl MorphTarget {
    fn add(&self, weight: f32, shape: &mut MeshShape) {
        let add = |to: &mut Vec3, by: &Vec3| *to += *by * weight;
        for (to, by) in shape.positions.iter_mut().zip(&self.positions) {
            add(to, by);
        }
        for (to, by) in shape.normals.iter_mut().zip(&self.normals) {
            add(to, by);
        }
        for (to, by) in shape.tangents.iter_mut().zip(&self.tangents) {
            let along = to.truncate() + *by * weight;
            *to = along.extend(to.w);
        }
    }
}

impl Influences {
    /// The transform of a vertex by its joints.
    fn matrix(&self, vertex: usize, joints: &[DAffine3]) -> DAffine3 {
        let mut sum = (DAffine3::ZERO, 0.0);
        for &(joint, weight) in &self.joints[vertex * self.per_vertex..][..self.per_vertex] {
            if weight == 0.0 || !weight.is_finite() {
                continue;
            }
            let (matrix, weight) = (&joints[joint as usize], f64::from(weight));
            sum.0.matrix3 += matrix.matrix3 * weight;
            sum.0.translation += matrix.translation * weight;
            sum.1 += weight;
        }
        let (matrix, weight) = sum;
        // Normalises weights, which exporters have rounded.
        if weight > 0.0 {
            DAffine3 {
                matrix3: matrix.matrix3 * weight.recip(),
                translation: matrix.translation / weight,
            }
        } else {
            DAffine3 {
                matrix3: DMat3::IDENTITY,
                translation: DVec3::ZERO,
            }
        }
    }
}

impl Deform {
    /// The bytes of its arrays.
    pub fn bytes(&self) -> u64 {
        let vectors = |v: &[Vec3]| size_of_val(v);
        let target = |t: &MorphTarget| vectors(&t.positions) + vectors(&t.normals) + vectors(&t.tangents);
        let joints = self.influences.as_ref().map_or(0, |i| size_of_val(&i.joints[..]));
        (self.base.bytes() + self.targets.iter().map(target).sum::<usize>() + joints) as u64
    }

    /// The same with vertex `i` taken from `vertices[i]`. Moves that are not finite become 0.
    pub fn gathered(mut self, vertices: &[u32]) -> Self {
        fn gather<T: Copy>(values: &mut Vec<T>, vertices: &[u32], each: usize) {
            if !values.is_empty() {
                let of = |v: &u32| values[*v as usize * each..][..each].iter().copied();
                *values = vertices.iter().flat_map(of).collect();
            }
        }
        for target in &mut self.targets {
            gather(&mut target.positions, vertices, 1);
            gather(&mut target.normals, vertices, 1);
            gather(&mut target.tangents, vertices, 1);
            let moves = target.positions.iter_mut().chain(&mut target.normals);
            let moves = moves.chain(&mut target.tangents).filter(|v| !v.is_finite());
            moves.for_each(|v| *v = Vec3::ZERO);
        }
        if let Some(influences) = &mut self.influences {
            gather(&mut influences.joints, vertices, influences.per_vertex);
        }
        self
    }

    /// The vertices with these weights of the targets and these transforms of the joints.
    pub fn shape(&self, weights: &[f32], joints: Option<&[DAffine3]>) -> MeshShape {
        let mut shape = self.base.clone();
        let targets = self.targets.iter().zip(weights);
        let shown: Vec<_> = targets.filter(|(_, w)| **w != 0.0 && w.is_finite()).collect();
        for (target, weight) in &shown {
            target.add(**weight, &mut shape);
        }
        shape.normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        if shown.iter().any(|(target, _)| !target.tangents.is_empty()) {
            let unit = |t: &mut Vec4| *t = t.truncate().normalize_or_zero().extend(t.w);
            shape.tangents.iter_mut().for_each(unit);
        }
        if let (Some(influences), Some(joints)) = (&self.influences, joints) {
            shape.bend(|vertex| influences.matrix(vertex, joints));
        }
        shape
    }
}

impl MeshShape {
    /// Transforms each vertex by its own matrix.
    fn bend(&mut self, matrix: impl Fn(usize) -> DAffine3 + Sync) {
        let matrices = parallel::table(self.positions.len(), matrix);
        parallel::update(&mut self.positions, |i, p| {
            *p = matrices[i].transform_point3(p.as_dvec3()).as_vec3();
        });
        parallel::update(&mut self.normals, |i, n| {
            let m = matrices[i].matrix3;
            let normals = DMat3::from_cols(
                m.y_axis.cross(m.z_axis),
                m.z_axis.cross(m.x_axis),
                m.x_axis.cross(m.y_axis),
            );
            *n = (normals * n.as_dvec3()).normalize_or_zero().as_vec3();
        });
        parallel::update(&mut self.tangents, |i, t| {
            let along = (matrices[i].matrix3 * t.truncate().as_dvec3()).normalize_or_zero();
            *t = along.as_vec3().extend(t.w);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_between_two_joints_equals_the_weighted_mean_of_both() {
        let deform = Deform {
            base: MeshShape {
                positions: vec![Vec3::X, Vec3::Y],
                normals: vec![Vec3::Y; 2],
                tangents: vec![Vec4::new(1.0, 0.0, 0.0, -1.0); 2],
            },
            targets: vec![MorphTarget {
                positions: vec![Vec3::X; 2],
                normals: vec![Vec3::X - Vec3::Y; 2],
                tangents: vec![Vec3::Z - Vec3::X; 2],
            }],
            influences: Some(Influences {
                per_vertex: 2,
                joints: vec![(0, 0.25), (1, 0.75), (0, 0.0), (1, 3.0)],
            }),
        };
        let joints = [
            DAffine3::from_translation(DVec3::Z * 4.0),
            DAffine3::from_scale(DVec3::new(2.0, 2.0, 2.0)),
        ];
        let shape = deform.shape(&[0.0], Some(&joints));
        assert_eq!(shape.positions, [Vec3::new(1.75, 0.0, 1.0), Vec3::Y * 2.0]);
        assert_eq!(shape.normals, [Vec3::Y; 2]);
        // The target moves the vertex, the normal and the tangent, which joints move after it.
        let shape = deform.shape(&[1.0], Some(&joints));
        assert_eq!(shape.positions, [Vec3::new(3.5, 0.0, 1.0), Vec3::new(2.0, 2.0, 0.0)]);
        assert_eq!(shape.normals, [Vec3::X; 2]);
        assert_eq!(shape.tangents, [Vec4::new(0.0, 0.0, 1.0, -1.0); 2]);
        let twice = deform.clone().gathered(&[1, 1, 0]);
        assert_eq!(twice.influences.map(|i| i.joints[4]), Some((0, 0.25)));
    }
}
