//! An axis-aligned box.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `min` | `[x, y, z]` | m | required |
//! | `max` | `[x, y, z]`, above `min` on every axis | m | required |
//!
//! ```toml
//! shape.cuboid = { min = [-1, 0, -1], max = [1, 2, 1] }
//! ```
//!
//! Normals point outwards. Every face has its own `u` and `v` from 0 to 1. On the four sides `v` runs up along +y and `u` to
//! the right as seen from outside; on the top (+y) `u` runs along +x and `v` along -z, on the bottom `u` along +x and `v`
//! along +z.
//!
//! # Implementation
//!
//! `dpdu x dpdv` points outwards. From outside, directions are sampled over the one to three visible faces, from inside over
//! all six: the face by its solid angle, and on it as on a rectangle (see [`super::quad`]).

use serde::Deserialize;

use super::{
    LocalSurface, ShapeHit, ShapeKind, ShapeSample,
    block::{Attempt, BlockKind, intersected_in_blocks, vector},
    numeric::{Or, choose, point_of, rounded, rounded_hit},
    rectangle::{Rectangle, SeenRectangle},
};
use crate::{
    math::{Aabb, DVec3, Ray, Vec2, Vec3},
    value::{Point, Problem, Spanned},
};

/// The description of a cuboid in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CuboidDesc {
    pub min: Point,
    pub max: Spanned<Point>,
}

impl CuboidDesc {
    /// A point of the shape.
    pub fn anchor(&self) -> Option<DVec3> {
        Some(self.min.0)
    }

    pub fn compile(&self, origin: DVec3) -> Result<Cuboid, Problem> {
        let (min, max) = (self.min.relative_to(origin), self.max.get_ref().relative_to(origin));
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let given = |p: &Point| p.0[axis] as f32;
            let (low, high) = (given(&self.min), given(self.max.get_ref()));
            let problem = |message: String| Problem::at(self.max.span(), message);
            if max[axis] == min[axis] {
                let message = format!("a cuboid without extent along {name}: both `min` and `max` have {low}");
                return Err(problem(message).with_help("for a flat rectangle, take `shape.quad`"));
            }
            if max[axis] < min[axis] {
                let message = format!("`max` has {name} = {high}, below the {low} of `min`");
                return Err(problem(message).with_help("swap the two numbers"));
            }
        }
        Ok(Cuboid { min, max })
    }
}

/// A box, seen from outside and from inside.
#[derive(Clone, Copy, Debug)]
pub struct Cuboid {
    min: Vec3,
    max: Vec3,
}

/// One of the six faces: its normal's axis and side, and the axes of `u` and `v` with their sense.
struct Face {
    normal: DVec3,
    along: [DVec3; 2],
}

/// -x, +x, -y, +y, -z, +z: axis k has the faces 2k and 2k + 1.
const FACES: [Face; 6] = [
    Face {
        normal: DVec3::NEG_X,
        along: [DVec3::Z, DVec3::Y],
    },
    Face {
        normal: DVec3::X,
        along: [DVec3::NEG_Z, DVec3::Y],
    },
    Face {
        normal: DVec3::NEG_Y,
        along: [DVec3::X, DVec3::Z],
    },
    Face {
        normal: DVec3::Y,
        along: [DVec3::X, DVec3::NEG_Z],
    },
    Face {
        normal: DVec3::NEG_Z,
        along: [DVec3::NEG_X, DVec3::Y],
    },
    Face {
        normal: DVec3::Z,
        along: [DVec3::X, DVec3::Y],
    },
];

impl Cuboid {
    /// A face, from the corner where its u and v are 0.
    fn rectangle(&self, face: &Face) -> Rectangle {
        let (min, max) = (self.min.as_dvec3(), self.max.as_dvec3());
        let extent = max - min;
        // Where u and v are 0, every axis with a positive direction is at its minimum.
        let backwards = face.normal - face.along[0] - face.along[1];
        let corner = DVec3::select(backwards.cmpgt(DVec3::ZERO), max, min);
        let lengths = face.along.map(|e| extent.dot(e.abs()));
        Rectangle {
            corner,
            edges: [face.along[0] * lengths[0], face.along[1] * lengths[1]],
            lengths,
            normal: face.normal,
        }
    }

    /// The faces as seen from a point, those that look away from it left out; from inside, all.
    fn seen(&self, from: Vec3) -> [Option<SeenRectangle>; 6] {
        let inside = from.cmpge(self.min).all() && from.cmple(self.max).all();
        std::array::from_fn(|i| {
            let face = &FACES[i];
            let (axis, outermost) = (i / 2, if i % 2 == 1 { self.max } else { self.min });
            let side = f64::from(from[axis]) - f64::from(outermost[axis]);
            let faces_us = side * face.normal[axis] > 0.0;
            (inside || faces_us).then(|| self.rectangle(face).seen_from(from.as_dvec3()))
        })
    }
}

fn solid_angles(seen: &[Option<SeenRectangle>; 6]) -> [f64; 6] {
    seen.map(|face| face.map_or(0.0, |f| f.solid_angle()))
}

impl BlockKind<6> for Cuboid {
    #[inline(always)]
    fn numbers(&self) -> [f64; 6] {
        let (a, b) = (self.min.as_dvec3(), self.max.as_dvec3());
        [a.x, a.y, a.z, b.x, b.y, b.z]
    }

    /// Tests the slabs; a ray that runs along a face counts as inside that slab.
    #[inline(always)]
    fn attempt(numbers: &[f64; 6], ray: &Ray) -> Attempt {
        let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
        let (min, max) = (vector(numbers, 0) - o, vector(numbers, 3) - o);
        let mut enter = (f64::NEG_INFINITY, 0.0_f32);
        let mut leave = (f64::INFINITY, 0.0_f32);
        let mut meets = true;
        for axis in 0..3 {
            let (low, high, d) = (min[axis], max[axis], d[axis]);
            let face = (2 * axis) as f32;
            let (at_low, at_high) = ((low / d, face), (high / d, face + 1.0));
            let (near, far) = (at_low, at_high).or(d > 0.0, (at_high, at_low));
            let is_level = d == 0.0;
            meets &= (is_level & (low <= 0.0) & (high >= 0.0)) | (!is_level & !near.0.is_nan());
            enter = near.or(!is_level & (near.0 > enter.0), enter);
            leave = far.or(!is_level & (far.0 < leave.0), leave);
        }
        let (near, is_near_on_ray) = rounded_hit(ray, enter.0, enter.1);
        let (far, is_far_on_ray) = rounded_hit(ray, leave.0, leave.1);
        meets &= (enter.0 <= leave.0) & (is_near_on_ray | is_far_on_ray);
        Attempt::of(near.or(is_near_on_ray, far), meets)
    }
}

impl ShapeKind for Cuboid {
    fn bounds(&self) -> Aabb {
        Aabb {
            min: self.min,
            max: self.max,
        }
    }

    intersected_in_blocks!();

    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> LocalSurface {
        let face = &FACES[(hit.u as usize).min(5)];
        let rectangle = self.rectangle(face);
        let uv = rectangle.uv(point_of(ray, hit));
        let inside = point_of(ray, hit).clamp(self.min.as_dvec3(), self.max.as_dvec3());
        let p = DVec3::select(face.normal.cmpeq(DVec3::ZERO), inside, rectangle.corner);
        let (p, p_error) = rounded(p, f64::from(self.min.abs().max(self.max.abs()).max_element()));
        LocalSurface {
            p,
            p_error,
            ng: face.normal.as_vec3(),
            uv,
            dpdu: rectangle.edges[0].as_vec3(),
            dpdv: rectangle.edges[1].as_vec3(),
        }
    }

    fn area(&self) -> f32 {
        2.0 * self.bounds().half_area()
    }

    fn sample(&self, from: Vec3, u: Vec2) -> Option<ShapeSample> {
        let seen = self.seen(from);
        let angles = solid_angles(&seen);
        let (i, ux) = choose(&angles, u.x);
        let face = seen[i]?;
        let p = face.sample(ux, u.y.into());
        let pmf = angles[i] / angles.iter().sum::<f64>();
        let pdf = face.pdf(p) * pmf as f32;
        (pdf > 0.0).then(|| ShapeSample {
            p: p.as_vec3(),
            ng: FACES[i].normal.as_vec3(),
            pdf,
        })
    }

    fn pdf(&self, from: Vec3, wi: Vec3, hit: &ShapeHit) -> f32 {
        let seen = self.seen(from);
        let angles = solid_angles(&seen);
        let i = (hit.u as usize).min(5);
        seen[i].map_or(0.0, |face| {
            let pmf = angles[i] / angles.iter().sum::<f64>();
            face.pdf(point_of(&Ray::new(from, wi), hit)) * pmf as f32
        })
    }
}
