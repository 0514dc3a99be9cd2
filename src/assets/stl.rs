//! STL files, binary and as text.
//!
//! Corners at the same position become one vertex. The normals of facets are ignored, because the order of corners defines the
//! side, and so are the two bytes after each facet. The surface is flat. A file is binary if its length fits the number of
//! triangles in its header, whatever its first word is.

use std::{collections::HashMap, path::Path};

use super::{
    Files, MemoryBudget, MemoryKind,
    bare::{self, BareMeshProblem, PlacedMesh, model_of},
    model::{Model, ModelChoice},
    model_format::{ModelError, ModelFormat},
};
use crate::{
    math::{DAabb, DVec3, Vec3, origin},
    shape::mesh::Mesh,
};

/// The bytes before the first facet, and those of a facet.
const HEADER: usize = 84;
const FACET: usize = 50;

/// Bytes of memory for a facet during merging: its corners, and a table entry for each.
const FACET_MEMORY: u64 = 12 + 3 * (24 + 12 + 24);

/// The format.
pub struct Stl;

impl ModelFormat for Stl {
    fn extensions(&self) -> &'static [&'static str] {
        &["stl"]
    }

    fn load(&self, path: &Path, _: &ModelChoice, files: &Files) -> Result<Model, Box<dyn ModelError>> {
        Ok(bare::load(path, files, parse)?)
    }
}

fn parse(bytes: &[u8], memory: &MemoryBudget) -> Result<Model, BareMeshProblem> {
    let is_text = bytes
        .trim_ascii_start()
        .get(..5)
        .is_some_and(|w| w.eq_ignore_ascii_case(b"solid"));
    let count = bytes
        .get(80..HEADER)
        .and_then(|b| b.try_into().ok())
        .map(u32::from_le_bytes);
    let has_room = |count: u32| (bytes.len() - HEADER) as u64 >= u64::from(count) * FACET as u64;
    match count {
        Some(count) if has_room(count) && (!is_text || bytes.len() == HEADER + count as usize * FACET) => {
            let end = HEADER + count as usize * FACET;
            memory.check(MemoryKind::Models, u64::from(count) * FACET_MEMORY)?;
            Ok(model_of(binary(&bytes[HEADER..end]))?)
        }
        _ if is_text => {
            // A facet takes more than 50 bytes of text.
            memory.check(MemoryKind::Models, (bytes.len() / FACET) as u64 * FACET_MEMORY)?;
            Ok(model_of(text(bytes)?)?)
        }
        Some(count) => Err(broken(format!(
            "the file names {count} triangles, but has the bytes of {} only",
            (bytes.len() - HEADER) / FACET
        ))),
        None => Err(broken("the file is too short for an STL file".into())),
    }
}

fn broken(cause: String) -> BareMeshProblem {
    BareMeshProblem::Broken(cause)
}

/// Vertices, merged by position.
#[derive(Default)]
struct Vertices {
    positions: Vec<Vec3>,
    known: HashMap<[u32; 3], u32>,
}

impl Vertices {
    fn at(&mut self, p: Vec3) -> u32 {
        // Adding 0 turns -0 into 0.
        let p = p + 0.0;
        *self.known.entry(p.to_array().map(f32::to_bits)).or_insert_with(|| {
            self.positions.push(p);
            self.positions.len() as u32 - 1
        })
    }

    fn into_mesh(self, triangles: Vec<[u32; 3]>, origin: DVec3) -> PlacedMesh {
        let mesh = Mesh {
            positions: self.positions,
            triangles,
            ..Mesh::default()
        };
        PlacedMesh { mesh, origin }
    }
}

/// The mesh of a binary file.
fn binary(facets: &[u8]) -> PlacedMesh {
    let mut vertices = Vertices::default();
    let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let mut corner = |b: &[u8]| vertices.at(Vec3::new(number(b), number(&b[4..]), number(&b[8..])));
    let triangles = facets
        .chunks_exact(FACET)
        .map(|f| [corner(&f[12..24]), corner(&f[24..36]), corner(&f[36..48])])
        .collect();
    vertices.into_mesh(triangles, DVec3::ZERO)
}

fn text(bytes: &[u8]) -> Result<PlacedMesh, BareMeshProblem> {
    let mut facets = Vec::new();
    let (mut corners, mut count) = ([DVec3::ZERO; 3], 0);
    let mut is_ended = false;
    for line in bytes.split(|b| *b == b'\n' || *b == b'\r') {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        let keyword = words.next().unwrap_or_default();
        if keyword.eq_ignore_ascii_case(b"vertex") {
            let mut next = || words.next().and_then(|w| str::from_utf8(w).ok()?.parse::<f64>().ok());
            let (Some(x), Some(y), Some(z)) = (next(), next(), next()) else {
                return Err(broken(format!(
                    "triangle {} has a corner without three numbers",
                    facets.len()
                )));
            };
            if let Some(corner) = corners.get_mut(count) {
                *corner = DVec3::new(x, y, z);
            }
            count += 1;
        } else if keyword.eq_ignore_ascii_case(b"endloop") {
            if count != 3 {
                return Err(broken(format!("triangle {} has {count} corners", facets.len())));
            }
            facets.push(corners);
            count = 0;
        }
        is_ended = keyword.eq_ignore_ascii_case(b"endsolid") || is_ended && keyword.is_empty();
    }
    if count > 0 || !is_ended {
        return Err(broken("the file ends without `endsolid`".into()));
    }
    let bounds = DAabb::from_points(facets.iter().flatten().copied());
    let origin = origin::of_box(&bounds).unwrap_or_default();
    let mut vertices = Vertices::default();
    let triangles = facets.iter().map(|f| f.map(|p| vertices.at((p - origin).as_vec3())));
    let triangles = triangles.collect();
    Ok(vertices.into_mesh(triangles, origin))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::bare::for_each_damage;

    /// Two triangles of a square in the xy plane.
    const SQUARE: [[f32; 9]; 2] = [
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0],
        [-0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0],
    ];

    fn as_binary(header: &[u8]) -> Vec<u8> {
        let mut out = header.to_vec();
        out.resize(80, b' ');
        out.extend_from_slice(&2_u32.to_le_bytes());
        for triangle in SQUARE {
            out.extend_from_slice(&[0xff; 12]);
            out.extend(triangle.iter().flat_map(|v| v.to_le_bytes()));
            out.extend_from_slice(&[1, 2]);
        }
        out
    }

    fn as_text() -> String {
        let facet = |t: &[f32; 9]| {
            let corner = |c: &[f32]| format!("      vertex {} {} {:e}\r\n", c[0], c[1], c[2]);
            let corners: String = t.chunks_exact(3).map(corner).collect();
            format!("  facet normal nan 0 0\r\n    outer loop\r\n{corners}    endloop\r\n  endfacet\r\n")
        };
        let facets: String = SQUARE.iter().map(facet).collect();
        format!("solid square\r\n{facets}endsolid square\r\n")
    }

    fn read(bytes: &[u8]) -> Result<Model, String> {
        let problem = |e: BareMeshProblem| e.at("a.stl".into()).to_string();
        parse(bytes, &MemoryBudget::default()).map_err(problem)
    }

    #[test]
    fn text_and_bytes_give_the_same_indexed_mesh() {
        let model = read(&as_binary(b"solid in name only")).unwrap();
        assert_eq!(model.meshes[0].triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(model.meshes[0].positions.len(), 4);
        assert!(model.meshes[0].normals.is_empty());
        assert_eq!(model.meshes, read(as_text().as_bytes()).unwrap().meshes);
        assert_eq!(model.meshes, read(as_text().to_uppercase().as_bytes()).unwrap().meshes);
    }

    #[test]
    fn counts_and_cut_files_are_refused_before_memory_is_taken() {
        let mut many = as_binary(b"");
        many[80..84].copy_from_slice(&4_000_000_000_u32.to_le_bytes());
        assert_eq!(
            read(&many).unwrap_err(),
            "broken model: the file names 4000000000 triangles, but has the bytes of 2 only: a.stl"
        );
        assert!(read(&as_binary(b"")[..180]).unwrap_err().contains("2 triangles"));
        assert!(read(b"").unwrap_err().contains("too short"));
        let text = as_text();
        assert!(
            read(&text.as_bytes()[..text.len() - 30])
                .unwrap_err()
                .contains("endsolid")
        );
        let four = text.replacen("endloop", "vertex 0 0 0\r\nendloop", 1);
        assert!(read(four.as_bytes()).unwrap_err().contains("triangle 0 has 4 corners"));
        assert!(read(text.replace("vertex 1", "vertex x").as_bytes()).is_err());
        assert!(read(&as_binary(b"")).is_ok_and(|m| m.features.is_empty()));
        let little = parse(&as_binary(b""), &MemoryBudget::new(Some(10)));
        assert!(matches!(little, Err(BareMeshProblem::Memory(_))));
    }

    #[test]
    fn cut_and_flipped_bytes_never_panic() {
        for whole in [as_binary(b"x"), as_text().into_bytes()] {
            for_each_damage(&whole, |bytes| drop(read(bytes)));
        }
    }
}
