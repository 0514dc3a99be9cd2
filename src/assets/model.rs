//! The content of a model file in any format: meshes with their transforms and materials, cameras and lights.

use std::{path::PathBuf, sync::Arc};

use glam::DAffine3;

use crate::{
    math::{Aabb, Rgb},
    shape::mesh::Mesh,
    texture::image::{TextureFilter, Wrap},
};

/// A model, in its own space: right-handed, +y up, metres.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Valid, none of them without triangles.
    pub meshes: Vec<Mesh>,
    pub instances: Vec<MeshInstance>,
    /// The file's hierarchy; empty where its format has none.
    pub nodes: Vec<ModelNode>,
    pub materials: Vec<ModelMaterial>,
    pub textures: Vec<ModelTexture>,
    pub images: Vec<ImageSource>,
    pub cameras: Vec<ModelCamera>,
    pub lights: Vec<ModelLight>,
}

impl Model {
    /// The bytes of its arrays.
    pub fn bytes(&self) -> u64 {
        self.meshes.iter().map(Mesh::bytes).sum()
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
    /// May mirror, may even flatten.
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
    /// Reflectance, times the texture's colour where there is one.
    pub base_color: Rgb,
    /// An index into [`Model::textures`].
    pub base_texture: Option<usize>,
}

impl Default for ModelMaterial {
    /// White, without a texture.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Rgb::WHITE,
            base_texture: None,
        }
    }
}

/// An image and how it is looked up with the mesh's texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelTexture {
    /// An index into [`Model::images`].
    pub image: usize,
    pub filter: TextureFilter,
    /// Along s and along t.
    pub wrap: [Wrap; 2],
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

/// A camera: it looks along its own -z, +y is up.
#[derive(Clone, Copy, Debug)]
pub struct ModelCamera {
    pub model_from_camera: DAffine3,
    pub view: ModelView,
}

/// The view of a model's camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModelView {
    /// The angle over the picture's height, in radians.
    Perspective { fov: f64 },
    /// The height of what is seen, in m.
    Orthographic { height: f64 },
}

/// A light: it shines along its own -z.
#[derive(Clone, Copy, Debug)]
pub struct ModelLight {
    pub model_from_light: DAffine3,
    /// In W sr^-1; of a sun the irradiance on a surface that faces it, in W m^-2.
    pub strength: Rgb,
    pub kind: ModelLightKind,
}

/// The kind of a model's light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModelLightKind {
    Point,
    /// Half angles in radians: full light up to `inner`, none beyond `outer`.
    Spot {
        inner: f64,
        outer: f64,
    },
    Sun,
}

impl Model {
    /// The number of triangles of all parts.
    pub fn triangle_count(&self) -> u64 {
        let of = |part: &MeshInstance| self.meshes[part.mesh].triangles.len() as u64;
        self.instances.iter().map(of).sum()
    }

    /// The box around all parts; empty without triangles.
    pub fn bounds(&self) -> Aabb {
        let corners: Vec<Aabb> = self.meshes.iter().map(Mesh::bounds).collect();
        let points = self.instances.iter().flat_map(|part| {
            let own = corners[part.mesh];
            (0..8).map(move |i| {
                part.model_from_mesh
                    .transform_point3(own.corner(i).as_dvec3())
                    .as_vec3()
            })
        });
        Aabb::from_points(points)
    }
}
