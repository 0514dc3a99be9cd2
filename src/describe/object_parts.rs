//! The settings of some nodes of a model, in place of those of its object.

use serde::{Deserialize, Deserializer, de};

use super::LightGroupName;
use crate::{
    scene::{ObjectBackFaces, RayVisibility},
    value::Spanned,
};

/// The table `[[object.part]]`. What is not given is that of the object.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectPartDesc {
    /// Names of nodes, with wildcards; at least one.
    #[serde(deserialize_with = "some_nodes")]
    pub nodes: Vec<Spanned<String>>,
    pub material: Option<Spanned<String>>,
    pub visible: Option<bool>,
    pub ray_visibility: Option<RayVisibility>,
    pub holdout: Option<bool>,
    pub shadow_catcher: Option<Spanned<bool>>,
    pub lights: Option<Vec<Spanned<String>>>,
    pub exclude_lights: Option<Vec<Spanned<String>>>,
    pub group: Option<LightGroupName>,
    pub back_faces: Option<Spanned<ObjectBackFaces>>,
}

fn some_nodes<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Spanned<String>>, D::Error> {
    let nodes = Vec::<Spanned<String>>::deserialize(deserializer)?;
    if nodes.is_empty() {
        return Err(de::Error::custom(
            "a part needs the names of its nodes, such as [\"Wheel*\"]",
        ));
    }
    Ok(nodes)
}
