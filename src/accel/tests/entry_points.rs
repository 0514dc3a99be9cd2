//! Tests of shadow rays that start at entry points below the root.

use super::*;
use crate::accel::{
    kernels::{occluded_stream, packet::order::PacketOrder, ray_selection::RaySelection, scratch::Scratch},
    wide::Wide,
};

/// Returns groups of 64 rays with nearby origins that go to a point light or an area light per
/// group. They start at a vertex of the scene or anywhere. One in `odd` rays is unlike the others
/// of its group.
pub(super) fn groups(g: &Geometry, count: usize, size: f32, odd: usize) -> Vec<Ray> {
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

/// Fails at the first ray whose occlusion differs from that of the linear scan. Returns the number
/// of blocked rays.
fn compare_with_scan(g: Geometry, rays: &[Ray]) -> usize {
    let g = Arc::new(g);
    let mut truth = vec![false; rays.len()];
    let linear = build(AccelKind::Linear, g.clone()).expect("the scene is valid");
    linear.occluded(rays, &mut truth);
    for simd in Isa::available() {
        let wide = Wide::build(g.clone(), Quality::default(), simd).expect("the scene is valid");
        for order in [
            PacketOrder::ROWS,
            PacketOrder::blocks(4, 16),
            PacketOrder::blocks(8, 1024),
        ] {
            let mut blocked = vec![false; rays.len()];
            let mut list = vec![];
            order.put(rays.len(), &mut list);
            let selection = RaySelection::Together(&list);
            occluded_stream(simd, &wide.tree, &g, rays, selection, &mut blocked, &mut Scratch::new());
            for (i, ray) in rays.iter().enumerate() {
                assert_eq!(blocked[i], truth[i], "{simd}, {order:?}, ray {i}: {ray:?}");
            }
        }
    }
    truth.iter().filter(|blocked| **blocked).count()
}

fn trees() -> [Geometry; 4] {
    [soup(3000, 40, 0.1), grid(48, 0.05), grid(12, 0.0), rooms()]
}

#[test]
fn rays_that_begin_together_equal_the_linear_scan() {
    for g in trees() {
        let rays = groups(&g, 150, 1.0, 1_000_000);
        let blocked = compare_with_scan(g, &rays);
        assert!(blocked > rays.len() / 20 && blocked < rays.len() * 19 / 20, "{blocked}");
    }
}

#[test]
fn rays_that_begin_together_equal_the_linear_scan_beside_odd_ones() {
    for g in trees() {
        for odd in [1, 8, 64] {
            let rays = groups(&g, 60, 1.0, odd);
            compare_with_scan(g.clone(), &rays);
        }
    }
}

#[test]
fn rays_that_begin_together_equal_the_linear_scan_in_scenes_of_any_size() {
    for size in [1e-18, 1e-9, 1e9] {
        let mut g = soup(2000, 0, 0.1);
        g.vertices.iter_mut().for_each(|p| *p *= size);
        let rays = groups(&g, 60, size, 30);
        compare_with_scan(g, &rays);
    }
}

#[test]
fn any_number_of_rays_begins_together() {
    for count in [1, 15, 16, 17, 63, 255, 256, 257, 1000] {
        let g = soup(500, 0, 0.2);
        let mut rays = groups(&g, 16, 1.0, 1_000_000);
        rays.truncate(count);
        compare_with_scan(g, &rays);
    }
}

#[test]
fn rays_begin_at_their_own_heads_however_many_between_them_are_known() {
    let g = Arc::new(grid(300, 0.05));
    let mut r = Random(7);
    let mut rays = Vec::new();
    for _ in 0..1500 {
        let at = g.corners(r.below(g.triangles.len()))[0];
        let lamp = at + r.vec(1.0) + Vec3::new(0.0, 0.2, 0.0);
        for _ in 0..64 {
            let o = at + r.vec(1e-3);
            rays.push(Ray::segment(o, lamp - o, 0.999));
        }
    }
    let mut list = vec![];
    PacketOrder::ROWS.put(rays.len(), &mut list);
    for simd in Isa::available() {
        let wide = Wide::build(g.clone(), Quality::default(), simd).expect("the scene is valid");
        let mut scratch = Scratch::new();
        let mut alone = vec![false; rays.len()];
        occluded_stream(simd, &wide.tree, &g, &rays, RaySelection::All, &mut alone, &mut scratch);
        // One in `apart` groups has a few unresolved rays, the others have none.
        for apart in [1, 4, 5, 8, 9, 13] {
            let is_known = |i: usize| !(i / 64).is_multiple_of(apart) || i % 64 > 20;
            let mut blocked: Vec<bool> = (0..rays.len()).map(is_known).collect();
            let selection = RaySelection::Together(&list);
            let report = occluded_stream(simd, &wide.tree, &g, &rays, selection, &mut blocked, &mut scratch);
            assert_eq!(report.entry_points_pay, Some(true), "otherwise rays begin at the root");
            for i in (0..rays.len()).filter(|&i| !is_known(i)) {
                assert_eq!(blocked[i], alone[i], "{simd}, {apart} apart, ray {i}: {:?}", rays[i]);
            }
        }
    }
}
