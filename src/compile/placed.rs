//! The models of objects, and the parts of them that move.

use std::{collections::HashMap, path::PathBuf, sync::Arc};

use super::{
    model_lights::LampOptions,
    place::ObjectPlace,
    selection::{SelectedNodes, Selection},
};
use crate::{
    assets::{
        model::{Model, ModelChoice},
        motion::{ModelEdits, NodeEdit},
        store::ModelRequest,
    },
    describe::{Part, PartsDesc, SceneDesc},
    geometry::{InstanceId, MAX_MAGNIFICATION},
    material::MaterialId,
    math::{DAabb, DAffine3, Transform},
    scene::{MeshId, ObjectFromGroup, ObjectId},
    shape::mesh::{Playback, Repeat},
    value::{Problem, Span, Spanned, UnknownName, matches_wildcards},
};

/// An object whose geometry is in a file.
#[derive(Clone, Debug)]
pub(super) struct PlacedModel {
    pub object: ObjectId,
    /// The object of the description, by its index: the same, unless this is a part of it.
    pub described: usize,
    /// The index of the placed model that this is a part of, if it is one.
    pub part_of: Option<usize>,
    /// The nodes that are shown.
    pub selection: Selection,
    /// The same nodes of its model, once that is loaded.
    pub nodes: SelectedNodes,
    pub file: PathBuf,
    pub choice: ModelChoice,
    /// When its animations are played.
    pub playback: Playback,
    /// The values that replace those of the file, at the time for which the scene is compiled.
    pub edits: ModelEdits,
    /// Whether these change over time.
    pub is_edited_over_time: bool,
    /// The materials of the scene that take the place of some of the model's, by the names of these.
    pub replaced: Vec<(String, MaterialId)>,
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
    /// The options for its point lights and spots.
    pub lamps: LampOptions,
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

/// The problem of values of parts of an object that is no mesh.
pub(super) const NO_PARTS: &str = "only a `shape.mesh` has nodes and materials of its own";

/// The problem of values of materials that are not shown.
pub(super) const OTHER_MATERIAL: &str = "the object has a `material`, which takes the place of those of its model";

/// Finds what placed objects show of their models, and the values that replace those of these.
pub(super) fn choose_parts(desc: &SceneDesc, placed: &mut [PlacedModel], models: &[Arc<Model>]) {
    for (at, model) in models.iter().enumerate() {
        placed[at].edits = edits(&desc.objects[placed[at].described].parts, model);
        // The parts of an object follow it.
        let selection = &placed[at].selection;
        placed[at].nodes = match placed[at].part_of {
            Some(whole) => placed[whole].nodes.of(selection),
            None => selection.nodes(model),
        };
    }
}

/// The values of a description that replace those of `model`.
pub(super) fn edits(parts: &PartsDesc, model: &Model) -> ModelEdits {
    let Some(motion) = &model.motion else {
        return ModelEdits::default();
    };
    let node = |(name, edit): (&str, NodeEdit)| Some((*motion.named_nodes.get(name)?, edit));
    let mut edits = ModelEdits {
        nodes: parts.nodes().filter_map(node).collect(),
        ..ModelEdits::default()
    };
    for (name, factors) in parts.materials() {
        // A material that is not shown has no motion.
        if let Some(&material) = motion.named_materials.get(name) {
            edits.materials.extend(factors.iter().map(|factor| (material, *factor)));
        }
    }
    edits
}

/// The problems of names in descriptions that are none of `models`, which are those of `placed`.
pub(super) fn unknown_parts(desc: &SceneDesc, placed: &[PlacedModel], models: &[Arc<Model>]) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (placed, model) in placed.iter().zip(models) {
        let object = &desc.objects[placed.described];
        let parts = &object.parts;
        if parts.is_empty() && placed.selection.is_whole() || placed.part_of.is_some() {
            continue;
        }
        let known = KnownParts::new(placed, model);
        problems.extend(object.node_patterns().filter_map(|pattern| known.unmatched(pattern)));
        problems.extend(
            parts
                .names()
                .filter_map(|(what, name, span)| known.problem(what, name, span)),
        );
    }
    problems
}

/// The names of the nodes and materials of a model.
pub(super) struct KnownParts {
    nodes: Vec<String>,
    materials: Vec<String>,
    /// Whether the object has another material.
    has_other: bool,
}

impl KnownParts {
    pub fn new(placed: &PlacedModel, model: &Model) -> Self {
        Self {
            nodes: model.names_of_nodes(),
            materials: model.names_of_materials().into_iter().map(|(name, _)| name).collect(),
            has_other: placed.material.is_some(),
        }
    }

    /// The problem of a name with wildcards that means no node.
    fn unmatched(&self, pattern: &Spanned<String>) -> Option<Problem> {
        if self.nodes.iter().any(|name| matches_wildcards(pattern.get_ref(), name)) {
            return None;
        }
        self.problem(Part::Node, pattern.get_ref(), pattern.span())
    }

    /// The problem of a name at `span` that none of these parts has.
    pub fn problem(&self, part: Part, name: &str, span: Span) -> Option<Problem> {
        let (what, known) = match part {
            Part::Material if self.has_other => return Some(Problem::at(span, OTHER_MATERIAL)),
            Part::Node => ("node", &self.nodes),
            Part::Material => ("material", &self.materials),
        };
        if known.iter().any(|known| known == name) {
            return None;
        }
        let unknown = UnknownName::new(what, name, known.iter().map(String::as_str));
        Some(match known.is_empty() {
            true => unknown.with_fallback(Some("the model has none".to_owned())).at(span),
            false => unknown.at(span),
        })
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
            let pose = || model.pose(&placed.playback, &placed.edits, time);
            let posed = poses.or_insert_with(model, placed, || {
                let posed = pose().map(|pose| model.posed(pose));
                if placed.selection.is_whole() {
                    return posed.map_or_else(|| Arc::clone(model), Arc::new);
                }
                let mut chosen = posed.unwrap_or_else(|| Model::clone(model));
                chosen.hidden.extend(placed.nodes.left_out(model));
                Arc::new(chosen)
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

/// What the pose of a model follows from, beside the time.
#[derive(PartialEq, Eq, Hash)]
struct PoseKey {
    model: *const Model,
    start_and_speed: [u64; 2],
    times: Option<u32>,
    /// The bits of values of the file, or the object whose values change over time: whether objects share a pose does not
    /// depend on the time.
    edits: Result<Vec<u64>, u32>,
    replaced: Vec<(String, u32)>,
    selection: Selection,
}

/// A value for each pose of a model.
pub(super) struct Poses<T>(HashMap<PoseKey, T>);

impl<T> Default for Poses<T> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

impl<T> Poses<T> {
    fn key(model: &Arc<Model>, placed: &PlacedModel) -> PoseKey {
        let playback = &placed.playback;
        PoseKey {
            model: Arc::as_ptr(model),
            start_and_speed: [playback.start, playback.speed].map(f64::to_bits),
            times: match playback.repeat {
                Repeat::Once => Some(1),
                Repeat::Times(times) => Some(times),
                Repeat::Forever => None,
            },
            edits: match placed.is_edited_over_time {
                true => Err(placed.object.0),
                false => Ok(placed.edits.bits()),
            },
            replaced: (placed.replaced.iter())
                .map(|(name, material)| (name.clone(), material.0))
                .collect(),
            selection: placed.selection.clone(),
        }
    }

    /// The value of the pose of an object, made once.
    pub fn or_insert_with(&mut self, model: &Arc<Model>, placed: &PlacedModel, new: impl FnOnce() -> T) -> &T {
        self.0.entry(Self::key(model, placed)).or_insert_with(new)
    }

    pub fn get(&self, model: &Arc<Model>, placed: &PlacedModel) -> Option<&T> {
        self.0.get(&Self::key(model, placed))
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
