//! The requirements on every camera, and the rays of each.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

use proptest::prelude::*;

use super::*;
use crate::camera::lens::FieldOfView;

const LENS: Vec2 = Vec2::splat(0.5);

fn scene(text: &str) -> SceneCamera {
    let desc: CameraDesc = toml::from_str(text).expect("a camera");
    desc.compile().expect("a camera")
}

fn camera(text: &str, film: FilmSize) -> Camera {
    let scene = scene(text);
    Camera::new(&scene.pose, &scene.lens, film)
}

fn ray(camera: &Camera, x: f32, y: f32) -> Ray {
    camera.ray(Vec2::new(x, y), LENS).expect("a ray")
}

fn looks(camera: &Camera, x: f32, y: f32, along: [f64; 3]) -> bool {
    (ray(camera, x, y).d.as_dvec3() - DVec3::from(along)).length() < 1e-6
}

/// Every kind, at (1, 2, 3) and looking along -z.
fn every_kind() -> Vec<SceneCamera> {
    CameraDesc::NAMES
        .iter()
        .map(|name| {
            let required = match *name {
                "orthographic" => ", height = 4",
                "pinhole" => ", fx = 80, distortion.opencv = [-0.1, 0.02, 0, 0]",
                _ => "",
            };
            scene(&format!("{name} = {{ eye = [1, 2, 3], target = [1, 2, 0]{required} }}"))
        })
        .collect()
}

#[test]
fn the_middle_of_every_picture_is_the_target() {
    for scene in every_kind() {
        let camera = Camera::new(&scene.pose, &scene.lens, [60, 40]);
        let ray = ray(&camera, 30.0, 20.0);
        assert!((ray.d - Vec3::NEG_Z).length() < 1e-6 && (ray.o - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-6);
        assert_eq!((ray.tmin, ray.tmax), (0.0, f32::INFINITY));
    }
}

#[test]
fn neighbouring_pixels_are_a_cone_apart_in_the_middle_of_every_picture() {
    for scene in every_kind() {
        let camera = Camera::new(&scene.pose, &scene.lens, [400, 200]);
        let [a, b] = [99.5, 100.5].map(|y| ray(&camera, 200.0, y));
        let cone = camera.pixel_cone();
        let name = scene.lens.name();
        assert!(((a.d - b.d).length() - cone.spread).abs() < 1e-5, "{name}");
        assert!(((a.o - b.o).length() - cone.width).abs() < 1e-6, "{name}");
        assert!(cone.width + cone.spread > 0.0, "{name}");
    }
}

#[test]
fn rays_of_an_orthographic_camera_are_parallel_and_as_far_apart_as_it_says() {
    let text = "orthographic = { eye = [0, 0, 9], target = [0, 0, 0], height = 6, shift = [0.25, 0.5] }";
    let camera = camera(text, [300, 200]);
    for (x, y) in [(0.0, 0.0), (300.0, 200.0), (17.5, 120.5)] {
        let ray = ray(&camera, x, y);
        assert_eq!(ray.d, Vec3::NEG_Z);
        // 9 m wide: moved by a quarter and a half of that.
        let want = Vec3::new(-4.5 + 0.03 * x + 2.25, 3.0 - 0.03 * y + 4.5, 9.0);
        assert!((ray.o - want).length() < 1e-5, "{} {want}", ray.o);
    }
}

#[test]
fn a_panorama_shows_longitude_across_and_latitude_up() {
    let camera = camera("panorama = { eye = [0, 0, 0], target = [0, 0, -1] }", [360, 180]);
    for (x, y, along) in [
        (180.0, 90.0, [0.0, 0.0, -1.0]),
        (270.0, 90.0, [1.0, 0.0, 0.0]),
        (90.0, 90.0, [-1.0, 0.0, 0.0]),
        (0.0, 90.0, [0.0, 0.0, 1.0]),
        (360.0, 90.0, [0.0, 0.0, 1.0]),
        (33.0, 0.0, [0.0, 1.0, 0.0]),
        (33.0, 180.0, [0.0, -1.0, 0.0]),
        (180.0, 45.0, [0.0, FRAC_1_SQRT_2, -FRAC_1_SQRT_2]),
        // Beyond the pole.
        (180.0, -45.0, [0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2]),
    ] {
        assert!(looks(&camera, x, y, along), "{x} {y}");
    }
}

#[test]
fn a_fisheyes_angle_grows_with_the_distance_from_the_middle_up_to_its_circle() {
    for degrees in [40.0, 180.0, 360.0_f64] {
        let text = format!("fisheye = {{ eye = [0, 0, 0], target = [0, 0, -1], fov = {degrees} }}");
        let camera = camera(&text, [300, 200]);
        for part in [0.0, 0.25, 0.5, 0.999] {
            let (sin, cos) = libm::sincos(part * 0.5 * degrees.to_radians());
            let at = 100.0 * part as f32;
            assert!(looks(&camera, 150.0 + at, 100.0, [sin, 0.0, -cos]));
            assert!(looks(&camera, 150.0, 100.0 - at, [0.0, sin, -cos]));
        }
        for (x, y) in [(150.0, -0.1), (250.1, 100.0), (0.0, 0.0), (80.0, 28.0)] {
            assert_eq!(camera.ray(Vec2::new(x, y), LENS), None, "{x} {y}");
        }
        assert!(!camera.fills_film());
    }
}

#[test]
fn a_camera_path_may_say_of_a_lens_what_its_camera_has() {
    let given = LensOverrides {
        view: Some(FieldOfView::Vertical(60.0)),
        focus_distance: Some(2.0),
        shift_x: Some(0.1),
        ..LensOverrides::default()
    };
    let unknown: Vec<_> = every_kind()
        .iter()
        .map(|s| s.lens.unsupported_columns(&given))
        .collect();
    let none: &[&str] = &[];
    assert_eq!(
        unknown,
        [
            none,
            &["fov", "focus_distance"],
            &["fov", "focus_distance", "shift_x"],
            &["focus_distance", "shift_x"],
            &["fov", "focus_distance", "shift_x"],
        ]
    );
    let fisheye = scene("fisheye = { eye = [0, 0, 0], target = [0, 0, -1] }");
    let Lens::Fisheye(lens) = fisheye.lens.with_overrides(&given, None) else {
        unreachable!("it is a fisheye")
    };
    assert_eq!(lens.fov, 60.0);
    for scene in every_kind() {
        assert_eq!(scene.lens.with_overrides(&LensOverrides::default(), None), scene.lens);
    }
}

#[test]
fn what_no_camera_can_be_is_refused_at_the_value() {
    let message = |text: &str| toml::from_str::<CameraDesc>(text).unwrap_err().message().to_owned();
    let pose = "eye = [0, 0, 1], target = [0, 0, 0]";
    assert_eq!(
        message(&format!("fisheye = {{ {pose}, fov = 361 }}")),
        "expected an angle above 0 and at most 360 degrees, found 361"
    );
    assert_eq!(
        message(&format!("orthographic = {{ {pose}, height = 0 }}")),
        "expected a number above 0, found 0"
    );
    assert!(message(&format!("orthographic = {{ {pose} }}")).contains("missing field `height`"));
    assert!(message(&format!("panorama = {{ {pose}, fov = 3 }}")).contains("unknown field `fov`"));
    let at_eye: CameraDesc = toml::from_str("panorama = { eye = [0, 0, 1], target = [0, 0, 1] }").expect("well-formed");
    assert_eq!(at_eye.compile().unwrap_err()[0].message, "the target is at the eye");
}

/// A camera that turns by `angle` about the origin, 5 m away, and looks at it.
fn orbit(lens: &Lens, angle: f64) -> impl Fn(f64) -> Result<Camera, PoseError> {
    let lens = *lens;
    move |u| {
        let (sin, cos) = libm::sincos(u * angle);
        let eye = DVec3::new(5.0 * sin, 0.0, 5.0 * cos);
        Ok(Camera::new(
            &Pose::look_at(eye, &LookAt::new(DVec3::ZERO))?,
            &lens,
            [200, 100],
        ))
    }
}

#[test]
fn a_moving_camera_strays_from_its_curve_by_no_more_than_it_says() {
    for scene in every_kind() {
        for angle in [0.01, 0.2, FRAC_PI_2] {
            let exact = orbit(&scene.lens, angle);
            let shot = FrameCamera::from(PictureCamera::moving(&exact).expect("poses"));
            assert!(shot.moves());
            // Half of an ulp of 5 m, and of a unit direction, beside the chords.
            let eye = 5.0 * angle.powi(2) / 2048.0 + 1e-6;
            let sight = angle.powi(3) / 250_000.0 + 2e-7;
            for i in 0..97 {
                let time = i as f32 / 97.0;
                let want = exact(time.into()).expect("a pose");
                // The origin of an orthographic ray in the middle, and the line of sight.
                let (a, b) = (ray(&shot.camera(time), 100.0, 50.0), ray(&want, 100.0, 50.0));
                assert!(f64::from((a.o - b.o).length()) < eye, "{angle} {time}");
                assert!(f64::from((a.d - b.d).length()) < sight, "{angle} {time}");
            }
        }
    }
}

#[test]
fn a_camera_that_stands_still_is_itself_at_all_times() {
    for scene in every_kind() {
        let camera = Camera::new(&scene.pose, &scene.lens, [200, 100]);
        let still = FrameCamera::from(camera);
        assert!(!still.moves());
        let held = PictureCamera::moving(|_| Ok::<_, PoseError>(camera))
            .expect("a shot")
            .into();
        for time in [0.0, 0.3, 0.99] {
            for shot in [&still, &held] {
                assert_eq!(ray(&shot.camera(time), 120.5, 70.5), ray(&camera, 120.5, 70.5));
            }
        }
    }
}

proptest! {
    #[test]
    fn directions_are_unit_vectors_wherever_the_film_is_met(x in -3.0_f32..63.0, y in -3.0_f32..43.0, u in 0.0_f32..1.0) {
        for scene in every_kind() {
            let camera = Camera::new(&scene.pose, &scene.lens, [60, 40]);
            if let Some(ray) = camera.ray(Vec2::new(x, y), Vec2::new(u, 0.3)) {
                prop_assert!((ray.d.length() - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_panorama_and_a_fisheye_of_360_degrees_see_every_direction_once(x in 0.0_f32..400.0, y in 0.0_f32..200.0) {
        let panorama = camera("panorama = { eye = [0, 0, 0], target = [0, 0, -1] }", [400, 200]);
        let d = ray(&panorama, x, y).d.as_dvec3();
        let (lon, lat) = (libm::atan2(d.x, -d.z), libm::asin(d.y.clamp(-1.0, 1.0)));
        let back = [(lon / PI + 1.0) * 200.0, (0.5 - lat / PI) * 200.0];
        prop_assert!((back[1] - f64::from(y)).abs() < 0.05);
        if (1.0..199.0).contains(&y) {
            let off = (back[0] - f64::from(x)).abs();
            prop_assert!(off.min(400.0 - off) < 0.05, "{off}");
        }
        // The circle that a fisheye of 360 degrees fills, but for its edge, which is the direction behind.
        let fisheye = camera("fisheye = { eye = [0, 0, 0], target = [0, 0, -1], fov = 360 }", [400, 400]);
        let place = Vec2::new(x, 2.0 * y) - Vec2::splat(200.0);
        if place.length() < 199.0 {
            let along = ray(&fisheye, x, 2.0 * y).d.as_dvec3();
            let angle = libm::acos((-along.z).clamp(-1.0, 1.0));
            prop_assert!((angle / PI * 200.0 - f64::from(place.length())).abs() < 0.05);
            let back = fisheye.project(along * 3.0).expect("it is seen");
            prop_assert!((back.x - f64::from(x)).abs() < 0.05 && (back.y - f64::from(2.0 * y)).abs() < 0.05, "{back}");
        }
    }
}
