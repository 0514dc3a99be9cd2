//! Nodes: the tree is checked, then walked without recursion.

use std::collections::BTreeSet;

use ::gltf::json::{Value, scene::Node};
use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::{
    document::{Document, get},
    edited::EditedNumbers,
    error::GltfProblem,
    json::doubles,
};
use crate::{
    assets::{
        model::{ModelNode, SceneChoice},
        motion::Trs,
    },
    math::{keys, sorting},
    value::UnknownName,
};

/// A node of the shown scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedNode {
    /// Its number in the document.
    pub index: usize,
    /// The place of its parent among the placed nodes.
    pub parent: Option<usize>,
    pub parent_from_node: DAffine3,
    pub model_from_node: DAffine3,
}

/// The nodes of a document and the parent of each.
pub(super) struct Hierarchy<'a> {
    nodes: &'a [Node],
    parents: Vec<Option<usize>>,
}

impl<'a> Hierarchy<'a> {
    pub fn new(document: &'a Document<'_>) -> Result<Self, GltfProblem> {
        let nodes = &document.root.nodes;
        let parents = parents(nodes)?;
        Ok(Self { nodes, parents })
    }

    /// All nodes by name, in the order of the document.
    pub fn names(&self) -> Vec<ModelNode> {
        let named = |(node, parent): (&Node, &Option<usize>)| ModelNode {
            name: node.name.clone().unwrap_or_default(),
            parent: *parent,
        };
        self.nodes.iter().zip(&self.parents).map(named).collect()
    }

    /// The nodes that KHR_node_visibility hides.
    pub fn hidden(&self, document: &Document<'_>) -> BTreeSet<usize> {
        let is_hidden = |node: &usize| {
            let path = format!("/nodes/{node}/extensions/KHR_node_visibility/visible");
            document.raw.pointer(&path).and_then(Value::as_bool) == Some(false)
        };
        sorting::ordered((0..self.nodes.len()).filter(is_hidden))
    }

    /// Whether a node and all nodes above it are visible, where these are `hidden`, or may become so.
    pub fn may_be_visible(&self, hidden: &BTreeSet<usize>, edited: &EditedNumbers, node: usize) -> bool {
        let mut line = std::iter::successors(Some(node), |n| self.parents[*n]);
        line.all(|node| !hidden.contains(&node) || edited.switches(node))
    }

    /// The nodes of the document's scene, parents first.
    pub fn placed(&self, document: &Document<'_>, scene: Option<&SceneChoice>) -> Result<Vec<PlacedNode>, GltfProblem> {
        let mut stack: Vec<(usize, Option<usize>)> = Vec::new();
        let roots = roots(document, scene, &self.parents)?;
        stack.extend(roots.into_iter().rev().map(|i| (i, None)));
        let mut seen = vec![false; self.nodes.len()];
        let mut out: Vec<PlacedNode> = Vec::new();
        while let Some((index, parent)) = stack.pop() {
            // A scene may name a node twice, or a node and its parent.
            if std::mem::replace(&mut seen[index], true) {
                continue;
            }
            let model_from_parent = parent.map_or(DAffine3::IDENTITY, |parent| out[parent].model_from_node);
            let parent_from_node = local(&document.raw["nodes"][index], index)?;
            let model_from_node = model_from_parent * parent_from_node;
            if !model_from_node.is_finite() {
                return Err(GltfProblem::broken(format!(
                    "node {index} is infinitely large or far away"
                )));
            }
            let children = self.nodes[index].children.iter().flatten();
            stack.extend(children.rev().map(|c| (c.value(), Some(out.len()))));
            out.push(PlacedNode {
                index,
                parent,
                parent_from_node,
                model_from_node,
            });
        }
        Ok(out)
    }
}

/// The parent of each node; every node has one at most, and none is its own ancestor.
fn parents(nodes: &[Node]) -> Result<Vec<Option<usize>>, GltfProblem> {
    let mut parents = vec![None; nodes.len()];
    for (i, node) in nodes.iter().enumerate() {
        for child in node.children.iter().flatten().map(|c| c.value()) {
            get(nodes, child, "node").map_err(|e| e.within(&format!("node {i}")))?;
            if let Some(other) = parents[child].replace(i) {
                return Err(GltfProblem::broken(format!(
                    "node {child} is a child of both node {other} and node {i}"
                )));
            }
        }
    }
    // Nodes that cannot be reached from a root are on a cycle or below one.
    let mut reached = vec![false; nodes.len()];
    let mut stack: Vec<usize> = (0..nodes.len()).filter(|i| parents[*i].is_none()).collect();
    while let Some(i) = stack.pop() {
        reached[i] = true;
        stack.extend(nodes[i].children.iter().flatten().map(|c| c.value()));
    }
    match reached.iter().position(|r| !r) {
        None => Ok(parents),
        Some(below) => {
            // After as many steps up as there are nodes, the walk is on the cycle.
            let on_cycle = (0..nodes.len()).fold(below, |i, _| parents[i].unwrap_or(i));
            Err(GltfProblem::broken(format!("node {on_cycle} is its own ancestor")))
        }
    }
}

/// The roots of the chosen scene, else of the default one, else of the first; without scenes all nodes without a parent.
fn roots(
    document: &Document<'_>,
    choice: Option<&SceneChoice>,
    parents: &[Option<usize>],
) -> Result<Vec<usize>, GltfProblem> {
    let root = &document.root;
    let scene = match (choice, root.scene) {
        (Some(SceneChoice::Number(index)), _) => Some(get(&root.scenes, *index, "scene")?),
        (Some(SceneChoice::Name(name)), _) => {
            let found = root.scenes.iter().find(|s| s.name.as_ref() == Some(name));
            Some(found.ok_or_else(|| {
                let known: Vec<&str> = root.scenes.iter().filter_map(|s| s.name.as_deref()).collect();
                let unknown = UnknownName::new("scene", name, known.iter().copied());
                GltfProblem::UnknownName(if known.is_empty() {
                    unknown.with_fallback(Some("the model has no scene with a name".to_owned()))
                } else {
                    unknown
                })
            })?)
        }
        (None, Some(scene)) => Some(get(&root.scenes, scene.value(), "scene")?),
        (None, None) => root.scenes.first(),
    };
    let Some(scene) = scene else {
        return Ok((0..parents.len()).filter(|i| parents[*i].is_none()).collect());
    };
    let index = |node: usize| get(&root.nodes, node, "node").map(|_| node);
    scene.nodes.iter().map(|n| index(n.value())).collect()
}

/// The transform of a node relative to its parent, in the double precision of its text.
fn local(node: &Value, index: usize) -> Result<DAffine3, GltfProblem> {
    if node.get("matrix").is_some() {
        let m = DMat4::from_cols_array(&doubles(node, "matrix", DMat4::IDENTITY.to_cols_array()));
        // Compared in single precision, which exporters write.
        if m.row(3).as_vec4() != glam::Vec4::W {
            return Err(GltfProblem::broken(format!("the matrix of node {index} is not affine")));
        }
        return Ok(DAffine3::from_mat4(m));
    }
    Ok(parts(node).affine())
}

/// The parts of the transform of a node, of a matrix those that it is made of.
pub(super) fn parts(node: &Value) -> Trs {
    if node.get("matrix").is_some() {
        let m = DMat4::from_cols_array(&doubles(node, "matrix", DMat4::IDENTITY.to_cols_array()));
        let (scale, rotation, translation) = m.to_scale_rotation_translation();
        return Trs {
            translation,
            rotation: keys::normalized(rotation),
            scale,
        };
    }
    // Exporters round.
    let rotation = DQuat::from_array(doubles(node, "rotation", [0.0, 0.0, 0.0, 1.0]));
    Trs {
        translation: DVec3::from_array(doubles(node, "translation", [0.0; 3])),
        rotation: keys::normalized(rotation),
        scale: DVec3::from_array(doubles(node, "scale", [1.0; 3])),
    }
}
