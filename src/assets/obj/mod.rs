//! OBJ files with their MTL libraries.
//!
//! The loader reads positions with colours, texture coordinates, normals, faces with any number of corners, smoothing
//! groups, and materials with their textures. Points, lines and free-form geometry are not rendered. Faces that differ in
//! group, material or smoothing are different parts; objects and groups are nodes. If the file has no normals, the faces of a
//! smoothing group share theirs, and all others are flat. Colours of vertices are display values up to 1, or up to 255 if they
//! are whole numbers or one is above 16.
//!
//! The loader accepts any encoding, any line ends and keywords in any case. Indices without a vertex and numbers that cannot be
//! read are errors with their line. Numbers that are not finite cost their vertex or attribute, and broken normals give way to
//! those of the faces.
//!
//! Vertices and texture coordinates are read in double precision. If all are far from the file's origin, as in map coordinates,
//! they are stored relative to an origin of their own ([`crate::math::origin`]), which all parts share.

mod error;
mod lines;
mod mtl;
mod normalize;
pub(super) mod polygon;
mod positions;
mod smooth;
mod uvs;

use std::{collections::HashMap, io, path::Path};

use glam::DAffine3;

use super::{
    Files, MemoryKind, gzip,
    model::{self, FaceUse, MeshInstance, Model, ModelChoice, ModelNode, UvSet},
    model_format::{ModelError, ModelFormat},
    repair::{Repairs, color_range, repair},
    tangents,
};
use crate::{
    math::{DVec2, Vec2, Vec3, Vec4, srgb},
    shape::mesh::{Mesh, MeshError, Polygons, around_origin},
    warnings::WarningKind,
};
use mtl::MaterialUse;
use normalize::{Normalized, Run, Treatment};

pub use error::ObjError;

/// The memory that a byte of a file takes while it is read, in bytes: files of triangles or quads have taken 4.4 to 7.
const MEMORY_PER_BYTE: u64 = 4;

/// The format.
pub struct Obj;

impl ModelFormat for Obj {
    fn extensions(&self) -> &'static [&'static str] {
        &["obj"]
    }

    fn joins_groups(&self) -> bool {
        true
    }

    fn load(&self, path: &Path, choice: &ModelChoice, files: &Files) -> Result<Model, Box<dyn ModelError>> {
        Ok(load(path, choice.face_use(), files)?)
    }
}

/// Loads the model at `path`. A file without faces is a model without parts.
pub fn load(path: &Path, faces: FaceUse, files: &Files) -> Result<Model, ObjError> {
    let bytes = gzip::read(path, files).map_err(|source| ObjError::Read {
        source,
        path: path.to_owned(),
    })?;
    if bytes.trim_ascii().is_empty() {
        let (cause, path) = ("the file is empty".to_owned(), path.to_owned());
        return Err(ObjError::Broken { cause, path });
    }
    files
        .memory()
        .check(MemoryKind::Models, MEMORY_PER_BYTE * bytes.len() as u64)
        .map_err(|over| ObjError::Read {
            source: io::Error::new(io::ErrorKind::OutOfMemory, over),
            path: path.to_owned(),
        })?;
    parse(&bytes, path, faces, files)
}

/// Reads a model from the bytes of a file; libraries and images are beside `path`.
pub fn parse(bytes: &[u8], path: &Path, faces: FaceUse, files: &Files) -> Result<Model, ObjError> {
    let text = lines::decode(bytes);
    let at = |flaw: normalize::Flaw| ObjError::Line {
        line: flaw.line,
        cause: flaw.cause,
        path: path.to_owned(),
    };
    let mut normalized = normalize::normalize(&text, Treatment::default()).map_err(at)?;
    let far_uvs = normalized.may_have_far_uvs.then(|| uvs::far(&text)).flatten();
    let treatment = Treatment {
        numbers_uvs: far_uvs.is_some(),
        origin: normalized.may_be_far.then(|| positions::origin(&text)).flatten(),
        keeps_colors: normalized.has_colors,
    };
    if treatment != Treatment::default() {
        normalized = normalize::normalize(&text, treatment).map_err(at)?;
    }
    warn_of_normals(&normalized, path, files);
    // Errors of the parser and of the mesh's validation have no line, so it is searched afterwards.
    let broken = |cause: String| match normalize::diagnose(&text) {
        Some(flaw) => at(flaw),
        None => ObjError::Broken {
            cause,
            path: path.to_owned(),
        },
    };
    let options = tobj::LoadOptions {
        single_index: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let no_library = |_: &Path| Ok(Default::default());
    let (groups, _) =
        tobj::load_obj_buf(&mut &normalized.text[..], &options, no_library).map_err(|e| broken(e.to_string()))?;
    drop(normalized.text);
    let (scale, out_of_range) = color_scale(&groups);
    let mut repairs = Repairs::default();
    let meshes = groups
        .into_iter()
        .filter(|g| !g.mesh.indices.is_empty())
        .map(|g| {
            let run = g.name.parse().ok().and_then(|i: usize| normalized.runs.get(i));
            let run = run.ok_or_else(|| "a group without a number".to_owned())?;
            Ok((
                run,
                mesh(&g.mesh, scale, faces, far_uvs.as_deref(), &mut repairs).map_err(|e| e.to_string())?,
            ))
        })
        .collect::<Result<Vec<_>, _>>()
        .map_err(broken)?;
    let mut library = mtl::Library::load(path, &normalized.libraries, files)?;
    let model_from_mesh = treatment.origin.map_or(DAffine3::IDENTITY, DAffine3::from_translation);
    let mut model = assemble(meshes, model_from_mesh, normalized.nodes, &mut library, path)?;
    model.faults.extend(repairs.faults().chain(out_of_range));
    for ((name, what), count) in normalize::SKIPPED.iter().zip(normalized.skipped) {
        (0..count).for_each(|_| model.add_feature(name, "statement", model::Treatment::Without(what)));
    }
    Ok(model)
}

/// Warns of invalid normals, which were replaced.
fn warn_of_normals(normalized: &Normalized, path: &Path, files: &Files) {
    let are = match normalized.bad_normals {
        0 => return,
        1 => "invalid normal is replaced by that",
        _ => "invalid normals are replaced by those",
    };
    let text = format!("{} {are} of the faces: {}", normalized.bad_normals, path.display());
    files.warnings().add(WarningKind::BROKEN_ELEMENTS, path.display(), text);
}

/// The factor that makes display values up to 1 of the colours of vertices, and a fault where some are out of range.
fn color_scale(groups: &[tobj::Model]) -> (f32, Option<String>) {
    let (least, most, are_bytes) = color_range(groups.iter().flat_map(|g| g.mesh.vertex_color.iter().copied()));
    let one = if are_bytes { 255.0 } else { 1.0 };
    let is_outside = least < 0.0 || most > one;
    let fault = is_outside.then(|| format!("colours of vertices from {least} to {most} are cut to 0 and {one}"));
    (1.0 / one, fault)
}

/// The linear colours of a group's vertices, white where they have none; empty if all are white.
fn colors(group: &tobj::Mesh, scale: f32) -> Vec<Vec4> {
    let is_white = |c: f32| c.is_nan() || c * scale == 1.0;
    if group.vertex_color.iter().all(|c| is_white(*c)) {
        return Vec::new();
    }
    let linear = |c: f32| match c.is_nan() {
        true => 1.0,
        false => srgb::decode((c * scale).clamp(0.0, 1.0)),
    };
    let color = |c: &[f32]| Vec4::new(linear(c[0]), linear(c[1]), linear(c[2]), 1.0);
    group.vertex_color.chunks_exact(3).map(color).collect()
}

/// The mesh of a group, with triangulated faces.
///
/// `far_uvs` are the texture coordinates of the file, if the group has their numbers.
fn mesh(
    group: &tobj::Mesh,
    color_scale: f32,
    faces: FaceUse,
    far_uvs: Option<&[DVec2]>,
    repairs: &mut Repairs,
) -> Result<Mesh, MeshError> {
    let vec3 = |v: &[f32]| Vec3::new(v[0], v[1], v[2]);
    let positions: Vec<Vec3> = group.positions.chunks_exact(3).map(vec3).collect();
    let mut triangles = Vec::with_capacity(group.indices.len() / 3);
    let mut polygons = Polygons::default();
    if group.face_arities.is_empty() {
        triangles.extend(group.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]));
    } else {
        let mut rest = &group.indices[..];
        for arity in &group.face_arities {
            let (face, after) = rest.split_at(*arity as usize);
            rest = after;
            if faces == FaceUse::Polygons {
                polygons.push(face);
            }
            let corners: Vec<Vec3> = face.iter().map(|v| positions[*v as usize]).collect();
            polygon::triangulate(&corners, |t| triangles.push(t.map(|i| face[i])));
        }
    }
    let uvs = group.texcoords.chunks_exact(2);
    let (uv_origin, uvs) = match far_uvs {
        None => (Vec2::ZERO, uvs.map(|t| Vec2::new(t[0], t[1])).collect()),
        Some(all) => around_origin(uvs.map(|t| all[uvs::number([t[0], t[1]])])),
    };
    let mut mesh = Mesh {
        positions,
        triangles,
        polygons: polygons.without_triangles(),
        normals: group
            .normals
            .chunks_exact(3)
            .map(|n| vec3(n).normalize_or_zero())
            .collect(),
        uvs,
        uv_origins: [uv_origin, Vec2::ZERO],
        colors: colors(group, color_scale),
        ..Mesh::default()
    };
    *repairs += repair(&mut mesh);
    mesh.validate()?;
    Ok(mesh)
}

fn assemble(
    mut meshes: Vec<(&Run, Mesh)>,
    model_from_mesh: DAffine3,
    nodes: Vec<ModelNode>,
    library: &mut mtl::Library<'_>,
    path: &Path,
) -> Result<Model, ObjError> {
    let smooths = |run: &Run, mesh: &Mesh| run.smoothing != 0 && mesh.normals.is_empty();
    let mut groups = smooth::Groups::default();
    for (run, mesh) in meshes.iter().filter(|(run, mesh)| smooths(run, mesh)) {
        groups.add(run.smoothing, mesh);
    }
    for (run, mesh) in meshes.iter_mut().filter(|(run, mesh)| smooths(run, mesh)) {
        mesh.normals = groups.normals(run.smoothing, mesh);
    }
    let mut model = Model {
        nodes,
        ..Model::default()
    };
    let mut materials: HashMap<MaterialUse<'_>, usize> = HashMap::new();
    for (run, mut mesh) in meshes {
        if mesh.triangles.is_empty() {
            continue;
        }
        let wanted = MaterialUse {
            name: run.material.as_deref(),
            has_colors: !mesh.colors.is_empty(),
        };
        let material = match materials.get(&wanted) {
            Some(&placed) => placed,
            None => library.place(wanted, path, &mut model)?,
        };
        materials.insert(wanted, material);
        if model.materials[material].surface.normal.is_some() {
            tangents::add(&mut mesh, UvSet::First);
        }
        model.instances.push(MeshInstance {
            mesh: model.meshes.len(),
            material,
            node: run.node,
            model_from_mesh,
        });
        model.meshes.push(mesh.into());
    }
    Ok(model)
}

#[cfg(test)]
mod tests;
