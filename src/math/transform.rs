//! Affine transforms with their inverse.

use glam::{Affine3, DAffine3, DMat3, DMat4, DVec3, Vec3};

use super::{Aabb, Ray};

/// An invertible affine map from an object's own space to the world, with its inverse: 96 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    world_from_local: Affine3,
    local_from_world: Affine3,
}

impl Transform {
    pub const IDENTITY: Self = Self {
        world_from_local: Affine3::IDENTITY,
        local_from_world: Affine3::IDENTITY,
    };

    /// `None` where the map has no usable inverse: it is singular or its numbers are not finite.
    pub fn new(world_from_local: DAffine3) -> Option<Self> {
        let m = world_from_local.matrix3;
        let volume = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
        let relative = m.determinant().abs() / volume;
        if relative.is_nan() || relative < 1e-12 {
            return None;
        }
        let inverse = world_from_local.inverse();
        let t = Self {
            world_from_local: world_from_local.as_affine3(),
            local_from_world: inverse.as_affine3(),
        };
        (t.world_from_local.is_finite() && t.local_from_world.is_finite()).then_some(t)
    }

    /// The map of [`from_parts`] with its inverse.
    pub fn from_parts(translate: DVec3, rotate: DVec3, scale: DVec3) -> Option<Self> {
        Self::new(from_parts(translate, rotate, scale))
    }

    pub fn is_identity(&self) -> bool {
        *self == Self::IDENTITY
    }

    /// `self` after `inner`.
    pub fn then_from(&self, inner: &Self) -> Option<Self> {
        Self::new(widen(self.world_from_local) * widen(inner.world_from_local))
    }

    /// The map from local space to the world, in double precision.
    pub fn widened(&self) -> DAffine3 {
        widen(self.world_from_local)
    }

    /// A world-space ray in local space; its `t` means the same point in both.
    pub fn ray_to_local(&self, ray: &Ray) -> Ray {
        Ray {
            o: self.local_from_world.transform_point3(ray.o),
            d: self.local_from_world.transform_vector3(ray.d),
            ..*ray
        }
    }

    pub fn point_to_world(&self, p: Vec3) -> Vec3 {
        self.world_from_local.transform_point3(p)
    }

    pub fn point_to_local(&self, p: Vec3) -> Vec3 {
        self.local_from_world.transform_point3(p)
    }

    pub fn vector_to_world(&self, v: Vec3) -> Vec3 {
        self.world_from_local.transform_vector3(v)
    }

    pub fn vector_to_local(&self, v: Vec3) -> Vec3 {
        self.local_from_world.transform_vector3(v)
    }

    /// A normal, by the inverse transpose; not normalised. A mirroring map keeps the side it points
    /// to.
    pub fn normal_to_world(&self, n: Vec3) -> Vec3 {
        let m = self.local_from_world.matrix3;
        Vec3::new(m.x_axis.dot(n), m.y_axis.dot(n), m.z_axis.dot(n))
    }

    /// The inverse of [`Transform::normal_to_world`]; not normalised.
    pub fn normal_to_local(&self, n: Vec3) -> Vec3 {
        let m = self.world_from_local.matrix3;
        Vec3::new(m.x_axis.dot(n), m.y_axis.dot(n), m.z_axis.dot(n))
    }

    /// The bound of each coordinate's error after mapping `p`, known up to `p_error`, to the world.
    pub fn point_error_to_world(&self, p: Vec3, p_error: Vec3) -> Vec3 {
        let t = self.world_from_local.translation.abs();
        let g = super::float::gamma(4);
        absolute(&self.world_from_local, p_error) * (1.0 + g) + (absolute(&self.world_from_local, p.abs()) + t) * g
    }

    /// The bound of each coordinate's error, in the world, of the point that `p` becomes in local
    /// space when a ray that starts there is mapped.
    pub fn return_error(&self, p: Vec3) -> Vec3 {
        let local = absolute(&self.local_from_world, p.abs()) + self.local_from_world.translation.abs();
        absolute(&self.world_from_local, local * super::float::gamma(8))
    }

    /// By how much the way to local space and back magnifies roundings, at most: of a vector's
    /// components, and of a point at the origin in metres. The first is 1 for a scale along the
    /// axes, at most 3 for a rotation with it, and large for maps that shear.
    pub fn magnification(&self) -> (f32, f32) {
        let there = |v: Vec3| absolute(&self.world_from_local, absolute(&self.local_from_world, v)).max_element();
        let m = absolute(&self.world_from_local, self.local_from_world.translation.abs());
        let t = self.world_from_local.translation.abs();
        (there(Vec3::ONE).max(1.0), (m + t).max_element())
    }

    /// Whether it turns right-handed into left-handed.
    pub fn is_mirroring(&self) -> bool {
        self.world_from_local.matrix3.determinant() < 0.0
    }

    /// The factor by which it enlarges volumes.
    pub fn volume(&self) -> f32 {
        self.world_from_local.matrix3.determinant().abs()
    }

    /// The world-space box around a local one.
    pub fn bounds_to_world(&self, local: &Aabb) -> Aabb {
        if self.is_identity() || local.is_empty() {
            return *local;
        }
        if !local.is_finite() {
            return Aabb::UNBOUNDED;
        }
        Aabb::from_points((0..8).map(|i| self.point_to_world(local.corner(i)))).padded(4.0)
    }
}

/// The map's matrix, of absolute numbers, times `v`.
fn absolute(map: &Affine3, v: Vec3) -> Vec3 {
    let m = map.matrix3;
    m.x_axis.abs() * v.x + m.y_axis.abs() * v.y + m.z_axis.abs() * v.z
}

fn widen(a: Affine3) -> DAffine3 {
    DAffine3 {
        matrix3: a.matrix3.as_dmat3(),
        translation: a.translation.as_dvec3(),
    }
}

/// The affine map that scales first, then rotates about the fixed x, y and z axes in this order
/// (`rotate`, degrees), then translates.
pub fn from_parts(translate: DVec3, rotate: DVec3, scale: DVec3) -> DAffine3 {
    DAffine3 {
        matrix3: rotation(rotate) * DMat3::from_diagonal(scale),
        translation: translate,
    }
}

/// The rotation about the fixed x, y and z axes in this order by these angles (degrees).
pub fn rotation(angles: DVec3) -> DMat3 {
    axis_rotation(2, angles.z) * axis_rotation(1, angles.y) * axis_rotation(0, angles.x)
}

/// The angles (degrees) from which [`rotation`] makes this one. Of a turn of y by 90 degrees, where x and z are about the same
/// axis, z is 0.
pub fn angles(rotation: DMat3) -> DVec3 {
    let [x, y, z] = rotation.to_cols_array_2d();
    let across = (x[0] * x[0] + x[1] * x[1]).sqrt();
    let radians = if across > 1e-12 {
        [
            libm::atan2(y[2], z[2]),
            libm::atan2(-x[2], across),
            libm::atan2(x[1], x[0]),
        ]
    } else {
        [libm::atan2(-z[1], y[1]), libm::atan2(-x[2], across), 0.0]
    };
    DVec3::from_array(radians.map(f64::to_degrees))
}

/// The affine map of 16 numbers, row by row, for column vectors; `None` for a last row that is not 0
/// 0 0 1.
pub fn from_rows(rows: [[f64; 4]; 4]) -> Option<DAffine3> {
    let is_affine = rows[3] == [0.0, 0.0, 0.0, 1.0];
    is_affine.then(|| DAffine3::from_mat4(DMat4::from_cols_array_2d(&rows).transpose()))
}

/// The rotation about coordinate axis `axis` by `degrees`, exact at multiples of 90.
pub fn axis_rotation(axis: usize, degrees: f64) -> DMat3 {
    let (s, c) = match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        d => (libm::sin(d.to_radians()), libm::cos(d.to_radians())),
    };
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut m = DMat3::IDENTITY;
    let mut set = |row: usize, col: usize, x: f64| m.col_mut(col)[row] = x;
    set(u, u, c);
    set(v, u, s);
    set(u, v, -s);
    set(v, v, c);
    m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotation_about_fixed_axes_goes_x_then_y_then_z() {
        let t = Transform::from_parts(DVec3::ZERO, DVec3::new(90.0, 0.0, 90.0), DVec3::ONE).expect("a rotation");
        // +y goes to +z by x, stays by z.
        assert_eq!(t.point_to_world(Vec3::Y), Vec3::Z);
        // +x stays by x, goes to +y by z.
        assert_eq!(t.point_to_world(Vec3::X), Vec3::Y);
    }

    #[test]
    fn normals_stay_perpendicular_under_scale_and_mirror() {
        let t = Transform::from_parts(
            DVec3::new(1.0, 2.0, 3.0),
            DVec3::new(10.0, 20.0, 30.0),
            DVec3::new(-2.0, 0.5, 3.0),
        )
        .expect("invertible");
        let n = t.normal_to_world(Vec3::Z);
        assert!(n.dot(t.vector_to_world(Vec3::X)).abs() < 1e-5);
        assert!(n.dot(t.vector_to_world(Vec3::Y)).abs() < 1e-5);
        assert!(n.dot(t.vector_to_world(Vec3::Z)) > 0.0);
        assert!((t.normal_to_local(n) - Vec3::Z).length() < 1e-5);
        assert!(t.is_mirroring());
        let p = Vec3::new(0.3, -7.0, 2.0);
        assert!((t.point_to_local(t.point_to_world(p)) - p).length() < 1e-5);
    }

    #[test]
    fn singular_and_non_finite_maps_are_refused() {
        assert!(Transform::from_parts(DVec3::ZERO, DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0)).is_none());
        assert!(Transform::from_parts(DVec3::splat(f64::NAN), DVec3::ZERO, DVec3::ONE).is_none());
    }
}
