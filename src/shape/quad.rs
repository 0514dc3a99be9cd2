//! A flat convex quadrilateral.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `corners` | four points `[x, y, z]`, in order around the quad | m | required |
//!
//! ```toml
//! shape.quad = { corners = [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]] }
//! ```
//!
//! With corners A, B, C, D the normal is that of (B - A) x (D - A): it points to the side from which the corners run
//! counterclockwise, in the shape's own space: a `transform` that mirrors keeps the side. The parameters `u` and `v` are bilinear:
//! A = (0, 0), B = (1, 0), C = (1, 1), D = (0, 1).
//!
//! The corners must lie in a plane: each may be off by up to 1e-4 of the longer diagonal, and by the rounding of numbers
//! that large. The surface is then the plane to which all four corners are equally close.
//!
//! # Implementation
//!
//! Rays of a scene are traced against the two triangles of a parallelogram.
//!
//! Two quads that share an edge, or a quad and a triangle of a mesh, leave no gap: on which side of an edge a ray passes
//! depends on the edge's two corners alone, as in [`triangle`]. `dpdu x dpdv` points along the normal.
//!
//! On a rectangle that is near for its size, directions are sampled uniformly by solid angle; on any other quad, points uniformly
//! by area.

use serde::Deserialize;

use super::{
    LocalSurface, Parallelogram, Shape, ShapeHit, ShapeKind, ShapeSample,
    numeric::{area_sample, choose, dot_direction, point_of, rounded, rounded_hit, solid_angle_pdf},
    rectangle::{Rectangle, SeenRectangle},
    sample_block::SampleBlock,
    triangle::{self, Shear},
};
use crate::{
    math::{Aabb, DVec3, Ray, Vec2, Vec3},
    value::{List, Point, Problem, Spanned},
};

/// The largest distance of a corner from the plane, in lengths of the longer diagonal.
const PLANAR_TOLERANCE: f64 = 1e-4;

/// The description of a quad in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QuadDesc {
    pub corners: Spanned<List<Point, 4>>,
}

impl QuadDesc {
    /// A point of the shape.
    pub fn anchor(&self) -> Option<DVec3> {
        Some(self.corners.get_ref().0[0].0)
    }

    pub fn compile(&self, origin: DVec3) -> Result<Quad, Problem> {
        let problem = |message: String, help: &str| Err(Problem::at(self.corners.span(), message).with_help(help));
        let quad = Quad::from_corners(self.corners.get_ref().0.map(|p| p.relative_to(origin)));
        let corners = quad.corners.map(|c| c.as_dvec3());
        let [a, b, c, d] = corners;
        let size = (c - a).length().max((d - b).length());
        // What rounding to single precision does to a corner, and to twice an area.
        let rounding = corners.iter().fold(size, |m, c| m.max(c.length())) * f64::from(f32::EPSILON);
        let noise = size * rounding;
        let spread = [0, 1, 2, 3].map(|i| quad.turn(i).length());
        if spread.iter().all(|s| *s <= noise) {
            let message = "the corners are on one line or in one point: the quad has no area";
            return problem(message.to_owned(), "give four corners of a convex quadrilateral");
        }
        let crossed = || {
            let message = "the corners make a dent or cross each other";
            problem(
                message.to_owned(),
                "give the corners of a convex quadrilateral, in order around it",
            )
        };
        if (c - a).cross(d - b).length() <= noise {
            return crossed();
        }
        let off = (a - quad.middle).dot(quad.normal).abs();
        if off > PLANAR_TOLERANCE * size + rounding {
            let message = format!(
                "the corners are not in a plane: they are {:.2} % of the quad's size off it",
                100.0 * off / size
            );
            return problem(message, "move them into a plane, or use a mesh of two triangles");
        }
        if (0..4).any(|i| quad.turn(i).dot(quad.normal) < -noise) {
            return crossed();
        }
        Ok(quad)
    }
}

/// A convex quadrilateral, seen from both sides.
#[derive(Clone, Copy, Debug)]
pub struct Quad {
    corners: [Vec3; 4],
    /// The mean of the corners.
    middle: DVec3,
    normal: DVec3,
    /// The lengths of the edges AB and AD, if it is a rectangle up to the rounding of its corners.
    lengths: Option<[f64; 2]>,
    /// The vectors whose products with a point relative to A are u and v, for a parallelogram, at most [`MAX_SKEW`] off.
    inverse: Option<[DVec3; 2]>,
    /// The parallelogram that the quad is, up to the rounding of its corners.
    parallelogram: Option<Parallelogram>,
    /// The largest coordinate.
    extent: f32,
    /// Kept, since every hit is brought into it.
    bounds: Aabb,
}

/// The most by which the corner C of a parallelogram may be off, as a part of its size. Rounded coordinates are within it.
const MAX_SKEW: f64 = 1e-5;

impl Quad {
    /// Unit.
    pub fn normal(&self) -> Vec3 {
        self.normal.as_vec3()
    }

    pub(crate) fn from_corners(corners: [Vec3; 4]) -> Self {
        let [a, b, c, d] = corners.map(|c| c.as_dvec3());
        // Of a flat convex quad this is the direction of (B - A) x (D - A), and it needs no angle
        // at A.
        let normal = (c - a).cross(d - b).normalize_or(DVec3::Y);
        let (e, f, skew) = (b - a, d - a, a - b + c - d);
        let noise = f64::from(4.0 * f32::EPSILON);
        let largest = [a, b, c, d].iter().fold(0.0_f64, |m, c| m.max(c.abs().max_element()));
        // The rounding of corners turns short edges.
        let (product, lengths) = (e.length() * f.length(), e.length() + f.length());
        let turned = (noise * largest * lengths).min(MAX_SKEW * product);
        let is_parallelogram = skew.length() <= noise * largest;
        let is_rectangle = is_parallelogram && e.dot(f).abs() <= turned.max(noise * product);
        let middle = (a + b + c + d) * 0.25;
        let across = |x: DVec3, y: DVec3| x.cross(normal) / x.cross(normal).dot(y);
        let inverse = [across(f, e), across(e, f)];
        let slope = inverse[0].length().max(inverse[1].length());
        let inverse = (slope * skew.length() <= MAX_SKEW).then_some(inverse);
        let mut quad = Self {
            corners,
            middle,
            normal,
            lengths: is_rectangle.then(|| [e.length(), f.length()]),
            inverse,
            parallelogram: inverse
                .filter(|_| is_parallelogram)
                .map(|to_uv| Parallelogram::new(corners, to_uv, normal.as_vec3())),
            extent: largest as f32,
            bounds: Aabb::EMPTY,
        };
        quad.bounds = Aabb::from_points(corners.into_iter().chain(quad.flat())).padded(1.0);
        quad
    }

    /// The corners moved onto the plane, on which rays meet the quad and light samples lie.
    #[inline]
    fn flat(&self) -> [Vec3; 4] {
        if self.bilinear().3 == DVec3::ZERO {
            return self.corners;
        }
        let (n, middle) = (self.normal, self.middle);
        let on_plane = |c: DVec3| c - n * (c - middle).dot(n);
        self.corners.map(|c| on_plane(c.as_dvec3()).as_vec3())
    }

    /// The cross product of the edges that meet in corner `i`.
    fn turn(&self, i: usize) -> DVec3 {
        let at = |k: usize| self.corners[(i + k) % 4].as_dvec3();
        (at(1) - at(0)).cross(at(3) - at(0))
    }

    /// Corner A, the edges AB and AD, and how far C is from completing a parallelogram.
    #[inline(always)]
    fn bilinear(&self) -> (DVec3, DVec3, DVec3, DVec3) {
        let [a, b, c, d] = self.corners.map(|c| c.as_dvec3());
        (a, b - a, d - a, a - b + c - d)
    }

    /// The u and v of a point of the plane of a parallelogram, relative to its corner A.
    #[inline(always)]
    fn inverse_parallelogram([to_u, to_v]: [DVec3; 2], h: DVec3) -> (f64, f64) {
        (h.dot(to_u).clamp(0.0, 1.0), h.dot(to_v).clamp(0.0, 1.0))
    }

    /// The u and v of a point of the plane of a quad that is no parallelogram: the inverse of A + u
    /// e + v f + u v skew, each in `[0, 1]`.
    ///
    /// Both sides' cross product with e + v skew, along the normal, leaves a quadratic equation for
    /// v.
    #[inline]
    fn inverse_bilinear(&self, p: DVec3) -> (f64, f64) {
        let (a, e, f, skew) = self.bilinear();
        let h = p - a;
        let cross = |x: DVec3, y: DVec3| x.cross(y).dot(self.normal);
        let (k2, k1, k0) = (cross(skew, f), cross(e, f) + cross(h, skew), cross(h, e));
        let q = -0.5 * (k1 + (k1 * k1 - 4.0 * k2 * k0).max(0.0).sqrt().copysign(k1));
        let u_at = |v: f64| {
            let across = e + skew * v;
            let u = (h - f * v).dot(across) / across.length_squared();
            // Where A and B are one point, or C and D, every u leads there.
            if u.is_nan() { 0.0 } else { u.clamp(0.0, 1.0) }
        };
        let distance = |(u, v): (f64, f64)| (h - e * u - f * v - skew * (u * v)).length_squared();
        // Both roots may be inside: where A and B are one point, one of them is 0.
        [k0 / q, q / k2]
            .into_iter()
            .filter(|v| v.is_finite())
            .map(|v| v.clamp(0.0, 1.0))
            .map(|v| (u_at(v), v))
            .min_by(|x, y| distance(*x).total_cmp(&distance(*y)))
            .unwrap_or((u_at(0.0), 0.0))
    }

    /// Whether a ray passes between the edges, by the edge test of [`triangle::intersect`].
    #[inline]
    fn has_edges_around(&self, ray: &Ray) -> bool {
        let shear = Shear::new(&ray.d);
        let corner = |i: usize| shear.flat(shear.permute(&(self.corners[i] - ray.o)));
        let (a, b, c, d) = (corner(0), corner(1), corner(2), corner(3));
        let edge = Shear::edge;
        let (ab, bc, cd, da) = (edge(a, b), edge(b, c), edge(c, d), edge(d, a));
        ab.min(bc).min(cd.min(da)) >= 0.0 || ab.max(bc).max(cd.max(da)) <= 0.0
    }

    /// The place of the quad nearest to where the ray met it: u, v and the point.
    #[inline]
    fn place(&self, ray: &Ray, hit: &ShapeHit) -> (f64, f64, DVec3) {
        // Triangles tell no more than `t`.
        let v = if self.parallelogram.is_some() { 0.0 } else { hit.v };
        let on_ray = point_of(ray, &ShapeHit { v, ..*hit });
        let (a, e, f, skew) = self.bilinear();
        let (u, v) = match self.inverse {
            Some(inverse) if skew == DVec3::ZERO => {
                // A parallelogram has no corner off its plane.
                let (u, v) = Self::inverse_parallelogram(inverse, on_ray - a);
                return (u, v, a + e * u + f * v);
            }
            Some(inverse) => {
                // Each step makes the error smaller by the skew.
                let step = |(u, v): (f64, f64)| Self::inverse_parallelogram(inverse, on_ray - a - skew * (u * v));
                step(step(step((0.0, 0.0))))
            }
            None => self.inverse_bilinear(on_ray),
        };
        let p = a + e * u + f * v + skew * (u * v);
        (u, v, p - self.normal * (p - self.middle).dot(self.normal))
    }

    /// The triangles ABC and ACD.
    fn halves([a, b, c, d]: [Vec3; 4]) -> [[Vec3; 3]; 2] {
        [[a, b, c], [a, c, d]]
    }

    /// The rectangle with edges of these lengths, if it is one.
    #[inline(always)]
    fn rectangle(&self, lengths: [f64; 2]) -> Rectangle {
        let [corner, b, _, d] = self.flat().map(|c| c.as_dvec3());
        Rectangle {
            corner,
            edges: [b - corner, d - corner],
            lengths,
            normal: self.normal,
        }
    }

    #[inline]
    fn seen_from(&self, from: Vec3) -> Option<SeenRectangle> {
        Some(self.rectangle(self.lengths?).seen_from(from.as_dvec3()))
    }

    /// Per m^2.
    fn per_area(&self) -> f64 {
        1.0 / Self::halves(self.flat()).map(triangle::area).iter().sum::<f64>()
    }
}

impl From<Quad> for Shape {
    fn from(quad: Quad) -> Self {
        Self::Quad(quad)
    }
}

impl ShapeKind for Quad {
    #[inline]
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    #[inline]
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let t = (self.middle - ray.o.as_dvec3()).dot(self.normal) / dot_direction(ray.d, self.normal);
        let (hit, is_on_ray) = rounded_hit(ray, t, 0.0);
        (is_on_ray && self.has_edges_around(ray)).then_some(hit)
    }

    fn parallelogram(&self) -> Option<&Parallelogram> {
        self.parallelogram.as_ref()
    }

    #[inline]
    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> LocalSurface {
        let (u, v, p) = self.place(ray, hit);
        let (p, p_error) = rounded(p, self.extent.into());
        let (_, e, f, skew) = self.bilinear();
        LocalSurface {
            p,
            p_error,
            ng: self.normal.as_vec3(),
            uv: Vec2::new(u as f32, v as f32),
            dpdu: (e + skew * v).as_vec3(),
            dpdv: (f + skew * u).as_vec3(),
        }
    }

    fn flat_normal(&self) -> Option<Vec3> {
        Some(self.normal())
    }

    fn area(&self) -> f32 {
        (1.0 / self.per_area()) as f32
    }

    #[inline]
    fn sample(&self, from: Vec3, u: Vec2) -> Option<ShapeSample> {
        let Some(seen) = self.seen_from(from) else {
            let halves = Self::halves(self.flat());
            let areas = halves.map(triangle::area);
            let (half, ux) = choose(&areas, u.x);
            let p = triangle::point(halves[half], triangle::sample_barycentric(Vec2::new(ux as f32, u.y)));
            return area_sample(1.0 / (areas[0] + areas[1]), from, p, self.normal);
        };
        let p = seen.sample(u.x.into(), u.y.into());
        let pdf = seen.pdf(p);
        (pdf > 0.0).then(|| ShapeSample {
            p: p.as_vec3(),
            ng: self.normal.as_vec3(),
            pdf,
        })
    }

    #[inline]
    fn put_in_block(&self, lane: usize, block: &mut SampleBlock) -> bool {
        let Some(lengths) = self.lengths else { return false };
        let plane_error = self.parallelogram.map_or(0.0, |flat| flat.plane_error(None));
        block.set_rectangle(lane, &self.rectangle(lengths), plane_error);
        true
    }

    fn pdf(&self, from: Vec3, wi: Vec3, hit: &ShapeHit) -> f32 {
        let (_, _, p) = self.place(&Ray::new(from, wi), hit);
        self.seen_from(from).map_or_else(
            || solid_angle_pdf(self.per_area(), from.as_dvec3(), p, self.normal),
            |seen| seen.pdf(p),
        )
    }
}

#[cfg(test)]
mod tests;
