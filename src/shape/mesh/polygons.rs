//! The faces of a mesh before they become triangles.

/// Faces with any number of corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polygons {
    /// The vertices of all faces, one face after another.
    corners: Vec<u32>,
    /// The end of each face among the corners.
    ends: Vec<usize>,
}

impl Polygons {
    pub fn push(&mut self, face: &[u32]) {
        self.corners.extend(face);
        self.ends.push(self.corners.len());
    }

    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The vertices of each face.
    pub fn faces(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| &self.corners[start..*end])
    }

    /// The vertices of all faces.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// The bytes of its arrays.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.corners[..]) + size_of_val(&self.ends[..])) as u64
    }

    /// Forgets faces of three corners alone: they are the triangles of the mesh.
    pub fn without_triangles(self) -> Self {
        let are_triangles = self.faces().all(|face| face.len() == 3);
        match are_triangles {
            true => Self::default(),
            false => self,
        }
    }

    /// The faces whose vertices are all kept, by their new numbers.
    pub fn renumbered(&self, number: impl Fn(u32) -> Option<u32>) -> Self {
        let mut kept = Self::default();
        for face in self.faces() {
            if let Some(face) = face.iter().map(|v| number(*v)).collect::<Option<Vec<u32>>>() {
                kept.push(&face);
            }
        }
        kept
    }
}
