//! Faces of PLY files: their corners, and the colours and texture coordinates that belong to faces rather than to vertices.

use std::collections::HashMap;

use super::{
    header::{Element, NumberType, PropertyKind},
    source::{Source, Stop},
    values::{broken, list_length, skip, skip_property, stopped},
};
use crate::{
    assets::{
        MemoryBudget, MemoryKind,
        bare::{BareMeshProblem, PlacedMesh},
        model::FaceUse,
        obj::polygon,
    },
    math::{DVec2, Vec3, Vec4},
    shape::mesh::{Polygons, around_origin},
};

/// Bytes of memory for a corner that has a colour or texture coordinates of its own.
const CORNER_MEMORY: u64 = 160;

/// Faces as they are read; they may come before the vertices.
#[derive(Default)]
pub(super) struct Faces {
    /// Faces of three corners, unless corners have values of their own.
    triangles: Vec<[u32; 3]>,
    /// The corners of other faces, one face after another, and where each ends.
    corners: Vec<u32>,
    ends: Vec<usize>,
    /// The raw colour of each face in `ends`, where faces have one, and the type of its numbers.
    pub colors: Vec<Vec4>,
    pub color_type: Option<NumberType>,
    /// The texture coordinates of each corner in `corners`, where faces have them.
    uvs: Vec<DVec2>,
    has_uvs: bool,
    keeps_polygons: bool,
    /// Whether an element was read.
    is_read: bool,
}

/// The meaning of a property of a face.
#[derive(Clone, Copy)]
enum Role {
    Corners { count: NumberType, item: NumberType },
    Channel { which: usize, number: NumberType },
    Uvs { count: NumberType, item: NumberType },
    Other,
}

fn role(name: &str, kind: PropertyKind) -> Role {
    match (name, kind) {
        ("vertex_indices" | "vertex_index", PropertyKind::List { count, item }) => Role::Corners { count, item },
        ("texcoord", PropertyKind::List { count, item }) => Role::Uvs { count, item },
        (_, PropertyKind::Number(number)) => {
            let which = match name {
                "red" | "diffuse_red" | "r" => 0,
                "green" | "diffuse_green" | "g" => 1,
                "blue" | "diffuse_blue" | "b" => 2,
                "alpha" | "a" => 3,
                _ => return Role::Other,
            };
            Role::Channel { which, number }
        }
        _ => Role::Other,
    }
}

/// The number of a vertex.
#[inline(always)]
fn corner(source: &mut impl Source, item: NumberType) -> Result<u32, Stop> {
    let number = source.number(item)?;
    let whole = number as u32;
    if f64::from(whole) == number {
        Ok(whole)
    } else {
        Err(Stop::NoNumber(format!("vertex {number}")))
    }
}

impl Faces {
    pub fn new(faces: FaceUse) -> Self {
        Self {
            keeps_polygons: faces == FaceUse::Polygons,
            ..Self::default()
        }
    }

    /// Reads the element `face`.
    pub fn read(&mut self, element: &Element, source: &mut impl Source) -> Result<(), BareMeshProblem> {
        let roles: Vec<Role> = element.properties.iter().map(|p| role(&p.name, p.kind)).collect();
        if !roles.iter().any(|role| matches!(role, Role::Corners { .. })) {
            let is_corners = |name: &str| matches!(name, "vertex_indices" | "vertex_index");
            return match element.properties.iter().any(|p| is_corners(&p.name)) {
                true => Err(broken("the corners of faces are no list")),
                false => skip(element, source),
            };
        }
        let is_corners = |role: &&Role| matches!(role, Role::Corners { .. });
        if self.is_read || roles.iter().filter(is_corners).count() > 1 {
            return Err(broken("the faces have more than one list of corners"));
        }
        self.is_read = true;
        let channel = |wanted: usize| {
            roles.iter().find_map(|role| match role {
                Role::Channel { which, number } if *which == wanted => Some(*number),
                _ => None,
            })
        };
        let has_colors = (0..3).all(|which| channel(which).is_some());
        self.color_type = channel(0).filter(|_| has_colors);
        let alpha = channel(3).map_or(1.0, NumberType::one);
        self.has_uvs = roles.iter().any(|role| matches!(role, Role::Uvs { .. }));
        let is_plain = !has_colors && !self.has_uvs;
        if is_plain {
            self.triangles.reserve_exact(element.count as usize);
        }
        for i in 0..element.count {
            let mut read = || -> Result<(), Stop> {
                let (start, mut color, mut uvs) = (self.corners.len(), [1.0, 1.0, 1.0, alpha], Vec::new());
                let mut is_face = false;
                for (role, property) in roles.iter().zip(&element.properties) {
                    match *role {
                        Role::Corners { count, item } => is_face = self.corners(source, count, item, is_plain)?,
                        Role::Channel { which, number } => color[which] = source.number(number)?,
                        Role::Uvs { count, item } => {
                            for _ in 0..list_length(source, count)? {
                                uvs.push(source.number(item)?);
                            }
                        }
                        Role::Other => skip_property(source, property)?,
                    }
                }
                if is_face && has_colors {
                    let [r, g, b, a] = color.map(|v| v as f32);
                    self.colors.push(Vec4::new(r, g, b, (a / alpha as f32).clamp(0.0, 1.0)));
                }
                if is_face && self.has_uvs {
                    // A list that is too short stands for no coordinates.
                    let own = (0..self.corners.len() - start).map(|k| uvs.get(2 * k..2 * k + 2));
                    self.uvs.extend(own.map(|uv| uv.map_or(DVec2::ZERO, DVec2::from_slice)));
                }
                Ok(())
            };
            read().map_err(|stop| stopped(element, i)(stop))?;
        }
        Ok(())
    }

    /// Reads the corners of a face; whether they are in `corners`.
    #[inline(always)]
    fn corners(
        &mut self,
        source: &mut impl Source,
        count: NumberType,
        item: NumberType,
        is_plain: bool,
    ) -> Result<bool, Stop> {
        let length = list_length(source, count)?;
        match length {
            3 if is_plain => {
                let corners = [corner(source, item)?, corner(source, item)?, corner(source, item)?];
                self.triangles.push(corners);
                Ok(false)
            }
            // Lines and points.
            0..3 => source.skip(item, length).map(|()| false),
            _ => {
                for _ in 0..length {
                    self.corners.push(corner(source, item)?);
                }
                self.ends.push(self.corners.len());
                Ok(true)
            }
        }
    }

    /// Reads the element `tristrips`: lists of vertices in which -1 begins a new strip.
    pub fn read_strips(&mut self, element: &Element, source: &mut impl Source) -> Result<(), BareMeshProblem> {
        for i in 0..element.count {
            let mut read = || -> Result<(), Stop> {
                for property in &element.properties {
                    let Role::Corners { count, item } = role(&property.name, property.kind) else {
                        skip_property(source, property)?;
                        continue;
                    };
                    let mut strip: [u32; 2] = [0; 2];
                    let mut length = 0;
                    for _ in 0..list_length(source, count)? {
                        let number = source.number(item)?;
                        if number == -1.0 {
                            length = 0;
                            continue;
                        }
                        let next = number as u32;
                        if f64::from(next) != number {
                            return Err(Stop::NoNumber(format!("vertex {number}")));
                        }
                        let [a, b] = strip;
                        match length {
                            0 | 1 => strip[length] = next,
                            // Every other triangle of a strip is wound the other way round.
                            _ if length % 2 == 0 => self.triangles.push([a, b, next]),
                            _ => self.triangles.push([b, a, next]),
                        }
                        if length >= 2 {
                            strip = [b, next];
                        }
                        length += 1;
                    }
                }
                Ok(())
            };
            read().map_err(|stop| stopped(element, i)(stop))?;
        }
        Ok(())
    }

    /// Gives the mesh its triangles; those of larger faces come last. Where faces have values of their own, vertices are parted
    /// so that each has one value. The colours are linear by now.
    pub fn finish(self, placed: &mut PlacedMesh, memory: &MemoryBudget) -> Result<(), BareMeshProblem> {
        let mesh = &mut placed.mesh;
        let count = mesh.positions.len();
        let all = self.corners.iter().chain(self.triangles.iter().flatten());
        if let Some(corner) = all.copied().find(|c| *c as usize >= count) {
            return Err(broken(format!(
                "a face names vertex {corner}, but there are only {count}"
            )));
        }
        let is_parted = !self.colors.is_empty() || self.has_uvs;
        if is_parted {
            let corners = self.corners.len() + self.triangles.as_flattened().len();
            memory.check(MemoryKind::Models, corners as u64 * CORNER_MEMORY)?;
        }
        let plain_triangles = self.triangles.len();
        let mut parted = Parted {
            plain_triangles,
            ..Parted::default()
        };
        mesh.triangles = self.triangles;
        let (mut start, mut places, mut polygons) = (0, Vec::new(), Polygons::default());
        for (face, end) in self.ends.into_iter().enumerate() {
            let corners = &self.corners[start..end];
            places.clear();
            places.extend(corners.iter().map(|c| mesh.positions[*c as usize]));
            let color = self.colors.get(face).copied();
            let own: Vec<u32> = match is_parted {
                false => corners.to_vec(),
                true => (corners.iter().enumerate())
                    .map(|(k, c)| parted.vertex(*c, color, self.uvs.get(start + k).copied()))
                    .collect(),
            };
            if self.keeps_polygons {
                polygons.push(&own);
            }
            polygon::triangulate(&places, |t| mesh.triangles.push(t.map(|i| own[i])));
            start = end;
        }
        if is_parted {
            // Triangles of strips have no values of their own.
            for vertex in mesh.triangles.iter_mut().take(parted.plain_triangles).flatten() {
                *vertex = parted.vertex(*vertex, None, None);
            }
            parted.apply(placed);
        }
        if self.keeps_polygons {
            let plain = &placed.mesh.triangles[..plain_triangles];
            plain.iter().for_each(|triangle| polygons.push(triangle));
            placed.mesh.polygons = polygons.without_triangles();
        }
        Ok(())
    }
}

/// Vertices of which each has one colour and one pair of texture coordinates.
#[derive(Default)]
struct Parted {
    known: HashMap<(u32, [u32; 4], [u64; 2]), u32>,
    /// The vertex that each comes from, and its own values.
    vertices: Vec<(u32, Option<Vec4>, Option<DVec2>)>,
    plain_triangles: usize,
}

impl Parted {
    fn vertex(&mut self, from: u32, color: Option<Vec4>, uv: Option<DVec2>) -> u32 {
        let color_bits = color.unwrap_or(Vec4::NAN).to_array().map(f32::to_bits);
        let uv_bits = uv.unwrap_or(DVec2::NAN).to_array().map(f64::to_bits);
        *self.known.entry((from, color_bits, uv_bits)).or_insert_with(|| {
            self.vertices.push((from, color, uv));
            self.vertices.len() as u32 - 1
        })
    }

    fn apply(self, placed: &mut PlacedMesh) {
        let mesh = &mut placed.mesh;
        let of = |from: u32| from as usize;
        let has_colors = !mesh.colors.is_empty() || self.vertices.iter().any(|(_, color, _)| color.is_some());
        let has_uvs = !mesh.uvs.is_empty() || self.vertices.iter().any(|(_, _, uv)| uv.is_some());
        let positions: Vec<Vec3> = self.vertices.iter().map(|v| mesh.positions[of(v.0)]).collect();
        let color = |(from, own, _): &(u32, Option<Vec4>, Option<DVec2>)| {
            own.or(mesh.colors.get(of(*from)).copied()).unwrap_or(Vec4::ONE)
        };
        let vertex_uv = |from: u32| Some(mesh.uvs.get(of(from))?.as_dvec2() + mesh.uv_origins[0].as_dvec2());
        let uv = |(from, _, own): &(u32, Option<Vec4>, Option<DVec2>)| own.or(vertex_uv(*from)).unwrap_or_default();
        let colors = self.vertices.iter().filter(|_| has_colors).map(color).collect();
        let all = self.vertices.iter().filter(|_| has_uvs).map(uv);
        let (uv_origin, uvs) = around_origin(all);
        let normals = self.vertices.iter().filter(|_| !mesh.normals.is_empty());
        mesh.normals = normals.map(|v| mesh.normals[of(v.0)]).collect();
        (mesh.positions, mesh.colors, mesh.uvs) = (positions, colors, uvs);
        mesh.uv_origins[0] = uv_origin;
    }
}
