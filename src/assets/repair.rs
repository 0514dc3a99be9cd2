//! Numbers of a mesh that are not finite: each costs its vertex or its attribute, never the model.

use std::ops::AddAssign;

use crate::{
    math::{Vec2, Vec3, Vec4},
    shape::mesh::Mesh,
};

/// The numbers of elements that were repaired.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Repairs {
    vertices: usize,
    normals: usize,
    uvs: usize,
    colors: usize,
    tangents: usize,
}

impl AddAssign for Repairs {
    fn add_assign(&mut self, other: Self) {
        self.vertices += other.vertices;
        self.normals += other.normals;
        self.uvs += other.uvs;
        self.colors += other.colors;
        self.tangents += other.tangents;
    }
}

impl Repairs {
    /// A fault for each kind of element.
    pub fn faults(&self) -> impl Iterator<Item = String> {
        let lines = [
            (self.vertices, "vertices", "left out"),
            (self.normals, "normals", "replaced by those of the faces"),
            (self.uvs, "texture coordinates", "set to 0"),
            (self.colors, "colours", "set to white"),
            (self.tangents, "tangents", "set to any direction in the surface"),
        ];
        let said = lines.into_iter().filter(|(count, ..)| *count > 0);
        said.map(|(count, what, how)| format!("{what} that are not finite are {how}: {count}"))
    }
}

/// Leaves out vertices without a finite position and the triangles that use them, and replaces other numbers that are not
/// finite: normals by those of the faces, texture coordinates by 0, colours by white, tangents by any direction in the surface.
/// A mesh with arrays that do not fit each other stays as it is.
pub(super) fn repair(mesh: &mut Mesh) -> Repairs {
    let vertices = mesh.positions.len();
    let lengths = [
        mesh.normals.len(),
        mesh.uvs.len(),
        mesh.second_uvs.len(),
        mesh.colors.len(),
        mesh.tangents.len(),
    ];
    let fits = lengths.iter().all(|length| *length == 0 || *length == vertices)
        && mesh
            .triangles
            .iter()
            .flatten()
            .chain(mesh.polygons.corners())
            .all(|v| (*v as usize) < vertices);
    if !fits {
        return Repairs::default();
    }
    let vertices = remove_vertices(mesh);
    let normals = replace(&mut mesh.normals, |n| n.is_finite(), |_| Vec3::ZERO);
    let across = |i: usize| {
        let normal = mesh.normals.get(i).and_then(|n| n.try_normalize());
        normal.unwrap_or(Vec3::Z).any_orthonormal_vector().extend(1.0)
    };
    let [first, second] = mesh.uv_origins;
    Repairs {
        vertices,
        normals,
        uvs: replace(&mut mesh.uvs, |t| t.is_finite(), |_| Vec2::ZERO - first)
            + replace(&mut mesh.second_uvs, |t| t.is_finite(), |_| Vec2::ZERO - second),
        colors: replace(&mut mesh.colors, |c| c.is_finite(), |_| Vec4::ONE),
        tangents: replace(&mut mesh.tangents, |t| t.is_finite(), across),
    }
}

/// Replaces what is not `sound`; returns how many were.
fn replace<T>(values: &mut [T], sound: impl Fn(&T) -> bool, instead: impl Fn(usize) -> T) -> usize {
    let mut count = 0;
    for (i, value) in values.iter_mut().enumerate() {
        if !sound(value) {
            *value = instead(i);
            count += 1;
        }
    }
    count
}

/// Removes vertices without a finite position, and their triangles; returns how many vertices.
fn remove_vertices(mesh: &mut Mesh) -> usize {
    let is_kept: Vec<bool> = mesh.positions.iter().map(|p| p.is_finite()).collect();
    let lost = is_kept.iter().filter(|kept| !**kept).count();
    if lost == 0 {
        return 0;
    }
    let mut next = 0;
    let numbers: Vec<u32> = is_kept
        .iter()
        .map(|kept| {
            let own = next;
            next += u32::from(*kept);
            own
        })
        .collect();
    mesh.triangles.retain(|t| t.iter().all(|v| is_kept[*v as usize]));
    for vertex in mesh.triangles.iter_mut().flatten() {
        *vertex = numbers[*vertex as usize];
    }
    let number = |v: u32| is_kept[v as usize].then_some(numbers[v as usize]);
    mesh.polygons = mesh.polygons.renumbered(number);
    retain(&mut mesh.positions, &is_kept);
    retain(&mut mesh.normals, &is_kept);
    retain(&mut mesh.uvs, &is_kept);
    retain(&mut mesh.second_uvs, &is_kept);
    retain(&mut mesh.colors, &is_kept);
    retain(&mut mesh.tangents, &is_kept);
    lost
}

/// Keeps these elements of an array that may be empty.
fn retain<T>(values: &mut Vec<T>, is_kept: &[bool]) {
    let mut kept = is_kept.iter();
    values.retain(|_| *kept.next().unwrap_or(&true));
}

/// The least and the largest of the finite numbers of colours, and whether they are display values up to 255 rather than up to
/// 1: one is above 16, or they are whole numbers and one is above 1.
pub(super) fn color_range(channels: impl Iterator<Item = f32>) -> (f32, f32, bool) {
    let (mut least, mut most, mut is_whole) = (0.0_f32, 0.0_f32, true);
    for v in channels.filter(|v| v.is_finite()) {
        (least, most) = (least.min(v), most.max(v));
        is_whole &= v.fract() == 0.0;
    }
    (least, most, most > 16.0 || most > 1.0 && is_whole)
}

/// Whether a word stands for a number that is not finite, as the libraries of several languages write it: `nan`, `-inf`,
/// `1.#IND`, `-nan(ind)`.
pub(super) fn is_not_finite(word: &[u8]) -> bool {
    let word = word.strip_prefix(b"-").or(word.strip_prefix(b"+")).unwrap_or(word);
    let begins = |with: &[u8]| word.get(..with.len()).is_some_and(|w| w.eq_ignore_ascii_case(with));
    begins(b"nan") || begins(b"inf") || begins(b"1.#")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y, Vec3::NAN],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            normals: vec![Vec3::Z; 5],
            ..Mesh::default()
        }
    }

    #[test]
    fn a_position_costs_its_vertex_and_its_triangles_alone() {
        let mut mesh = square();
        let faults: Vec<_> = repair(&mut mesh).faults().collect();
        assert_eq!(faults, ["vertices that are not finite are left out: 1"]);
        assert_eq!(
            (mesh.positions.len(), mesh.triangles.len(), mesh.validate()),
            (4, 2, Ok(()))
        );
        let mut mesh = square();
        mesh.positions[1].y = f32::INFINITY;
        repair(&mut mesh);
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
        assert_eq!(mesh.validate(), Ok(()));
    }

    #[test]
    fn other_numbers_are_replaced_and_counted() {
        let mut mesh = square();
        mesh.positions[4] = Vec3::ONE;
        mesh.normals[0].x = f32::NAN;
        mesh.uvs = vec![Vec2::NAN; 5];
        mesh.colors = vec![Vec4::INFINITY; 5];
        mesh.tangents = vec![Vec4::NAN; 5];
        assert_eq!(repair(&mut mesh).faults().count(), 4);
        assert_eq!(
            (mesh.normals[0], mesh.uvs[1], mesh.colors[2]),
            (Vec3::ZERO, Vec2::ZERO, Vec4::ONE)
        );
        assert!(mesh.tangents[1].truncate().dot(Vec3::Z).abs() < 1e-6);
        assert_eq!(mesh.validate(), Ok(()));
        assert_eq!(repair(&mut mesh), Repairs::default());
    }

    #[test]
    fn words_for_no_number_are_known() {
        assert!(
            ["nan", "-NaN", "-nan(ind)", "inf", "-Infinity", "1.#IND", "-1.#QNAN"]
                .iter()
                .all(|w| is_not_finite(w.as_bytes()))
        );
        assert!(
            !["1", "-1.5e3", "x", "north", "#", ""]
                .iter()
                .any(|w| is_not_finite(w.as_bytes()))
        );
    }
}
