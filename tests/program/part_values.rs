//! Models whose nodes have settings of their own, over frames: by tables of values, and while they play.

use crate::{
    common::{Folder, pixels},
    parts::{HEAD, MODEL},
};

const MATERIALS: &str = r#"
[material.red]
matte = { albedo = [0.8, 0.1, 0.1] }
[material.blue]
matte = { albedo = [0.1, 0.1, 0.8] }
[[light]]
point = { position = [0, 1, 5], intensity = 20 }
"#;

/// The model with an animation that moves two nodes along x, by a metre in half a second.
fn playing_model() -> String {
    let nodes =
        ["0", "2"].map(|node| format!(r#"{{"sampler": 0, "target": {{"node": {node}, "path": "translation"}}}}"#));
    let changes = [
        (
            r#""byteOffset": 44, "byteLength": 24}"#,
            r#", {"buffer": 0, "byteOffset": 36, "byteLength": 8}"#.to_owned(),
        ),
        (
            r#"{"bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3"}"#,
            r#", {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [0.5]}"#
                .to_owned(),
        ),
        (
            r#""extensions": {"KHR_node_visibility": {"visible": false}}}]"#,
            format!(
                r#", "animations": [{{"name": "Walk", "channels": [{}], "samplers": [{{"input": 2, "output": 1}}]}}]"#,
                nodes.join(", ")
            ),
        ),
    ];
    changes.iter().fold(MODEL.to_owned(), |model, (before, added)| {
        assert!(model.contains(before), "{before}");
        model.replace(before, &format!("{before}{added}"))
    })
}

/// The pixels of the frames of a scene with these objects, and their files.
fn frames(objects: &str, values: &str, range: &str) -> Vec<(Vec<[f32; 3]>, Vec<u8>)> {
    let folder = Folder::new();
    folder.write("car.gltf", &playing_model());
    folder.write("s.toml", &format!("{HEAD}{MATERIALS}{objects}"));
    let mut args = vec!["s.toml", "-o", "f.##.exr", "--exr-type", "float", "--range", range];
    if !values.is_empty() {
        folder.write("v.csv", values);
        args.extend(["--values", "v.csv"]);
    }
    folder.succeed(&args);
    let names = folder.names().into_iter().filter(|name| name.ends_with(".exr"));
    names
        .map(|name| (pixels(&folder.path(&name)).1, folder.read(&name)))
        .collect()
}

fn assert_same(a: &[(Vec<[f32; 3]>, Vec<u8>)], b: &[(Vec<[f32; 3]>, Vec<u8>)]) {
    assert_eq!(a.len(), b.len());
    for (frame, ((a, _), (b, _))) in a.iter().zip(b).enumerate() {
        let differ = a.iter().zip(b).filter(|(a, b)| a != b).count();
        assert_eq!(differ, 0, "pixels of picture {frame} differ");
    }
}

/// An object of the nodes that these keys choose.
fn object(name: &str, mesh: &str, keys: &str) -> String {
    format!("[[object]]\nname = '{name}'\nshape.mesh = {{ file = 'car.gltf'{mesh} }}\n{keys}\n")
}

#[test]
fn settings_of_parts_in_a_table_are_those_of_a_file_that_has_them() {
    let parts = |first: &str, second: &str| {
        let parts = [("Wheel.L", first), ("Wheel", second)];
        let parts = parts.map(|(node, keys)| format!("[[object.part]]\nnodes = ['{node}']\n{keys}\n"));
        object("car", "", &parts.concat())
    };
    let table = "frame,object.car.part.0.visible,object.car.part.0.material,object.car.part.1.ray_visibility.camera,\
                 object.car.part.1.holdout\n\
                 1,true,red,true,false\n2,false,red,true,true\n4,true,blue,false,false\n";
    let whole = frames(&parts("material = 'red'", ""), table, "1-4");
    let of_file = [
        ("1", parts("material = 'red'", "")),
        ("2", parts("visible = false", "holdout = true")),
        ("3", parts("visible = false", "holdout = true")),
        ("4", parts("material = 'blue'", "ray_visibility = { camera = false }")),
    ];
    // A table that changes nothing gives the file its frames.
    let still = "frame,background.color\n1,0.3\n4,0.3\n";
    let of_file: Vec<_> = of_file
        .iter()
        .flat_map(|(frame, objects)| frames(objects, still, frame))
        .collect();
    assert_same(&whole, &of_file);
    assert!(whole[0].0 != whole[1].0 && whole[2].0 != whole[3].0 && whole[0].0 != whole[3].0);
    let chunks = ["4", "2-3"]
        .map(|range| frames(&parts("material = 'red'", ""), table, range))
        .concat();
    let of_whole = [3, 1, 2].map(|frame: usize| &whole[frame].1);
    assert!(chunks.iter().map(|(_, file)| file).eq(of_whole), "the bytes of chunks");
}

#[test]
fn objects_with_parts_move_as_objects_of_these_nodes() {
    let table = |objects: [&str; 2], wheel: &str| {
        let moves =
            objects.map(|name| format!("object.{name}.transform.translate.x,object.{name}.transform.rotate.z,"));
        let columns = if objects[0] == objects[1] {
            &moves[..1]
        } else {
            &moves[..]
        };
        let rows = [["0,0,", "-1.2"], ["0.4,50,", "-0.5"]];
        let rows = rows.map(|[moved, wheel]| moved.repeat(columns.len()) + wheel);
        format!(
            "frame,interp,{}object.{wheel}.node.Wheel.L.transform.translate.y\n1,linear,{}\n3,linear,{}\n",
            columns.concat(),
            rows[0],
            rows[1]
        )
    };
    let part = "[[object.part]]\nnodes = ['Wheel.L']\nmaterial = 'red'";
    let parts = frames(&object("car", "", part), &table(["car"; 2], "car"), "1-3");
    let others = object("a", "", "nodes = ['Wheel', 'Wheel#2', 'crowd']");
    let objects = others + &object("b", "", "nodes = ['Wheel.L']\nmaterial = 'red'");
    assert_same(&parts, &frames(&objects, &table(["a", "b"], "b"), "1-3"));
    assert!(parts[0].0 != parts[1].0 && parts[1].0 != parts[2].0);
    let last = frames(&object("car", "", part), &table(["car"; 2], "car"), "3");
    assert!(last[0].1 == parts[2].1, "the bytes of a frame alone");
}

#[test]
fn parts_of_a_playing_model_look_like_objects_that_play_it() {
    let playing = ", animation = 'Walk'";
    let keys =
        "[[object.part]]\nnodes = ['Wheel']\nmaterial = 'red'\n[[object.part]]\nnodes = ['crowd']\nvisible = false";
    let parts = frames(&object("car", playing, keys), "", "0-12x6");
    let others = object("a", playing, "nodes = ['Wheel#2', 'Wheel.L']");
    let objects = others + &object("b", playing, "nodes = ['Wheel']\nmaterial = 'red'");
    assert_same(&parts, &frames(&objects, "", "0-12x6"));
    assert!(parts[0].0 != parts[1].0 && parts[1].0 != parts[2].0);
    let middle = frames(&object("car", playing, keys), "", "6");
    assert!(middle[0].1 == parts[1].1, "the bytes of a frame alone");
}

#[test]
fn values_of_parts_change_while_their_model_plays() {
    let playing = ", animation = 'Walk'";
    let part = |keys: &str| object("car", playing, &format!("[[object.part]]\nnodes = ['Wheel']\n{keys}"));
    let table = "frame,object.car.part.0.visible\n0,true\n6,false\n12,true\n";
    let whole = frames(&part("material = 'blue'"), table, "0-12x6");
    let of_file = ["", "visible = false", ""].map(|keys| part(&format!("material = 'blue'\n{keys}")));
    let of_file: Vec<_> = (of_file.iter().zip(["0", "6", "12"]))
        .flat_map(|(objects, frame)| frames(objects, "", frame))
        .collect();
    assert_same(&whole, &of_file);
    assert!(whole[0].0 != whole[1].0 && whole[1].0 != whole[2].0);
}
