//! PLY files, as text and as bytes in either order.
//!
//! The loader reads the positions of vertices, their normals (`nx`), their colours (`red`, `alpha`) and texture coordinates
//! (`s`, `u` or `texture_u`), faces with any number of corners, which may have colours and texture coordinates (`texcoord`) of
//! their own, and strips of triangles (`tristrips`). Colours of whole numbers are display values, those of floats are linear.
//! Whatever else is in the file is skipped. A file without normals is flat. A file without faces is a cloud of points; one of
//! Gaussian splats is refused. Positions in double precision and in text keep it.
//!
//! The number of elements is checked against the length of the file before memory is allocated.
//!
//! Source: G. Turk, "The PLY Polygon File Format", 1994.

mod colors;
mod faces;
mod header;
mod source;
#[cfg(test)]
mod tests;
mod values;

use std::path::Path;

use super::{
    Files, MemoryBudget, MemoryKind,
    bare::{self, BareMeshProblem, PlacedMesh, model_of},
    model::{FaceUse, Model, ModelChoice, Treatment},
    model_format::{ModelError, ModelFormat},
};
use crate::{
    math::{DVec2, DVec3, Vec3},
    shape::mesh::around_origin,
};
use faces::Faces;
use header::{Element, Encoding, Header, NumberType, Property, PropertyKind};
use source::{BigEndian, Binary, LittleEndian, Source, Text};
use values::{broken, skip, skip_property, stopped};

/// The most bytes of memory for each vertex: a position and texture coordinates, also in double precision, a normal and a colour.
const VERTEX_MEMORY: u64 = 12 + 24 + 12 + 8 + 16 + 16;

/// The format.
pub struct Ply;

impl ModelFormat for Ply {
    fn extensions(&self) -> &'static [&'static str] {
        &["ply"]
    }

    fn load(&self, path: &Path, choice: &ModelChoice, files: &Files) -> Result<Model, Box<dyn ModelError>> {
        let faces = choice.face_use();
        Ok(bare::load(path, files, |bytes, memory| parse(bytes, faces, memory))?)
    }
}

fn parse(bytes: &[u8], faces: FaceUse, memory: &MemoryBudget) -> Result<Model, BareMeshProblem> {
    let (header, data) = header::read(bytes).map_err(broken)?;
    if header.elements.iter().any(is_splats) {
        let what = "the file holds Gaussian splats, which are no surfaces and are not rendered";
        return Err(BareMeshProblem::Unsupported(what.to_owned()));
    }
    let (mesh, faults) = match header.encoding {
        Encoding::Text => read(&header, Text(data), faces, memory),
        Encoding::LittleEndian => read(&header, Binary::<LittleEndian>::new(data), faces, memory),
        Encoding::BigEndian => read(&header, Binary::<BigEndian>::new(data), faces, memory),
    }?;
    let mut model = model_of(mesh)?;
    model.faults.extend(faults);
    for _ in 0..header.textures {
        model.add_feature("TextureFile", "file", Treatment::Without(""));
    }
    Ok(model)
}

/// Whether an element holds Gaussian splats, as they are trained or compressed.
fn is_splats(element: &Element) -> bool {
    let has = |name: &str| element.properties.iter().any(|p| p.name == name);
    has("f_dc_0") && (has("scale_0") || has("rot_0")) || has("packed_rotation")
}

/// The used properties of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Slot {
    X,
    Y,
    Z,
    Nx,
    Ny,
    Nz,
    R,
    G,
    B,
    A,
    S,
    T,
    /// An unused property.
    Other,
}

const SLOTS: usize = Slot::Other as usize + 1;

impl Slot {
    fn of(name: &str) -> Self {
        match name {
            "x" => Self::X,
            "y" => Self::Y,
            "z" => Self::Z,
            "nx" => Self::Nx,
            "ny" => Self::Ny,
            "nz" => Self::Nz,
            "red" | "diffuse_red" | "r" => Self::R,
            "green" | "diffuse_green" | "g" => Self::G,
            "blue" | "diffuse_blue" | "b" => Self::B,
            "alpha" | "a" => Self::A,
            "s" | "u" | "texture_u" | "texture_s" => Self::S,
            "t" | "v" | "texture_v" | "texture_t" => Self::T,
            _ => Self::Other,
        }
    }
}

/// Reads the data; returns the mesh with the faults of its colours.
fn read(
    header: &Header,
    mut source: impl Source,
    face_use: FaceUse,
    memory: &MemoryBudget,
) -> Result<(PlacedMesh, Vec<String>), BareMeshProblem> {
    let (mut placed, mut faces) = (PlacedMesh::default(), Faces::new(face_use));
    let mut faults = Vec::new();
    for element in &header.elements {
        check_count(element, header.encoding, source.bytes_left())?;
        let done = match element.name.as_str() {
            "vertex" => {
                memory.check(MemoryKind::Models, element.count.saturating_mul(VERTEX_MEMORY))?;
                let number = read_vertices(element, header.encoding, &mut source, &mut placed)?;
                faults.extend(number.and_then(|number| colors::linearize(&mut placed.mesh.colors, number)));
                Ok(())
            }
            "face" | "tristrips" => {
                // A corner of one byte becomes a triangle of twelve.
                memory.check(MemoryKind::Models, 12 * source.bytes_left() as u64)?;
                match element.name.as_str() {
                    "face" => faces.read(element, &mut source),
                    _ => faces.read_strips(element, &mut source),
                }
            }
            _ => skip(element, &mut source),
        };
        done?;
    }
    if !faces.colors.is_empty() && !placed.mesh.colors.is_empty() {
        faults.push("colours of faces are not used, since the vertices have colours".to_owned());
        faces.colors.clear();
    }
    faults.extend(
        faces
            .color_type
            .and_then(|number| colors::linearize(&mut faces.colors, number)),
    );
    faces.finish(&mut placed, memory)?;
    Ok((placed, faults))
}

/// Refuses more elements than the remaining bytes can hold.
fn check_count(element: &Element, encoding: Encoding, left: usize) -> Result<(), BareMeshProblem> {
    // The last number of a text needs no space after it.
    let left = left as u64 + u64::from(encoding == Encoding::Text);
    let least = element.least_bytes(encoding);
    if element.count.saturating_mul(least) > left {
        let Element { name, count, .. } = element;
        return Err(broken(format!(
            "the file names {count} elements `{name}` of at least {least} bytes each, but only {left} bytes are left"
        )));
    }
    Ok(())
}

/// Reads the vertices, with raw colours; returns the type of those where there are any.
fn read_vertices(
    element: &Element,
    encoding: Encoding,
    source: &mut impl Source,
    placed: &mut PlacedMesh,
) -> Result<Option<NumberType>, BareMeshProblem> {
    let slots: Vec<(Slot, &Property)> = element.properties.iter().map(|p| (Slot::of(&p.name), p)).collect();
    let has = |slot: Slot| {
        let is_number = |p: &Property| matches!(p.kind, PropertyKind::Number(_));
        slots.iter().any(|(own, p)| *own == slot && is_number(p))
    };
    if ![Slot::X, Slot::Y, Slot::Z].into_iter().all(has) {
        return Err(broken("the vertices have no x, y and z"));
    }
    let has_normals = [Slot::Nx, Slot::Ny, Slot::Nz].into_iter().all(has);
    let has_colors = [Slot::R, Slot::G, Slot::B].into_iter().all(has);
    let has_uvs = [Slot::S, Slot::T].into_iter().all(has);
    let count = element.count as usize;
    // Numbers beyond single precision.
    let is_long = |slot| {
        matches!(
            number_type(&slots, slot),
            NumberType::F64 | NumberType::I32 | NumberType::U32
        )
    };
    let has_doubles = encoding == Encoding::Text || [Slot::X, Slot::Y, Slot::Z].into_iter().any(is_long);
    let mut doubles = Vec::with_capacity(if has_doubles { count } else { 0 });
    *placed = PlacedMesh::default();
    let mesh = &mut placed.mesh;
    mesh.positions.reserve_exact(if has_doubles { 0 } else { count });
    mesh.normals.reserve_exact(if has_normals { count } else { 0 });
    mesh.colors.reserve_exact(if has_colors { count } else { 0 });
    let mut uvs = Vec::with_capacity(if has_uvs { count } else { 0 });
    let alpha = number_type(&slots, Slot::A);
    let mut own = [1.0; SLOTS];
    for i in 0..element.count {
        for (slot, property) in &slots {
            match property.kind {
                PropertyKind::Number(number) => source.number(number).map(|v| own[*slot as usize] = v),
                PropertyKind::List { .. } => skip_property(source, property),
            }
            .map_err(|stop| stopped(element, i)(stop))?;
        }
        let vec3 = |slot: Slot| {
            let at = slot as usize;
            Vec3::new(own[at] as f32, own[at + 1] as f32, own[at + 2] as f32)
        };
        if has_doubles {
            doubles.push(DVec3::new(
                own[Slot::X as usize],
                own[Slot::Y as usize],
                own[Slot::Z as usize],
            ));
        } else {
            mesh.positions.push(vec3(Slot::X));
        }
        if has_normals {
            mesh.normals.push(vec3(Slot::Nx));
        }
        if has_uvs {
            uvs.push(DVec2::new(own[Slot::S as usize], own[Slot::T as usize]));
        }
        if has_colors {
            let a = own[Slot::A as usize] / alpha.one();
            mesh.colors.push(vec3(Slot::R).extend(a.clamp(0.0, 1.0) as f32));
        }
    }
    (mesh.uv_origins[0], mesh.uvs) = around_origin(uvs.into_iter());
    if has_doubles {
        placed.set_positions(&doubles);
    }
    Ok(has_colors.then(|| number_type(&slots, Slot::R)))
}

/// The type of a property of a vertex; float if it is missing.
fn number_type(slots: &[(Slot, &Property)], slot: Slot) -> NumberType {
    let property = slots.iter().find(|(own, _)| *own == slot);
    match property.map(|(_, p)| p.kind) {
        Some(PropertyKind::Number(number)) => number,
        _ => NumberType::F32,
    }
}
