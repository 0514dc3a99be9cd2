//! Where a mesh stands: its corners and normals in another space.

use glam::{DAffine3, DMat3};
use rayon::prelude::*;

use super::meshes::MIN_LEN;
use crate::{math::Vec3, shape::mesh::Mesh};

/// Whether a triangle is one.
pub(super) fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    let a = a.as_dvec3();
    // What is not a number is for the acceleration structure to refuse.
    (b.as_dvec3() - a).cross(c.as_dvec3() - a).length_squared() != 0.0
}

/// Where a mesh stands, and what its normals become.
pub(super) struct Place {
    world_from_mesh: DAffine3,
    /// The inverse transpose times the determinant's magnitude: it exists for flattened meshes too.
    normals: DMat3,
    /// Whether the order of corners must change for the front to stay the front.
    pub mirrors: bool,
}

impl Place {
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
        }
    }

    pub fn points<'a>(&'a self, mesh: &'a Mesh) -> impl IndexedParallelIterator<Item = Vec3> + 'a {
        let is_identity = self.world_from_mesh == DAffine3::IDENTITY;
        mesh.positions.par_iter().with_min_len(MIN_LEN).map(move |p| {
            if is_identity {
                *p
            } else {
                self.world_from_mesh.transform_point3(p.as_dvec3()).as_vec3()
            }
        })
    }

    pub fn normal(&self, n: Vec3) -> Vec3 {
        (self.normals * n.as_dvec3()).normalize_or_zero().as_vec3()
    }
}
