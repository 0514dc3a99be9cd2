//! The compiled scene: flat, immutable arrays with indices between them.
//!
//! It holds no camera and no film, so it is compiled once and renders any number of frames.

use std::{
    borrow::Cow,
    ops::Range,
    sync::{Arc, OnceLock},
};

use back_faces::UsedBackFaces;

use crate::{
    bsdf::Bsdf,
    geometry::Hit,
    light::{LightSample, LightTables},
    material::{BatchKind, Material, MaterialId},
    math::{DVec3, Ray, Rgb, Transform, Vec2, Vec3, Vec4},
    texture::{TexturePoint, Textures},
};

mod albedo;
mod back_faces;
pub mod background;
pub mod builder;
pub mod contacts;
mod emitter_bounds;
pub mod emitters;
mod error;
pub mod first_hit;
mod halves;
mod hidden;
pub mod instance;
pub mod interaction;
pub mod lamps;
pub mod light_component;
pub mod light_groups;
pub mod light_links;
mod light_samples;
pub mod lights;
mod lit;
mod material_bsdfs;
pub mod mattes;
pub mod media;
mod mesh_transform;
pub mod motion;
pub mod names;
mod one_sided;
mod ray_visibility;
pub mod shading_frame;
pub mod surface_soa;
pub mod surfaces;
pub mod update;
mod vertex_attributes;

pub use back_faces::{BackFaces, MaterialBackFaces, ObjectBackFaces, two_sided_reason};
pub use background::{Background, BackgroundRadiance};
pub(crate) use builder::MeshOwner;
pub use builder::{GroupId, SceneBuilder};
pub use emitters::{EmitterId, EmitterPrim, Emitters};
pub use error::SceneBuildError;
pub use first_hit::FirstHit;
pub use halves::{SceneGeometry, SceneShading, ShadingUpdate};
pub use hidden::ObjectRole;
pub use instance::{InstanceRecord, ObjectFromGroup};
pub use interaction::SurfaceInteraction;
pub use lamps::{LampHit, Lamps};
pub use light_component::Component;
pub use light_groups::{LightGroup, LightGroups};
pub use light_links::{LightLinks, LightOrigin, LightSet, LightSetId, LitWorld};
pub use light_samples::{FamilyBlock, LightNumbers, LightSamples};
pub use lights::{LightChoice, LightFamily, LightSampleContext, LightSource, Lights, SampledLight};
pub use mattes::{Matte, MatteKind, MatteTable, Mattes, Part};
pub use media::{Media, MediumStack};
pub(crate) use mesh_transform::MeshTransform;
pub use motion::{PointMotion, SceneMotion, ScenePlaces};
pub use names::{NodeId, NodeName};
pub use ray_visibility::{RayKind, RayVisibility};
pub use surfaces::Surfaces;
pub use update::{MeshId, MeshPose, SceneUpdate, SceneUpdateError};

/// An index into the scene's objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectId(pub u32);

/// An index into the scene's lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightId(pub u32);

/// An object of the scene file.
#[derive(Clone, Debug)]
pub struct Object {
    pub name: String,
    /// The file that its geometry comes from, as the scene file names it.
    pub asset: Option<String>,
    /// The material of its shape; the parts of a mesh have their own.
    pub material: MaterialId,
    /// The rays that meet it.
    pub rays: RayVisibility,
    pub role: ObjectRole,
    /// The lights that light it.
    pub lit_by: LightSetId,
    /// `None` where its materials say what its backs are.
    pub back_faces: Option<ObjectBackFaces>,
    /// The object of which it is a part with settings of its own, and whose name it has.
    pub part_of: Option<ObjectId>,
}

/// A range of triangles with the normals and texture coordinates of their vertices.
///
/// An instanced mesh is in the space of its group, and its objects are those of its instances.
#[derive(Clone, Debug)]
pub struct MeshRecord {
    pub object: ObjectId,
    pub material: MaterialId,
    /// The object's transform, if it has one: textures are evaluated in the object's own space.
    pub transform: Option<Transform>,
    /// The node of its file that it belongs to.
    pub node: Option<NodeId>,
    /// The number from 0 of the copy of a mesh that it is, in a group from that of the instance; `None` where there is one only.
    pub copy: Option<u32>,
    /// Indices into the geometry's triangles.
    pub triangles: Range<u32>,
    /// Indices into the geometry's vertices.
    pub vertices: Range<u32>,
    /// Unit shading normals in world space, per vertex; 0 for the normal of the face. Empty for flat shading.
    pub normals: Vec<Vec3>,
    /// Per vertex; empty where the file has none.
    pub uvs: Vec<Vec2>,
    pub second_uvs: Vec<Vec2>,
    /// See [`Mesh::uv_origins`](crate::shape::mesh::Mesh::uv_origins).
    pub uv_origins: [Vec2; 2],
    /// Linear colours with opacity, per vertex; empty where the file has none.
    pub colors: Vec<Vec4>,
    /// Per vertex, in world space; empty if they are derived from the texture coordinates.
    pub tangents: Vec<Vec4>,
}

/// A compiled scene: all inputs of a frame except the camera.
///
/// Single precision is coarse far from the world's origin, so all positions are relative to the origin of the scene. Cameras
/// are in world space.
///
/// Its two halves change at different times, see [`SceneGeometry`] and [`SceneShading`]. The lights are made of both and
/// are rebuilt when one of them changes.
pub struct Scene {
    /// The scene's origin in world space, in m: 0 unless the scene is far away. Single precision represents it exactly.
    pub origin: DVec3,
    pub geometry: Arc<SceneGeometry>,
    pub shading: Arc<SceneShading>,
    pub lights: Lights,
    hides: bool,
    used_backs: UsedBackFaces,
    samples_lights_only: bool,
    /// Whether some lights do not light all objects.
    has_links: bool,
    /// Whether that is so, or the scene has shadow catchers.
    selects_lights: bool,
    /// See [`Scene::mattes`].
    mattes: OnceLock<Mattes>,
}

impl Scene {
    /// Combines two halves and builds the lights.
    fn new(origin: DVec3, geometry: Arc<SceneGeometry>, shading: Arc<SceneShading>) -> Self {
        let lights = Lights::new(&geometry, &shading);
        let (hides, samples_lights_only) =
            ray_visibility::of_objects(geometry.objects.iter().map(|o| o.rays), lights.emitters().count() > 0);
        let has_links = geometry
            .objects
            .iter()
            .any(|object| object.lit_by != LightSetId::default());
        let is_catcher = |object: &Object| object.role == ObjectRole::ShadowCatcher;
        let selects_lights = has_links || geometry.objects.iter().any(is_catcher);
        Self {
            origin,
            lights,
            hides,
            used_backs: UsedBackFaces::new(geometry.objects.iter().map(|o| o.back_faces), &shading.back_faces),
            samples_lights_only,
            has_links,
            selects_lights,
            geometry,
            shading,
            mattes: OnceLock::new(),
        }
    }

    /// Returns the scene with another shading. It shares the geometry, so no acceleration structure is built; the lights are
    /// rebuilt.
    ///
    /// # Errors
    /// `shading` has fewer materials than the scene, so that a [`MaterialId`] of the geometry has none.
    pub fn with_shading(&self, shading: Arc<SceneShading>) -> Result<Self, SceneUpdateError> {
        let [found, expected] = [&shading, &self.shading].map(|shading| shading.materials.len());
        if found < expected {
            return Err(SceneUpdateError::TooFewMaterials { found, expected });
        }
        Ok(Self::new(self.origin, Arc::clone(&self.geometry), shading))
    }

    /// The textures and bitmaps that materials refer to.
    #[inline]
    pub fn textures(&self) -> Textures<'_> {
        self.shading.textures()
    }

    /// Whether a texture is filtered over the footprint of a ray, so that rays need cones.
    pub fn reads_footprints(&self) -> bool {
        self.shading.reads_footprints()
    }

    #[inline]
    pub fn material(&self, id: MaterialId) -> &Material {
        self.shading.material(id)
    }

    /// The BSDF of a material at a point of a surface.
    #[inline]
    pub fn bsdf(&self, id: MaterialId, at: &TexturePoint) -> Cow<'_, Bsdf> {
        self.shading.bsdfs.at(id, self.material(id), &self.textures(), at)
    }

    /// The kind of block that shades surfaces of a material.
    #[inline]
    pub fn batch_kind(&self, id: MaterialId) -> BatchKind {
        self.shading.bsdfs.batch_kind(id)
    }

    /// Whether any material is shaded by this kind of block.
    #[inline]
    pub fn has_batch_kind(&self, kind: BatchKind) -> bool {
        self.shading.bsdfs.has_batch_kind(kind)
    }

    /// The radiance of the background in the unit direction `w`, in W m^-2 sr^-1.
    #[inline]
    pub fn background_radiance(&self, w: Vec3) -> Rgb {
        self.shading.background.radiance.radiance(w)
    }

    /// The group of `light`. Called rarely.
    #[cold]
    pub fn group_of(&self, light: LightId) -> LightGroup {
        match self.origin_of(light) {
            LightOrigin::Light(light) => self.shading.light_groups.of_analytic(light),
            LightOrigin::Background => self.shading.light_groups.of_background(),
            LightOrigin::Object(object) => self.shading.light_groups.of_object(object),
        }
    }

    /// The tables that an analytic light refers to.
    #[inline]
    pub fn light_tables(&self, light: LightId) -> LightTables<'_> {
        LightTables {
            picture: self.lights.picture(light),
            ..self.shading.light_tables()
        }
    }

    /// Samples a direction from which `light` illuminates `from`, by two uniform numbers in `[0, 1)`; `None` if no light
    /// arrives.
    #[inline]
    pub fn sample_light(&self, light: LightId, from: Vec3, u: Vec2) -> Option<LightSample> {
        match self.lights.source(light) {
            LightSource::Analytic(own) => own.sample(&self.light_tables(light), from, u),
            LightSource::Emitter(emitter) => self.sample_emitter(emitter, from, u),
            LightSource::Background => self.shading.background.radiance.sample(self.geometry.accel.simd(), u),
        }
    }

    /// The density, in sr^-1, with which [`Lights::choose`] and [`Scene::sample_light`] at `at` sample the direction `w` of
    /// the background. 0 if the background is not sampled.
    #[inline]
    pub fn pdf_background(&self, at: &LightSampleContext, w: Vec3) -> f32 {
        let of_light = |light| self.shading.background.radiance.pdf(w) * self.lights.pmf(at, light);
        self.lights.background().map_or(0.0, of_light)
    }

    /// The suns whose disk contains the unit direction `w`, each with its radiance, in W m^-2 sr^-1, and the density with
    /// which light sampling at `at` samples `w`, in sr^-1. [`Scene::background_radiance`] does not include them.
    #[inline]
    pub fn suns(&self, at: &LightSampleContext, w: Vec3) -> impl Iterator<Item = (LightId, Rgb, f32)> {
        self.lights
            .suns(w)
            .map(|(light, l, pdf)| (light, l, pdf * self.lights.pmf(at, light)))
    }

    /// The lights with a surface that a ray of unit direction meets before `end`, for a ray that comes straight from the camera or
    /// for another one. A light that lies in a surface at its end is in front of that surface, as it is for shadow rays, and so not
    /// behind one that the ray has passed.
    pub fn lamps_along(&self, ray: &Ray, end: f32, is_from_camera: bool) -> impl Iterator<Item = LampHit> {
        let behind = |t: f32| t + (ray.at(t).abs().max_element() + t) * 1e-6;
        let ray = Ray {
            tmin: if ray.tmin > 0.0 { behind(ray.tmin) } else { ray.tmin },
            tmax: if end.is_finite() { behind(end) } else { end },
            ..*ray
        };
        let tables = |light| self.light_tables(light);
        self.lights
            .lamps()
            .along(self.lights.all(), tables, ray, is_from_camera)
    }

    /// The density, in sr^-1, with which light sampling at `at` samples the unit direction `w`, along which a ray from `at`
    /// has this hit. 0 if the surface is no light.
    #[inline]
    pub fn pdf_hit(&self, at: &LightSampleContext, w: Vec3, hit: &Hit) -> f32 {
        self.pdf_emitter(at.p, w, hit).map_or(0.0, |(emitter, pdf)| {
            pdf * self.lights.pmf(at, self.lights.of_emitter(emitter))
        })
    }

    /// Whether a BSDF has more than one lobe, so that a random number selects one.
    pub fn has_lobes(&self) -> bool {
        self.shading.materials.iter().any(Material::has_lobes)
    }

    /// Whether all materials are opaque everywhere.
    pub fn is_opaque(&self) -> bool {
        self.shading.materials.iter().all(Material::is_opaque)
    }

    /// The opacity of the surface at a hit, from 0 to 1.
    pub fn opacity(&self, ray: &Ray, hit: &Hit) -> f32 {
        let material = self.material(self.material_of(hit));
        if material.is_opaque() {
            return 1.0;
        }
        material.opacity(&self.textures(), &self.surface(ray, hit).texture)
    }

    /// The material at a hit.
    pub fn material_of(&self, hit: &Hit) -> MaterialId {
        let Some(mesh) = self.geometry.mesh_of(hit.prim) else {
            let triangles = self.geometry.accel.geometry().triangles.len() as u32;
            return self.geometry.shape_material(hit.prim.index() - triangles);
        };
        let instance = self.geometry.instances.get(hit.instance.0 as usize);
        instance.and_then(|i| i.material).unwrap_or(mesh.material)
    }
}
