use std::path::PathBuf;

use super::*;
use crate::{
    assets::camera_path::{CameraPathOptions, ValueColumns},
    describe::{FrameTime, MovingDesc, Source, ValueSource, parse},
};

const SCENE: &str = "[background]\nenvironment = { file = 'sky.exr' }\n\
                     [camera.perspective]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n\
                     [texture.t]\nchecker = { a = 0, b = 1 }\n\
                     [material.m]\nmatte = { albedo = 0.5 }\n\
                     [[object]]\nname = 'a.b'\nmaterial = 'm'\nshape.sphere = { radius = 1 }\n\
                     [[light]]\nname = 'key'\npoint = { position = [0, 1, 2], intensity = 3 }\n";

fn scene() -> SceneDesc {
    parse(Source::new(PathBuf::from("s.toml"), SCENE)).unwrap_or_else(|e| panic!("{e}"))
}

/// The values of a table, with 10 frames per second.
fn read(table: &str) -> Result<Values, String> {
    read_for(&scene(), table)
}

fn read_for(scene: &SceneDesc, table: &str) -> Result<Values, String> {
    let options = CameraPathOptions {
        fps: Some(10.0),
        ..CameraPathOptions::default()
    };
    let path = PathBuf::from("v.csv");
    let table = ValueTable::read(table.as_bytes(), ValueColumns::All, &options);
    let table = table.map_err(|problems| problems.messages())?;
    Values::new(scene, &[ValueSource::Table(ValueFile { path, table })]).map_err(|e| e.to_string())
}

fn at(table: &str, frames: &[f64]) -> Vec<String> {
    let values = read(table).unwrap_or_else(|e| panic!("{e}"));
    frames.iter().map(|frame| values.at(*frame).join(" ")).collect()
}

#[test]
fn numbers_move_and_are_held_beyond_the_rows() {
    let table = "frame,background.environment.rotate.y,interp\n0,0,linear\n8,360,linear\n";
    assert_eq!(
        at(table, &[-5.0, 0.0, 1.0, 4.5, 8.0, 99.0]),
        ["0.0", "0.0", "45.0", "202.5", "360.0", "360.0"]
    );
    let smooth = at("frame,light.key.point.intensity\n0,0\n1,1\n2,0\n", &[0.5, 1.0, 1.5]);
    assert_eq!(smooth[1], "1.0");
    assert_eq!(smooth[0], smooth[2]);
}

#[test]
fn the_interpolation_of_a_column_replaces_that_of_the_rows() {
    let table = "# interp: light.key.point.intensity = hold\nframe,light.key.point.intensity,material.m.matte.albedo,interp\n\
                 0,1,0,linear\n2,3,1,linear\n";
    assert_eq!(at(table, &[1.0, 2.0]), ["1.0 0.5", "3.0 1.0"]);
}

#[test]
fn words_truths_and_mixed_cells_hold() {
    let table = "frame,object.a.b.visible,object.a.b.material,background.visible,material.m.matte.albedo\n\
                 0,1,m,TRUE,0.5\n4,0,,false,texture.t\n";
    let held = ["true \"m\" true 0.5", "false \"m\" false \"texture.t\""];
    assert_eq!(at(table, &[3.9, 4.0]), held);
}

#[test]
fn a_cell_means_the_same_whatever_the_others_of_its_column_are() {
    let table = |cells: &str| format!("frame,object.a.b.visible\n{cells}");
    assert_eq!(
        at(&table("0,1\n1,true\n2,0\n"), &[0.0, 1.0, 2.0]),
        ["true", "true", "false"]
    );
    let mixed = read(&table("0,1\n1,true\n2,0.5\n")).unwrap_err();
    assert!(mixed.starts_with("v.csv:4: object.a.b.visible: expected"), "{mixed}");
    let numbers = read(&table("0,1\n1,0.5\n2,0\n")).unwrap_err();
    assert!(
        numbers.starts_with("v.csv:3: object.a.b.visible: expected"),
        "{numbers}"
    );
}

#[test]
fn one_number_of_a_list_by_two_letters_is_refused_with_both() {
    let twice = read("frame,material.m.matte.albedo.r,material.m.matte.albedo.x\n0,1,1\n").unwrap_err();
    assert!(
        twice.contains("`material.m.matte.albedo.r` is the same value"),
        "{twice}"
    );
}

#[test]
fn times_are_frames_by_the_frame_rate() {
    let values = read("time,light.key.point.intensity\n0.1,1\n0.32,2\n").expect("values");
    assert_eq!(values.frames(), Some(1..=3));
    assert_eq!(values.at(3.2), ["2.0"]);
}

#[test]
fn the_components_of_a_list_are_set_together_or_written_in_the_file() {
    let whole = "frame,object.a.b.shape.sphere.center.x,object.a.b.shape.sphere.center.y,object.a.b.shape.sphere.center.z\n1,1,2,3\n";
    assert_eq!(at(whole, &[1.0]), ["1.0 2.0 3.0"]);
    let message = read("frame,object.a.b.shape.sphere.center.x\n1,1\n").expect_err("two components are missing");
    assert!(
        message.contains("v.csv:2: object.a.b.shape.sphere.center.x: the file has no `center`"),
        "{message}"
    );
    assert!(read("frame,object.a.b.transform.scale.x\n1,2\n").is_ok());
    let message = read("frame,material.m.matte.albedo.r,material.m.matte.albedo.w\n1,1,1\n").expect_err("no component");
    assert!(message.contains("albedo.w"), "{message}");
}

#[test]
fn a_wrong_value_names_the_row_that_has_it() {
    let message = read("frame,light.key.point.intensity\n1,3\n2,4\n5,-1\n").expect_err("a negative intensity");
    assert!(message.contains("v.csv:4: light.key.point.intensity: "), "{message}");
    let message = read("frame,background.environment.intensty\n1,3\n").expect_err("an unknown key");
    assert!(message.contains("(did you mean `intensity`?)"), "{message}");
}

#[test]
fn a_name_may_look_like_a_number() {
    assert_eq!(
        at("frame,object.a.b.material\n0,1\n4,12\n", &[0.0, 5.0]),
        ["\"1\"", "\"12\""]
    );
}

#[test]
fn a_value_that_is_set_for_the_job_takes_the_place_of_its_columns() {
    let overrides = Overrides::default().with("light.key.point.intensity", 7.0);
    let scene = scene().with(&overrides).unwrap_or_else(|e| panic!("{e}"));
    let table = "frame,light.key.point.intensity,light.key.point.position.x\n0,1,2\n4,3,4\n";
    let values = read_for(&scene, table).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(values.at(4.0), ["4.0"]);
}

#[test]
fn one_value_by_two_names_is_refused_with_both() {
    let message =
        read("frame,light.key.point.intensity,light.0.point.intensity\n1,1,1\n").expect_err("it is one value");
    let expected = "v.csv:1: light.0.point.intensity: `light.key.point.intensity` is the same value";
    assert!(message.contains(expected), "{message}");
}

const QUATERNION: &str = "frame,object.a.b.transform.rotate.qx,object.a.b.transform.rotate.qy,\
                          object.a.b.transform.rotate.qz,object.a.b.transform.rotate.qw";

#[test]
fn a_quaternion_turns_on_the_shortest_arc_at_an_even_rate() {
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    // The second rotation is that of the opposite sign, by 90 degrees about y.
    let table = format!("{QUATERNION}\n0,0,0,0,1\n4,0,{},0,{}\n", -quarter, -quarter);
    let values = read(&table).unwrap_or_else(|e| panic!("{e}"));
    for frame in [-1.0, 0.0, 1.0, 2.5, 4.0, 9.0] {
        let found: Vec<f64> = values.at(frame).iter().map(|v| v.parse().expect("a number")).collect();
        let half = 22.5_f64.to_radians() * frame.clamp(0.0, 4.0) / 2.0;
        let expected = [0.0, libm::sin(half), 0.0, libm::cos(half)];
        let dot: f64 = found.iter().zip(expected).map(|(a, b)| a * b).sum();
        assert!((dot.abs() - 1.0).abs() < 1e-12, "{frame}: {found:?}");
    }
}

#[test]
fn a_quaternion_is_whole_and_has_a_length() {
    let fault = |rows: &str| read(&format!("{QUATERNION}\n{rows}")).expect_err("it is wrong");
    let message = fault("0,0,0,0,1\n1,0,0,,1\n");
    let expected = "v.csv:3: object.a.b.transform.rotate.qz: a row gives all of a quaternion or nothing";
    assert!(message.contains(expected), "{message}");
    let message = fault("0,0,0,0,0\n");
    assert!(
        message.contains("v.csv:2: ") && message.contains("a length above 0"),
        "{message}"
    );
    let message = read("frame,object.a.b.transform.rotate.qx\n0,1\n").expect_err("it is not whole");
    assert!(message.contains("needs the columns qx, qy, qz, qw"), "{message}");
    assert!(read(&format!("{QUATERNION}\n0,,,,\n3,0,0,0,2\n")).is_ok());
}

#[test]
fn the_shutter_holds_for_the_whole_job() {
    for name in ["camera.shutter", "camera.shutter.0"] {
        let message = read(&format!("frame,{name}\n0,0.5\n")).expect_err("it is refused");
        assert!(message.contains("holds for the whole job"), "{message}");
    }
}

#[test]
fn columns_of_one_value_and_of_its_parts_are_refused_with_both_names() {
    for (columns, second, first) in [
        (
            "light.key.point.intensity,light.key.point.intensity.r",
            "light.key.point.intensity.r",
            "light.key.point.intensity",
        ),
        (
            "material.m.matte.albedo.b,background.color,material.m.matte.albedo",
            "material.m.matte.albedo.b",
            "material.m.matte.albedo",
        ),
    ] {
        let ones = columns.split(',').map(|_| ",1").collect::<String>();
        let message = read(&format!("frame,{columns}\n1{ones}\n")).expect_err("two columns of a value");
        let expected = format!("v.csv:1: {second}: the column `{first}` sets the same value");
        assert!(message.contains(&expected), "{message}");
    }
    assert!(read("frame,light.key.point.intensity.r,light.key.point.position.x\n1,1,1\n").is_ok());
}

#[test]
fn of_names_with_points_that_name_of_which_the_next_step_is_a_key_counts() {
    let lights = "[[light]]\nname = 'key.point'\nspot = { position = [0, 1, 2], intensity = 3, cone_angle = 40, target = [0, 0, 0] }\n";
    let scene = parse(Source::new(PathBuf::from("s.toml"), format!("{SCENE}{lights}")));
    let scene = scene.unwrap_or_else(|e| panic!("{e}"));
    let of = |name: &str| {
        let values = read_for(&scene, &format!("frame,{name}\n1,2\n")).unwrap_or_else(|e| panic!("{e}"));
        values.columns[0].entity
    };
    assert_eq!(of("light.key.point.intensity"), Entity::Light(0));
    assert_eq!(of("light.key.point.spot.intensity"), Entity::Light(1));
    let message = read_for(&scene, "frame,light.key.point.sport.intensity\n1,2\n").expect_err("an unknown key");
    assert!(message.contains("sport"), "{message}");
}

#[test]
fn a_camera_whose_eye_is_at_its_target_names_the_cell_that_moves_it_there() {
    let scene = scene();
    let table = "frame,camera.perspective.fov,camera.perspective.eye.z\n1,30,5\n2,40,0\n3,50,-5\n";
    let values = read_for(&scene, table).unwrap_or_else(|e| panic!("{e}"));
    let moving = MovingDesc::new(&scene, &values);
    assert!(moving.camera(1.0).is_ok());
    let message = moving.camera(2.0).map(drop).expect_err("no direction").to_string();
    assert!(
        message.starts_with("v.csv:3: camera.perspective.eye.z: the target is at the eye"),
        "{message}"
    );
}

#[test]
fn a_scale_of_zero_is_one_of_a_nanometre_a_metre() {
    let (scene, table) = (
        scene(),
        "frame,object.a.b.transform.scale.y,interp\n1,1,linear\n3,-1,linear\n",
    );
    let values = read_for(&scene, table).unwrap_or_else(|e| panic!("{e}"));
    let (moving, mut desc) = (MovingDesc::new(&scene, &values), scene.clone());
    let object = BTreeSet::from([Entity::Object(0)]);
    let set = moving.set(&mut desc, (FrameTime::from(2.0), &values.at(2.0)), &object);
    assert!(set.is_ok());
    let transform = desc.objects[0].transform.as_ref().expect("a transform").get_ref();
    let map = transform.compile(0..0).expect("it has an inverse");
    assert_eq!(
        map.matrix3.to_cols_array(),
        [1.0, 0.0, 0.0, 0.0, 1e-9, 0.0, 0.0, 0.0, 1.0]
    );
}
