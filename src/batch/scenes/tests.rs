use std::{fs, path::Path};

use super::*;
use crate::{
    batch::{Job, Request},
    render::{Control, Renderer, StillScene},
    texture::bitmap::Storage,
};

const SCENE: &str = r#"
[render]
width = 20
height = 16
samples = 4
[camera]
perspective = { eye = [0, 1.5, 7], target = [0, 1, 0], fov = 45 }
[background.environment]
file = "sky.hdr"
[texture.squares]
checker = { a = 0.2, b = 0.9 }
transform = { scale = 8 }
[material.red]
matte = { albedo = [0.8, 0.1, 0.1] }
[material.squares]
matte = { albedo = "texture.squares" }
[material.lamp]
emitter = { radiance = 5 }
[material.glass]
glass = {}
[[object]]
name = "ball"
material = "red"
shape.sphere = { radius = 0.7 }
[[object]]
name = "lamp"
material = "lamp"
shape.sphere = { radius = 0.3 }
transform = { translate = [1, 3, 0] }
[[object]]
name = "roof"
material = "glass"
shape.mesh = { file = "roof.obj" }
transform = { translate = [0, 1, -1], rotate = [0, 20, 0] }
[[object]]
name = "roof 2"
shape.mesh = { file = "roof.obj" }
transform = { translate = [-2, 0.5, 0], scale = [1, 2, 1] }
[[object]]
name = "far"
material = "red"
shape.mesh = { file = "far.obj" }
transform = { translate = [-5000, 0, -3000], scale = 1 }
[[object]]
name = "lit"
shape.mesh = { file = "lit.obj" }
transform = { translate = [3, 1, 0] }
[[object]]
name = "dots"
shape.mesh = { file = "dots.ply", radius = 0.2 }
[[object]]
name = "floor"
material = "squares"
shape.cuboid = { min = [-5, -1, -5], max = [5, -0.7, 5] }
[[light]]
name = "key"
point = { position = [3, 4, 5], intensity = 40 }
"#;

const ROOF: &str = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 1 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 4 3 2 1\n";

/// A model of two parts, of which one shines.
const LIT: &str = "mtllib lit.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl lamp\nf 1 2 3\nusemtl dull\nf 1 3 4\n";

const DOTS: &str = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
                    end_header\n-1 1 2\n1 0.5 2\n";

/// A folder with the scene, its files and a table.
fn folder(table: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("written");
    write("s.toml", SCENE.as_bytes());
    write("roof.obj", ROOF.as_bytes());
    let far = "v 5001 0 3000\nv 5002 0 3000\nv 5001 1.5 3000\nf 1 2 3\n";
    write("far.obj", far.as_bytes());
    write("lit.obj", LIT.as_bytes());
    write("lit.mtl", b"newmtl lamp\nKe 4 4 4\nnewmtl dull\nKd 0.5 0.5 0.5\n");
    write("dots.ply", DOTS.as_bytes());
    write("v.csv", table.as_bytes());
    let texels: Vec<u8> = (0..8)
        .flat_map(|i| [200, 30 * i as u8, 30, 127 + i as u8 % 3])
        .collect();
    write(
        "sky.hdr",
        &[b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n", &texels[..]].concat(),
    );
    folder
}

fn job(folder: &Path) -> Job {
    let request = Request {
        values: Some(folder.join("v.csv")),
        ..Request::default()
    };
    Job::open(&folder.join("s.toml"), &request).unwrap_or_else(|e| panic!("{e}"))
}

/// The bits of a picture of this scene, which stands still.
fn picture(job: &Job, scene: &Scene) -> Vec<[u32; 4]> {
    let (frame, still) = (&job.plan.frames[0], &mut StillScene(scene));
    let film = (job.plan).render_frame(&Renderer::new(), still, (frame, &frame.camera), &Control::default());
    let film = film.expect("a film");
    film.beauty().iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

/// Renders frames of a table in this order, by changing the scene of the frame before and by compiling each alone.
fn both_ways(table: &str, frames: &[f64]) {
    both_ways_in(&folder(table), table, frames);
}

fn both_ways_in(folder: &tempfile::TempDir, table: &str, frames: &[f64]) {
    let job = job(folder.path());
    let compiled = || job.compile().expect("a scene");
    let (mut changed, mut anew) = (job.scenes(compiled()), job.scenes(compiled()));
    let mut pictures = Vec::new();
    for &frame in frames {
        let found = picture(&job, changed.seek(frame).expect("a scene"));
        anew.recover();
        let expected = picture(&job, anew.seek(frame).expect("a scene"));
        assert!(found == expected, "frame {frame} of {table}");
        pictures.push(found);
    }
    assert!(pictures[0] != pictures[1], "nothing changes in {table}");
}

const FRAMES: [f64; 5] = [1.0, 3.0, 2.25, 9.0, 1.0];

#[test]
fn a_scene_that_is_changed_equals_one_that_is_compiled_for_its_time() {
    for (column, first, last) in [
        ("material.red.matte.albedo.g", "0.1", "0.9"),
        ("material.lamp.emitter.radiance.b", "5", "50"),
        ("texture.squares.checker.b", "0.9", "0.4"),
        ("light.key.point.intensity", "40", "90"),
        ("light.key.point.position.x", "3", "-3"),
        ("background.environment.rotate.y", "0", "180"),
        ("background.environment.intensity", "1", "2.5"),
        ("background.visible", "true", "false"),
        ("object.ball.transform.translate.y", "0", "1.7"),
        ("object.lamp.transform.translate.x", "1", "-1"),
        ("object.roof.transform.rotate.y", "20", "425"),
        ("object.roof.transform.scale", "1", "1.5"),
        ("object.roof 2.transform.translate.x", "-2", "0.3"),
        ("object.far.transform.translate.x", "-5000", "-5003.3"),
        ("object.lit.transform.translate.x", "3", "2"),
        ("object.dots.transform.translate.y", "0", "1"),
        ("object.roof.material", "glass", "red"),
        ("object.ball.visible", "1", "0"),
        ("object.roof.visible", "true", "false"),
        ("object.ball.shape.sphere.radius", "0.7", "1.2"),
        ("object.ball.material", "red", "glass"),
        ("object.roof.material", "glass", "lamp"),
        ("object.roof 2.shape.mesh.file", "roof.obj", "lit.obj"),
    ] {
        both_ways(&format!("frame,{column}\n1,{first}\n3,{last}\n"), &FRAMES);
    }
}

#[test]
fn values_that_change_together_equal_a_scene_that_is_compiled_for_their_time() {
    let all = "frame,material.red.matte.albedo,light.key.point.intensity.r,light.key.point.intensity.g,\
               light.key.point.intensity.b,object.roof.transform.translate.x,object.lamp.transform.translate.y,\
               object.roof 2.visible,background.environment.rotate.y\n\
               1,0.5,1,2,3,0,2,true,0\n2,0.7,40,20,30,1,3,false,90\n3,0.6,70,0,0,2,1,true,360\n";
    both_ways(all, &FRAMES);
}

#[test]
fn skies_and_suns_of_other_times_equal_those_that_are_compiled_for_them() {
    let table = "frame,background.sky.elevation,object.roof.transform.translate.x\n1,4,0\n3,60,1\n";
    let folder = folder(table);
    let scene = SCENE.replace(
        "[background.environment]\nfile = \"sky.hdr\"",
        "[background.sky]\nelevation = 20",
    );
    fs::write(folder.path().join("s.toml"), scene).expect("written");
    both_ways_in(&folder, table, &[1.0, 3.0]);
}

#[test]
fn a_frame_after_one_that_is_wrong_is_right() {
    let folder = folder("frame,object.floor.shape.cuboid.max.x\n1,5\n2,-9\n3,6\n");
    let job = job(folder.path());
    let scenes = || job.scenes(job.compile().expect("a scene"));
    let (mut scenes, mut alone) = (scenes(), scenes());
    scenes.seek(1.0).expect("a scene");
    let message = scenes.seek(2.0).map(drop).expect_err("no size").to_string();
    assert!(
        message.contains("v.csv:3: object.floor.shape.cuboid.max.x: "),
        "{message}"
    );
    let found = picture(&job, scenes.seek(3.0).expect("a scene"));
    assert!(found == picture(&job, alone.seek(3.0).expect("a scene")));
}

#[test]
fn a_file_that_a_cell_names_is_there_or_is_told_with_the_cell() {
    let folder = folder("frame,object.roof.shape.mesh.file\n1,roof.obj\n2,none.obj\n");
    let message = job(folder.path())
        .load()
        .map(drop)
        .expect_err("no such file")
        .to_string();
    assert!(
        message.contains("v.csv:3: object.roof.shape.mesh.file: cannot read the file"),
        "{message}"
    );
}

mod animations;
mod parts;

#[test]
fn a_scene_that_others_have_stays_and_the_next_one_equals_that_of_its_time() {
    let folder = folder("frame,material.red.matte.albedo.g\n1,0.1\n3,0.9\n");
    let job = job(folder.path());
    let mut scenes = job.scenes(job.compile().expect("a scene"));
    let first = picture(&job, scenes.seek(1.0).expect("a scene"));
    let shared = scenes.shared();
    let third = picture(&job, scenes.seek(3.0).expect("a scene"));
    assert!(picture(&job, &shared) == first && first != third);
    assert!(picture(&job, scenes.seek(1.0).expect("a scene")) == first);
}

/// A job whose scene has two images of 2 by 2 texels.
fn textured(table: &str) -> (tempfile::TempDir, Job) {
    let folder = folder(table);
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("written");
    let tga = |gray: u8| {
        let mut file = vec![0; 18];
        (file[2], file[12], file[14], file[16]) = (3, 2, 2, 8);
        file.extend([gray, 250, 90, 10]);
        file
    };
    write("a.tga", &tga(0));
    write("b.tga", &tga(200));
    let other = "[texture.zebra]\nimage = { file = \"b.tga\" }\n[material.red]";
    let scene = SCENE.replace("checker = { a = 0.2, b = 0.9 }", "image = { file = \"a.tga\" }");
    let scene = scene.replace("[material.red]", other);
    write("s.toml", scene.as_bytes());
    let job = job(folder.path());
    (folder, job)
}

/// The addresses of the texels of all bitmaps of a scene.
fn texels(scene: &Scene) -> Vec<*const u8> {
    let bitmaps = scene.shading.bitmaps.iter();
    let address = |bitmap: &crate::texture::Bitmap| match &bitmap.storage {
        Storage::Srgb8(texels) | Storage::Linear8(texels) => texels.as_ptr(),
        other => panic!("{other:?}"),
    };
    bitmaps.map(address).collect()
}

#[test]
fn images_that_stay_are_decoded_once_and_changed_files_again() {
    let table = "frame,object.ball.shape.sphere.radius,texture.squares.image.filter\n1,0.7,trilinear\n3,1.2,nearest\n4,1,trilinear\n";
    let (folder, job) = textured(table);
    let mut scenes = job.scenes(job.compile().expect("a scene"));
    let first = scenes.seek(1.0).expect("a scene");
    let (addresses, sky) = (texels(first), first.shading.background.radiance.address());
    assert!(addresses.len() == 2 && !first.shading.bitmaps[0].levels.is_empty());
    let third = scenes.seek(3.0).expect("a scene");
    assert_eq!(texels(third), addresses);
    assert!(third.shading.bitmaps[0].levels.is_empty());
    assert_eq!(third.shading.background.radiance.address(), sky);
    let fourth = picture(&job, scenes.seek(4.0).expect("a scene"));
    assert_eq!(texels(scenes.current()), addresses);
    scenes.recover();
    assert!(picture(&job, scenes.seek(4.0).expect("a scene")) == fourth);
    fs::copy(folder.path().join("b.tga"), folder.path().join("a.tga")).expect("copied");
    // The new image may be where the old one was.
    assert!(picture(&job, scenes.seek(3.5).expect("a scene")) != fourth);
    assert_eq!(texels(scenes.current())[1], addresses[1]);
}

#[test]
fn the_scene_of_the_first_frame_is_compiled_once_around_the_origin_of_the_file() {
    let folder = folder("frame,object.ball.shape.sphere.radius\n5,1.1\n7,0.8\n");
    let job = job(folder.path());
    let mut scenes = job.scenes(job.compile().expect("a scene"));
    let compiled = Arc::as_ptr(&scenes.current().geometry);
    let scene = scenes.seek(5.0).expect("a scene");
    assert_eq!(Arc::as_ptr(&scene.geometry), compiled);
    let of_file = compile::scene(&job.desc, job.plan.picture.accel).expect("a scene");
    assert_eq!(scene.origin, of_file.origin);
}
