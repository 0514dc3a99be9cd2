//! Emitters: the primitives of the geometry that emit, and light sampling on them.
//!
//! Emitters are numbered: first the shapes, in the order of the geometry, then the triangles of
//! each mesh. Nothing is stored per triangle; a mesh is a range of numbers.
//!
//! A triangle must be a light at one place, so emitting meshes are baked into world space. Emitting instances (in scenes built
//! in code) and unbounded emitters are not sampled: only BSDF sampling finds them.

use super::{MeshRecord, Scene, SceneGeometry, SceneShading};
use crate::{
    geometry::{Geometry, Hit, PrimId},
    light::{AreaBlock, LightSample, area},
    material::{Emission, EmissionReach, Material, MaterialId},
    math::{Rgb, Sidedness, Transform, Vec2, Vec3},
    shape::{ShapeHit, spherical, triangle},
    texture::{Color, ScenePlace, TexturePoint},
};

/// The number of an emitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EmitterId(pub u32);

/// The primitives that emit.
#[derive(Clone, Debug, Default)]
pub struct Emitters {
    /// The indices of emitting shapes in the geometry, in ascending order.
    pub(super) shapes: Vec<u32>,
    /// In ascending order of the meshes.
    pub(super) mesh_emitters: Vec<MeshEmitters>,
    /// The emission of each of `shapes`, if it is constant over the surface.
    uniform: Vec<Option<UniformEmission>>,
    count: u32,
}

/// An emission that is constant over a surface.
#[derive(Clone, Copy, Debug)]
struct UniformEmission {
    /// In W m^-2 sr^-1.
    radiance: Rgb,
    sidedness: Sidedness,
}

impl UniformEmission {
    fn of(material: &Material) -> Option<Self> {
        let Emission {
            radiance: Color::Constant(radiance),
            scale,
            sidedness,
            reach: EmissionReach::Everything,
        } = material.emission().filter(|_| material.is_opaque())?
        else {
            return None;
        };
        Some(Self {
            radiance: radiance * scale,
            sidedness,
        })
    }

    /// The radiance of the front if `front_cos > 0`, else of the back; `None` if that side does not emit.
    #[inline]
    fn towards(&self, front_cos: f32) -> Option<Rgb> {
        (front_cos > 0.0 || self.sidedness == Sidedness::Both).then_some(self.radiance)
    }
}

/// The triangles of an emitting mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshEmitters {
    /// An index into the scene's meshes.
    pub mesh: u32,
    first_triangle: u32,
    triangles: u32,
    /// The emitter number of its first triangle.
    first: u32,
    uniform: Option<UniformEmission>,
}

impl MeshEmitters {
    /// The triangle of an emitter of this mesh.
    fn triangle(&self, id: EmitterId) -> u32 {
        self.first_triangle + id.0 - self.first
    }
}

/// What a block of area lights holds of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HeldLight {
    Nothing,
    /// Its points; the radiance of each is [`Scene::radiance_in_block`].
    Points,
    Whole,
}

/// The primitive of an emitter.
#[derive(Clone, Copy, Debug)]
pub enum EmitterPrim<'a> {
    /// An index into the geometry's shapes.
    Shape(u32),
    /// An index into the geometry's triangles, and its mesh.
    Triangle(u32, &'a MeshRecord),
}

impl Emitters {
    /// Collects the emitters of a scene. Unbounded surfaces are left out.
    pub fn collect(scene: &SceneGeometry, shading: &SceneShading) -> Self {
        let geometry = scene.accel.geometry();
        let is_lamp = |e: Emission| e.reach == EmissionReach::Everything && !is_dark(&e);
        let emits = |material: MaterialId| shading.material(material).emission().is_some_and(is_lamp);
        let shapes: Vec<u32> = (0..geometry.shapes.len() as u32)
            .filter(|&i| emits(scene.shape_material(i)) && geometry.shapes[i as usize].shape.bounds().is_finite())
            .collect();
        let uniform = shapes
            .iter()
            .map(|&i| UniformEmission::of(shading.material(scene.shape_material(i))));
        let uniform = uniform.collect();
        let mut count = shapes.len() as u32;
        let mut mesh_emitters = Vec::new();
        let is_instanced = |m: &MeshRecord| geometry.groups.iter().any(|g| g.triangles.contains(&m.triangles.start));
        let shining = (0..).zip(&scene.meshes).filter(|(_, m)| emits(m.material));
        for (mesh, record) in shining.filter(|(_, m)| !is_instanced(m)) {
            let triangles = record.triangles.end - record.triangles.start;
            mesh_emitters.push(MeshEmitters {
                triangles,
                mesh,
                first_triangle: record.triangles.start,
                first: count,
                uniform: UniformEmission::of(shading.material(record.material)),
            });
            count += triangles;
        }
        Self {
            shapes,
            mesh_emitters,
            uniform,
            count,
        }
    }

    pub fn count(&self) -> u32 {
        self.count
    }

    /// The emitter of the emitting primitive `prim`; `None` if it is not sampled.
    fn of_prim(&self, geometry: &Geometry, prim: PrimId) -> Option<EmitterId> {
        let index = prim.index();
        match index.checked_sub(geometry.triangles.len() as u32) {
            Some(shape) => self.shapes.binary_search(&shape).ok().map(|i| EmitterId(i as u32)),
            None => {
                let after = self.mesh_emitters.partition_point(|r| r.first_triangle <= index);
                let run = self.mesh_emitters[..after].last()?;
                let at = index - run.first_triangle;
                (at < run.triangles).then_some(EmitterId(run.first + at))
            }
        }
    }

    /// The primitive of emitter `id`; `meshes` are the scene's.
    pub fn prim<'a>(&self, id: EmitterId, meshes: &'a [MeshRecord]) -> EmitterPrim<'a> {
        if let Some(shape) = self.shapes.get(id.0 as usize) {
            return EmitterPrim::Shape(*shape);
        }
        let run = self.run(id);
        EmitterPrim::Triangle(run.triangle(id), &meshes[run.mesh as usize])
    }

    /// The mesh of an emitter that is a triangle.
    #[inline]
    fn run(&self, id: EmitterId) -> &MeshEmitters {
        &self.mesh_emitters[self.mesh_emitters.partition_point(|r| r.first <= id.0) - 1]
    }
}

impl Scene {
    /// Samples light from an emitter, see [`Scene::sample_light`].
    pub(super) fn sample_emitter(&self, emitter: EmitterId, from: Vec3, u: Vec2) -> Option<LightSample> {
        let geometry = self.geometry.accel.geometry();
        let (sample, material, at) = match self.lights.emitters().prim(emitter, &self.geometry.meshes) {
            EmitterPrim::Shape(index) => {
                let placed = &geometry.shapes[index as usize];
                let transform = geometry.transform(placed);
                let (sample, p) = area::sample_shape(&placed.shape, transform, from, u)?;
                if let Some(emission) = &self.lights.emitters().uniform[emitter.0 as usize] {
                    return sample.light(from, emission.towards(sample.front_cos(from))?);
                }
                let material = self.material(self.geometry.shape_material(index));
                let from_local = transform.map_or(from, |t| t.point_to_local(from));
                let surface = area::surface_at(&placed.shape, from_local, p)?;
                let at = TexturePoint {
                    uv: surface.uv,
                    ..shape_point(transform, p, surface.ng)
                };
                (sample, material, at)
            }
            EmitterPrim::Triangle(index, mesh) => {
                let sample = area::sample_triangle(geometry.corners(index as usize), from, u)?;
                let material = self.material(mesh.material);
                let at = if is_uniform(material) {
                    uniform_point()
                } else {
                    self.point_of_emitter(mesh, index, sample.p, sample.ng)
                };
                (sample, material, at)
            }
        };
        let li = self.sampled_radiance(material, &at, sample.front_cos(from));
        if li.is_black() {
            return None;
        }
        sample.light(from, li)
    }

    /// The radiance of a sampled point of an emitter, in W m^-2 sr^-1, on the front if `front_cos > 0` and else on the back.
    fn sampled_radiance(&self, material: &Material, at: &TexturePoint, front_cos: f32) -> Rgb {
        let textures = self.textures();
        let emitted = material
            .emission()
            .map(|emission| emission.radiance(&textures, at, front_cos));
        let emitted = emitted.unwrap_or(Rgb::BLACK);
        if material.is_opaque() {
            return emitted;
        }
        // Opacity scales emission.
        emitted * material.opacity(&textures, at)
    }

    /// The texture point of the place `p` on a triangle of an emitting mesh.
    fn point_of_emitter(&self, mesh: &MeshRecord, triangle: u32, p: Vec3, ng: Vec3) -> TexturePoint {
        let geometry = self.geometry.accel.geometry();
        let place = weights(geometry.corners(triangle as usize), p);
        texture_point(mesh, geometry.triangles[triangle as usize], (p, ng), place)
    }

    /// The radiance of the sampled point `p` of an emitter of which a block holds the points, see [`Scene::set_emitter`].
    pub(super) fn radiance_in_block(&self, emitter: EmitterId, (p, ng): (Vec3, Vec3), front_cos: f32) -> Rgb {
        match self.lights.emitters().prim(emitter, &self.geometry.meshes) {
            EmitterPrim::Shape(_) => Rgb::BLACK,
            EmitterPrim::Triangle(index, mesh) => {
                let at = self.point_of_emitter(mesh, index, p, ng);
                self.sampled_radiance(self.material(mesh.material), &at, front_cos)
            }
        }
    }

    /// Sets the area light of a lane. Returns what the block holds of it.
    pub(super) fn set_emitter(&self, emitter: EmitterId, lane: usize, block: &mut AreaBlock) -> HeldLight {
        let (emitters, geometry) = (self.lights.emitters(), self.geometry.accel.geometry());
        let (emission, held) = match emitters.shapes.get(emitter.0 as usize) {
            Some(shape) => {
                let placed = &geometry.shapes[*shape as usize];
                let emission = emitters.uniform[emitter.0 as usize];
                let is_free = emission.is_some() && placed.transform.is_none();
                if !(is_free && placed.shape.put_in_block(lane, &mut block.points)) {
                    return HeldLight::Nothing;
                }
                (emission, HeldLight::Whole)
            }
            None => {
                let run = emitters.run(emitter);
                let corners = geometry.corners(run.triangle(emitter) as usize);
                block.points.set_triangle(lane, &corners);
                let held = run.uniform.map_or(HeldLight::Points, |_| HeldLight::Whole);
                (run.uniform, held)
            }
        };
        // Both sides of what is not constant, whose radiance depends on the side.
        let varying = UniformEmission {
            radiance: Rgb::WHITE,
            sidedness: Sidedness::Both,
        };
        let UniformEmission { radiance, sidedness } = emission.unwrap_or(varying);
        block.set_emission(lane, radiance, sidedness);
        held
    }

    /// The emitter at `hit`, which a ray from `from` along the unit direction `w` found, and the density of
    /// [`Scene::sample_emitter`] for `w`, in sr^-1; `None` if the hit is no emitter.
    pub(super) fn pdf_emitter(&self, from: Vec3, w: Vec3, hit: &Hit) -> Option<(EmitterId, f32)> {
        let geometry = self.geometry.accel.geometry();
        let emitter = self.lights.emitters().of_prim(geometry, hit.prim)?;
        let pdf = match geometry.shape(hit.prim) {
            Some(placed) => {
                let Hit { t, u, v, .. } = *hit;
                let hit = ShapeHit { t, u, v };
                area::pdf_shape(&placed.shape, geometry.transform(placed), from, w, &hit)
            }
            None => spherical::pdf(geometry.corners(hit.prim.index() as usize), from, hit.u, hit.v),
        };
        Some((emitter, pdf))
    }
}

/// A texture point for colours that do not vary.
pub(super) fn uniform_point() -> TexturePoint {
    TexturePoint::new(Vec3::ZERO, Vec3::Y)
}

pub(super) fn is_constant_emission(emission: &Emission) -> bool {
    emission.radiance.is_constant()
}

/// Whether its emission is constant over the surface.
fn is_uniform(material: &Material) -> bool {
    material.is_opaque() && material.emission().is_none_or(|e| is_constant_emission(&e))
}

/// Whether it is known to be black everywhere.
fn is_dark(emission: &Emission) -> bool {
    let black = match emission.radiance {
        Color::Constant(c) | Color::Tinted(_, c) => c.is_black(),
        Color::Texture(_) => false,
    };
    black || emission.scale == 0.0
}

/// Returns the texture point of a shape with this transform; `p` and `n` are in the shape's own space.
pub(super) fn shape_point(transform: Option<&Transform>, p: Vec3, n: Vec3) -> TexturePoint {
    match transform {
        None => TexturePoint::in_scene(p, n),
        Some(t) => TexturePoint {
            scene: ScenePlace {
                p: t.point_to_world(p),
                n: t.normal_to_world(n).normalize(),
                ..TexturePoint::new(p, n).scene
            },
            ..TexturePoint::new(p, n)
        },
    }
}

/// Returns the texture point of the place `p` with the normal `ng` on a triangle of a mesh, at the weights `u` and `v` of the last
/// two of its corners, which are these `vertices`.
pub(super) fn texture_point(
    mesh: &MeshRecord,
    vertices: [u32; 3],
    (p, ng): (Vec3, Vec3),
    [u, v]: [f32; 2],
) -> TexturePoint {
    let place = match &mesh.transform {
        None => TexturePoint::in_scene(p, ng),
        Some(t) => TexturePoint {
            scene: TexturePoint::in_scene(p, ng).scene,
            ..TexturePoint::new(t.point_to_local(p), t.normal_to_local(ng).normalize())
        },
    };
    let own = vertices.map(|v| (v - mesh.vertices.start) as usize);
    let uvs = (!mesh.uvs.is_empty()).then(|| own.map(|i| mesh.uvs[i]));
    let mut at = TexturePoint {
        uv: triangle::uv(uvs, u, v),
        uv_origin: mesh.uv_origins[0],
        ..place
    };
    if mesh.has_attributes() {
        at.vertex = mesh.attributes(own, u, v);
    }
    at
}

/// The weights of the last two corners of a triangle at its point `p`, which is rounded; 0 where it has no area.
fn weights([a, b, c]: [Vec3; 3], p: Vec3) -> [f32; 2] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let n = ab.cross(ac);
    let area = n.length_squared();
    if area == 0.0 {
        return [0.0; 2];
    }
    // None where a coordinate is too large for the products.
    let share = |x: f32, most: f32| if x > 0.0 { x.min(most) } else { 0.0 };
    let u = share(ap.cross(ac).dot(n) / area, 1.0);
    let v = share(ab.cross(ap).dot(n) / area, 1.0 - u);
    [u, v]
}
