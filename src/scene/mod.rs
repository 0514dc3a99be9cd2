//! The compiled scene: flat, immutable arrays that name each other by number.
//!
//! It holds no camera and no film, so it is compiled once and renders any number of frames.

use std::ops::Range;

use crate::{
    accel::{Accelerator, Hit, Instance, PrimRef},
    light::LightSample,
    material::{Material, MaterialId},
    math::{Ray, Rgb, Transform, Vec2, Vec3},
    texture::{Bitmap, Texture, Textures},
};

pub mod builder;
pub mod instance;
pub mod interaction;
pub mod lights;
pub mod motion;

pub use builder::{Builder, GroupId};
pub use instance::{InstanceRecord, ObjectFromGroup};
pub use interaction::Surface;
pub use lights::{Choice, Lights, Receiver};
pub use motion::{MeshId, Motion, MotionError, Pose};

/// An index into the scene's objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectId(pub u32);

/// An index into the scene's lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightId(pub u32);

/// What a scene file calls an object.
#[derive(Clone, Debug)]
pub struct Object {
    pub name: String,
    /// Of its shape; the parts of a mesh have their own.
    pub material: MaterialId,
}

/// What is seen where a ray meets nothing.
#[derive(Clone, Copy, Debug)]
pub struct Background {
    pub radiance: Rgb,
    /// Whether camera rays see it; where they do not, RGB and A are 0.
    pub visible: bool,
}

impl Background {
    /// One radiance everywhere, seen by all.
    pub fn new(radiance: Rgb) -> Self {
        Self {
            radiance,
            visible: true,
        }
    }
}

/// A run of triangles with what their corners carry beside positions.
///
/// That of an instanced mesh is in the space of its group, and its instances say which objects they are.
#[derive(Clone, Debug)]
pub struct MeshRecord {
    pub object: ObjectId,
    pub material: MaterialId,
    /// The object's, where it has one: textures stick to the object's own space.
    pub transform: Option<Transform>,
    /// Which of the geometry's triangles.
    pub triangles: Range<u32>,
    /// Which of the geometry's vertices its corners are.
    pub vertices: Range<u32>,
    /// Per vertex, unit, in world space, 0 where only the face knows; empty for flat shading.
    pub normals: Vec<Vec3>,
    /// Per vertex; empty where the file has none.
    pub uvs: Vec<Vec2>,
}

/// Everything that a frame is rendered from, but the camera.
pub struct Scene {
    pub accel: Box<dyn Accelerator>,
    pub objects: Vec<Object>,
    /// In the order of their triangles, which they cover without gaps.
    pub meshes: Vec<MeshRecord>,
    /// What each of the geometry's instances is.
    pub instances: Vec<InstanceRecord>,
    /// What [`ObjectFromGroup::At`] names.
    pub object_places: Vec<Transform>,
    /// Object of each of the geometry's shapes.
    pub shape_objects: Vec<ObjectId>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub bitmaps: Vec<Bitmap>,
    pub lights: Lights,
    pub background: Background,
}

impl Scene {
    /// The tables that material colours are looked up in.
    #[inline]
    pub fn textures(&self) -> Textures<'_> {
        Textures {
            textures: &self.textures,
            bitmaps: &self.bitmaps,
        }
    }

    /// Whether a texture looks at more than points, so that rays should know how wide they are.
    pub fn reads_footprints(&self) -> bool {
        self.bitmaps.iter().any(|b| !b.levels.is_empty())
    }

    #[inline]
    pub fn material(&self, id: MaterialId) -> &Material {
        &self.materials[id.0 as usize]
    }

    /// The radiance that arrives where a ray along the unit direction `w` meets nothing, in W m^-2 sr^-1.
    #[inline]
    pub fn escape(&self, _w: Vec3) -> Rgb {
        self.background.radiance
    }

    /// A direction from which `light` shines on `from`, by two uniform numbers in `[0, 1)`; `None` where it does not.
    #[inline]
    pub fn sample_light(&self, light: LightId, from: Vec3, u: Vec2) -> Option<LightSample> {
        self.lights.sample(light, from, u)
    }

    /// The density, in sr^-1, with which [`Lights::choose`] and [`Scene::sample_light`] at `at` find the direction `w` towards what
    /// lies behind everything. 0 where it is not a light that is asked for.
    #[inline]
    pub fn pdf_escape(&self, _at: &Receiver, _w: Vec3) -> f32 {
        0.0
    }

    /// The same for the unit direction `w` towards the surface that a ray from `at` met there with `hit`. 0 where no light is.
    #[inline]
    pub fn pdf_hit(&self, _at: &Receiver, _w: Vec3, _hit: &Hit, _surface: &Surface) -> f32 {
        0.0
    }

    /// Whether everything in it is opaque everywhere.
    pub fn is_opaque(&self) -> bool {
        self.materials.iter().all(Material::is_opaque)
    }

    /// The part of the light that is stopped where `ray` meets something, from 0 to 1.
    pub fn opacity(&self, ray: &Ray, hit: &Hit) -> f32 {
        let material = self.material(self.material_of(hit));
        if material.is_opaque() {
            return 1.0;
        }
        material.opacity(&self.textures(), &self.surface(ray, hit).texture)
    }

    /// The material of what was hit.
    fn material_of(&self, hit: &Hit) -> MaterialId {
        let triangles = self.accel.geometry().triangles.len();
        match (hit.prim.index() as usize).checked_sub(triangles) {
            Some(shape) => self.objects[self.shape_objects[shape].0 as usize].material,
            None => {
                let instead = self.instances.get(hit.instance.0 as usize).and_then(|i| i.material);
                instead.unwrap_or_else(|| self.mesh_of(hit.prim).material)
            }
        }
    }

    /// The mesh that triangle `prim` is of.
    fn mesh_of(&self, prim: PrimRef) -> &MeshRecord {
        let after = self.meshes.partition_point(|m| m.triangles.start <= prim.index());
        &self.meshes[after - 1]
    }

    /// All that shading needs to know of a hit.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        let geometry = self.accel.geometry();
        match geometry.shape(hit.prim) {
            Some(placed) => {
                let object = self.shape_objects[hit.prim.index() as usize - geometry.triangles.len()];
                let material = self.objects[object.0 as usize].material;
                Surface::of_shape(placed, geometry.transform(placed), ray, hit, object, material)
            }
            None => {
                let index = hit.prim.index() as usize;
                let place = geometry.place(hit.instance);
                let mut surface = Surface::of_triangle(
                    geometry.corners(index),
                    geometry.triangles[index],
                    self.mesh_of(hit.prim),
                    place,
                    ray,
                    hit,
                );
                if hit.instance != Instance::NONE {
                    self.instances[hit.instance.0 as usize].claim(&mut surface, &self.object_places);
                }
                surface
            }
        }
    }
}
