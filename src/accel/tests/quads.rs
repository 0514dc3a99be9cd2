//! Parallelograms, which trees hold as triangles, among triangles and other shapes.

use super::*;
use crate::{
    math::{DVec3, Transform},
    shape::quad::Quad,
};

fn quad(corners: [Vec3; 4]) -> Quad {
    Quad::from_corners(corners)
}

/// Returns walls that share edges, tilted and skewed quads, one that is no parallelogram, and moved, mirrored and flattened ones.
fn walls() -> (Geometry, Vec<[Vec3; 4]>) {
    let mut g = soup(60, 10, 0.3);
    let mut r = Random(31);
    let mut all = Vec::new();
    let mut add = |g: &mut Geometry, o: Vec3, e: Vec3, f: Vec3, transform: Option<Transform>| {
        let corners = [o, o + e, o + e + f, o + f];
        g.add_shape(quad(corners).into(), transform);
        all.push(corners.map(|c| transform.map_or(c, |t| t.point_to_world(c))));
    };
    for axis in 0..3 {
        let [a, b, c] = [0, 1, 2].map(|k| Vec3::AXES[(axis + k) % 3]);
        for at in [-1.0, 1.0] {
            add(&mut g, a * at - b - c, b, c * 2.0, None);
            add(&mut g, a * at - c, b, c * 2.0, None);
        }
    }
    for _ in 0..10 {
        let [o, e, f] = [0.8, 0.5, 0.5].map(|size| r.vec(size));
        add(&mut g, o, e, f, None);
        for scale in [
            DVec3::new(0.5, 1.5, 1.0),
            DVec3::new(1.0, -0.7, 1.0),
            DVec3::splat(-1.0),
        ] {
            let [translate, rotate] = [0.4, 180.0].map(|size| r.vec(size).as_dvec3());
            let t = Transform::from_parts(translate, rotate, scale).expect("it can be inverted");
            add(&mut g, o, e, f, Some(t));
        }
    }
    let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::new(0.7, 0.6, 0.0), Vec3::Y];
    g.add_shape(quad([a, b, c, d]).into(), None);
    (g, all)
}

#[test]
fn every_accelerator_equals_the_linear_scan_on_parallelograms() {
    let (g, corners) = walls();
    let mut rays = rays(&g, 30_000);
    let mut r = Random(37);
    for i in 0..60_000 {
        let [a, b, c, d] = corners[r.below(corners.len())];
        let to = match i % 4 {
            0 => a + (c - a) * r.unit(),
            1 => a + (b - a) * r.unit(),
            2 => [a, b, c, d][r.below(4)],
            _ => a + (b - a) * r.unit() + (d - a) * r.unit(),
        };
        let o = [r.vec(0.9), r.vec(30.0), to + Vec3::AXES[r.below(3)]][i / 4 % 3];
        rays.push(Ray::new(o, to - o));
    }
    assert!(compare(g, &rays) > 60_000);
}

#[test]
fn camera_rays_meet_parallelograms_as_single_rays_do() {
    let (g, _) = walls();
    let rays: Vec<Ray> = (0..20_000)
        .map(|i| {
            let d = Vec3::new((i % 200) as f32 - 100.0, (i / 200) as f32 - 50.0, -150.0);
            Ray::new(Vec3::new(0.0, 0.0, 0.9), d)
        })
        .collect();
    assert!(compare(g, &rays) > 19_000);
}

#[test]
fn nothing_passes_between_walls_that_share_an_edge() {
    let mut g = Geometry::default();
    let at = |x: i32, z: i32| Vec3::new(x as f32 * 0.37, (x * x % 7) as f32 * 0.1, z as f32 * 0.73);
    for x in -10..10 {
        for z in -10..10 {
            g.add_shape(
                quad([at(x, z), at(x + 1, z), at(x + 1, z + 1), at(x, z + 1)]).into(),
                None,
            );
        }
    }
    let accel = build(AccelKind::Wide, Arc::new(g)).expect("the scene is valid");
    let mut r = Random(41);
    let rays: Vec<Ray> = (0..50_000)
        .map(|_| {
            let (x, z) = (r.below(19) as i32 - 9, r.below(19) as i32 - 9);
            let to = at(x, z) + (at(x + 1, z + 1) - at(x, z)) * if r.below(2) == 0 { 0.0 } else { r.unit() };
            let o = to + Vec3::new(r.unit() - 0.5, 5.0, r.unit() - 0.5);
            Ray::new(o, to - o)
        })
        .collect();
    let mut hits = vec![None; rays.len()];
    accel.nearest_batch(RayBatch::unordered(&rays), &mut hits);
    assert!(hits.iter().all(Option::is_some));
}
