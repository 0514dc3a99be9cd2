//! Models of a scene: triangles in world space, or instances.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use super::{
    instancing::{InstanceUnits, Instancing},
    materials::add_model_materials,
    model_lights,
    motion::Movables,
    placed::{Kept, LoadedModels, MovedPart, PlacedModel},
};
use crate::{
    assets::{
        AssetError, MemoryBudget, MemoryKind,
        model::{MAX_TRIANGLES, MeshInstance, Model, ModelTexture},
        store::ImageRequest,
    },
    geometry::InstanceId,
    light::LightFind,
    material::MaterialId,
    math::{DAabb, DAffine3, Transform, origin},
    scene::{
        GroupId, InstanceRecord, LightId, MeshId, MeshOwner, MeshTransform, NodeId, ObjectFromGroup, SceneBuilder,
    },
    texture::{BitmapId, TextureId},
    warnings::{WarningKind, Warnings},
};

mod hidden;
mod model_use;
mod node_names;

pub(super) use model_use::ModelUse;

/// The meshes of a model that become instances, with their groups so far.
struct InstancingPlan {
    units: InstanceUnits,
    /// The parts of [`InstanceUnits::rest`] in their own space, if they are not all parts or that is not the model's space.
    rest_parts: Option<Vec<MeshInstance>>,
    /// The transform from that space.
    model_from_rest: DAffine3,
    shares_rest: bool,
    rest: Option<GroupId>,
    shared: Vec<Option<GroupId>>,
    /// See [`Model::movers`].
    movers: Vec<Option<(Option<usize>, DAffine3)>>,
    /// The transforms of copies within the model, by the first part of each copy, and of the rest.
    transforms: HashMap<Option<usize>, ObjectFromGroup>,
}

impl InstancingPlan {
    fn new(model: &Model, bounds: &DAabb, model_use: &ModelUse, instancing: Instancing) -> Self {
        let mut units = InstanceUnits::new(model, model_use.objects, instancing);
        units.rest.retain(|part| !model.hidden.contains(part));
        let rest = &units.rest;
        let origin = origin::of_box(bounds);
        let near = |part: &MeshInstance| MeshInstance {
            model_from_mesh: DAffine3 {
                translation: part.model_from_mesh.translation - origin.unwrap_or_default(),
                ..part.model_from_mesh
            },
            ..part.clone()
        };
        let parts = || rest.iter().map(|&i| near(&model.instances[i])).collect();
        Self {
            rest_parts: (rest.len() < model.instances.len() || origin.is_some()).then(parts),
            model_from_rest: origin.map_or(DAffine3::IDENTITY, DAffine3::from_translation),
            shares_rest: instancing.wants(units.triangles, model_use.objects),
            rest: None,
            shared: vec![None; units.shared.len()],
            transforms: HashMap::new(),
            movers: model.movers(),
            units,
        }
    }

    /// The number of triangles that another object adds.
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
struct PlacedParts<'a> {
    placed: &'a PlacedModel,
    model: &'a Model,
    model_use: &'a ModelUse,
    /// Their transforms are relative to `scene_from_group`.
    parts: &'a [MeshInstance],
    /// The copy of a mesh that each part is, from `first_copy`.
    copies: &'a [Option<u32>],
    first_copy: u32,
    scene_from_group: DAffine3,
    model_from_group: DAffine3,
    object_from_group: ObjectFromGroup,
    /// The node, if the parts become an instance.
    node: Option<NodeId>,
    /// The first of the parts in the model, if they move.
    moves: Option<usize>,
}

/// The space of added triangles.
#[derive(Clone, Copy)]
enum Space {
    World,
    Group,
}

/// Adds models to a scene.
pub(super) struct ModelPlacer<'a> {
    pub scene: &'a mut SceneBuilder,
    /// The images of the scene so far, in the order of their [`BitmapId`]s.
    pub images: &'a mut Vec<ImageRequest>,
    pub instancing: Instancing,
    pub warnings: &'a Warnings,
    pub memory: &'a MemoryBudget,
    /// The parts that may move, so far.
    pub movables: Movables,
}

impl ModelPlacer<'_> {
    /// Adds the model of each object.
    pub fn place(&mut self, placed: &[PlacedModel], loaded: &LoadedModels) -> Result<(), Vec<AssetError>> {
        let LoadedModels { models, bounds, .. } = loaded;
        let mut errors = Vec::new();
        let mut uses: HashMap<*const Model, ModelUse> = HashMap::new();
        let pairs = placed.iter().zip(models);
        let moved: HashSet<*const Model> = pairs.filter(|(p, _)| p.moved).map(|(_, m)| Arc::as_ptr(m)).collect();
        for (placed, model) in placed.iter().zip(models) {
            // Parts share the nodes and the materials of their object.
            let whole = placed.part_of.map(|whole| &uses[&Arc::as_ptr(&models[whole])]);
            let shared = whole.map(ModelUse::shared);
            let model_use = uses
                .entry(Arc::as_ptr(model))
                .or_insert_with(|| shared.unwrap_or_default());
            model_use.objects += 1;
            if placed.part_of.is_some() {
                continue;
            }
            if model_use.objects == 1 && !model.nodes.is_empty() {
                let nodes = model.nodes.iter().map(|n| (n.name.as_str(), n.parent));
                model_use.first_node = Some(self.scene.model_nodes(nodes));
            }
            if !placed.replaced.is_empty() && model_use.replaced.is_empty() {
                let names = model.names_of_materials();
                for (name, material) in &placed.replaced {
                    let own = names.iter().find(|(known, _)| known == name);
                    let own = own.and_then(|(_, number)| *number);
                    model_use.replaced.extend(own.map(|own| (own, *material)));
                }
            }
            if placed.material.is_none() && model_use.first_material.is_none() {
                // Objects of one model share its materials.
                let first_texture = TextureId(self.scene.texture_count() as u32);
                let first = self.add_materials(model);
                model_use.first_material = Some(first);
                self.movables.looks.push((placed.object, first, first_texture));
            }
        }
        for (object, node) in node_names::of(placed, models, &uses) {
            self.scene.name_node(object, node);
        }
        let mut plans: HashMap<*const Model, InstancingPlan> = HashMap::new();
        for (placed, model) in placed.iter().zip(models) {
            let at = Arc::as_ptr(model);
            let instancing = match moved.contains(&at) {
                true => Instancing::Always,
                false => self.instancing,
            };
            let plan = plans
                .entry(at)
                .or_insert_with(|| InstancingPlan::new(model, &bounds[&at], &uses[&at], instancing));
            match self.add(placed, model, &uses[&at], plan) {
                Ok(0) => {}
                Ok(dropped) => {
                    let plural = if dropped == 1 { "triangle" } else { "triangles" };
                    let file = placed.file.display();
                    let text = format!("{dropped} {plural} without area left out: {file}");
                    self.warnings.add(WarningKind::NO_AREA, file, text);
                }
                Err(e) => errors.push(e),
            }
            errors.extend(self.add_lights(placed, model).err());
        }
        if errors.is_empty() { Ok(()) } else { Err(errors) }
    }

    /// Adds an object; returns the number of triangles that were left out because they have no area.
    fn add(
        &mut self,
        placed: &PlacedModel,
        model: &Model,
        model_use: &ModelUse,
        plan: &mut InstancingPlan,
    ) -> Result<usize, AssetError> {
        if let Some(points) = &model.points {
            if !placed.visible {
                self.scene.hidden_part(placed.object, None);
                return Ok(0);
            }
            self.take(points.positions.len() as u64 * SceneBuilder::SHAPE_BYTES, placed)?;
            self.add_points(placed, points, model_use);
            return Ok(0);
        }
        if placed.point_radius.is_some() {
            let file = placed.file.display();
            let text = format!("the radius of points is not used, since the model has faces: {file}");
            self.warnings
                .add_topic(WarningKind::UNUSED_SETTING, "radius", file, text);
        }
        let Some(first) = model.instances.first() else {
            let path = placed.file.clone();
            return Err(AssetError::NoTriangles { path });
        };
        self.check_capacity(plan.triangles(), 0, placed)?;
        let material = model_use.material(first.material, placed.material);
        self.scene.set_object_material(placed.object, material);
        let object_from_rest = if plan.model_from_rest == DAffine3::IDENTITY {
            ObjectFromGroup::Identity
        } else {
            self.object_from_group(placed, None, plan.model_from_rest, &mut plan.transforms)
        };
        let of_parts = &plan.units.copies.of_parts;
        let first_copy = self.scene.add_copies(plan.units.copies.count);
        let rest_copies: Vec<Option<u32>> = plan.units.rest.iter().map(|part| of_parts[*part]).collect();
        let rest = PlacedParts {
            placed,
            model,
            model_use,
            copies: &rest_copies,
            first_copy,
            parts: plan.rest_parts.as_ref().unwrap_or(&model.instances),
            scene_from_group: placed.place.of(&plan.model_from_rest),
            model_from_group: plan.model_from_rest,
            object_from_group: object_from_rest,
            node: None,
            moves: None,
        };
        let (mut dropped, mut hidden) = (0, [Vec::new(), Vec::new()]);
        if !rest.parts.is_empty() {
            let group = plan.shares_rest.then_some(&mut plan.rest);
            match placed.visible {
                true => dropped += self.copy(&rest, group)?,
                false => self.hide(&rest, group.is_some(), &mut hidden),
            }
        }
        for (unit, group) in plan.units.shared.iter().zip(&mut plan.shared) {
            // Parts of a run vanish together.
            for run in unit.copies.iter().filter(|run| !model.hidden.contains(&run.start)) {
                let model_from_group = model.instances[run.start].model_from_mesh;
                let in_group = |part: &MeshInstance| MeshInstance {
                    model_from_mesh: DAffine3::IDENTITY,
                    ..part.clone()
                };
                let parts: Vec<MeshInstance> = model.instances[run.clone()].iter().map(in_group).collect();
                let number = of_parts[run.start].map(|_| 0);
                let own = PlacedParts {
                    parts: &parts,
                    copies: &vec![number; parts.len()],
                    moves: plan.movers[run.start].map(|_| run.start),
                    first_copy: first_copy + of_parts[run.start].unwrap_or(0),
                    scene_from_group: placed.place.of(&model_from_group),
                    model_from_group,
                    object_from_group: self.object_from_group(
                        placed,
                        Some(run.start),
                        model_from_group,
                        &mut plan.transforms,
                    ),
                    node: model_use.node_of(&parts[0]),
                    ..rest
                };
                match placed.visible {
                    true => dropped += self.copy(&own, Some(group))?,
                    false => self.hide(&own, true, &mut hidden),
                }
            }
        }
        for node in hidden.concat() {
            self.scene.hidden_part(placed.object, node);
        }
        Ok(dropped)
    }

    /// Adds the lights of a model, where the object brings them.
    fn add_lights(&mut self, placed: &PlacedModel, model: &Model) -> Result<(), AssetError> {
        if placed.choice.lights != Some(true) || !placed.visible {
            return Ok(());
        }
        let world_from_scene = DAffine3::from_translation(self.scene.origin());
        let own = model.lights.iter().enumerate();
        for (number, light) in own.filter(|(number, _)| placed.nodes.has_light(model, *number)) {
            let place = world_from_scene * placed.place.of(&light.model_from_light);
            let Some(desc) = model_lights::describe(light, place, placed.lamps) else {
                continue;
            };
            let light = desc
                .compile(&LightFind::nothing(self.scene.origin()))
                .map_err(|problem| AssetError::Light {
                    cause: problem.message,
                    path: placed.file.clone(),
                })?;
            let id = LightId(self.scene.lights().len() as u32);
            self.movables.lights.push((placed.object, number, id));
            match &placed.light_group {
                Some(group) => self.scene.grouped_light(light, group),
                None => self.scene.light(light),
            }
            self.scene.own_last_light(placed.object);
        }
        Ok(())
    }

    /// The transform of a copy within its object; `None` for the parts that are not shared.
    fn object_from_group(
        &mut self,
        placed: &PlacedModel,
        copy: Option<usize>,
        model_from_group: DAffine3,
        known: &mut HashMap<Option<usize>, ObjectFromGroup>,
    ) -> ObjectFromGroup {
        if placed.place.transform.is_none() {
            return ObjectFromGroup::WorldFromGroup;
        }
        let Some(transform) = Transform::new(model_from_group) else {
            // A copy with a singular transform is baked.
            return ObjectFromGroup::Identity;
        };
        *known.entry(copy).or_insert_with(|| self.scene.object_place(transform))
    }

    /// Reserves memory for what is added to the scene, in bytes.
    fn take(&self, bytes: u64, placed: &PlacedModel) -> Result<(), AssetError> {
        self.memory
            .take(MemoryKind::Shapes, bytes)
            .map_err(|cause| AssetError::Memory {
                cause,
                path: placed.file.clone(),
            })
    }

    fn check_capacity(&self, triangles: u64, vertices: u64, placed: &PlacedModel) -> Result<(), AssetError> {
        let geometry = self.scene.geometry();
        let triangles = geometry.triangles.len() as u64 + triangles;
        let vertices = geometry.vertices.len() as u64 + vertices;
        if triangles > MAX_TRIANGLES || vertices > u64::from(u32::MAX) {
            let (limit, path) = (MAX_TRIANGLES, placed.file.clone());
            return Err(AssetError::TooManyTriangles { triangles, limit, path });
        }
        Ok(())
    }

    /// Adds a model's materials, textures and images; returns its first material.
    fn add_materials(&mut self, model: &Model) -> MaterialId {
        let first_material = self.scene.materials().len() as u32;
        // An image may be loaded both as colours and as data.
        let first_image = self.images.len();
        let mut bitmap = |texture: &ModelTexture| {
            let request = ImageRequest::new(model.images[texture.image].clone(), texture.color_space);
            let own = &self.images[first_image..];
            let at = own.iter().position(|known| *known == request).unwrap_or_else(|| {
                self.images.push(request);
                self.images.len() - 1 - first_image
            });
            BitmapId((first_image + at) as u32)
        };
        let bitmaps: Vec<BitmapId> = model.textures.iter().map(&mut bitmap).collect();
        add_model_materials(self.scene, model, &bitmaps);
        MaterialId(first_material)
    }

    /// Adds parts as an instance of `group`, which is made of them at the first call, or in world space if there is no `group` or
    /// an instance is not suitable. Returns the number of triangles that were left out.
    fn copy(&mut self, copy: &PlacedParts<'_>, group: Option<&mut Option<GroupId>>) -> Result<usize, AssetError> {
        let placed = copy.placed;
        let transform = self.instance_transform(copy, group.is_some());
        let (Some(group), Some(transform)) = (group, transform) else {
            let (mut dropped, emits) = (0, self.emits(copy));
            for (i, part) in copy.parts.iter().zip(copy.copies).enumerate() {
                let mesh = MeshId(self.scene.mesh_count());
                dropped += self.bake(copy, part, Space::World)?;
                if let Some(first) = copy.moves.filter(|_| self.scene.mesh_count() > mesh.0) {
                    let mirrors = MeshTransform::new(copy.scene_from_group).mirrors;
                    let kept = Kept::Baked { mesh, mirrors, emits };
                    self.movables.parts.push(MovedPart::new(placed.object, first + i, kept));
                }
            }
            return Ok(dropped);
        };
        let mut dropped = 0;
        let id = match *group {
            Some(id) => id,
            None => {
                let first_triangle = self.scene.geometry().triangles.len() as u32;
                let first_vertex = self.scene.geometry().vertices.len() as u32;
                for (i, part) in copy.parts.iter().zip(copy.copies).enumerate() {
                    let mesh = MeshId(self.scene.mesh_count());
                    dropped += self.bake(copy, part, Space::Group)?;
                    if let Some(first) = copy.moves.filter(|_| self.scene.mesh_count() > mesh.0) {
                        self.movables
                            .parts
                            .push(MovedPart::new(placed.object, first + i, Kept::InGroup(mesh)));
                    }
                }
                *group.insert(self.scene.end_group(first_triangle, first_vertex))
            }
        };
        let record = InstanceRecord {
            object: placed.object,
            material: placed.material,
            object_from_group: copy.object_from_group,
            node: copy.node,
            first_copy: copy.first_copy,
        };
        if let Some(first) = copy.moves {
            let kept = Kept::Instance {
                instance: InstanceId(self.scene.instance_count()),
                within: copy.object_from_group,
            };
            self.movables.parts.push(MovedPart::new(placed.object, first, kept));
        }
        self.take(SceneBuilder::INSTANCE_BYTES, placed)?;
        self.scene.place_group(id, transform, record);
        Ok(dropped)
    }

    /// Adds a part; returns the number of its triangles that were left out because they have no area.
    fn bake(
        &mut self,
        copy: &PlacedParts<'_>,
        (part, number): (&MeshInstance, &Option<u32>),
        space: Space,
    ) -> Result<usize, AssetError> {
        let mesh = &copy.model.meshes[part.mesh];
        self.check_capacity(mesh.triangles.len() as u64, mesh.positions.len() as u64, copy.placed)?;
        self.take(mesh.bytes() + SceneBuilder::MESH_BYTES, copy.placed)?;
        let (scene_from_group, transform, instead, first_copy) = match space {
            Space::World => (
                copy.scene_from_group,
                copy.placed.place.transform,
                copy.placed.material,
                copy.first_copy,
            ),
            // The meshes of a group keep the model's materials; instances may override them.
            Space::Group => (
                DAffine3::IDENTITY,
                None,
                copy.placed.material.filter(|_| copy.model_use.first_material.is_none()),
                0,
            ),
        };
        let owner = MeshOwner {
            object: copy.placed.object,
            material: copy.model_use.material(part.material, instead),
            transform,
            node: copy.model_use.node_of(part),
            copy: number.map(|number| first_copy + number),
        };
        let transform = MeshTransform::new(scene_from_group * part.model_from_mesh);
        let transform = match copy.moves {
            Some(_) => transform.keeping_all(),
            None => transform,
        };
        Ok(self.scene.transformed_mesh(&owner, mesh, &transform))
    }
}
