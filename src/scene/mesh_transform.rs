//! Transforms of a mesh's vertices and normals.

use glam::{DAffine3, DMat3};

use crate::{
    math::{Vec3, Vec4, parallel},
    shape::mesh::Mesh,
};

/// The triangles of a task.
const TOGETHER: usize = 16384;

/// An affine map of a mesh, possibly mirrored or singular.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshTransform {
    world_from_mesh: DAffine3,
    /// The inverse transpose times the determinant's magnitude, which exists for singular maps too.
    normals: DMat3,
    pub mirrors: bool,
    is_identity: bool,
    keeps_all: bool,
}

impl MeshTransform {
    pub fn new(world_from_mesh: DAffine3) -> Self {
        let m = world_from_mesh.matrix3;
        let mirrors = m.determinant() < 0.0;
        let cofactors = DMat3::from_cols(
            m.y_axis.cross(m.z_axis),
            m.z_axis.cross(m.x_axis),
            m.x_axis.cross(m.y_axis),
        );
        Self {
            world_from_mesh,
            normals: if mirrors { -cofactors } else { cofactors },
            mirrors,
            is_identity: world_from_mesh == DAffine3::IDENTITY,
            keeps_all: false,
        }
    }

    /// The same, which keeps triangles without area: those of meshes that move may have one at another time.
    pub fn keeping_all(self) -> Self {
        Self {
            keeps_all: true,
            ..self
        }
    }

    /// Appends the mesh's vertices to `vertices` and its triangles to `triangles`, except those without area unless all are
    /// kept. The front of a triangle stays its front.
    pub fn append(&self, mesh: &Mesh, vertices: &mut Vec<Vec3>, triangles: &mut Vec<[u32; 3]>) {
        let first = vertices.len();
        vertices.resize(first + mesh.positions.len(), Vec3::ZERO);
        parallel::update(&mut vertices[first..], |i, p| *p = self.point(mesh.positions[i]));
        let shown = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| v + first as u32);
            let corners = [a, b, c].map(|v| vertices[v as usize]);
            (self.keeps_all || has_area(corners)).then_some(if self.mirrors { [a, c, b] } else { [a, b, c] })
        };
        let kept = parallel::map(mesh.triangles.chunks(TOGETHER), |some| -> Vec<_> {
            some.iter().filter_map(shown).collect()
        });
        kept.iter().for_each(|some| triangles.extend(some));
    }

    /// Transforms the position of a vertex.
    pub fn point(&self, p: Vec3) -> Vec3 {
        if self.is_identity {
            p
        } else {
            self.world_from_mesh.transform_point3(p.as_dvec3()).as_vec3()
        }
    }

    pub fn normal(&self, n: Vec3) -> Vec3 {
        (self.normals * n.as_dvec3()).normalize_or_zero().as_vec3()
    }
}

impl MeshTransform {
    /// Transforms a tangent with the side of its bitangent, which a mirroring transform flips.
    pub fn tangent(&self, t: Vec4) -> Vec4 {
        let along = self.world_from_mesh.matrix3 * t.truncate().as_dvec3();
        let side = if self.mirrors { -t.w } else { t.w };
        along.normalize_or_zero().as_vec3().extend(side)
    }
}

fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    let a = a.as_dvec3();
    // The acceleration structure refuses numbers that are not finite.
    (b.as_dvec3() - a).cross(c.as_dvec3() - a).length_squared() != 0.0
}
