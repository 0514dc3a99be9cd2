//! One-sided surfaces: against the scene without them, and against surfaces that are black.

use std::path::Path;

use batch_render::{
    batch::{Job, Request},
    describe::{self, Source},
    film::Film,
    render::Control,
};

/// Renders a scene of these tables; `render` stands in `[render]`.
fn shoot(render: &str, tables: &str) -> Film {
    shoot_with(&format!("width = 24\nheight = 18\nsamples = 4\n{render}"), tables)
}

fn shoot_with(render: &str, tables: &str) -> Film {
    let text = format!(
        "[render]\nfilter = 'box'\n{render}\n\
         [output]\naovs = ['depth', 'albedo', 'objectId', 'materialId']\n{tables}"
    );
    let desc = describe::parse(Source::new(Path::new("scene.toml").into(), text)).unwrap_or_else(|e| panic!("{e}"));
    let job = Job::new(desc, &Request::default()).unwrap_or_else(|e| panic!("{e}"));
    let scene = job.compile().unwrap_or_else(|e| panic!("{e}"));
    job.render_frame(&mut job.scenes(scene), 0, &Control::default())
        .expect("a film")
}

/// A floor under a lamp and a sky, and a shape of a material between them; `object` are further keys of the shape.
fn scene(material: &str, shape: &str, object: &str) -> String {
    format!(
        "[camera]\nperspective = {{ eye = [0, 1.5, 5], target = [0, 0.8, 0], fov = 45 }}\n\
         [background]\ncolor = [0.1, 0.2, 0.3]\n\
         [material.floor]\nmatte = {{ albedo = 0.6 }}\n\
         [material.black]\nmatte = {{ albedo = 0 }}\n\
         [material.shown]\n{material}\n\
         [[object]]\nmaterial = 'floor'\nshape.quad = {{ corners = [[-9, 0, 9], [9, 0, 9], [9, 0, -9], [-9, 0, -9]] }}\n\
         [[object]]\nmaterial = 'shown'\nshape.{shape}\n{object}\n\
         [[light]]\nrect = {{ position = [2, 4, 1], target = [0, 0, 0], size = [1, 1], power = 90 }}\n\
         [[light]]\npoint = {{ position = [-1, 3, 2], intensity = 4 }}\n"
    )
}

/// Materials that blocks of lanes hold, and others.
const MATERIALS: [&str; 6] = [
    "matte = { albedo = [0.8, 0.2, 0.1] }",
    "matte = { albedo = 0.5, roughness = 0.7 }",
    "metal = { preset = 'gold', roughness = 0.3 }",
    "principled = { base_color = [0.2, 0.5, 0.3], roughness = 0.4, clearcoat = 1 }",
    "mirror = { reflectance = 0.9 }",
    "mix = { a = 'floor', b = 'black', factor = 0.5 }",
];

const INTEGRATORS: [&str; 3] = ["", "integrator.whitted = {}", "integrator.occlusion = { samples = 4 }"];

/// A ball before the camera, and one around it: the front and the back of a sphere.
const BEFORE: &str = "sphere = { center = [0, 0.8, 0], radius = 0.8 }";
const AROUND: &str = "sphere = { center = [0, 0.8, 0], radius = 20 }";

fn assert_same(a: &Film, b: &Film, planes: &[&str]) {
    let differ = a.beauty().iter().zip(b.beauty()).filter(|(a, b)| a != b).count();
    assert_eq!(differ, 0, "pixels differ");
    for name in planes {
        let [a, b] = [a, b].map(|film| &film.plane(name).expect("a pass").values);
        let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert!(bits(a) == bits(b), "{name}");
    }
}

const ALL: &[&str] = &["depth", "albedo", "objectId", "materialId"];

#[test]
fn fronts_look_the_same_whatever_the_backs_are() {
    for render in INTEGRATORS {
        for material in MATERIALS {
            let shaded = shoot(render, &scene(material, BEFORE, ""));
            for backs in ["black", "culled"] {
                let key = format!("back_faces = '{backs}'");
                assert_same(&shoot(render, &scene(material, BEFORE, &key)), &shaded, ALL);
                let of_material = shoot(render, &scene(&format!("{material}\n{key}"), BEFORE, ""));
                assert_same(&of_material, &shaded, ALL);
            }
        }
    }
}

#[test]
fn culled_backs_are_not_there() {
    for render in INTEGRATORS {
        let gone = shoot(render, &scene(MATERIALS[0], AROUND, "visible = false"));
        for material in MATERIALS {
            let culled = shoot(
                render,
                &scene(&format!("{material}\nback_faces = 'culled'"), AROUND, ""),
            );
            assert_same(&culled, &gone, &["depth", "albedo", "objectId"]);
            let by_object = "back_faces = 'culled'";
            let culled = shoot(render, &scene(material, AROUND, by_object));
            assert_same(&culled, &gone, &["depth", "albedo", "objectId"]);
        }
    }
}

#[test]
fn black_backs_are_black_matte_surfaces_with_their_own_names() {
    for render in &INTEGRATORS[..2] {
        let black = shoot(render, &scene(MATERIALS[0], AROUND, ""));
        let black_matte = shoot(render, &scene("matte = { albedo = 0 }", AROUND, ""));
        assert!(black.beauty() != black_matte.beauty());
        for material in MATERIALS {
            let backs = shoot(render, &scene(material, AROUND, "back_faces = 'black'"));
            assert_same(&backs, &black_matte, ALL);
        }
    }
}

#[test]
fn an_object_wins_over_its_materials() {
    let own = format!("{}\nback_faces = 'black'", MATERIALS[0]);
    let shaded = shoot("", &scene(MATERIALS[0], AROUND, ""));
    assert_same(&shoot("", &scene(&own, AROUND, "back_faces = 'shaded'")), &shaded, ALL);
}

#[test]
fn a_clear_body_and_a_lamp_that_shines_to_both_sides_have_no_backs() {
    for material in ["glass = { ior = 1.5 }", "emitter = { radiance = 1, two_sided = true }"] {
        let shaded = shoot("", &scene(material, BEFORE, ""));
        for backs in ["black", "culled"] {
            let key = format!("back_faces = '{backs}'");
            assert_same(&shoot("", &scene(material, BEFORE, &key)), &shaded, ALL);
        }
    }
}

/// A plane between the floor and the lights, with its front up or down.
fn roof(material: &str, up: &str, keys: &str) -> String {
    let corners = match up {
        "up" => "[-3, 2, 3], [3, 2, 3], [3, 2, -3], [-3, 2, -3]",
        _ => "[-3, 2, -3], [3, 2, -3], [3, 2, 3], [-3, 2, 3]",
    };
    scene(material, &format!("quad = {{ corners = [{corners}] }}"), keys)
}

#[test]
fn a_surface_throws_no_shadow_on_what_its_culled_back_faces() {
    let direct = "integrator.path = { max_depth = 2, strategy = 'light' }";
    let roof = |up, keys| shoot(direct, &roof(MATERIALS[0], up, keys));
    let culled = roof("up", "back_faces = 'culled'");
    // The camera is below: it sees the back.
    assert_same(
        &culled,
        &roof("up", "visible = false"),
        &["depth", "albedo", "objectId"],
    );
    assert!(culled.beauty() != roof("up", "").beauty());
    assert_same(&roof("down", "back_faces = 'culled'"), &roof("down", ""), ALL);
}

#[test]
fn opacity_counts_on_fronts_alone_where_backs_are_culled() {
    let veil = |opacity: &str| {
        format!(
            "principled = {{ base_color = [0.7, 0.3, 0.2], {opacity} }}\n[texture.holes]\nchecker = {{ a = 0, b = 1 }}"
        )
    };
    for veil in [
        "opacity = 0.4",
        "opacity = 'texture.holes'",
        "opacity = 'texture.holes', alpha = 'mask'",
    ]
    .map(veil)
    {
        for render in INTEGRATORS {
            let gone = shoot(render, &scene(&veil, AROUND, "visible = false"));
            let culled = shoot(render, &scene(&veil, AROUND, "back_faces = 'culled'"));
            assert_same(&culled, &gone, &["depth", "albedo", "objectId"]);
        }
        // Shadow rays meet the backs of a roof whose front is up, and its front where that is down.
        let direct = "integrator.path = { max_depth = 2, strategy = 'light' }";
        let roof = |up, keys| shoot(direct, &roof(&veil, up, keys));
        let culled = roof("up", "back_faces = 'culled'");
        assert_same(
            &culled,
            &roof("up", "visible = false"),
            &["depth", "albedo", "objectId"],
        );
        let front = roof("down", "back_faces = 'culled'");
        assert_same(&front, &roof("down", ""), ALL);
        assert!(culled.beauty() != front.beauty());
    }
}

/// A glTF file of a node for each of these materials, with a triangle that looks to +z.
fn gltf(materials: &[&str]) -> String {
    let listed = |text: fn(usize, &str) -> String| {
        let all = materials.iter().enumerate().map(|(i, material)| text(i, material));
        all.collect::<Vec<_>>().join(", ")
    };
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": 36,
        "uri": "data:;base64,AACAvwAAAAAAAIA/AACAPwAAAAAAAIA/AAAAAAAAAEAAAAAA"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, 0, 0], "max": [1, 2, 1]}}],
        "materials": [{}], "meshes": [{}], "nodes": [{}]}}"#,
        listed(|i, sides| {
            let color = format!(r#""pbrMetallicRoughness": {{"baseColorFactor": [0.{i}, 0.5, 0.2, 1]}}"#);
            format!(r#"{{"name": "M{i}", {color}{sides}}}"#)
        }),
        listed(|i, _| format!(r#"{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": {i}}}]}}"#)),
        listed(|i, _| format!(
            r#"{{"name": "N{i}", "mesh": {i}, "translation": [{}, 0, 0]}}"#,
            2.2 * i as f32
        )),
    )
}

#[test]
fn a_gltf_file_says_which_of_its_surfaces_have_backs() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.gltf");
    let picture = |turn: f32, keys: &str| {
        let shape = format!(
            "mesh = {{ file = '{}' }}\ntransform = {{ rotate = [0, {turn}, 0] }}",
            path.display()
        );
        // The model has its own materials.
        let tables = scene(MATERIALS[0], &shape, keys).replace("material = 'shown'\n", "");
        shoot("", &tables)
    };
    let (one_sided, two_sided) = (r#", "doubleSided": false"#, r#", "doubleSided": true"#);
    for (sides, is_culled) in [("", true), (one_sided, true), (two_sided, false)] {
        std::fs::write(&path, gltf(&[sides])).expect("a file");
        for turn in [0.0, 180.0] {
            let shaded = picture(turn, "");
            let expected = if is_culled { "back_faces = 'culled'" } else { "" };
            let by_file = picture(turn, "back_faces = 'file'");
            assert_same(&by_file, &picture(turn, expected), ALL);
            // Seen from the front, light passes the back.
            assert_eq!(by_file.beauty() != shaded.beauty(), is_culled, "{sides} {turn}");
        }
    }
    // One file with surfaces of both sorts.
    std::fs::write(&path, gltf(&[one_sided, two_sided])).expect("a file");
    let by_file = picture(180.0, "back_faces = 'file'");
    let by_part = picture(180.0, "[[object.part]]\nnodes = ['N0']\nback_faces = 'culled'");
    assert_same(&by_file, &by_part, &["depth", "albedo"]);
    let all = ["shaded", "culled"].map(|backs| picture(180.0, &format!("back_faces = '{backs}'")));
    assert!(all.iter().all(|film| film.beauty() != by_file.beauty()));
}

#[test]
fn what_lights_bring_past_one_sided_surfaces_does_not_depend_on_the_strategy() {
    let panes = "[material.pane]\nglass = { thin_walled = true }\nback_faces = 'black'\n\
                 [material.wall]\nmatte = { albedo = 0.7 }\nback_faces = 'culled'\n\
                 [material.lamp]\nemitter = { radiance = 5 }\nback_faces = 'culled'\n\
                 [[object]]\nmaterial = 'pane'\nshape.quad = { corners = [[-2, 2, 2], [2, 2, 2], [2, 2, 0], [-2, 2, 0]] }\n\
                 [[object]]\nmaterial = 'pane'\nshape.quad = { corners = [[-2, 2, -2], [2, 2, -2], [2, 2, 0], [-2, 2, 0]] }\n\
                 [[object]]\nmaterial = 'wall'\nshape.quad = { corners = [[-2, 0, -2], [2, 0, -2], [2, 2, -2], [-2, 2, -2]] }\n\
                 [[object]]\nmaterial = 'lamp'\nshape.quad = { corners = [[-1, 3, -1], [1, 3, -1], [1, 3, 1], [-1, 3, 1]] }\n";
    let point = "point = { position = [-1, 3, 2], intensity = 4 }";
    let rect = "rect = { position = [-1, 3, 2], target = [0, 0, 0], size = [1, 1], power = 20 }";
    let tables = scene(MATERIALS[0], BEFORE, "").replace(point, rect) + panes;
    let mean = |strategy: &str| {
        let integrator = format!("integrator.path = {{ max_depth = 4, strategy = '{strategy}' }}");
        let film = shoot_with(&format!("width = 12\nheight = 9\nsamples = 256\n{integrator}"), &tables);
        film.beauty().iter().map(|p| f64::from(p[1])).sum::<f64>()
    };
    let (light, bsdf, mis) = (mean("light"), mean("bsdf"), mean("mis"));
    let differ = |a: f64| (a - mis).abs() > 0.02 * mis;
    assert!(!differ(light) && !differ(bsdf), "{light} {bsdf} {mis}");
}
