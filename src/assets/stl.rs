//! STL files, binary and as text.
//!
//! Corners in the same place become one vertex. The normals of facets are ignored, since the order of corners tells the side.
//! The two bytes after a facet are its colour, by either convention. The surface is flat. A file is text if its first word is
//! `solid` and its beginning has no byte 0. Where whole facets follow the header of a binary file, their
//! number counts, not the header's.

use std::{collections::HashMap, path::Path};

use super::{
    Files, MemoryBudget, MemoryKind,
    bare::{self, BareMeshProblem, PlacedMesh, model_of},
    model::{Model, ModelChoice},
    model_format::{ModelError, ModelFormat},
    repair::is_not_finite,
};
use crate::{
    math::{DAabb, DVec3, Vec3, Vec4, origin, srgb},
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
    let is_text = is_text(bytes);
    let Some((header, facets)) = bytes.split_at_checked(HEADER).filter(|_| !is_text) else {
        if !is_text {
            return Err(broken("the file is too short for an STL file, it has no header".into()));
        }
        // A facet takes more than 50 bytes of text.
        memory.check(MemoryKind::Models, (bytes.len() / FACET) as u64 * FACET_MEMORY)?;
        return Ok(model_of(text(bytes)?)?);
    };
    let named = u32::from_le_bytes([header[80], header[81], header[82], header[83]]) as usize;
    let there = facets.len() / FACET;
    // Programs that write as they go name no number, or the largest.
    let is_whole = facets.len().is_multiple_of(FACET) && there > 0;
    let count = match named {
        _ if is_whole => there,
        named if named <= there => named,
        _ => {
            let cause = format!("the file names {named} triangles, but has the bytes of {there} only");
            return Err(broken(cause));
        }
    };
    memory.check(MemoryKind::Models, count as u64 * FACET_MEMORY)?;
    let mut model = model_of(binary(&facets[..count * FACET], Coloring::of(header)))?;
    if count != named {
        let fault = format!("its header names {named} triangles, and the {count} that follow are read");
        model.faults.push(fault);
    }
    Ok(model)
}

/// Whether a file is text. Its first word alone does not tell: the headers of many binary files begin with it.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let begins = start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let beginning = &bytes[..bytes.len().min(HEADER + FACET)];
    // Zeros at the end are padding.
    let padding = beginning.iter().rev().take_while(|byte| **byte == 0).count();
    begins && !beginning[..beginning.len() - padding].contains(&0)
}

fn broken(cause: String) -> BareMeshProblem {
    BareMeshProblem::Broken(cause)
}

/// The convention by which the two bytes after a facet are a colour.
#[derive(Clone, Copy)]
enum Coloring {
    /// The convention of VisCAM and SolidView: with the highest bit set, 5 bits each of red, green and blue.
    Facets,
    /// The convention of Materialise Magics: with the highest bit set the colour of the header, else 5
    /// bits each of blue, green and red.
    Magics([u8; 4]),
}

impl Coloring {
    fn of(header: &[u8]) -> Self {
        const WORD: &[u8] = b"COLOR=";
        let at = header.windows(WORD.len()).position(|w| w == WORD);
        let color = at.and_then(|at| header.get(at + WORD.len()..at + WORD.len() + 4));
        match color.and_then(|c| c.try_into().ok()) {
            Some(color) => Self::Magics(color),
            None => Self::Facets,
        }
    }

    /// The linear colour of a facet, by its two bytes.
    fn color(self, bits: u16) -> Option<Vec4> {
        let five = |shift: u32| srgb::decode(f32::from(bits >> shift & 31) / 31.0);
        match (self, bits >> 15) {
            (Self::Facets, 0) => None,
            (Self::Facets, _) => Some(Vec4::new(five(10), five(5), five(0), 1.0)),
            (Self::Magics(_), 0) => Some(Vec4::new(five(0), five(5), five(10), 1.0)),
            (Self::Magics([r, g, b, a]), _) => {
                let [r, g, b] = [r, g, b].map(srgb::decode8);
                Some(Vec4::new(r, g, b, f32::from(a) / 255.0))
            }
        }
    }
}

/// The colour of a facet that has none, in a file in which others have one.
const PLAIN: Vec4 = Vec4::new(0.8, 0.8, 0.8, 1.0);

/// Vertices that are shared where they are in the same place and of the same colour.
#[derive(Default)]
struct Vertices {
    positions: Vec<Vec3>,
    /// None, or one for each vertex.
    colors: Vec<Vec4>,
    known: HashMap<([u32; 3], u16), u32>,
}

impl Vertices {
    /// The vertex at a place; `key` tells colours apart.
    fn at(&mut self, p: Vec3, (key, color): (u16, Option<Vec4>)) -> u32 {
        // Adding 0 makes one zero of two.
        let p = p + 0.0;
        *self
            .known
            .entry((p.to_array().map(f32::to_bits), key))
            .or_insert_with(|| {
                self.positions.push(p);
                self.colors.extend(color);
                self.positions.len() as u32 - 1
            })
    }

    fn into_mesh(self, triangles: Vec<[u32; 3]>, origin: DVec3) -> PlacedMesh {
        let mesh = Mesh {
            positions: self.positions,
            colors: self.colors,
            triangles,
            ..Mesh::default()
        };
        PlacedMesh { mesh, origin }
    }
}

/// The mesh of whole facets.
fn binary(facets: &[u8], coloring: Coloring) -> PlacedMesh {
    let mut vertices = Vertices::default();
    let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let bits = |f: &[u8]| u16::from_le_bytes([f[48], f[49]]);
    let is_colored = facets.chunks_exact(FACET).any(|f| coloring.color(bits(f)).is_some());
    let triangles = facets.chunks_exact(FACET).map(|f| {
        let color = match is_colored {
            true => (bits(f), Some(coloring.color(bits(f)).unwrap_or(PLAIN))),
            false => (0, None),
        };
        let mut corner = |b: &[u8]| vertices.at(Vec3::new(number(b), number(&b[4..]), number(&b[8..])), color);
        [corner(&f[12..24]), corner(&f[24..36]), corner(&f[36..48])]
    });
    let triangles = triangles.collect();
    vertices.into_mesh(triangles, DVec3::ZERO)
}

/// The mesh of a text, wherever its lines end. The words after `solid` and `endsolid` are a name.
fn text(bytes: &[u8]) -> Result<PlacedMesh, BareMeshProblem> {
    let mut facets = Vec::new();
    let (mut corners, mut count) = ([DVec3::ZERO; 3], 0);
    let (mut is_in_name, mut is_ended) = (false, false);
    let mut words = bytes
        .split(u8::is_ascii_whitespace)
        .filter(|w| !w.is_empty())
        .peekable();
    while let Some(word) = words.next() {
        let is = |keyword: &[u8]| word.eq_ignore_ascii_case(keyword);
        let begins_facet = is(b"facet") && words.peek().is_some_and(|next| next.eq_ignore_ascii_case(b"normal"));
        is_in_name &= !begins_facet;
        if is(b"endsolid") || is(b"solid") && !is_in_name {
            (is_ended, is_in_name) = (is(b"endsolid"), true);
        } else if is(b"vertex") && !is_in_name {
            let mut next = || words.next().and_then(number);
            let (Some(x), Some(y), Some(z)) = (next(), next(), next()) else {
                let facet = facets.len();
                return Err(broken(format!("triangle {facet} has a corner without three numbers")));
            };
            if let Some(corner) = corners.get_mut(count) {
                *corner = DVec3::new(x, y, z);
            }
            count += 1;
        } else if is(b"endloop") && !is_in_name {
            if count != 3 {
                return Err(broken(format!("triangle {} has {count} corners", facets.len())));
            }
            facets.push(corners);
            count = 0;
        }
    }
    if count > 0 || !is_ended {
        return Err(broken("the file ends without `endsolid`".into()));
    }
    let finite = facets.iter().flatten().copied().filter(|p| p.is_finite());
    let origin = origin::of_box(&DAabb::from_points(finite)).unwrap_or_default();
    let mut vertices = Vertices::default();
    let mut vertex = |p: DVec3| vertices.at((p - origin).as_vec3(), (0, None));
    let triangles = facets.iter().map(|f| f.map(&mut vertex)).collect();
    Ok(vertices.into_mesh(triangles, origin))
}

fn number(word: &[u8]) -> Option<f64> {
    let number = str::from_utf8(word).ok().and_then(|w| w.parse().ok());
    number.or_else(|| is_not_finite(word).then_some(f64::NAN))
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
        many.push(0);
        assert_eq!(
            read(&many).unwrap_err(),
            "broken model: the file names 4000000000 triangles, but has the bytes of 2 only: a.stl"
        );
        assert!(read(&as_binary(b"")[..180]).unwrap_err().contains("2 triangles"));
        assert!(read(b"STL").unwrap_err().contains("no header"));
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
    fn the_facets_that_follow_are_read_whatever_number_the_header_names() {
        for named in [0, 1, 3, u32::MAX] {
            let mut bytes = as_binary(b"solid of another program");
            bytes[80..84].copy_from_slice(&named.to_le_bytes());
            let model = read(&bytes).unwrap();
            assert_eq!((model.meshes[0].triangles.len(), model.faults.len()), (2, 1), "{named}");
        }
        assert!(read(&as_binary(b"")).unwrap().faults.is_empty());
    }

    #[test]
    fn facets_have_colors_by_either_convention() {
        let colored = |header: &[u8], bits: [u16; 2]| {
            let mut bytes = as_binary(header);
            for (facet, bits) in bits.into_iter().enumerate() {
                let end = HEADER + (facet + 1) * FACET;
                bytes[end - 2..end].copy_from_slice(&bits.to_le_bytes());
            }
            let model = read(&bytes).unwrap();
            let mesh = &model.meshes[0];
            let color = |t: usize| mesh.colors.get(mesh.triangles[t][0] as usize).copied();
            [color(0), color(1)]
        };
        let (red, blue) = (Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 0.0, 1.0, 1.0));
        assert_eq!(colored(b"", [0x8000 | 31 << 10, 0x8000 | 31]), [Some(red), Some(blue)]);
        assert_eq!(colored(b"", [0x8000 | 31 << 10, 31]), [Some(red), Some(PLAIN)]);
        assert_eq!(colored(b"", [31 << 10, 31]), [None, None]);
        let magics = b"STLB COLOR=\x00\xff\x00\xff,MATERIAL=";
        let green = Vec4::new(0.0, 1.0, 0.0, 1.0);
        assert_eq!(colored(magics, [31, 0xffff]), [Some(red), Some(green)]);
        assert_eq!(colored(magics, [31 << 10, 31 << 10]), [Some(blue), Some(blue)]);
    }

    #[test]
    fn text_needs_no_lines_and_a_number_that_is_none_costs_its_facet() {
        let lines = as_text();
        let one_line = lines
            .replace("\r\n", " ")
            .replace("solid square", "solid vertex of a facet");
        assert_eq!(
            read(one_line.as_bytes()).unwrap().meshes,
            read(lines.as_bytes()).unwrap().meshes
        );
        let padded = [lines.as_bytes(), &[0; 100]].concat();
        assert_eq!(read(&padded).unwrap().meshes[0].triangles.len(), 2);
        let model = read(lines.replacen("vertex 1 1", "vertex 1 -nan(ind)", 1).as_bytes()).unwrap();
        assert_eq!((model.meshes[0].triangles.len(), model.faults.len()), (1, 1));
        let mut bytes = as_binary(b"");
        bytes[HEADER + 12..HEADER + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        assert_eq!(read(&bytes).unwrap().meshes[0].triangles.len(), 1);
    }

    #[test]
    fn cut_and_flipped_bytes_never_panic() {
        for whole in [as_binary(b"x"), as_text().into_bytes()] {
            for_each_damage(&whole, |bytes| drop(read(bytes)));
        }
    }
}
