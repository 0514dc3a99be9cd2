//! glTF 2.0 assets, as JSON with its files or as a GLB.
//!
//! The loader reads triangles with all vertex attributes, skins and morph targets, animations, materials with their
//! extensions, cameras and lights. All features of a file are reported as [`ModelFeature`](super::model::ModelFeature)s. A file
//! that requires an unknown extension is refused. Files are untrusted: every index, offset and length is checked before use,
//! nodes form a tree, files are beside the asset, and memory is proportional to the file.
//!
//! Source: Khronos, "glTF 2.0 Specification", version 2.0.1, 2021.

mod accessor;
mod animations;
mod cameras;
mod container;
mod document;
mod edited;
mod error;
mod fault_place;
mod features;
mod instancing;
mod json;
mod lights;
mod lint;
mod materials;
mod moving;
mod nodes;
mod pose;
mod primitive;
mod textures;
mod variants;

use std::{path::Path, sync::Arc};

use super::{
    Files,
    model::{MeshInstance, Model, ModelCamera, ModelChoice, Treatment},
    model_format::{ModelError, ModelFormat},
    motion::{Carried, Motion, PartMotion},
};
use document::{Document, get};
use edited::EditedNumbers;
use error::GltfProblem;
use glam::DAffine3;
use moving::Moving;
use nodes::PlacedNode;
use pose::{Pose, PrimitiveUse};
use variants::Variants;

pub use error::GltfError;

/// The format.
pub struct Gltf;

impl ModelFormat for Gltf {
    fn extensions(&self) -> &'static [&'static str] {
        &["gltf", "glb"]
    }

    fn may_be_packed(&self) -> bool {
        false
    }

    fn has_choices(&self) -> bool {
        true
    }

    fn load(&self, path: &Path, choice: &ModelChoice, files: &Files) -> Result<Model, Box<dyn ModelError>> {
        Ok(load(path, choice, files)?)
    }
}

/// Loads the asset at `path`. One without triangles is a model without parts.
pub fn load(path: &Path, choice: &ModelChoice, files: &Files) -> Result<Model, GltfError> {
    let bytes = files.read(path).map_err(|source| GltfError::Read {
        source,
        path: path.to_owned(),
    })?;
    parse(&bytes, path, choice, files)
}

/// Parses an asset; the files that it names are beside `path`.
pub fn parse(bytes: &[u8], path: &Path, choice: &ModelChoice, files: &Files) -> Result<Model, GltfError> {
    read(bytes, path, choice, files).map_err(|problem| problem.at(path))
}

fn read(bytes: &[u8], path: &Path, choice: &ModelChoice, files: &Files) -> Result<Model, GltfProblem> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let document = Document::open(bytes, folder, files)?;
    let root = &document.root;
    let mut model = Model::default();
    let mut meshes = primitive::Meshes::default();
    features::collect(&document.raw, choice, &mut model);
    let hierarchy = nodes::Hierarchy::new(&document)?;
    model.nodes = hierarchy.names();
    let placed = hierarchy.placed(&document, choice.scene.as_ref())?;
    let variants = Variants::new(&document, choice.variant.as_deref())?;
    model.variants = variants.names();
    if choice.scene.is_none() && root.scenes.len() > 1 {
        let how = Treatment::InPart("one of several is shown, `scene` chooses another");
        model.add_feature("scenes", "file", how);
    }
    let lights = lights::Lights::new(&document, choice.light_units);
    let played = animations::read(&document, choice.animation.as_ref(), lights.divisor(), &mut model)?;
    animations::check(&document, &played)?;
    let names = materials::names(&document);
    model.named_materials = Some(names.into_iter().map(|name| (name, None)).collect());
    let edited = EditedNumbers::new(&choice.edited, &model);
    let hidden = hierarchy.hidden(&document);
    let moving = Moving::new(&placed, &played, &edited);
    let mut materials = materials::ModelMaterials::new(animations::textures(&played));
    let pose = Pose::new(&document, &placed, &moving);
    let mut motion = Motion::default();
    for (
        at,
        &PlacedNode {
            index,
            model_from_node: place,
            ..
        },
    ) in placed.iter().enumerate()
    {
        if !hierarchy.may_be_visible(&hidden, &edited, index) {
            continue;
        }
        let node = &root.nodes[index];
        if let Some(mesh) = node.mesh {
            let primitives = &get(&root.meshes, mesh.value(), "mesh")?.primitives;
            let copies = instancing::copies(&document, index)?;
            for (i, primitive) in primitives.iter().enumerate() {
                let own = primitive.material.map(|m| m.value());
                let material = variants.material(&document, [mesh.value(), i]).or(own);
                let uv_sets = materials::uv_sets(&document, material)?;
                let used = PrimitiveUse {
                    primitive,
                    node: index,
                    mesh: mesh.value(),
                    index: i,
                    uv_sets,
                    tangents: materials::tangent_set(&document, material, uv_sets)?,
                };
                let Some(mesh) = meshes.place(&document, &used, &pose, &mut model)? else {
                    continue;
                };
                let material = materials.place(&document, material, mesh.has_colors, path, &mut model)?;
                for copy in &copies {
                    if moving.moves(at) && !mesh.is_skinned {
                        motion.parts.push(PartMotion {
                            part: model.instances.len(),
                            node: at,
                            node_from_mesh: *copy,
                        });
                    }
                    if moving.switches(at) {
                        motion.switched.push((model.instances.len(), at));
                    }
                    // Many nodes may share a mesh of many primitives.
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
                Some(view) => {
                    let at_rest = ModelCamera {
                        name: node.name.clone().or(camera.name.clone()).unwrap_or_default(),
                        model_from_camera: place,
                        view,
                    };
                    model.cameras.push(at_rest.clone());
                    motion.cameras.push(Carried {
                        node: at,
                        source: node.camera.map_or(0, |camera| camera.value()),
                        at_rest,
                    });
                }
                None => model.add_feature("invalid numbers", "camera", Treatment::Without("it is left out")),
            }
        }
        if let Some((source, at_rest)) = lights.of_node(index)? {
            model.lights.push(at_rest.light(place));
            model.light_nodes.push(index);
            motion.lights.push(Carried {
                node: at,
                source,
                at_rest,
            });
        }
    }
    if choice.lights == Some(true) && !model.lights.is_empty() {
        tracing::info!("{}: {}", path.display(), lights.treatment());
    }
    if !played.is_empty() || !edited.is_empty() {
        let mut changed = animations::materials(&played);
        changed.extend(edited.materials.iter().map(|(number, _)| *number));
        let looks = materials.motions(&document, changed, &model);
        (motion.materials, motion.textures) = (looks.materials.clone(), looks.textures.clone());
        motion.named_nodes = moving.named_nodes(&edited);
        let named = edited.materials.iter();
        motion.named_materials = named
            .filter_map(|(number, name)| Some((name.clone(), *looks.material_places.get(number)?)))
            .collect();
        motion.meshes = meshes.motions;
        motion.nodes = moving.nodes(&document, &placed, (&played, &edited), &hidden);
        motion.skins = pose.into_skins();
        motion.clips = (played.into_iter())
            .map(|clip| clip.shown(|moved| moving.target(moved, &looks)))
            .collect();
        model.motion = Some(Arc::new(motion));
    }
    for (number, (_, place)) in model.named_materials.iter_mut().flatten().enumerate() {
        *place = materials.place_of(number);
    }
    model.meshes = meshes.meshes.into_iter().map(Arc::new).collect();
    model.faults.extend(meshes.repairs.faults());
    model.faults.extend(lint::faults(&document, &materials.used_images()));
    if document
        .raw
        .get("meshes")
        .and_then(|m| m.as_array())
        .is_some_and(Vec::is_empty)
    {
        return Err(GltfProblem::broken("meshes is an empty array"));
    }
    Ok(model)
}

#[cfg(test)]
pub(crate) mod samples;
#[cfg(test)]
mod tests;
