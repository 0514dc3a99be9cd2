use super::*;
use crate::assets::bare::for_each_damage;
use crate::math::{Vec2, Vec4, srgb};

fn read(bytes: &[u8]) -> Result<Model, String> {
    let problem = |e: BareMeshProblem| e.at("a.ply".into()).to_string();
    parse(bytes, FaceUse::Triangles, &MemoryBudget::default()).map_err(problem)
}

const HEADER: &str = "\
element vertex 4
property float x
property float y
property double z
property uchar red
property uchar green
property uchar blue
property uchar alpha
property list uchar short extra
property float texture_u
property float texture_v
element face 2
property uchar flags
property list uchar int vertex_indices
element edge 1
property int vertex1
end_header
";

fn as_text() -> String {
    format!(
        "ply\nformat ascii 1.0\ncomment x\nobj_info y\n{HEADER}\
         0 0 0 255 0 0 255 0 0 0\n1 0 0 0 255 0 255 1 7 1 0\n1 1 0 0 0 255 51 0 1 1\n0 1 0 188 188 188 255 0 0 1\n\
         9 3 0 1 2\n9 3 0 2 3\n5\n"
    )
}

fn as_binary(is_big: bool) -> Vec<u8> {
    let name = if is_big { "big" } else { "little" };
    let mut out = format!("ply\nformat binary_{name}_endian 1.0\n{HEADER}").into_bytes();
    let turn = |mut bytes: Vec<u8>| {
        if is_big {
            bytes.reverse();
        }
        bytes
    };
    let number = |v: f32| turn(v.to_le_bytes().to_vec());
    let vertices = [
        ([0.0, 0.0], [255, 0, 0, 255], [0.0, 0.0]),
        ([1.0, 0.0], [0, 255, 0, 255], [1.0, 0.0]),
        ([1.0, 1.0], [0, 0, 255, 51], [1.0, 1.0]),
        ([0.0, 1.0], [188, 188, 188, 255], [0.0, 1.0]),
    ];
    for (i, (place, color, uv)) in vertices.into_iter().enumerate() {
        out.extend(place.into_iter().flat_map(number));
        out.extend([0; 8]);
        out.extend(color);
        out.push(u8::from(i == 1));
        if i == 1 {
            out.extend(turn(7_i16.to_le_bytes().to_vec()));
        }
        out.extend(uv.into_iter().flat_map(number));
    }
    let index = |v: &i32| turn(v.to_le_bytes().to_vec());
    for face in [[0, 1, 2], [0, 2, 3]] {
        out.extend([9, 3]);
        out.extend(face.iter().flat_map(index));
    }
    out.extend(index(&5));
    out
}

#[test]
fn text_and_bytes_in_either_order_give_the_same_mesh() {
    let model = read(as_text().as_bytes()).unwrap();
    let mesh = &model.meshes[0];
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.positions[2], Vec3::new(1.0, 1.0, 0.0));
    assert_eq!(mesh.colors[0], Vec4::new(1.0, 0.0, 0.0, 1.0));
    assert_eq!(mesh.colors[2].w, 0.2);
    assert_eq!(mesh.colors[3].x, srgb::decode8(188));
    assert_eq!(mesh.uvs, [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
    assert!(model.materials[0].surface.reads_vertices);
    for is_big in [false, true] {
        assert_eq!(read(&as_binary(is_big)).unwrap().meshes, model.meshes);
    }
    assert_eq!(
        read(as_text().replace('\n', "\r\n").as_bytes()).unwrap().meshes,
        model.meshes
    );
}

/// A file of vertices in a plane, and faces.
fn flat(vertices: &[[f32; 2]], faces: &str) -> String {
    let count = faces.lines().count();
    let vertices: String = vertices.iter().map(|[x, y]| format!("{x} {y} 0 0 0 2\n")).collect();
    format!(
        "ply\nformat ascii 1.0\nelement face {count}\nproperty list int uint vertex_index\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n{faces}{vertices}",
        vertices.lines().count()
    )
}

#[test]
fn faces_may_have_any_number_of_corners_and_come_first() {
    let dart = [[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]];
    let model = read(flat(&dart, "4 0 1 2 3\n2 0 1\n0\n3 0 1 2\n").as_bytes()).unwrap();
    let mesh = &model.meshes[0];
    assert_eq!(mesh.normals, [Vec3::Z; 4]);
    assert_eq!((mesh.triangles.len(), mesh.triangles[0]), (3, [0, 1, 2]));
    let area: f32 = (1..3)
        .map(|i| mesh.corners(i))
        .map(|[a, b, c]| (b - a).cross(c - a).z * 0.5)
        .sum();
    assert_eq!(area, 4.0);
    assert!(!model.materials[0].surface.reads_vertices);
}

#[test]
fn faces_that_name_no_vertex_are_refused() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let message = |faces: &str| read(flat(&square, faces).as_bytes()).unwrap_err();
    assert!(message("3 0 1 4\n").contains("names vertex 4, but there are only 4"));
    assert!(message("4 0 1 2 4\n").contains("names vertex 4, but there are only 4"));
    assert!(message("3 0 1 -1\n").contains("vertex -1"));
    assert!(message("3 0 1 1.5\n").contains("vertex 1.5"));
    assert!(message("-3 0 1 1\n").contains("a list of -3 numbers"));
    assert!(message("4000000000 0 1 1\n").contains("a list of 4000000000 numbers"));
    assert!(message("3 0 x 1\n").contains("face 0: expected a number, found 'x'"));
}

#[test]
fn vertices_without_faces_are_points_as_large_as_their_distance() {
    let row: Vec<[f32; 2]> = (0..9_u8).map(|i| [f32::from(i) * 0.25, 0.0]).collect();
    let model = read(flat(&row, "").as_bytes()).unwrap();
    assert!(model.meshes.is_empty() && model.instances.is_empty());
    let points = model.points.as_ref().expect("a cloud");
    assert_eq!((points.positions.len(), points.radius), (9, 0.25));
    let bounds = model.bounds();
    assert_eq!([bounds.min.x, bounds.max.x], [-0.25, 2.25]);
    assert!(read(flat(&[], "").as_bytes()).unwrap().is_empty());
}

#[test]
fn doubles_and_text_far_away_are_relative_to_an_origin() {
    let place = DVec3::new(431_250.125, 20.0, 5_649_830.375);
    let header = |format| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let corners = [DVec3::ZERO, DVec3::X * 0.001, DVec3::Y * 0.001].map(|p| place + p);
    let lines = corners.map(|p| format!("{} {} {}\n", p.x, p.y, p.z)).concat();
    let text = header("ascii") + &lines + "3 0 1 2\n";
    let mut binary = header("binary_little_endian").into_bytes();
    binary.extend(corners.iter().flat_map(|p| p.to_array()).flat_map(f64::to_le_bytes));
    binary.push(3);
    binary.extend([0_i32, 1, 2].into_iter().flat_map(i32::to_le_bytes));
    for bytes in [text.as_bytes(), &binary] {
        let model = read(bytes).unwrap();
        let origin = model.instances[0].model_from_mesh.translation;
        for (found, expected) in model.meshes[0].positions.iter().zip(&corners) {
            let error = (origin + found.as_dvec3() - *expected).length();
            assert!(error < 1e-7, "{error}");
        }
    }
}

#[test]
fn counts_beyond_the_file_are_refused_before_memory_is_taken() {
    for whole in [as_text().into_bytes(), as_binary(false)] {
        let text = String::from_utf8_lossy(&whole).into_owned();
        for element in ["vertex 4", "face 2", "edge 1"] {
            let many = element.split(' ').next().unwrap().to_owned() + " 4000000000";
            let at = text.find(element).unwrap();
            let bytes = [&whole[..at], many.as_bytes(), &whole[at + element.len()..]].concat();
            let message = read(&bytes).unwrap_err();
            assert!(message.contains("4000000000 elements"), "{message}");
        }
    }
    // What takes no bytes takes no time.
    let empty = "ply\nformat ascii 1.0\nelement nothing 4000000000\nend_header\n";
    assert!(read(empty.as_bytes()).unwrap().instances.is_empty());
    assert!(read(&as_binary(false)[..400]).unwrap_err().contains("the file"));
    let little = parse(as_text().as_bytes(), FaceUse::Triangles, &MemoryBudget::new(Some(10)));
    assert!(matches!(little, Err(BareMeshProblem::Memory(_))));
}

#[test]
fn cut_and_flipped_bytes_never_panic() {
    for whole in [as_text().into_bytes(), as_binary(false), as_binary(true)] {
        for_each_damage(&whole, |bytes| drop(read(bytes)));
    }
}

/// A file of text with two separate squares in the xy plane, and what comes after them.
fn squares(vertex_properties: &str, vertex_values: &str, elements: &str, data: &str) -> String {
    let places = ["0 0", "1 0", "1 1", "0 1", "2 0", "3 0", "3 1", "2 1"];
    let vertices = places.map(|p| format!("{p} 0 {vertex_values}\n")).concat();
    format!(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n{vertex_properties}\
         {elements}end_header\n{vertices}{data}"
    )
}

const COLORED_FACES: &str = "element face 2\nproperty uchar red\nproperty list uchar int vertex_indices\nproperty uchar green\n\
                             property uchar blue\n";

#[test]
fn colors_of_faces_color_their_corners() {
    let model = read(squares("", "", COLORED_FACES, "255 4 0 1 2 3 0 0\n0 4 4 5 6 7 0 255\n").as_bytes()).unwrap();
    let mesh = &model.meshes[0];
    assert!(model.materials[0].surface.reads_vertices && model.faults.is_empty());
    let color = |t: usize| mesh.triangles[t].map(|v| mesh.colors[v as usize]);
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (4, 8));
    assert_eq!(color(0), [Vec4::new(1.0, 0.0, 0.0, 1.0); 3]);
    assert_eq!(color(3), [Vec4::new(0.0, 0.0, 1.0, 1.0); 3]);
    // Faces that share vertices keep their colours apart.
    let shared = read(squares("", "", COLORED_FACES, "255 3 0 1 2 0 0\n0 3 0 2 3 0 255\n").as_bytes()).unwrap();
    assert_eq!(shared.meshes[0].positions.len(), 6);
    // Colours of vertices come first, and it is said.
    let colors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let both = squares(
        colors,
        "0 255 0",
        COLORED_FACES,
        "255 4 0 1 2 3 0 0\n0 4 4 5 6 7 0 255\n",
    );
    let model = read(both.as_bytes()).unwrap();
    assert_eq!(model.meshes[0].colors, [Vec4::new(0.0, 1.0, 0.0, 1.0); 8]);
    assert_eq!(model.faults.len(), 1);
}

#[test]
fn corners_have_texture_coordinates_of_their_own() {
    let faces = "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n";
    let data = "4 0 1 2 3 8 0 0 1 0 1 1 0 1\n3 0 2 3 6 0.5 0 1 1 0 1\n";
    let model = read(squares("", "", faces, data).as_bytes()).unwrap();
    let mesh = &model.meshes[0];
    // Vertex 0 has two pairs of coordinates, 2 and 3 have one each.
    assert_eq!(mesh.positions.len(), 5);
    let uvs = mesh.triangles[2].map(|v| mesh.uvs[v as usize]);
    assert_eq!(uvs, [Vec2::new(0.5, 0.0), Vec2::ONE, Vec2::Y]);
    // A list that is too short stands for 0.
    assert!(read(squares("", "", faces, "4 0 1 2 3 2 1 1\n3 4 5 6 0\n").as_bytes()).is_ok());
}

#[test]
fn strips_of_triangles_keep_their_side() {
    let strips = "element tristrips 1\nproperty list int int vertex_indices\n";
    let model = read(squares("", "", strips, "9 0 1 3 2 -1 4 5 7 6\n").as_bytes()).unwrap();
    let mesh = &model.meshes[0];
    assert_eq!(mesh.triangles, [[0, 1, 3], [3, 1, 2], [4, 5, 7], [7, 5, 6]]);
    assert!(model.points.is_none() && model.features.is_empty());
    assert!(
        read(squares("", "", strips, "3 0 1 9\n").as_bytes())
            .unwrap_err()
            .contains("vertex 9")
    );
    assert!(
        read(squares("", "", strips, "3 0 1 -2\n").as_bytes())
            .unwrap_err()
            .contains("vertex -2")
    );
}

#[test]
fn gaussian_splats_are_refused_by_their_name() {
    let properties = ["f_dc_0", "f_dc_1", "opacity", "scale_0", "rot_0"].map(|p| format!("property float {p}\n"));
    let splats = squares(&properties.concat(), "0 0 0 0 0", "", "");
    assert!(read(splats.as_bytes()).unwrap_err().contains("Gaussian splats"));
}

#[test]
fn a_number_that_is_none_costs_its_vertex_alone() {
    let face = "element face 1\nproperty list uchar int vertex_indices\n";
    let mesh = squares("", "", face, "4 0 1 2 3\n").replace("2 0 0 \n", "-nan(ind) 1.#INF 0 \n");
    let model = read(mesh.as_bytes()).unwrap();
    assert_eq!(
        (model.meshes[0].positions.len(), model.meshes[0].triangles.len()),
        (7, 2)
    );
    assert_eq!(model.faults, ["vertices that are not finite are left out: 1"]);
    let cloud = read(squares("", "", "", "").replace("1 1 0 \n", "nan 1 0 \n").as_bytes()).unwrap();
    assert_eq!(cloud.points.expect("a cloud").positions.len(), 7);
    let colors = "property float red\nproperty float green\nproperty float blue\n";
    let model = read(squares(colors, "255 128 0", face, "4 0 1 2 3\n").as_bytes()).unwrap();
    let expected = Vec4::new(1.0, srgb::decode(128.0 / 255.0), 0.0, 1.0);
    assert_eq!((model.meshes[0].colors[0], model.faults.len()), (expected, 1));
    assert!(read(b"").is_err());
}
