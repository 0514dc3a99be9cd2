//! Models of formats without animations whose nodes and materials have other values than those of the file.

use glam::DAffine3;

use super::{
    model::Model,
    motion::{EditedParts, MaterialMotion, Motion, MotionNode, PartMotion, Trs},
};

/// The motion of a model of a format without animations, of which these parts are edited.
pub fn motion(model: &Model, edited: &EditedParts) -> Motion {
    let mut motion = Motion::default();
    let names = model.names_of_nodes();
    // A part of the model moves and vanishes with the nodes above it.
    let (mut moves, mut switches) = (Vec::new(), Vec::new());
    for (number, (node, name)) in model.nodes.iter().zip(&names).enumerate() {
        let parent = node.parent.filter(|parent| *parent < number);
        let (is_moved, is_switched) = (edited.moved.contains(name), edited.switched.contains(name));
        moves.push(is_moved || parent.is_some_and(|parent| moves[parent]));
        switches.push(is_switched || parent.is_some_and(|parent| switches[parent]));
        if is_moved || is_switched {
            motion.named_nodes.insert(name.clone(), number);
        }
        motion.nodes.push(MotionNode {
            parent,
            parent_from_node: DAffine3::IDENTITY,
            animated: is_moved.then_some(Trs::IDENTITY),
            visible: true,
        });
    }
    for (part, instance) in model.instances.iter().enumerate() {
        let Some(node) = instance.node else { continue };
        if moves[node] {
            motion.parts.push(PartMotion {
                part,
                node,
                node_from_mesh: instance.model_from_mesh,
            });
        }
        if switches[node] {
            motion.switched.push((part, node));
        }
    }
    for (name, number) in model.names_of_materials() {
        if let Some(number) = number.filter(|_| edited.materials.contains(&name)) {
            motion.named_materials.insert(name, motion.materials.len());
            let surface = model.materials[number].surface;
            motion.materials.push(MaterialMotion::of_surface(number, surface));
        }
    }
    motion
}
