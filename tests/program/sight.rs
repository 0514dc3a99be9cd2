//! Pictures that show next to nothing are warned of, and an exposure that suits the scene is found.

use crate::common::{Folder, pixels, stderr};

fn scene(light: &str, rest: &str) -> String {
    format!(
        "[render]\nwidth = 16\nheight = 16\nsamples = 4\n[camera]\nperspective = {{ eye = [0, 0, 4], target = [0, 0, 0] }}\n\
         [material.m]\nmatte = {{ albedo = 0.5 }}\n[[object]]\nmaterial = 'm'\n\
         shape.plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }}\n{light}\n{rest}\n"
    )
}

fn sun(irradiance: f32) -> String {
    format!("[[light]]\nsun = {{ direction = [0, 0, -1], irradiance = {irradiance} }}")
}

/// The messages about the pictures of a scene.
fn log(folder: &Folder, text: &str, args: &[&str]) -> String {
    folder.write("s.toml", text);
    let output = folder.run(&[&["s.toml", "--progress", "none", "-o", "f.####.png"], args].concat());
    assert!(output.status.success());
    stderr(&output)
}

#[test]
fn a_picture_that_is_mostly_clipped_or_black_is_warned_of_once_with_the_reason() {
    let folder = Folder::new();
    assert_eq!(log(&folder, &scene(&sun(2.0), ""), &[]), "");
    // White is not clipped, and a dark sky around what is seen is no fault.
    assert_eq!(log(&folder, &scene("", "[background]\ncolor = 1"), &[]), "");
    let away = scene(&sun(2.0), "").replace(
        "shape.plane = { point = [0, 0, 0], normal = [0, 0, 1] }",
        "shape.sphere = { center = [0, 0, 0], radius = 0.3 }",
    );
    assert_eq!(log(&folder, &away, &[]), "");
    folder.write(
        "p.csv",
        "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n1,0,0,4,0,0,0\n2,0,1,4,0,0,0\n",
    );
    let said = log(&folder, &scene(&sun(1366.0), ""), &["--frames", "p.csv"]);
    assert_eq!(said.matches("of what is lit").count(), 1, "{said}");
    assert!(
        said.contains("frame 1: 100 % of what is lit is clipped: its brightest light has 1366 W m^-2"),
        "{said}"
    );
    assert!(!said.contains("683") && said.contains("`--exposure auto`"), "{said}");
    // As much where most of the picture is a dark sky.
    let small = away.replace("irradiance = 2", "irradiance = 1366");
    let said = log(&folder, &small, &[]);
    assert!(said.contains(" % of what is lit is clipped: its brightest"), "{said}");
    let said = log(&folder, &scene("", ""), &[]);
    assert!(
        said.contains("100 % of the picture is black: there is no light"),
        "{said}"
    );
    let said = log(
        &folder,
        &scene(&sun(2.0), "").replace("target = [0, 0, 0]", "target = [0, 0, 9]"),
        &[],
    );
    assert!(said.contains("the camera sees nothing of the scene"), "{said}");
    let said = log(&folder, &scene(&sun(2.0).replace("-1]", "1]"), ""), &[]);
    assert!(said.contains("no light reaches what the camera sees"), "{said}");
}

#[test]
fn a_clipped_picture_names_what_is_brightest_and_photometric_lights_only_of_models() {
    let folder = Folder::new();
    let lamp = "[material.lamp]\nemitter = { radiance = 7e29 }\n[[object]]\nmaterial = 'lamp'\nshape.sphere = { center = [0, 0, 3], radius = 0.2 }";
    for (light, rest, reason) in [
        (
            sun(1.0),
            lamp,
            "clipped: the material `lamp` emits 7.00e29 W m^-2 sr^-1",
        ),
        (
            sun(1.0),
            "[background]\ncolor = [1, 90, 3]",
            "clipped: the background has 90.000 W m^-2 sr^-1 on average",
        ),
        (
            sun(2.0).replace("= 2", "= 3e38"),
            "[background]\ncolor = 90",
            "clipped: its brightest light has 3.00e38 W m^-2",
        ),
    ] {
        let said = log(&folder, &scene(&light, rest), &[]);
        assert!(said.contains(reason) && !said.contains("683"), "{said}");
    }
    let point = r#"{"type": "point", "intensity": 5000}"#;
    folder.write("m.gltf", &crate::model_lights::model("a camera", point));
    let shot = [
        "m.gltf",
        "--progress",
        "none",
        "--resolution",
        "16x16",
        "--samples",
        "1",
        "-o",
        "m.png",
    ];
    let said = stderr(&folder.run(&shot));
    assert!(said.contains("in candela or lux are to be divided by 683"), "{said}");
}

#[test]
fn a_model_that_burns_out_or_is_not_seen_before_its_backdrop_is_warned_of() {
    let folder = Folder::new();
    folder.write("cube.obj", crate::stage::CUBE);
    let shot = |flags: &[&str]| {
        let small = [
            "cube.obj",
            "--progress",
            "none",
            "--resolution",
            "32x24",
            "--samples",
            "4",
            "-o",
            "m.png",
        ];
        stderr(&folder.run(&[&small, flags].concat()))
    };
    assert_eq!(shot(&[]), "");
    let said = shot(&["--sun", "30,45,1e6"]);
    assert!(
        said.contains("% of what is lit is clipped: its brightest light has 1.00e6 W m^-2"),
        "{said}"
    );
    let away = ["--set", "camera.perspective.target=[0,0,99]"];
    let said = shot(&away);
    assert!(
        said.contains("the camera sees nothing of the scene but its background"),
        "{said}"
    );
    // A part of a picture may well be empty.
    assert_eq!(shot(&[&away[..], &["--crop", "0,0,9,9"]].concat()), "");
}

#[test]
fn a_catcher_or_a_holdout_around_a_small_object_is_no_black_picture() {
    let folder = Folder::new();
    let ball = "[[object]]\nmaterial = 'm'\nshape.sphere = { center = [0, 0, 0.3], radius = 0.3 }\n[background]\nvisible = false\ncolor = 0.4";
    for integrator in ["path", "whitted"] {
        for role in ["shadow_catcher = true", "holdout = true"] {
            let scene = scene(&format!("{role}\n{}", sun(2.0)), ball);
            let scene = scene.replace("samples = 4", &format!("samples = 4\nintegrator = '{integrator}'"));
            assert_eq!(log(&folder, &scene, &[]), "", "{integrator}, {role}");
            // An ordinary object without light is told all the same.
            let dark = scene
                .replace("color = 0.4", "color = 0")
                .replace("irradiance = 2", "irradiance = 0");
            let said = log(&folder, &dark, &[]);
            assert!(said.contains("no light reaches what the camera sees"), "{said}");
        }
    }
}

#[test]
fn a_lamp_whose_file_sends_all_light_to_its_dark_side_is_warned_of() {
    let folder = Folder::new();
    let backwards = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0\n1 1 60\n90 135 180\n0\n100 200 300\n";
    folder.write("back.ies", backwards);
    folder.write("lamp.ies", &backwards.replace("90 135 180", "0 45 90"));
    let lamp = |kind: &str, file: &str, more: &str| {
        let light = format!("{kind}, position = [0, 0, 2], target = [0, 0, 0], ies = \"{file}\"{more} }}");
        let scene = scene(&format!("{}\n[[light]]\n{light}", sun(1.0)), "");
        log(&folder, &scene, &[])
    };
    for kind in ["rect = { size = [1, 1]", "disk = { radius = 1"] {
        for power in ["", ", power = 9"] {
            let said = lamp(kind, "back.ies", power);
            assert!(
                said.contains("light 2 is dark: all light of `ies = \"back.ies\"` goes backwards"),
                "{said}"
            );
            assert!(said.contains("`two_sided = true`"), "{said}");
        }
        assert_eq!(lamp(kind, "back.ies", ", two_sided = true"), "");
        assert_eq!(lamp(kind, "lamp.ies", ", power = 2"), "");
    }
    assert_eq!(lamp("point = { radius = 0", "back.ies", ""), "");
}

#[test]
fn light_that_clips_by_the_division_through_its_alpha_equals_light_that_clips_by_itself() {
    let folder = Folder::new();
    // A sheet of one tenth of alpha that shines: 0.5 with its alpha, and 5 without.
    let sheet = "[render]\nwidth = 16\nheight = 16\nsamples = 64\nintegrator = 'path'\n\
        [camera]\nperspective = { eye = [0, 0, 4], target = [0, 0, 0] }\n[background]\nvisible = false\ncolor = 0\n\
        [material.m]\nprincipled = { emissive = 5, base_color = 0, opacity = 0.1 }\n[[object]]\nmaterial = 'm'\n\
        shape.plane = { point = [0, 0, 0], normal = [0, 0, 1] }\n";
    let said = log(&folder, sheet, &["-o", "f.exr"]);
    assert!(said.contains(" % of what is lit is clipped"), "{said}");
    let shown = image::load_from_memory(&folder.read("f.0001.png"))
        .expect("a picture")
        .into_rgba8();
    let [r, _, _, a] = shown.get_pixel(8, 8).0;
    assert!(r == 255 && a < 64, "{r} {a}");
    // The EXR file holds the light itself.
    let light = pixels(&folder.path("f.exr")).1;
    let mean = light.iter().map(|pixel| pixel[0]).sum::<f32>() / light.len() as f32;
    assert!((mean - 0.5).abs() < 0.05, "{mean}");
    // Without alpha nothing clips.
    assert_eq!(
        log(&folder, &sheet.replace("visible = false", "visible = true"), &[]),
        ""
    );
}

#[test]
fn an_exposure_that_suits_the_scene_is_that_of_the_first_frame_in_every_part() {
    let folder = Folder::new();
    // The second frame sees more of the black sky, and the third nothing else.
    folder.write(
        "p.csv",
        "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n1,0,0,4,0,0,0\n2,0,0,4,9,0,2\n3,0,0,4,0,0,9\n",
    );
    let auto = scene(&sun(1366.0), "[output]\nexposure = 'auto'");
    let said = log(&folder, &auto, &["--frames", "p.csv"]);
    assert!(
        said.contains("frame 3: 100 % of the picture is black: the camera sees nothing"),
        "{said}"
    );
    let whole = folder.read("f.0002.png");
    assert_eq!(
        log(&folder, &auto, &["--frames", "p.csv", "--range", "2", "--samples", "4"]),
        ""
    );
    assert!(folder.read("f.0002.png") == whole, "a part has another exposure");
    let middle = image::load_from_memory(&folder.read("f.0001.png"))
        .expect("a picture")
        .into_rgb8();
    // Middle gray.
    let shown = middle.get_pixel(8, 8).0;
    assert!(shown.iter().all(|v| v.abs_diff(118) <= 1), "{shown:?}");
    // Files of light do not change.
    let said = log(&folder, &scene(&sun(2.0), ""), &["--exposure", "auto", "-o", "a.exr"]);
    assert_eq!(said, "");
    let light = pixels(&folder.path("a.exr")).1[0][0];
    assert!((light - 1.0 / std::f32::consts::PI).abs() < 1e-3, "{light}");
    // The fingerprint is that of the question: nothing is rendered again.
    folder.write("s.toml", &auto);
    let again = ["s.toml", "--frames", "p.csv", "-o", "f.####.png", "--list-stale"];
    folder.succeed(&["s.toml", "--frames", "p.csv", "-o", "f.####.png", "--progress", "none"]);
    assert_eq!(folder.succeed(&again), "");
    let message = folder.fail(2, &["s.toml", "--exposure", "bright"]);
    assert!(
        message.contains("expected a number of stops, such as 1 or -0.5, or `auto`"),
        "{message}"
    );
}
