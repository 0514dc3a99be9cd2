use super::*;
use crate::assets::MemoryBudget;

fn read(text: &str) -> Result<Model, ObjError> {
    parse(
        text.as_bytes(),
        Path::new("nowhere/a.obj"),
        FaceUse::Triangles,
        &Files::default(),
    )
}

/// Two squares that meet at the z axis with a right angle between them.
const CORNER: &str = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nv 0 1 0\nv 0 1 1\n";

#[test]
fn faces_of_one_smoothing_group_share_normals_and_others_are_flat() {
    let faces = "f 1 2 3 4\nusemtl b\nf 1 5 6 2\n";
    let flat = read(&format!("{CORNER}{faces}")).unwrap();
    assert!(flat.meshes.iter().all(|m| m.normals.is_empty()));
    let smooth = read(&format!("{CORNER}s 1\n{faces}")).unwrap();
    // Two meshes, because of the material, yet one surface.
    let diagonal = Vec3::new(1.0, 1.0, 0.0).normalize();
    for mesh in &smooth.meshes {
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            let expected = if p.x == p.y { diagonal } else { Vec3::new(p.y, p.x, 0.0) };
            assert!((*n - expected).length() < 1e-6, "{p}: {n}");
        }
    }
    let apart = read(&format!("{CORNER}s 1\nf 1 2 3 4\ns 2\nf 1 5 6 2\n")).unwrap();
    assert!(apart.meshes[1].normals.iter().all(|n| (*n - Vec3::X).length() < 1e-6));
}

#[test]
fn normals_of_the_file_win_over_smoothing_groups() {
    let model = read(&format!("{CORNER}vn 0 2 0\ns 1\nf 1//1 2//1 3//1\n")).unwrap();
    assert_eq!(model.meshes[0].normals, [Vec3::Y; 3]);
}

#[test]
fn relative_and_mixed_corners_are_read() {
    let model = read(&format!(
        "{CORNER}vt 0 0\nvt 1 0\nvt 1 1\nf -6/-3 -5/-2 -4/-1\nf 1/1 2 3/3\n"
    ))
    .unwrap();
    assert_eq!(model.meshes[0].uvs, [Vec2::ZERO, Vec2::X, Vec2::ONE]);
    assert!(model.meshes[1].uvs.is_empty());
    assert_eq!(model.meshes[0].positions, model.meshes[1].positions);
}

#[test]
fn vertices_in_the_coordinates_of_a_map_lose_nothing() {
    let moved = |x: f64, z: f64| {
        let corner = |line: &str| {
            let p: Vec<f64> = line.split(' ').skip(1).map(|n| n.parse().unwrap()).collect();
            format!("v {:.2} {:.2} {:.2}\n", x + 0.2 * p[0], 0.2 * p[1], z + 0.2 * p[2])
        };
        let vertices: String = CORNER.lines().map(corner).collect();
        read(&format!("{vertices}s 1\nf 1 2 3 4\nf 1 5 6 2\n")).unwrap()
    };
    let (near, far) = (moved(0.0, 0.0), moved(431_250.0, 5_649_830.0));
    assert_eq!(near.instances[0].model_from_mesh, DAffine3::IDENTITY);
    let place = far.instances[0].model_from_mesh.translation;
    assert_eq!(place, crate::math::DVec3::new(431_250.0, 0.0, 5_649_830.0));
    assert_eq!(near.meshes, far.meshes);
    let bounds = far.bounds();
    assert!((bounds.min - place).length() < 1e-6 && (bounds.max - place - 0.2).length() < 1e-6);
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    let message = |text: &str| read(text).unwrap_err().to_string();
    assert_eq!(
        message(&format!("{CORNER}f 1 2 7\n")),
        "line 7: a face names vertex 7, but there are only 6: nowhere/a.obj"
    );
    assert_eq!(
        message("v 0 0 0\nv 1 one 0\nv 0 1 0\nf 1 2 3\n"),
        "line 2: expected a number, found 'one': nowhere/a.obj"
    );
    assert_eq!(
        message("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 three\n"),
        "line 4: expected the number of a vertex, found 'three': nowhere/a.obj"
    );
    assert_eq!(message("f\n"), "line 1: a face without corners: nowhere/a.obj");
    assert_eq!(
        message("v 0 0\n"),
        "line 1: a vertex has too few numbers: nowhere/a.obj"
    );
}

#[test]
fn files_without_faces_are_models_without_parts() {
    for text in [
        "",
        "# nothing\n",
        "v 0 0 0\np 1\n",
        "v 0 0 0\nv 1 1 1\nl 1 2\nf 1 2\n",
        "\u{0}\u{1}",
    ] {
        assert!(read(text).unwrap().instances.is_empty(), "{text:?}");
    }
}

#[test]
fn cut_and_flipped_bytes_never_panic() {
    let whole = format!("{CORNER}vt 0 0\nvn 0 1 0\ns 1\nf 1/1/1 2/1/1 3/-1/-1 4//1\nusemtl a\nf 1 5 6 -5 \\\n 2\n");
    for i in 0..whole.len() {
        let _ = parse(
            &whole.as_bytes()[..i],
            Path::new("a.obj"),
            FaceUse::Triangles,
            &Files::default(),
        );
        for byte in [b'\n', b'-', b'9', b'/', b' ', b'e', 0, 0xff] {
            let mut changed = whole.clone().into_bytes();
            changed[i] = byte;
            let _ = parse(&changed, Path::new("a.obj"), FaceUse::Triangles, &Files::default());
        }
    }
}

#[test]
fn colours_of_vertices_are_display_values_that_multiply_the_material() {
    let of = |colors: [&str; 3]| {
        let [a, b, c] = colors;
        read(&format!("v 0 0 0 {a}\nv 1 0 0 {b}\nv 0 1 0 {c}\nf 1 2 3\n")).unwrap()
    };
    let model = of(["1 0 0", "0.5 0.5 0.5", ""]);
    let gray = srgb::decode(0.5);
    let expected = [[1.0, 0.0, 0.0, 1.0], [gray, gray, gray, 1.0], [1.0; 4]].map(Vec4::from_array);
    assert_eq!(model.meshes[0].colors, expected);
    let surface = model.materials[0].surface;
    assert!(surface.reads_vertices);
    assert_eq!(
        surface.base_color,
        crate::texture::Color::Constant(crate::math::Rgb::WHITE)
    );
    let bytes = of(["255 0 0", "0 255 0", "0 0 255"]);
    assert_eq!(bytes.meshes[0].colors[1], Vec4::new(0.0, 1.0, 0.0, 1.0));
    let mixed = of(["255 0 0", "0 255 0", ""]);
    assert_eq!(mixed.meshes[0].colors[2], Vec4::ONE);
    // White tells nothing, and a part without a colour keeps its grey.
    let white = of(["1 1 1"; 3]);
    assert!(white.meshes[0].colors.is_empty() && !white.materials[0].surface.reads_vertices);
}

#[test]
fn a_normal_that_is_no_number_gives_way_to_the_face() {
    let model = read(&format!("{CORNER}vn nan 0 0\nvn 0 2 0\nf 1//1 2//2 3//2\n")).unwrap();
    assert_eq!(model.meshes[0].normals, [Vec3::ZERO, Vec3::Y, Vec3::Y]);
}

#[test]
fn keywords_may_have_any_case_and_parts_keep_the_names_of_their_groups() {
    let text = format!("{CORNER}O house\nG roof\nUSEMTL a\nF 1 2 3\ng wall\nf 1 2 4\n");
    let model = read(&text.replace("v ", "V ")).unwrap();
    let names: Vec<_> = model
        .instances
        .iter()
        .map(|part| model.nodes[part.node.unwrap()].clone())
        .collect();
    assert_eq!(names[0].name, "roof");
    assert_eq!(names[1].name, "wall");
    assert_eq!(model.nodes[names[1].parent.unwrap()].name, "house");
    assert_eq!(model.materials[0].name, "a");
}

#[test]
fn vertices_that_are_no_numbers_cost_their_faces_alone() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -nan(ind) 1.#INF 0\n";
    let read = |faces: &str| {
        let text = format!("{square}{faces}");
        parse(
            text.as_bytes(),
            Path::new("a.obj"),
            FaceUse::Triangles,
            &Files::default(),
        )
        .unwrap()
    };
    let model = read("f 1 2 3 4\nf 3 4 5\nf 1 2 3 5\n");
    assert_eq!(model.meshes[0].triangles.len(), 2);
    assert_eq!(model.faults, ["vertices that are not finite are left out: 1"]);
    // One that no face uses costs nothing.
    assert!(read("f 1 2 3 4\n").faults.is_empty());
    // Far from the origin, too.
    let far = "v 431250.5 0 0\nv 431251.5 0 0\nv 431251.5 1 0\nv nan 1 0\nf 1 2 3\nf 2 3 4\n";
    let model = parse(
        far.as_bytes(),
        Path::new("a.obj"),
        FaceUse::Triangles,
        &Files::default(),
    )
    .unwrap();
    assert_eq!(model.meshes[0].triangles.len(), 1);
}

#[test]
fn geometry_that_is_not_rendered_is_a_feature() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nl 1 2\nl 2 3\np 1\ncstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 1\n\
                parm u 0 1\nend\ncall other.obj\n";
    let model = parse(
        text.as_bytes(),
        Path::new("a.obj"),
        FaceUse::Triangles,
        &Files::default(),
    )
    .unwrap();
    let features: Vec<_> = model.features.iter().map(|f| (f.name.as_str(), f.count)).collect();
    assert_eq!(features, [("p", 1), ("l", 2), ("surf", 1), ("call", 1)]);
    assert_eq!(
        model.features[2].loss().unwrap(),
        "not rendered: surf, used by 1 statement (free-form surfaces)"
    );
}

#[test]
fn colors_out_of_range_are_cut_and_said() {
    let red = |colors: [&str; 3]| {
        let [a, b, c] = colors;
        let model = read(&format!("v 0 0 0 {a}\nv 1 0 0 {b}\nv 0 1 0 {c}\nf 1 2 3\n")).unwrap();
        (model.meshes[0].colors[0].x, model.faults.len())
    };
    assert_eq!(red(["1 0 0", "0.5 0 0", "0 0 0"]), (1.0, 0));
    assert_eq!(red(["255 0 0", "0 9 0", "0 0 0"]), (1.0, 0));
    assert_eq!(red(["1.5 0 0", "0.5 0 0", "0 0 0"]), (1.0, 1));
    assert_eq!(red(["-0.5 0 0", "0.5 0 0", "0 0 0"]), (0.0, 1));
    assert_eq!(red(["300 0 0", "0.5 0 0", "0 0 0"]), (1.0, 1));
}

#[test]
fn a_file_that_takes_more_memory_than_is_allowed_is_not_read() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("a.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".repeat(1000)).unwrap();
    let load_with = |kibibytes: u64| {
        let files = Files::new(false, MemoryBudget::new(Some(kibibytes << 10)));
        load(&path, FaceUse::Triangles, &files)
    };
    assert!(load_with(200).is_ok());
    let refused = load_with(100).unwrap_err().to_string();
    assert!(refused.contains("are allowed (--max-memory)"), "{refused}");
}
