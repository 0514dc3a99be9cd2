//! Values that replace those of a scene file, and the errors that name their origins.

use std::path::PathBuf;

use batch_render::describe::{Overrides, SceneDesc, Source, parse};

fn read(text: &str, overrides: Overrides) -> Result<SceneDesc, String> {
    parse(Source::new(PathBuf::from("s.toml"), text).with(overrides)).map_err(|e| e.to_string())
}

fn samples(text: &str, overrides: Overrides) -> (u32, Option<(u32, f32)>) {
    let desc = read(&format!("[render]\n{text}"), overrides).expect("valid");
    let samples = desc.render.samples.get_ref();
    let adaptive = samples.adaptive().map(|a| (a.min.get_ref().0, a.threshold.0));
    (samples.max(), adaptive)
}

#[test]
fn a_value_replaces_that_of_the_file_or_adds_it() {
    let overrides = Overrides::default()
        .with("render.width", 8)
        .with("output.view", "agx")
        .with("output.aovs", vec!["N", "depth"]);
    let desc = read("[render]\nwidth = 4\nheight = 5", overrides).expect("valid");
    assert_eq!((desc.render.width.get_ref().0, desc.render.height.get_ref().0), (8, 5));
    assert_eq!(desc.output.view.name(), "agx");
    assert_eq!(desc.output.aovs.expect("two passes").0.len(), 2);
}

#[test]
fn a_wrong_value_names_its_origin_and_suggests_another() {
    let mut overrides = Overrides::default();
    overrides.set("--view", "output.view", "agy");
    overrides.set("--integrator", "render.integrator", "whited");
    overrides.set("--seed", "render.seed", -1);
    let errors = read("[render]\nseed = 4", overrides).expect_err("three are wrong");
    assert!(
        errors.contains("--view: unknown view `agy` (did you mean `agx`?)"),
        "{errors}"
    );
    let overrides = Overrides::default().with("render.integrator", "whited");
    assert_eq!(
        read("", overrides).expect_err("a typing error"),
        "render.integrator: unknown integrator `whited` (did you mean `whitted`?)"
    );
    let overrides = Overrides::default().with("render.sed", 1);
    assert_eq!(
        read("", overrides).expect_err("a typing error"),
        "render.sed: unknown key `sed` (did you mean `seed`?)"
    );
}

#[test]
fn a_kind_keeps_its_settings_where_it_stays_the_same() {
    let depth = |kind: &str| {
        let text = "[render]\nintegrator.path = { max_depth = 3 }";
        let desc = read(text, Overrides::default().with("render.integrator", kind)).expect("valid");
        format!("{:?}", desc.render.integrator)
    };
    assert!(depth("path").contains("Count(3)") && !depth("whitted").contains("Count(3)"));
    let overrides = Overrides::default().with("render.integrator.path.max_depth", 7);
    let desc = read("[render]\nintegrator = 'path'", overrides).expect("valid");
    assert!(format!("{:?}", desc.render.integrator).contains("Count(7)"));
}

#[test]
fn samples_stay_adaptive_or_fixed() {
    let max = |n: i64| Overrides::default().with("render.samples", n);
    let threshold = Overrides::default().with("render.samples.threshold", 0.5);
    assert_eq!(samples("samples = 4", max(9)), (9, None));
    assert_eq!(
        samples("samples = { min = 20, max = 80, threshold = 0.1 }", max(9)),
        (9, Some((20, 0.1)))
    );
    assert_eq!(samples("samples = 4", threshold.clone()), (4, Some((16, 0.5))));
    assert_eq!(samples("", threshold.clone()), (64, Some((16, 0.5))));
    let both = threshold.with("render.samples.min", 2);
    assert_eq!(samples("samples = 4", both), (4, Some((2, 0.5))));
    let error = read("", Overrides::default().with("render.samples.min", 2)).expect_err("not adaptive");
    assert!(
        error.starts_with("render.samples.min: the number of samples is fixed"),
        "{error}"
    );
    assert!(read("", max(0)).expect_err("no samples").contains("at least 1"));
}

#[test]
fn elements_of_lists_are_counted_from_0() {
    let text = "[[light]]\nsun = { direction = [0, -1, 0], irradiance = 1 }";
    let dark = |n: u32| Overrides::default().with(&format!("light.{n}.sun.irradiance"), 0.25);
    let lights = read(text, dark(0)).expect("one light").lights;
    assert!(format!("{lights:?}").contains("0.25"));
    let error = read(text, dark(1)).expect_err("one light");
    assert_eq!(
        error,
        "light.1.sun.irradiance: `light` has no element 1, they count from 0"
    );
}

#[test]
fn only_values_of_the_scene_itself_are_beside_the_settings() {
    let overrides = Overrides::default()
        .with("render.samples", 4)
        .with("output.view", "agx");
    assert_eq!(overrides.of_scene(), "");
    let overrides = overrides
        .with("render.working_space", "acescg")
        .with("camera.perspective.fov", 40);
    assert_eq!(
        overrides.of_scene(),
        "render.working_space = \"acescg\"\ncamera.perspective.fov = 40\n"
    );
}

#[test]
fn a_path_ends_at_values_that_are_no_tables() {
    let error = read("[render]\nseed = 4", Overrides::default().with("render.seed.x", 1)).expect_err("no table");
    assert_eq!(error, "render.seed.x: `seed` is no table but of type integer");
}

#[test]
fn a_key_of_another_kind_is_refused_unless_the_kind_is_set_first() {
    let text = "[render]\nintegrator = 'path'";
    let deeper = |overrides: Overrides| overrides.with("render.integrator.whitted.max_depth", 3);
    assert_eq!(
        read(text, deeper(Overrides::default())).expect_err("another kind"),
        "render.integrator.whitted.max_depth: the integrator is `path` (line 2), not `whitted` \
         (to replace it, set render.integrator=whitted before)"
    );
    let replaced = deeper(Overrides::default().with("render.integrator", "whitted"));
    assert_eq!(read(text, replaced).expect("valid").render.integrator.name(), "whitted");
    assert_eq!(
        read("", deeper(Overrides::default()))
            .expect("valid")
            .render
            .integrator
            .name(),
        "whitted"
    );
}

#[test]
fn a_new_name_is_accepted_only_where_the_file_defines_none() {
    let red = Overrides::default()
        .with("material.red.matte.albedo", 1)
        .with("material.red.matte.albedo", 0.5);
    assert_eq!(read("", red.clone()).expect("valid").materials.len(), 1);
    let error = read("[material.rad]\nmatte = { albedo = 1 }", red).expect_err("a typing error");
    assert!(
        error.starts_with("material.red.matte.albedo: unknown material `red` (did you mean `rad`?)"),
        "{error}"
    );
}

#[test]
fn an_empty_list_of_files_is_refused() {
    let error = read("[output]\nfiles = []", Overrides::default()).expect_err("no file");
    assert!(error.contains("expected at least one file"), "{error}");
}

#[test]
fn a_kind_that_is_set_first_takes_the_place_of_the_other_and_keeps_the_name() {
    let text = "[camera]\nperspective = { eye = [0, 0, 5], target = [0, 0, 0] }\n\
                [[light]]\nname = 'key'\nspot = { position = [0, 1, 2], direction = [0, -1, 0], cone_angle = 20, intensity = 3 }\n";
    let to_disk = Overrides::default()
        .with("light.key", "disk")
        .with("light.key.disk.position", toml::Value::from(vec![0, 3, 0]))
        .with("light.0.disk.direction", toml::Value::from(vec![0, -1, 0]))
        .with("light.key.disk.radius", 2)
        .with("light.key.disk.power", 9);
    let desc = read(text, to_disk).expect("a scene");
    assert_eq!(desc.lights[0].light.name(), "disk");
    assert_eq!(
        desc.lights[0].name.as_ref().map(|name| name.get_ref().as_str()),
        Some("key")
    );
    let missing = read(text, Overrides::default().with("light.key", "disk")).unwrap_err();
    assert!(missing.contains("missing field"), "{missing}");
}

#[test]
fn a_list_that_is_too_long_is_refused_in_every_scene_of_a_kind() {
    let mut lists = 0;
    for entry in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/kinds")).expect("a folder") {
        let path = entry.expect("a file").path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("a text");
        let is_of_list = |c: char| c.is_ascii_digit() || "+-.e_, ".contains(c);
        for (end, _) in text.match_indices(']') {
            let numbers = text[..end].rsplit('[').next().unwrap_or_default();
            if numbers.is_empty() || !numbers.chars().all(is_of_list) {
                continue;
            }
            let longer = format!("{}, 0{}", &text[..end], &text[end..]);
            let refused = parse(Source::new(path.clone(), longer));
            let message = refused.err().map(|e| e.to_string()).unwrap_or_default();
            assert!(
                message.contains("expected"),
                "{}: [{numbers}, 0] is read",
                path.display()
            );
            lists += 1;
        }
    }
    assert!(lists > 100, "{lists}");
}
