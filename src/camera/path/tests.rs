use proptest::prelude::*;

use super::*;
use crate::camera::{lens::FieldOfView, perspective::PerspectiveLens};

fn looking(frame: f64, eye: DVec3) -> PathKey {
    PathKey {
        frame,
        eye,
        orientation: Orientation::Target {
            target: DVec3::ZERO,
            up: None,
            roll: None,
        },
        lens: LensOverrides::default(),
        pinhole: None,
        shutter: None,
        readout: None,
        stereo: [None; 2],
        interp: Interp::Smooth,
        name: None,
    }
}

fn turned(frame: f64, degrees: DVec3) -> PathKey {
    let order = RotationOrder::Zxy;
    PathKey {
        orientation: Orientation::Rotation(Rotation::Euler { degrees, order }),
        ..looking(frame, DVec3::ZERO)
    }
}

fn with_lens(frame: f64, lens: LensOverrides) -> PathKey {
    PathKey {
        lens,
        ..looking(frame, DVec3::Z)
    }
}

fn focal(mm: f64) -> LensOverrides {
    LensOverrides {
        view: Some(FieldOfView::FocalLength(mm)),
        ..LensOverrides::default()
    }
}

fn scene_lens(keys: &str) -> Lens {
    let text = format!("perspective = {{ eye = [0, 0, 9], target = [0, 0, 0], {keys} }}");
    let desc: crate::camera::CameraDesc = toml::from_str(&text).expect("well-formed");
    desc.compile().expect("a camera").lens
}

#[test]
fn frames_are_all_whole_ones_between_the_keys() {
    let path = |a: f64, b: f64| CameraPath::new(&[looking(a, DVec3::X), looking(b, DVec3::Z)]).expect("a path");
    assert_eq!(path(-3.0, 2.0).frames(), -3..=2);
    assert_eq!(path(0.5, 2.5).frames(), 1..=2);
    assert_eq!(path(0.2, 0.8).frames().count(), 0);
    let still = CameraPath::new(&[looking(7.0, DVec3::X)]).expect("a path");
    assert_eq!(still.frames(), 7..=7);
}

#[test]
fn nothing_is_extrapolated() {
    let path = CameraPath::new(&[looking(1.0, DVec3::X), looking(3.0, DVec3::Z)]).expect("a path");
    for frame in [0.999, 3.001, f64::NAN] {
        let error = path.at(frame).unwrap_err().to_string();
        assert_eq!(
            error,
            format!("frame {frame} is outside of the camera path, which goes from 1 to 3")
        );
    }
}

#[test]
fn keys_that_make_no_path_are_refused() {
    let refused = |keys: &[PathKey]| CameraPath::new(keys).unwrap_err().to_string();
    let at = |frame| looking(frame, DVec3::X);
    assert_eq!(refused(&[]), "the camera path has no keys");
    assert_eq!(
        refused(&[at(2.0), at(2.0)]),
        "frame 2 comes after frame 2: frames must rise"
    );
    assert_eq!(
        refused(&[at(f64::NAN)]),
        "frame NaN is not a number between -1000000000 and 1000000000"
    );
    assert_eq!(
        refused(&[looking(4.0, DVec3::ZERO)]),
        "frame 4: the target is at the eye"
    );
    assert_eq!(
        refused(&[at(1.0), turned(2.0, DVec3::ZERO)]),
        "frame 2: the orientation is given in another way than before"
    );
    let angle = LensOverrides {
        view: Some(FieldOfView::Vertical(40.0)),
        ..LensOverrides::default()
    };
    assert_eq!(
        refused(&[with_lens(1.0, focal(50.0)), with_lens(2.0, angle)]),
        "frame 2: the view is given in another way than before"
    );
    assert_eq!(
        refused(&[with_lens(1.0, focal(0.0))]),
        "frame 1: the view is not an angle between 0 and 180 degrees or a focal length above 0"
    );
}

#[test]
fn curves_of_eye_and_target_that_meet_are_an_error_there_and_only_there() {
    let keys = [looking(0.0, DVec3::X), looking(2.0, DVec3::NEG_X)];
    let path = CameraPath::new(&keys).expect("a path");
    assert!(path.at(0.9).is_ok());
    assert_eq!(
        path.at(1.0).unwrap_err().to_string(),
        "frame 1: the target is at the eye"
    );
}

#[test]
fn angles_turn_as_far_as_their_numbers_say() {
    let forward = |to: f64, frame: f64| {
        let keys = [turned(1.0, DVec3::ZERO), turned(5.0, DVec3::new(0.0, to, 0.0))];
        CameraPath::new(&keys)
            .expect("a path")
            .at(frame)
            .expect("inside")
            .pose
            .forward()
    };
    // A full turn about +y, by a quarter in each frame.
    for (frame, want) in [
        (1.0, DVec3::NEG_Z),
        (2.0, DVec3::NEG_X),
        (3.0, DVec3::Z),
        (4.0, DVec3::X),
        (5.0, DVec3::NEG_Z),
    ] {
        assert!((forward(360.0, frame) - want).length() < 1e-12, "{frame}");
    }
    // The long way to 270 degrees leads by way of 135.
    let want = DVec3::new(-1.0, 0.0, 1.0).normalize();
    assert!((forward(270.0, 3.0) - want).length() < 1e-12);
}

#[test]
fn quaternions_turn_the_shorter_way() {
    let key = |frame, degrees: f64| PathKey {
        orientation: Orientation::Rotation(Rotation::Quaternion(DQuat::from_rotation_y(degrees.to_radians()))),
        ..looking(frame, DVec3::ZERO)
    };
    let path = CameraPath::new(&[key(0.0, 350.0), key(10.0, 10.0)]).expect("a path");
    let middle = path.at(5.0).expect("inside").pose;
    assert!((middle.forward() - DVec3::NEG_Z).length() < 1e-12);
}

#[test]
fn a_quantity_moves_past_keys_that_are_silent_and_rests_outside_of_those_that_speak() {
    let silent = LensOverrides::default();
    let path = CameraPath::new(&[
        with_lens(0.0, silent),
        with_lens(10.0, focal(20.0)),
        with_lens(20.0, silent),
        with_lens(30.0, focal(40.0)),
        with_lens(40.0, silent),
    ])
    .expect("a path");
    for (frame, mm) in [(0.0, 20.0), (10.0, 20.0), (20.0, 30.0), (30.0, 40.0), (40.0, 40.0)] {
        assert_eq!(path.at(frame).expect("inside").lens, focal(mm));
    }
}

#[test]
fn the_path_speaks_before_the_scene_and_leaves_the_rest_to_it() {
    let scene = scene_lens("focal_length = 50, sensor_width = 24, aperture_radius = 0.1");
    let state = CameraPath::new(&[with_lens(1.0, focal(35.0))])
        .and_then(|path| path.at(1.0))
        .expect("a state");
    let (Lens::Perspective(lens), Lens::Perspective(own)) = (state.apply(&scene), scene) else {
        unreachable!("both are perspective lenses")
    };
    let want = PerspectiveLens {
        view: FieldOfView::FocalLength(35.0),
        // The path's target is 1 m away, the scene's 9 m.
        focus: crate::camera::lens::Focus::OnTarget(1.0),
        ..own
    };
    assert_eq!(lens, want);
}

#[test]
fn names_last_until_the_next_one() {
    let mut keys: Vec<_> = (0..4).map(|i| looking(f64::from(i), DVec3::X)).collect();
    keys[1].name = Some("wide".into());
    keys[3].name = Some("close".into());
    let path = CameraPath::new(&keys).expect("a path");
    let names: Vec<_> = [0.0, 1.0, 2.5, 3.0]
        .map(|frame| path.at(frame).expect("inside").name.unwrap_or_default())
        .into();
    assert_eq!(names, ["", "wide", "wide", "close"]);
}

/// The camera when the shutter opens and when it closes.
fn over_shutter(path: &CameraPath, frame: f64, otherwise: Timing) -> Result<[CameraState; 2], PathError> {
    let interval = path.shutter_interval(frame, otherwise)?;
    Ok([path.at(interval.time(0.0))?, path.at(interval.time(1.0))?])
}

#[test]
fn pictures_are_views_of_their_own_and_the_camera_moves_between_them_alone() {
    let keys = [
        looking(1.0, DVec3::X),
        looking(5.0, DVec3::X * 5.0),
        looking(9.0, DVec3::X * 9.0),
    ];
    let path = CameraPath::new(&keys).expect("a path").of_pictures(vec![1, 5, 9]);
    let half = Shutter { open: 0.0, close: 0.5 };
    let moves = |frame: f64| {
        let [open, shut] = over_shutter(&path, frame, half.into()).expect("inside");
        open.pose != shut.pose
    };
    assert_eq!([1.0, 3.0, 5.0, 5.25, 9.0].map(moves), [false, true, false, true, false]);
    let camera = path.with_scene_timing(half.into());
    let camera = camera
        .frame_camera(5.0, |_| Ok::<_, PathError>(Lens::default()), [100, 100])
        .expect("a camera");
    assert!(!camera.moves() && camera.duration() == 0.5 && camera.neighbours().next.is_some());
}

#[test]
fn the_shutter_opens_and_closes_on_the_same_curve_and_stops_at_its_ends() {
    let path = CameraPath::new(&[looking(0.0, DVec3::X), looking(10.0, DVec3::X * 11.0)]).expect("a path");
    let half = Shutter {
        open: -0.25,
        close: 0.25,
    };
    let eyes = |frame| {
        over_shutter(&path, frame, half.into())
            .expect("inside")
            .map(|state| state.pose.eye().x)
    };
    let close = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < 1e-12 && (a[1] - b[1]).abs() < 1e-12;
    assert!(close(eyes(4.0), [4.75, 5.25]));
    assert!(close(eyes(0.0), [1.0, 1.25]));
    assert!(close(eyes(10.0), [10.75, 11.0]));
    assert!(over_shutter(&path, 11.0, half.into()).is_err());

    let own = PathKey {
        shutter: Some(Shutter { open: 0.0, close: 0.5 }),
        ..looking(0.0, DVec3::X)
    };
    let path = CameraPath::new(&[own, looking(10.0, DVec3::X * 11.0)]).expect("a path");
    let [open, shut] = over_shutter(&path, 4.0, half.into()).expect("inside");
    assert_eq!((open.frame, shut.frame), (4.0, 4.5));
}

#[test]
fn a_picture_never_shows_both_sides_of_a_cut() {
    let key = |frame: f64, x: f64, interp| PathKey {
        interp,
        ..looking(frame, DVec3::X * x)
    };
    let path = CameraPath::new(&[
        key(1.0, 1.0, Interp::Smooth),
        key(2.0, 2.0, Interp::Step),
        key(3.0, 50.0, Interp::Smooth),
        key(4.0, 51.0, Interp::Smooth),
    ])
    .expect("a path");
    let wide = Shutter { open: -0.5, close: 1.5 };
    let eyes = |frame| {
        let states = over_shutter(&path, frame, wide.into()).expect("inside");
        states.map(|state| state.pose.eye().x)
    };
    assert_eq!(eyes(2.0), [1.5, 2.0]);
    assert_eq!(eyes(3.0), [50.0, 51.0]);
}

/// The x of the eye, that is of the ray in the middle, at times of a picture.
fn eyes_of_shot(path: &CameraPath, frame: f64, times: [f32; 3]) -> [f32; 3] {
    let camera = path
        .frame_camera(frame, |_| Ok::<_, PathError>(Lens::default()), [100, 100])
        .expect("a camera");
    let middle = glam::Vec2::splat(50.0);
    times.map(|time| camera.camera(time).ray(middle, middle).expect("a ray").o.x)
}

#[test]
fn a_shot_goes_along_the_path_while_the_shutter_is_open() {
    let open = |frame: f64, x: f64, interp| PathKey {
        shutter: Some(Shutter { open: -0.5, close: 0.5 }),
        interp,
        ..looking(frame, DVec3::X * x)
    };
    let path = CameraPath::new(&[
        open(1.0, 1.0, Interp::Linear),
        open(2.0, 2.0, Interp::Linear),
        open(3.0, 3.0, Interp::Step),
        open(4.0, 50.0, Interp::Linear),
        open(5.0, 51.0, Interp::Linear),
    ])
    .expect("a path");
    let times = [0.0, 0.25, 0.75];
    assert_eq!(eyes_of_shot(&path, 2.0, times), [1.5, 1.75, 2.25]);
    // It stands still before the path begins, and on both sides of a cut.
    assert_eq!(eyes_of_shot(&path, 1.0, times), [1.0, 1.0, 1.25]);
    assert_eq!(eyes_of_shot(&path, 3.0, times), [2.5, 2.75, 3.0]);
    assert_eq!(eyes_of_shot(&path, 4.0, times), [50.0, 50.0, 50.25]);
    // A picture between two frames is one of its own time.
    assert_eq!(eyes_of_shot(&path, 1.75, times), [1.25, 1.5, 2.0]);
    assert_eq!(eyes_of_shot(&path, 4.25, times), [50.0, 50.0, 50.5]);

    let closed = CameraPath::new(&[looking(1.0, DVec3::X), looking(2.0, DVec3::X * 2.0)]).expect("a path");
    let camera = closed
        .frame_camera(1.0, |_| Ok::<_, PathError>(Lens::default()), [100, 100])
        .expect("a camera");
    assert!(!camera.moves());
}

proptest! {
    #[test]
    fn rows_at_every_frame_are_used_bit_for_bit(rows in prop::collection::vec([-50.0..50.0, -50.0..50.0, -50.0..50.0, 1.0..300.0, -500.0..500.0], 1..12)) {
        let keys: Vec<_> = rows.iter().enumerate().map(|(i, row)| PathKey {
            eye: DVec3::new(row[0], row[1], row[2]),
            lens: focal(row[3]),
            ..turned(i as f64 + 100.0, DVec3::new(row[1], row[4], row[2]))
        }).collect();
        let path = CameraPath::new(&keys).unwrap();
        for (frame, key) in path.frames().zip(&keys) {
            let state = path.at(frame as f64).unwrap();
            let Orientation::Rotation(Rotation::Euler { degrees, order }) = key.orientation else {
                unreachable!("turned")
            };
            prop_assert_eq!(state.pose, Pose::from_euler(key.eye, degrees, order).unwrap());
            prop_assert_eq!(state.lens, key.lens);
        }
    }
}
