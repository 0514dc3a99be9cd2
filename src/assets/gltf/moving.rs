//! The nodes, meshes, lights, cameras and materials that the played animations of a document and values move.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::{
    animations::Played,
    document::Document,
    edited::EditedNumbers,
    materials::MovingLooks,
    nodes::{self, PlacedNode},
};
use crate::assets::motion::{MotionNode, Target};

/// The nodes and meshes that the played animations and values move.
#[derive(Default)]
pub(super) struct Moving {
    /// The place of each node of the document among the placed ones.
    places: HashMap<usize, usize>,
    /// Whether each placed node moves, by itself or with those above it.
    moves: Vec<bool>,
    /// Whether each placed node may vanish, by itself or with those above it.
    switches: Vec<bool>,
    /// The nodes and the meshes of the document whose weights are animated.
    weighted: (HashSet<usize>, HashSet<usize>),
}

impl Moving {
    pub fn new(placed: &[PlacedNode], played: &[Played], edited: &EditedNumbers) -> Self {
        let mut moving = Self {
            places: placed
                .iter()
                .enumerate()
                .map(|(place, node)| (node.index, place))
                .collect(),
            ..Self::default()
        };
        let mut own = edited.moved().clone();
        for channel in played.iter().flat_map(|clip| &clip.channels) {
            match channel.moved {
                Target::Translation(node) | Target::Rotation(node) | Target::Scale(node) => {
                    own.insert(node);
                }
                Target::NodeWeights(node) => {
                    moving.weighted.0.insert(node);
                }
                Target::MeshWeights(mesh) => {
                    moving.weighted.1.insert(mesh);
                }
                Target::Material(..) | Target::Texture(..) | Target::Light(..) | Target::Camera(..) => {}
            }
        }
        for node in placed {
            let above = |of: &[bool]| node.parent.is_some_and(|parent| of[parent]);
            let (moves, switches) = (above(&moving.moves), above(&moving.switches));
            moving.moves.push(moves || own.contains(&node.index));
            moving.switches.push(switches || edited.switches(node.index));
        }
        moving
    }

    /// The place of a node of the document among the placed ones.
    pub fn place_of(&self, node: usize) -> Option<usize> {
        self.places.get(&node).copied()
    }

    /// Whether a placed node moves.
    pub fn moves(&self, place: usize) -> bool {
        self.moves[place]
    }

    /// Whether a placed node may vanish.
    pub fn switches(&self, place: usize) -> bool {
        self.switches[place]
    }

    /// The places of the nodes that values replace, by their names.
    pub fn named_nodes(&self, edited: &EditedNumbers) -> HashMap<String, usize> {
        let named = edited.nodes();
        named
            .filter_map(|(name, node)| Some((name.clone(), self.place_of(*node)?)))
            .collect()
    }

    /// Whether the weights of a mesh at a node are animated, where `has_own` tells whether those at rest are the node's own.
    pub fn is_weighted(&self, node: usize, mesh: usize, has_own: bool) -> bool {
        let (nodes, meshes) = &self.weighted;
        nodes.contains(&node) || !has_own && meshes.contains(&mesh)
    }

    /// The nodes of the motion. `hidden` are the nodes of the document that are not visible at rest.
    pub fn nodes(
        &self,
        document: &Document<'_>,
        placed: &[PlacedNode],
        (played, edited): (&[Played], &EditedNumbers),
        hidden: &BTreeSet<usize>,
    ) -> Vec<MotionNode> {
        let channels = played.iter().flat_map(|clip| &clip.channels);
        let replaced = channels.filter_map(|channel| match channel.moved {
            Target::Translation(node) | Target::Rotation(node) | Target::Scale(node) => Some(node),
            _ => None,
        });
        let replaced: HashSet<usize> = replaced.chain(edited.moved().iter().copied()).collect();
        let node = |node: &PlacedNode| MotionNode {
            parent: node.parent,
            parent_from_node: node.parent_from_node,
            animated: (replaced.contains(&node.index)).then(|| nodes::parts(&document.raw["nodes"][node.index])),
            visible: !hidden.contains(&node.index),
        };
        placed.iter().map(node).collect()
    }

    /// The target of a channel in the motion; `None` if it is not shown.
    pub fn target(&self, moved: &Target, looks: &MovingLooks) -> Option<Target> {
        Some(match *moved {
            Target::Translation(node) => Target::Translation(self.place_of(node)?),
            Target::Rotation(node) => Target::Rotation(self.place_of(node)?),
            Target::Scale(node) => Target::Scale(self.place_of(node)?),
            Target::NodeWeights(node) => Target::NodeWeights(self.place_of(node)?),
            Target::MeshWeights(mesh) => Target::MeshWeights(mesh),
            Target::Material(material, property) => Target::Material(*looks.material_places.get(&material)?, property),
            Target::Texture(material, key, property) => {
                Target::Texture(*looks.texture_places.get(&(material, key))?, key, property)
            }
            Target::Light(light, property) => Target::Light(light, property),
            Target::Camera(camera, property) => Target::Camera(camera, property),
        })
    }
}
