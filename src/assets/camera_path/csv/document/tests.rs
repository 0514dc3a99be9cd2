use glam::DVec3;

use super::*;
use crate::camera::{
    LensOverrides, RotationOrder,
    lens::{Aperture, FieldOfView},
    path::{Interp, Rotation},
    perspective::PerspectiveLens,
};

const SPACED: &str = "\
# The moves.
frame, eye_x, eye_y, eye_z, target_x, target_y, target_z, name

1,         0,     0,    15,        0,        0,      -85, home
# Then to the right.
11,       20,     0,    15,       20,        0,      -85, right
21,        0,     0,    15,        0,        0,      -85,\"left, again\"
";

fn document(text: &str) -> PathDocument {
    PathDocument::read(text.as_bytes(), &CameraPathOptions::default()).expect("a path")
}

fn text(document: &PathDocument) -> String {
    String::from_utf8(document.to_bytes()).expect("UTF-8")
}

fn key(frame: f64, eye: [f64; 3]) -> PathKey {
    PathKey {
        frame,
        eye: DVec3::from_array(eye),
        orientation: Orientation::Target {
            target: DVec3::new(0.0, 0.0, -85.0),
            up: Some(DVec3::Y),
            roll: Some(0.0),
        },
        lens: LensOverrides::default(),
        pinhole: None,
        shutter: None,
        readout: None,
        stereo: [None; 2],
        interp: Interp::default(),
        name: None,
    }
}

fn frames(document: &PathDocument) -> Vec<f64> {
    document.keys().map(|key| key.frame).collect()
}

#[test]
fn a_file_that_is_not_edited_stays_as_it_was_byte_for_byte() {
    let texts = [
        SPACED.to_owned(),
        SPACED.replace('\n', "\r\n"),
        format!("\u{feff}sep=;\n{}", SPACED.replace(", again", "").replace(',', ";")),
    ];
    for text in texts {
        assert_eq!(document(&text).to_bytes(), text.as_bytes());
    }
}

#[test]
fn a_new_key_is_a_row_in_its_place_and_everything_else_stays() {
    let mut document = document(SPACED);
    document
        .set(&key(15.0, [1.5, -2.0, 0.25]), &Lens::default())
        .expect("set");
    let row = "15,      1.5,    -2,  0.25,        0,        0,      -85,      \n";
    let end = SPACED.find("21,").expect("the last row");
    assert_eq!(text(&document), format!("{}{row}{}", &SPACED[..end], &SPACED[end..]));
    assert_eq!(frames(&document), [1.0, 11.0, 15.0, 21.0]);

    document.set(&key(-3.0, [0.0; 3]), &Lens::default()).expect("set");
    assert_eq!(frames(&document)[0], -3.0);
    assert!(text(&document).starts_with("# The moves.\nframe, eye_x"));
}

#[test]
fn a_key_is_replaced_in_its_row_which_keeps_its_name() {
    let mut document = document(SPACED);
    document
        .set(&key(21.0, [7.0, 0.0, 1e-7]), &Lens::default())
        .expect("set");
    let row = "21,        7,     0, 0.0000001,        0,        0,      -85,\"left, again\"\n";
    assert!(text(&document).ends_with(row), "{}", text(&document));
    assert_eq!(
        document.keys().last().and_then(|k| k.name.as_deref()),
        Some("left, again")
    );
}

#[test]
fn a_header_behind_a_number_sign_and_an_index_are_kept() {
    let scene = Lens::Perspective(PerspectiveLens::vertical(40.0));
    let mut document = document("# ,frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n0,1,0,0,5,0,0,0\n,,,,,,,\n");
    let mut wide = key(5.0, [0.0, 0.0, 7.0]);
    wide.lens.view = Some(FieldOfView::Vertical(60.0));
    document.set(&wide, &scene).expect("set");
    assert_eq!(
        text(&document),
        "# ,frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov\n\
         0,1,0,0,5,0,0,0,40\n,5,0,0,7,0,0,-85,60\n,,,,,,,\n"
    );
}

#[test]
fn a_key_moves_over_others_and_not_onto_one() {
    let mut document = document(SPACED);
    document.move_key(1.0, 31.0).expect("moved");
    assert_eq!(frames(&document), [11.0, 21.0, 31.0]);
    document.move_key(31.0, -1.0).expect("moved");
    assert_eq!(frames(&document), [-1.0, 11.0, 21.0]);
    document.move_key(11.0, 12.0).expect("moved");
    assert!(text(&document).contains("# Then to the right.\n12,"));
    assert!(matches!(document.move_key(12.0, 21.0), Err(EditError::Taken(_))));
    assert!(matches!(document.move_key(11.0, 13.0), Err(EditError::NoKey(_))));
    assert_eq!(frames(&document), [-1.0, 12.0, 21.0]);
}

#[test]
fn the_last_key_may_go_and_a_new_file_begins_without_one() {
    let mut document = PathDocument::new(&CameraPathOptions::default());
    assert!(document.path().is_none());
    document.set(&key(5.0, [1.0, 2.0, 3.0]), &Lens::default()).expect("set");
    assert_eq!(text(&document), format!("{HEADER}5,1,2,3,0,0,-85\n"));
    document.remove(5.0).expect("removed");
    assert!(document.path().is_none() && document.remove(5.0).is_err());
    assert_eq!(text(&document), HEADER);
}

#[test]
fn a_parameter_of_one_key_leaves_the_others_as_the_scene_has_them() {
    let scene = Lens::Perspective(PerspectiveLens::vertical(40.0));
    let mut document = document("frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n1,0,0,5,0,0,0\n9,0,0,9,0,0,0\n");
    let mut wide = key(5.0, [0.0, 0.0, 7.0]);
    wide.lens.view = Some(FieldOfView::Vertical(60.0));
    wide.lens.focus_distance = Some(3.0);
    document.set(&wide, &scene).expect("set");
    let expected = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov,focus_distance\n\
                    1,0,0,5,0,0,0,40,5\n5,0,0,7,0,0,-85,60,3\n9,0,0,9,0,0,0,40,9\n";
    assert_eq!(text(&document), expected);
    // A file says it in one way.
    wide.lens.view = Some(FieldOfView::FocalLength(35.0));
    assert!(matches!(
        document.set(&wide, &scene),
        Err(EditError::OtherWay("the view"))
    ));
    assert_eq!(text(&document), expected);
    wide.lens.view = None;
    wide.lens.aperture = Some(Aperture::FStop(2.8));
    document.set(&wide, &scene).expect("set");
    assert!(text(&document).contains("\n5,0,0,7,0,0,-85,60,3,2.8\n9,0,0,9,0,0,0,40,9,\n"));
}

#[test]
fn another_up_and_a_roll_become_columns_in_which_the_other_keys_are_level() {
    let mut document = document("frame,eye_x,eye_y,eye_z,target_x,target_y,target_z\n1,0,0,5,0,0,0\n");
    let mut tilted = key(2.0, [0.0, 0.0, 7.0]);
    tilted.orientation = Orientation::Target {
        target: DVec3::ZERO,
        up: Some(DVec3::Z),
        roll: Some(-12.5),
    };
    document.set(&tilted, &Lens::default()).expect("set");
    let expected = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z,up_x,up_y,up_z,roll\n\
                    1,0,0,5,0,0,0,0,1,0,0\n2,0,0,7,0,0,0,0,0,1,-12.5\n";
    assert_eq!(text(&document), expected);
}

#[test]
fn a_file_of_rotations_gets_the_rotation_of_the_target() {
    let header = "frame,eye_x,eye_y,eye_z";
    let cases = [
        (format!("{header},qx,qy,qz,qw\n1,0,0,5,0,0,0,1\n"), None),
        (
            format!("# rotation_order: ZXY\n{header},rot_x,rot_y,rot_z\n1,0,0,5,0,350,0\n"),
            Some(RotationOrder::Zxy),
        ),
    ];
    for (file, order) in cases {
        let mut document = document(&file);
        let mut key = key(3.0, [1.0, 2.0, 3.0]);
        let target = DVec3::new(-4.0, 1.0, 2.0);
        key.orientation = Orientation::Target {
            target,
            up: None,
            roll: Some(20.0),
        };
        document.set(&key, &Lens::default()).expect("set");
        let state = document.path().expect("keys").at(3.0).expect("a key");
        assert!(
            (state.pose.forward() - (target - key.eye).normalize()).length() < 1e-12,
            "{file}"
        );
        let at = LookAt {
            target,
            up: DVec3::Y,
            roll: 20.0,
        };
        let wanted = Pose::look_at(key.eye, &at).expect("a pose");
        assert!((state.pose.up() - wanted.up()).length() < 1e-12, "{file}");
        if order.is_some() {
            // By whole turns as near as can be to the key before: less than half a turn away.
            let Some(Orientation::Rotation(Rotation::Euler { degrees, .. })) =
                document.keys().last().map(|k| k.orientation)
            else {
                panic!("angles");
            };
            assert!((degrees.y - 350.0).abs() <= 180.0, "{degrees}");
        }
    }
}

#[test]
fn a_key_within_a_full_turn_keeps_the_turn() {
    let order = "# rotation_order: ZXY\n";
    let turn = format!("{order}frame,eye_x,eye_y,eye_z,rot_x,rot_y,rot_z\n0,0,0,5,0,0,0\n10,0,0,5,0,-720,0\n");
    let mut document = document(&turn);
    let mut key = key(5.0, [0.0, 0.0, 5.0]);
    // A quarter of a turn to the right, and a whole one.
    key.orientation = Orientation::Target {
        target: DVec3::new(1.0, 0.0, 5.0),
        up: None,
        roll: None,
    };
    document.set(&key, &Lens::default()).expect("set");
    let Some(Orientation::Rotation(Rotation::Euler { degrees, .. })) = document.keys().nth(1).map(|k| k.orientation)
    else {
        panic!("angles");
    };
    assert!((degrees - DVec3::new(0.0, -450.0, 0.0)).length() < 1e-9, "{degrees}");
}

/// Keys with times, at 24 frames a second.
fn timed(keys: &str) -> PathDocument {
    let options = CameraPathOptions {
        fps: Some(24.0),
        ..CameraPathOptions::default()
    };
    let file = format!("time,eye_x,eye_y,eye_z,target_x,target_y,target_z\n{keys}");
    PathDocument::read(file.as_bytes(), &options).expect("a path")
}

#[test]
fn times_are_written_where_the_file_has_times() {
    let mut document = timed("0,0,0,5,0,0,0\n");
    document.set(&key(7.0, [1.0; 3]), &Lens::default()).expect("set");
    assert_eq!(frames(&document), [0.0, 7.0]);
    assert!(text(&document).ends_with("0.291667,1,1,1,0,0,-85\n"));
}

#[test]
fn a_key_that_is_replaced_keeps_the_text_of_its_time() {
    let mut document = timed("0.0417,0,0,5,0,0,0\n0.12345678,0,0,6,0,0,0\n");
    for (frame, x) in [(1.0, 7.0), (0.12345678 * 24.0, 8.0)] {
        document.set(&key(frame, [x, 0.0, 0.0]), &Lens::default()).expect("set");
    }
    assert!(text(&document).ends_with("\n0.0417,7,0,0,0,0,-85\n0.12345678,8,0,0,0,0,-85\n"));
}

#[test]
fn an_edit_that_leaves_no_path_changes_nothing() {
    let mut document = document(SPACED);
    let at_target = key(30.0, [0.0, 0.0, -85.0]);
    assert!(document.set(&at_target, &Lens::default()).is_err());
    let mut wide = key(30.0, [0.0; 3]);
    wide.lens.view = Some(FieldOfView::Vertical(200.0));
    assert!(matches!(
        document.set(&wide, &Lens::default()),
        Err(EditError::Invalid(_))
    ));
    assert_eq!(text(&document), SPACED);
}
