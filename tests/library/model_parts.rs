//! Nodes of a model with settings of their own: against models that have these nodes alone.

use batch_render::{
    batch::{Job, Request},
    describe::{self, Overrides, Source},
    film::Film,
    render::Control,
    scene::{MatteKind, Scene},
};

/// A body with two wheels below it, a hub below one of them, and a mast: boxes that stand side by side and throw shadows on each other.
/// `nodes` are the numbers of those that have a mesh.
fn model(nodes: &[usize]) -> String {
    let mesh = |node: usize| if nodes.contains(&node) { "\"mesh\": 0, " } else { "" };
    let triangles = "AACAvwAAAAAAAIA/AACAPwAAAAAAAIA/AAAAAAAAAEAAAAAA";
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": 36, "uri": "data:;base64,{triangles}"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, 0, 0], "max": [1, 2, 1]}}],
        "materials": [{{"name": "Paint", "pbrMetallicRoughness": {{"baseColorFactor": [0.2, 0.3, 0.8, 1], "metallicFactor": 0}}}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
        "nodes": [{{{}"name": "Body", "children": [1, 2]}}, {{{}"name": "Wheel_L", "translation": [-1.6, 0, 0.5], "children": [3]}},
        {{{}"name": "Wheel_R", "translation": [1.6, 0, 0.5]}}, {{{}"name": "Hub", "translation": [0.4, 0.3, 0.8], "scale": [0.4, 0.4, 0.4]}},
        {{{}"name": "Mast", "translation": [0, 1.2, -0.5]}}]}}"#,
        mesh(0),
        mesh(1),
        mesh(2),
        mesh(3),
        mesh(4)
    )
}

const ALL: [usize; 5] = [0, 1, 2, 3, 4];

struct Shot {
    film: Film,
    scene: Scene,
}

/// Renders objects of these tables, of models that show these nodes.
fn shoot_with(models: &[&[usize]], objects: &str, overrides: Overrides) -> Result<Shot, String> {
    let folder = tempfile::tempdir().expect("a folder");
    for (i, nodes) in models.iter().enumerate() {
        let path = folder.path().join(format!("{i}.gltf"));
        std::fs::write(path, model(nodes)).expect("a file");
    }
    let text = format!(
        "[render]\nwidth = 32\nheight = 24\nsamples = 4\nfilter = 'box'\n[output]\naovs = ['depth', 'objectId', 'materialId', 'lightgroup_rim']\n\
         [camera]\nperspective = {{ eye = [0, 2, 9], target = [0, 1, 0], fov = 40 }}\n\
         [background]\ncolor = 0.2\n\
         [material.red]\nmatte = {{ albedo = [0.7, 0.1, 0.1] }}\n[material.lamp]\nemitter = {{ radiance = [3, 2, 1] }}\n\
         [material.floor]\nmatte = {{ albedo = 0.5 }}\n\
         [[object]]\nmaterial = 'floor'\nname = 'floor'\nshape.quad = {{ corners = [[-9, 0, 9], [9, 0, 9], [9, 0, -9], [-9, 0, -9]] }}\n\
         {objects}\n\
         [[light]]\nname = 'key'\nrect = {{ position = [2, 6, 3], target = [0, 0, 0], size = [1, 1], power = 200 }}\n\
         [[light]]\nname = 'rim'\ngroup = 'rim'\npoint = {{ position = [-3, 4, 4], intensity = 20 }}\n"
    );
    let source = Source::new(folder.path().join("scene.toml"), text).with(overrides);
    let desc = describe::parse(source).map_err(|e| e.to_string())?;
    let job = Job::new(desc, &Request::default()).map_err(|e| e.to_string())?;
    let scene = job.compile().map_err(|e| e.to_string())?;
    let again = job.compile().map_err(|e| e.to_string())?;
    let film = job
        .render_frame(&mut job.scenes(scene), 0, &Control::default())
        .expect("a film");
    Ok(Shot { film, scene: again })
}

fn shoot(models: &[&[usize]], objects: &str) -> Shot {
    shoot_with(models, objects, Overrides::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// An object of a model, by the number of its file.
fn object(file: usize, keys: &str) -> String {
    format!("[[object]]\nname = 'car{file}'\nshape.mesh = {{ file = '{file}.gltf' }}\n{keys}\n")
}

fn assert_same(a: &Shot, b: &Shot, planes: &[&str]) {
    let differ = a
        .film
        .beauty()
        .iter()
        .zip(b.film.beauty())
        .filter(|(a, b)| a != b)
        .count();
    assert_eq!(differ, 0, "pixels differ");
    for name in planes {
        let [a, b] = [a, b].map(|shot| &shot.film.plane(name).expect("a pass").values);
        assert!(
            a.iter().map(|v| v.to_bits()).eq(b.iter().map(|v| v.to_bits())),
            "{name}"
        );
    }
}

fn names(shot: &Shot, kind: MatteKind) -> Vec<String> {
    let mattes = shot.scene.mattes().table(kind).mattes.iter();
    mattes.map(|matte| matte.name.clone()).collect()
}

#[test]
fn an_object_of_some_nodes_is_a_model_without_the_others() {
    for (keys, nodes) in [
        ("nodes = ['Body']", &ALL[..4]),
        ("nodes = ['Wheel_?']", &[1, 2, 3][..]),
        ("nodes = ['*L', 'Mast']", &[1, 3, 4]),
        ("nodes = ['Hub']", &[3]),
        ("nodes = ['*']", &ALL),
    ] {
        let (some, alone) = (shoot(&[&ALL], &object(0, keys)), shoot(&[nodes], &object(0, "")));
        assert_same(&some, &alone, &["depth", "objectId", "materialId"]);
        for kind in [MatteKind::Object, MatteKind::Material, MatteKind::Asset] {
            assert_eq!(names(&some, kind), names(&alone, kind), "{keys}");
        }
    }
}

#[test]
fn parts_that_are_not_visible_look_like_a_model_without_them_and_keep_their_names() {
    let whole = shoot(&[&ALL], &object(0, ""));
    for (keys, nodes) in [
        ("[[object.part]]\nnodes = ['Wheel*']\nvisible = false", &[0, 4][..]),
        (
            "[[object.part]]\nnodes = ['Body', 'Mast']\nvisible = false\n[[object.part]]\nnodes = ['Wheel_R']\nvisible = true",
            &[2],
        ),
        (
            "[[object.part]]\nnodes = ['Wheel_L']\n[[object.part]]\nnodes = ['Hub']\nvisible = false",
            &[0, 1, 2, 4],
        ),
    ] {
        let (some, alone) = (shoot(&[&ALL], &object(0, keys)), shoot(&[nodes], &object(0, "")));
        assert_same(&some, &alone, &["depth"]);
        let sorted = |mut names: Vec<String>| {
            names.sort();
            names
        };
        assert_eq!(
            sorted(names(&some, MatteKind::Object)),
            sorted(names(&whole, MatteKind::Object)),
            "{keys}"
        );
        assert_eq!(names(&some, MatteKind::Material), names(&whole, MatteKind::Material));
    }
}

#[test]
fn parts_with_settings_look_like_objects_with_them() {
    for settings in [
        "material = 'red'",
        "material = 'lamp'\ngroup = 'rim'",
        "ray_visibility = { camera = false }",
        "ray_visibility = { shadow = false }",
        "holdout = true",
        "shadow_catcher = true",
        "lights = ['rim']",
        "exclude_lights = ['group:rim', 'background']",
        "back_faces = 'culled'",
        "back_faces = 'black'\nmaterial = 'red'",
    ] {
        let part = format!("[[object.part]]\nnodes = ['Wheel*']\n{settings}");
        let parts = shoot(&[&ALL], &object(0, &part));
        let objects = object(0, "") + &object(1, settings);
        let objects = shoot(&[&[0, 4], &[1, 2, 3]], &objects);
        assert_same(&parts, &objects, &["depth", "lightgroup_rim"]);
        assert!(
            names(&parts, MatteKind::Object)
                .iter()
                .any(|name| name == "car0/Body/Wheel_L/Hub"),
            "{settings}"
        );
    }
}

#[test]
fn a_part_has_what_it_does_not_give_from_its_object() {
    let part = "material = 'red'\nexclude_lights = ['rim']\n[[object.part]]\nnodes = ['Wheel*']\nvisible = true";
    let plain = "material = 'red'\nexclude_lights = ['rim']";
    assert_same(
        &shoot(&[&ALL], &object(0, part)),
        &shoot(&[&ALL], &object(0, plain)),
        &["depth"],
    );
}

#[test]
fn numbers_and_names_of_parts_are_those_of_the_nodes_of_their_object() {
    let plain = shoot(&[&ALL], &object(0, ""));
    let parts = shoot(
        &[&ALL],
        &object(
            0,
            "[[object.part]]\nnodes = ['Wheel_L', 'Mast']\nlights = ['key', 'rim', 'background']",
        ),
    );
    // Each pixel names the same node.
    let node = |shot: &Shot, at: usize| {
        let id = shot.film.plane("objectId").expect("a pass").values[at].to_bits() as usize;
        let part = id.checked_sub(1).map(|at| shot.scene.mattes().parts()[at]);
        part.map(|part| shot.scene.part_name(part.object, part.node))
    };
    for at in 0..32 * 24 {
        assert_eq!(node(&plain, at), node(&parts, at));
    }
    let moved = shoot(
        &[&ALL],
        &object(0, "[object.node.Wheel_R]\ntransform.translate = [0, 0.5, 0]"),
    );
    for other in [&parts, &moved] {
        assert_eq!(names(&plain, MatteKind::Object), names(other, MatteKind::Object));
    }
    assert_eq!(plain.scene.mattes().parts().len(), parts.scene.mattes().parts().len());
    assert_eq!(names(&plain, MatteKind::Asset), names(&parts, MatteKind::Asset));
}

#[test]
fn settings_of_parts_are_values_with_names() {
    let keys = "[[object.part]]\nnodes = ['Wheel*']";
    let set = |key: &str, value: &str| {
        let overrides = Overrides::default().with(key, value.parse::<toml::Value>().expect("a value"));
        shoot_with(&[&ALL], &object(0, keys), overrides).unwrap_or_else(|e| panic!("{e}"))
    };
    let gone = shoot(&[&ALL], &object(0, &format!("{keys}\nvisible = false")));
    assert_same(&set("object.car0.part.0.visible", "false"), &gone, &["depth"]);
    let red = shoot(&[&ALL], &object(0, &format!("{keys}\nmaterial = 'red'")));
    assert_same(&set("object.car0.part.0.material", "'red'"), &red, &["depth"]);
    // Nodes have values whatever part they are in.
    let moved = set("object.car0.node.Wheel_L.transform.translate.y", "1.0");
    assert!(moved.film.beauty() != red.film.beauty());
}

#[test]
fn a_pattern_without_a_node_is_an_error_that_suggests_one() {
    let fail = |keys: &str| {
        shoot_with(&[&ALL], &object(0, keys), Overrides::default())
            .err()
            .expect("an error")
    };
    assert!(fail("nodes = ['Body', 'Wheel_l']").contains("did you mean `Wheel_L`?"));
    assert!(fail("[[object.part]]\nnodes = ['Door*']\nvisible = false").contains("unknown node `Door*`"));
    let text = "[[object]]\nmaterial = 'red'\nshape.sphere = { radius = 1 }\nnodes = ['Body']";
    let error = shoot_with(&[&ALL], text, Overrides::default()).err().expect("an error");
    assert!(error.contains("only a `shape.mesh` has nodes"), "{error}");
}
