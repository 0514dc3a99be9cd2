//! Refinement against closed forms.

mod displaced;
mod hostile;
mod of_model;

use glam::{DVec2, DVec3};

use super::{cage::CageRules, surface::Surface};
use crate::{
    math::{Vec2, Vec3},
    shape::mesh::{Mesh, Scheme},
};

const SMOOTH: CageRules = CageRules {
    crease_cos: -2.0,
    crease_sharpness: f32::INFINITY,
    keeps_corners: false,
};

/// The surface of faces over these vertices.
fn surface_of(positions: &[Vec3], faces: &[Vec<u32>], rules: &CageRules) -> Surface {
    let mesh = Mesh {
        positions: positions.to_vec(),
        ..Mesh::default()
    };
    Surface::new(&[(&mesh, faces.iter().map(Vec::as_slice).collect())], rules)
}

fn refined(mut surface: Surface, scheme: Scheme, levels: usize) -> Surface {
    for _ in 0..levels {
        surface = surface.refined(scheme);
    }
    surface
}

fn limit(surface: Surface, scheme: Scheme, levels: usize) -> Surface {
    let mut surface = refined(surface, scheme, levels);
    surface.move_to_limit(scheme);
    surface
}

/// A cube from -1 to 1.
fn cube() -> (Vec<Vec3>, Vec<Vec<u32>>) {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    ((0..8).map(corner).collect(), faces.map(Vec::from).to_vec())
}

fn cube_surface(rules: &CageRules) -> Surface {
    let (positions, faces) = cube();
    surface_of(&positions, &faces, rules)
}

/// A grid of `n` by `n` vertices in the xz plane, with these heights; quadrilaterals, or triangles with edges along x, z and x = z.
fn grid(n: u32, height: impl Fn(u32, u32) -> f32, triangles: bool) -> (Vec<Vec3>, Vec<Vec<u32>>) {
    let places = (0..n * n).map(|i| (i % n, i / n));
    let positions = places
        .map(|(i, j)| Vec3::new(i as f32, height(i, j), j as f32))
        .collect();
    let mut faces = Vec::new();
    for (i, j) in (0..(n - 1) * (n - 1)).map(|k| (k % (n - 1), k / (n - 1))) {
        let at = |di: u32, dj: u32| (j + dj) * n + i + di;
        let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
        match triangles {
            true => faces.extend([vec![a, b, c], vec![a, c, d]]),
            false => faces.push(vec![a, b, c, d]),
        }
    }
    (positions, faces)
}

fn bumps(i: u32, j: u32) -> f32 {
    ((i * 7 + j * j * 3 + i * j * 5) % 11) as f32 / 8.0
}

fn assert_near(a: DVec3, b: DVec3, bound: f64) {
    assert!((a - b).length() <= bound, "{a} is not {b}");
}

/// The four weights of a uniform cubic B-spline at `t` of a segment.
fn spline(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [
        s * s * s,
        3.0 * t * t * t - 6.0 * t * t + 4.0,
        3.0 * s * s * s - 6.0 * s * s + 4.0,
        t * t * t,
    ]
    .map(|w| w / 6.0)
}

#[test]
fn cube_has_the_limit_of_its_closed_forms_on_every_level() {
    // (n^2 v + 4 e + f) / (n (n + 5)) of the first level: 5/9, 3/4 and 1 of a corner, an edge and a face.
    let (corner, edge, face) = (0.5, 395.0 / 648.0, 68.0 / 81.0);
    for levels in 1..5 {
        let surface = limit(cube_surface(&SMOOTH), Scheme::CatmullClark, levels);
        for p in &surface.positions[..8] {
            assert_near(p.abs(), DVec3::splat(corner), 1e-15);
        }
        for p in &surface.positions[8..20] {
            let mut own = p.abs().to_array();
            own.sort_by(f64::total_cmp);
            assert_near(DVec3::from(own), DVec3::new(0.0, edge, edge), 1e-15);
        }
        for p in &surface.positions[20..26] {
            assert!((p.abs().max_element() - face).abs() < 1e-15 && (p.length() - face).abs() < 1e-15);
        }
    }
}

#[test]
fn vertices_of_the_cube_converge_to_their_limit() {
    let mut last = f64::INFINITY;
    for levels in 1..7 {
        let surface = refined(cube_surface(&SMOOTH), Scheme::CatmullClark, levels);
        let far = (surface.positions[0].abs() - DVec3::splat(0.5)).length();
        assert!(
            far < 0.42 * last,
            "level {levels} is {far} from the limit, after {last}"
        );
        last = far;
    }
    assert!(last < 1e-3);
}

#[test]
fn counts_follow_euler_and_every_edge_has_two_faces() {
    let (positions, faces) = cube();
    let mut triangles = Vec::new();
    for face in &faces {
        triangles.extend([vec![face[0], face[1], face[2]], vec![face[0], face[2], face[3]]]);
    }
    for (scheme, faces) in [
        (Scheme::CatmullClark, &faces),
        (Scheme::Linear, &faces),
        (Scheme::Loop, &triangles),
        (Scheme::Linear, &triangles),
        (Scheme::CatmullClark, &triangles),
    ] {
        for levels in 0..4 {
            let surface = refined(surface_of(&positions, faces, &SMOOTH), scheme, levels);
            for net in [&surface.places, &surface.values] {
                let sum = i64::from(net.vertices) - net.edges.len() as i64 + surface.faces.count() as i64;
                assert_eq!(sum, 2);
                let mut uses = vec![0; net.edges.len()];
                for face in surface.faces.all() {
                    for corner in face.clone() {
                        let edge = net.edge_of[corner];
                        uses[edge as usize] += 1;
                        let next = if corner + 1 == face.end { face.start } else { corner + 1 };
                        let (own, mut ends) = ([net.corners[corner], net.corners[next]], net.edges[edge as usize]);
                        if own != ends {
                            ends.reverse();
                        }
                        assert_eq!(own, ends);
                    }
                }
                assert!(uses.iter().all(|count| *count == 2));
            }
            let first = if scheme == Scheme::CatmullClark && faces.len() == 12 {
                3
            } else {
                4
            };
            let count = (0..levels).fold(faces.len(), |count, level| count * if level == 0 { first } else { 4 });
            assert_eq!(surface.faces.count(), count);
        }
    }
}

#[test]
fn regular_patch_is_a_bicubic_b_spline() {
    let (positions, faces) = grid(4, bumps, false);
    let levels = 4;
    let surface = limit(surface_of(&positions, &faces, &SMOOTH), Scheme::CatmullClark, levels);
    let mut tested = 0;
    for p in &surface.positions {
        // The spline's x and z are linear within the patch.
        let (u, v) = (p.x - 1.0, p.z - 1.0);
        if !(0.0..=1.0).contains(&u) || !(0.0..=1.0).contains(&v) {
            continue;
        }
        let mut height = 0.0;
        for (j, wv) in spline(v).into_iter().enumerate() {
            for (i, wu) in spline(u).into_iter().enumerate() {
                height += wu * wv * f64::from(bumps(i as u32, j as u32));
            }
        }
        assert!((p.y - height).abs() < 1e-14, "{u} {v}");
        tested += 1;
    }
    assert_eq!(tested, 17 * 17);
}

#[test]
fn texture_coordinates_are_as_smooth_as_positions_but_for_seams() {
    let (positions, faces) = grid(4, bumps, false);
    let place = |p: &Vec3| Vec2::new(p.y, p.x);
    let mesh = Mesh {
        uvs: positions.iter().map(place).collect(),
        positions,
        ..Mesh::default()
    };
    let surface = Surface::new(&[(&mesh, faces.iter().map(Vec::as_slice).collect())], &SMOOTH);
    let surface = limit(surface, Scheme::CatmullClark, 3);
    assert_eq!(surface.values.vertices, surface.places.vertices);
    let corners = surface.places.corners.iter().zip(&surface.values.corners);
    let points = || {
        let at = |(place, value): (&u32, &u32)| (surface.positions[*place as usize], surface.uvs[*value as usize]);
        corners.clone().map(at)
    };
    for (p, uv) in points() {
        if (1.0..=2.0).contains(&p.x) && (1.0..=2.0).contains(&p.z) {
            assert!((p.y - uv.x).abs() + (p.x - uv.y).abs() < 1e-14);
        }
        // A side of the boundary is a straight line through the vertices.
        let along = uv.y as u32;
        if p.z == 0.0 && along < 3 {
            let part = uv.y.fract();
            let [a, b] = [along, along + 1].map(|i| f64::from(bumps(i, 0)));
            assert!((uv.x - (a * (1.0 - part) + b * part)).abs() < 1e-15);
        }
    }
    // Positions of corners move, and their texture coordinates stay.
    let corner = DVec2::new(f64::from(bumps(3, 0)), 3.0);
    assert!(points().any(|(_, uv)| uv == corner));
}

/// The twelve weights of a box spline patch at barycentric u, v and w of its middle triangle.
///
/// Source: J. Stam, "Evaluation of Loop Subdivision Surfaces", 1998.
fn box_spline(u: f64, v: f64, w: f64) -> [f64; 12] {
    let (u2, v2, w2) = (u * u, v * v, w * w);
    let (u3, v3, w3) = (u2 * u, v2 * v, w2 * w);
    let (u4, v4, w4) = (u3 * u, v3 * v, w3 * w);
    let near = |a4: f64, [a3b, a2b2, ab3, b4]: [f64; 4], [a3c, a2bc, ab2c, b3c]: [f64; 4]| {
        a4 + 2.0 * a3c + 6.0 * a3b + 6.0 * a2bc + 12.0 * a2b2 + 6.0 * ab2c + 6.0 * ab3 + 2.0 * b3c + b4
    };
    let own = |[a, b, c]: [f64; 3]| {
        let (a2, b2, c2) = (a * a, b * b, c * c);
        6.0 * a2 * a2
            + 24.0 * a2 * a * (b + c)
            + 24.0 * a2 * (b2 + c2)
            + 60.0 * a2 * b * c
            + 8.0 * a * (b2 * b + c2 * c)
            + 36.0 * a * b * c * (b + c)
            + b2 * b2
            + c2 * c2
            + 6.0 * b * c * (b2 + c2)
            + 12.0 * b2 * c2
    };
    [
        u4 + 2.0 * u3 * v,
        u4 + 2.0 * u3 * w,
        near(
            u4,
            [u3 * v, u2 * v2, u * v3, v4],
            [u3 * w, u2 * v * w, u * v2 * w, v3 * w],
        ),
        own([u, v, w]),
        near(
            u4,
            [u3 * w, u2 * w2, u * w3, w4],
            [u3 * v, u2 * v * w, u * v * w2, v * w3],
        ),
        v4 + 2.0 * u * v3,
        own([v, u, w]),
        own([w, u, v]),
        w4 + 2.0 * u * w3,
        v4 + 2.0 * v3 * w,
        near(
            v4,
            [v3 * w, v2 * w2, v * w3, w4],
            [u * v3, u * v2 * w, u * v * w2, u * w3],
        ),
        w4 + 2.0 * v * w3,
    ]
    .map(|weight| weight / 12.0)
}

#[test]
fn regular_patch_of_triangles_is_a_box_spline() {
    // The triangle of (2, 2), (2, 3) and (3, 3), and the vertices around it.
    let around: [[i32; 2]; 12] = [
        [-1, -1],
        [0, -1],
        [-1, 0],
        [0, 0],
        [1, 0],
        [-1, 1],
        [0, 1],
        [1, 1],
        [2, 1],
        [0, 2],
        [1, 2],
        [2, 2],
    ];
    let (positions, faces) = grid(6, bumps, true);
    let surface = limit(surface_of(&positions, &faces, &SMOOTH), Scheme::Loop, 4);
    let mut tested = 0;
    for p in &surface.positions {
        let (x, z) = (p.x - 2.0, p.z - 2.0);
        let (u, v, w) = (1.0 - z, z - x, x);
        if u.min(v).min(w) < 0.0 {
            continue;
        }
        let weights = box_spline(u, v, w);
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        let terms = weights.iter().zip(around);
        let height: f64 = terms
            .map(|(weight, [i, j])| weight * f64::from(bumps((2 + i) as u32, (2 + j) as u32)))
            .sum();
        assert!((p.y - height).abs() < 1e-14, "{u} {v} {w}");
        tested += 1;
    }
    assert_eq!(tested, 17 * 18 / 2);
}

/// The closed cubic B-spline of these points at segment `k` and `t`.
fn closed_spline(points: &[DVec3], k: usize, t: f64) -> DVec3 {
    let at = |i: usize| points[(k + i + points.len() - 1) % points.len()];
    spline(t).into_iter().enumerate().map(|(i, w)| at(i) * w).sum()
}

#[test]
fn boundaries_are_cubic_b_splines_and_have_corners_where_asked_for() {
    let positions = [
        Vec3::ZERO,
        Vec3::X * 3.0,
        Vec3::new(2.0, 1.0, 2.0),
        Vec3::new(0.0, 0.5, 1.0),
    ];
    let points = positions.map(|p| p.as_dvec3());
    let cage = |rules: &CageRules, faces: &[Vec<u32>]| surface_of(&positions, faces, rules);
    for (scheme, faces) in [
        (Scheme::CatmullClark, vec![vec![0, 1, 2, 3]]),
        (Scheme::Loop, vec![vec![0, 1, 2], vec![0, 2, 3]]),
    ] {
        let levels = 3;
        let surface = limit(cage(&SMOOTH, &faces), scheme, levels);
        let on_curve: Vec<DVec3> = (0..4)
            .flat_map(|k| (0..8).map(move |t| closed_spline(&points, k, f64::from(t) / 8.0)))
            .collect();
        let boundary = surface.places.edges.iter().zip(&surface.sharpness);
        let mut ends: Vec<u32> = boundary
            .filter(|(_, s)| **s > 0.0)
            .flat_map(|(ends, _)| *ends)
            .collect();
        ends.sort_unstable();
        ends.dedup();
        assert_eq!(ends.len(), on_curve.len());
        for end in ends {
            let p = surface.positions[end as usize];
            let far = on_curve.iter().map(|q| p.distance(*q)).fold(f64::INFINITY, f64::min);
            assert!(far < 1e-15 * 4.0, "{p}");
        }
    }
    let with_corners = CageRules {
        keeps_corners: true,
        ..SMOOTH
    };
    let surface = limit(cage(&with_corners, &[vec![0, 1, 2, 3]]), Scheme::CatmullClark, 3);
    assert_eq!(surface.positions[..4], points);
    // Two triangles that share an edge have two vertices of one face.
    let surface = limit(cage(&with_corners, &[vec![0, 1, 2], vec![0, 2, 3]]), Scheme::Loop, 3);
    assert_eq!([surface.positions[1], surface.positions[3]], [points[1], points[3]]);
    assert_near(
        surface.positions[0],
        (points[0] * 4.0 + points[1] + points[3]) / 6.0,
        1e-15,
    );
}

#[test]
fn creased_cube_stays_a_cube_with_its_normals() {
    let creased = CageRules {
        crease_cos: 0.5,
        ..SMOOTH
    };
    let surface = limit(cube_surface(&creased), Scheme::CatmullClark, 2);
    for p in &surface.positions {
        assert!((p.abs().max_element() - 1.0).abs() < 1e-15, "{p}");
    }
    assert_eq!(
        surface.positions[..8],
        cube().0.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>()
    );
    assert_eq!(surface.values.vertices, 6 * 25);
    for normal in surface.normals() {
        assert!((normal.abs().max_element() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn sharpness_of_whole_levels_is_crease_rules_and_then_smooth_ones() {
    let rules = |crease_sharpness| CageRules {
        crease_cos: 0.5,
        crease_sharpness,
        keeps_corners: false,
    };
    let two = refined(cube_surface(&rules(2.0)), Scheme::CatmullClark, 2);
    let always = refined(cube_surface(&rules(f32::INFINITY)), Scheme::CatmullClark, 2);
    assert_eq!(two.positions, always.positions);
    assert!(two.sharpness.iter().all(|s| *s == 0.0));
    // Half a level is the mean of a smooth one and a crease.
    let [none, half, one] = [0.0, 0.5, 1.0].map(|s| refined(cube_surface(&rules(s)), Scheme::CatmullClark, 1));
    for (half, (none, one)) in half.positions.iter().zip(none.positions.iter().zip(&one.positions)) {
        assert_near(*half, (*none + *one) * 0.5, 1e-15);
    }
}

#[test]
fn linear_faces_stay_where_they_are() {
    let surface = limit(cube_surface(&SMOOTH), Scheme::Linear, 3);
    assert_eq!(surface.positions.len(), 6 * 8 * 8 + 2);
    for p in &surface.positions {
        assert_eq!(p.abs().max_element(), 1.0);
        assert_eq!(*p * 4.0, (*p * 4.0).round());
    }
    let (positions, faces) = grid(3, |_, _| 0.0, true);
    let surface = limit(surface_of(&positions, &faces, &SMOOTH), Scheme::Linear, 2);
    assert!(surface.faces.are_triangles());
    assert_eq!(surface.positions.len(), 81);
}

#[test]
fn parts_and_seams_do_not_tear_and_keep_their_values() {
    // Two meshes of a strip each, whose common vertices have other texture coordinates.
    let strip = |x: f32| Mesh {
        positions: vec![
            Vec3::new(x, 0.0, 0.0),
            Vec3::new(x + 1.0, 1.0 - x, 0.0),
            Vec3::new(x + 1.0, 1.0 - x, 1.0),
            Vec3::new(x, 0.0, 1.0),
        ],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        ..Mesh::default()
    };
    let (left, mut right) = (strip(0.0), strip(1.0));
    right.positions[0].y = 1.0;
    right.positions[3].y = 1.0;
    let face: &[u32] = &[0, 1, 2, 3];
    let surface = Surface::new(&[(&left, vec![face]), (&right, vec![face])], &SMOOTH);
    assert_eq!((surface.places.vertices, surface.values.vertices), (6, 8));
    let surface = limit(surface, Scheme::CatmullClark, 2);
    let meshes = surface.meshes([&left, &right].into_iter());
    let one_sided = limit(Surface::new(&[(&left, vec![face])], &SMOOTH), Scheme::CatmullClark, 2);
    assert_eq!(one_sided.meshes([&left].into_iter())[0].positions.len(), 25);
    let [a, b] = [&meshes[0], &meshes[1]];
    assert_eq!((a.positions.len(), b.positions.len(), a.triangles.len()), (25, 25, 32));
    assert_eq!((a.validate(), b.validate()), (Ok(()), Ok(())));
    let mut common = 0;
    for (p, (n, uv)) in a.positions.iter().zip(a.normals.iter().zip(&a.uvs)) {
        if uv.x == 1.0 {
            let at = b
                .positions
                .iter()
                .position(|q| q == p)
                .expect("a vertex of the other part");
            assert_eq!((b.uvs[at].x, b.uvs[at].y, b.normals[at]), (0.0, uv.y, *n));
            common += 1;
        }
    }
    assert_eq!(common, 5);
}
