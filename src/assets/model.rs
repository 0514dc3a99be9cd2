//! The content of a model file in any format: meshes with their transforms and materials, cameras and lights.

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
    sync::Arc,
};

use glam::DAffine3;

use super::{
    displacement::Displacement,
    motion::{EditedParts, ModelClip, ModelEdits, ModelPose, Motion},
    points::PointCloud,
};
use crate::{
    material::principled::Principled,
    math::{DAabb, Rgb},
    shape::mesh::{Mesh, Playback},
    texture::{
        Color, StTransform,
        bitmap::ColorSpace,
        image::{TextureFilter, Wrap},
    },
    value::{one_line, unique_names, visible},
};

pub use super::views::{ModelCamera, ModelLight, ModelLightKind, ModelView};
pub use crate::shape::mesh::{AnimationChoice, LightUnits, SceneChoice, Subdivision};

/// The most triangles that a scene stores.
pub const MAX_TRIANGLES: u64 = 1 << 27;

/// The feature of models with animations.
pub const ANIMATIONS: &str = "animations";

/// The choice among the alternatives in a model file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ModelChoice {
    /// `None` for the default scene.
    pub scene: Option<SceneChoice>,
    /// The name of a material variant; `None` for the default materials.
    pub variant: Option<String>,
    /// Whether values choose variants at other times.
    pub is_varied: bool,
    /// Whether its lights shine; `None` where nobody decided.
    pub lights: Option<bool>,
    pub light_units: LightUnits,
    /// The animations that are played; `None` where nobody decided.
    pub animation: Option<AnimationChoice>,
    /// The nodes and materials of which values replace some.
    pub edited: EditedParts,
    /// The subdivision of its meshes, if they are subdivided.
    pub subdivision: Option<Subdivision>,
    /// The displacement after the subdivision.
    pub displacement: Option<Displacement>,
}

/// The faces that a loader keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceUse {
    /// Triangles alone.
    Triangles,
    /// [`Mesh::polygons`] as well.
    Polygons,
}

impl ModelChoice {
    /// The faces that it needs.
    pub fn face_use(&self) -> FaceUse {
        match &self.subdivision {
            Some(how) if how.reads_polygons() => FaceUse::Polygons,
            _ => FaceUse::Triangles,
        }
    }
}

/// A model, in its own space: right-handed, +y up, metres.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Valid meshes with at least one triangle. Models in other poses and of other selections of nodes share them.
    pub meshes: Vec<Arc<Mesh>>,
    pub instances: Vec<MeshInstance>,
    pub points: Option<PointCloud>,
    /// The file's hierarchy; empty if the format has none.
    pub nodes: Vec<ModelNode>,
    pub materials: Vec<ModelMaterial>,
    /// The unique names of all materials of the file, each with its index in [`Model::materials`] if it is shown;
    /// `None` if these are all materials.
    pub named_materials: Option<Vec<(String, Option<usize>)>>,
    /// The parts that are not visible.
    pub hidden: HashSet<usize>,
    pub textures: Vec<ModelTexture>,
    pub images: Vec<ImageSource>,
    pub cameras: Vec<ModelCamera>,
    pub lights: Vec<ModelLight>,
    /// The node of each light, an index into [`Model::nodes`].
    pub light_nodes: Vec<usize>,
    /// The names of the file's material variants.
    pub variants: Vec<String>,
    /// All animations of the file, in its order.
    pub clips: Vec<ModelClip>,
    /// The motion by those animations that are played and by values; `None` if it has neither.
    pub motion: Option<Arc<Motion>>,
    /// The features that the file uses, each once.
    pub features: Vec<ModelFeature>,
    /// Faults of the file that do not prevent rendering.
    pub faults: Vec<String>,
}

impl Model {
    /// Counts a use of a feature.
    pub fn add_feature(&mut self, name: &str, used_by: &'static str, treatment: Treatment) {
        let known = self
            .features
            .iter_mut()
            .find(|f| f.name == name && f.used_by == used_by && f.treatment == treatment);
        match known {
            Some(feature) => feature.count += 1,
            None => self.features.push(ModelFeature {
                name: name.to_owned(),
                count: 1,
                used_by,
                treatment,
            }),
        }
    }

    /// The warning about a feature of this model, if it is not rendered.
    pub fn loss(&self, feature: &ModelFeature) -> Option<String> {
        let loss = feature.loss()?;
        if feature.name != ANIMATIONS {
            return Some(loss);
        }
        let names = self.clips.iter().map(|clip| format!("`{}`", one_line(&clip.name, 80)));
        let names = names.collect::<Vec<_>>().join(", ");
        let names = one_line(&names, 400);
        Some(format!(
            "{loss}: {names}; `animation` of the mesh or --animation plays them"
        ))
    }

    /// The bytes of its arrays.
    pub fn bytes(&self) -> u64 {
        let points = self.points.as_ref().map_or(0, PointCloud::bytes);
        let motion = self.motion.as_ref().map_or(0, |motion| motion.bytes());
        self.meshes.iter().map(|mesh| mesh.bytes()).sum::<u64>() + points + motion
    }
}

/// A mesh under a transform.
#[derive(Clone, Debug)]
pub struct MeshInstance {
    /// An index into [`Model::meshes`].
    pub mesh: usize,
    /// An index into [`Model::materials`].
    pub material: usize,
    /// An index into [`Model::nodes`].
    pub node: Option<usize>,
    /// Possibly mirrored or singular.
    pub model_from_mesh: DAffine3,
}

/// A node of the file's hierarchy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelNode {
    /// May be empty.
    pub name: String,
    /// An index into [`Model::nodes`]; `None` at the top.
    pub parent: Option<usize>,
}

/// A material as a model file describes it.
#[derive(Clone, Debug)]
pub struct ModelMaterial {
    /// May be empty.
    pub name: String,
    /// Its [`TextureId`](crate::texture::TextureId)s are indices into [`Model::textures`].
    pub surface: Principled,
    /// Whether the file says that its backs are not seen.
    pub is_one_sided: bool,
}

impl Default for ModelMaterial {
    /// White and matte, without a texture.
    fn default() -> Self {
        Self {
            name: String::new(),
            surface: Principled::matte(Color::Constant(Rgb::WHITE)),
            is_one_sided: false,
        }
    }
}

/// An image with the parameters of its lookup.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelTexture {
    /// An index into [`Model::images`].
    pub image: usize,
    pub color_space: ColorSpace,
    pub filter: TextureFilter,
    /// Along s and along t.
    pub wrap: [Wrap; 2],
    /// The transform of s and t.
    pub transform: StTransform,
    pub uv_set: UvSet,
}

impl ModelTexture {
    /// A colour texture that is repeated and filtered.
    pub fn of_image(image: usize) -> Self {
        Self {
            image,
            color_space: ColorSpace::Srgb,
            filter: TextureFilter::Trilinear,
            wrap: [Wrap::Repeat; 2],
            transform: StTransform::IDENTITY,
            uv_set: UvSet::First,
        }
    }
}

/// The texture coordinates of a [`Mesh`] that a texture reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum UvSet {
    /// [`Mesh::uvs`].
    #[default]
    First,
    /// [`Mesh::second_uvs`].
    Second,
}

/// A feature of a file format that a model uses, and its treatment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelFeature {
    /// The name in the format.
    pub name: String,
    /// The number of its users, and what these are, in the singular.
    pub count: usize,
    pub used_by: &'static str,
    pub treatment: Treatment,
}

/// The treatment of a feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Treatment {
    Rendered,
    /// Not needed for a correct picture, for this reason.
    Unneeded(&'static str),
    /// Rendered except for this part.
    InPart(&'static str),
    /// Not rendered; the text says what is shown instead, and may be empty.
    Without(&'static str),
}

impl ModelFeature {
    /// The warning about a feature that is not rendered: `not rendered: KHR_X, used by 3 materials`.
    pub fn loss(&self) -> Option<String> {
        let (how, detail) = match self.treatment {
            Treatment::Rendered | Treatment::Unneeded(_) => return None,
            Treatment::InPart(part) => ("rendered in part", part),
            Treatment::Without(instead) => ("not rendered", instead),
        };
        let detail = match detail {
            "" => String::new(),
            detail => format!(" ({detail})"),
        };
        let users = match self.count {
            1 => format!("1 {}", self.used_by),
            count => format!("{count} {}", plural(self.used_by)),
        };
        Some(if self.name == plural(self.used_by) {
            format!("{how}: {users}{detail}")
        } else {
            format!("{how}: {}, used by {users}{detail}", visible(&self.name))
        })
    }
}

/// The plural of a word of this module.
fn plural(word: &str) -> String {
    match word {
        "mesh" => "meshes".to_owned(),
        _ => format!("{word}s"),
    }
}

/// The source of an image's bytes.
#[derive(Clone, Debug, PartialEq)]
pub enum ImageSource {
    File(PathBuf),
    Bytes {
        /// The name of the image in errors.
        name: PathBuf,
        bytes: Arc<[u8]>,
    },
}

impl ImageSource {
    /// Its file, or its name in errors.
    pub fn name(&self) -> &Path {
        let (Self::File(name) | Self::Bytes { name, .. }) = self;
        name
    }
}

impl Model {
    /// Whether it has no geometry.
    pub fn is_empty(&self) -> bool {
        self.instances.is_empty() && self.points.is_none()
    }

    /// The unique names of all nodes.
    pub fn names_of_nodes(&self) -> Vec<String> {
        unique_names(self.nodes.iter().map(|node| node.name.as_str()))
    }

    /// The unique names of all materials of the file, each with its index in [`Model::materials`] if it is shown.
    pub fn names_of_materials(&self) -> Vec<(String, Option<usize>)> {
        let of_shown = || {
            let names = unique_names(self.materials.iter().map(|material| material.name.as_str()));
            names.into_iter().zip((0..).map(Some)).collect()
        };
        self.named_materials.clone().unwrap_or_else(of_shown)
    }

    /// The pose at `time`, in s; `None` for a model without motion.
    pub fn pose(&self, playback: &Playback, edits: &ModelEdits, time: f64) -> Option<ModelPose> {
        self.motion.as_ref().map(|motion| motion.pose(playback, edits, time))
    }

    /// The parts that move, deform or may vanish: for each the number of its node, and its transform within the node if that moves.
    pub fn movers(&self) -> Vec<Option<(Option<usize>, DAffine3)>> {
        let mut movers = vec![None; self.instances.len()];
        let Some(motion) = &self.motion else {
            return movers;
        };
        let deforming: HashSet<usize> = motion.meshes.iter().map(|mesh| mesh.mesh).collect();
        for (mover, part) in movers.iter_mut().zip(&self.instances) {
            *mover = deforming
                .contains(&part.mesh)
                .then_some((part.node, DAffine3::IDENTITY));
        }
        for (part, _) in &motion.switched {
            movers[*part] = Some((self.instances[*part].node, self.instances[*part].model_from_mesh));
        }
        for part in &motion.parts {
            movers[part.part] = Some((self.instances[part.part].node, part.node_from_mesh));
        }
        movers
    }

    /// The same model in this pose.
    pub fn posed(&self, pose: ModelPose) -> Self {
        let mut model = self.clone();
        for (part, model_from_mesh) in pose.parts {
            model.instances[part].model_from_mesh = model_from_mesh;
        }
        for (mesh, shape) in pose.meshes {
            shape.apply(Arc::make_mut(&mut model.meshes[mesh]));
        }
        for (material, surface) in pose.materials {
            model.materials[material].surface = surface;
        }
        for (texture, transform) in pose.textures {
            model.textures[texture].transform = transform;
        }
        (model.cameras, model.lights) = (pose.cameras, pose.lights);
        model.hidden = pose.hidden;
        model
    }

    /// The bounds of all parts; empty if there are none.
    pub fn bounds(&self) -> DAabb {
        let own: Vec<DAabb> = self.meshes.iter().map(|mesh| mesh.bounds().into()).collect();
        let placed = |part: &MeshInstance| own[part.mesh].transformed(&part.model_from_mesh);
        let points = self.points.iter();
        let points = points.map(|p| DAabb::from(p.bounds()).transformed(&p.model_from_points));
        (self.instances.iter().map(placed).chain(points)).fold(DAabb::EMPTY, DAabb::union)
    }
}
