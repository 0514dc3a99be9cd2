//! The models of objects, and the parts of them that move.

use std::{collections::HashMap, path::PathBuf, sync::Arc};

use super::place::ObjectPlace;
use crate::{
    assets::{
        model::{Model, ModelChoice},
        store::ModelRequest,
    },
    geometry::{InstanceId, MAX_MAGNIFICATION},
    material::MaterialId,
    math::{DAabb, DAffine3, Transform},
    scene::{MeshId, ObjectFromGroup, ObjectId},
    shape::mesh::{Playback, Repeat},
};

/// An object whose geometry is in a file.
#[derive(Clone, Debug)]
pub(super) struct PlacedModel {
    pub object: ObjectId,
    pub file: PathBuf,
    pub choice: ModelChoice,
    /// When its animations are played.
    pub playback: Playback,
    /// Overrides the model's own materials.
    pub material: Option<MaterialId>,
    pub place: ObjectPlace,
    /// Whether its geometry and its lights are there.
    pub visible: bool,
    /// Whether it moves at some time: then its parts are instances.
    pub moved: bool,
    /// The group of its lights.
    pub light_group: Option<String>,
    /// Overrides the radius of its points, in m.
    pub point_radius: Option<f32>,
}

impl PlacedModel {
    /// The request for its file.
    pub fn request(&self) -> ModelRequest {
        ModelRequest {
            path: self.file.clone(),
            choice: self.choice.clone(),
        }
    }

    /// The transform of a group of its parts as an instance, which is that to the object's space `within` the object; `None` if it
    /// cannot be one. That of an object that moves is the one that moving it makes.
    pub fn transform(&self, model_from_group: &DAffine3, within: ObjectFromGroup) -> Option<Transform> {
        let whole = Transform::new(self.place.of(model_from_group))?;
        let transform = match (self.place.transform, within) {
            (Some(place), ObjectFromGroup::Identity) if self.moved => place,
            (Some(place), ObjectFromGroup::At(_)) if self.moved => {
                place.then_from(&Transform::new(*model_from_group)?)?
            }
            _ => whole,
        };
        (transform.magnification().0 <= MAX_MAGNIFICATION).then_some(transform)
    }
}

/// The models of placed objects, one for each object.
pub(super) struct LoadedModels {
    /// In the poses of the time for which the scene is compiled.
    pub models: Vec<Arc<Model>>,
    /// The same at rest.
    pub at_rest: Vec<Arc<Model>>,
    /// The bounds at rest of each different model.
    pub bounds: HashMap<*const Model, DAabb>,
}

impl LoadedModels {
    /// The models of these objects at `time`, in s.
    pub fn new(placed: &[PlacedModel], at_rest: Vec<Arc<Model>>, time: f64) -> Self {
        let mut rest_bounds = HashMap::new();
        let (mut bounds, mut models) = (HashMap::new(), Vec::new());
        let mut poses: Poses<Arc<Model>> = Poses::default();
        for (placed, model) in placed.iter().zip(&at_rest) {
            let own = *rest_bounds.entry(Arc::as_ptr(model)).or_insert_with(|| model.bounds());
            let posed = poses.or_insert_with(model, &placed.playback, || match model.pose(&placed.playback, time) {
                Some(pose) => Arc::new(model.posed(pose)),
                None => Arc::clone(model),
            });
            bounds.insert(Arc::as_ptr(posed), own);
            models.push(Arc::clone(posed));
        }
        Self {
            models,
            at_rest,
            bounds,
        }
    }

    /// The bounds of the model of each object at rest, in the space of the model.
    pub fn own_bounds(&self) -> impl Iterator<Item = &DAabb> {
        self.models.iter().map(|model| &self.bounds[&Arc::as_ptr(model)])
    }
}

/// A value for each model and playback.
pub(super) struct Poses<T>(HashMap<(*const Model, [u64; 2], Option<u32>), T>);

impl<T> Default for Poses<T> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

impl<T> Poses<T> {
    fn key(model: &Arc<Model>, playback: &Playback) -> (*const Model, [u64; 2], Option<u32>) {
        let times = match playback.repeat {
            Repeat::Once => Some(1),
            Repeat::Times(times) => Some(times),
            Repeat::Forever => None,
        };
        let numbers = [playback.start, playback.speed].map(f64::to_bits);
        (Arc::as_ptr(model), numbers, times)
    }

    /// The value of a model and a playback, made once.
    pub fn or_insert_with(&mut self, model: &Arc<Model>, playback: &Playback, new: impl FnOnce() -> T) -> &T {
        self.0.entry(Self::key(model, playback)).or_insert_with(new)
    }

    pub fn get(&self, model: &Arc<Model>, playback: &Playback) -> Option<&T> {
        self.0.get(&Self::key(model, playback))
    }
}

/// The place in the scene of a part that moves.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kept {
    Instance {
        instance: InstanceId,
        within: ObjectFromGroup,
    },
    /// In the space of a group.
    InGroup(MeshId),
    /// In the space of the scene.
    Baked {
        mesh: MeshId,
        mirrors: bool,
        /// Whether it emits light. If not, it is baked because its transform has no inverse.
        emits: bool,
    },
}

/// A part of a model that moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct MovedPart {
    pub object: ObjectId,
    /// An index into [`Model::instances`].
    pub part: usize,
    pub kept: Kept,
}

impl MovedPart {
    pub fn new(object: ObjectId, part: usize, kept: Kept) -> Self {
        Self { object, part, kept }
    }
}
