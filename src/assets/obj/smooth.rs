//! Normals of smoothing groups: faces of a group share normals at common positions.

use std::collections::HashMap;

use crate::{
    math::{DVec3, Vec3},
    shape::mesh::Mesh,
};

/// Sums of a group's face normals at each position, by the group's number.
#[derive(Default)]
pub(super) struct Groups(HashMap<(u32, [u32; 3]), DVec3>);

fn key(group: u32, p: Vec3) -> (u32, [u32; 3]) {
    // Adding 0 turns -0 into 0.
    (group, (p + 0.0).to_array().map(f32::to_bits))
}

impl Groups {
    /// Adds the faces of a mesh, weighted by their angles at the corner, so that the triangulation does not matter.
    ///
    /// Source: Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal Facets", JGT 3(1), 1998,
    /// doi:10.1080/10867651.1998.10487487.
    pub fn add(&mut self, group: u32, mesh: &Mesh) {
        let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
        for (i, triangle) in mesh.triangles.iter().enumerate() {
            let corners = mesh.corners(i).map(|p| p.as_dvec3());
            let [a, b, c] = corners;
            let Some(normal) = (b - a).cross(c - a).try_normalize() else {
                continue;
            };
            for k in 0..3 {
                let (e, f) = (corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
                let angle = libm::atan2(e.cross(f).length(), e.dot(f));
                sums[triangle[k] as usize] += normal * angle;
            }
        }
        for (p, sum) in mesh.positions.iter().zip(sums) {
            *self.0.entry(key(group, *p)).or_default() += sum;
        }
    }

    /// A normal for each vertex; 0 where the faces' normals cancel.
    pub fn normals(&self, group: u32, mesh: &Mesh) -> Vec<Vec3> {
        let normal = |p: &Vec3| {
            let sum = self.0.get(&key(group, *p)).copied().unwrap_or_default();
            sum.normalize_or_zero().as_vec3()
        };
        mesh.positions.iter().map(normal).collect()
    }
}
