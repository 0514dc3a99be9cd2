//! Hits and normals of flat shapes against algebra.

use super::examples::{PLACES, Random, placed, shape};
use crate::{
    math::{Ray, Vec2, Vec3},
    shape::triangle,
};

#[test]
fn cuboids_are_met_along_their_axes_from_both_sides() {
    let cube = shape("cuboid = { min = [-1, -1, -1], max = [1, 2, 3] }");
    for (axis, far) in [(Vec3::X, 1.0), (Vec3::Y, 2.0), (Vec3::Z, 3.0)] {
        for zero in [0.0, -0.0] {
            let d = |sign: f32| Vec3::select(axis.cmpeq(Vec3::ONE), Vec3::splat(sign), Vec3::splat(zero));
            let at = |o: Vec3, d: Vec3| {
                let ray = Ray::new(o, d);
                let hit = cube.intersect(&ray)?;
                Some((hit.t, cube.surface(&ray, &hit).ng))
            };
            assert_eq!(at(axis * 10.0, d(-1.0)), Some((10.0 - far, axis)));
            assert_eq!(at(-axis * 10.0, d(1.0)), Some((9.0, -axis)));
            assert_eq!(at(Vec3::ZERO, d(1.0)), Some((far, axis)));
            assert_eq!(at(Vec3::ZERO, d(-1.0)), Some((1.0, -axis)));
            assert_eq!(at(axis * 10.0, d(1.0)), None);
            assert_eq!(at(Vec3::splat(4.0), d(-1.0)), None);
            // Along a face and along an edge.
            assert!(at(Vec3::splat(-1.0) - axis, d(1.0)).is_some());
        }
    }
}

#[test]
fn faces_of_a_cuboid_have_upright_parameters() {
    let cube = shape("cuboid = { min = [-1, -1, -1], max = [1, 1, 1] }");
    let aside = Vec3::new(0.2, 0.4, 0.6);
    for n in [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z] {
        let ray = Ray::new(n * 3.0 + aside - n * aside.dot(n), -n);
        let s = cube.surface(&ray, &cube.intersect(&ray).unwrap());
        assert_eq!(s.dpdu.cross(s.dpdv).normalize(), n);
        assert_eq!(s.ng, n);
        let p = s.dpdu * (s.uv.x - 0.5) + s.dpdv * (s.uv.y - 0.5) + n;
        assert!((p - s.p).length() < 1e-6, "{p} is not {}", s.p);
        if n.y == 0.0 {
            assert_eq!(s.dpdv, Vec3::Y * 2.0);
        }
    }
}

#[test]
fn a_cube_of_six_quads_is_met_where_the_cuboid_is() {
    let cube = shape("cuboid = { min = [0, 0, 0], max = [1, 1, 1] }");
    let c = |i: u8| format!("[{}, {}, {}]", i & 1, i >> 1 & 1, i >> 2);
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let quads = faces.map(|f| {
        let corners = f.map(c).join(", ");
        shape(&format!("quad = {{ corners = [{corners}] }}"))
    });
    let mut random = Random(42);
    let mut met = 0;
    for _ in 0..20_000 {
        let o = Vec3::splat(0.5) + random.direction() * (0.2 + random.next() * 3.0);
        let to = Vec3::new(random.next(), random.next(), random.next()) * 1.2 - 0.1;
        let ray = Ray::new(o, to - o);
        let nearest = quads
            .iter()
            .filter_map(|q| Some((q, q.intersect(&ray)?)))
            .min_by(|x, y| x.1.t.total_cmp(&y.1.t));
        let solid = cube.intersect(&ray);
        assert_eq!(solid.map(|h| h.t), nearest.map(|(_, h)| h.t));
        if let (Some(hit), Some((quad, on_quad))) = (solid, nearest) {
            met += 1;
            assert_eq!(cube.surface(&ray, &hit).ng, quad.surface(&ray, &on_quad).ng);
        }
    }
    assert!(met > 10_000);
}

const QUAD: &str = "quad = { corners = [[$x, $y, $z], [$bx, $y, $z], [$bx, $cy, $z], [$x, $cy, $z]] }";

#[test]
fn quads_keep_the_normal_they_were_wound_about() {
    for (size, at) in PLACES {
        let text = QUAD
            .replace("$bx", &(at.x + size).to_string())
            .replace("$cy", &(at.y + size).to_string());
        let quad = placed(&text, size, at);
        for side in [1.0, -1.0] {
            let ray = Ray::new(at + Vec3::new(0.25, 0.5, side * 2.0) * size, -Vec3::Z * side);
            let hit = quad.intersect(&ray).unwrap();
            let s = quad.surface(&ray, &hit);
            assert_eq!((hit.t, s.ng), (2.0 * size, Vec3::Z));
            let rounding = 4.0 * f32::EPSILON * (1.0 + at.length() / size);
            assert!((s.uv - Vec2::new(0.25, 0.5)).length() <= rounding, "{}", s.uv);
        }
        let ray = Ray::new(at + Vec3::new(-0.5, 0.5, 0.0) * size, Vec3::X);
        assert_eq!(quad.intersect(&ray), None, "edge-on");
    }
}

#[test]
fn parameters_of_a_quad_are_bilinear() {
    let corners = [
        Vec3::ZERO,
        Vec3::new(3.0, 0.0, 0.0),
        Vec3::new(2.0, 1.0, 0.0),
        Vec3::new(0.5, 0.75, 0.0),
    ];
    let quad = shape("quad = { corners = [[0, 0, 0], [3, 0, 0], [2, 1, 0], [0.5, 0.75, 0]] }");
    let mut random = Random(43);
    for _ in 0..1000 {
        let (u, v) = (random.next(), random.next());
        let [a, b, c, d] = corners;
        let p = a.lerp(b, u).lerp(d.lerp(c, u), v);
        let ray = Ray::new(p + Vec3::Z, -Vec3::Z);
        let s = quad.surface(&ray, &quad.intersect(&ray).unwrap());
        assert!(
            (s.uv.x - u).abs() < 2e-6 && (s.uv.y - v).abs() < 2e-6,
            "{} is not {u}, {v}",
            s.uv
        );
    }
}

#[test]
fn quads_and_triangles_that_share_an_edge_leave_no_gap() {
    let mut random = Random(44);
    let left = shape("quad = { corners = [[0.1, 0.2, 0.3], [0.7, 0.3, 0.9], [0.3, 0.9, 1.1], [-0.3, 0.8, 0.5]] }");
    let right = shape("quad = { corners = [[0.7, 0.3, 0.9], [0.1, 0.2, 0.3], [0.5, -0.7, 0.2], [1.1, -0.6, 0.8]] }");
    let (a, b) = (Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.7, 0.3, 0.9));
    let normals = [&left, &right].map(|q| q.sample(Vec3::ONE * 9.0, random.square()).unwrap().ng);
    let mut tried = 0;
    for i in 0..100_000 {
        let on_edge = a.lerp(b, 0.01 + 0.98 * random.next());
        let away = random.direction() * random.next();
        let o = on_edge + away * [0.5, 3.0, 100.0][i % 3];
        let ray = Ray::new(o, on_edge - o);
        // Seen from the side the edge is the outline of both, and a ray may pass beside it.
        let seen = normals.map(|n| n.dot(ray.d.normalize()));
        if seen[0] * seen[1] > 1e-3 {
            tried += 1;
            let met = left.intersect(&ray);
            assert!(met.is_some() || right.intersect(&ray).is_some(), "{ray:?}");
            let of_mesh = triangle::intersect(&ray, b, a, Vec3::new(0.5, -0.7, 0.2));
            assert!(met.is_some() || of_mesh.is_some(), "{ray:?}");
        }
    }
    assert!(tried > 50_000, "{tried}");
}

#[test]
fn a_plane_counts_metres_from_its_point() {
    let plane = shape("plane = { point = [1, 2, 3], normal = [0, 4, 0] }");
    let ray = Ray::new(Vec3::new(4.0, 12.0, 8.0), -Vec3::Y * 2.0);
    let hit = plane.intersect(&ray).unwrap();
    let s = plane.surface(&ray, &hit);
    assert_eq!((hit.t, s.p, s.ng), (5.0, Vec3::new(4.0, 2.0, 8.0), Vec3::Y));
    assert_eq!(s.uv.to_array(), [3.0, -5.0]);
    assert_eq!(plane.intersect(&Ray::new(Vec3::Y * 9.0, Vec3::X)), None);
    assert_eq!(plane.intersect(&Ray::new(Vec3::Y * 2.0, Vec3::X)), None);
}
