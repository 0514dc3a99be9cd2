//! Quads and their parameters.

use super::*;

#[test]
fn u_and_v_of_a_parallelogram_are_those_of_any_quad() {
    for off in [0.0, 1e-7, 1e-6, 4e-6] {
        let c = Vec3::new(2.3 + off, 1.1 - off, off);
        let quad = Quad::from_corners([Vec3::ZERO, Vec3::new(2.0, 0.1, 0.0), c, Vec3::new(0.3, 1.0, 0.0)]);
        assert!(quad.inverse.is_some());
        for i in 0..100 {
            let at = DVec3::new(0.3 + 0.015 * f64::from(i), 0.2 + 0.005 * f64::from(i), 0.0);
            let p = at - quad.normal * (at - quad.middle).dot(quad.normal);
            let ray = Ray::new((p + quad.normal).as_vec3(), -quad.normal());
            let hit = quad.intersect(&ray).unwrap();
            let (u, v, _) = quad.place(&ray, &hit);
            let (expected_u, expected_v) = quad.inverse_bilinear(point_of(&ray, &hit));
            assert!(
                (u - expected_u).abs() < 1e-9 && (v - expected_v).abs() < 1e-9,
                "{off} {i}: {u} {v}"
            );
        }
    }
}

/// A lamp of a published scene (veach-bidir), turned and written with eight digits.
#[test]
fn a_rectangle_of_rounded_corners_is_a_rectangle() {
    let corners = [
        Vec3::new(-2.747_779_8, 5.172_271_3, -3.733_627_8),
        Vec3::new(-2.767_996_3, 5.050_267_7, -3.790_199),
        Vec3::new(-2.633_86, 5.036_069, -3.807_512_3),
        Vec3::new(-2.613_644, 5.158_072, -3.750_940_8),
    ];
    let lengths = Quad::from_corners(corners).lengths.unwrap();
    assert!(lengths.iter().all(|l| (l - 0.136).abs() < 1e-3), "{lengths:?}");
    let turned = corners.map(|c| if c == corners[1] { c + Vec3::X * 1e-5 } else { c });
    assert!(Quad::from_corners(turned).lengths.is_none());
}

/// Otherwise the quad hides the light that leaves it.
#[test]
fn light_samples_lie_where_rays_meet_the_quad() {
    // A general quad with a corner off its plane within the tolerance, and a rectangle that was turned and written with six digits.
    let general = [
        Vec3::new(-0.278_419, 0.613_602, -1.164_463),
        Vec3::new(-0.482_016, -1.007_189, 0.056_841),
        Vec3::new(0.211_872, -0.496_504, 0.915_848),
        Vec3::new(0.289_209, 0.604_313, -0.034_105),
    ];
    let [o, s, t] = [
        Vec3::new(0.1, 0.2, -0.3),
        Vec3::new(0.48, 0.6, -0.64),
        Vec3::new(0.6, -0.768, -0.27),
    ];
    let digits = |v: Vec3| (v * 1e6).round() / 1e6;
    let rectangle = [o, o + s, o + s + t, o + t].map(digits);
    for corners in [general, rectangle] {
        let quad = Quad::from_corners(corners);
        for i in 0..200 {
            let u = Vec2::new((i as f32 * 0.618_034).fract(), (i as f32 + 0.5) / 200.0);
            let from = Vec3::new(3.0, 1.0 + 0.01 * i as f32, 2.0);
            let sample = quad.sample(from, u).unwrap();
            let off = (sample.p.as_dvec3() - quad.middle).dot(quad.normal).abs();
            assert!(off < 2e-7, "{off}");
        }
    }
}

#[test]
fn a_triangle_is_a_quad_with_any_two_corners_in_one_point() {
    let [a, b, c] = [
        Vec3::new(-1.0, -1.0, 0.5),
        Vec3::new(1.0, -1.0, 0.5),
        Vec3::new(0.0, 1.0, 0.5),
    ];
    for corners in [[a, a, b, c], [a, b, b, c], [a, b, c, c], [a, b, c, a]] {
        let quad = Quad::from_corners(corners);
        let (o, e, f, skew) = quad.bilinear();
        for i in 0..200 {
            let [u, v] = [0.618_034, 0.754_877].map(|k| (f64::from(i) * k).fract().clamp(0.01, 0.99));
            let p = o + e * u + f * v + skew * (u * v);
            let (found_u, found_v) = quad.inverse_bilinear(p);
            assert!(
                (found_u - u).abs() < 1e-9 && (found_v - v).abs() < 1e-9,
                "{corners:?} {u} {v}: {found_u} {found_v}"
            );
        }
    }
}

#[test]
fn rays_leave_large_tilted_parallelograms_nearly_as_close_as_triangles() {
    let (across, along) = (Vec3::new(0.8, 0.3, -0.52), Vec3::new(-0.25, 0.95, 0.17));
    for size in [1.0, 100.0, 10_000.0] {
        let corners =
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| (across * x + along * y) * size);
        let quad = Quad::from_corners(corners);
        let flat = quad.parallelogram().unwrap();
        for i in 0..200 {
            let [u, v] = [0.618_034_f32, 0.754_877].map(|k| (i as f32 * k).fract());
            let (u, v) = (u.max(v), u.min(v));
            let [a, b, c, _] = corners;
            let triangle = triangle::surface_point([a, b, c], u - v, v);
            let place = flat.place(triangle.p);
            let [own, of_triangle] = [place.p_error, triangle.p_error].map(|e| e.dot(place.ng.abs()));
            assert!(own < 3.0 * of_triangle, "{size} {u} {v}: {own} {of_triangle}");
        }
    }
}
