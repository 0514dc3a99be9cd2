//! Models of one mesh without a material, from PLY and STL files.

use std::{
    io,
    path::{Path, PathBuf},
};

use glam::DAffine3;

use super::{
    Files, MemoryBudget, OverBudget,
    files::is_refused,
    gzip,
    model::{MeshInstance, Model, ModelMaterial},
};
use crate::{
    material::principled::Principled,
    math::Rgb,
    shape::mesh::{Mesh, MeshError},
    texture::Color,
};

/// Why a PLY or STL file was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum BareMeshError {
    #[error("cannot read model: {source}: {}", path.display())]
    Read { source: io::Error, path: PathBuf },
    #[error("broken model: {cause}: {}", path.display())]
    Broken { cause: String, path: PathBuf },
    #[error("the model has {vertices} points and no faces, and point clouds are not rendered yet: {}", path.display())]
    Points { vertices: usize, path: PathBuf },
    #[error("{cause}: {}", path.display())]
    Memory { cause: OverBudget, path: PathBuf },
}

impl BareMeshError {
    /// Whether the file could not be read at all, rather than understood.
    pub fn is_missing(&self) -> bool {
        matches!(self, Self::Read { source, .. } if !is_refused(source))
    }
}

/// A fault of a file whose name the caller knows.
#[derive(Debug)]
pub(super) enum BareMeshProblem {
    Broken(String),
    Points(usize),
    Memory(OverBudget),
}

impl BareMeshProblem {
    pub fn at(self, path: PathBuf) -> BareMeshError {
        match self {
            Self::Broken(cause) => BareMeshError::Broken { cause, path },
            Self::Points(vertices) => BareMeshError::Points { vertices, path },
            Self::Memory(cause) => BareMeshError::Memory { cause, path },
        }
    }
}

impl From<MeshError> for BareMeshProblem {
    fn from(e: MeshError) -> Self {
        Self::Broken(e.to_string())
    }
}

impl From<OverBudget> for BareMeshProblem {
    fn from(cause: OverBudget) -> Self {
        Self::Memory(cause)
    }
}

/// Loads the model at `path`, which may be packed, by `parse`.
pub(super) fn load(
    path: &Path,
    files: &Files,
    parse: impl FnOnce(&[u8], &MemoryBudget) -> Result<Model, BareMeshProblem>,
) -> Result<Model, BareMeshError> {
    let bytes = gzip::read(path, files).map_err(|source| BareMeshError::Read {
        source,
        path: path.to_owned(),
    })?;
    parse(&bytes, files.memory()).map_err(|problem| problem.at(path.to_owned()))
}

/// Calls `read` with every beginning of a file, and with every byte changed in several ways.
#[cfg(test)]
pub(super) fn for_each_damage(whole: &[u8], read: impl Fn(&[u8])) {
    for i in 0..whole.len() {
        read(&whole[..i]);
        for byte in [b'\n', b'-', b'9', b' ', 0, 0xff] {
            let mut changed = whole.to_vec();
            changed[i] = byte;
            read(&changed);
        }
    }
}

/// A model of one mesh: matte and light gray, or in the colours of its vertices. One without triangles has no parts.
///
/// # Errors
/// The arrays of the mesh do not fit each other.
pub(super) fn model_of(mesh: Mesh) -> Result<Model, MeshError> {
    let mut model = Model::default();
    mesh.validate()?;
    if mesh.triangles.is_empty() {
        return Ok(model);
    }
    let has_colors = !mesh.colors.is_empty();
    let color = Rgb::gray(if has_colors { 1.0 } else { 0.8 });
    model.materials.push(ModelMaterial {
        name: String::new(),
        surface: Principled {
            reads_vertices: has_colors,
            ..Principled::matte(Color::Constant(color))
        },
    });
    model.instances.push(MeshInstance {
        mesh: 0,
        material: 0,
        node: None,
        model_from_mesh: DAffine3::IDENTITY,
    });
    model.meshes.push(mesh);
    Ok(model)
}
