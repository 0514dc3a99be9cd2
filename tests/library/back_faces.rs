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
fn roof(up: &str, keys: &str) -> String {
    let corners = match up {
        "up" => "[-3, 2, 3], [3, 2, 3], [3, 2, -3], [-3, 2, -3]",
        _ => "[-3, 2, -3], [3, 2, -3], [3, 2, 3], [-3, 2, 3]",
    };
    scene(MATERIALS[0], &format!("quad = {{ corners = [{corners}] }}"), keys)
}

#[test]
fn a_surface_throws_no_shadow_on_what_its_culled_back_faces() {
    let direct = "integrator.path = { max_depth = 2, strategy = 'light' }";
    let shaded = shoot(direct, &roof("up", ""));
    let gone = shoot(direct, &roof("up", "visible = false"));
    let culled = shoot(direct, &roof("up", "back_faces = 'culled'"));
    // The camera is below: it sees the back.
    assert_same(&culled, &gone, &["depth", "albedo", "objectId"]);
    assert!(culled.beauty() != shaded.beauty());
    let down = shoot(direct, &roof("down", "back_faces = 'culled'"));
    assert_same(&down, &shoot(direct, &roof("down", "")), ALL);
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
