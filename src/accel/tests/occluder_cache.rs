//! Tests of shadow rays that the occluder cache resolves.

use super::*;
use crate::accel::{
    kernels::{occluded_at_once, packet::order::PacketOrder},
    wide::Wide,
};

/// Returns groups of 64 rays with nearby origins that go to a point light or an area light per
/// group. They start at a vertex of the scene or anywhere. One in `odd` rays is unlike the others
/// of its group.
fn groups(g: &Geometry, count: usize, size: f32, odd: usize) -> Vec<Ray> {
    let mut r = Random(41);
    let mut rays = Vec::new();
    for group in 0..count {
        let at = match group % 3 {
            0 => r.vec(1.5 * size),
            _ => g.corners(r.below(g.triangles.len()))[r.below(3)],
        };
        let lamp = match group % 4 {
            0 => at + [Vec3::X, Vec3::NEG_Y, Vec3::Z][group / 4 % 3] * size,
            1 => r.vec(50.0 * size),
            _ => r.vec(2.0 * size),
        };
        let apart = [0.0, 1e-4, 0.02, 0.3][group / 3 % 4] * size;
        let wide = [0.0, 0.3, 1.0][group / 5 % 3] * size;
        for _ in 0..64 {
            let o = at + r.vec(apart);
            let mut ray = Ray::segment(o, lamp + r.vec(wide) - o, 0.999);
            match r.below(8 * odd) {
                0 => ray.d = r.vec(1.0),
                1 => ray.d.y = 0.0,
                2 => ray.d.z = f32::NAN,
                3 => ray.tmax = [f32::NAN, f32::INFINITY][group % 2],
                4 => ray.tmin = [f32::NAN, -r.unit() * size][group % 2],
                5 => ray.o.x = [f32::NAN, f32::INFINITY, 1e30][group % 3],
                6 => ray.d *= [1e-30, 1e-3, 1e9][group % 3],
                7 => ray = Ray::NONE,
                _ => {}
            }
            rays.push(ray);
        }
    }
    rays
}

/// Returns the number of `rays` that are left for traversal, or `None` if all are. Fails at the
/// first ray that is resolved otherwise than by the linear scan.
fn left(g: &Arc<Geometry>, rays: &[Ray]) -> Option<usize> {
    let mut truth = vec![false; rays.len()];
    let linear = build(AccelKind::Linear, g.clone()).expect("the scene is valid");
    linear.occluded(rays, &mut truth);
    let mut counts = vec![];
    for simd in Isa::available() {
        let wide = Wide::build(g.clone(), Quality::default(), simd).expect("the scene is valid");
        let mut blocked = vec![false; rays.len()];
        wide.occluded(rays, &mut blocked);
        assert_eq!(blocked, truth, "{simd}");
        let mut remaining = vec![];
        for order in [
            PacketOrder::ROWS,
            PacketOrder::blocks(4, 16),
            PacketOrder::blocks(8, 1024),
        ] {
            let mut blocked = vec![false; rays.len()];
            let pays = occluded_at_once(simd, &wide.tree, rays, order, &mut blocked, &mut remaining);
            let mut is_left = vec![!pays; rays.len()];
            for id in remaining.iter().filter(|_| pays) {
                assert!(!is_left[*id as usize], "it is left twice");
                is_left[*id as usize] = true;
            }
            for (i, ray) in rays.iter().enumerate() {
                let right = blocked[i] == truth[i] || is_left[i] && !blocked[i];
                assert!(right, "{simd}, {order:?}, ray {i}: {ray:?}");
            }
            if order == PacketOrder::ROWS {
                counts.push(pays.then_some(remaining.len()));
            }
        }
    }
    assert!(counts.iter().all(|count| *count == counts[0]), "{counts:?}");
    counts[0]
}

/// Returns objects under a roof of two triangles, with a floor.
pub(super) fn under_a_roof(spheres: usize, triangles: usize) -> Geometry {
    let mut g = soup(triangles, spheres, 0.05);
    g.vertices.iter_mut().for_each(|p| p.y = 0.3 * p.y - 0.3);
    for (y, half) in [(0.5, 1.5), (-0.7, 4.0)] {
        let first = g.vertices.len() as u32;
        let corner = |x: f32, z: f32| Vec3::new(half * x, y, half * z);
        g.vertices.extend([
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ]);
        g.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| first + k)));
    }
    g
}

/// Returns groups of 64 rays with nearby origins at this height that go to one light above the
/// roof.
pub(super) fn to_a_lamp(count: usize, height: f32, reach: f32) -> Vec<Ray> {
    let mut r = Random(3);
    let mut rays = Vec::new();
    for _ in 0..count {
        let at = r.vec(1.0);
        for _ in 0..64 {
            let apart = r.vec(0.02);
            let o = Vec3::new(at.x + apart.x, height, at.z + apart.z);
            let to = Vec3::new(7.0, 9.0, 5.0) - o;
            rays.push(match reach {
                f32::INFINITY => Ray::new(o, to.normalize()),
                _ => Ray::segment(o, to, reach),
            });
        }
    }
    rays
}

#[test]
fn rays_that_leave_a_roof_are_in_the_open() {
    let g = Arc::new(under_a_roof(10, 2000));
    for reach in [0.999, f32::INFINITY] {
        let rays = to_a_lamp(50, 0.5_f32.next_up(), reach);
        assert_eq!(left(&g, &rays), Some(0));
    }
}

#[test]
fn rays_under_a_roof_are_in_its_shadow() {
    let g = Arc::new(under_a_roof(10, 2000));
    for reach in [0.999, f32::INFINITY] {
        let rays = to_a_lamp(50, 0.2, reach);
        assert!(left(&g, &rays).is_some_and(|left| left < rays.len() / 2));
        let on_the_floor = to_a_lamp(50, -0.69, reach);
        left(&g, &on_the_floor);
    }
}

#[test]
fn rays_that_end_before_a_roof_are_not_in_its_shadow() {
    let g = Arc::new(under_a_roof(10, 2000));
    assert_eq!(left(&g, &to_a_lamp(50, 0.2, 0.02)), Some(0));
}

#[test]
fn rays_through_a_roofs_edges_go_the_way_they_go_by_themselves() {
    let g = Arc::new(under_a_roof(0, 2000));
    let mut r = Random(17);
    let roof = g.triangles.len() - 4;
    let mut rays = Vec::new();
    let lamp = to_a_lamp(200, 0.2, 0.999);
    for (group, to_lamp) in lamp.chunks(64).enumerate() {
        // So that the roof is found.
        rays.extend_from_slice(to_lamp);
        let at = Vec3::new(1.4 * r.unit(), 0.2, 1.4 * r.unit());
        for k in 0..64 {
            let o = at + r.vec(1e-3);
            // Mainly along x, y or z.
            let [a, b, c] = g.corners(roof + group % 2);
            let edge = [(a, b), (b, c), (c, a)][group / 2 % 3];
            let to = match k % 2 {
                0 => edge.0 + (edge.1 - edge.0) * r.unit(),
                _ => Vec3::new(0.3 * r.unit(), 0.5, 0.3 * r.unit()),
            };
            rays.push(Ray::segment(o, 1.5 * (to - o), 0.999));
        }
    }
    assert!(left(&g, &rays).is_some_and(|left| left < rays.len() / 2));
}

#[test]
fn it_is_not_tried_further_where_little_is_answered() {
    let g = Arc::new(soup(3000, 40, 0.3));
    assert_eq!(left(&g, &groups(&g, 100, 1.0, 1_000_000)), None);
}

#[test]
fn rays_answered_at_once_equal_the_linear_scan_beside_odd_ones() {
    let trees = [
        under_a_roof(10, 2000),
        soup(300, 40, 0.3),
        grid(12, 0.0),
        grid(48, 0.05),
        rooms(),
    ];
    for g in trees.map(Arc::new) {
        for odd in [1, 8, 64] {
            let mut rays = groups(&g, 60, 1.0, odd);
            // Enough unoccluded rays that the others are tried as well.
            rays.extend(to_a_lamp(60, 2.0, 0.999));
            assert!(left(&g, &rays).is_some());
        }
    }
}

#[test]
fn rays_answered_at_once_equal_the_linear_scan_in_scenes_of_any_size() {
    for size in [1e-18, 1e-9, 1e9] {
        let mut g = under_a_roof(0, 2000);
        g.vertices.iter_mut().for_each(|p| *p *= size);
        let mut rays = to_a_lamp(40, 0.2, 0.999);
        rays.extend(to_a_lamp(40, 0.5_f32.next_up(), 0.999));
        rays.iter_mut()
            .for_each(|ray| (ray.o, ray.d) = (ray.o * size, ray.d * size));
        let g = Arc::new(g);
        assert!(left(&g, &rays).is_some(), "{size}");
        left(&g, &groups(&g, 60, size, 30));
    }
}
