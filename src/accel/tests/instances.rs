//! Tests of instances and of edits.

use glam::{DAffine3, DMat3, DVec3};

use super::*;
use crate::math::Transform;

/// Returns a transform with a translation, a rotation and a scale; some also mirror or shear.
pub(super) fn place(r: &mut Random, kind: usize, spread: f32) -> Transform {
    let wide = |v: Vec3| v.as_dvec3();
    let translate = wide(r.vec(spread));
    let scale = match kind {
        0 => Vec3::ONE,
        1 => Vec3::splat(0.2 + r.unit()),
        2 => Vec3::new(0.1 + r.unit(), 0.1 + r.unit(), 2.0 * r.unit() + 0.1),
        _ => Vec3::new(-0.3 - r.unit(), 0.5, 0.1 + r.unit()),
    };
    let turn = if kind == 0 { DVec3::ZERO } else { wide(r.vec(180.0)) };
    let t = Transform::from_parts(translate, turn, wide(scale)).expect("invertible");
    if kind < 4 {
        return t;
    }
    let shear = DAffine3::from_mat3(DMat3::from_cols(
        DVec3::new(1.0, 0.0, 0.0),
        DVec3::new(0.7, 1.0, 0.0),
        DVec3::new(-0.4, 0.9, 0.3),
    ));
    Transform::new(shear * t.widened()).expect("invertible")
}

/// Adds the triangles of `mesh` as a group.
pub(super) fn add_group(g: &mut Geometry, mesh: &Geometry) {
    let (vertex, triangle) = (g.vertices.len() as u32, g.triangles.len() as u32);
    g.vertices.extend(&mesh.vertices);
    g.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + vertex)));
    g.groups.push(MeshGroup {
        triangles: triangle..g.triangles.len() as u32,
        vertices: vertex..g.vertices.len() as u32,
    });
}

pub(super) fn add_instance(g: &mut Geometry, group: u32, transform: Transform) {
    g.instances.push(GroupInstance {
        group,
        transform: g.transforms.len() as u32,
    });
    g.transforms.push(transform);
}

/// Returns two groups between triangles that are in none, shapes, and `count` instances with
/// transforms of all kinds.
pub(super) fn crowd(count: usize, spread: f32) -> Geometry {
    let mut g = soup(20, 10, 0.3);
    add_group(&mut g, &soup(60, 0, 0.4));
    let vertex = g.vertices.len() as u32;
    g.vertices.extend([Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0]);
    g.triangles.push([0, 1, 2].map(|v| vertex + v));
    add_group(&mut g, &grid(4, 0.0));
    // Groups of one triangle and of none.
    add_group(&mut g, &soup(1, 0, 1.0));
    add_group(&mut g, &soup(0, 0, 1.0));
    let mut r = Random(17);
    for i in 0..count {
        let transform = place(&mut r, i % 5, spread);
        add_instance(&mut g, [0, 1, 0, 2, 3, 1, 0][i % 7], transform);
    }
    g
}

fn compare_crowd(g: Geometry, count: usize) -> usize {
    let rays = rays(&g.without_instances(), count);
    compare(g, &rays)
}

#[test]
fn every_accelerator_equals_the_linear_scan_on_instances() {
    assert!(compare_crowd(crowd(30, 1.0), 20_000) > 8_000);
}

#[test]
fn every_accelerator_equals_the_linear_scan_on_instances_far_away() {
    let mut g = crowd(20, 1e4);
    for placed in 0..20 {
        let t = &mut g.transforms[placed];
        let far = DAffine3::from_translation(DVec3::new(3e5, 0.0, -1e5));
        *t = Transform::new(far * t.widened()).expect("invertible");
    }
    compare_crowd(g, 15_000);
    // A mesh far from its local origin that its instance moves back.
    let mut g = crowd(0, 1.0);
    for v in g.groups[0].vertices.clone() {
        g.vertices[v as usize] += Vec3::new(1e5, -2e5, 0.0);
    }
    for i in 0..5 {
        let back = DAffine3::from_translation(DVec3::new(-1e5, 2e5, f64::from(i)));
        add_instance(&mut g, 0, Transform::new(back).expect("invertible"));
    }
    assert!(compare_crowd(g, 15_000) > 4_000);
}

#[test]
fn every_accelerator_equals_the_linear_scan_on_instances_that_magnify_roundings() {
    let mut g = crowd(0, 1.0);
    let mut r = Random(3);
    for i in 0..12 {
        let flat = DAffine3::from_scale(DVec3::new(1.0, [1e-3, 1e3][i % 2], 1.0));
        let t = place(&mut r, 2, 2.0);
        add_instance(
            &mut g,
            (i % 2) as u32,
            Transform::new(flat * t.widened()).expect("invertible"),
        );
    }
    compare_crowd(g, 15_000);
}

#[test]
fn the_lower_of_two_instances_in_one_place_wins() {
    let mut g = crowd(12, 0.7);
    for i in 0..12 {
        let GroupInstance { group, transform } = g.instances[11 - i];
        let same = g.transforms[transform as usize];
        add_instance(&mut g, group, same);
    }
    // A group that is in the scene without an instance as well.
    let mesh = soup(60, 0, 0.4);
    let vertex = g.vertices.len() as u32;
    g.vertices.extend(&mesh.vertices);
    g.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + vertex)));
    add_instance(&mut g, 0, Transform::IDENTITY);
    let rays = rays(&g.without_instances(), 15_000);
    let mut hits = vec![None; rays.len()];
    build(AccelKind::Linear, Arc::new(g.clone()))
        .expect("sound")
        .nearest(&rays, &mut hits);
    let instances: Vec<InstanceId> = hits.iter().flatten().map(|h| h.instance).collect();
    let copies = 12..24;
    assert!(instances.iter().any(|i| i.0 < 12) && !instances.iter().any(|i| copies.contains(&i.0)));
    compare(g, &rays);
}

#[test]
fn instances_without_anything_else_and_of_nothing_work() {
    for groups in 1..4 {
        let mut g = Geometry::default();
        for group in 0..groups {
            add_group(&mut g, &soup(group, 0, 1.0));
            add_instance(&mut g, group as u32, Transform::IDENTITY);
        }
        let rays = rays(&g.without_instances(), 2000);
        compare(g, &rays);
    }
}

#[test]
fn an_instance_is_where_its_copy_in_world_space_is() {
    let g = crowd(30, 1.5);
    let flat = g.without_instances();
    // Rays through edges and vertices are left out: their hits depend on rounding.
    let rays = rays(&flat, 60_000)
        .chunks(6)
        .flat_map(|six| [six[0], six[1]])
        .collect::<Vec<_>>();
    let trace = |g: &Geometry| {
        let mut hits = vec![None; rays.len()];
        let accel = build(AccelKind::Wide, Arc::new(g.clone())).expect("sound");
        accel.nearest(&rays, &mut hits);
        assert_eq!(accel.stats().seen, flat.triangles.len() as u64 + 10);
        hits
    };
    let (copies, instances) = (trace(&flat), trace(&g));
    let agree = copies.iter().zip(&instances).filter(|pair| match pair {
        (Some(a), Some(b)) => (a.t - b.t).abs() <= 1e-4 * (1.0 + a.t.abs()),
        (None, None) => true,
        _ => false,
    });
    let agree = agree.count() as f32 / rays.len() as f32;
    assert!(agree > 0.999, "{agree}");
    let (a, b) = (g.world_bounds(), flat.world_bounds());
    assert_eq!(a.union(b), a);
}

#[test]
fn bad_groups_and_instances_are_refused() {
    let error = |change: fn(&mut Geometry)| {
        let mut g = crowd(3, 1.0);
        change(&mut g);
        let g = Arc::new(g);
        let kinds = AccelKind::ALL.into_iter().map(|kind| build(kind, g.clone()).err());
        let errors: Vec<_> = kinds.collect();
        assert!(errors.iter().all(|e| *e == errors[0]), "{errors:?}");
        errors[0].clone().map(|e| e.to_string()).unwrap_or_default()
    };
    let missing = "instance 1 names a group or a transform that does not exist";
    assert_eq!(error(|g| g.instances[1].group = 4), missing);
    assert_eq!(error(|g| g.instances[1].transform = 3), missing);
    let order = "group 1 is out of order or names what does not exist";
    assert_eq!(error(|g| g.groups[1].triangles.start = 3), order);
    assert_eq!(error(|g| g.groups.swap(0, 1)), order);
    let shared = "triangle 0 and one that is not of its group have a vertex in common";
    assert_eq!(error(|g| g.triangles[0][1] = g.groups[0].vertices.start), shared);
    let shared = "triangle 20 and one that is not of its group have a vertex in common";
    assert_eq!(error(|g| g.triangles[20][1] = 0), shared);
    let far = "instance 2 reaches beyond 1e12 m";
    let move_far = |g: &mut Geometry| {
        let far = DAffine3::from_translation(DVec3::X * 1e13);
        g.transforms[2] = Transform::new(far).expect("invertible");
    };
    assert_eq!(error(move_far), far);
}

/// Fails if `accel` differs from a new accelerator over its geometry.
fn compare_with_new(accel: &dyn Accelerator, kind: AccelKind) {
    let g = accel.geometry();
    let rays = rays(&g.without_instances(), 3000);
    let trace = |accel: &dyn Accelerator| {
        let (mut hits, mut blocked) = (vec![None; rays.len()], vec![false; rays.len()]);
        accel.nearest(&rays, &mut hits);
        accel.occluded(&rays, &mut blocked);
        (hits, blocked)
    };
    let new = build(kind, g.clone()).expect("sound");
    let ((a, a_blocked), (b, b_blocked)) = (trace(accel), trace(&*new));
    for i in 0..rays.len() {
        assert_eq!(bits(&a[i]), bits(&b[i]), "{kind}, ray {i}: {:?}", rays[i]);
    }
    assert_eq!(a_blocked, b_blocked, "{kind}");
    assert!(a.iter().flatten().count() > 100);
}

#[test]
fn moving_one_of_a_thousand_builds_the_top_alone() {
    for kind in AccelKind::ALL {
        let count = if kind == AccelKind::Linear { 50 } else { 1000 };
        let mut accel = build(kind, Arc::new(crowd(count, 8.0))).expect("sound");
        let before = accel.stats();
        let mut r = Random(77);
        for turn in 0..3 {
            let edit = Edit {
                instances: vec![(InstanceId(7 * turn), place(&mut r, 2, 8.0))],
                shapes: vec![(turn, place(&mut r, 1, 1.0))],
                ..Edit::default()
            };
            let updated = accel.update(&edit).expect("sound");
            let top = if kind == AccelKind::Linear {
                vec![]
            } else {
                vec![TreeId::Top]
            };
            assert_eq!((updated.built, updated.refitted), (top, vec![]), "{kind}");
            compare_with_new(&*accel, kind);
        }
        assert_eq!(accel.stats().seen, before.seen);
    }
}

#[test]
fn a_mesh_that_bends_changes_its_own_tree_and_the_top() {
    for kind in AccelKind::ALL {
        let g = crowd(20, 2.0);
        let group = g.groups[0].clone();
        let mut accel = build(kind, Arc::new(g)).expect("sound");
        for turn in 1..3 {
            let positions = &accel.geometry().vertices[group.vertices.start as usize..group.vertices.end as usize];
            let bent = positions.iter().map(|p| *p + Vec3::Y * (0.1 * turn as f32 * p.x * p.x));
            let edit = Edit {
                vertices: vec![(group.vertices.start, bent.collect())],
                ..Edit::default()
            };
            let updated = accel.update(&edit).expect("sound");
            let (top, own) = (TreeId::Top, TreeId::Group(0));
            let expected = match kind {
                AccelKind::Linear => (vec![], vec![]),
                AccelKind::Wide => (vec![top], vec![own]),
                _ => (vec![own, top], vec![]),
            };
            assert_eq!((updated.built, updated.refitted), expected, "{kind}");
            compare_with_new(&*accel, kind);
        }
    }
}

#[test]
fn a_mesh_that_is_torn_apart_is_built_anew_and_so_is_one_that_gains_area() {
    let mut g = crowd(20, 2.0);
    let [a, b, _] = g.triangles[25];
    g.triangles[25] = [a, b, b];
    let (first, last) = (g.groups[0].vertices.start, g.groups[0].vertices.end);
    // The mesh is torn apart; then a degenerate triangle gets a third vertex of its own.
    g.vertices[b as usize] = g.vertices[a as usize];
    g.triangles[25] = [a, b, b + 1];
    let mut accel = build(AccelKind::Wide, Arc::new(g)).expect("sound");
    let mut r = Random(5);
    let update = |accel: &mut Box<dyn Accelerator>, first, positions| {
        let edit = Edit {
            vertices: vec![(first, positions)],
            ..Edit::default()
        };
        let updated = accel.update(&edit).expect("sound");
        assert_eq!(updated.built, [TreeId::Group(0), TreeId::Top]);
        compare_with_new(&**accel, AccelKind::Wide);
    };
    update(&mut accel, b, vec![Vec3::new(0.3, 0.1, -0.9)]);
    let torn = (first..last).map(|_| r.vec(1.0)).collect();
    update(&mut accel, first, torn);
    // Static geometry has a tree of its own.
    let edit = Edit {
        vertices: vec![(0, vec![Vec3::splat(0.5)])],
        ..Edit::default()
    };
    let updated = accel.update(&edit).expect("sound");
    assert_eq!(
        (updated.built, updated.refitted),
        (vec![TreeId::Top], vec![TreeId::Static])
    );
    compare_with_new(&*accel, AccelKind::Wide);
}

#[test]
fn the_first_change_of_a_scene_of_one_tree_parts_what_moves_from_what_does_not() {
    for kind in [AccelKind::Bvh2, AccelKind::Wide] {
        let mut accel = build(kind, Arc::new(soup(200, 40, 0.3))).expect("sound");
        let mut r = Random(9);
        for built in [vec![TreeId::Static, TreeId::Top], vec![TreeId::Top]] {
            let edit = Edit {
                shapes: vec![(3, place(&mut r, 2, 1.0)), (5, place(&mut r, 3, 1.0))],
                ..Edit::default()
            };
            assert_eq!(accel.update(&edit).expect("sound").built, built);
            compare_with_new(&*accel, kind);
        }
    }
}

#[test]
fn an_edit_that_makes_no_sense_changes_nothing() {
    for kind in AccelKind::ALL {
        let mut accel = build(kind, Arc::new(crowd(5, 1.0))).expect("sound");
        let first = accel.geometry().groups[0].vertices.start;
        let far = Transform::new(DAffine3::from_translation(DVec3::X * 1e13)).expect("invertible");
        let vertices = accel.geometry().vertices.len();
        let edits = [
            (
                vec![(InstanceId(5), far)],
                vec![],
                vec![],
                "there is no instance 5 to be moved",
            ),
            (
                vec![(InstanceId(2), far)],
                vec![],
                vec![],
                "instance 2 reaches beyond 1e12 m",
            ),
            (vec![], vec![(10, far)], vec![], "there is no shape 10 to be moved"),
            (
                vec![],
                vec![(0, far)],
                vec![],
                "primitive 147 has a coordinate beyond 1e12 m",
            ),
            (
                vec![],
                vec![],
                vec![(first, vec![Vec3::ZERO, Vec3::NAN])],
                "vertex 61 would be at no finite place, or beyond 1e12 m",
            ),
        ];
        for (instances, shapes, vertices, message) in edits {
            let edit = Edit {
                instances,
                shapes,
                vertices,
            };
            let error = accel.update(&edit).expect_err("it makes no sense");
            let message = message.replace("147", &accel.geometry().triangles.len().to_string());
            assert_eq!(error.to_string(), message);
            compare_with_new(&*accel, kind);
        }
        let past_the_end = Edit {
            vertices: vec![(vertices as u32, vec![Vec3::ZERO])],
            ..Edit::default()
        };
        assert!(accel.update(&past_the_end).is_err());
    }
}
