//! The options of a scene that is loaded.

use std::collections::{BTreeMap, BTreeSet};

use super::Instancing;
use crate::{assets::motion::EditedParts, math::DVec3};

/// The options on which the arrays of a scene depend, beside its description.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    pub instancing: Instancing,
    /// The first position of the camera if it is not that of the scene's own camera. In a large scene, positions near it are the
    /// most precise.
    pub eye: Option<DVec3>,
    /// The origin of the scene; `None` for that which suits it.
    pub origin: Option<DVec3>,
    /// The objects that move at some time, by their indices. They are never baked into the world.
    pub moved: BTreeSet<usize>,
    /// The nodes and materials of models whose values change over time, by the indices of objects.
    pub edited: BTreeMap<usize, EditedParts>,
    /// The objects that play other animations over time, by their indices.
    pub animated: BTreeSet<usize>,
    /// The objects that show other variants of their models over time, by their indices.
    pub varied: BTreeSet<usize>,
    /// Whether values of materials change over time.
    pub changes_materials: bool,
    /// The time of the animations of models, in s.
    pub time: f64,
}
