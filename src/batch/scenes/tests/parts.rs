//! Nodes and materials of models whose values change.

use super::{
    animations::{animation, model},
    *,
};

/// A scene with the figure of these keys beside its file. The file has animations: `turn` of the node `thing`, if there are any.
fn open(keys: &str, table: Option<&str>, channels: &[(&str, usize)]) -> Result<(tempfile::TempDir, Job), Error> {
    let folder = folder(table.unwrap_or("frame\n1\n"));
    let scene = format!(
        "{SCENE}[[object]]\nname = \"figure\"\ntransform = {{ translate = [0, 0.3, 1], rotate = [0, 10, 0] }}\n\
         shape.mesh = {{ file = \"figure.glb\", lights = true{} }}\n{keys}\n\
         [[object]]\nname = \"late\"\nshape.mesh = {{ file = \"figure.glb\", lights = false, animation = [] }}\n",
        if channels.is_empty() {
            ""
        } else {
            ", animation = \"all\""
        }
    );
    fs::write(folder.path().join("s.toml"), scene).expect("written");
    fs::write(folder.path().join("figure.glb"), model(&animation(channels))).expect("written");
    let request = Request {
        values: table.map(|_| folder.path().join("v.csv")),
        fps: Some(10.0),
        ..Request::default()
    };
    let job = Job::open(&folder.path().join("s.toml"), &request)?;
    Ok((folder, job))
}

fn still(keys: &str) -> Vec<[u32; 4]> {
    let (_folder, job) = open(keys, None, &[]).unwrap_or_else(|e| panic!("{e}"));
    picture(&job, &job.compile().unwrap_or_else(|e| panic!("{e}")))
}

/// The pictures of frames of a table, made by moving the scene of the frame before, which equal those of scenes that are compiled
/// for their frame alone.
fn pictures(table: &str, channels: &[(&str, usize)], frames: &[f64]) -> Vec<Vec<[u32; 4]>> {
    let (_folder, job) = open("", Some(table), channels).unwrap_or_else(|e| panic!("{e}"));
    let compiled = || job.compile().unwrap_or_else(|e| panic!("{e}"));
    let (mut moved, mut anew) = (job.scenes(compiled()), job.scenes(compiled()));
    let at = |frame: &f64| {
        let found = picture(&job, moved.seek(*frame).expect("a scene"));
        anew.recover();
        let expected = picture(&job, anew.seek(*frame).expect("a scene"));
        assert!(found == expected, "frame {frame} of {table}");
        found
    };
    frames.iter().map(at).collect()
}

const FRAMES: [f64; 4] = [1.0, 3.0, 2.25, 1.0];

#[test]
fn a_part_that_is_changed_equals_one_that_is_compiled_for_its_time() {
    for (name, first, last) in [
        ("node.thing.transform.translate.x", "0", "1"),
        ("node.thing.transform.rotate.z", "0", "70"),
        ("node.child.transform.scale", "0.5", "1.5"),
        ("node.child.transform.scale.y", "0.5", "2"),
        ("node.tip.transform.rotate.x", "0", "80"),
        ("node.morph.transform.translate.y", "0", "1"),
        ("node.lamp.transform.translate.x", "1", "-1"),
        ("node.bulb.transform.translate.y", "2", "0.4"),
        ("node.still.transform.scale.x", "1", "-2"),
        ("node.still.transform.scale.x", "1", "0"),
        ("node.thing.visible", "1", "0"),
        ("node.lamp.visible", "true", "false"),
        ("node.skin.visible", "false", "true"),
        ("node.bulb.visible", "true", "false"),
        ("material.0.base_color.g", "0.4", "0.9"),
        ("material.0.base_color", "0.4", "0.9"),
        ("material.0.metallic", "0", "1"),
        ("material.0.roughness", "0.1", "1"),
        ("material.1.emissive.r", "3", "9"),
        ("material.0.emissive", "0", "2"),
        ("material.0.opacity", "1", "0.2"),
    ] {
        let table = format!("frame,object.figure.{name},interp\n1,{first},linear\n3,{last},linear\n");
        let found = pictures(&table, &[], &FRAMES);
        // The opacity of an opaque surface does not count.
        assert!(
            found[0] != found[1] || name.ends_with("opacity"),
            "nothing changes in {table}"
        );
        assert!(found[0] == found[3], "a frame depends on those before it: {table}");
    }
}

#[test]
fn a_table_equals_the_scene_file_with_the_same_values() {
    let table = "frame,object.figure.node.thing.transform.translate.x,object.figure.node.thing.transform.rotate.y,\
                 object.figure.node.child.transform.scale.x,object.figure.node.lamp.visible,\
                 object.figure.material.0.base_color.r,object.figure.material.1.emissive\n\
                 1,0,0,1,1,0.1,1\n2,0.5,40,2,0,0.9,4\n";
    let keys = "[object.node.thing.transform]\ntranslate.x = 0.5\nrotate = { y = 40 }\n\
                [object.node.child]\ntransform.scale.x = 2\n[object.node.lamp]\nvisible = false\n\
                [object.material_overrides]\n0 = { base_color = { r = 0.9 } }\n1 = { emissive = 4 }\n";
    assert!(pictures(table, &[], &[2.0])[0] == still(keys));
    assert!(still(keys) != still(""));
}

#[test]
fn a_node_of_a_table_equals_the_same_pose_of_an_animation() {
    // The animation is at its first key in frame 0, and at its second one in frame 10.
    let column = |key: &str| format!("object.figure.node.thing.transform.{key}");
    let [y, w] = [0.6_f32, 0.8].map(f64::from);
    for (keys, channel, rows) in [
        (
            &["translate.x", "translate.y"][..],
            ("/nodes/1/translation", 6),
            ["0,0", "0.6,0.9"].map(str::to_owned),
        ),
        (
            &["rotate.qx", "rotate.qy", "rotate.qz", "rotate.qw"],
            ("/nodes/1/rotation", 7),
            ["0,0,0,1".to_owned(), format!("0,{y},0,{w}")],
        ),
    ] {
        let columns: Vec<String> = keys.iter().map(|key| column(key)).collect();
        let table = format!("frame,{}\n0,{}\n10,{}\n", columns.join(","), rows[0], rows[1]);
        let by_table = pictures(&table, &[], &[0.0, 10.0]);
        let still = "frame,light.key.point.intensity\n0,40\n10,40\n";
        assert!(by_table == pictures(still, &[channel], &[0.0, 10.0]), "{table}");
        assert!(by_table[0] != by_table[1]);
    }
}

#[test]
fn a_value_wins_over_an_animation_of_the_same_thing_and_leaves_the_others() {
    let channels = [("/nodes/1/translation", 6), ("/nodes/1/rotation", 7)];
    let table = "frame,object.figure.node.thing.transform.translate.x\n0,0.25\n30,0.25\n";
    let frames = [0.0, 10.0, 30.0];
    let both = pictures(table, &channels, &frames);
    let rotation_alone = pictures(table, &channels[1..], &frames);
    let translation_alone = pictures(table, &channels[..1], &frames);
    assert!(both == rotation_alone, "the translation of the animation shows");
    assert!(translation_alone[0] == translation_alone[2]);
    assert!(both[0] != both[1], "the rotation of the animation is lost");
}

#[test]
fn an_animation_plays_beside_values_of_other_parts() {
    let channels = [
        ("/nodes/1/translation", 6),
        ("/nodes/4/rotation", 7),
        ("/nodes/6/weights", 8),
    ];
    let table = "frame,object.figure.node.child.transform.translate.y,object.figure.node.tip.transform.scale,\
                 object.figure.material.0.roughness,object.late.node.thing.visible\n\
                 0,0,1,0.2,1\n10,1,0.5,1,0\n20,0.3,2,0.5,1\n";
    let found = pictures(table, &channels, &[0.0, 10.0, 4.5, 20.0, 10.0]);
    assert!(found[0] != found[1] && found[1] == found[4]);
}

#[test]
fn objects_of_one_file_have_values_of_their_own() {
    let table = "frame,object.figure.material.0.base_color,object.late.material.0.base_color,\
                 object.late.node.thing.transform.translate.y\n0,0.1,0.9,0\n10,0.9,0.1,2\n";
    let found = pictures(table, &[], &[0.0, 10.0, 0.0]);
    assert!(found[0] != found[1]);
}

#[test]
fn a_part_that_is_unknown_is_told_with_its_cell_and_the_nearest_name() {
    for (table, expected) in [
        (
            "frame,object.figure.node.thin.visible\n1,1\n",
            "v.csv:1: object.figure.node.thin.visible: unknown node `thin` (did you mean `thing`?)",
        ),
        (
            "frame,object.figure.material.2.roughness\n1,1\n",
            "v.csv:1: object.figure.material.2.roughness: unknown material `2` (did you mean `0`?)",
        ),
        (
            "frame,object.ball.node.thing.visible\n1,1\n",
            "v.csv:1: object.ball.node.thing.visible: only a `shape.mesh` has nodes and materials of its own",
        ),
        (
            "frame,object.figure.node.thing.transform.rotat.x\n1,1\n",
            "object.figure.node.thing.transform.rotat.x: unknown key `rotat` (did you mean `rotate`?)",
        ),
        (
            "frame,object.figure.material.0.roughnes\n1,1\n",
            "object.figure.material.0.roughnes: unknown key `roughnes` (did you mean `roughness`?)",
        ),
        (
            "frame,object.figure.material.0.roughness\n1,1\n2,1.5\n",
            "v.csv:3: object.figure.material.0.roughness: expected a number from 0 to 1, found 1.5",
        ),
        (
            "frame,object.figure.node.thing.visible\n1,2\n",
            "v.csv:2: object.figure.node.thing.visible: ",
        ),
        (
            "frame,object.figure.node.thing.transform.rotate.x,object.figure.node.thing.transform.rotate.qx\n1,2,3\n",
            "a quaternion and `object.figure.node.thing.transform.rotate.x` are the same rotation",
        ),
    ] {
        let opened = open("", Some(table), &[]).and_then(|(_folder, job)| job.load().map(drop));
        let message = opened.expect_err(table).to_string();
        assert!(message.contains(expected), "{message}");
    }
    let message = open(
        "material = 'red'\n[object.material_overrides.0]\nroughness = 0.5\n",
        None,
        &[],
    )
    .and_then(|(_folder, job)| job.load().map(drop))
    .expect_err("its material is another")
    .to_string();
    assert!(message.contains("the object has a `material`"), "{message}");
    let message = open("[object.node.thin]\nvisible = false\n", None, &[])
        .and_then(|(_folder, job)| job.load().map(drop))
        .expect_err("there is no such node")
        .to_string();
    assert!(
        message.contains("unknown node `thin`") && message.contains("did you mean `thing`?"),
        "{message}"
    );
}

#[test]
fn a_table_of_values_of_parts_leaves_the_files_alone() {
    let table =
        "frame,object.figure.material.0.base_color.r,object.figure.node.thing.transform.translate.x\n1,0,0\n9,1,1\n";
    let (folder, job) = open("", Some(table), &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut scenes = job.scenes(job.compile().expect("a scene"));
    scenes.seek(1.0).expect("a scene");
    fs::remove_file(folder.path().join("figure.glb")).expect("it is there");
    let [first, last] = [1.0, 9.0].map(|frame| picture(&job, scenes.seek(frame).expect("no file is read")));
    assert!(first != last);
}
