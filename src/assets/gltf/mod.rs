//! glTF 2.0 assets, as JSON with its files or as a GLB.
//!
//! Read are the triangles of the default scene with their normals and texture coordinates, base colours with their
//! textures, cameras, and the lights of KHR_lights_punctual. A file that requires another extension is refused by its
//! name. Nothing in a file is believed: every index, offset and length is checked before it is used, nodes form a tree,
//! files lie beside the asset, and memory is in proportion to the file.
//!
//! Source: Khronos, "glTF 2.0 Specification", version 2.0.1, 2021.

mod accessor;
mod cameras;
mod container;
mod document;
mod error;
mod features;
mod instancing;
mod json;
mod lights;
mod materials;
mod nodes;
mod pose;
mod primitive;
mod textures;

use std::path::Path;

use super::{
    Files,
    model::{MeshInstance, Model, ModelCamera},
};
use document::{Document, get};
use error::GltfProblem;
use glam::DAffine3;
use pose::Pose;
use primitive::PrimitiveUse;

pub use error::GltfError;

/// Loads the asset at `path`. One without triangles is a model without parts.
pub fn load(path: &Path, files: &Files) -> Result<Model, GltfError> {
    let bytes = files.read(path).map_err(|source| GltfError::Read {
        source,
        path: path.to_owned(),
    })?;
    parse(&bytes, path, files)
}

/// Reads an asset from the bytes of a file; what it names lies beside `path`.
pub fn parse(bytes: &[u8], path: &Path, files: &Files) -> Result<Model, GltfError> {
    read(bytes, path, files).map_err(|problem| problem.at(path))
}

fn read(bytes: &[u8], path: &Path, files: &Files) -> Result<Model, GltfProblem> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let document = Document::open(bytes, folder, files)?;
    let root = &document.root;
    let mut model = Model::default();
    let mut meshes = primitive::Meshes::default();
    let mut materials = materials::ModelMaterials::default();
    features::collect(&document.raw, &mut model);
    let hierarchy = nodes::Hierarchy::new(&document)?;
    model.nodes = hierarchy.names();
    let placed = hierarchy.placed(&document)?;
    let pose = Pose::new(&document, &placed);
    for &(index, place) in &placed {
        if !hierarchy.is_visible(&document, index) {
            continue;
        }
        let node = &root.nodes[index];
        if let Some(mesh) = node.mesh {
            let primitives = &get(&root.meshes, mesh.value(), "mesh")?.primitives;
            let copies = instancing::copies(&document, index)?;
            for (i, primitive) in primitives.iter().enumerate() {
                let material = primitive.material.map(|m| m.value());
                let used = PrimitiveUse {
                    primitive,
                    node: index,
                    mesh: mesh.value(),
                    index: i,
                    uv_sets: materials::uv_sets(&document, material)?,
                };
                let Some(mesh) = meshes.place(&document, &used, &pose, &mut model)? else {
                    continue;
                };
                let material = materials.place(&document, material, mesh.has_colors, path, &mut model)?;
                for copy in &copies {
                    // Many nodes may name a mesh of many primitives.
                    document.reserve(size_of::<MeshInstance>() as u64)?;
                    model.instances.push(MeshInstance {
                        mesh: mesh.index,
                        material,
                        node: Some(index),
                        model_from_mesh: if mesh.is_skinned {
                            DAffine3::IDENTITY
                        } else {
                            place * *copy
                        },
                    });
                }
            }
        }
        if let Some(camera) = node.camera {
            let camera = get(&root.cameras, camera.value(), "camera")?;
            match cameras::view(camera) {
                Some(view) => model.cameras.push(ModelCamera {
                    model_from_camera: place,
                    view,
                }),
                None => tracing::warn!(
                    "a camera of node {index} makes no sense and is left out: {}",
                    path.display()
                ),
            }
        }
        model.lights.extend(lights::light(&document, index, place)?);
    }
    model.meshes = meshes.meshes;
    Ok(model)
}

#[cfg(test)]
mod tests;
