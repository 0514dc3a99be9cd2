//! Computation of surface interactions from hits.

use std::ops::Range;

use glam::Vec2Swizzles;

use super::{
    MeshRecord, Scene, SurfaceInteraction,
    interaction::{HitGeometry, SmoothSurface},
    surface_soa::{SoaBlock, SurfaceSoa},
};
use crate::{
    geometry::{Geometry, Hit, InstanceId, PrimId},
    material::MaterialId,
    math::{Dispatch, Ray, Transform, Vec2, Vec3},
    shape::{FlatPlace, LocalSurface, ShapeHit, triangle},
    simd::prefetch,
    texture::{ScenePlace, TexturePoint, TextureSpace, VertexAttributes},
};

/// The distance of prefetches, in hits.
const PREFETCH_DISTANCE: usize = 12;

/// A batch of surface interactions.
#[derive(Debug, Default)]
pub struct Surfaces {
    pub interactions: Vec<SurfaceInteraction>,
    /// The mesh of each interaction and of those that follow, see [`SceneGeometry::mesh_index`](super::SceneGeometry::mesh_index).
    meshes: Vec<usize>,
    soa: SurfaceSoa,
}

impl Surfaces {
    /// The geometry of all interactions, in blocks.
    pub fn blocks(&self) -> &[SoaBlock] {
        self.soa.blocks()
    }
}

/// The surface of a hit, before its shading view is computed.
enum HitSurface<'a> {
    Geometry(HitGeometry),
    /// A triangle in world space.
    Triangle(MeshTriangle<'a>),
}

/// A triangle of a mesh.
struct MeshTriangle<'a> {
    mesh: &'a MeshRecord,
    corners: [Vec3; 3],
    /// The indices of the corners in the mesh's own arrays.
    own: [usize; 3],
}

impl<'a> MeshTriangle<'a> {
    #[inline(always)]
    fn new(mesh: &'a MeshRecord, geometry: &Geometry, prim: PrimId) -> Self {
        let index = prim.index() as usize;
        Self {
            mesh,
            corners: geometry.corners(index),
            own: geometry.triangles[index].map(|v| (v - mesh.vertices.start) as usize),
        }
    }

    /// Interpolates tangents (in the mesh's space), colours and the second UV set.
    #[inline]
    fn fill_attributes(&self, hit: &Hit, surface: &mut SurfaceInteraction) {
        surface.tangent = self.mesh.tangent(self.own, hit.u, hit.v);
        if self.mesh.has_attributes() {
            surface.texture.vertex = self.mesh.attributes(self.own, hit.u, hit.v);
        }
    }

    #[inline(always)]
    fn uvs(&self) -> Option<[Vec2; 3]> {
        (!self.mesh.uvs.is_empty()).then(|| self.own.map(|i| self.mesh.uvs[i]))
    }

    /// The smooth surface at the hit of a ray along `d`, from the shading normals of the corners; `to_world` transforms normals
    /// and points.
    #[inline(always)]
    fn smooth(&self, hit: &Hit, d: Vec3, to_world: impl ToWorld) -> SmoothSurface {
        if self.mesh.normals.is_empty() {
            return SmoothSurface::default();
        }
        let normals = self.own.map(|i| to_world.normal(self.mesh.normals[i]));
        let [a, b, c] = normals;
        let corners = self.corners.map(|p| to_world.point(p));
        let ng = to_world.normal((self.corners[1] - self.corners[0]).cross(self.corners[2] - self.corners[0]));
        let normal = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
        // The viewer's side, by normals that may be reversed.
        let side = if (ng.dot(d) > 0.0) == (ng.dot(normal) < 0.0) {
            1.0
        } else {
            -1.0
        };
        SmoothSurface {
            normal,
            lift: triangle::lift(corners, normals.map(|n| n * side), hit.u, hit.v),
        }
    }
}

/// A transform from a mesh's space to world space.
trait ToWorld {
    fn point(&self, p: Vec3) -> Vec3;
    fn normal(&self, n: Vec3) -> Vec3;
}

/// A mesh in world space.
struct InWorld;

impl ToWorld for InWorld {
    #[inline(always)]
    fn point(&self, p: Vec3) -> Vec3 {
        p
    }

    #[inline(always)]
    fn normal(&self, n: Vec3) -> Vec3 {
        n
    }
}

impl ToWorld for &Transform {
    fn point(&self, p: Vec3) -> Vec3 {
        self.point_to_world(p)
    }

    fn normal(&self, n: Vec3) -> Vec3 {
        self.normal_to_world(n).normalize_or_zero()
    }
}

impl Scene {
    /// Computes the surface interaction of a hit.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> SurfaceInteraction {
        let geometry = self.geometry.accel.geometry();
        let mut surface = SurfaceInteraction::unset();
        let mesh = self.geometry.mesh_of(hit.prim);
        let placed_geometry = match self.fill(geometry, (ray, hit, mesh), &mut surface, |_| true) {
            HitSurface::Geometry(placed_geometry) => placed_geometry,
            HitSurface::Triangle(face) => {
                let point = triangle::surface_point(face.corners, hit.u, hit.v);
                let SmoothSurface { normal, lift } = face.smooth(hit, ray.d, InWorld);
                HitGeometry {
                    p: point.p,
                    p_error: point.p_error,
                    ng: point.ng,
                    smooth: normal,
                    lift,
                }
            }
        };
        surface.set_geometry(&placed_geometry, &placed_geometry.shading_view(ray.d));
        self.fill_texture_point(hit, mesh, &mut surface);
        if self.shading.reads_scene_places() {
            surface.fill_scene_place();
        }
        surface
    }

    /// Computes the surface interactions of the hits `part` into `surfaces`, in place of its contents. `hit` returns a hit and its
    /// ray by index; `prims`, the primitives of all hits, serve to prefetch the data of later hits.
    #[inline]
    pub fn surfaces<'a>(
        &self,
        on: impl Dispatch,
        part: Range<usize>,
        prims: &[PrimId],
        hit: impl Fn(usize) -> (&'a Ray, &'a Hit),
        surfaces: &mut Surfaces,
    ) {
        let geometry = self.geometry.accel.geometry();
        let Surfaces {
            interactions,
            meshes,
            soa,
        } = surfaces;
        interactions.resize(part.len(), SurfaceInteraction::unset());
        soa.clear();
        meshes.clear();
        let first = prims.iter().take(part.start + PREFETCH_DISTANCE).skip(part.start);
        meshes.extend(first.map(|prim| self.geometry.mesh_index(*prim)));
        for (surface, (k, i)) in interactions.iter_mut().zip(part.clone().enumerate()) {
            if let Some(later) = prims.get(i + 2 * PREFETCH_DISTANCE) {
                prefetch(&geometry.triangles, later.index() as usize);
            }
            if let Some(later) = prims.get(i + PREFETCH_DISTANCE) {
                let mesh = self.geometry.mesh_index(*later);
                self.prefetch_corners(geometry, *later, self.geometry.meshes.get(mesh));
                meshes.push(mesh);
            }
            let (ray, hit) = hit(i);
            let hit_on = (ray, hit, self.geometry.meshes.get(meshes[k]));
            let varies = |material| self.shading.is_spatially_varying(material);
            match self.fill(geometry, hit_on, surface, varies) {
                HitSurface::Geometry(placed_geometry) => soa.push_geometry(&placed_geometry, ray.d),
                HitSurface::Triangle(face) => {
                    let smooth = face.smooth(hit, ray.d, InWorld);
                    soa.push_triangle(face.corners, [hit.u, hit.v], smooth, ray.d);
                }
            }
        }
        soa.compute(on);
        for (k, surface) in interactions.iter_mut().enumerate() {
            soa.set_geometry(k, surface);
            if self.shading.is_spatially_varying(surface.material) {
                let mesh = self.geometry.meshes.get(meshes[k]);
                self.fill_texture_point(hit(part.start + k).1, mesh, surface);
                if self.shading.reads_scene_places() {
                    surface.fill_scene_place();
                }
            }
        }
    }

    /// Prefetches the vertices and attributes of a hit's triangle.
    #[inline(always)]
    fn prefetch_corners(&self, geometry: &Geometry, prim: PrimId, mesh: Option<&MeshRecord>) {
        let Some(mesh) = mesh else {
            return;
        };
        let corners = &geometry.triangles[prim.index() as usize];
        for &v in corners {
            prefetch(&geometry.vertices, v as usize);
        }
        for &v in corners.iter().filter(|_| !mesh.normals.is_empty()) {
            prefetch(&mesh.normals, (v - mesh.vertices.start) as usize);
        }
        for &v in corners.iter().filter(|_| !mesh.uvs.is_empty()) {
            prefetch(&mesh.uvs, (v - mesh.vertices.start) as usize);
        }
    }

    /// Sets all fields of `surface` but its geometry, and returns that. A hit on a triangle has a mesh. `needs_texture` tells for
    /// which materials the texture point needs more than `uv`.
    #[inline(always)]
    fn fill<'a>(
        &'a self,
        geometry: &Geometry,
        (ray, hit, mesh): (&Ray, &Hit, Option<&'a MeshRecord>),
        surface: &mut SurfaceInteraction,
        needs_texture: impl Fn(MaterialId) -> bool,
    ) -> HitSurface<'a> {
        surface.clear_parameters();
        surface.t = hit.t;
        match mesh.map(|mesh| MeshTriangle::new(mesh, geometry, hit.prim)) {
            None => HitSurface::Geometry(self.fill_from_shape(geometry, ray, hit, surface, needs_texture)),
            Some(face) if hit.instance != InstanceId::NONE => {
                HitSurface::Geometry(self.fill_from_instance(geometry, face, (ray, hit), surface, needs_texture))
            }
            Some(face) => {
                (surface.object, surface.material) = (face.mesh.object, face.mesh.material);
                surface.texture.uv_origin = face.mesh.uv_origins[0];
                if needs_texture(surface.material) {
                    let (uv, dpdu, dpdv) = triangle::parameters(face.corners, face.uvs(), hit.u, hit.v);
                    surface.texture.uv = uv;
                    (surface.dpdu, surface.dpdv) = (dpdu, dpdv);
                } else {
                    surface.texture.uv = triangle::uv(face.uvs(), hit.u, hit.v);
                }
                HitSurface::Triangle(face)
            }
        }
    }

    /// Sets the texture point of a hit on a triangle in world space.
    #[inline(never)]
    fn fill_texture_point(&self, hit: &Hit, mesh: Option<&MeshRecord>, surface: &mut SurfaceInteraction) {
        let Some(mesh) = mesh.filter(|_| hit.instance == InstanceId::NONE) else {
            return;
        };
        let face = MeshTriangle::new(mesh, self.geometry.accel.geometry(), hit.prim);
        let (p, n, u, v) = (surface.p, surface.ng, surface.dpdu, surface.dpdv);
        let (place, dpdu, dpdv) = match &mesh.transform {
            None => (TexturePoint::in_scene(p, n), u, v),
            Some(t) => (
                TexturePoint::new(t.point_to_local(p), t.normal_to_local(n).normalize()),
                t.vector_to_local(u),
                t.vector_to_local(v),
            ),
        };
        surface.texture = TexturePoint {
            uv: surface.texture.uv,
            uv_origin: surface.texture.uv_origin,
            dpdu,
            dpdv,
            ..place
        };
        if self.shading.reads_heights() {
            let n = surface.texture.n;
            surface.height_axis = mesh.transform.as_ref().map_or(n, |t| t.vector_to_world(n));
        }
        face.fill_attributes(hit, surface);
    }

    #[inline(always)]
    fn fill_from_shape(
        &self,
        geometry: &Geometry,
        ray: &Ray,
        hit: &Hit,
        surface: &mut SurfaceInteraction,
        needs_texture: impl Fn(MaterialId) -> bool,
    ) -> HitGeometry {
        let index = hit.prim.index() as usize - geometry.triangles.len();
        let placed = &geometry.shapes[index];
        let object = self.geometry.shape_objects[index];
        let material = self.geometry.objects[object.0 as usize].material;
        (surface.object, surface.material) = (object, material);
        // The cone of a ray that a curved mirror reflects depends on the curvature, also where no texture is read.
        let needs_texture = needs_texture(material) || self.shading.reads_footprints();
        let flat = geometry.place_on_parallelogram(placed, ray, hit.t);
        if let Some(flat) = flat.filter(|_| !needs_texture) {
            (surface.texture.uv, surface.texture.uv_origin) = (flat.uv, Vec2::ZERO);
            return HitGeometry::flat(flat.p, flat.p_error, flat.ng);
        }
        self.fill_from_any_shape(geometry, index, (ray, hit, flat), surface, needs_texture)
    }

    /// Does what [`Scene::fill_from_shape`] does after object and material are set, for all shapes and textures; `flat`
    /// is the place on a parallelogram.
    #[inline(never)]
    fn fill_from_any_shape(
        &self,
        geometry: &Geometry,
        index: usize,
        (ray, hit, flat): (&Ray, &Hit, Option<FlatPlace>),
        surface: &mut SurfaceInteraction,
        needs_texture: bool,
    ) -> HitGeometry {
        let placed = &geometry.shapes[index];
        let transform = geometry.transform(placed);
        let shape_hit = ShapeHit {
            t: hit.t,
            u: hit.u,
            v: hit.v,
        };
        let mut local = match transform {
            None => placed.shape.surface(ray, &shape_hit),
            Some(t) => placed.shape.surface(&t.ray_to_local(ray), &shape_hit),
        };
        local.uv = flat.map_or(local.uv, |flat| flat.uv);
        (surface.texture.uv, surface.texture.uv_origin) = (local.uv, Vec2::ZERO);
        if needs_texture {
            surface.texture = TexturePoint {
                curvature: placed.shape.curvature(),
                ..texture_point(&local)
            };
            if transform.is_none() {
                surface.texture.space = TextureSpace::Scene;
            }
            if let Some(color) = self.geometry.shape_colors.get(index) {
                surface.texture.vertex = VertexAttributes::of_color(*color);
            }
            let in_world = |d: Vec3| transform.map_or(d, |t| t.vector_to_world(d));
            (surface.dpdu, surface.dpdv) = (in_world(local.dpdu), in_world(local.dpdv));
            if self.shading.reads_heights() {
                surface.height_axis = in_world(local.ng);
            }
        }
        match (flat, transform) {
            (Some(flat), _) => HitGeometry::flat(flat.p, flat.p_error, flat.ng),
            (None, Some(t)) => in_world(&local, t),
            (None, None) => HitGeometry::flat(local.p, local.p_error, local.ng),
        }
    }

    fn fill_from_instance(
        &self,
        geometry: &Geometry,
        face: MeshTriangle<'_>,
        (ray, hit): (&Ray, &Hit),
        surface: &mut SurfaceInteraction,
        needs_texture: impl Fn(MaterialId) -> bool,
    ) -> HitGeometry {
        let instance = &self.geometry.instances[hit.instance.0 as usize];
        let t = &geometry.transforms[geometry.instances[hit.instance.0 as usize].transform as usize];
        (surface.object, surface.material) = (instance.object, instance.material.unwrap_or(face.mesh.material));
        let (uvs, needs_texture) = (face.uvs(), needs_texture(surface.material));
        let mut local = if needs_texture {
            triangle::surface(face.corners, uvs, hit.u, hit.v)
        } else {
            triangle::surface_without_derivatives(face.corners, uvs, hit.u, hit.v)
        };
        if uvs.is_none() && t.is_mirroring() {
            // The mirrored copy in world space has its last two corners swapped.
            local.uv = local.uv.yx();
            (local.dpdu, local.dpdv) = (local.dpdv, local.dpdu);
        }
        let mut placed_geometry = in_world(&local, t);
        placed_geometry.p_error += t.return_error(placed_geometry.p);
        let smooth = face.smooth(hit, ray.d, t);
        (placed_geometry.smooth, placed_geometry.lift) = (smooth.normal, smooth.lift);
        (surface.texture.uv, surface.texture.uv_origin) = (local.uv, face.mesh.uv_origins[0]);
        if needs_texture {
            (surface.dpdu, surface.dpdv) = (t.vector_to_world(local.dpdu), t.vector_to_world(local.dpdv));
            surface.texture = TexturePoint {
                uv_origin: face.mesh.uv_origins[0],
                ..texture_point(&local)
            };
            let places = &self.geometry.object_transforms;
            instance.fill_texture_point(surface, &placed_geometry, places);
            if self.shading.reads_heights() {
                surface.height_axis = instance.height_axis(surface.texture.n, t, places);
            }
            face.fill_attributes(hit, surface);
            let tangent = surface.tangent;
            let side = if t.is_mirroring() { -tangent.w } else { tangent.w };
            surface.tangent = t.vector_to_world(tangent.truncate()).extend(side);
        }
        placed_geometry
    }
}

impl SurfaceInteraction {
    /// Sets the place of the texture point in the scene.
    fn fill_scene_place(&mut self) {
        self.texture.scene = ScenePlace {
            p: self.p,
            n: self.ng,
            dpdu: self.dpdu,
            dpdv: self.dpdv,
        };
    }
}

#[inline(always)]
fn in_world(local: &LocalSurface, t: &Transform) -> HitGeometry {
    HitGeometry::flat(
        t.point_to_world(local.p),
        t.point_error_to_world(local.p, local.p_error),
        t.normal_to_world(local.ng).normalize(),
    )
}

fn texture_point(local: &LocalSurface) -> TexturePoint {
    TexturePoint {
        uv: local.uv,
        dpdu: local.dpdu,
        dpdv: local.dpdv,
        ..TexturePoint::new(local.p, local.ng)
    }
}

#[cfg(test)]
mod tests;
