//! Shapes: what a ray can meet, each in its own local space.
//!
//! A shape answers four questions. *Where is it* ([`ShapeKind::bounds`]), *where does a ray meet
//! it* ([`ShapeKind::intersect`], asked very often and so kept to the least that tells two hits
//! apart), *what is there* ([`ShapeKind::surface`], asked once, for the winning hit only), and *how
//! does light leave it* ([`ShapeKind::sample`] and [`ShapeKind::pdf`], for emitters).
//!
//! Normals are as authored: of a closed shape they point outwards, of a flat one to the side its
//! corners are wound about; they are never turned towards the viewer here.

use crate::{
    kind::kinds,
    math::{Aabb, DVec3, Dispatch, Ray, Vec2, Vec3},
    value::Problem,
};

mod axis;
mod ball;
#[cfg(test)]
mod battery;
pub mod block;
pub mod cone;
pub mod cuboid;
pub mod cylinder;
pub mod disk;
pub mod mesh;
mod numeric;
mod parallelogram;
pub mod plane;
pub mod quad;
pub mod rectangle;
mod round;
mod sample_block;
mod sampled;
pub mod sphere;
pub mod spherical;
pub mod triangle;

pub use block::{Attempt, Numbers, RayBlock};
pub use parallelogram::{FlatPlace, Parallelogram};
pub use sample_block::SampleBlock;
pub use sampled::SampledPoint;

/// The intersection of a ray and a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeHit {
    /// In lengths of the ray's direction.
    pub t: f32,
    /// With `v`, whatever the shape itself needs to find the place again in [`ShapeKind::surface`].
    pub u: f32,
    pub v: f32,
}

/// The surface around a hit, in the shape's local space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalSurface {
    /// The point, brought back onto the surface.
    pub p: Vec3,
    /// Bound on the absolute error of each coordinate of `p`.
    pub p_error: Vec3,
    /// Unit geometric normal, as authored.
    pub ng: Vec3,
    /// Surface parameters, what `mapping.uv` textures read.
    pub uv: Vec2,
    /// The derivatives of `p` with respect to `uv.x` and `uv.y`.
    pub dpdu: Vec3,
    pub dpdv: Vec3,
}

/// A sampled point on a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeSample {
    pub p: Vec3,
    /// Unit geometric normal, as authored.
    pub ng: Vec3,
    /// Density of the direction towards `p`, in sr^-1 as seen from `from`.
    pub pdf: f32,
}

/// The contract of every shape. All quantities are in local space, lengths in metres.
pub trait ShapeKind {
    /// A box around it; [`Aabb::UNBOUNDED`] where there is none.
    fn bounds(&self) -> Aabb;

    /// The nearest hit with `ray.tmin < t <= ray.tmax`. The direction need not be a unit vector.
    /// Never NaN.
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit>;

    /// Returns the numbers by which a block tells the shape from others of its kind.
    fn block_numbers(&self) -> Numbers {
        Numbers::default()
    }

    /// Attempts [`ShapeKind::intersect`] without an end for all lanes of a block whose shapes are of this kind; the
    /// default attempts nothing.
    fn attempt_block(&self, _on: impl Dispatch, block: &mut RayBlock<'_>) {
        block.answer.fill(Attempt::UNKNOWN);
    }

    /// The parallelogram that the shape is, if rays of a scene are traced against its two triangles in place of
    /// [`ShapeKind::intersect`].
    fn parallelogram(&self) -> Option<&Parallelogram> {
        None
    }

    /// The surface at a hit of `ray`; of a [`ShapeKind::parallelogram`], only `t` of the hit counts.
    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> LocalSurface;

    /// The surface's area, in m^2; infinite for an unbounded shape.
    fn area(&self) -> f32;

    /// A point on the shape as seen from `from`, by two uniform numbers in `[0, 1)`; `None` where
    /// it cannot be seen or cannot be sampled.
    fn sample(&self, from: Vec3, u: Vec2) -> Option<ShapeSample>;

    /// Sets the emitter of a block's lane, if a block can hold the shape. Returns whether it can.
    fn put_in_block(&self, _lane: usize, _block: &mut SampleBlock) -> bool {
        false
    }

    /// The density of [`ShapeKind::sample`] to choose the direction `wi`, in sr^-1. `hit` is where
    /// the ray from `from` along `wi` meets the shape: its `t` counts lengths of `wi`, which need
    /// not be a unit vector.
    fn pdf(&self, from: Vec3, wi: Vec3, hit: &ShapeHit) -> f32;

    /// The unit normal of a shape that is flat all over; `None` for other shapes. Emitters of which it is known are
    /// sampled with less noise.
    fn flat_normal(&self) -> Option<Vec3> {
        None
    }

    /// The largest curvature of the surface, in radians per metre; 0 for a flat one.
    fn curvature(&self) -> f32 {
        0.0
    }
}

kinds! {
    /// A shape, flat and without pointers.
    enum Shape / ShapeDesc {
        "sphere" => Sphere(sphere::Sphere, sphere::SphereDesc),
        "disk" => Disk(disk::Disk, disk::DiskDesc),
        "quad" => Quad(quad::Quad, quad::QuadDesc),
        "cuboid" => Cuboid(cuboid::Cuboid, cuboid::CuboidDesc),
        "cylinder" => Cylinder(cylinder::Cylinder, cylinder::CylinderDesc),
        "cone" => Cone(cone::Cone, cone::ConeDesc),
        "plane" => Plane(plane::Plane, plane::PlaneDesc),
    }
    described only { "mesh" => Mesh(mesh::MeshDesc), }
    compiled by fn compile(&self, origin: DVec3) -> Result<Shape, Problem>;
    described by {
        /// A point of the shape, or near it, in the space of its description; `None` for an unbounded shape and for a mesh.
        fn anchor(&self) -> Option<DVec3>;
    }
    /// See [`ShapeKind::bounds`].
    fn bounds(&self) -> Aabb;
    /// See [`ShapeKind::intersect`].
    fn intersect(&self, ray: &Ray) -> Option<ShapeHit>;
    /// See [`ShapeKind::block_numbers`].
    fn block_numbers(&self) -> Numbers;
    /// See [`ShapeKind::attempt_block`].
    fn attempt_block(&self, on: impl Dispatch, block: &mut RayBlock<'_>);
    /// See [`ShapeKind::parallelogram`].
    fn parallelogram(&self) -> Option<&Parallelogram>;
    /// See [`ShapeKind::surface`].
    fn surface(&self, ray: &Ray, hit: &ShapeHit) -> LocalSurface;
    /// See [`ShapeKind::area`].
    fn area(&self) -> f32;
    /// See [`ShapeKind::sample`].
    fn sample(&self, from: Vec3, u: Vec2) -> Option<ShapeSample>;
    /// See [`ShapeKind::put_in_block`].
    fn put_in_block(&self, lane: usize, block: &mut SampleBlock) -> bool;
    /// See [`ShapeKind::pdf`].
    fn pdf(&self, from: Vec3, wi: Vec3, hit: &ShapeHit) -> f32;
    /// See [`ShapeKind::flat_normal`].
    fn flat_normal(&self) -> Option<Vec3>;
    /// See [`ShapeKind::curvature`].
    fn curvature(&self) -> f32;
}

impl ShapeDesc {
    /// The mesh of a file, if it is one.
    pub fn mesh(&self) -> Option<&mesh::MeshDesc> {
        match self {
            Self::Mesh(mesh) => Some(mesh),
            _ => None,
        }
    }
}
