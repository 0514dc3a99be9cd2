//! The nodes of objects, in the order in which they are named and numbered.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use super::model_use::ModelUse;
use crate::{
    assets::model::Model,
    compile::placed::PlacedModel,
    scene::{NodeId, ObjectId},
};

/// The nodes that each object shows, by itself or by its parts, in the order of its file. So names and numbers depend neither on
/// which nodes are visible nor on which have settings of their own, move or share their triangles.
pub(super) fn of(
    placed: &[PlacedModel],
    models: &[Arc<Model>],
    uses: &HashMap<*const Model, ModelUse>,
) -> Vec<(ObjectId, NodeId)> {
    let mut parts_of: HashMap<usize, Vec<&PlacedModel>> = HashMap::new();
    for part in placed {
        if let Some(whole) = part.part_of {
            parts_of.entry(whole).or_default().push(part);
        }
    }
    let mut nodes = Vec::new();
    for (at, (whole, model)) in placed.iter().zip(models).enumerate() {
        if whole.part_of.is_some() {
            continue;
        }
        let parts = parts_of.get(&at).into_iter().flatten().copied();
        let left_out: Vec<HashSet<usize>> = parts.chain([whole]).map(|part| part.nodes.left_out(model)).collect();
        let instances = model.instances.iter().enumerate();
        let shown = instances.filter(|(number, _)| left_out.iter().any(|left_out| !left_out.contains(number)));
        let model_use = &uses[&Arc::as_ptr(model)];
        nodes.extend(shown.filter_map(|(_, part)| Some((whole.object, model_use.node_of(part)?))));
    }
    nodes
}
