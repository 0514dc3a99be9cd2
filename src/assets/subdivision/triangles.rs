//! The triangles and normals of a refined surface.

use std::ops::Range;

use glam::DVec3;

use super::{
    sets::Sets,
    surface::Surface,
    topology::{after, before},
};
use crate::shape::mesh::Mesh;

/// Marks what has no number yet.
const NONE: u32 = u32::MAX;

impl Surface {
    /// The corners of pairs of faces that meet at an edge without a lasting crease: the first that an edge starts
    /// from in one face and in the other.
    fn neighbours(&self) -> impl Iterator<Item = [u32; 2]> {
        let mut first = vec![NONE; self.places.edges.len()];
        let corners = (0..).zip(&self.places.edge_of);
        corners.filter_map(move |(corner, edge)| {
            let edge = *edge as usize;
            if self.sharpness[edge] == f32::INFINITY {
                return None;
            }
            if first[edge] == NONE {
                first[edge] = corner;
                return None;
            }
            Some([first[edge], corner])
        })
    }

    /// Twice the area of the triangle of a corner and those beside it, along its normal.
    pub(super) fn corner_normal(&self, corner: usize, face: &Range<usize>) -> DVec3 {
        let at = |corner: usize| self.positions[self.places.corners[corner] as usize];
        let p = at(corner);
        (at(after(corner, face)) - p).cross(at(before(corner, face)) - p)
    }

    /// The unit normal of each value: the mean over the faces around it up to the edges that stay sharp, weighed by the area at the
    /// corner; 0 where that cancels.
    pub fn normals(&self) -> Vec<DVec3> {
        let mut sets = Sets::new(self.values.vertices as usize);
        let next = self.faces.next_corners();
        let value = |corner: u32| self.values.corners[corner as usize];
        for [a, b] in self.neighbours() {
            sets.join(value(a), value(next[b as usize]));
            sets.join(value(next[a as usize]), value(b));
        }
        let mut sums = vec![DVec3::ZERO; self.values.vertices as usize];
        for face in self.faces.all() {
            for corner in face.clone() {
                sums[sets.first(self.values.corners[corner]) as usize] += self.corner_normal(corner, &face);
            }
        }
        let of = |value: u32| sums[sets.first(value) as usize].normalize_or_zero();
        (0..self.values.vertices).map(of).collect()
    }

    /// The triangles of each part, with normals. `parts` are the meshes that the surface is made of.
    pub fn meshes<'a>(&self, parts: impl Iterator<Item = &'a Mesh>) -> Vec<Mesh> {
        let normals = self.normals();
        let mut place_of = vec![0; self.values.vertices as usize];
        for (value, place) in self.values.corners.iter().zip(&self.places.corners) {
            place_of[*value as usize] = *place;
        }
        let mut number_of = vec![NONE; self.values.vertices as usize];
        let mut start = 0;
        let mut of_part = |(part, end): (&Mesh, usize)| {
            let mut mesh = Mesh {
                uv_origins: part.uv_origins,
                ..Mesh::default()
            };
            for face in (start..end).map(|face| self.faces.corners(face)) {
                let mut number = |value: u32| {
                    let at = value as usize;
                    if number_of[at] == NONE {
                        number_of[at] = mesh.positions.len() as u32;
                        mesh.positions.push(self.positions[place_of[at] as usize].as_vec3());
                        mesh.normals.push(normals[at].as_vec3());
                        if !part.uvs.is_empty() {
                            mesh.uvs.push(self.uvs[at].as_vec2());
                        }
                        if !part.second_uvs.is_empty() {
                            mesh.second_uvs.push(self.second_uvs[at].as_vec2());
                        }
                        if !part.colors.is_empty() {
                            mesh.colors.push(self.colors[at].as_vec4());
                        }
                    }
                    number_of[at]
                };
                let corners = &self.values.corners[face];
                let first = number(corners[0]);
                for pair in corners[1..].windows(2) {
                    let (second, third) = (number(pair[0]), number(pair[1]));
                    mesh.triangles.push([first, second, third]);
                }
            }
            start = end;
            mesh
        };
        let ends = self.part_ends.iter().copied();
        parts.zip(ends).map(&mut of_part).collect()
    }
}
