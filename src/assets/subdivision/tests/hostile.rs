//! Faces of strange topology.

use glam::DVec3;

use super::{CageRules, SMOOTH, limit, surface_of};
use crate::{
    math::Vec3,
    shape::mesh::{Mesh, Scheme},
};

#[test]
fn faces_that_lose_corners_and_odd_edges_do_no_harm() {
    // A sheet with three wings, a cone whose base is a point, a face with a corner twice, and one
    // that is wound the other way round.
    let positions = [
        Vec3::ZERO,
        Vec3::Y,
        Vec3::X,
        Vec3::new(-1.0, 0.0, 0.5),
        Vec3::new(-1.0, 0.0, -0.5),
        Vec3::ZERO,
        Vec3::new(0.0, -0.0, -0.0),
    ];
    let hostile: [Vec<Vec<u32>>; 6] = [
        vec![vec![0, 1, 2], vec![0, 1, 3], vec![1, 0, 4]],
        vec![vec![0, 5, 6, 1]],
        vec![vec![0, 5, 1, 2], vec![0, 0, 0], vec![1, 1, 1, 1]],
        vec![vec![0, 1, 0, 2], vec![0, 1, 2, 0, 3, 4]],
        vec![vec![0, 1, 2], vec![0, 1, 3], vec![0, 1, 2], vec![2, 1, 0]],
        vec![],
    ];
    for faces in &hostile {
        for rules in [
            SMOOTH,
            CageRules {
                crease_cos: 0.9,
                crease_sharpness: 0.7,
                keeps_corners: true,
            },
        ] {
            let whole = surface_of(&positions, faces, &rules);
            let schemes: &[Scheme] = match whole.faces.are_triangles() {
                true => &Scheme::ALL,
                false => &[Scheme::CatmullClark, Scheme::Linear],
            };
            for scheme in schemes {
                let surface = limit(whole.clone(), *scheme, 3);
                assert!(surface.positions.iter().all(|p| p.is_finite()));
                let mesh = &surface.meshes([&Mesh::default()].into_iter())[0];
                assert_eq!(mesh.validate(), Ok(()));
            }
        }
    }
    let wings = limit(surface_of(&positions, &hostile[0], &SMOOTH), Scheme::Loop, 2);
    assert_eq!(
        wings.positions[..2],
        [DVec3::ZERO, DVec3::Y],
        "an edge of three faces is a crease"
    );
}
