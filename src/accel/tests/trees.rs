//! Tests of builds: degenerate input, threads, and failures.

use std::sync::Arc;

use super::{Random, compare, grid, rays, rooms, soup};
use crate::{
    accel::*,
    math::{Ray, Vec3},
};

/// Bad input must not take long: for any input, twice the size takes about twice as long.
#[test]
fn degenerate_input_builds_in_linear_time() {
    let mut r = Random(31);
    let mut scene = |f: &dyn Fn(usize, &mut Random) -> [Vec3; 3]| {
        let mut g = Geometry::default();
        for i in 0..60_000 {
            g.vertices.extend(f(i, &mut r));
            g.triangles.push([0, 1, 2].map(|k| (3 * i + k) as u32));
        }
        g
    };
    let corner = |p: Vec3, size: f32| [p, p + Vec3::X * size, p + Vec3::Y * size];
    let scenes = [
        ("identical", scene(&|_, _| corner(Vec3::ZERO, 1.0))),
        ("points", scene(&|_, r| [r.vec(1.0); 3])),
        (
            "no area",
            scene(&|_, r| {
                [0.0, 0.5, 1.0].map({
                    let p = r.vec(1.0);
                    move |k| p + Vec3::X * k
                })
            }),
        ),
        (
            "in a line",
            scene(&|i, _| [0.0, 0.5, 1.0].map(|k| Vec3::X * (i as f32 + k))),
        ),
        (
            "large and small",
            scene(&|i, r| {
                if i == 0 {
                    corner(Vec3::ZERO, 1e12)
                } else {
                    corner(r.vec(1e-6), 1e-8)
                }
            }),
        ),
        (
            "clusters",
            scene(&|i, r| corner(r.vec(1e-2) + (i % 2) as f32 * 1e4, 1e-3)),
        ),
        (
            "one centre",
            scene(&|i, _| {
                let size = i as f32 * 1e-5;
                [
                    Vec3::splat(-size),
                    Vec3::new(size, size, -size),
                    Vec3::new(0.0, 0.0, size),
                ]
            }),
        ),
        (
            "equal boxes",
            scene(&|_, r| [Vec3::ZERO, Vec3::ONE, Vec3::new(r.unit(), r.unit(), 0.5)]),
        ),
        (
            "powers of two",
            scene(&|i, _| {
                corner(
                    Vec3::splat(2_f32.powi(-(i as i32 % 150))),
                    2_f32.powi(-(i as i32 % 140)),
                )
            }),
        ),
        ("flat", grid(170, 0.0)),
    ];
    for (name, g) in scenes {
        let accel = build(AccelKind::Wide, Arc::new(g)).expect("the scene is valid");
        let seconds = accel.stats().build_time.as_secs_f32();
        assert!(seconds < 5.0, "{name}: {seconds} s");
    }
}

#[test]
fn copies_of_a_triangle_are_tested_once() {
    let mut g = soup(1, 0, 0.5);
    g.triangles = vec![[0, 1, 2]; 5000];
    let rays = rays(&g, 500);
    let accel = build(AccelKind::Wide, Arc::new(g.clone())).expect("the scene is valid");
    let mut costs = vec![RayCost::default(); rays.len()];
    accel.cost(&rays, &mut costs);
    assert!(costs.iter().all(|cost| cost.prims <= 1));
    assert!(compare(g, &rays) > 50);
}

/// Returns a room around more small triangles than a piece of the tree holds, and a sphere.
fn room_around_a_cloud() -> Geometry {
    let mut g = soup(40_000, 1, 0.01);
    g.vertices.iter_mut().for_each(|p| *p *= 0.1);
    for axis in 0..3 {
        let [a, b, c] = [0, 1, 2].map(|k| Vec3::AXES[(axis + k) % 3]);
        for at in [-1.0, 1.0] {
            let first = g.vertices.len() as u32;
            g.vertices
                .extend([b + c, b - c, -b - c, c - b].map(|corner| a * at + corner));
            g.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| first + k)));
        }
    }
    g
}

#[test]
fn walls_are_no_leaf_that_is_the_room() {
    let g = Arc::new(room_around_a_cloud());
    let mut r = Random(41);
    // Between the walls and the cloud, parallel to neither.
    let short = |_| Ray::segment(Vec3::splat(0.5) + r.vec(0.2), r.vec(0.2), 1.0);
    let rays: Vec<Ray> = (0..500).map(short).collect();
    let accel = build(AccelKind::Wide, g).expect("the scene is valid");
    let mut costs = vec![RayCost::default(); rays.len()];
    accel.cost(&rays, &mut costs);
    let tested: u32 = costs.iter().map(|cost| cost.prims).sum();
    assert!(tested < 500, "{tested} triangles by 500 rays");
}

#[test]
fn few_primitives_beside_pieces_are_found_as_by_the_linear_scan() {
    let g = room_around_a_cloud();
    let rays = rays(&g, 500);
    assert!(compare(g, &rays) > 250);
}

#[test]
fn trees_do_not_depend_on_the_number_of_threads() {
    // The second one has more than one partition.
    for g in [rooms(), grid(160, 0.05)] {
        let build = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads");
            let prims = build::prims::Prims::whole(&g).expect("the scene is valid");
            let leaves = build::bvh2_tree::Leaves { triangles: 2 };
            let tree = pool.install(|| build::build_tree(prims, &g, leaves));
            tree.expect("there are triangles")
        };
        let (one, three) = (build(1), build(3));
        assert_eq!(one.ids, three.ids);
        let same = |(a, b): (&build::bvh2_tree::FlatNode, &build::bvh2_tree::FlatNode)| {
            a.bounds == b.bounds && (a.link, a.count) == (b.link, b.count)
        };
        assert!(one.nodes.len() == three.nodes.len() && one.nodes.iter().zip(&three.nodes).all(same));
    }
}

#[test]
fn bad_coordinates_are_refused_with_the_primitive() {
    let with = |x: f32| {
        let mut g = soup(5, 1, 0.5);
        g.vertices[7].y = x;
        build(AccelKind::Bvh2, Arc::new(g)).err()
    };
    assert_eq!(with(f32::NAN), Some(BuildError::NotFinite { prim: 2 }));
    assert_eq!(with(f32::NEG_INFINITY), Some(BuildError::NotFinite { prim: 2 }));
    assert_eq!(with(1e20), Some(BuildError::TooLarge { prim: 2 }));
    let mut g = soup(5, 1, 0.5);
    g.triangles[3][1] = 15;
    let error = build(AccelKind::Linear, Arc::new(g))
        .err()
        .expect("vertex 15 does not exist");
    assert_eq!(error.to_string(), "triangle 3 names vertex 15, but there are 15");
}
