//! The surface that meshes are before they are refined.
//!
//! Vertices at the same position are one place, in whichever mesh they are: files part vertices where texture coordinates or
//! materials change, and the surface is not to tear there. Faces lose corners that are at the place of the one before them.
//!
//! An edge of one face is a boundary. Edges of more than two faces, and those of two faces that run along it in the same
//! direction, are creases. A place where several surfaces touch stays where it is, as in OpenSubdiv, unless it lies
//! within a crease of two such edges.

use std::collections::HashMap;

use glam::{DVec2, DVec3, DVec4};

use super::{
    sets::Sets,
    surface::Surface,
    topology::{Faces, Net, after},
};
use crate::{math::Vec3, shape::mesh};

/// The creases of a cage.
#[derive(Clone, Copy, Debug)]
pub struct CageRules {
    /// The cosine of the least angle between the normals of faces at a crease; -2 for no creases.
    pub crease_cos: f64,
    pub crease_sharpness: f32,
    /// Whether boundaries have corners at the vertices of one face.
    pub keeps_corners: bool,
}

/// The faces at an edge.
#[derive(Clone, Copy, Debug)]
struct EdgeUse {
    count: u32,
    /// The first corners from which it starts, and their faces.
    corners: [u32; 2],
    faces: [u32; 2],
    /// Whether the first two faces run along it in opposite directions.
    is_opposite: bool,
}

impl EdgeUse {
    fn is_boundary(&self) -> bool {
        self.count == 1
    }

    fn is_manifold(&self) -> bool {
        self.count == 2 && self.is_opposite
    }
}

/// The faces of meshes, with the places of their corners.
#[derive(Default)]
struct Gathered {
    ends: Vec<u32>,
    part_ends: Vec<usize>,
    /// The place of each corner, and its vertex among those of all meshes.
    places: Vec<u32>,
    vertices: Vec<u32>,
    positions: Vec<DVec3>,
}

fn gather<'a>(parts: &[(&'a mesh::Mesh, Vec<&'a [u32]>)]) -> Gathered {
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    let mut all = Gathered::default();
    let mut first_vertex = 0;
    for (mesh, faces) in parts {
        let mut place_of = |p: Vec3| {
            // Adding 0 turns -0 into 0.
            *known.entry((p + 0.0).to_array().map(f32::to_bits)).or_insert_with(|| {
                all.positions.push(p.as_dvec3());
                all.positions.len() as u32 - 1
            })
        };
        let places: Vec<u32> = mesh.positions.iter().map(|p| place_of(*p)).collect();
        let vertices = one_of_equals(mesh, &places);
        for face in faces {
            let start = all.places.len();
            for vertex in *face {
                let place = places[*vertex as usize];
                if all.places[start..].last() != Some(&place) {
                    all.places.push(place);
                    all.vertices.push(first_vertex + vertices[*vertex as usize]);
                }
            }
            while all.places.len() > start + 1 && all.places[start] == all.places[all.places.len() - 1] {
                all.places.pop();
                all.vertices.pop();
            }
            if all.places.len() < start + 3 {
                all.places.truncate(start);
                all.vertices.truncate(start);
            } else {
                all.ends.push(all.places.len() as u32);
            }
        }
        all.part_ends.push(all.ends.len());
        first_vertex += mesh.positions.len() as u32;
    }
    all
}

/// For each vertex of a mesh the first one with its place and its values. Files part vertices of one value by normals, and some
/// write each corner of a face apart.
fn one_of_equals(mesh: &mesh::Mesh, places: &[u32]) -> Vec<u32> {
    let mut known: HashMap<(u32, [u32; 8]), u32> = HashMap::with_capacity(places.len());
    let first = |(vertex, place): (u32, &u32)| {
        let at = vertex as usize;
        let [u, v] = mesh.uvs.get(at).map_or([0.0; 2], |uv| uv.to_array());
        let [s, t] = mesh.second_uvs.get(at).map_or([0.0; 2], |uv| uv.to_array());
        let [r, g, b, a] = mesh.colors.get(at).map_or([1.0; 4], |color| color.to_array());
        let values = [u, v, s, t, r, g, b, a].map(f32::to_bits);
        *known.entry((*place, values)).or_insert(vertex)
    };
    (0..).zip(places).map(first).collect()
}

/// The net of places, and the use of each of its edges.
fn net_of(faces: &Faces, corners: Vec<u32>, vertices: usize) -> (Net, Vec<EdgeUse>) {
    let mut known: HashMap<[u32; 2], u32> = HashMap::with_capacity(corners.len() / 2);
    let mut net = Net {
        vertices: vertices as u32,
        edge_of: Vec::with_capacity(corners.len()),
        edges: Vec::with_capacity(corners.len() / 2),
        corners,
    };
    let mut uses: Vec<EdgeUse> = Vec::with_capacity(net.corners.len() / 2);
    for (number, face) in (0..).zip(faces.all()) {
        for corner in face.clone() {
            let ends = [corner, after(corner, &face)].map(|c| net.corners[c]);
            let key = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            let edge = *known.entry(key).or_insert(uses.len() as u32);
            net.edge_of.push(edge);
            match uses.get_mut(edge as usize) {
                None => {
                    net.edges.push(ends);
                    uses.push(EdgeUse {
                        count: 1,
                        corners: [corner as u32; 2],
                        faces: [number; 2],
                        is_opposite: false,
                    });
                }
                Some(used) => {
                    if used.count == 1 {
                        (used.corners[1], used.faces[1]) = (corner as u32, number);
                        used.is_opposite = net.edges[edge as usize] != ends;
                    }
                    used.count += 1;
                }
            }
        }
    }
    (net, uses)
}

/// The normals of faces, by Newell's sum; 0 of those without area.
fn normals(faces: &Faces, net: &Net, positions: &[DVec3]) -> Vec<DVec3> {
    let at = |corner: usize| positions[net.corners[corner] as usize];
    let normal = |face: std::ops::Range<usize>| {
        let first = at(face.start);
        let corners = face.clone();
        let sum: DVec3 = corners
            .map(|corner| (at(corner) - first).cross(at(after(corner, &face)) - first))
            .sum();
        sum.normalize_or_zero()
    };
    faces.all().map(normal).collect()
}

/// The places that never move: see the head of the module. `next` are the corners after each.
fn corners(next: &[u32], net: &Net, uses: &[EdgeUse], rules: &CageRules) -> Vec<bool> {
    let places = net.vertices as usize;
    let mut fans = Sets::new(net.corners.len());
    for used in uses.iter().filter(|used| used.is_manifold()) {
        let [a, b] = used.corners;
        fans.join(a, next[b as usize]);
        fans.join(b, next[a as usize]);
    }
    #[derive(Clone, Copy, Default)]
    struct Place {
        fans: u32,
        faces: u32,
        edges: u32,
        boundaries: u32,
        odd: u32,
    }
    let mut at = vec![Place::default(); places];
    for (corner, place) in net.corners.iter().enumerate() {
        let at = &mut at[*place as usize];
        at.faces += 1;
        at.fans += u32::from(fans.first(corner as u32) == corner as u32);
    }
    for (ends, used) in net.edges.iter().zip(uses) {
        for place in ends {
            let at = &mut at[*place as usize];
            at.edges += 1;
            at.boundaries += u32::from(used.is_boundary());
            at.odd += u32::from(!used.is_boundary() && !used.is_manifold());
        }
    }
    let stays = |at: &Place| {
        if at.faces == 1 && at.edges == 2 && rules.keeps_corners {
            return true;
        }
        let is_within_crease = at.odd == 2 && at.boundaries == 0 && at.faces > at.edges;
        (at.fans > 1 || at.odd > 0) && !is_within_crease
    };
    at.iter().map(stays).collect()
}

/// The net of values, and the vertex among those of all meshes that each value has. `next` are the corners after each.
fn values(next: &[u32], places: &Net, uses: &[EdgeUse], sharpness: &[f32], vertices: &[u32]) -> (Net, Vec<u32>) {
    let mut sets = Sets::new(vertices.len());
    let is_open = |edge: usize| !uses[edge].is_manifold() || sharpness[edge] == f32::INFINITY;
    for used in (0..uses.len()).filter(|edge| !is_open(*edge)).map(|edge| uses[edge]) {
        let [a, b] = used.corners;
        for [a, b] in [[a, next[b as usize]], [b, next[a as usize]]] {
            if vertices[a as usize] == vertices[b as usize] {
                sets.join(a, b);
            }
        }
    }
    let (mut net, mut sources) = (Net::default(), Vec::new());
    for corner in 0..vertices.len() as u32 {
        let first = sets.first(corner);
        if first == corner {
            net.corners.push(sources.len() as u32);
            sources.push(vertices[corner as usize]);
        } else {
            net.corners.push(net.corners[first as usize]);
        }
    }
    net.vertices = sources.len() as u32;
    for (corner, &after) in next.iter().enumerate() {
        let ends = [net.corners[corner], net.corners[after as usize]];
        let edge = places.edge_of[corner] as usize;
        let twin = uses[edge].corners[0] as usize;
        if !is_open(edge) && twin < corner {
            let shared = net.edge_of[twin];
            let [a, b] = net.edges[shared as usize];
            if [b, a] == ends {
                net.edge_of.push(shared);
                continue;
            }
        }
        net.edge_of.push(net.edges.len() as u32);
        net.edges.push(ends);
    }
    (net, sources)
}

impl Surface {
    /// The surface of these meshes and their faces, which have indices of vertices.
    pub fn new(parts: &[(&mesh::Mesh, Vec<&[u32]>)], rules: &CageRules) -> Self {
        let gathered = gather(parts);
        let faces = Faces::Ends(gathered.ends);
        let (places, uses) = net_of(&faces, gathered.places, gathered.positions.len());
        let normals = match rules.crease_cos >= -1.0 {
            true => normals(&faces, &places, &gathered.positions),
            false => Vec::new(),
        };
        let sharpness = |used: &EdgeUse| {
            if !used.is_manifold() {
                return f32::INFINITY;
            }
            let is_crease = !normals.is_empty() && {
                let [a, b] = used.faces.map(|face| normals[face as usize]);
                a != DVec3::ZERO && b != DVec3::ZERO && a.dot(b) < rules.crease_cos
            };
            if is_crease { rules.crease_sharpness } else { 0.0 }
        };
        let sharpness: Vec<f32> = uses.iter().map(sharpness).collect();
        let next = faces.next_corners();
        let (values, sources) = values(&next, &places, &uses, &sharpness, &gathered.vertices);
        let mut surface = Self {
            is_corner: corners(&next, &places, &uses, rules),
            positions: gathered.positions,
            part_ends: gathered.part_ends,
            sharpness,
            ..Self::default()
        };
        surface.take_values(parts, &sources);
        surface.mark_seams(&places, &values);
        (surface.faces, surface.places, surface.values) = (faces, places, values);
        surface
    }

    /// Makes creases of the edges that one face has alone, and corners of their values and of those at corners.
    fn mark_seams(&mut self, places: &Net, values: &Net) {
        let mut faces_at = vec![0_u32; values.edges.len()];
        values.edge_of.iter().for_each(|edge| faces_at[*edge as usize] += 1);
        self.value_sharpness = vec![f32::INFINITY; values.edges.len()];
        for (edge, place_edge) in values.edge_of.iter().zip(&places.edge_of) {
            if faces_at[*edge as usize] > 1 {
                self.value_sharpness[*edge as usize] = self.sharpness[*place_edge as usize];
            }
        }
        self.is_seam = vec![false; values.vertices as usize];
        for (value, place) in values.corners.iter().zip(&places.corners) {
            self.is_seam[*value as usize] |= self.is_corner[*place as usize];
        }
        for (ends, sharpness) in values.edges.iter().zip(&self.value_sharpness) {
            if *sharpness == f32::INFINITY {
                ends.iter().for_each(|end| self.is_seam[*end as usize] = true);
            }
        }
    }

    /// Takes the values of these vertices of all meshes.
    fn take_values(&mut self, parts: &[(&mesh::Mesh, Vec<&[u32]>)], sources: &[u32]) {
        let ends: Vec<u32> = (parts.iter())
            .scan(0, |end, (mesh, _)| {
                *end += mesh.positions.len() as u32;
                Some(*end)
            })
            .collect();
        let of = |source: u32| {
            let part = ends.partition_point(|end| *end <= source);
            let first = part.checked_sub(1).map_or(0, |before| ends[before]);
            (parts[part].0, (source - first) as usize)
        };
        let has = |test: fn(&mesh::Mesh) -> bool| parts.iter().any(|(mesh, _)| test(mesh));
        let sources = || sources.iter().map(|source| of(*source));
        if has(|mesh| !mesh.uvs.is_empty()) {
            let uv = |(mesh, at): (&mesh::Mesh, usize)| mesh.uvs.get(at).map_or(DVec2::ZERO, |uv| uv.as_dvec2());
            self.uvs = sources().map(uv).collect();
        }
        if has(|mesh| !mesh.second_uvs.is_empty()) {
            let uv = |(mesh, at): (&mesh::Mesh, usize)| mesh.second_uvs.get(at).map_or(DVec2::ZERO, |uv| uv.as_dvec2());
            self.second_uvs = sources().map(uv).collect();
        }
        if has(|mesh| !mesh.colors.is_empty()) {
            let color = |(mesh, at): (&mesh::Mesh, usize)| mesh.colors.get(at).map_or(DVec4::ONE, |c| c.as_dvec4());
            self.colors = sources().map(color).collect();
        }
    }
}
