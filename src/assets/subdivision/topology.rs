//! Faces, edges and vertices of a surface, and their refinement without a look at numbers.
//!
//! Every face becomes one face for each of its corners, or four triangles. The edges of the finer faces follow from those of the
//! coarser ones, so only the coarsest faces have to be searched for common edges.

use std::ops::{Add, Div, Range};

use crate::shape::mesh::Scheme;

/// The way in which faces are split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// A quadrilateral for each corner, around a new vertex in the face.
    Quads,
    /// Four triangles for each triangle.
    Triangles,
}

/// The runs of corners that are faces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Faces {
    /// The end of each.
    Ends(Vec<u32>),
    /// `count` faces of three or of four corners each.
    Equal { corners: u32, count: u32 },
}

impl Default for Faces {
    fn default() -> Self {
        Self::Ends(Vec::new())
    }
}

impl Faces {
    pub fn count(&self) -> usize {
        match self {
            Self::Ends(ends) => ends.len(),
            Self::Equal { count, .. } => *count as usize,
        }
    }

    /// The corners of a face.
    pub fn corners(&self, face: usize) -> Range<usize> {
        match self {
            Self::Ends(ends) => {
                let start = face.checked_sub(1).map_or(0, |before| ends[before]);
                start as usize..ends[face] as usize
            }
            Self::Equal { corners, .. } => {
                let corners = *corners as usize;
                corners * face..corners * (face + 1)
            }
        }
    }

    /// The corners of all faces, in order.
    pub fn all(&self) -> impl Iterator<Item = Range<usize>> {
        (0..self.count()).map(|face| self.corners(face))
    }

    /// The number of corners of the first `count` faces.
    pub fn corners_of_first(&self, count: usize) -> usize {
        count.checked_sub(1).map_or(0, |last| self.corners(last).end)
    }

    /// The corner after each.
    pub fn next_corners(&self) -> Vec<u32> {
        let mut next = Vec::with_capacity(self.corners_of_first(self.count()));
        for face in self.all() {
            next.extend(face.clone().map(|corner| after(corner, &face) as u32));
        }
        next
    }

    pub fn are_triangles(&self) -> bool {
        match self {
            Self::Ends(_) => self.all().all(|face| face.len() == 3),
            Self::Equal { corners, .. } => *corners == 3,
        }
    }

    /// The faces of the next level, those of a face next to each other. There are so many `corners`.
    pub fn refined(&self, split: Split, corners: usize) -> Self {
        match split {
            Split::Quads => Self::Equal {
                corners: 4,
                count: corners as u32,
            },
            Split::Triangles => Self::Equal {
                corners: 3,
                count: 4 * self.count() as u32,
            },
        }
    }
}

/// The way in which a scheme splits these faces.
pub fn split_of(scheme: Scheme, faces: &Faces) -> Split {
    match scheme {
        Scheme::CatmullClark => Split::Quads,
        Scheme::Loop => Split::Triangles,
        Scheme::Linear if faces.are_triangles() => Split::Triangles,
        Scheme::Linear => Split::Quads,
    }
}

/// The vertices at the corners of faces, and the edges between them.
///
/// A surface has two of them over the same faces: one of places, and one of values, of which there are several at a place where the
/// surface has a seam.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Net {
    pub vertices: u32,
    /// The vertex of each corner.
    pub corners: Vec<u32>,
    /// The edge from each corner to the next one of its face.
    pub edge_of: Vec<u32>,
    /// The ends of each edge.
    pub edges: Vec<[u32; 2]>,
}

impl Net {
    /// The half of the edge `edge` that is at `vertex`, by its number in the next level.
    fn half(&self, edge: u32, vertex: u32) -> u32 {
        2 * edge + u32::from(self.edges[edge as usize][0] != vertex)
    }

    /// The net of the next level. Its vertices are those of this one, then one for each edge, then, of quadrilaterals, one for each
    /// face. Its edges are the two halves of each edge, then those within faces.
    pub fn refined(&self, faces: &Faces, split: Split) -> Self {
        let (old_edges, inner) = (self.edges.len(), self.corners.len());
        let first_middle = self.vertices;
        let first_center = first_middle + old_edges as u32;
        let first_inner = 2 * old_edges as u32;
        let of_corner = 4 * inner;
        let mut fine = Self {
            vertices: match split {
                Split::Quads => first_center + faces.count() as u32,
                Split::Triangles => first_center,
            },
            corners: Vec::with_capacity(of_corner),
            edge_of: Vec::with_capacity(of_corner),
            edges: Vec::with_capacity(2 * old_edges + inner),
        };
        for (edge, ends) in (first_middle..).zip(&self.edges) {
            fine.edges.extend(ends.map(|end| [end, edge]));
        }
        for (center, face) in (first_center..).zip(faces.all()) {
            for corner in face.clone() {
                let before = before(corner, &face);
                let (vertex, inner) = (self.corners[corner], first_inner + corner as u32);
                let [out, into] = [corner, before].map(|c| self.edge_of[c]);
                let [middle, last] = [out, into].map(|edge| first_middle + edge);
                let [first_half, last_half] = [out, into].map(|edge| self.half(edge, vertex));
                match split {
                    Split::Quads => {
                        fine.edges.push([middle, center]);
                        fine.corners.extend([vertex, middle, center, last]);
                        let back = first_inner + before as u32;
                        fine.edge_of.extend([first_half, inner, back, last_half]);
                    }
                    Split::Triangles => {
                        fine.edges.push([middle, last]);
                        fine.corners.extend([vertex, middle, last]);
                        fine.edge_of.extend([first_half, inner, last_half]);
                    }
                }
            }
            if split == Split::Triangles {
                let start = face.start;
                fine.corners.extend(face.map(|c| first_middle + self.edge_of[c]));
                fine.edge_of.extend([1, 2, 0].map(|k| first_inner + (start + k) as u32));
            }
        }
        fine
    }
}

/// The corner of a face before `corner`.
pub fn before(corner: usize, face: &Range<usize>) -> usize {
    if corner == face.start { face.end - 1 } else { corner - 1 }
}

/// The corner of a face after `corner`.
pub fn after(corner: usize, face: &Range<usize>) -> usize {
    if corner + 1 == face.end { face.start } else { corner + 1 }
}

/// The values of the next level by linear interpolation: those of the vertices, the means of the ends of each edge and, of
/// quadrilaterals, the means of the corners of each face. Without values there are none.
pub fn interpolated<T>(values: &[T], net: &Net, faces: &Faces, split: Split) -> Vec<T>
where
    T: Copy + Default + Add<Output = T> + Div<f64, Output = T>,
{
    if values.is_empty() {
        return Vec::new();
    }
    let at = |vertex: u32| values[vertex as usize];
    let middles = net.edges.iter().map(|[a, b]| (at(*a) + at(*b)) / 2.0);
    let mut fine: Vec<T> = values.iter().copied().chain(middles).collect();
    if split == Split::Quads {
        fine.extend(faces.all().map(|face| mean(&net.corners[face], at)));
    }
    fine
}

/// The mean at these vertices.
pub fn mean<T>(vertices: &[u32], at: impl Fn(u32) -> T) -> T
where
    T: Default + Add<Output = T> + Div<f64, Output = T>,
{
    let sum = vertices.iter().fold(T::default(), |sum, vertex| sum + at(*vertex));
    sum / vertices.len() as f64
}
