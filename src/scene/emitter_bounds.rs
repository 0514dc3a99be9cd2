//! The bounds of emitters, from which the light tree is built.

use super::{
    Emitters, MeshRecord, SceneGeometry, SceneShading,
    emitters::{is_constant_emission, shape_point, texture_point, uniform_point},
};
use crate::{
    geometry::{Geometry, PrimId},
    light::{LightBounds, OrientationCone, Sidedness, area},
    material::{Emission, Material},
    math::{Aabb, Rgb, Transform, Vec2, Vec3, exponential, parallel},
    shape::{
        Shape,
        triangle::{self, TrianglePoint},
    },
    texture::TexturePoint,
};

/// The bounds of all emitters.
pub struct EmitterBounds {
    /// In the order of the emitters.
    pub all: Vec<LightBounds>,
    /// The number of emitters that give no light because they have no area.
    pub without_area: usize,
}

impl Emitters {
    pub fn bounds(&self, scene: &SceneGeometry, shading: &SceneShading) -> EmitterBounds {
        let geometry = scene.accel.geometry();
        let of_shape = |&i: &u32| shading.shape_bounds(geometry, i, shading.material(scene.shape_material(i)));
        let mut all: Vec<LightBounds> = self.shapes.iter().map(of_shape).collect();
        let mut without_area = all.iter().filter(|b| b.power <= 0.0).count();
        for run in &self.mesh_emitters {
            let mesh = &scene.meshes[run.mesh as usize];
            shading.mesh_bounds(geometry, mesh, &mut all);
            without_area += areas(geometry, mesh).filter(|area| *area <= 0.0).count();
        }
        EmitterBounds { all, without_area }
    }
}

impl SceneShading {
    /// Returns the bounds of a shape of this material.
    fn shape_bounds(&self, geometry: &Geometry, index: u32, material: &Material) -> LightBounds {
        let placed = &geometry.shapes[index as usize];
        let transform = geometry.transform(placed);
        let emission = material.emission();
        let normal = placed.shape.flat_normal();
        let normal = normal.map(|n| transform.map_or(n, |t| t.normal_to_world(n).normalize()));
        let radiance = emission.map_or(0.0, |e| self.mean_radiance(&e, &placed.shape, transform));
        let bounds = geometry.bounds(PrimId::new(geometry.triangles.len() as u32 + index));
        LightBounds {
            bounds,
            directions: normal.map_or(OrientationCone::ALL, |n| OrientationCone::flat(n, sidedness(emission))),
            // The mean projected area of a convex body is a quarter of its surface (Cauchy).
            power: area_in_world(&placed.shape, transform) * radiance * if normal.is_some() { 1.0 } else { 0.25 },
        }
    }

    /// An estimate, above 0, of the mean radiance that leaves `shape`, in W m^-2 sr^-1.
    fn mean_radiance(&self, emission: &Emission, shape: &Shape, transform: Option<&Transform>) -> f32 {
        const SIDE: u32 = 4;
        if is_constant_emission(emission) {
            return emission.radiance(&self.textures(), &uniform_point(), 1.0).mean();
        }
        let box_ = shape.bounds();
        let away = box_.extent().max_element() * 3.0;
        let places = [Vec3::new(1.0, 0.8, 0.6), Vec3::new(-1.0, -0.8, -0.6)].map(|d| box_.center() + d * away);
        let grid = (0..SIDE * SIDE).map(|i| Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5) / SIDE as f32);
        let radiances = grid.flat_map(|u| places.map(|from| (from, u))).filter_map(|(from, u)| {
            let sample = shape.sample(from, u)?;
            let surface = area::surface_at(shape, from, sample.p)?;
            let at = TexturePoint {
                uv: surface.uv,
                ..shape_point(transform, sample.p, surface.ng)
            };
            Some(emission.radiance(&self.textures(), &at, 1.0).mean())
        });
        let (sum, count) = radiances.fold((0.0, 0.0), |(sum, n), l| (sum + l, n + 1.0));
        // The texture may be brighter between the sampled points.
        if sum > 0.0 {
            sum / count
        } else {
            emission.scale * MIN_RELATIVE_RADIANCE
        }
    }

    /// Adds the bounds of a mesh's triangles.
    fn mesh_bounds(&self, geometry: &Geometry, mesh: &MeshRecord, all: &mut Vec<LightBounds>) {
        let Some(emission) = self.material(mesh.material).emission() else {
            return;
        };
        let radiance_at = |triangle: u32| self.triangle_radiance(geometry, &emission, mesh, triangle);
        let first = all.len();
        let none = LightBounds {
            bounds: Aabb::EMPTY,
            directions: OrientationCone::ALL,
            power: 0.0,
        };
        all.resize(first + mesh.triangles.len(), none);
        let of_mesh = &mut all[first..];
        let triangle_of = |k: usize| mesh.triangles.start + k as u32;
        parallel::update(of_mesh, |k, own| {
            let i = triangle_of(k);
            let corners = geometry.corners(i as usize);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let area = triangle::area(corners) as f32;
            let directions = normal.try_normalize().map_or(OrientationCone::ALL, |n| {
                OrientationCone::flat(n, sidedness(Some(emission)))
            });
            *own = LightBounds {
                bounds: Aabb::from_points(corners),
                directions,
                power: area * radiance_at(i),
            };
        });
        if is_constant_emission(&emission) {
            return;
        }
        // A texture that is dark at the sampled points may be bright between them.
        let (power, area) = (
            of_mesh.iter().map(|b| f64::from(b.power)).sum::<f64>(),
            areas(geometry, mesh).sum::<f64>(),
        );
        let mean = if power > 0.0 {
            (power / area) as f32
        } else {
            emission.scale * MIN_RELATIVE_RADIANCE
        };
        parallel::update(of_mesh, |k, bounds| {
            let i = triangle_of(k);
            let points = triangle_points(geometry, mesh, i, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
            let most = self.textures().max_within(&emission.radiance, &points) * emission.scale;
            if most <= mean * DIM_RADIANCE {
                bounds.power = 0.0;
            } else {
                let area = triangle::area(geometry.corners(i as usize)) as f32;
                bounds.power += MESH_MEAN_WEIGHT * mean.min(most) * area;
            }
        });
    }

    /// The mean radiance of a triangle over a few points, in W m^-2 sr^-1.
    fn triangle_radiance(&self, geometry: &Geometry, emission: &Emission, mesh: &MeshRecord, index: u32) -> f32 {
        const POINTS: [[f32; 2]; 4] = [[1.0 / 3.0, 1.0 / 3.0], [0.1, 0.1], [0.8, 0.1], [0.1, 0.8]];
        if is_constant_emission(emission) {
            return emission.radiance(&self.textures(), &uniform_point(), 1.0).mean();
        }
        let points = triangle_points(geometry, mesh, index, POINTS);
        let radiance = |at| emission.radiance(&self.textures(), at, 1.0);
        points.iter().fold(Rgb::BLACK, |sum, at| sum + radiance(at)).mean() / POINTS.len() as f32
    }
}

/// Returns the texture points at barycentric coordinates u and v of a triangle.
fn triangle_points<const N: usize>(
    geometry: &Geometry,
    mesh: &MeshRecord,
    index: u32,
    points: [[f32; 2]; N],
) -> [TexturePoint; N] {
    let corners = geometry.corners(index as usize);
    let vertices = geometry.triangles[index as usize];
    points.map(|[u, v]| {
        let TrianglePoint { p, ng, .. } = triangle::surface_point(corners, u, v);
        texture_point(mesh, vertices, (p, ng), [u, v])
    })
}

/// Returns the areas of a mesh's triangles, in m^2.
fn areas<'a>(geometry: &'a Geometry, mesh: &MeshRecord) -> impl Iterator<Item = f64> + 'a {
    mesh.triangles
        .clone()
        .map(|i| triangle::area(geometry.corners(i as usize)))
}

/// The radiance, relative to the texture's scale, that a texture is assumed to have if all sampled points are black: the
/// light tree still selects its emitter.
const MIN_RELATIVE_RADIANCE: f32 = 1e-3;
/// The weight of the mesh's mean in the estimate of a triangle.
const MESH_MEAN_WEIGHT: f32 = 0.05;

/// The radiance, relative to the mesh's mean, up to which a triangle is no light. Paths that hit it still find its light,
/// so this is unbiased.
const DIM_RADIANCE: f32 = 1e-3;

fn sidedness(emission: Option<Emission>) -> Sidedness {
    emission.map_or(Sidedness::Front, |e| e.sidedness)
}

/// The approximate area of a transformed shape, in m^2.
fn area_in_world(shape: &Shape, transform: Option<&Transform>) -> f32 {
    let stretch = transform.map_or(1.0, |t| exponential::cbrt(t.volume()));
    shape.area() * stretch * stretch
}
