//! Models of one mesh without a material, from PLY and STL files.

use std::{
    io,
    path::{Path, PathBuf},
};

use glam::{DAffine3, DVec3};

use super::{
    Files, MemoryBudget, OverBudget,
    files::is_refused,
    gzip,
    model::{MeshInstance, Model, ModelMaterial},
    model_format::ModelError,
    points::{PointCloud, mean_spacing},
    repair::repair,
};
use crate::{
    material::principled::Principled,
    math::{DAabb, Rgb, origin},
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
    #[error("unsupported model: {what}: {}", path.display())]
    Unsupported { what: String, path: PathBuf },
    #[error("{cause}: {}", path.display())]
    Memory { cause: OverBudget, path: PathBuf },
}

impl ModelError for BareMeshError {
    fn path(&self) -> &Path {
        let (Self::Read { path, .. }
        | Self::Broken { path, .. }
        | Self::Unsupported { path, .. }
        | Self::Memory { path, .. }) = self;
        path
    }

    fn is_missing(&self) -> bool {
        matches!(self, Self::Read { source, .. } if !is_refused(source))
    }
}

/// An error without the name of the file, which the caller adds.
#[derive(Debug)]
pub(super) enum BareMeshProblem {
    Broken(String),
    Unsupported(String),
    Memory(OverBudget),
}

impl BareMeshProblem {
    pub fn at(self, path: PathBuf) -> BareMeshError {
        match self {
            Self::Broken(cause) => BareMeshError::Broken { cause, path },
            Self::Unsupported(what) => BareMeshError::Unsupported { what, path },
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

/// Loads the model at `path`, possibly compressed, by `parse`.
pub(super) fn load(
    path: &Path,
    files: &Files,
    parse: impl FnOnce(&[u8], &MemoryBudget) -> Result<Model, BareMeshProblem>,
) -> Result<Model, BareMeshError> {
    let bytes = gzip::read(path, files).map_err(|source| BareMeshError::Read {
        source,
        path: path.to_owned(),
    })?;
    if bytes.trim_ascii().is_empty() {
        let (cause, path) = ("the file is empty".to_owned(), path.to_owned());
        return Err(BareMeshError::Broken { cause, path });
    }
    parse(&bytes, files.memory()).map_err(|problem| problem.at(path.to_owned()))
}

/// Calls `read` with every prefix of a file, and with every byte changed in several ways.
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

/// A mesh whose positions are relative to an origin.
#[derive(Default)]
pub(super) struct PlacedMesh {
    pub mesh: Mesh,
    pub origin: DVec3,
}

impl PlacedMesh {
    /// Sets the positions of the vertices. If all of them are far away, the mesh gets an origin of its own.
    pub fn set_positions(&mut self, positions: &[DVec3]) {
        let bounds = DAabb::from_points(positions.iter().copied().filter(|p| p.is_finite()));
        self.origin = origin::of_box(&bounds).unwrap_or_default();
        self.mesh.positions = positions.iter().map(|p| (*p - self.origin).as_vec3()).collect();
    }
}

/// A model of one mesh or, without triangles, of points: matte and light gray, or with vertex colours. Without vertices it has no
/// parts.
///
/// # Errors
/// The arrays of the mesh do not fit each other.
pub(super) fn model_of(placed: PlacedMesh) -> Result<Model, MeshError> {
    let mut model = Model::default();
    let PlacedMesh { mut mesh, origin } = placed;
    model.faults = repair(&mut mesh).faults().collect();
    mesh.normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
    mesh.validate()?;
    if mesh.positions.is_empty() {
        return Ok(model);
    }
    let has_colors = !mesh.colors.is_empty();
    let color = Rgb::gray(if has_colors { 1.0 } else { 0.8 });
    model.materials.push(ModelMaterial {
        surface: Principled {
            reads_vertices: has_colors,
            ..Principled::matte(Color::Constant(color))
        },
        ..ModelMaterial::default()
    });
    let place = DAffine3::from_translation(origin);
    if mesh.triangles.is_empty() {
        model.points = Some(PointCloud {
            radius: mean_spacing(&mesh.positions),
            positions: mesh.positions,
            colors: mesh.colors,
            material: 0,
            model_from_points: place,
        });
        return Ok(model);
    }
    model.instances.push(MeshInstance {
        mesh: 0,
        material: 0,
        node: None,
        model_from_mesh: place,
    });
    model.meshes.push(mesh.into());
    Ok(model)
}
