//! The triangle of a mesh: three corners that live in the mesh's arrays.

use super::{LocalSurface, ShapeHit};
use crate::math::{DVec3, Ray, Vec2, Vec3, float::gamma};

/// The shear of a direction onto its main axis.
///
/// Coordinates are taken in the order of `axes`, the main one last; a point (x, y, z) relative to
/// the ray's origin comes to lie at (x - `x` z, y - `y` z), and the ray at zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shear {
    pub axes: [usize; 3],
    pub x: f32,
    pub y: f32,
}

impl Shear {
    #[inline(always)]
    pub fn new(d: &Vec3) -> Self {
        let [x, y, z] = d.abs().to_array();
        // The case is unpredictable, so there is no branch.
        let first = (x > y) & (x > z);
        let second = !first & (y > z);
        let axes = [[0, 1, 2], [2, 0, 1], [1, 2, 0]][usize::from(second) + 2 * usize::from(first)];
        // Where it lies in memory: a copy would have to be written before its parts can be read.
        let d: &[f32; 3] = d.as_ref();
        let [x, y, z] = axes;
        let (x, y, z) = (d[x], d[y], d[z]);
        let inv = 1.0 / z;
        Self {
            axes,
            x: x * inv,
            y: y * inv,
        }
    }

    /// The position of a corner after the shear. The corner is relative to the ray's origin, with its
    /// axes permuted.
    #[inline]
    pub fn flat(&self, corner: Vec3) -> Vec2 {
        Vec2::new(corner.x - self.x * corner.z, corner.y - self.y * corner.z)
    }

    /// Twice the signed area between the ray and an edge, as seen along the main axis.
    #[inline]
    pub fn edge(p: Vec2, q: Vec2) -> f32 {
        p.x * q.y - p.y * q.x
    }

    /// The coordinates of `v` in the order of the axes.
    #[inline]
    pub fn permute(&self, v: &Vec3) -> Vec3 {
        let v: &[f32; 3] = v.as_ref();
        let [x, y, z] = self.axes;
        Vec3::new(v[x], v[y], v[z])
    }
}

/// Intersects `ray` with the triangle `a`, `b`, `c` for `ray.tmin < t <= ray.tmax`; `u` and `v` are
/// the barycentric weights of `b` and `c`.
///
/// Watertight: where a corner comes to lie depends on the ray and the corner alone, and of two
/// rounded products the difference never has the wrong sign. So the edge tests are exact for
/// corners that lie a little elsewhere, the same for all triangles they belong to; only zero may
/// stand for either sign, and counts as inside. Nothing passes between triangles that share an edge
/// or a corner. A fused multiply-add would break that.
///
/// Every accelerator computes these operations in this order, so that all of them find the same
/// bits.
///
/// Source: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, for the
/// edges; `t` comes from the plane, which is exact for one that is parallel to two axes.
#[inline]
pub fn intersect(ray: &Ray, a: Vec3, b: Vec3, c: Vec3) -> Option<ShapeHit> {
    let shear = Shear::new(&ray.d);
    let [a, b, c] = [a, b, c].map(|corner| shear.permute(&(corner - ray.o)));
    let [p, q, r] = [a, b, c].map(|corner| shear.flat(corner));
    let (u, v, w) = (Shear::edge(r, q), Shear::edge(p, r), Shear::edge(q, p));
    let smallest = u.min(v).min(w);
    let largest = u.max(v).max(w);
    if !(smallest >= 0.0 || largest <= 0.0) {
        return None;
    }
    let n = (a - c).cross(b - a);
    let det = n.dot(shear.permute(&ray.d));
    if det == 0.0 {
        return None;
    }
    let t = n.dot(a) / det;
    if !(t > ray.tmin && t <= ray.tmax) {
        return None;
    }
    let sum = u + v + w;
    if sum == 0.0 {
        return None;
    }
    Some(ShapeHit {
        t,
        u: v / sum,
        v: w / sum,
    })
}

/// The surface at a hit that [`intersect`] found, by the weights `u` of b and `v` of c; see
/// [`parameters`] for `uvs`.
pub fn surface(corners: [Vec3; 3], uvs: Option<[Vec2; 3]>, u: f32, v: f32) -> LocalSurface {
    let (uv, dpdu, dpdv) = parameters(corners, uvs, u, v);
    LocalSurface {
        uv,
        dpdu,
        dpdv,
        ..surface_without_derivatives(corners, uvs, u, v)
    }
}

/// Returns [`surface`] with derivatives of 0.
pub fn surface_without_derivatives(corners: [Vec3; 3], uvs: Option<[Vec2; 3]>, u: f32, v: f32) -> LocalSurface {
    let point = surface_point(corners, u, v);
    LocalSurface {
        p: point.p,
        p_error: point.p_error,
        ng: point.ng,
        uv: uv(uvs, u, v),
        dpdu: Vec3::ZERO,
        dpdv: Vec3::ZERO,
    }
}

/// The way from the point at the weights `u` of b and `v` of c to the curved surface that a triangle with the unit `normals`
/// at its corners approximates, where that is above the triangle; zero where it is below.
///
/// The normals are on the side that counts as above, 0 where a corner has none. Rays that leave from there below the plane of
/// the triangle do not meet its neighbours too early. Source: Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021,
/// chapter 4.
#[inline]
pub fn lift([a, b, c]: [Vec3; 3], normals: [Vec3; 3], u: f32, v: f32) -> Vec3 {
    let (ab, ac) = (b - a, c - a);
    let from_a = ab * u + ac * v;
    let to_plane = |from: Vec3, n: Vec3| n * -from.dot(n).min(0.0);
    to_plane(from_a, normals[0]) * (1.0 - u - v)
        + to_plane(from_a - ab, normals[1]) * u
        + to_plane(from_a - ac, normals[2]) * v
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct TrianglePoint {
    pub p: Vec3,
    /// Bound on the absolute error of each coordinate of `p`.
    ///
    /// It has two parts: that of the point, from Pharr, Jakob, Humphreys, "Physically Based
    /// Rendering", 4th ed., section 6.8.4, and along the normal that of the distance to the plane
    /// which [`intersect`] finds from there, so that a ray that leaves the triangle does not meet
    /// it again. Of a needle the second part ends at the needle's width.
    pub p_error: Vec3,
    /// The direction of (b - a) x (c - a); +y where there is no area.
    pub ng: Vec3,
}

/// The place at the weights `u` of b and `v` of c.
#[inline]
pub fn surface_point(corners: [Vec3; 3], u: f32, v: f32) -> TrianglePoint {
    let (point, is_exact) = point_in_f32(corners, u, v);
    if is_exact {
        return point;
    }
    let n = normal_times_area(corners);
    point_along_normal(corners, u, v, n.normalize_or(DVec3::Y).as_vec3(), n.length() as f32)
}

/// The same for the most part: whether it is says the second answer. It is not where single
/// precision cannot hold the square of the area.
#[inline(always)]
pub fn point_in_f32(corners: [Vec3; 3], u: f32, v: f32) -> (TrianglePoint, bool) {
    let n = normal_times_area(corners).as_vec3();
    let length2 = n.length_squared();
    let length = length2.sqrt();
    let is_exact = (length2 > 1e-30) & (length2 < 1e30);
    (point_along_normal(corners, u, v, n / length, length), is_exact)
}

#[inline(always)]
fn point_along_normal(corners: [Vec3; 3], u: f32, v: f32, ng: Vec3, twice_area: f32) -> TrianglePoint {
    let [a, b, c] = corners;
    let (pa, pb, pc) = (a * (1.0 - u - v).max(0.0), b * u, c * v);
    let p = pa + pb + pc;
    TrianglePoint {
        p,
        p_error: (pa.abs() + pb.abs() + pc.abs()) * gamma(7) + ng.abs() * plane_error(corners, p, twice_area),
        ng,
    }
}

/// Bound on the error of the distance between `p`, a point of the triangle, and its plane, as the
/// operations of [`intersect`] find it: ten of them in a row, from the corners relative to the
/// origin to the product with the normal.
#[inline(always)]
pub(super) fn plane_error([a, b, c]: [Vec3; 3], p: Vec3, twice_area: f32) -> f32 {
    let (ra, rb, rc) = ((a - p).abs(), (b - p).abs(), (c - p).abs());
    let (e1, e2) = (ra + rc, rb + ra);
    let normal = Vec3::new(
        e1.y * e2.z + e1.z * e2.y,
        e1.z * e2.x + e1.x * e2.z,
        e1.x * e2.y + e1.y * e2.x,
    );
    let error = normal.dot(ra) * gamma(10) / twice_area;
    let longest2 = (b - a)
        .length_squared()
        .max((c - b).length_squared())
        .max((a - c).length_squared());
    // Wider than the needle; and where there is no area both are NaN or infinite.
    let of_needle = error.min(twice_area / longest2.sqrt());
    let error = if error * error * longest2 < twice_area * twice_area {
        error
    } else {
        of_needle
    };
    if error.is_finite() { error } else { 0.0 }
}

/// Parameters at the weights `u` of b and `v` of c, see [`parameters`].
#[inline(always)]
pub fn uv(uvs: Option<[Vec2; 3]>, u: f32, v: f32) -> Vec2 {
    match uvs {
        Some([a, b, c]) => a * (1.0 - u - v).max(0.0) + b * u + c * v,
        None => Vec2::new(u, v),
    }
}

/// Parameters at the weights `u` of b and `v` of c, and how the point moves with them: by those at the corners, `uvs`, or the
/// weights themselves where there are none.
///
/// Both derivatives are zero where the `uvs` lie in one point or on one line, so that the point does not follow from them.
#[inline(always)]
pub fn parameters(corners: [Vec3; 3], uvs: Option<[Vec2; 3]>, u: f32, v: f32) -> (Vec2, Vec3, Vec3) {
    match uvs {
        Some(of_corners) => {
            let (dpdu, dpdv) = derivatives(corners, of_corners);
            (uv(uvs, u, v), dpdu, dpdv)
        }
        None => {
            let [a, b, c] = corners;
            (uv(uvs, u, v), b - a, c - a)
        }
    }
}

fn derivatives([a, b, c]: [Vec3; 3], [ta, tb, tc]: [Vec2; 3]) -> (Vec3, Vec3) {
    let (ab, ac) = ((b - a).as_dvec3(), (c - a).as_dvec3());
    let (tab, tac) = ((tb - ta).as_dvec2(), (tc - ta).as_dvec2());
    let det = tab.perp_dot(tac);
    let dpdu = ((ab * tac.y - ac * tab.y) / det).as_vec3();
    let dpdv = ((ac * tab.x - ab * tac.x) / det).as_vec3();
    let spans = dpdu.cross(dpdv) != Vec3::ZERO && dpdu.is_finite() && dpdv.is_finite();
    if spans { (dpdu, dpdv) } else { (Vec3::ZERO, Vec3::ZERO) }
}

/// The normal, whose length is twice the area, in double precision.
#[inline(always)]
pub(super) fn normal_times_area([a, b, c]: [Vec3; 3]) -> DVec3 {
    let a = a.as_dvec3();
    (b.as_dvec3() - a).cross(c.as_dvec3() - a)
}

/// In m^2.
pub fn area(corners: [Vec3; 3]) -> f64 {
    0.5 * normal_times_area(corners).length()
}

/// The weights of b and c of a point that is uniform by area, from two uniform numbers in `[0, 1)`.
///
/// Source: Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
#[inline(always)]
pub fn sample_barycentric(u: Vec2) -> Vec2 {
    let half = u.x.min(u.y) * 0.5;
    let is_upper = u.y > u.x;
    Vec2::new(
        if is_upper { half } else { u.x - half },
        if is_upper { u.y - half } else { half },
    )
}

/// The point whose corners b and c weigh `weights`.
#[inline(always)]
pub fn point([a, b, c]: [Vec3; 3], weights: Vec2) -> DVec3 {
    let (a, w) = (a.as_dvec3(), weights.as_dvec2());
    a + (b.as_dvec3() - a) * w.x + (c.as_dvec3() - a) * w.y
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::{float::offset_origins, trig},
        shape::{
            battery::Random,
            spherical::{pdf, sample},
        },
    };

    fn random_triangle(random: &mut Random, center: Vec3, size: f32) -> [Vec3; 3] {
        std::array::from_fn(|_| center + random.direction() * size)
    }

    #[test]
    fn rays_spawned_from_a_triangle_never_meet_it_again() {
        let mut random = Random(51);
        for i in 0..20_000 {
            let (center, size) = [
                (Vec3::ZERO, 1.0),
                (Vec3::new(3.0, -2.0, 50.0), 0.1),
                (Vec3::new(0.0, 10.0, 0.0), 1e4),
            ][i % 3];
            let corners = random_triangle(&mut random, center, size);
            let [a, b, c] = corners;
            let weights = sample_barycentric(random.square());
            let needle = area(corners) < 2e-3 * f64::from(size * size);
            if needle {
                continue;
            }
            let s = surface(corners, None, weights.x, weights.y);
            let d = random.direction();
            let grazing = d - s.ng * (d.dot(s.ng) * 0.999);
            for w in [d, grazing] {
                let [above, below] = offset_origins(s.p, s.p_error, s.ng);
                let ray = Ray::new(if w.dot(s.ng) < 0.0 { below } else { above }, w);
                assert_eq!(intersect(&ray, a, b, c), None, "{corners:?} {s:?} {ray:?}");
            }
        }
    }

    /// Corners in a ring around a point, near a plane that is turned at random.
    fn ring(random: &mut Random, center: Vec3, size: f32) -> Vec<Vec3> {
        let n = random.direction();
        let (x, y) = n.any_orthonormal_pair();
        (0..7)
            .map(|i| {
                let angle = i as f32 * std::f32::consts::TAU / 7.0;
                center
                    + (x * trig::cos(angle) + y * trig::sin(angle) + n * (0.3 * random.next()))
                        * (size * (0.2 + random.next()))
            })
            .collect()
    }

    #[test]
    fn nothing_passes_between_triangles_that_share_an_edge_or_a_corner() {
        let mut random = Random(54);
        let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        for i in 0..40_000 {
            let size = [1e-3, 1.0, 30.0, 1e4][i % 4];
            let center = random.direction() * [0.0, 1.0, 100.0][i / 4 % 3] * size;
            let ring = ring(&mut random, center, size);
            let n = (ring[0] - center).cross(ring[1] - center).normalize();
            // At the corner that all share, at an edge, or at the place on it that is near its end.
            let along = [0.0, random.next() * 0.9, 1e-6][i / 12 % 3];
            let target = center + (ring[2] - center) * along;
            let side = random.direction();
            let d = match i / 36 % 3 {
                0 => axes[(random.next() * 6.0) as usize % 6],
                1 => (n + side * 0.5) * size,
                _ => Vec3::new(n.x, n.y, 0.0) + side * 1e-4,
            };
            // What is nearly seen edge-on has no inside.
            if d.normalize_or_zero().dot(n).abs() < 0.6 {
                continue;
            }
            let o = target - d * [1.0, 10.0, 1e-2][i % 3];
            let ray = Ray {
                tmin: f32::NEG_INFINITY,
                ..Ray::new(o, d)
            };
            let met = (0..7).any(|k| intersect(&ray, center, ring[k], ring[(k + 1) % 7]).is_some());
            assert!(met, "{ray:?} passes {center} in {ring:?}");
        }
    }

    #[test]
    fn weights_and_distances_are_those_of_exact_numbers() {
        let mut random = Random(55);
        for i in 0..20_000 {
            let size = [1e-3, 1.0, 1e4][i % 3];
            let corners = random_triangle(&mut random, random_center(i) * size, size);
            let [a, b, c] = corners;
            let p = point(corners, sample_barycentric(random.square())).as_vec3();
            let o = p + random.direction() * size * 3.0;
            let ray = Ray::new(o, (p - o) * (0.1 + random.next()));
            let n = normal_times_area(corners);
            let (o, d, [a, b, c], twice) = (
                o.as_dvec3(),
                ray.d.as_dvec3(),
                [a, b, c].map(|p| p.as_dvec3()),
                n.length(),
            );
            let cos = n.dot(d).abs() / (twice * d.length());
            if twice < 0.05 * f64::from(size * size) || cos < 0.05 {
                continue;
            }
            let Some(hit) = intersect(&ray, corners[0], corners[1], corners[2]) else {
                continue;
            };
            let t = n.dot(a - o) / n.dot(d);
            let at = o + d * t;
            let u = (a - c).cross(at - c).dot(n) / (twice * twice);
            let v = (b - a).cross(at - a).dot(n) / (twice * twice);
            assert!((f64::from(hit.t) / t - 1.0).abs() < 1e-4, "{} is not {t}", hit.t);
            assert!((f64::from(hit.u) - u).abs() < 1e-4, "{} is not {u}", hit.u);
            assert!((f64::from(hit.v) - v).abs() < 1e-4, "{} is not {v}", hit.v);
        }
    }

    fn random_center(i: usize) -> Vec3 {
        [Vec3::ZERO, Vec3::new(3.0, -2.0, 7.0)][i / 3 % 2]
    }

    #[test]
    fn surfaces_find_the_hit_again() {
        let mut random = Random(52);
        for _ in 0..1000 {
            let corners = random_triangle(&mut random, Vec3::ONE, 2.0);
            let [a, b, c] = corners;
            let w = sample_barycentric(random.square());
            let p = point(corners, w).as_vec3();
            let o = p + random.direction() * 5.0;
            let ray = Ray::new(o, p - o);
            let Some(hit) = intersect(&ray, a, b, c) else { continue };
            let s = surface(corners, None, hit.u, hit.v);
            let cos = s.ng.dot(ray.d.normalize()).abs();
            assert!((s.p - p).length() * cos < 1e-4, "{} is not {p}", s.p);
            assert!(s.ng.dot((b - a).cross(c - a)) > 0.0);
        }
    }

    #[test]
    fn derivatives_follow_the_texture_coordinates() {
        let corners = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 3.0];
        // u runs along +y, v along -x.
        let uvs = [Vec2::new(0.5, 1.0), Vec2::new(0.5, 0.0), Vec2::new(1.0, 1.0)];
        let s = surface(corners, Some(uvs), 0.25, 0.5);
        assert_eq!((s.dpdu, s.dpdv), (Vec3::Y * 6.0, Vec3::X * -2.0));
        assert_eq!((s.uv, s.p), (Vec2::new(0.75, 0.75), Vec3::new(0.5, 1.5, 0.0)));
        let degenerate = surface(corners, Some([Vec2::ONE; 3]), 0.25, 0.5);
        assert_eq!(degenerate.uv, Vec2::ONE);
        assert_eq!((degenerate.dpdu, degenerate.dpdv), (Vec3::ZERO, Vec3::ZERO));
    }

    #[test]
    fn the_density_of_samples_integrates_to_the_solid_angle_and_is_that_of_the_hit_near_and_far() {
        let corners = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 3.0];
        for from in [
            Vec3::new(0.3, -1.0, 2.0),
            Vec3::new(30.0, 10.0, 25.0),
            Vec3::new(0.4, 0.6, 0.05),
        ] {
            agrees_with_pdf(corners, from);
        }
    }

    fn agrees_with_pdf(corners: [Vec3; 3], from: Vec3) {
        let mut random = Random(53);
        let (n, mut solid_angle) = (100_000, 0.0);
        for _ in 0..n {
            let (weights, density) = sample(corners, from, random.square());
            let ray = Ray::new(from, (point(corners, weights).as_vec3() - from).normalize());
            solid_angle += 1.0 / f64::from(density);
            let [a, b, c] = corners;
            if let Some(hit) = intersect(&ray, a, b, c) {
                let pdf = pdf(corners, from, hit.u, hit.v);
                assert!((pdf / density - 1.0).abs() < 1e-4);
            }
        }
        // Van Oosterom and Strackee, "The Solid Angle of a Plane Triangle", 1983.
        let [a, b, c] = corners.map(|p| (p - from).as_dvec3());
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        let expected = 2.0 * libm::atan2(a.dot(b.cross(c)).abs(), below);
        assert!((solid_angle / f64::from(n) / expected - 1.0).abs() < 0.01);
    }
}
