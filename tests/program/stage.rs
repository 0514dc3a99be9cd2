//! Flags that light a scene and place its camera, compared with scene files that say the same.

use crate::common::{Folder, pixels, repo_str};

const SIDE: usize = 24;
const HEAD: &str = "[render]\nwidth = 24\nheight = 24\nsamples = 8\n[background]\ncolor = 0.3\n";
const CAMERA: &str = "[camera]\nperspective = { eye = [0, 1, 6], target = [0, 0, 0], fov = 30 }\n";
const BALL: &str = "[material.m]\nmatte = { albedo = 0.7 }\n[[object]]\nname = \"ball\"\nmaterial = \"m\"\n\
                    shape.sphere = { center = [0, 0, 0], radius = 1 }\n";
/// A white cube of 2 m around the origin.
pub const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
                    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n";

/// The pixels of a scene with these flags.
fn picture(scene: &str, flags: &[&str]) -> Vec<[f32; 3]> {
    let folder = Folder::new();
    folder.write("s.toml", scene);
    folder.succeed(&[&["s.toml", "-o", "p.exr"], flags].concat());
    pixels(&folder.path("p.exr")).1
}

fn message(scene: &str, flags: &[&str]) -> String {
    let folder = Folder::new();
    folder.write("s.toml", scene);
    folder.fail(2, &[&["s.toml", "-o", "p.exr"], flags].concat())
}

/// The pixels of the cube as a model by itself.
fn cube(flags: &[&str]) -> Vec<[f32; 3]> {
    let folder = Folder::new();
    folder.write("cube.obj", CUBE);
    let small = ["--resolution", "24x24", "--samples", "8"];
    let small = if flags.contains(&"--samples") { &[] } else { &small[..] };
    folder.succeed(&[&["cube.obj", "-o", "p.exr"], small, flags].concat());
    pixels(&folder.path("p.exr")).1
}

#[test]
fn an_environment_of_a_flag_is_that_of_a_scene_file() {
    let map = repo_str("scenes/kinds/sky.hdr");
    let scene = format!("{HEAD}{CAMERA}{BALL}");
    let named = scene.replace("color = 0.3", &format!("environment = {{ file = '{map}' }}"));
    let by_flag = picture(&scene, &["--environment", &map]);
    assert!(by_flag == picture(&named, &[]));
    assert!(by_flag != picture(&scene, &[]));
    // It takes the place of the sky and the sun of a model.
    let folder = Folder::new();
    folder.write("cube.obj", CUBE);
    let text = folder.succeed(&["check", "cube.obj", "--json", "--environment", &map]);
    assert!(text.contains("\"lights\": 0"), "{text}");
}

#[test]
fn an_environment_of_a_flag_starts_at_the_current_folder() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("a")).expect("a folder");
    folder.write("a/s.toml", &format!("{HEAD}{CAMERA}{BALL}"));
    std::fs::copy(repo_str("scenes/kinds/sky.hdr"), folder.path("sky.hdr")).expect("a copy");
    folder.succeed(&["a/s.toml", "-o", "p.exr", "--environment", "sky.hdr"]);
    let job = ["a/s.toml", "-o", "p.exr", "--environment", "sky.hdr", "--list-stale"];
    assert_eq!(folder.succeed(&job), "");
    let other = folder.succeed(&["a/s.toml", "-o", "p.exr", "--list-stale"]);
    assert!(other.contains("p.exr"), "{other}");
    // The message names the flag, also where a model by itself has no file of a scene.
    std::fs::copy(repo_str("scenes/cube/cube.obj"), folder.path("cube.obj")).expect("a copy");
    for scene in ["a/s.toml", "cube.obj"] {
        let message = folder.fail(66, &[scene, "-o", "p.exr", "--environment", "none.hdr"]);
        assert!(
            message.starts_with("error: --environment: cannot read image: "),
            "{message}"
        );
    }
}

#[test]
fn a_background_of_a_flag_is_seen_and_lights_nothing() {
    let scene = format!("{HEAD}{CAMERA}{BALL}");
    let (plain, shown) = (picture(&scene, &[]), picture(&scene, &["--background", "1,0.5,0.25"]));
    let middle = SIDE / 2 * SIDE + SIDE / 2;
    assert_eq!(shown[0], [1.0, 0.5, 0.25]);
    assert_eq!(shown[middle], plain[middle]);
    let coded = picture(&scene, &["--background", "#ff0080"])[0];
    assert!(
        (coded[0] - 1.0).abs() < 1e-3 && coded[1] == 0.0 && (coded[2] - 0.2159).abs() < 1e-3,
        "{coded:?}"
    );
    let hidden = scene.replace("color = 0.3", "color = 0.3\nvisible = false");
    assert_eq!(picture(&hidden, &["--background", "0.5"])[0], [0.5; 3]);
}

#[test]
fn a_backdrop_does_not_change_the_metered_exposure() {
    let exposure = |color: &str| {
        let folder = Folder::new();
        folder.write("cube.obj", CUBE);
        let job = [
            "cube.obj",
            "-v",
            "-o",
            "p.png",
            "--resolution",
            "24x24",
            "--samples",
            "1",
        ];
        let output = folder.run(&[&job[..], &["--exposure", "auto", "--background", color]].concat());
        let log = crate::common::stderr(&output);
        let line = log
            .lines()
            .find(|line| line.contains("the exposure is"))
            .map(str::to_owned);
        let line = line.unwrap_or_else(|| panic!("{log}"));
        line.split("the exposure is ")
            .nth(1)
            .and_then(|rest| rest.split(' ').next()?.parse().ok())
            .unwrap_or(f64::NAN)
    };
    let (dark, bright): (f64, f64) = (exposure("0.001"), exposure("4"));
    // Only pixels at the silhouette mix both.
    assert!((dark - bright).abs() < 0.3, "{dark} and {bright}");
}

#[test]
fn before_a_backdrop_no_sun_is_seen() {
    let sky = "sky = { elevation = 3, azimuth = 0, sun_size = 8 }";
    let scene = format!("{HEAD}{CAMERA}").replace("color = 0.3", sky);
    let (seen, hidden) = (picture(&scene, &[]), picture(&scene, &["--background", "0.25"]));
    assert!(seen.iter().any(|pixel| pixel[0] > 1.0));
    assert!(hidden.iter().all(|pixel| *pixel == [0.25; 3]));
}

#[test]
fn a_sun_of_a_flag_turns_that_of_the_scene_or_is_added() {
    let scene = format!("{HEAD}{CAMERA}{BALL}");
    let sun = |direction: &str, irradiance: f32| {
        format!("{scene}[[light]]\nsun = {{ direction = {direction}, irradiance = {irradiance}, angle = 0.53 }}\n")
    };
    let right = sun("[-1, 0, 0]", 2.2);
    assert!(picture(&scene, &["--sun", "90,0"]) == picture(&right, &[]));
    assert!(picture(&sun("[0, -1, 0]", 3.0), &["--sun", "90,0"]) == picture(&sun("[-1, 0, 0]", 3.0), &[]));
    assert!(picture(&sun("[0, -1, 0]", 3.0), &["--sun", "0,90,5"]) == picture(&sun("[0, -1, 0]", 5.0), &[]));
    let two = format!("{right}[[light]]\nsun = {{ direction = [0, -1, 0], irradiance = 1 }}\n");
    let found = message(&two, &["--sun", "0,45"]);
    assert!(found.contains("--sun: the scene has 2 suns"), "{found}");
    let found = message(&scene, &["--sun", "north"]);
    assert!(found.contains("AZIMUTH,ELEVATION"), "{found}");
    assert!(cube(&["--sun", "-60,20"]) != cube(&[]));
}

#[test]
fn a_lens_of_a_flag_takes_the_place_of_a_field_of_view() {
    let scene = format!("{HEAD}{CAMERA}{BALL}");
    let with = |lens: &str| scene.replace("fov = 30", lens);
    let found = picture(&scene, &["--lens", "50"]);
    assert!(found == picture(&with("focal_length = 50, sensor_width = 36"), &[]));
    assert!(found == picture(&with("fov_x = 20"), &["--lens", "50"]));
    let blurred = picture(&scene, &["--lens", "50", "--fstop", "0.02"]);
    assert!(blurred == picture(&with("focal_length = 50, sensor_width = 36, fstop = 0.02"), &[]));
    assert!(blurred != found);
    let flat = scene
        .replace("perspective = {", "orthographic = {")
        .replace("fov = 30", "height = 4");
    let text = message(&flat, &["--lens", "50"]);
    assert!(
        text.contains("--lens: only a perspective camera has a focal length"),
        "{text}"
    );
    let text = message(&flat, &["--fstop", "2"]);
    assert!(
        text.contains("--fstop: only a perspective camera has an aperture"),
        "{text}"
    );
    let text = message(&scene, &["--fstop", "0"]);
    assert!(text.contains("expected a number above 0"), "{text}");
}

/// The first and the last column and row of a picture of `side` columns in which something is.
fn extent(pixels: &[[f32; 3]], side: usize) -> [usize; 4] {
    let seen = (0..pixels.len()).filter(|i| pixels[*i] != [0.0; 3]);
    seen.fold([side, 0, side, 0], |[x0, x1, y0, y1], i| {
        let (x, y) = (i % side, i / side);
        [x0.min(x), x1.max(x), y0.min(y), y1.max(y)]
    })
}

#[test]
fn a_long_lens_frames_a_model_as_a_short_one_does() {
    let dark = ["--background", "0", "--resolution", "24x24", "--samples", "1"];
    for lens in ["24", "50", "135"] {
        let [x0, x1, y0, y1] = extent(&cube(&[&dark[..], &["--lens", lens]].concat()), SIDE);
        assert!(
            x0 >= 1 && x1 <= SIDE - 2 && y0 >= 1 && y1 <= SIDE - 2,
            "{lens}: {x0} {x1} {y0} {y1}"
        );
        assert!((x1 - x0).max(y1 - y0) >= 2 * SIDE / 3, "{lens}: {x0} {x1} {y0} {y1}");
    }
}

#[test]
fn a_framed_scene_fits_and_fills_the_picture_in_all_frames() {
    let folder = Folder::new();
    // The camera is far too near, or far too far away.
    for (eye, lens) in [
        ("[0, 1, 1.1]", "fov = 30"),
        ("[90, 10, 60]", "focal_length = 35"),
        ("[3, 1, 4]", "fov = 70, shift = [0.2, 0.1]"),
    ] {
        let camera = format!("[camera]\nperspective = {{ eye = {eye}, target = [0, 0, 0], {lens} }}\n");
        folder.write(
            "s.toml",
            &format!(
                "{}{camera}{BALL}",
                HEAD.replace("color = 0.3", "color = 0.3\nbackdrop = 0")
            ),
        );
        folder.succeed(&["s.toml", "-o", "p.exr", "--frame-to-fit", "--samples", "1"]);
        let [x0, x1, y0, y1] = extent(&pixels(&folder.path("p.exr")).1, SIDE);
        assert!(
            x0 >= 1 && x1 <= SIDE - 2 && y0 >= 1 && y1 <= SIDE - 2,
            "{eye}: {x0} {x1} {y0} {y1}"
        );
        // The box of the ball is larger than the ball.
        assert!((x1 - x0).max(y1 - y0) >= SIDE / 3, "{eye}: {x0} {x1} {y0} {y1}");
    }
    // It moves by 8 m, and all parts of the job agree.
    folder.write(
        "s.toml",
        &format!(
            "{}{CAMERA}{BALL}",
            HEAD.replace("color = 0.3", "color = 0.3\nbackdrop = 0")
        ),
    );
    folder.write(
        "v.csv",
        "frame,interp,object.ball.transform.translate.x\n1,linear,-4\n5,linear,4\n",
    );
    let job = [
        "s.toml",
        "--values",
        "v.csv",
        "--samples",
        "1",
        "--frame-to-fit",
        "-o",
        "f.#.exr",
    ];
    folder.succeed(&job);
    let whole: Vec<Vec<u8>> = (1..=5).map(|frame| folder.read(&format!("f.{frame}.exr"))).collect();
    for frame in 1..=5 {
        let [x0, x1, y0, y1] = extent(&pixels(&folder.path(&format!("f.{frame}.exr"))).1, SIDE);
        assert!(
            x0 >= 1 && x1 <= SIDE - 2 && y0 >= 1 && y1 <= SIDE - 2,
            "{frame}: {x0} {x1} {y0} {y1}"
        );
    }
    folder.succeed(&[&job[..], &["--part", "2/3"]].concat());
    folder.succeed(&[&job[..], &["--range", "5"]].concat());
    assert!((1..=5).map(|frame| folder.read(&format!("f.{frame}.exr"))).eq(whole));
    assert_eq!(folder.succeed(&[&job[..], &["--list-stale"]].concat()), "");
    folder.write(
        "p.csv",
        "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n1,0,0,5,0,0,0\n",
    );
    folder.fail(2, &["s.toml", "-o", "f.#.exr", "--frames", "p.csv", "--frame-to-fit"]);
}

#[test]
fn a_framed_orbit_fits_at_all_angles() {
    let folder = Folder::new();
    folder.write("bar.obj", &CUBE.replace("v -1", "v -6").replace("v 1", "v 6"));
    let job = [
        "bar.obj",
        "-o",
        "f.#.exr",
        "--resolution",
        "24x24",
        "--samples",
        "1",
        "--background",
        "0",
    ];
    folder.succeed(&[&job[..], &["--orbit", "6", "--frame-to-fit"]].concat());
    for frame in 1..=6 {
        let [x0, x1, y0, y1] = extent(&pixels(&folder.path(&format!("f.{frame}.exr"))).1, SIDE);
        assert!(
            x0 >= 1 && x1 <= SIDE - 2 && y0 >= 1 && y1 <= SIDE - 2,
            "{frame}: {x0} {x1} {y0} {y1}"
        );
    }
}

#[test]
fn an_orbit_of_half_a_turn_has_the_frames_of_a_whole_one() {
    let folder = Folder::new();
    let bar = BALL.replace(
        "sphere = { center = [0, 0, 0], radius = 1 }",
        "cuboid = { min = [-2, -1, -1], max = [2, 0, 1] }",
    );
    let sun = "[[light]]\nsun = { direction = [1, -2, -3], irradiance = 2 }\n";
    folder.write("s.toml", &format!("{HEAD}{CAMERA}{bar}{sun}"));
    let fixed = ["s.toml", "--seed-mode", "fixed"];
    folder.succeed(&[&fixed[..], &["--turntable", "4", "-o", "whole.#.exr"]].concat());
    folder.succeed(&[&fixed[..], &["--orbit", "4:-180", "-o", "half.#.exr"]].concat());
    let of = |name: &str| pixels(&folder.path(name)).1;
    assert!(of("half.1.exr") == of("whole.1.exr"));
    assert!(of("half.3.exr") == of("whole.4.exr"));
    assert!(of("half.2.exr") != of("whole.2.exr"));
    for wrong in ["0", "4:x", "x"] {
        folder.fail(2, &["s.toml", "--orbit", wrong, "-o", "half.#.exr"]);
    }
}

#[test]
fn a_ground_shows_the_background_with_the_shadow_of_the_model() {
    let (plain, ground) = (
        cube(&["--background", "0.5"]),
        cube(&["--background", "0.5", "--ground"]),
    );
    let around: Vec<f32> = (plain.iter().zip(&ground))
        .filter(|(plain, _)| **plain == [0.5; 3])
        .map(|(_, ground)| ground[0])
        .collect();
    assert!(around.len() > SIDE * SIDE / 4 && around.iter().all(|shade| *shade < 0.6));
    assert!(ground[0] == [0.5; 3] && around.iter().any(|shade| *shade < 0.3));
    let surface = cube(&[
        "--background",
        "0.5",
        "--ground",
        "--set",
        "object.ground.shadow_catcher=false",
    ]);
    let row = (SIDE - 1) * SIDE..SIDE * SIDE;
    assert!(surface[row].iter().all(|[r, ..]| *r > 0.05 && *r < 0.4));
    let found = message(&format!("{HEAD}{CAMERA}{BALL}"), &["--ground"]);
    assert!(found.contains("--ground is that of a model by itself"), "{found}");
}

#[test]
fn all_sides_of_a_white_cube_differ_from_each_other_and_from_the_backdrop() {
    let found = cube(&["--resolution", "48x48", "--samples", "64"]);
    let at = |x: usize, y: usize| found[y * 48 + x][0];
    // The sides that face upwards, to the camera and to the right, and the corner of the picture.
    let shades = [at(24, 11), at(16, 28), at(37, 28), at(1, 1)];
    for (i, a) in shades.iter().enumerate() {
        for b in &shades[i + 1..] {
            assert!((a / b).max(b / a) > 1.25, "{shades:?}");
        }
        assert!(*a < 1.0, "{shades:?}");
    }
}

#[test]
fn the_ground_is_beside_a_model_of_any_name_and_of_any_material() {
    let folder = Folder::new();
    folder.write("cube.obj", CUBE);
    folder.write("ground.obj", CUBE);
    let shot = |model: &str, flags: &[&str]| {
        let small = [
            model,
            "-o",
            "p.exr",
            "--resolution",
            "24x24",
            "--samples",
            "8",
            "--ground",
        ];
        folder.succeed(&[&small, flags].concat());
        pixels(&folder.path("p.exr")).1
    };
    let plain = shot("cube.obj", &[]);
    assert!(shot("ground.obj", &[]) == plain);
    let surface = ["--set", "object.ground.shadow_catcher=false"];
    let bright = |material: &str| {
        let found = shot("cube.obj", &[&surface[..], &["--set", material]].concat());
        found[SIDE * SIDE - 1][0]
    };
    let half = bright("material.ground.matte.albedo=0.4");
    let ratio = half / bright("material.ground.matte.albedo=0.2");
    assert!((ratio - 2.0).abs() < 0.05, "{ratio}");
    let second = ["--set", "object.ground 2.shadow_catcher=false"];
    let found = shot("ground.obj", &second);
    assert!(found == shot("cube.obj", &surface));
    // A glossy floor mirrors the cube.
    let glossy = shot(
        "cube.obj",
        &["--set", "material.ground={metal = {color = 0.9, roughness = 0.1}}"],
    );
    assert!(glossy != plain);
}

#[test]
fn a_number_of_the_supplied_sky_is_changed_by_itself_and_a_texture_without_use_is_told() {
    let bright = |flags: &[&str]| -> f32 { cube(flags).iter().map(|pixel| pixel[0]).sum() };
    assert!(bright(&["--set", "background.gradient.up=5"]) > 1.5 * bright(&[]));
    assert!(cube(&["--set", "background.gradient.up=0.55"]) == cube(&[]));
    let folder = Folder::new();
    folder.write("cube.obj", CUBE);
    let job = ["cube.obj", "-o", "p.png", "--resolution", "8x8", "--samples", "1"];
    let told = folder.run(&[&job[..], &["--set", "texture.a.noise.scale=3"]].concat());
    let told = crate::common::stderr(&told);
    let expected = "--set texture.a.noise.scale has no effect: nothing is made of the texture `a`";
    assert!(told.contains(expected), "{told}");
}
