//! A surface of faces at one level of its refinement.

use glam::{DVec2, DVec3, DVec4};

use super::{
    rules::{Controls, limit_points, refined_points},
    topology::{Faces, Net, Split, interpolated, split_of},
};
use crate::shape::mesh::Scheme;

/// A surface. It is refined as a whole; its faces belong to parts, which have materials of their own.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    pub faces: Faces,
    /// The number of faces of all parts up to each.
    pub part_ends: Vec<usize>,
    pub places: Net,
    /// The net of values. Each of its vertices belongs to one part and is at one place; where the surface has a seam or an edge
    /// that stays sharp, there are several at a place.
    pub values: Net,
    /// In double precision, one for each vertex of `places`.
    pub positions: Vec<DVec3>,
    /// The places that never move.
    pub is_corner: Vec<bool>,
    /// The sharpness of each edge of `places`: the number of levels on which it is a crease, infinite on boundaries.
    pub sharpness: Vec<f32>,
    /// The values at seams, which never change.
    pub is_seam: Vec<bool>,
    /// The sharpness of each edge of `values`, infinite where only one face has it.
    pub value_sharpness: Vec<f32>,
    /// One for each vertex of `values`, or none.
    pub uvs: Vec<DVec2>,
    pub second_uvs: Vec<DVec2>,
    pub colors: Vec<DVec4>,
}

/// The sharpness of the edges of the next level, of which `inner` are within faces.
fn finer(sharpness: &[f32], inner: usize) -> Vec<f32> {
    let halves = sharpness.iter().flat_map(|s| [(s - 1.0).max(0.0); 2]);
    halves.chain(std::iter::repeat_n(0.0, inner)).collect()
}

/// The same vertices, and others up to `count`.
fn extended(is_marked: &[bool], count: u32) -> Vec<bool> {
    let mut all = is_marked.to_vec();
    all.resize(count as usize, false);
    all
}

impl Surface {
    fn controls(&self) -> Controls<'_> {
        Controls {
            faces: &self.faces,
            net: &self.places,
            points: &self.positions,
            sharpness: &self.sharpness,
            is_corner: &self.is_corner,
        }
    }

    /// Changes texture coordinates by `change`, unless there are none.
    fn smooth(&self, uvs: &[DVec2], change: impl Fn(&Controls<'_>) -> Vec<DVec3>) -> Vec<DVec2> {
        if uvs.is_empty() {
            return Vec::new();
        }
        let points: Vec<DVec3> = uvs.iter().map(|uv| uv.extend(0.0)).collect();
        let changed = change(&Controls {
            faces: &self.faces,
            net: &self.values,
            points: &points,
            sharpness: &self.value_sharpness,
            is_corner: &self.is_seam,
        });
        changed.into_iter().map(DVec3::truncate).collect()
    }

    /// The surface of the next level. `Loop` is for triangles.
    pub fn refined(&self, scheme: Scheme) -> Self {
        let Self {
            faces, places, values, ..
        } = self;
        let split = split_of(scheme, faces);
        let inner = places.corners.len();
        let (places_then, values_then) = (places.refined(faces, split), values.refined(faces, split));
        let ends = self.part_ends.iter().map(|end| self.faces_within(*end, split));
        let smooth = |uvs| self.smooth(uvs, |controls| refined_points(controls, scheme));
        Self {
            faces: faces.refined(split, inner),
            part_ends: ends.collect(),
            positions: refined_points(&self.controls(), scheme),
            is_corner: extended(&self.is_corner, places_then.vertices),
            sharpness: finer(&self.sharpness, inner),
            is_seam: extended(&self.is_seam, values_then.vertices),
            value_sharpness: finer(&self.value_sharpness, inner),
            uvs: smooth(&self.uvs),
            second_uvs: smooth(&self.second_uvs),
            colors: interpolated(&self.colors, values, faces, split),
            values: values_then,
            places: places_then,
        }
    }

    /// The number of faces that the first `count` faces become.
    fn faces_within(&self, count: usize, split: Split) -> usize {
        match split {
            Split::Triangles => 4 * count,
            Split::Quads => self.faces.corners_of_first(count),
        }
    }

    /// Moves all vertices to their places on the limit surface. It is one of triangles, for `Loop`, or of quadrilaterals.
    pub fn move_to_limit(&mut self, scheme: Scheme) {
        let smooth = |uvs| self.smooth(uvs, |controls| limit_points(controls, scheme));
        let (positions, uvs, second_uvs) = (
            limit_points(&self.controls(), scheme),
            smooth(&self.uvs),
            smooth(&self.second_uvs),
        );
        (self.positions, self.uvs, self.second_uvs) = (positions, uvs, second_uvs);
    }
}
