//! The parts of objects that are not visible, and the choice between instances and baked parts, on which their order depends.

use super::{ModelPlacer, PlacedParts};
use crate::{material::EmissionReach, math::Transform, scene::NodeId};

impl ModelPlacer<'_> {
    /// Adds the nodes that parts would have if their object were visible, to those that would be baked, or be instances.
    pub(super) fn hide(
        &self,
        copy: &PlacedParts<'_>,
        has_group: bool,
        [baked, instances]: &mut [Vec<Option<NodeId>>; 2],
    ) {
        let nodes = copy.parts.iter().map(|part| copy.model_use.node_of(part));
        match (self.instance_transform(copy, has_group), copy.node) {
            (None, _) => baked.extend(nodes),
            (Some(_), None) => instances.extend(nodes),
            (Some(_), node) => instances.push(node),
        }
    }

    /// The transform of parts as an instance; `None` if they cannot be one.
    pub(super) fn instance_transform(&self, copy: &PlacedParts<'_>, has_group: bool) -> Option<Transform> {
        let transform = copy.placed.transform(&copy.model_from_group, copy.object_from_group);
        transform.filter(|_| has_group && !self.emits(copy))
    }

    /// Whether parts emit light that is sampled by triangle.
    pub(super) fn emits(&self, copy: &PlacedParts<'_>) -> bool {
        copy.parts.iter().any(|part| {
            let material = copy.model_use.material(part.material, copy.placed.material);
            let emission = self.scene.material_of(material).emission();
            emission.is_some_and(|e| e.reach == EmissionReach::Everything)
        })
    }
}
