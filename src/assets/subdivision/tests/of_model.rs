//! Subdivision of models of all formats.

use std::{path::Path, sync::Arc};

use super::super::{SubdivisionProblem, subdivide};
use crate::{
    assets::{
        Files, MemoryBudget,
        model::{FaceUse, Model, ModelTexture, Subdivision},
        obj,
    },
    math::Vec3,
    shape::mesh::Scheme,
    texture::{Color, TextureId},
};

/// A cube from -1 to 1 of six squares in two groups with a material each, and a lone triangle of another object.
const CUBE: &str = "o box\nv -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\ng sides\nusemtl a\nf 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\ng ends\nusemtl b\nf 1 3 4 2\nf 5 6 8 7\n";

pub(super) fn model(text: &str) -> Model {
    let parsed = obj::parse(
        text.as_bytes(),
        Path::new("a.obj"),
        FaceUse::Polygons,
        &Files::default(),
    );
    parsed.expect("a model")
}

fn subdivided(text: &str, how: &Subdivision) -> Model {
    let mut model = model(text);
    subdivide(&mut model, how, None, true, &MemoryBudget::default()).expect("memory enough");
    model
}

fn assert_near(a: Vec3, b: Vec3) {
    assert!((a - b).length() < 1e-6, "{a} is not {b}");
}

#[test]
fn polygons_are_refined_over_the_groups_of_an_object() {
    let fine = subdivided(CUBE, &Subdivision::of_levels(2));
    let counts: Vec<usize> = fine.meshes.iter().map(|mesh| mesh.triangles.len()).collect();
    assert_eq!(counts, [4 * 16 * 2, 2 * 16 * 2]);
    for mesh in &fine.meshes {
        assert_eq!((mesh.validate(), mesh.normals.len()), (Ok(()), mesh.positions.len()));
        let corners = mesh
            .positions
            .iter()
            .filter(|p| (p.abs() - 0.5).abs().max_element() < 1e-6);
        assert_eq!(corners.count(), 8, "the limit of the corners of a whole cube");
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!(p.normalize().dot(*n) > 0.97, "{n} at {p}");
        }
    }
    // The object alone has other limits than a part of it.
    let ends = CUBE.replace("o box\n", "").replace("g ends", "o ends");
    let torn = subdivided(&ends, &Subdivision::of_levels(1));
    assert!(torn.meshes[1].positions.iter().all(|p| p.z.abs() == 1.0));
}

#[test]
fn triangles_alone_are_refined_by_loop_and_others_by_what_is_asked_for() {
    let tetrahedron = "v 1 1 1\nv -1 -1 1\nv -1 1 -1\nv 1 -1 -1\nf 1 2 4\nf 1 3 2\nf 1 4 3\nf 2 3 4\n";
    let fine = subdivided(tetrahedron, &Subdivision::of_levels(2));
    assert!(model(tetrahedron).meshes[0].polygons.is_empty());
    assert_eq!(fine.meshes[0].triangles.len(), 64);
    // The rule of a vertex of valence 3 weights each neighbour by 3/16, the limit by 1/5.
    assert_near(fine.meshes[0].positions[0], Vec3::splat(1.0 - 0.6 - 0.2));
    let by = |scheme| Subdivision {
        scheme: Some(scheme),
        ..Subdivision::of_levels(1)
    };
    assert_eq!(
        subdivided(tetrahedron, &by(Scheme::CatmullClark)).meshes[0]
            .triangles
            .len(),
        24
    );
    let counts = |scheme| {
        subdivided(CUBE, &by(scheme))
            .meshes
            .iter()
            .map(|m| m.triangles.len())
            .sum::<usize>()
    };
    assert_eq!(Scheme::ALL.map(counts), [48, 48, 48]);
    let linear = subdivided(CUBE, &by(Scheme::Linear));
    for mesh in &linear.meshes {
        // Edges of 90 degrees stay sharp.
        let far = mesh.normals.iter().map(|n| n.abs().max_element() - 1.0);
        assert!(far.map(f32::abs).all(|far| far < 1e-6));
    }
}

#[test]
fn vertices_that_differ_in_number_alone_are_one() {
    let sheet = "v 0 0 0\nv 1 0.5 0\nv 2 0 0\nv 0 0 1\nv 1 0.5 1\nv 2 0 1\nvt 0 0\nvt 0.5 0\nvt 1 0\nvt 0 1\nvt 0.5 1\nvt 1 1\n";
    let whole = format!("{sheet}f 1/1 4/4 5/5 2/2\nf 2/2 5/5 6/6 3/3\n");
    // The same with texture coordinates of each face's own.
    let apart = format!("{sheet}vt 0.5 0\nvt 0.5 1\nf 1/1 4/4 5/5 2/2\nf 2/7 5/8 6/6 3/3\n");
    let [whole, apart] = [whole, apart].map(|text| subdivided(&text, &Subdivision::of_levels(2)));
    let [a, b] = [&whole.meshes[0], &apart.meshes[0]];
    assert_eq!(
        (&a.positions, &a.uvs, &a.triangles),
        (&b.positions, &b.uvs, &b.triangles)
    );
}

#[test]
fn broken_vertices_cost_their_faces_and_degenerate_meshes_stay() {
    let fine = subdivided(&CUBE.replace("v 1 1 1\n", "v nan 1 1\n"), &Subdivision::of_levels(1));
    let triangles: usize = fine.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    assert_eq!(triangles, 3 * 4 * 2);
    let point = subdivided(
        "v 0 0 0\nv 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3 4\n",
        &Subdivision::of_levels(3),
    );
    assert_eq!(point.meshes[0].triangles.len(), 2);
}

#[test]
fn memory_and_the_most_triangles_are_checked_before_they_are_taken() {
    let refused = |levels: u32, limit: u64| {
        let refused = subdivide(
            &mut model(CUBE),
            &Subdivision::of_levels(levels),
            None,
            true,
            &MemoryBudget::new(Some(limit)),
        );
        refused.expect_err("too much").to_string()
    };
    assert_eq!(
        refused(8, 64 << 20),
        "`subdivide = 8` makes 786432 triangles of it: models need 177 MiB of memory, and 64 MiB are allowed (--max-memory)"
    );
    assert_eq!(
        refused(12, u64::MAX),
        "`subdivide = 12` makes 201326592 triangles of it, more than the 134217728 that there can be"
    );
}

#[test]
fn tangents_need_more_memory_than_a_mesh_without_them() {
    let how = Subdivision::of_levels(3);
    // 768 triangles in a group of two meshes, of 180 and 56 bytes, or of 300 and 56.
    let budget = MemoryBudget::new(Some(768 * 300));
    let mut mapped = model(CUBE);
    for mesh in mapped.meshes.iter_mut().map(Arc::make_mut) {
        mesh.uvs = mesh.positions.iter().map(|p| p.truncate()).collect();
    }
    subdivide(&mut mapped.clone(), &how, None, true, &budget).expect("memory enough");
    mapped.textures.push(ModelTexture::of_image(0));
    mapped.materials[1].surface.normal = Some(Color::Texture(TextureId(0)));
    let refused = subdivide(&mut mapped.clone(), &how, None, true, &budget).expect_err("too much");
    assert!(
        matches!(refused, SubdivisionProblem::Memory { triangles: 768, .. }),
        "{refused}"
    );
    let budget = MemoryBudget::new(Some(768 * 356));
    subdivide(&mut mapped, &how, None, true, &budget).expect("memory enough");
    assert!(!mapped.meshes[1].tangents.is_empty() && mapped.meshes[0].tangents.is_empty());
}
