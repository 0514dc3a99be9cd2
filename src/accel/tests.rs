//! Comparison of all accelerators with the linear scan.

use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::{
    geometry::*,
    math::{Ray, Vec3, hash},
    shape::{Shape, sphere::Sphere},
};

mod instances;
mod packets;
mod quads;
mod small;
mod trees;

/// A pseudorandom number generator with a fixed seed.
struct Random(u32);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 += 1;
        hash::unit_f32(hash::pcg4d([self.0, 7, 11, 13])[0])
    }

    fn vec(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.unit() - 0.5, self.unit() - 0.5, self.unit() - 0.5) * (2.0 * size)
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f32) as usize).min(n - 1)
    }
}

fn soup(triangles: usize, spheres: usize, size: f32) -> Geometry {
    let mut r = Random(1);
    let mut g = Geometry::default();
    for i in 0..triangles {
        let c = r.vec(1.0);
        g.vertices.extend([c, c + r.vec(size), c + r.vec(size)]);
        g.triangles.push([0, 1, 2].map(|k| (3 * i + k) as u32));
    }
    for _ in 0..spheres {
        g.add_shape(sphere(r.vec(1.0), 0.2 * size * (0.1 + r.unit())), None);
    }
    g
}

fn sphere(center: Vec3, radius: f32) -> Shape {
    Shape::Sphere(Sphere { center, radius })
}

/// Returns a square of `n` by `n` cells in y = 0 with bumps of `height`, with shared edges and many
/// equal boxes.
fn grid(n: usize, height: f32) -> Geometry {
    let mut g = Geometry::default();
    let mut r = Random(5);
    for z in 0..=n {
        for x in 0..=n {
            let place = |i: usize| i as f32 / n as f32 * 2.0 - 1.0;
            g.vertices.push(Vec3::new(place(x), height * r.unit(), place(z)));
        }
    }
    let at = |x: usize, z: usize| (z * (n + 1) + x) as u32;
    for z in 0..n {
        for x in 0..n {
            g.triangles.push([at(x, z), at(x + 1, z), at(x + 1, z + 1)]);
            g.triangles.push([at(x, z), at(x + 1, z + 1), at(x, z + 1)]);
        }
    }
    g
}

/// Returns random rays, axis-aligned rays, rays through vertices and edges, rays in planes of the
/// scene, short rays, and rays from far away.
fn rays(g: &Geometry, count: usize) -> Vec<Ray> {
    let mut r = Random(99);
    let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let point = |r: &mut Random| {
        if g.vertices.is_empty() {
            return r.vec(1.0);
        }
        let [a, b, c] = if g.triangles.is_empty() {
            [g.vertices[0]; 3]
        } else {
            g.corners(r.below(g.triangles.len()))
        };
        match r.below(3) {
            0 => a,
            1 => a + (b - a) * r.unit(),
            _ => a * 0.25 + b * 0.25 + c * 0.5,
        }
    };
    (0..count)
        .map(|i| {
            let mut ray = match i % 6 {
                0 => Ray::new(r.vec(1.5), r.vec(1.0)),
                1 => Ray::new(r.vec(1.5), axes[r.below(6)]),
                2 => {
                    let d = axes[r.below(6)];
                    Ray::new(point(&mut r) - d * 3.0, d)
                }
                3 => {
                    let o = r.vec(3.0);
                    Ray::new(o, point(&mut r) - o)
                }
                4 => {
                    let (a, b) = (point(&mut r), point(&mut r));
                    Ray::new(a, b - a)
                }
                _ => {
                    let o = r.vec(1.0) * 1e4;
                    Ray::new(o, point(&mut r) - o)
                }
            };
            match i % 11 {
                0 => ray.tmax = r.unit() * 2.0,
                1 => ray.tmin = r.unit(),
                2 => ray.tmin = -r.unit(),
                3 => ray.d = Vec3::new(-0.0, ray.d.y, ray.d.z),
                _ => {}
            }
            ray
        })
        .collect()
}

fn bits(hit: &Option<Hit>) -> Option<[u32; 5]> {
    hit.map(|h| {
        [
            h.t.to_bits(),
            h.u.to_bits(),
            h.v.to_bits(),
            h.prim.index(),
            h.instance.0,
        ]
    })
}

/// Fails at the first ray for which an accelerator and the linear scan disagree. Returns the number
/// of hits.
fn compare(g: Geometry, rays: &[Ray]) -> usize {
    let g = Arc::new(g);
    let run = |accel: Box<dyn Accelerator>| {
        let mut hits = vec![None; rays.len()];
        let mut blocked = vec![false; rays.len()];
        // These rays are incoherent, so they do not go into packets, whatever their layout.
        let layout = BatchLayout::Rows(16);
        accel.nearest_batch(RayBatch { rays, layout }, &mut hits);
        accel.occluded_batch(RayBatch { rays, layout }, &mut blocked);
        (hits, blocked)
    };
    let (truth, blocked) = run(build(AccelKind::Linear, g.clone()).expect("the scene is valid"));
    for (hit, blocked) in truth.iter().zip(&blocked) {
        assert_eq!(hit.is_some(), *blocked);
    }
    let check = |name: &str, accel: Result<Box<dyn Accelerator>, BuildError>| {
        let (hits, b) = run(accel.expect("the scene is valid"));
        for i in 0..rays.len() {
            assert_eq!(bits(&hits[i]), bits(&truth[i]), "{name}, ray {i}: {:?}", rays[i]);
            assert_eq!(b[i], blocked[i], "{name} occlusion, ray {i}: {:?}", rays[i]);
        }
    };
    check("bvh2", build(AccelKind::Bvh2, g.clone()));
    for simd in Isa::available() {
        let kind = AccelKind::Wide;
        check(&format!("wide {simd}"), build(BuildOptions { kind, simd }, g.clone()));
    }
    truth.iter().flatten().count()
}

#[test]
fn every_accelerator_equals_the_linear_scan_on_a_soup() {
    let g = soup(300, 40, 0.3);
    let rays = rays(&g, 100_000);
    assert!(compare(g, &rays) > 30_000);
}

#[test]
fn every_accelerator_equals_the_linear_scan_on_shared_edges() {
    let g = grid(16, 0.1);
    let rays = rays(&g, 100_000);
    assert!(compare(g, &rays) > 30_000);
}

#[test]
fn every_accelerator_equals_the_linear_scan_on_a_flat_grid() {
    let g = grid(16, 0.0);
    let rays = rays(&g, 100_000);
    assert!(compare(g, &rays) > 20_000);
}

#[test]
fn every_accelerator_equals_the_linear_scan_on_slivers() {
    let mut g = soup(200, 0, 0.5);
    for i in 0..200 {
        let [a, b] = [g.vertices[3 * i], g.vertices[3 * i + 1]];
        g.vertices[3 * i + 2] = a + (b - a) * 0.37 + Vec3::splat(if i % 2 == 0 { 0.0 } else { 1e-6 });
    }
    let rays = rays(&g, 100_000);
    compare(g, &rays);
}

/// Returns rooms: walls and floors of two triangles each, planks a hundred times as long as wide,
/// some of them inclined, and small objects between them.
fn rooms() -> Geometry {
    let mut g = soup(1500, 0, 0.04);
    let mut r = Random(17);
    let mut quad = |o: Vec3, a: Vec3, b: Vec3| {
        let first = g.vertices.len() as u32;
        g.vertices.extend([o, o + a, o + a + b, o + b]);
        g.triangles.push([0, 1, 2].map(|k| first + k));
        g.triangles.push([0, 2, 3].map(|k| first + k));
    };
    for axis in 0..3 {
        let [a, b, c] = [0, 1, 2].map(|k| Vec3::AXES[(axis + k) % 3]);
        for at in [-1.0, -0.3, 1.0] {
            quad(a * at - b - c, b * 2.0, c * 2.0);
        }
        for _ in 0..6 {
            quad(r.vec(0.9) - b, b * 2.0, c * 0.02);
        }
        for i in 0..40 {
            let along = if i % 2 == 0 { b + c } else { b - c };
            quad(r.vec(0.9) - along * 0.5, along, b * 0.01);
        }
    }
    g
}

#[test]
fn every_accelerator_equals_the_linear_scan_on_walls_that_are_cut() {
    let g = rooms();
    let mut r = Random(23);
    let mut rays = rays(&g, 60_000);
    // Rays along the walls, in them and just above, from near and from far.
    for i in 0..40_000 {
        let corners = g.corners(1500 + r.below(g.triangles.len() - 1500));
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize();
        let inside = |r: &mut Random| a + (b - a) * r.unit() + (c - b) * r.unit();
        let (from, to) = (inside(&mut r), inside(&mut r));
        let height = normal * [0.0, 1e-7, -1e-5, 1e-3, 0.3][i % 5];
        let d = (to - from).normalize_or_zero();
        let back = [0.0, 1.0, 50.0, 1e4][i / 5 % 4];
        rays.push(Ray::new(from + height * (1.0 + back) - d * back, d - height));
    }
    assert!(compare(g, &rays) > 30_000);
}

#[test]
fn every_accelerator_equals_the_linear_scan_across_magnitudes() {
    let mut g = soup(100, 10, 0.3);
    for (i, v) in g.vertices.iter_mut().enumerate() {
        *v *= [1e-6, 1.0, 1e6][i / 3 % 3];
    }
    let rays = rays(&g, 60_000);
    compare(g, &rays);
}

#[test]
fn every_accelerator_equals_the_linear_scan_on_camera_rays() {
    let mut scene = grid(16, 0.1);
    scene.shapes = soup(0, 40, 1.0).shapes;
    scene.triangles.extend_from_within(..100);
    for (eye, tilt) in [
        (Vec3::new(0.3, 1.5, 2.0), 0.0),
        (Vec3::new(0.0, 0.05, 0.0), 0.3),
        (Vec3::new(0.0, 3.0, 0.0), 9.0),
    ] {
        for parallel in [0.0, 1.0] {
            let rays: Vec<Ray> = (0..10_007)
                .map(|i| {
                    let at = Vec3::new((i % 100) as f32 / 50.0 - 1.0, (i / 100) as f32 / 50.0 - 1.0, 0.0);
                    let d = Vec3::new(0.0, -0.7 - tilt, -1.0) + at * (1.0 - parallel);
                    let mut ray = Ray::new(eye + at * parallel, d);
                    ray.tmax = if i % 7 == 0 { 1.7 } else { f32::INFINITY };
                    ray
                })
                .collect();
            compare(scene.clone(), &rays);
        }
    }
}

#[test]
fn scenes_of_none_one_and_two_primitives_work() {
    for (triangles, spheres) in [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)] {
        let g = soup(triangles, spheres, 1.0);
        let rays = rays(&g, 3000);
        compare(g, &rays);
    }
}

#[test]
fn the_lower_of_two_equal_primitives_wins() {
    let mut g = soup(40, 5, 0.8);
    g.triangles.extend_from_within(..);
    g.shapes.extend_from_within(..);
    let rays = rays(&g, 20_000);
    compare(g, &rays);
}

#[test]
fn rays_that_are_not_finite_meet_nothing() {
    let g = soup(50, 5, 0.5);
    let mut odd = Vec::new();
    for bad in [f32::NAN, f32::INFINITY, 0.0] {
        odd.push(Ray::new(Vec3::ZERO, Vec3::splat(bad)));
        odd.push(Ray::new(Vec3::splat(bad), Vec3::new(bad, 0.0, 0.0)));
    }
    odd.push(Ray::segment(Vec3::ZERO, Vec3::X, f32::NAN));
    assert_eq!(compare(g, &odd), 0);
}

#[test]
fn an_unknown_name_lists_those_that_there_are() {
    let error = "fastest"
        .parse::<AccelKind>()
        .expect_err("there is no such accelerator");
    assert_eq!(
        error.to_string(),
        "unknown accelerator `fastest` (expected one of `linear`, `bvh2`, `wide`)"
    );
}

#[test]
fn costs_count_less_in_a_tree_than_in_a_scan() {
    let g = Arc::new(grid(30, 0.1));
    let rays = rays(&g, 500);
    for kind in AccelKind::ALL {
        let mut costs = vec![RayCost::default(); rays.len()];
        build(kind, g.clone())
            .expect("the scene is valid")
            .cost(&rays, &mut costs);
        let mean = costs.iter().map(|c| f64::from(c.prims)).sum::<f64>() / costs.len() as f64;
        assert!(
            if kind == AccelKind::Linear {
                mean == 1800.0
            } else {
                mean < 200.0
            },
            "{kind}: {mean}"
        );
    }
}

/// Generates coordinates from a few values, so that vertices, edges and planes coincide.
fn coarse_point() -> impl Strategy<Value = Vec3> {
    let value = prop::sample::select(vec![-1.0_f32, -0.5, 0.0, -0.0, 0.25, 1.0, 1e-7, 3e4]);
    [value.clone(), value.clone(), value].prop_map(Vec3::from_array)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_accelerator_equals_the_linear_scan_on_small_random_scenes(
        vertices in prop::collection::vec(coarse_point(), 3..12),
        corners in prop::collection::vec([0_u32..12, 0_u32..12, 0_u32..12], 0..40),
        spheres in prop::collection::vec((coarse_point(), 0.01_f32..1.0), 0..4),
        origins in prop::collection::vec((coarse_point(), coarse_point()), 30..60),
    ) {
        let n = vertices.len() as u32;
        let mut g = Geometry {
            vertices,
            triangles: corners.into_iter().map(|t| t.map(|i| i % n)).collect(),
            ..Geometry::default()
        };
        for (center, radius) in spheres {
            g.add_shape(sphere(center, radius), None);
        }
        let mut rays = rays(&g, 120);
        rays.extend(origins.into_iter().map(|(o, d)| Ray::new(o, d)));
        compare(g, &rays);
    }
}
