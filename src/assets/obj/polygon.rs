//! Triangulation of faces.

use glam::{DVec2, DVec3};

use crate::math::Vec3;

/// The most corners of a face that is cut, which may take quadratic time; larger faces become fans.
const MOST_CORNERS: usize = 10_000;

/// Calls `triangle` with three indices into `corners` for each triangle of a face, with the winding of the face.
///
/// A convex face becomes a fan, a concave one is cut in its plane. A face with a corner that is not finite has no triangles.
pub(in crate::assets) fn triangulate(corners: &[Vec3], mut triangle: impl FnMut([usize; 3])) {
    if corners.len() < 3 || !corners.iter().all(|c| c.is_finite()) {
        return;
    }
    if corners.len() > 3 {
        let flat = projected(corners);
        if corners.len() <= MOST_CORNERS && !is_convex(&flat) {
            let coordinates: Vec<f64> = flat.iter().flat_map(|p| [p.x, p.y]).collect();
            if let Some(cut) = earcutr::earcut(&coordinates, &[], 2).ok().filter(|cut| !cut.is_empty()) {
                return cut
                    .chunks_exact(3)
                    .for_each(|t| triangle(oriented(&flat, [t[0], t[1], t[2]])));
            }
        }
    }
    (1..corners.len() - 1).for_each(|i| triangle([0, i, i + 1]));
}

/// The corners in the face's plane, counterclockwise; the plane's normal is Newell's.
fn projected(corners: &[Vec3]) -> Vec<DVec2> {
    let first = corners[0].as_dvec3();
    let at = |i: usize| corners[i % corners.len()].as_dvec3() - first;
    let normal: DVec3 = (0..corners.len()).map(|i| at(i).cross(at(i + 1))).sum();
    let Some(normal) = normal.try_normalize() else {
        return vec![DVec2::ZERO; corners.len()];
    };
    let (x, y) = normal.any_orthonormal_pair();
    // Makes x, y and the normal right-handed.
    let y = if x.cross(y).dot(normal) < 0.0 { -y } else { y };
    (0..corners.len())
        .map(|i| DVec2::new(at(i).dot(x), at(i).dot(y)))
        .collect()
}

/// Whether every corner of the face turns to the left, and once around in all.
fn is_convex(flat: &[DVec2]) -> bool {
    let n = flat.len();
    let edge = |i: usize| flat[(i + 1) % n] - flat[i % n];
    let turns_left = (0..n).all(|i| edge(i).perp_dot(edge(i + 1)) >= 0.0);
    // A star also turns left everywhere, but its edges change direction between left and right more than twice.
    let signs: Vec<bool> = (0..n)
        .map(|i| edge(i).x)
        .filter(|x| *x != 0.0)
        .map(|x| x > 0.0)
        .collect();
    let changes = (0..signs.len())
        .filter(|i| signs[*i] != signs[(i + 1) % signs.len()])
        .count();
    turns_left && changes <= 2
}

fn oriented(flat: &[DVec2], [a, b, c]: [usize; 3]) -> [usize; 3] {
    if (flat[b] - flat[a]).perp_dot(flat[c] - flat[a]) < 0.0 {
        [a, c, b]
    } else {
        [a, b, c]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum of the triangles' areas, and whether each is wound like +z.
    fn cut(corners: &[Vec3]) -> (f32, bool) {
        let (mut area, mut up) = (0.0, true);
        triangulate(corners, |t| {
            let [a, b, c] = t.map(|i| corners[i]);
            let n = (b - a).cross(c - a) * 0.5;
            area += n.length();
            up &= n.z >= 0.0;
        });
        (area, up)
    }

    #[test]
    fn concave_faces_keep_their_area_and_their_side() {
        let p = |x: f32, y: f32| Vec3::new(x, y, 2.0);
        let dart = [p(0.0, 0.0), p(4.0, 0.0), p(1.0, 1.0), p(0.0, 4.0)];
        assert_eq!(cut(&dart), (4.0, true));
        let shifted = [dart[1], dart[2], dart[3], dart[0]];
        assert_eq!(cut(&shifted), (4.0, true));
        let l = [
            p(0.0, 0.0),
            p(2.0, 0.0),
            p(2.0, 1.0),
            p(1.0, 1.0),
            p(1.0, 2.0),
            p(0.0, 2.0),
        ];
        assert_eq!(cut(&l), (3.0, true));
        let from_behind: Vec<_> = l.iter().rev().copied().collect();
        let (area, up) = cut(&from_behind);
        assert_eq!((area, up), (3.0, false));
    }

    #[test]
    fn convex_faces_are_fans_and_faces_without_area_do_no_harm() {
        let mut fan = Vec::new();
        triangulate(&[Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y + Vec3::Z], |t| fan.push(t));
        assert_eq!(fan, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(cut(&[Vec3::ZERO; 6]).0, 0.0);
        assert_eq!(cut(&[Vec3::ZERO, Vec3::X]).0, 0.0);
    }
}
