//! The motion of a compiled scene, and the update of the scene for another time.
//!
//! An update has the same numbers as the scene that is compiled for its time. Where that scene would have another structure there
//! is no update: an instance whose transform has no inverse is baked, a light that goes out is left out.

use std::{collections::BTreeMap, sync::Arc};

use super::{
    materials::model_material,
    model_lights,
    objects::moved_place,
    placed::{Kept, KnownParts, MovedPart, NO_PARTS, PlacedModel, Poses, edits},
    refresh::are_alike,
};
use crate::{
    assets::{
        Store,
        image::BitmapKey,
        model::Model,
        motion::{MeshShape, ModelPose},
        store::EnvironmentKey,
    },
    describe::{Part, SceneDesc},
    light::{Light, LightFind},
    material::{Material, MaterialId},
    math::{DAffine3, Transform, Vec3, Vec4, parallel},
    scene::{LightId, MeshId, MeshPose, MeshTransform, ObjectFromGroup, ObjectId, Scene, SceneUpdate, ShadingUpdate},
    texture::{StTransform, TextureId},
    value::{Problem, Span},
};

/// The places in a scene of all that the animations of models may move.
#[derive(Default)]
pub(super) struct Movables {
    pub parts: Vec<MovedPart>,
    /// The lights that shine: the object, the light of its model, and that of the scene.
    pub lights: Vec<(ObjectId, usize, LightId)>,
    /// The objects whose models brought their materials, with the first of these and of their textures.
    pub looks: Vec<(ObjectId, MaterialId, TextureId)>,
}

/// The motion of models in a compiled scene.
#[derive(Default)]
pub struct SceneMotion {
    placed: Vec<PlacedModel>,
    models: Vec<Arc<Model>>,
    movables: Movables,
    /// The keys of the bitmaps of the scene, and of its environment map.
    images: Vec<Option<BitmapKey>>,
    environment: Option<EnvironmentKey>,
}

impl SceneMotion {
    pub(super) fn new(placed: Vec<PlacedModel>, models: Vec<Arc<Model>>, movables: Movables) -> Self {
        let plays = |model: &Arc<Model>| model.motion.as_ref().is_some_and(|motion| !motion.clips.is_empty());
        if !models.iter().any(plays) && !placed.iter().any(|placed| placed.is_edited_over_time) {
            return Self::default();
        }
        Self {
            placed,
            models,
            movables,
            images: Vec::new(),
            environment: None,
        }
    }

    /// The problem of the name of a part of the model of an object, if there is one. Of a scene in which nothing moves only parts
    /// of objects without a model have one.
    pub fn part_problem(&self, object: usize, part: Part, name: &str, span: Span) -> Option<Problem> {
        let at = self.placed.iter().position(|placed| placed.object.0 as usize == object);
        match at {
            Some(at) => KnownParts::new(&self.placed[at], &self.models[at]).problem(part, name, span),
            None => Some(Problem::at(span, NO_PARTS)),
        }
    }

    /// The same for a scene with bitmaps and an environment map of these keys.
    pub(super) fn with_images(self, images: Vec<Option<BitmapKey>>, environment: Option<EnvironmentKey>) -> Self {
        Self {
            images,
            environment,
            ..self
        }
    }

    /// Gives `store` the images of `scene` for the one that is compiled next. The scene was compiled with this and
    /// shows no textures afterwards; those of a scene that others have as well stay. `has_new_background` tells whether
    /// the background has changed since.
    pub fn keep_images(&self, scene: &mut Scene, store: &Store, has_new_background: bool) {
        let environment = self.environment.clone().filter(|_| !has_new_background);
        if let Some(key) = environment {
            store.keep_background(key, scene.shading.background.radiance.clone());
        }
        let shading = Arc::get_mut(&mut scene.shading);
        let bitmaps = shading.map(|shading| std::mem::take(&mut shading.bitmaps));
        let keyed = self.images.iter().cloned().zip(bitmaps.unwrap_or_default());
        store.keep_images(keyed.filter_map(|(key, bitmap)| Some((key?, bitmap))));
    }

    /// Whether nothing moves.
    pub fn is_still(&self) -> bool {
        self.models.is_empty()
    }

    /// The times within all animations that are played at `time`, in s.
    pub fn local_times(&self, time: f64) -> impl Iterator<Item = f32> {
        let played = self.placed.iter().zip(&self.models);
        played.flat_map(move |(placed, model)| {
            let motion = model.motion.iter();
            motion.flat_map(move |motion| motion.local_times(&placed.playback, time))
        })
    }

    /// The update to `time`, in s, of `scene`, which was compiled with this and is that of `desc` but for its animations; `None` if
    /// it has to be compiled for that time. What `last` has already is left out; `last` becomes that of the update.
    pub fn update(
        &self,
        scene: &Scene,
        desc: &SceneDesc,
        time: f64,
        last: &mut LastPoses,
    ) -> Option<(SceneUpdate, ShadingUpdate)> {
        let old = std::mem::take(last);
        let mut placed = self.placed.clone();
        for (placed, model) in placed.iter_mut().zip(&self.models) {
            let object = &desc.objects[placed.described];
            if placed.moved {
                placed.place = moved_place(object, scene.origin).ok()?;
            }
            if placed.is_edited_over_time {
                placed.edits = edits(&object.parts, model);
            }
            last.geometry.push(geometry_key(placed, model, time));
            last.looks.push(looks_key(placed, model, time));
        }
        let has_moved = |at: usize| old.geometry.get(at) != Some(&last.geometry[at]);
        let pairs = || placed.iter().zip(&self.models).enumerate();
        let mut poses: Poses<ModelPose> = Poses::default();
        for (_, (placed, model)) in pairs().filter(|(at, _)| has_moved(*at)) {
            let pose = || model.pose(&placed.playback, &placed.edits, time);
            poses.or_insert_with(model, placed, || pose().unwrap_or_default());
        }
        let (mut models, mut looks) = (BTreeMap::new(), BTreeMap::new());
        for (at, (placed, model)) in pairs() {
            if has_moved(at) {
                let pose = poses.get(model, placed)?;
                models.insert(placed.object.0, PosedModel { placed, model, pose });
            }
            if old.looks.get(at) != Some(&last.looks[at]) {
                looks.insert(placed.object.0, (placed, model));
            }
        }
        let shading = ShadingUpdate {
            materials: self.materials(scene, desc, (&looks, time))?,
            normal_maps: Vec::new(),
            textures: self.textures((&looks, time)),
            lights: self.lights(scene, desc, &models)?,
            background: None,
        };
        Some((self.geometry(&models)?, shading))
    }

    fn geometry(&self, models: &BTreeMap<u32, PosedModel<'_>>) -> Option<SceneUpdate> {
        let mut update = SceneUpdate::default();
        let mut meshes = Vec::new();
        for moved in &self.movables.parts {
            let Some(posed) = models.get(&moved.object.0) else {
                continue;
            };
            let model_from_mesh = posed.part(moved.part);
            let instance = |within| posed.placed.transform(&model_from_mesh, within);
            match moved.kept {
                Kept::Instance { instance: id, within } => {
                    update.instances.push((id, instance(within)?));
                    if let ObjectFromGroup::At(place) = within {
                        update.places.push((place, Transform::new(model_from_mesh)?));
                    }
                }
                Kept::InGroup(mesh) => {
                    if let Some(shape) = posed.deformed(moved.part) {
                        meshes.push((mesh, shape, MeshTransform::new(DAffine3::IDENTITY)));
                    }
                }
                Kept::Baked { mesh, mirrors, emits } => {
                    let transform = MeshTransform::new(posed.placed.place.of(&model_from_mesh));
                    if transform.mirrors != mirrors || !emits && instance(ObjectFromGroup::WorldFromGroup).is_some() {
                        return None;
                    }
                    meshes.push((mesh, posed.shape(moved.part), transform));
                }
            }
        }
        let pose = |(mesh, shape, transform): &(MeshId, Arrays<'_>, MeshTransform)| mesh_pose(*mesh, *shape, transform);
        update.poses = meshes.iter().map(pose).collect();
        Some(update)
    }

    /// The new materials of these models at `time`; `None` if the scene has other arrays with them.
    fn materials(
        &self,
        scene: &Scene,
        desc: &SceneDesc,
        (models, time): (&MovedLooks<'_>, f64),
    ) -> Option<Vec<(MaterialId, Material)>> {
        let mut materials = Vec::new();
        for (object, first_material, first_texture) in &self.movables.looks {
            let Some((placed, model)) = models.get(&object.0) else {
                continue;
            };
            let motion = model.motion.iter();
            let surfaces = motion.flat_map(|motion| motion.surfaces(&placed.playback, &placed.edits, time));
            for (number, surface) in surfaces {
                let id = MaterialId(first_material.0 + number as u32);
                let mut material = model_material(&surface, *first_texture);
                material.convert_colors(desc.render.working_space);
                if !are_alike(scene.material(id), &material) {
                    return None;
                }
                materials.push((id, material));
            }
        }
        Some(materials)
    }

    /// The new transforms of textures.
    fn textures(&self, (models, time): (&MovedLooks<'_>, f64)) -> Vec<(TextureId, StTransform)> {
        let of_model = |(object, _, first): &(ObjectId, MaterialId, TextureId)| {
            let first = first.0;
            let (placed, model) = models.get(&object.0)?;
            let moved = model.motion.as_ref()?.texture_transforms(&placed.playback, time);
            let ids = moved
                .into_iter()
                .map(move |(texture, transform)| (TextureId(first + texture as u32), transform));
            Some(ids)
        };
        let looks = self.movables.looks.iter();
        looks.filter_map(of_model).flatten().collect()
    }

    /// The new lights; `None` if others of them shine.
    fn lights(
        &self,
        scene: &Scene,
        desc: &SceneDesc,
        models: &BTreeMap<u32, PosedModel<'_>>,
    ) -> Option<Vec<(LightId, Light)>> {
        let shines = |posed: &&PosedModel<'_>| posed.placed.choice.lights == Some(true) && posed.placed.visible;
        let world_from_scene = DAffine3::from_translation(scene.origin);
        let mut lights = Vec::new();
        for posed in models.values().filter(shines) {
            let own = posed.pose.lights.iter().enumerate();
            for (number, light) in own.filter(|(number, _)| posed.placed.nodes.has_light(posed.model, *number)) {
                let is_it =
                    |(object, own, _): &&(ObjectId, usize, LightId)| (*object, *own) == (posed.placed.object, number);
                let place = world_from_scene * posed.placed.place.of(&light.model_from_light);
                let kept = self.movables.lights.iter().find(is_it);
                match (kept, model_lights::describe(light, place, posed.placed.lamps)) {
                    (Some((.., id)), Some(desc_of_light)) => {
                        let mut light = desc_of_light.compile(&LightFind::nothing(scene.origin)).ok()?;
                        light.convert_colors(desc.render.working_space);
                        lights.push((*id, light));
                    }
                    (None, None) => {}
                    _ => return None,
                }
            }
        }
        Some(lights)
    }
}

/// What the poses of a scene followed from that was updated last: of the model of each object its geometry, and its materials. With
/// nothing in it everything is updated.
#[derive(Default)]
pub struct LastPoses {
    geometry: Vec<Vec<u64>>,
    looks: Vec<Vec<u64>>,
}

fn times<'a>(placed: &'a PlacedModel, model: &'a Model, time: f64) -> impl Iterator<Item = u64> + 'a {
    let motion = model.motion.iter();
    motion.flat_map(move |motion| {
        let times = motion.local_times(&placed.playback, time);
        times.map(|time| time.to_bits().into())
    })
}

fn geometry_key(placed: &PlacedModel, model: &Model, time: f64) -> Vec<u64> {
    let place = placed.place.of(&DAffine3::IDENTITY);
    let place = place.to_cols_array().map(f64::to_bits);
    let mut key: Vec<u64> = times(placed, model, time).chain(place).collect();
    key.extend(placed.edits.bits_of_nodes());
    key
}

fn looks_key(placed: &PlacedModel, model: &Model, time: f64) -> Vec<u64> {
    let mut key: Vec<u64> = times(placed, model, time).collect();
    key.extend(placed.edits.bits_of_materials());
    key
}

/// The models whose materials or textures change, by their objects.
type MovedLooks<'a> = BTreeMap<u32, (&'a PlacedModel, &'a Arc<Model>)>;

/// The positions, normals and tangents of a mesh.
type Arrays<'a> = (&'a [Vec3], &'a [Vec3], &'a [Vec4]);

/// The pose of a mesh of the scene.
fn mesh_pose(mesh: MeshId, (positions, normals, tangents): Arrays<'_>, transform: &MeshTransform) -> MeshPose {
    MeshPose {
        mesh,
        positions: parallel::table(positions.len(), |i| transform.point(positions[i])),
        normals: parallel::table(normals.len(), |i| transform.normal(normals[i])),
        tangents: parallel::table(tangents.len(), |i| transform.tangent(tangents[i])),
    }
}

/// A model in its pose.
#[derive(Clone, Copy)]
struct PosedModel<'a> {
    placed: &'a PlacedModel,
    model: &'a Model,
    pose: &'a ModelPose,
}

impl<'a> PosedModel<'a> {
    /// The transform of a part.
    fn part(&self, part: usize) -> DAffine3 {
        let moved = self.pose.parts.binary_search_by_key(&part, |(part, _)| *part);
        moved.map_or(self.model.instances[part].model_from_mesh, |at| self.pose.parts[at].1)
    }

    /// The shape of the mesh of a part, if it deforms.
    fn deformed(&self, part: usize) -> Option<Arrays<'a>> {
        let mesh = self.model.instances[part].mesh;
        let posed = self.pose.meshes.iter().find(|(posed, _)| *posed == mesh);
        posed.map(
            |(
                _,
                MeshShape {
                    positions,
                    normals,
                    tangents,
                },
            )| (&positions[..], &normals[..], &tangents[..]),
        )
    }

    /// The shape of the mesh of a part.
    fn shape(&self, part: usize) -> Arrays<'a> {
        let mesh = &self.model.meshes[self.model.instances[part].mesh];
        self.deformed(part)
            .unwrap_or((&mesh.positions, &mesh.normals, &mesh.tangents))
    }
}
