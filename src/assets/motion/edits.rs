//! Values that replace those of a model's file: transforms and visibility of nodes, factors of materials.

use std::collections::BTreeSet;

use glam::{DMat3, DQuat, DVec3};

use super::{Factor, Trs};
use crate::math::{keys, transform};

/// The nodes and materials of a model of which values replace some, by their names. Which of them these are holds for a whole job.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct EditedParts {
    /// The nodes with a transform.
    pub moved: BTreeSet<String>,
    /// The nodes that appear and vanish.
    pub switched: BTreeSet<String>,
    pub materials: BTreeSet<String>,
}

impl EditedParts {
    pub fn is_empty(&self) -> bool {
        self.moved.is_empty() && self.switched.is_empty() && self.materials.is_empty()
    }

    /// Adds others.
    pub fn extend(&mut self, others: &Self) {
        self.moved.extend(others.moved.iter().cloned());
        self.switched.extend(others.switched.iter().cloned());
        self.materials.extend(others.materials.iter().cloned());
    }
}

/// New numbers of a vector; `None` keeps one.
pub type NewNumbers = [Option<f64>; 3];

/// A new rotation of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NewRotation {
    /// Degrees about the fixed x, y and z axes in this order; those that are not given are those of the rest pose.
    Angles(NewNumbers),
    /// Of length 1.
    Quaternion(DQuat),
}

/// New values of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NodeEdit {
    pub translation: NewNumbers,
    pub rotation: Option<NewRotation>,
    pub scale: NewNumbers,
    /// Whether the node and those below it are visible.
    pub visible: Option<bool>,
}

/// A new factor of a material; of a colour the numbers that are given.
#[derive(Clone, Copy, Debug)]
pub struct FactorEdit {
    pub factor: &'static Factor,
    pub numbers: [Option<f32>; 3],
}

/// New values of a model, by the indices of its nodes and materials.
#[derive(Clone, Debug, Default)]
pub struct ModelEdits {
    pub nodes: Vec<(usize, NodeEdit)>,
    pub materials: Vec<(usize, FactorEdit)>,
}

impl NodeEdit {
    /// Whether it changes the transform.
    pub fn moves(&self) -> bool {
        let is_given = |numbers: &NewNumbers| numbers.iter().any(Option::is_some);
        is_given(&self.translation) || self.rotation.is_some() || is_given(&self.scale)
    }

    /// Replaces parts of a transform, of which `rest` is that of the rest pose. A part of which no number is given stays.
    pub(super) fn apply(&self, trs: &mut Trs, rest: &Trs) {
        let replaced = |part: &mut DVec3, rest: DVec3, new: &NewNumbers| {
            if new.iter().any(Option::is_some) {
                *part = merged(rest, new);
            }
        };
        replaced(&mut trs.translation, rest.translation, &self.translation);
        replaced(&mut trs.scale, rest.scale, &self.scale);
        match &self.rotation {
            None => {}
            Some(NewRotation::Quaternion(rotation)) => trs.rotation = *rotation,
            Some(NewRotation::Angles(new)) => {
                let rest = match new.iter().all(Option::is_some) {
                    true => DVec3::ZERO,
                    false => transform::angles(DMat3::from_quat(rest.rotation)),
                };
                let rotation = transform::rotation(merged(rest, new));
                trs.rotation = keys::normalized(DQuat::from_mat3(&rotation));
            }
        }
    }
}

fn merged(old: DVec3, new: &NewNumbers) -> DVec3 {
    let old = old.to_array();
    DVec3::from_array(std::array::from_fn(|i| new[i].unwrap_or(old[i])))
}

impl ModelEdits {
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.materials.is_empty()
    }

    /// The bits of all numbers: equal edits have equal ones.
    pub fn bits(&self) -> Vec<u64> {
        let mut bits = self.bits_of_nodes();
        bits.extend(self.bits_of_materials());
        bits
    }

    /// The bits of the numbers of nodes.
    pub fn bits_of_nodes(&self) -> Vec<u64> {
        let number = |v: &Option<f64>| v.map_or(u64::MAX, f64::to_bits);
        let mut bits = Vec::new();
        for (node, edit) in &self.nodes {
            bits.push(*node as u64);
            bits.extend(edit.translation.iter().chain(&edit.scale).map(number));
            match &edit.rotation {
                None => bits.push(0),
                Some(NewRotation::Angles(angles)) => bits.extend(angles.iter().map(number)),
                Some(NewRotation::Quaternion(q)) => bits.extend(q.to_array().map(f64::to_bits)),
            }
            bits.push(edit.visible.map_or(u64::MAX, u64::from));
        }
        bits
    }

    /// The bits of the numbers of materials.
    pub fn bits_of_materials(&self) -> Vec<u64> {
        let mut bits = Vec::new();
        for (material, edit) in &self.materials {
            bits.extend([u64::MAX - 1, *material as u64]);
            bits.extend(edit.factor.name.bytes().map(u64::from));
            bits.extend(edit.numbers.map(|v| v.map_or(u64::MAX, |v| v.to_bits().into())));
        }
        bits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rest() -> Trs {
        Trs {
            translation: DVec3::new(1.0, 2.0, 3.0),
            rotation: DQuat::from_rotation_x(0.5),
            scale: DVec3::splat(2.0),
        }
    }

    #[test]
    fn channels_that_are_not_given_keep_the_rest_pose() {
        let mut trs = Trs::IDENTITY;
        let edit = NodeEdit {
            translation: [None, Some(9.0), None],
            rotation: Some(NewRotation::Angles([None, None, Some(90.0)])),
            ..NodeEdit::default()
        };
        edit.apply(&mut trs, &rest());
        assert_eq!(trs.translation, DVec3::new(1.0, 9.0, 3.0));
        assert_eq!(trs.scale, DVec3::ONE);
        let expected = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2) * rest().rotation;
        assert!(trs.rotation.dot(expected).abs() > 1.0 - 1e-15, "{}", trs.rotation);
    }

    #[test]
    fn angles_of_a_rotation_make_it_again() {
        for angles in [
            DVec3::ZERO,
            DVec3::new(10.0, 20.0, 30.0),
            DVec3::new(-170.0, 80.0, 100.0),
            DVec3::new(30.0, 90.0, 0.0),
            DVec3::new(30.0, -90.0, 0.0),
        ] {
            let found = transform::angles(transform::rotation(angles));
            assert!((found - angles).length() < 1e-10, "{angles}: {found}");
        }
    }
}
