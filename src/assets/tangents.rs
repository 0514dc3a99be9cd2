//! Tangents for normal maps, for files without tangents.
//!
//! Normal maps are baked in the tangent space of M. S. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, which
//! glTF requires too. A vertex whose triangles have different tangents, as along a mirrored seam, is split.

use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};

use super::model::UvSet;
use crate::{
    math::{Vec2, Vec3, Vec4},
    shape::mesh::Mesh,
};

/// Memory for each triangle during the computation, in bytes.
pub(super) const TRIANGLE_MEMORY: u64 = 3 * 100;

/// Numbers with the same bits on every machine.
struct Numbers;

impl Ops for Numbers {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    fn acos(x: f32) -> f32 {
        libm::acos(f64::from(x)) as f32
    }
}

/// A mesh whose corners get tangents.
struct Corners<'a> {
    mesh: &'a Mesh,
    uvs: &'a [Vec2],
    /// The tangent of each corner of each triangle; zero if it has none.
    tangents: Vec<[Vec4; 3]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][corner] as usize
    }
}

impl Geometry<Numbers> for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let own = self.mesh.normals.get(self.vertex(face, corner));
        let own = own.copied().filter(|n| *n != Vec3::ZERO);
        own.unwrap_or_else(|| face_normal(self.mesh, face)).to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[self.vertex(face, corner)].to_array()
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        let encoded = tangent.map(|t| Vec4::from_array(t.tangent_encoded()));
        self.tangents[face][corner] = encoded.filter(|t| t.is_finite()).unwrap_or(Vec4::ZERO);
    }
}

fn face_normal(mesh: &Mesh, face: usize) -> Vec3 {
    let [a, b, c] = mesh.corners(face).map(|p| p.as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

/// Adds tangents along the texture coordinates of `set` to a valid mesh. A mesh without these coordinates is not changed. Returns
/// the vertex that each appended one is a copy of.
pub(super) fn add(mesh: &mut Mesh, set: UvSet) -> Vec<u32> {
    let uvs = match set {
        UvSet::First => &mesh.uvs,
        UvSet::Second => &mesh.second_uvs,
    };
    if !mesh.tangents.is_empty() || uvs.is_empty() {
        return Vec::new();
    }
    let mut corners = Corners {
        mesh,
        uvs,
        tangents: vec![[Vec4::ZERO; 3]; mesh.triangles.len()],
    };
    match generate_tangents(&mut corners) {
        Ok(()) => {
            let tangents = corners.tangents;
            assign(mesh, &tangents)
        }
        Err(_) => Vec::new(),
    }
}

/// Assigns the tangents of all corners to vertices: the first one to the vertex itself, each other to a copy of it.
/// Returns the vertices that are copied.
fn assign(mesh: &mut Mesh, tangents: &[[Vec4; 3]]) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let first_copy = mesh.positions.len();
    mesh.tangents = vec![Vec4::ZERO; first_copy];
    // The copies of a vertex are a linked list.
    let mut next = vec![NONE; first_copy];
    let mut is_set = vec![false; first_copy];
    let mut copied = Vec::new();
    for (triangle, tangents) in tangents.iter().enumerate() {
        for (corner, &tangent) in tangents.iter().enumerate() {
            let mut at = mesh.triangles[triangle][corner] as usize;
            if !std::mem::replace(&mut is_set[at], true) {
                mesh.tangents[at] = tangent;
            }
            while mesh.tangents[at] != tangent && next[at] != NONE {
                at = next[at] as usize;
            }
            if mesh.tangents[at] != tangent {
                let copy = mesh.positions.len();
                copy_vertex(mesh, at);
                copied.push(at as u32);
                mesh.tangents.push(tangent);
                next[at] = copy as u32;
                next.push(NONE);
                is_set.push(true);
                at = copy;
            }
            mesh.triangles[triangle][corner] = at as u32;
        }
    }
    copied
}

/// Appends a copy of a vertex, without its tangent.
fn copy_vertex(mesh: &mut Mesh, at: usize) {
    fn again<T: Copy>(values: &mut Vec<T>, at: usize) {
        if let Some(&value) = values.get(at) {
            values.push(value);
        }
    }
    again(&mut mesh.positions, at);
    again(&mut mesh.normals, at);
    again(&mut mesh.uvs, at);
    again(&mut mesh.second_uvs, at);
    again(&mut mesh.colors, at);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares in the xy plane beside each other, from x = -1 to 1, that share their middle vertices. The right one has
    /// u along x; the left one has it mirrored.
    fn mirrored() -> Mesh {
        let p = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        Mesh {
            positions: vec![
                p(-1.0, 0.0),
                p(0.0, 0.0),
                p(1.0, 0.0),
                p(-1.0, 1.0),
                p(0.0, 1.0),
                p(1.0, 1.0),
            ],
            triangles: vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
            normals: vec![Vec3::Z; 6],
            uvs: [1.0, 0.0, 1.0, 1.0, 0.0, 1.0]
                .into_iter()
                .enumerate()
                .map(|(i, u)| Vec2::new(u, if i < 3 { 0.0 } else { 1.0 }))
                .collect(),
            ..Mesh::default()
        }
    }

    #[test]
    fn a_mirrored_seam_has_both_tangents_and_the_rest_keeps_its_vertices() {
        let mut mesh = mirrored();
        assert_eq!(add(&mut mesh, UvSet::First), [1, 4]);
        assert_eq!(mesh.validate(), Ok(()));
        assert_eq!(mesh.positions.len(), 8, "the two vertices of the seam are copied");
        let (left, right) = (Vec4::new(-1.0, 0.0, 0.0, -1.0), Vec4::new(1.0, 0.0, 0.0, 1.0));
        for (i, triangle) in mesh.triangles.iter().enumerate() {
            let expected = if i < 2 { left } else { right };
            for v in triangle {
                assert_eq!(mesh.tangents[*v as usize], expected, "triangle {i}");
            }
            assert_eq!(mesh.corners(i), mirrored().corners(i));
        }
    }

    #[test]
    fn the_second_coordinates_are_followed_where_they_are_asked_for() {
        let mut mesh = mirrored();
        mesh.second_uvs = mesh.positions.iter().map(|p| Vec2::new(p.y, -p.x)).collect();
        add(&mut mesh, UvSet::Second);
        assert_eq!(mesh.positions.len(), 6);
        assert!(mesh.tangents.iter().all(|t| *t == Vec4::new(0.0, 1.0, 0.0, 1.0)));
    }

    #[test]
    fn flat_meshes_and_points_without_area_have_finite_tangents() {
        let mut mesh = mirrored();
        mesh.normals.clear();
        mesh.triangles.push([0, 0, 1]);
        mesh.uvs[2] = mesh.uvs[5];
        add(&mut mesh, UvSet::First);
        assert_eq!(mesh.validate(), Ok(()));
        assert_eq!(mesh.tangents.len(), mesh.positions.len());

        let mut bare = Mesh {
            uvs: Vec::new(),
            ..mirrored()
        };
        add(&mut bare, UvSet::First);
        assert!(bare.tangents.is_empty());
    }
}
