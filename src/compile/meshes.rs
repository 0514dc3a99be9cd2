//! Models from files to triangles in world space, and to instances where a mesh is seen many times.

use std::{collections::HashMap, path::PathBuf, sync::Arc};

use glam::DAffine3;
use rayon::prelude::*;

use super::{
    place::{Place, has_area},
    sharing::{Sharing, Units},
};
use crate::{
    accel::{Geometry, Group, MOST_MAGNIFICATION, PlacedGroup},
    assets::{
        AssetError, Store,
        model::{Model, Part, Surfacing},
        store::ImageRequest,
    },
    material::{Material, MaterialId, matte::Matte},
    math::Transform,
    scene::{InstanceRecord, MeshRecord, Object, ObjectFromGroup, ObjectId},
    texture::{
        BitmapId, Color, Mapping, Pattern, StTransform, Texture, TextureId, bitmap::ColorSpace, image::ImagePattern,
    },
};

/// The most triangles that a scene stores.
const MOST_TRIANGLES: u64 = 1 << 27;

/// Below so many items a task is not worth another thread.
pub(super) const MIN_LEN: usize = 16384;

/// An object whose geometry is in a file.
#[derive(Clone, Debug)]
pub(super) struct PlacedModel {
    pub object: ObjectId,
    pub file: PathBuf,
    /// Instead of the model's own.
    pub material: Option<MaterialId>,
    pub transform: Option<Transform>,
}

impl PlacedModel {
    fn world_from_model(&self) -> DAffine3 {
        self.transform.map_or(DAffine3::IDENTITY, |t| t.widened())
    }
}

/// The arrays of a scene that models add to.
pub(super) struct Parts {
    pub geometry: Geometry,
    pub objects: Vec<Object>,
    pub meshes: Vec<MeshRecord>,
    pub instances: Vec<InstanceRecord>,
    pub object_places: Vec<Transform>,
    pub materials: Vec<Material>,
    /// What scene files and models call them.
    pub names: Vec<String>,
    pub textures: Vec<Texture>,
    pub images: Vec<ImageRequest>,
}

/// What is known of a model that objects are of.
#[derive(Default)]
struct Uses {
    objects: u64,
    /// The number of its first material, where it brings its own.
    first_material: Option<u32>,
}

impl Uses {
    fn material_of(&self, part: &Part, instead: Option<MaterialId>) -> MaterialId {
        let own = self.first_material.unwrap_or(0) + part.material as u32;
        instead.unwrap_or(MaterialId(own))
    }
}

/// How a model is added, and which groups were made of it so far.
struct Plan {
    units: Units,
    /// The parts of [`Units::rest`], where they are not all.
    rest_parts: Option<Vec<Part>>,
    shares_rest: bool,
    rest: Option<u32>,
    shared: Vec<Option<u32>>,
    /// By the first part of a copy: its place in the model, in [`Parts::object_places`].
    places: HashMap<usize, u32>,
}

impl Plan {
    fn new(model: &Model, uses: &Uses, sharing: Sharing) -> Self {
        let units = Units::new(model, uses.objects, sharing);
        let rest = &units.rest;
        let parts = || rest.iter().map(|&i| model.parts[i].clone()).collect();
        Self {
            rest_parts: (rest.len() < model.parts.len()).then(parts),
            shares_rest: sharing.wants(units.triangles, uses.objects),
            rest: None,
            shared: vec![None; units.shared.len()],
            places: HashMap::new(),
            units,
        }
    }

    /// How many triangles the next object adds.
    fn triangles(&self) -> u64 {
        let rest = if self.shares_rest && self.rest.is_some() {
            0
        } else {
            self.units.triangles
        };
        let shared = self.units.shared.iter().zip(&self.shared);
        rest + shared
            .filter(|(_, group)| group.is_none())
            .map(|(unit, _)| unit.triangles)
            .sum::<u64>()
    }
}

/// Parts of a model that are added for an object.
struct Added<'a> {
    placed: &'a PlacedModel,
    model: &'a Model,
    uses: &'a Uses,
    /// Whose meshes' places are relative to `world_from_group`.
    parts: &'a [Part],
    world_from_group: DAffine3,
    object_from_group: ObjectFromGroup,
}

/// The space that triangles are added in.
#[derive(Clone, Copy)]
enum Space {
    World,
    Group,
}

impl Parts {
    /// Loads every file once and places its model as often as it is named.
    pub fn place(&mut self, placed: &[PlacedModel], store: &Store, sharing: Sharing) -> Result<(), Vec<AssetError>> {
        let files: Vec<PathBuf> = placed.iter().map(|p| p.file.clone()).collect();
        let models = store.models(&files)?;
        let mut uses: HashMap<*const Model, Uses> = HashMap::new();
        for (placed, model) in placed.iter().zip(&models) {
            let uses = uses.entry(Arc::as_ptr(model)).or_default();
            uses.objects += 1;
            if placed.material.is_none() && uses.first_material.is_none() {
                // Objects of one model share its materials.
                uses.first_material = Some(self.add_looks(model));
            }
        }
        let mut errors = Vec::new();
        let mut plans: HashMap<*const Model, Plan> = HashMap::new();
        for (placed, model) in placed.iter().zip(&models) {
            let at = Arc::as_ptr(model);
            let plan = plans.entry(at).or_insert_with(|| Plan::new(model, &uses[&at], sharing));
            match self.add(placed, model, &uses[&at], plan) {
                Ok(0) => {}
                Ok(dropped) => {
                    let plural = if dropped == 1 { "triangle" } else { "triangles" };
                    tracing::warn!("{dropped} {plural} without area left out: {}", placed.file.display());
                }
                Err(e) => errors.push(e),
            }
        }
        if errors.is_empty() { Ok(()) } else { Err(errors) }
    }

    /// Adds an object; returns how many triangles were left out because they have no area.
    fn add(&mut self, placed: &PlacedModel, model: &Model, uses: &Uses, plan: &mut Plan) -> Result<usize, AssetError> {
        let Some(first) = model.parts.first() else {
            let path = placed.file.clone();
            return Err(AssetError::NoTriangles { path });
        };
        self.check_room(plan.triangles(), 0, placed)?;
        self.objects[placed.object.0 as usize].material = uses.material_of(first, placed.material);
        let rest = Added {
            placed,
            model,
            uses,
            parts: plan.rest_parts.as_ref().unwrap_or(&model.parts),
            world_from_group: placed.world_from_model(),
            object_from_group: ObjectFromGroup::Identity,
        };
        let mut dropped = 0;
        if !rest.parts.is_empty() {
            dropped += self.copy(&rest, plan.shares_rest.then_some(&mut plan.rest))?;
        }
        for (unit, group) in plan.units.shared.iter().zip(&mut plan.shared) {
            for run in &unit.copies {
                let model_from_group = model.parts[run.start].model_from_mesh;
                let here = |part: &Part| Part {
                    model_from_mesh: DAffine3::IDENTITY,
                    ..part.clone()
                };
                let parts: Vec<Part> = model.parts[run.clone()].iter().map(here).collect();
                let own = Added {
                    parts: &parts,
                    world_from_group: placed.world_from_model() * model_from_group,
                    object_from_group: self.object_place(placed, run.start, model_from_group, &mut plan.places),
                    ..rest
                };
                dropped += self.copy(&own, Some(group))?;
            }
        }
        Ok(dropped)
    }

    /// Where a copy stands within its object.
    fn object_place(
        &mut self,
        placed: &PlacedModel,
        copy: usize,
        model_from_group: DAffine3,
        known: &mut HashMap<usize, u32>,
    ) -> ObjectFromGroup {
        if placed.transform.is_none() {
            return ObjectFromGroup::WorldFromGroup;
        }
        let Some(place) = Transform::new(model_from_group) else {
            // What is flat is baked.
            return ObjectFromGroup::Identity;
        };
        let at = known.entry(copy).or_insert_with(|| {
            self.object_places.push(place);
            self.object_places.len() as u32 - 1
        });
        ObjectFromGroup::At(*at)
    }

    fn check_room(&self, triangles: u64, vertices: u64, placed: &PlacedModel) -> Result<(), AssetError> {
        let triangles = self.geometry.triangles.len() as u64 + triangles;
        let vertices = self.geometry.vertices.len() as u64 + vertices;
        if triangles > MOST_TRIANGLES || vertices > u64::from(u32::MAX) {
            let (limit, path) = (MOST_TRIANGLES, placed.file.clone());
            return Err(AssetError::TooManyTriangles { triangles, limit, path });
        }
        Ok(())
    }

    /// Adds a model's materials, textures and images; returns the number of its first material.
    fn add_looks(&mut self, model: &Model) -> u32 {
        let first_material = self.materials.len() as u32;
        let first_image = self.images.len();
        self.images
            .extend(model.images.iter().map(|i| (i.clone(), ColorSpace::Srgb)));
        for surfacing in &model.materials {
            let albedo = self.color(surfacing, first_image);
            self.materials.push(Material::Matte(Matte::smooth(albedo)));
            self.names.push(surfacing.name.clone());
        }
        first_material
    }

    fn color(&mut self, surfacing: &Surfacing, first_image: usize) -> Color {
        let Some(texture) = &surfacing.base_texture else {
            return Color::Constant(surfacing.base_color);
        };
        self.textures.push(Texture {
            mapping: Mapping::Uv,
            transform: StTransform::IDENTITY,
            pattern: Pattern::Image(ImagePattern {
                bitmap: BitmapId((first_image + texture.image) as u32),
                filter: texture.filter,
                wrap: texture.wrap,
            }),
        });
        let id = TextureId(self.textures.len() as u32 - 1);
        Color::Tinted(id, surfacing.base_color)
    }

    /// Adds parts as an instance of `group`, which is made of them where there is none yet; or in world space, where
    /// no group is asked for or an instance will not do. Returns how many triangles were left out.
    fn copy(&mut self, copy: &Added<'_>, group: Option<&mut Option<u32>>) -> Result<usize, AssetError> {
        let (placed, uses) = (copy.placed, copy.uses);
        let shines = |part: &Part| {
            let material = uses.material_of(part, placed.material);
            matches!(self.materials[material.0 as usize], Material::Emitter(_))
        };
        let transform = Transform::new(copy.world_from_group).filter(|t| t.magnification().0 <= MOST_MAGNIFICATION);
        let (Some(group), Some(transform)) = (group.filter(|_| !copy.parts.iter().any(shines)), transform) else {
            let mut dropped = 0;
            for part in copy.parts {
                dropped += self.bake(copy, part, Space::World)?;
            }
            return Ok(dropped);
        };
        let mut dropped = 0;
        let number = match *group {
            Some(number) => number,
            None => {
                let (vertices, triangles) = (self.geometry.vertices.len(), self.geometry.triangles.len());
                for part in copy.parts {
                    dropped += self.bake(copy, part, Space::Group)?;
                }
                self.geometry.groups.push(Group {
                    triangles: triangles as u32..self.geometry.triangles.len() as u32,
                    vertices: vertices as u32..self.geometry.vertices.len() as u32,
                });
                *group.insert(self.geometry.groups.len() as u32 - 1)
            }
        };
        self.geometry.instances.push(PlacedGroup {
            group: number,
            transform: self.geometry.transforms.len() as u32,
        });
        self.geometry.transforms.push(transform);
        self.instances.push(InstanceRecord {
            object: placed.object,
            material: placed.material,
            object_from_group: copy.object_from_group,
        });
        Ok(dropped)
    }

    /// Adds a part; returns how many of its triangles have no area and were left out.
    fn bake(&mut self, copy: &Added<'_>, part: &Part, space: Space) -> Result<usize, AssetError> {
        let mesh = &copy.model.meshes[part.mesh];
        self.check_room(mesh.triangles.len() as u64, mesh.positions.len() as u64, copy.placed)?;
        let (world_from_group, transform, instead) = match space {
            Space::World => (copy.world_from_group, copy.placed.transform, copy.placed.material),
            // Its meshes keep their own materials, for the objects that do not bring one.
            Space::Group => (
                DAffine3::IDENTITY,
                None,
                copy.placed.material.filter(|_| copy.uses.first_material.is_none()),
            ),
        };
        let place = Place::new(world_from_group * part.model_from_mesh);
        let first_vertex = self.geometry.vertices.len() as u32;
        let first_triangle = self.geometry.triangles.len() as u32;
        self.geometry.vertices.par_extend(place.points(mesh));
        let vertices = &self.geometry.vertices;
        let triangles = mesh.triangles.par_iter().with_min_len(MIN_LEN).filter_map(|t| {
            let [a, b, c] = t.map(|v| v + first_vertex);
            let corners = [a, b, c].map(|v| vertices[v as usize]);
            has_area(corners).then_some(if place.mirrors { [a, c, b] } else { [a, b, c] })
        });
        self.geometry.triangles.par_extend(triangles);
        let end = self.geometry.triangles.len() as u32;
        if end > first_triangle {
            self.meshes.push(MeshRecord {
                object: copy.placed.object,
                material: copy.uses.material_of(part, instead),
                transform,
                triangles: first_triangle..end,
                vertices: first_vertex..self.geometry.vertices.len() as u32,
                normals: mesh.normals.iter().map(|n| place.normal(*n)).collect(),
                uvs: mesh.uvs.clone(),
            });
        }
        Ok(mesh.triangles.len() - (end - first_triangle) as usize)
    }
}
