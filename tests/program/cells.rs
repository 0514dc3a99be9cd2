//! Cells of tables of values: what is checked before the first frame, and frames that fail.

use crate::common::{Folder, MOVING_MODEL, pixels};

const SCENE: &str = r#"
[render]
width = 24
height = 16
samples = 4
[camera]
perspective = { eye = [0, 1, 6], target = [0, 1, 0], fov = 40 }
[background]
color = 0.1
[texture.squares]
checker = { a = 0.2, b = 0.9 }
[material.red]
matte = { albedo = [0.8, 0.1, 0.1] }
[[object]]
name = "ball"
material = "red"
shape.sphere = { radius = 1 }
transform = { translate = [0, 1, 0] }
[[object]]
name = "box"
material = "red"
shape.cuboid = { min = [-3, 0, -1], max = [-2, 1, 0] }
[[object]]
name = "walker"
shape.mesh = { file = "a.gltf", animation = "Walk" }
transform = { translate = [1, 0, 1] }
[[object]]
name = "last"
material = "red"
shape.sphere = { center = [2, 2, 0], radius = 0.4 }
[[light]]
name = "key"
point = { position = [3, 4, 5], intensity = 40 }
"#;

fn folder(table: &str) -> Folder {
    let folder = Folder::new();
    folder.write("s.toml", SCENE);
    folder.write("a.gltf", MOVING_MODEL);
    folder.write("v.csv", table);
    folder
}

const JOB: [&str; 7] = ["s.toml", "--values", "v.csv", "-o", "f.####.exr", "--exr-type", "float"];

#[test]
fn a_word_that_names_nothing_is_refused_before_the_first_frame() {
    for (column, good, bad, expected) in [
        (
            "object.walker.shape.mesh.animation",
            "Run",
            "Rum",
            "unknown animation `Rum` (did you mean `Run`?)",
        ),
        (
            "object.walker.shape.mesh.variant",
            "Red",
            "Red",
            "unknown variant `Red` (the model has none)",
        ),
        (
            "object.ball.material",
            "red",
            "rad",
            "unknown material `rad` (did you mean `red`?)",
        ),
        (
            "material.red.matte.albedo",
            "texture.squares",
            "texture.square",
            "unknown texture `square` (did you mean `squares`?)",
        ),
    ] {
        let line = if good == bad { 2 } else { 4 };
        let folder = folder(&format!("frame,{column}\n1,{good}\n2,{good}\n3,{bad}\n"));
        let message = folder.fail(65, &JOB);
        let expected = format!("v.csv:{line}: {column}: {expected}");
        assert!(message.contains(&expected), "{message}");
        assert!(folder.names().iter().all(|name| !name.ends_with(".exr")));
    }
    let all = folder("frame,object.walker.shape.mesh.animation\n1,Walk\n2,Run\n");
    all.succeed(&JOB);
}

#[test]
fn an_object_whose_scale_is_0_at_a_frame_is_gone_there_and_moves_between_its_neighbours() {
    let table = "frame,object.ball.transform.scale,interp\n1,1,linear\n3,-1,linear\n";
    let vectors = ["--aovs", "forward,backward"];
    let folder = folder(table);
    folder.succeed(&[&JOB[..], &vectors].concat());
    let gone = self::folder("frame,object.ball.visible\n2,false\n");
    gone.succeed(&[&JOB[..], &["--range", "2"]].concat());
    let of = |folder: &Folder, frame: u32| pixels(&folder.path(&format!("f.{frame:04}.exr"))).1;
    assert!(of(&folder, 2) == of(&gone, 2));
    assert!(of(&folder, 1) != of(&folder, 2));
    // The right edge of the ball goes to its centre, a metre to the left.
    let image = folder.open_exr("f.0001.exr");
    let channel = |name: &str| {
        let channels = &image.layer_data[0].channel_data.list;
        let found = channels
            .iter()
            .find(|channel| channel.name.eq(name))
            .expect("a channel");
        found.sample_data.values_as_f32().collect::<Vec<f32>>()
    };
    let x = channel("forward.u");
    assert!(x.iter().all(|v| v.is_finite()));
    let least = x.iter().copied().fold(f32::INFINITY, f32::min);
    // A metre is 16 / (2 * 6 * tan 20) pixels.
    assert!((-3.8..-2.4).contains(&least), "{least}");
}

#[test]
fn a_frame_that_fails_shows_its_lines_as_lines() {
    let folder = folder("frame,object.box.shape.cuboid.max.x,light.key.point.intensity\n1,-2,1\n2,-5,1\n3,-2,1\n");
    let output = folder.run(&JOB);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(!message.contains("\\n"), "{message}");
    assert!(
        message.contains("error: frame 2: v.csv:3: object.box.shape.cuboid.max.x: "),
        "{message}"
    );
    assert!(message.contains("frame 2: to repeat it alone: ") || message.contains("; to repeat it alone: "));
    assert!(folder.names().contains(&"f.0003.exr".to_owned()));
}

#[test]
fn names_and_numbers_of_objects_are_the_same_in_frames_that_hide_some() {
    let mut model = MOVING_MODEL.replace(
        r#""nodes": [{"mesh": 0}]"#,
        r#""nodes": [{"mesh": 0, "name": "leg"}, {"mesh": 0, "name": "arm", "translation": [0, 1, 0]}]"#,
    );
    model = model.replace(r#""meshes""#, r#""scene": 0, "scenes": [{"nodes": [0, 1]}], "meshes""#);
    let table =
        "frame,object.walker.visible,object.ball.visible\n1,true,true\n2,false,true\n3,true,false\n4,false,false\n";
    let folder = folder(table);
    folder.write("a.gltf", &model);
    folder.succeed(&[&JOB[..], &["--aovs", "CryptoObject,CryptoAsset,objectId"]].concat());
    let facts = |frame: u32| {
        let image = folder.open_exr(&format!("f.{frame:04}.exr"));
        let layer = &image.layer_data[0];
        let others = image.attributes.other.iter().chain(&layer.attributes.other);
        let mut manifests: Vec<String> = others
            .filter(|(name, _)| name.to_string().ends_with("/manifest"))
            .map(|(name, value)| format!("{name}: {value:?}"))
            .collect();
        manifests.sort();
        let numbers = layer
            .channel_data
            .list
            .iter()
            .find(|channel| channel.name.to_string().starts_with("objectId"));
        let numbers = numbers.expect("the pass").sample_data.values_as_f32();
        (manifests, numbers.fold(0.0, f32::max))
    };
    let (manifests, last) = facts(1);
    assert_eq!((manifests.len(), last), (2, 5.0));
    for name in ["ball", "walker/leg", "walker/arm", "last"] {
        assert!(
            manifests.iter().any(|text| text.contains(name)),
            "{name}: {manifests:?}"
        );
    }
    for frame in 2..=4 {
        assert_eq!(facts(frame), (manifests.clone(), last), "frame {frame}");
    }
}
