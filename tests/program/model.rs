//! A model file is a scene by itself.

use crate::common::{Folder, repo_str};
use batch_render::{
    compile::{self, Instancing},
    scene::{MatteKind, ObjectId},
};

fn pixels(folder: &Folder, name: &str) -> image::RgbImage {
    image::load_from_memory(&folder.read(name))
        .expect("a picture")
        .into_rgb8()
}

const SMALL: [&str; 6] = ["--resolution", "48x27", "--samples", "2", "--progress", "none"];

#[test]
fn a_model_is_a_scene_with_one_frame_beside_it() {
    let folder = Folder::new();
    for model in ["cube.obj", "cube.gltf"] {
        let path = repo_str(&format!("scenes/cube/{model}"));
        folder.succeed(&[&[path.as_str()], &SMALL[..]].concat());
    }
    assert_eq!(folder.names(), ["cube.0001.exr", "cube.0001.png"]);
    let picture = pixels(&folder, "cube.0001.png");
    let background = *picture.get_pixel(0, 0);
    let seen = picture.pixels().filter(|p| **p != background).count();
    let share = seen as f32 / picture.pixels().len() as f32;
    assert!((0.1..0.7).contains(&share), "{share} of the picture shows the cube");
    // It stands in the middle, and is red.
    let [r, g, _] = picture.get_pixel(24, 13).0;
    assert!(r > 2 * g, "{r} {g}");
}

#[test]
fn a_model_without_triangles_is_background_and_a_warning() {
    let folder = Folder::new();
    folder.write("points.obj", "v 0 0 0\nv 1 0 0\np 1 2\n");
    let output = folder.run(&[&["points.obj"], &SMALL[..]].concat());
    assert!(output.status.success());
    assert!(crate::common::stderr(&output).contains("the model has no triangles"));
    let picture = pixels(&folder, "points.0001.png");
    assert!(picture.pixels().all(|p| p == picture.get_pixel(0, 0)));
}

#[test]
fn a_turntable_begins_where_the_camera_stands_and_goes_once_around() {
    let folder = Folder::new();
    // Not the same from any two of four sides.
    folder.write("wedge.obj", "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -1 2 -1\nv 1 1 -1\nf 4 3 2 1\nf 1 2 6 5\nf 2 3 6\nf 3 4 5 6\nf 4 1 5\n");
    let run = |args: &[&str]| folder.succeed(&[&["wedge.obj"], &SMALL[..], args].concat());
    run(&["-o", "still.####.png"]);
    run(&["-o", "turn.#.png", "--turntable", "4"]);
    run(&["-o", "part.#.png", "--turntable", "4", "--range", "3"]);
    let turns: Vec<_> = (1..=4).map(|i| pixels(&folder, &format!("turn.{i}.png"))).collect();
    assert_eq!(turns[0], pixels(&folder, "still.0001.png"));
    assert_eq!(turns[2], pixels(&folder, "part.3.png"));
    for i in 0..4 {
        assert!(!turns[..i].contains(&turns[i]), "frame {} is seen before", i + 1);
    }
    let message = folder.fail(2, &["wedge.obj", "--turntable", "4", "--range", "5"]);
    assert!(message.contains("the turntable, which has frames 1 to 4"), "{message}");
}

#[test]
fn mirrored_meshes_keep_their_front() {
    let folder = Folder::new();
    let scene = |transform: &str| {
        format!(
            "[render]\nwidth = 32\nheight = 32\nsamples = 1\nintegrator.whitted = {{ ambient = 0.1 }}\n\
             [camera]\nperspective = {{ eye = [0, 1, 6], target = [0, 1, 0] }}\n\
             [material.m]\nphong = {{ color = [1, 1, 1] }}\n\
             [[light]]\nsun = {{ direction = [0, 0, -1], irradiance = 0.5 }}\n\
             [[object]]\nmaterial = \"m\"\nshape.mesh = {{ file = '{}' }}\n{transform}\n",
            repo_str("scenes/cube/cube.obj")
        )
    };
    for (name, transform) in [("plain", ""), ("mirrored", "transform = { scale = [1, 1, -1] }")] {
        folder.write(&format!("{name}.toml"), &scene(transform));
        folder.succeed(&[
            &format!("{name}.toml"),
            "--progress",
            "none",
            "-o",
            &format!("{name}.png"),
        ]);
    }
    // The front is lit, though its material is seen from one side only.
    let lit = pixels(&folder, "plain.png");
    assert_eq!(lit, pixels(&folder, "mirrored.png"));
    assert!(lit.get_pixel(16, 16).0[0] > 150);
}

#[test]
fn a_file_that_is_named_twice_is_placed_twice_and_brings_its_materials_once() {
    let folder = Folder::new();
    folder.write("a.mtl", "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n");
    folder.write(
        "a.obj",
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\nf 1 2 2\nusemtl blue\nf 3 2 1\n",
    );
    let object = "[[object]]\nshape.mesh = { file = 'a.obj' }\n";
    let scene = format!("{object}{object}transform = {{ translate = [0, 0, 3] }}\n");
    let desc = batch_render::describe::load(
        &folder.write("a.toml", &scene),
        &batch_render::describe::Overrides::default(),
        std::fs::read,
    )
    .expect("a scene");
    let scene = batch_render::compile::scene(&desc, batch_render::accel::AccelKind::default()).expect("sound");
    let geometry = scene.geometry.accel.geometry();
    // One of three triangles has no area.
    assert_eq!((geometry.triangles.len(), scene.geometry.meshes.len()), (4, 4));
    assert_eq!((scene.geometry.objects.len(), scene.shading.materials.len()), (2, 2));
    let materials: Vec<u32> = scene.geometry.meshes.iter().map(|m| m.material.0).collect();
    assert_eq!(materials, [0, 1, 0, 1]);
    let depths: Vec<f32> = (0..4).map(|i| geometry.corners(i)[0].z).collect();
    assert_eq!(depths, [0.0, 0.0, 3.0, 3.0]);
}

#[test]
fn materials_objects_and_nodes_keep_their_names() {
    let folder = Folder::new();
    // Three corners: (0, 0, 0), (1, 0, 0) and (0, 1, 0).
    folder.write(
        "robot.gltf",
        r#"{"asset": {"version": "2.0"}, "materials": [{"name": "steel"}],
            "buffers": [{"byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
            "nodes": [{"name": "arm", "children": [1, 2]}, {"name": "hand", "mesh": 0}, {"mesh": 0, "translation": [0, 0, 1]}]}"#,
    );
    let object = "[[object]]\nname = 'guard'\nshape.mesh = { file = 'robot.gltf' }\n";
    let floor = "[material.tiles]\nmatte = { albedo = 0.5 }\n[[object]]\nname = 'floor'\nmaterial = 'tiles'\nshape.plane = { point = [0, 0, 0], normal = [0, 1, 0] }\n";
    let desc = batch_render::describe::load(
        &folder.write("a.toml", &format!("{object}{floor}")),
        &batch_render::describe::Overrides::default(),
        std::fs::read,
    )
    .expect("a scene");
    for instancing in [Instancing::Never, Instancing::Always] {
        let scene = compile::scene_instancing(
            &desc,
            batch_render::accel::AccelKind::default(),
            &Default::default(),
            instancing,
        )
        .expect("sound");
        assert_eq!(scene.shading.material_names, ["tiles", "steel"]);
        let names: Vec<_> = scene.geometry.objects.iter().map(|o| o.name.as_str()).collect();
        assert_eq!(names, ["guard", "floor"]);
        let (guard, floor) = (ObjectId(0), ObjectId(1));
        assert_eq!(
            (scene.asset_name(floor), scene.asset_name(guard)),
            ("floor", "robot.gltf")
        );
        let instances = scene.geometry.instances.iter().map(|i| i.node);
        let meshes = scene.geometry.meshes.iter().map(|m| m.node);
        let nodes: Vec<_> = if instances.len() == 2 {
            instances.collect()
        } else {
            meshes.collect()
        };
        let parts: Vec<_> = nodes.iter().map(|node| scene.part_name(guard, *node)).collect();
        assert_eq!(parts, ["guard/arm/hand", "guard/arm/node 2"], "{instancing:?}");
        let names = |kind| -> Vec<_> {
            let mattes = &scene.mattes().table(kind).mattes;
            mattes.iter().map(|m| m.name.clone()).collect()
        };
        let mut objects = names(MatteKind::Object);
        objects.sort();
        assert_eq!(
            objects,
            ["floor", "guard/arm/hand", "guard/arm/node 2"],
            "{instancing:?}"
        );
        let counted = scene.mattes().parts().iter();
        let counted: Vec<_> = counted.map(|part| scene.part_name(part.object, part.node)).collect();
        assert_eq!(
            counted,
            ["guard/arm/hand", "guard/arm/node 2", "floor"],
            "{instancing:?}"
        );
        assert_eq!(names(MatteKind::Material), ["tiles", "steel"]);
        assert_eq!(names(MatteKind::Asset), ["robot.gltf", "floor"]);
    }
}

#[test]
fn bare_meshes_are_scenes_and_packed_ones_are_the_same() {
    use std::io::Write;
    let folder = Folder::new();
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
               element face 1\nproperty list uchar int vertex_indices\nend_header\n\
               -1 0 0\n1 0 0\n1 2 0\n-1 2 0\n4 0 1 2 3\n";
    let facet = |corners: [&str; 3]| {
        let corners = corners.map(|c| format!("vertex {c}\n")).concat();
        format!("facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n")
    };
    let facets = [["-1 0 0", "1 0 0", "1 2 0"], ["-1 0 0", "1 2 0", "-1 2 0"]].map(facet);
    folder.write("a.ply", ply);
    folder.write("a.stl", &format!("solid a\n{}endsolid a\n", facets.concat()));
    let file = std::fs::File::create(folder.path("a.ply.gz")).expect("a file");
    let mut packed = flate2::write::GzEncoder::new(file, flate2::Compression::best());
    packed.write_all(ply.as_bytes()).expect("written");
    packed.finish().expect("written");
    for (model, picture) in [("a.ply", "ply.png"), ("a.stl", "stl.png"), ("a.ply.gz", "gz.png")] {
        folder.succeed(&[&[model], &SMALL[..], &["-o", picture]].concat());
    }
    let pictures = ["ply.png", "stl.png", "gz.png"].map(|name| pixels(&folder, name));
    assert_eq!(pictures[0], pictures[1]);
    assert_eq!(pictures[0], pictures[2]);
}

#[test]
fn a_strict_job_says_each_loss_on_a_line_of_its_own() {
    let folder = Folder::new();
    folder.write("m.mtl", "newmtl a\nKd 1 0 0\ndisp d.png\nrefl r.png\n");
    folder.write("m.obj", "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let said = folder.fail(65, &["m.obj", "--strict", "--check"]);
    let errors: Vec<&str> = said.lines().filter(|line| line.starts_with("error: ")).collect();
    assert_eq!(errors.len(), 2, "{said}");
    assert!(errors[0].contains("disp") && errors[1].contains("refl"), "{said}");
}
