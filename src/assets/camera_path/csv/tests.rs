use std::{fmt::Write as _, path::Path};

use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::{
    assets::camera_path::CameraPathOptions,
    camera::{
        LensOverrides, LookAt, Pose, RotationOrder, Shutter,
        lens::{Aperture, FieldOfView, Sensor},
    },
};

const HEADER: &str = "frame,eye_x,eye_y,eye_z,target_x,target_y,target_z";

fn parse_with(text: &str, options: &CameraPathOptions) -> Result<CameraPath, String> {
    read_bytes(text.as_bytes(), options).map_err(|problems| problems.display(Path::new("camera_path.csv")).to_string())
}

fn parse(text: &str) -> Result<CameraPath, String> {
    parse_with(text, &CameraPathOptions::default())
}

/// Returns the error for the rows below a header with frame, eye and target, and the columns in `more`.
fn complaint(more: &str, rows: &str) -> String {
    parse(&format!("{HEADER}{more}\n{rows}\n")).expect_err("a complaint")
}

fn looking(eye: DVec3, target: DVec3) -> Pose {
    let at = LookAt {
        target,
        up: DVec3::Y,
        roll: 0.0,
    };
    Pose::look_at(eye, &at).expect("a pose")
}

fn pose(path: &CameraPath, frame: f64) -> Pose {
    path.at(frame).expect("inside").pose
}

#[test]
fn a_row_at_every_frame_is_used_as_it_is() {
    let path = parse(&format!("{HEADER}\n1,0,1,15,0,1,0\n2,0.1,1,15,0,1,0\n")).expect("a path");
    assert_eq!(path.frames(), 1..=2);
    let target = DVec3::new(0.0, 1.0, 0.0);
    assert_eq!(pose(&path, 1.0), looking(DVec3::new(0.0, 1.0, 15.0), target));
    assert_eq!(pose(&path, 2.0), looking(DVec3::new(0.1, 1.0, 15.0), target));
}

#[test]
fn delimiters_marks_line_ends_comments_and_spaces_do_not_matter() {
    let plain = parse("frame,tx,ty,tz,rx,ry,rz\n1,1,2,3,0,90,0\n4,1,2,4,0,80,0\n");
    assert!(plain.is_err());
    let order = "# rotation_order: ZXY\n";
    let want = parse(&format!(
        "{order}frame,tx,ty,tz,rx,ry,rz\n1,1,2,3,0,90,0\n4,1,2,4,0,80,0\n"
    ));
    assert!(want.is_ok());
    for text in [
        "\u{feff}# Rotation Order = zxy\r\nframe;tx;ty;tz;rx;ry;rz\r\n1;1;2;3;0;90;0\r\n\r\n4;1;2;4;0;80;0\r\n",
        "frame\ttx\tty\ttz\trx\try\trz\n# rotation_order: ZXY\n1\t1\t2\t3\t0\t90\t0\n  # done\n4\t1\t2\t4\t0\t80\t0",
        "#rotation_order:ZXY\rRZ ,\"Frame\",rotate_x,rotation y,Eye-X,pos_y,location.z,\r0,1, 0,90,1,2,3,\r0,4,0,80,1,2,4,\r",
    ] {
        assert_eq!(parse(text), want);
    }
}

#[test]
fn everything_that_a_row_can_say_is_heard() {
    let path = parse(&format!(
        "{HEADER},up_x,up_y,up_z,roll,focal_length,sensor_height,fstop,focus_distance,shutter_open,shutter_close,\
         shift_x,shift_y,interp,name,readout\n\
         1,0,0,5,0,0,0,0,1,0,90,50,24,2.8,5,-0.25,0.25,0.1,0.2,hold,\"wide, slow\",0.5\n\
         10,0,0,9,0,0,0,,,,,,,,,,,,,Linear,,\n"
    ))
    .expect("a path");
    let state = path.at(3.5).expect("inside");
    assert_eq!(
        state.lens,
        LensOverrides {
            view: Some(FieldOfView::FocalLength(50.0)),
            sensor: Some(Sensor::Height(24.0)),
            aperture: Some(Aperture::FStop(2.8)),
            focus_distance: Some(5.0),
            shift_x: Some(0.1),
            shift_y: Some(0.2),
            ..LensOverrides::default()
        }
    );
    let shutter = Shutter {
        open: -0.25,
        close: 0.25,
    };
    assert_eq!(state.shutter, Some(shutter));
    assert_eq!(state.readout, Some(0.5));
    assert_eq!(state.name.as_deref(), Some("wide, slow"));
    assert_eq!(state.pose.eye(), DVec3::Z * 5.0);
    assert_eq!(state.pose.up(), DVec3::NEG_X);
    assert_eq!(state.target_distance, Some(5.0));
}

#[test]
fn the_order_of_angles_must_be_said_and_the_option_goes_first() {
    let text = "frame,eye_x,eye_y,eye_z,rot_x,rot_y,rot_z\n1,0,0,0,10,20,30\n";
    let with = |order| CameraPathOptions {
        rotation_order: Some(order),
        ..CameraPathOptions::default()
    };
    assert_eq!(
        parse(text).unwrap_err(),
        "camera_path.csv:1: rot_x rot_y rot_z need a rotation order: write a line such as '# rotation_order: ZXY', \
         or give it with --rotation-order"
    );
    let turned = |order| Pose::from_euler(DVec3::ZERO, DVec3::new(10.0, 20.0, 30.0), order).expect("a pose");
    let said = format!("# rotation_order: YXZ\n{text}");
    assert_eq!(pose(&parse(&said).expect("a path"), 1.0), turned(RotationOrder::Yxz));
    let chosen = parse_with(&said, &with(RotationOrder::Zyx)).expect("a path");
    assert_eq!(pose(&chosen, 1.0), turned(RotationOrder::Zyx));
    assert_eq!(
        parse(&format!("# rotation_order: YXX\n{text}")).unwrap_err(),
        "camera_path.csv:1: unknown rotation order `YXX` (did you mean `YXZ`?)"
    );
    assert_eq!(
        parse(&format!("{said}# rotation_order: XYZ\n")).unwrap_err(),
        "camera_path.csv:4: rotation order XYZ after YXZ on line 1"
    );
}

#[test]
fn times_become_frames_and_what_rounding_took_is_given_back() {
    let text = "t,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n0.042,1,0,0,0,0,0,1\n0.0625,2,0,0,0,0,0,1\n";
    assert_eq!(
        parse(text).unwrap_err(),
        "camera_path.csv:1: there is a time and no frame: say how many frames a second has, with --fps"
    );
    let fps = |fps| CameraPathOptions {
        fps: Some(fps),
        ..CameraPathOptions::default()
    };
    let path = parse_with(text, &fps(24.0)).expect("a path");
    assert_eq!((path.frames(), path.last()), (0..=1, 1.5));
    assert_eq!(pose(&path, 1.0).eye(), DVec3::X);
    assert_eq!(
        parse_with(text, &fps(0.0)).unwrap_err(),
        "camera_path.csv:1: the frame rate 0 is not a number above 0"
    );
    let both = parse("frame,time,x,y,z,qx,qy,qz,qw\n7,0.5,0,0,0,0,0,0,1\n").expect("a path");
    assert_eq!(both.frames(), 7..=7);
}

#[test]
fn headers_are_told_what_they_lack() {
    let cases = [
        ("", "camera_path.csv: the file is empty: expected a header and rows"),
        (
            "# nothing\n\n",
            "camera_path.csv: the file is empty: expected a header and rows",
        ),
        (
            "1,0,0,5,0,0,0\n",
            "camera_path.csv:1: expected a header with the names of columns, found numbers",
        ),
        (
            "\nframe,eye_x,eye_y,qx,qy,qz,qw\n",
            "camera_path.csv:2: missing column: eye_z",
        ),
        (
            "eye_x,target_x,banana\n1,2,3\n",
            "camera_path.csv:1: unknown column `banana`\n\
             camera_path.csv:1: missing column: frame, or time and a frame rate\n\
             camera_path.csv:1: missing columns: eye_y eye_z\n\
             camera_path.csv:1: missing columns: target_y target_z",
        ),
        (
            "frame,eye_x,eye_y,eye_zz,target_x,target_y,target_z\n",
            "camera_path.csv:1: unknown column `eye_zz` (did you mean `eye_z`?)",
        ),
        (
            "frame,x,y,z\n",
            "camera_path.csv:1: nothing says which way the camera looks: \
             expected target_x target_y target_z, qx qy qz qw, or rot_x rot_y rot_z",
        ),
        (
            "frame,x,y,z,tx,qx,qy,qz,qw\n",
            "camera_path.csv:1: eye_x is given twice: by 'x' and by 'tx'",
        ),
        (
            "frame,x,y,z,look_at_x,look_at_y,look_at_z,qx,qy,qz,qw\n",
            "camera_path.csv:1: 'look_at_x' and 'qx' say in two ways which way the camera looks: keep one",
        ),
        (
            "frame,x,y,z,qx,qy,qz,qw,roll\n",
            "camera_path.csv:1: 'roll' needs target_x target_y target_z: a rotation says it all",
        ),
        (
            "frame,x,y,z,qx,qy,qz,qw,vfov,focal\n",
            "camera_path.csv:1: 'vfov' and 'focal' say the same thing in two ways: keep one",
        ),
        (
            "frame,x,y,z,qx,qy,qz,qw\n# 1,0,0,0,0,0,0,1\n",
            "camera_path.csv: there are no rows below the header",
        ),
    ];
    for (text, message) in cases {
        assert_eq!(parse(text).unwrap_err(), message, "{text}");
    }
}

#[test]
fn cells_are_told_what_is_wrong_with_them() {
    let cases = [
        ("", "1,abc,0,5,0,0,0", "2: eye_x: 'abc' is not a number"),
        ("", "1,NaN,0,5,0,0,0", "2: eye_x: 'NaN' is not finite"),
        ("", "1,0,-inf,5,0,0,0", "2: eye_y: '-inf' is not finite"),
        ("", "1,0,1e39,5,0,0,0", "2: eye_y: '1e39' is too large"),
        (
            "",
            "1,0,\"1,5\",5,0,0,0",
            "2: eye_y: '1,5' is not a number: write 1.5, with a point",
        ),
        ("", "1,0,,5,0,0,0", "2: eye_y: the cell is empty"),
        ("", "1,0,0,5,0,0", "2: the row has 6 cells, the header 7"),
        ("", "1,0,0,5,0,0,0,9", "2: cell 8 ('9') has no name in the header"),
        ("", "1.5,0,0,5,0,0,0", "2: frame: 1.5 is not a whole number"),
        (
            "",
            "4e9,0,0,5,0,0,0",
            "2: frame: frame 4000000000 is out of range: frames lie between -1000000000 and 1000000000",
        ),
        ("", "1,0,0,5,0,0,5", "2: target_x: the target is at the eye"),
        (
            "",
            "1,\"0,0,5,0,0,0",
            "2: a quoted cell does not end on its line: is a quote missing?",
        ),
        (",up_x,up_y,up_z", "1,0,0,5,0,0,0,0,1,", "2: up_z: the cell is empty"),
        (
            ",fov",
            "1,0,0,5,0,0,0,180",
            "2: fov: 180 is not above 0 and below 180 degrees",
        ),
        (
            ",hfov",
            "1,0,0,5,0,0,0,0",
            "2: hfov: 0 is not above 0 and below 180 degrees",
        ),
        (",lens", "1,0,0,5,0,0,0,-50", "2: lens: -50 is not above 0"),
        (",sensor_width", "1,0,0,5,0,0,0,0", "2: sensor_width: 0 is not above 0"),
        (",fstop", "1,0,0,5,0,0,0,0", "2: fstop: 0 is not above 0"),
        (
            ",aperture_radius",
            "1,0,0,5,0,0,0,-1",
            "2: aperture_radius: -1 is not at least 0",
        ),
        (",focus", "1,0,0,5,0,0,0,0", "2: focus: 0 is not above 0"),
        (
            ",shutter_open,shutter_close",
            "1,0,0,5,0,0,0,0.5,0.25",
            "2: shutter_close: 0.25 is before the shutter opens, at 0.5",
        ),
        (
            ",readout",
            "1,0,0,5,0,0,0,-1",
            "2: readout: a readout takes from 0 to 100 frames, not -1",
        ),
        (
            ",shutter_open",
            "1,0,0,5,0,0,0,0.5",
            "2: shutter_open: there is no shutter_close to go with it",
        ),
        (
            ",interp",
            "1,0,0,5,0,0,0,liner",
            "2: interp: unknown interpolation `liner` (did you mean `linear`?)",
        ),
        (
            ",interp",
            "1,0,0,5,0,0,0,elephant",
            "2: interp: unknown interpolation `elephant` (expected one of `smooth`, `linear`, `hold`)",
        ),
    ];
    for (more, row, message) in cases {
        assert_eq!(complaint(more, row), format!("camera_path.csv:{message}"), "{row}");
    }
}

#[test]
fn a_quaternion_is_of_unit_length_up_to_rounding() {
    let row = |q: &str| parse(&format!("frame,x,y,z,qx,qy,qz,qw\n1,0,0,0,{q}\n"));
    assert_eq!(
        row("0,0,0,0.998").unwrap_err(),
        "camera_path.csv:2: qx: the quaternion has length 0.998000, expected 1 within 0.001"
    );
    let path = row("0,0.7071,0,0.7071").expect("a path");
    assert!((pose(&path, 1.0).forward() - DVec3::NEG_X).length() < 1e-15);
}

#[test]
fn frames_rise_and_both_rows_are_named_where_they_do_not() {
    assert_eq!(
        complaint(
            "",
            "1,0,0,5,0,0,0\n# a comment\n3,0,0,5,0,0,0\n2,0,0,5,0,0,0\n1,0,0,5,0,0,0"
        ),
        "camera_path.csv:5: frame: frame 2 comes after frame 3 of line 4: frames must rise\n\
         camera_path.csv:6: frame: frame 1 is on line 2 already"
    );
}

#[test]
fn twenty_problems_are_listed_and_the_rest_counted() {
    let mut text = format!("{HEADER}\n");
    for frame in 1..=25 {
        let _ = writeln!(text, "{frame},abc,0,5,0,0,0");
    }
    let message = parse(&text).unwrap_err();
    let lines: Vec<_> = message.lines().collect();
    assert_eq!(lines.len(), 21);
    assert_eq!(lines[19], "camera_path.csv:21: eye_x: 'abc' is not a number");
    assert_eq!(lines[20], "and 5 more");
}

#[test]
fn what_is_not_utf_8_is_said_to_be_so() {
    let message = |bytes: &[u8]| {
        let problems = read_bytes(bytes, &CameraPathOptions::default()).unwrap_err();
        problems.display(Path::new("a.csv")).to_string()
    };
    assert_eq!(
        message(b"\xff\xfef\0r\0"),
        "a.csv: the file is UTF-16: save it as UTF-8"
    );
    assert_eq!(message(b"frame\n1\nb\xe4r\n"), "a.csv:3: the text is not UTF-8");
}

#[test]
fn the_line_by_which_excel_names_the_separator_is_no_header() {
    let rows = HEADER.replace(',', ";") + "\n1;0;0;5;0;0;0\n";
    for first in ["sep=;", "SEP=;", "\"sep=;\""] {
        assert_eq!(parse(&format!("{first}\r\n{rows}")).expect("a path").frames(), 1..=1);
    }
}

#[test]
fn cells_that_blanks_separate_are_one_problem_that_says_what_to_do() {
    let text = HEADER.replace(',', " ") + "\n1 0 0 5 0 0 0\n";
    assert_eq!(
        parse(&text).unwrap_err(),
        "camera_path.csv:1: the cells are separated by blanks: separate them by commas"
    );
}

#[test]
fn rows_of_empty_cells_are_no_rows() {
    let plain = parse(&format!("{HEADER}\n1,0,0,4,0,0,0\n2,.1,0,4,0,0,0\n"));
    let blank = ",,,,,,\n";
    let text = format!("{blank}{HEADER}\n1,0,0,4,0,0,0\n{blank} ,,\"\",,,,\n2,.1,0,4,0,0,0\n{blank}{blank}");
    assert!(plain.is_ok());
    assert_eq!(parse(&text), plain);
    // The lines of errors count them.
    let message = parse(&text.replace(".1", "abc")).unwrap_err();
    assert_eq!(message, "camera_path.csv:6: eye_x: 'abc' is not a number");
}

#[test]
fn an_index_of_pandas_is_skipped() {
    let plain = parse(&format!("{HEADER}\n1,0,0,4,0,0,0\n2,.1,0,4,0,0,0\n"));
    for (names, [first, second]) in [
        (",", ["0,", "1,"]),
        ("\"\",", ["\"a\",", "\"b\","]),
        ("Unnamed: 0,", ["0,", "1,"]),
        (",Unnamed: 0,", ["0,0,", "1,1,"]),
    ] {
        let text = format!("{names}{HEADER}\n{first}1,0,0,4,0,0,0\n{second}2,.1,0,4,0,0,0\n");
        assert_eq!(parse(&text), plain, "{names}");
    }
    let without_frame = HEADER.replace("frame", "");
    assert_eq!(
        parse(&format!("{without_frame}\n1,0,0,4,0,0,0\n")).unwrap_err(),
        "camera_path.csv:1: missing column: frame, or time and a frame rate: column 1 has no name"
    );
}

#[test]
fn a_header_behind_a_number_sign_is_read_above_numbers_only() {
    let rows = "1.000e+00,0,0,4.0e+00,0,0,0\n2.000e+00,1.0e-01,0,4,0,0,0\n";
    let plain = parse(&format!("{HEADER}\n{rows}"));
    assert!(plain.is_ok());
    for above in ["# ", "#", "# by hand, in steps\n# ", "# 0,0,0,4,0,0,0\n#"] {
        assert_eq!(parse(&format!("{above}{HEADER}\n{rows}")), plain, "{above}");
    }
    assert_eq!(parse(&format!("# {HEADER}\n# more\n{rows}")), plain);
    assert_eq!(
        parse(&format!("# {}\n{rows}", HEADER.replace("eye_z", "eye_zz"))).unwrap_err(),
        "camera_path.csv:1: unknown column `eye_zz` (did you mean `eye_z`?)"
    );
    // A header of its own goes first.
    assert_eq!(parse(&format!("# a,b,c,d,e,f,g\n{HEADER}\n{rows}")), plain);
    let numbers = "camera_path.csv:2: expected a header with the names of columns, found numbers";
    assert_eq!(parse(&format!("# 0,0,0,4,0,0,0\n{rows}")).unwrap_err(), numbers);
}

#[test]
fn control_characters_are_named_once() {
    for (padding, code) in [("\u{1a}", "001A"), ("\0\0\0\n\0\0", "0000")] {
        assert_eq!(
            complaint("", &format!("1,0,0,4,0,0,0\n{padding}")),
            format!("camera_path.csv:3: the control character U+{code} is no text: remove it")
        );
    }
}

proptest! {
    #[test]
    fn written_numbers_are_read_bit_for_bit(rows in prop::collection::vec([-1e6..1e6, -1e6..1e6, -1e6..1e6, 1.0..179.0], 1..20)) {
        let mut text = format!("{HEADER},fov\n");
        for (i, [x, y, z, fov]) in rows.iter().enumerate() {
            let _ = writeln!(text, "{i},{x},{y},{z},0,2e6,0,{fov}");
        }
        let path = parse(&text).unwrap();
        for (i, [x, y, z, fov]) in rows.iter().enumerate() {
            let state = path.at(i as f64).unwrap();
            prop_assert_eq!(state.pose.eye(), DVec3::new(*x, *y, *z));
            prop_assert_eq!(state.lens.view, Some(FieldOfView::Vertical(*fov)));
        }
    }

    #[test]
    fn no_bytes_make_it_panic(head in "(frame|time|tx|y|z|qx|qw|look_at_x|fov|[;,\t]){0,12}", body in "[-0-9.,;\"\n\t#eE ]{0,200}") {
        let options = CameraPathOptions { fps: Some(24.0), ..CameraPathOptions::default() };
        let _ = read_bytes(format!("{head}\n{body}").as_bytes(), &options);
        let _ = read_bytes(format!("{HEADER}\n{body}").as_bytes(), &options);
    }
}
