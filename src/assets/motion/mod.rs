//! The motion of a model: the animations that are played, and the pose of the model at a time.
//!
//! A model keeps its animations with everything that they move, so a pose costs no parsing. A pose depends on the time alone.

mod deform;
mod edits;
mod factors;
mod looks;
mod textures;

use std::collections::{HashMap, HashSet};

use glam::{DAffine3, DQuat, DVec3};

use super::views::{ModelCamera, ModelLight};
use crate::{material::principled::Principled, math::keys::Keys, shape::mesh::Playback, texture::StTransform};

pub use deform::{Deform, Influences, MeshShape, MorphTarget};
pub use edits::{EditedParts, FactorEdit, ModelEdits, NewNumbers, NewRotation, NodeEdit};
pub use factors::{Factor, FactorRange, MaterialMotion, MaterialProperty};
pub use looks::{CameraProperty, LightParameters, LightProperty, LightShape};
pub use textures::{TextureMotion, TextureProperty, texture_property};

/// An animation of a model file.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelClip {
    /// Unique in the file.
    pub name: String,
    /// The time of its last key, in s; NaN if that cannot be read.
    pub length: f32,
    /// The number of things of each sort that it moves, such as 3 nodes.
    pub moves: Vec<(&'static str, usize)>,
}

/// A translation, a rotation and a scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trs {
    pub translation: DVec3,
    pub rotation: DQuat,
    pub scale: DVec3,
}

impl Trs {
    pub const IDENTITY: Self = Self {
        translation: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
        scale: DVec3::ONE,
    };

    pub fn affine(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// A node of the shown scene.
#[derive(Clone, Debug)]
pub struct MotionNode {
    /// An index into [`Motion::nodes`], which is less than its own.
    pub parent: Option<usize>,
    /// The transform at rest.
    pub parent_from_node: DAffine3,
    /// The parts of that transform, if an animation or a value replaces one of them.
    pub animated: Option<Trs>,
    /// Whether it is visible at rest, if those above it are.
    pub visible: bool,
}

/// The target of a channel. Nodes and materials are indices into [`Motion::nodes`] and [`Motion::materials`]; meshes, lights and
/// cameras are those of the file. While a glTF file is read, all of them are numbers of the document.
#[derive(Clone, Debug)]
pub enum Target {
    Translation(usize),
    Rotation(usize),
    Scale(usize),
    NodeWeights(usize),
    MeshWeights(usize),
    Material(usize, MaterialProperty),
    /// The reference of a material to a texture, by its key; an index into [`Motion::textures`].
    Texture(usize, &'static str, TextureProperty),
    Light(usize, LightProperty),
    Camera(usize, CameraProperty),
}

/// Numbers over time, and what they move.
#[derive(Clone, Debug)]
pub struct Channel {
    pub target: Target,
    pub keys: Keys,
}

/// An animation that is played.
#[derive(Clone, Debug, Default)]
pub struct Clip {
    pub channels: Vec<Channel>,
    /// The time of the last key, in s.
    pub end: f32,
}

/// Joints, and the transforms into their spaces.
#[derive(Clone, Debug)]
pub struct Skin {
    /// An index into [`Motion::nodes`], and the transform from the space of the mesh.
    pub joints: Vec<(usize, DAffine3)>,
}

/// A part of the model whose node moves.
#[derive(Clone, Copy, Debug)]
pub struct PartMotion {
    /// An index into [`Model::instances`](super::model::Model::instances).
    pub part: usize,
    pub node: usize,
    /// The transform of a copy of the mesh within its node.
    pub node_from_mesh: DAffine3,
}

/// A mesh that deforms.
#[derive(Clone, Debug)]
pub struct MeshMotion {
    /// An index into [`Model::meshes`](super::model::Model::meshes).
    pub mesh: usize,
    pub node: usize,
    /// The mesh of the file, whose weights count where the node has none.
    pub source: usize,
    /// An index into [`Motion::skins`].
    pub skin: Option<usize>,
    /// The weights of its targets at rest.
    pub weights: Vec<f32>,
    pub has_own_weights: bool,
    pub deform: Deform,
}

/// A camera or a light of the model.
#[derive(Clone, Copy, Debug)]
pub struct Carried<T> {
    pub node: usize,
    /// The number in the file.
    pub source: usize,
    pub at_rest: T,
}

/// The motion of a model by the animations that are played, and by the values that replace its own.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// The nodes of the shown scene, parents first.
    pub nodes: Vec<MotionNode>,
    pub clips: Vec<Clip>,
    pub skins: Vec<Skin>,
    pub parts: Vec<PartMotion>,
    pub meshes: Vec<MeshMotion>,
    /// One for each of the model's cameras.
    pub cameras: Vec<Carried<ModelCamera>>,
    /// One for each of the model's lights.
    pub lights: Vec<Carried<LightParameters>>,
    pub materials: Vec<MaterialMotion>,
    /// The parts that may vanish, each with its node.
    pub switched: Vec<(usize, usize)>,
    /// The nodes and the materials that values replace, by their names.
    pub named_nodes: HashMap<String, usize>,
    pub named_materials: HashMap<String, usize>,
    pub textures: Vec<TextureMotion>,
}

/// The pose of a model at a time: all that differs from its rest pose.
#[derive(Clone, Debug, Default)]
pub struct ModelPose {
    /// New transforms of parts, by their indices into [`Model::instances`](super::model::Model::instances), in rising order.
    pub parts: Vec<(usize, DAffine3)>,
    /// New shapes of meshes, by their indices into [`Model::meshes`](super::model::Model::meshes).
    pub meshes: Vec<(usize, MeshShape)>,
    pub cameras: Vec<ModelCamera>,
    pub lights: Vec<ModelLight>,
    /// New surfaces of materials, by their indices into [`Model::materials`](super::model::Model::materials).
    pub materials: Vec<(usize, Principled)>,
    /// The parts that are not visible.
    pub hidden: HashSet<usize>,
    /// New transforms of textures, by their indices into [`Model::textures`](super::model::Model::textures).
    pub textures: Vec<(usize, StTransform)>,
}

/// The numbers of all channels at a time.
struct Animated<'a> {
    motion: &'a Motion,
    nodes: Vec<Option<Trs>>,
    node_weights: HashMap<usize, Vec<f32>>,
    mesh_weights: HashMap<usize, Vec<f32>>,
    model_from_node: Vec<DAffine3>,
    visible: Vec<bool>,
}

impl Motion {
    /// The time of the last key, in s.
    pub fn end(&self) -> f32 {
        self.clips.iter().map(|clip| clip.end).fold(0.0, f32::max)
    }

    /// Whether a camera of the model moves or changes, by its index.
    pub fn moves_camera(&self, camera: usize) -> bool {
        let Carried { node, source, .. } = self.cameras[camera];
        let mut line = std::iter::successors(Some(node), |node| self.nodes[*node].parent);
        let channels = self.clips.iter().flat_map(|clip| &clip.channels);
        let is_of = |channel: &Channel| matches!(channel.target, Target::Camera(camera, _) if camera == source);
        line.any(|node| self.nodes[node].animated.is_some()) || channels.into_iter().any(is_of)
    }

    /// The bytes of its arrays.
    pub fn bytes(&self) -> u64 {
        let channels = self.clips.iter().flat_map(|clip| &clip.channels);
        let keys: u64 = channels.map(|channel| channel.keys.bytes()).sum();
        keys + self.meshes.iter().map(|mesh| mesh.deform.bytes()).sum::<u64>()
    }

    /// The time within each animation at `time`, in s.
    pub fn local_times(&self, playback: &Playback, time: f64) -> impl Iterator<Item = f32> {
        let clips = self.clips.iter();
        clips.map(move |clip| playback.local_time(f64::from(clip.end), time) as f32)
    }

    /// All channels with their times within their animations.
    fn channels(&self, playback: &Playback, time: f64) -> impl Iterator<Item = (&Channel, f32)> {
        let timed = self.clips.iter().zip(self.local_times(playback, time));
        timed.flat_map(|(clip, time)| clip.channels.iter().map(move |channel| (channel, time)))
    }

    fn animated(&self, playback: &Playback, edits: &ModelEdits, time: f64) -> Animated<'_> {
        let mut animated = Animated {
            motion: self,
            nodes: self.nodes.iter().map(|node| node.animated).collect(),
            node_weights: HashMap::new(),
            mesh_weights: HashMap::new(),
            model_from_node: Vec::with_capacity(self.nodes.len()),
            visible: self.nodes.iter().map(|node| node.visible).collect(),
        };
        for (Channel { target, keys }, time) in self.channels(playback, time) {
            let vector = || DVec3::from_array(keys.array(time));
            let weights = || keys.at(time).map(|weight| weight as f32).collect();
            let mut set = |node: usize, change: &dyn Fn(&mut Trs)| animated.nodes[node].as_mut().map(change);
            match *target {
                Target::Translation(node) => _ = set(node, &|trs| trs.translation = vector()),
                Target::Rotation(node) => _ = set(node, &|trs| trs.rotation = keys.rotation(time)),
                Target::Scale(node) => _ = set(node, &|trs| trs.scale = vector()),
                Target::NodeWeights(node) => {
                    animated.node_weights.insert(node, weights());
                }
                Target::MeshWeights(mesh) => {
                    animated.mesh_weights.insert(mesh, weights());
                }
                Target::Material(..) | Target::Texture(..) | Target::Light(..) | Target::Camera(..) => {}
            }
        }
        for (node, edit) in &edits.nodes {
            if let (Some(trs), Some(rest)) = (&mut animated.nodes[*node], &self.nodes[*node].animated) {
                edit.apply(trs, rest);
            }
            animated.visible[*node] = edit.visible.unwrap_or(animated.visible[*node]);
        }
        for (at, node) in self.nodes.iter().enumerate() {
            animated.visible[at] &= node.parent.is_none_or(|parent| animated.visible[parent]);
        }
        for (node, trs) in self.nodes.iter().zip(&animated.nodes) {
            let own = trs.as_ref().map_or(node.parent_from_node, Trs::affine);
            let parent = node.parent.map(|parent| animated.model_from_node[parent]);
            animated.model_from_node.push(parent.map_or(own, |parent| parent * own));
        }
        animated
    }

    /// The surfaces of the materials that change, by their indices into [`Model::materials`](super::model::Model::materials).
    pub fn surfaces(&self, playback: &Playback, edits: &ModelEdits, time: f64) -> Vec<(usize, Principled)> {
        let mut materials: Vec<MaterialMotion> = self.materials.clone();
        for (Channel { target, keys }, time) in self.channels(playback, time) {
            if let Target::Material(material, property) = *target {
                materials[material].animate(property, keys, time);
            }
        }
        for (material, FactorEdit { factor, numbers }) in &edits.materials {
            materials[*material].set(factor, *numbers);
        }
        materials.into_iter().map(|m| (m.material, m.surface)).collect()
    }

    /// The transforms at `time`, in s, of textures that animations move.
    pub fn texture_transforms(&self, playback: &Playback, time: f64) -> Vec<(usize, StTransform)> {
        let mut textures: Vec<TextureMotion> = self.textures.clone();
        for (Channel { target, keys }, time) in self.channels(playback, time) {
            if let Target::Texture(texture, _, property) = *target {
                textures[texture].set(property, keys, time);
            }
        }
        textures.iter().map(|t| (t.texture, t.transform())).collect()
    }

    /// The pose at `time`, in s. Where `edits` and an animation give the same, `edits` counts.
    pub fn pose(&self, playback: &Playback, edits: &ModelEdits, time: f64) -> ModelPose {
        let animated = self.animated(playback, edits, time);
        let is_hidden = |(_, node): &&(usize, usize)| !animated.visible[*node];
        let mut pose = ModelPose {
            parts: self.parts.iter().map(|part| animated.part(part)).collect(),
            meshes: self.meshes.iter().map(|mesh| animated.mesh(mesh)).collect(),
            hidden: self.switched.iter().filter(is_hidden).map(|(part, _)| *part).collect(),
            ..ModelPose::default()
        };
        let mut lights: Vec<Carried<LightParameters>> = self.lights.clone();
        let mut cameras: Vec<Carried<ModelCamera>> = self.cameras.clone();
        for (Channel { target, keys }, time) in self.channels(playback, time) {
            match *target {
                Target::Light(source, property) => {
                    let lights = lights.iter_mut().filter(|light| light.source == source);
                    lights.for_each(|light| light.at_rest.set(property, keys, time));
                }
                Target::Camera(source, property) => {
                    let cameras = cameras.iter_mut().filter(|camera| camera.source == source);
                    cameras.for_each(|camera| property.set(&mut camera.at_rest.view, keys, time));
                }
                _ => {}
            }
        }
        for light in &mut lights {
            if !animated.visible[light.node] {
                light.at_rest.intensity = 0.0;
            }
        }
        let place = |node: usize| animated.model_from_node[node];
        pose.materials = self.surfaces(playback, edits, time);
        pose.textures = self.texture_transforms(playback, time);
        pose.lights = lights
            .iter()
            .map(|light| light.at_rest.light(place(light.node)))
            .collect();
        let moved = |camera: Carried<ModelCamera>| ModelCamera {
            model_from_camera: place(camera.node),
            ..camera.at_rest
        };
        pose.cameras = cameras.into_iter().map(moved).collect();
        pose
    }
}

impl Animated<'_> {
    fn part(&self, part: &PartMotion) -> (usize, DAffine3) {
        (part.part, self.model_from_node[part.node] * part.node_from_mesh)
    }

    fn mesh(&self, mesh: &MeshMotion) -> (usize, MeshShape) {
        let of_node = self.node_weights.get(&mesh.node);
        let of_mesh = self.mesh_weights.get(&mesh.source).filter(|_| !mesh.has_own_weights);
        let weights = of_node.or(of_mesh).unwrap_or(&mesh.weights);
        let joints: Option<Vec<DAffine3>> = mesh.skin.map(|skin| {
            let joints = self.motion.skins[skin].joints.iter();
            joints
                .map(|(node, joint_from_mesh)| self.model_from_node[*node] * *joint_from_mesh)
                .collect()
        });
        (mesh.mesh, mesh.deform.shape(weights, joints.as_deref()))
    }
}
