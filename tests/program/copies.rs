//! The pass `instanceId` counts the copies of meshes, whether they are stored once or baked.

use std::collections::BTreeSet;

use batch_render::{
    accel::AccelKind,
    assets::Store,
    batch::{Job, Request},
    compile::{self, Instancing},
    render::{Control, Renderer, StillScene},
    scene::Scene,
};

use crate::common::Folder;

/// The corners of a square of `n` times `n` cells of two triangles, from -0.4 to 0.4.
fn square(n: u32) -> Vec<f32> {
    let at = |i: u32| 0.8 * i as f32 / n as f32 - 0.4;
    let corners = |x, y| [[x, y], [x + 1, y], [x + 1, y + 1], [x, y], [x + 1, y + 1], [x, y + 1]];
    let cells = (0..n * n).flat_map(|cell| corners(cell % n, cell / n));
    cells.flat_map(|[x, y]| [at(x), at(y), 0.0]).collect()
}

/// Writes a model with nodes of two meshes: a card of two triangles and a sheet of 40,000. Each node is the number of its mesh and
/// its place. Then writes a scene in which the model stands at these heights.
fn write(folder: &Folder, nodes: &[(usize, f32, f32)], heights: &[f32]) {
    let meshes = [square(1), square(142)];
    let bytes: Vec<u8> = meshes.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let [card, sheet] = meshes.map(|mesh| mesh.len());
    let nodes: Vec<String> = nodes
        .iter()
        .enumerate()
        .map(|(i, (mesh, x, y))| {
            format!(
                r#"{{"name":"n{i}","mesh":{mesh},"translation":[{x},{y},{}]}}"#,
                -(*mesh as f32)
            )
        })
        .collect();
    let numbers: Vec<String> = (0..nodes.len()).map(|i| i.to_string()).collect();
    let bounds = r#""type":"VEC3","componentType":5126,"min":[-0.4,-0.4,0],"max":[0.4,0.4,0]"#;
    folder.write(
        "m.gltf",
        &format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{}]}}],"nodes":[{}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}},{{"primitives":[{{"attributes":{{"POSITION":1}}}}]}}],
            "buffers":[{{"uri":"m.bin","byteLength":{}}}],
            "bufferViews":[{{"buffer":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}}],
            "accessors":[{{"bufferView":0,"count":{},{bounds}}},{{"bufferView":1,"count":{},{bounds}}}]}}"#,
            numbers.join(","),
            nodes.join(","),
            bytes.len(),
            4 * card,
            4 * card,
            4 * sheet,
            card / 3,
            sheet / 3,
        ),
    );
    std::fs::write(folder.path("m.bin"), bytes).expect("writable");
    let objects: String = heights
        .iter()
        .enumerate()
        .map(|(i, y)| {
            format!("[[object]]\nname = 'o{i}'\nshape.mesh = {{ file = 'm.gltf' }}\ntransform = {{ translate = [0, {y}, 0] }}\n")
        })
        .collect();
    folder.write(
        "s.toml",
        &format!(
            "[render]\nwidth = 130\nheight = 30\nsamples = 1\n[camera]\n\
             perspective = {{ eye = [0, 0, 40], target = [0, 0, 0], fov = 8.5 }}\n[output]\naovs = ['instanceId']\n{objects}"
        ),
    );
}

/// The scene and the numbers of its copies in a picture.
fn numbers(folder: &Folder, instancing: Instancing) -> (Scene, Vec<u32>) {
    let job = Job::open(&folder.path("s.toml"), &Request::default()).expect("a job");
    let scene = compile::scene_instancing(&job.desc, AccelKind::Wide, &Store::default(), instancing).expect("a scene");
    let (frame, still) = (&job.plan.frames[0], &mut StillScene(&scene));
    let film = (job.plan).render_frame(&Renderer::new(), still, (frame, &frame.camera), &Control::default());
    let film = film.expect("a film");
    let plane = film.plane("instanceId").expect("it was asked for");
    let numbers = plane.values.iter().map(|value| value.to_bits()).collect();
    (scene, numbers)
}

#[test]
fn numbers_of_125_baked_copies_equal_those_of_instances() {
    let folder = Folder::new();
    let places: Vec<_> = (0..125)
        .map(|i| (0, (i % 25) as f32 - 12.0, (i / 25) as f32 - 2.0))
        .collect();
    write(&folder, &places, &[0.0]);
    let (baked, copies) = numbers(&folder, Instancing::Auto);
    let (shared, instances) = numbers(&folder, Instancing::Always);
    assert_eq!(
        (baked.geometry.instances.len(), shared.geometry.instances.len()),
        (0, 125)
    );
    assert!(copies == instances);
    let seen: BTreeSet<u32> = copies.into_iter().collect();
    assert!(seen.into_iter().eq(0..=125));
    // Their names are beside the picture.
    folder.succeed(&["s.toml", "--progress", "none", "-o", "f.exr", "--metadata", "ids"]);
    let ids: serde_json::Value = serde_json::from_slice(&folder.read("ids.json")).expect("JSON");
    let names = ids["instanceId"].as_array().expect("a list");
    assert!(names.len() == 125 && names[124] == "o0/n124", "{names:?}");
}

#[test]
fn copies_within_instances_have_numbers_of_their_own() {
    let folder = Folder::new();
    let places = [(1, 2.0, 0.0), (0, -1.0, 0.0), (0, 0.0, 0.0), (0, 1.0, 0.0)];
    write(&folder, &places, &[-1.0, 1.0]);
    let (shared, within) = numbers(&folder, Instancing::Auto);
    let (baked, alone) = numbers(&folder, Instancing::Never);
    assert_eq!(
        (baked.geometry.instances.len(), shared.geometry.instances.len()),
        (0, 2)
    );
    assert!(within == alone);
    let seen: BTreeSet<u32> = within.into_iter().collect();
    assert!(seen.into_iter().eq(0..=8));
    // A mesh that is shown once has no number.
    write(&folder, &places[..2], &[0.0]);
    assert!(numbers(&folder, Instancing::Auto).1.iter().all(|number| *number == 0));
}
