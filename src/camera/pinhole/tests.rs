//! Intrinsics by algebra, and distortions against their inverses and against numbers of OpenCV.

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::*;
use super::{
    brown::Brown,
    fisheyes::{FisheyePolynomial, KannalaBrandt},
    model::Model,
};
use crate::camera::{Camera, CameraDesc};

fn setup(keys: &str) -> CameraSetup<PinholeLens> {
    let text = format!("pinhole = {{ eye = [1, 2, 3], target = [1, 2, 0], {keys} }}");
    let CameraDesc::Pinhole(desc) = toml::from_str::<CameraDesc>(&text).expect("a camera") else {
        unreachable!("it is a pinhole")
    };
    desc.compile().expect("a valid camera")
}

fn pinhole(keys: &str, film: FilmSize) -> Pinhole {
    let CameraSetup { pose, lens } = setup(keys);
    lens.camera(&pose, film)
}

#[test]
fn a_point_is_seen_where_the_matrix_of_intrinsics_says() {
    let camera = pinhole("fx = 500, fy = 400, cx = 310, cy = 250, skew = 3", [640, 480]);
    let p = DVec3::new(0.3, -0.2, 2.0);
    let seen = camera
        .project(DVec3::new(1.0 + p.x, 2.0 - p.y, 3.0 - p.z))
        .expect("it is in front");
    let want = [
        500.0 * p.x / p.z + 3.0 * p.y / p.z + 310.0,
        400.0 * p.y / p.z + 250.0,
        p.z,
    ];
    assert!((seen - DVec3::from(want)).length() < 1e-9, "{seen}");
}

#[test]
fn pictures_of_another_size_scale_the_view() {
    let keys =
        "fx = 500, cx = 300, cy = 250, skew = 2, size = [640, 480], distortion.opencv = [-0.2, 0.05, 0.001, 0.002]";
    let [whole, half] = [[640, 480], [320, 240]].map(|film| pinhole(keys, film));
    for (x, y) in [(10.0, 20.0), (320.0, 240.0), (600.0, 470.0)] {
        let [a, b] = [(&whole, 1.0), (&half, 0.5)].map(|(camera, scale)| {
            let ray = camera.ray(Vec2::new(x, y) * scale, Vec2::ZERO);
            ray.expect("a ray").d
        });
        assert!((a - b).length() < 1e-6);
    }
}

#[test]
fn without_distortion_it_is_the_perspective_camera() {
    let pinhole = Camera::Pinhole(pinhole("fx = 300", [400, 200]));
    let fov = 2.0 * libm::atan(100.0 / 300.0).to_degrees();
    let text = format!("perspective = {{ eye = [1, 2, 3], target = [1, 2, 0], fov = {fov} }}");
    let scene = toml::from_str::<CameraDesc>(&text)
        .expect("a camera")
        .compile()
        .expect("a camera");
    let perspective = Camera::new(&scene.pose, &scene.lens, [400, 200]);
    for (x, y) in [(0.0, 0.0), (120.5, 77.25), (399.5, 199.5)] {
        let [a, b] = [&pinhole, &perspective].map(|c| c.ray(Vec2::new(x, y), Vec2::ZERO).expect("a ray").d);
        assert!((a - b).length() < 1e-6);
    }
    let [a, b] = [&pinhole, &perspective].map(|c| c.pinhole().expect("a pinhole"));
    assert!((a.focal[0] - b.focal[0]).abs() < 1e-4 && (a.center[1] - b.center[1]).abs() < 1e-9);
    assert!(pinhole.fills_film() && pinhole.missing_part([400, 200]) == 0.0);
}

/// Directions, and their places by both models.
const CASES_OF_OPENCV: &[([f64; 3], [[f64; 2]; 2])] = &[
    (
        [0.3, -0.2, 1.0],
        [
            [0.2864999188402555, -0.19091245589350367],
            [0.2872787052423656, -0.19151913682824376],
        ],
    ),
    (
        [-0.5, 0.4, 1.0],
        [
            [-0.4434229641091204, 0.3547732212872964],
            [-0.44227166332791634, 0.3538173306623331],
        ],
    ),
    (
        [0.05, 0.6, 1.0],
        [
            [0.04410071910859389, 0.5372692699281265],
            [0.04477747201524346, 0.5373296641829214],
        ],
    ),
    (
        [-0.7, -0.1, 1.0],
        [
            [-0.6073771481073135, -0.08585030687247336],
            [-0.6054588817590529, -0.086494125965579],
        ],
    ),
];

#[test]
fn places_are_those_of_opencv() {
    // projectPoints and fisheye.projectPoints of OpenCV 5.0.0 with the identity as camera matrix.
    let rational = Brown::new(&[
        -0.3, 0.12, 0.001, -0.002, 0.01, 0.05, -0.02, 0.003, 1e-3, -2e-3, 5e-4, 1e-4,
    ]);
    let fisheye = KannalaBrandt::new(&[-0.02, 0.01, -0.003, 5e-4]);
    for (d, want) in CASES_OF_OPENCV {
        let d = DVec3::from(*d);
        for (place, want) in [rational.place(d), fisheye.place(d)].into_iter().zip(want) {
            assert!(
                (place.expect("it is seen") - DVec2::from(*want)).length() < 1e-12,
                "{d}"
            );
        }
    }
}

#[test]
fn what_folds_over_is_empty_and_told() {
    // r (1 - r² / 2) is largest at r² = 2/3.
    let camera = pinhole("fx = 100, distortion.opencv = [-0.5, 0, 0, 0]", [400, 400]);
    let most = 100.0 * (2.0_f32 / 3.0).sqrt() * (2.0 / 3.0);
    let sees = |x: f32| camera.ray(Vec2::new(200.0 + x, 200.0), Vec2::ZERO).is_some();
    assert!(sees(most - 0.01) && !sees(most + 0.01) && !sees(190.0));
    let share = std::f64::consts::PI * f64::from(most).powi(2) / 160_000.0;
    assert!((camera.missing_part([400, 400]) - (1.0 - share)).abs() < 0.01);
    assert!(!camera.fills_film());
    // Behind the fold and behind the camera nothing is seen.
    assert_eq!(camera.project(DVec3::new(1.0 + 2.0, 2.0, 2.0)), None);
    assert_eq!(camera.project(DVec3::new(1.0, 2.0, 4.0)), None);
}

#[test]
fn wrong_numbers_of_coefficients_are_refused() {
    let problem = |distortion: &str| {
        let text = format!("pinhole = {{ eye = [0, 0, 1], target = [0, 0, 0], fx = 9, distortion.{distortion} }}");
        let desc = toml::from_str::<CameraDesc>(&text).map_err(|e| e.message().to_owned())?;
        desc.compile().map(drop).map_err(|problems| problems[0].message.clone())
    };
    let refused = |distortion: &str| problem(distortion).expect_err("it is wrong");
    assert_eq!(refused("opencv = [1, 2, 3]"), "expected 4, 5, 8 or 12 numbers, found 3");
    assert_eq!(refused("kannala_brandt = [1]"), "expected 4 numbers, found 1");
    assert!(refused("fisheye_polynomial = [0, -1]").contains("is not above 0"));
    assert!(refused("division = [1]").contains("unknown variant `division`"));
}

fn models() -> [PinholeLens; 5] {
    [
        "distortion.opencv = [-0.21, 0.08, 0, 0, -0.01]",
        "distortion.opencv = [-0.21, 0.08, 0.0004, -0.0002, -0.01]",
        "distortion.opencv = [0.3, -0.05, 0.002, 0.003, 0.02, 0.4, 0.01, 0.001, 0.001, -0.002, 0.0005, 0.0001]",
        "distortion.kannala_brandt = [-0.02, 0.01, -0.003, 0.0005]",
        "distortion.fisheye_polynomial = [0, 1.1, 0.02, -0.03, 0.01]",
    ]
    .map(|distortion| setup(&format!("fx = 300, skew = 1, {distortion}")).lens)
}

proptest! {
    #[test]
    fn a_ray_of_a_place_is_seen_at_this_place(x in -100.0_f64..740.0, y in -100.0_f64..580.0) {
        for lens in models() {
            let camera = lens.camera(&Pose::at(DVec3::ZERO), [640, 480]);
            let place = camera.inverse * (DVec2::new(x, y) - camera.center);
            if let Some(d) = camera.distortion.direction(place) {
                let back = camera.distortion.place(d).expect("it is seen");
                let pixels = camera.pixels * (back - place);
                prop_assert!(pixels.length() < 1e-6, "{pixels} at {x} {y}, {lens:?}");
            }
        }
    }
}

#[test]
fn nearly_all_of_usual_pictures_is_seen() {
    for lens in models() {
        let camera = lens.camera(&Pose::at(DVec3::ZERO), [640, 480]);
        assert_eq!(camera.missing_part([640, 480]), 0.0, "{lens:?}");
    }
}

#[test]
fn intrinsics_at_the_ends_of_their_range_have_rays_and_cones() {
    let ends = ["1.2e-38", "1", "3.4e38"];
    let offsets = ["-3.4e38", "0", "3.4e38"];
    let distortions = [
        "",
        "distortion.opencv = [-0.1, 0.2, 0.01, 0.02]",
        "distortion.kannala_brandt = [0.1, 0, 0, 0.1]",
        "distortion.fisheye_polynomial = [0, 1, 0.1]",
        "distortion.fisheye_polynomial = [3.4e38, 3.4e38, -3.4e38]",
        "distortion.fisheye_polynomial = [-3.4e38, 1e-300, 3.4e38]",
    ];
    let mut numbers = 0_u32;
    let mut pick = |of: &[&'static str]| {
        numbers += 1;
        of[crate::math::hash::mix32(numbers) as usize % of.len()]
    };
    for _ in 0..60 {
        for distortion in distortions {
            let [fx, fy, width, height] = std::array::from_fn(|_| pick(&ends));
            let [cx, cy, skew] = std::array::from_fn(|_| pick(&offsets));
            let keys = format!(
                "fx = {fx}, fy = {fy}, cx = {cx}, cy = {cy}, skew = {skew}, size = [{width}, {height}], {distortion}"
            );
            let camera = pinhole(&keys, [640, 480]);
            for place in [[0.0, 0.0], [320.0, 240.0], [640.0, 0.25]] {
                let ray = camera.ray(Vec2::from(place), Vec2::ZERO);
                assert!(
                    ray.is_none_or(|ray| (ray.d.length() - 1.0).abs() < 1e-5),
                    "{keys}: {ray:?}"
                );
                assert!(ray.is_some() || !distortion.is_empty(), "{keys}");
            }
            assert!(camera.pixel_cone().spread.is_finite(), "{keys}");
        }
    }
}

#[test]
fn a_fisheye_ends_where_its_model_does_whatever_its_film() {
    let line = FisheyePolynomial::new(&[0.0, 1e-3]);
    let sees = |distance: f64| line.direction(DVec2::new(distance, 0.0)).is_some();
    assert!(sees(1000.0 * PI - 1e-6) && !sees(1000.0 * PI + 1e-6));
    // The slope of r - r² is 0 at 1/2.
    let folds = FisheyePolynomial::new(&[0.0, 1e-3, -1.0]);
    let sees = |distance: f64| folds.direction(DVec2::new(0.0, distance)).is_some();
    assert!(sees(5e-4 * (1.0 - 1e-9)) && !sees(5e-4 * (1.0 + 1e-9)));
    let rises_slowly = FisheyePolynomial::new(&[-10.0, 1e-3, 0.0, 0.0, 0.0, 1e-30]);
    let place = DVec2::new(-8000.0, 8000.0);
    let d = rises_slowly.direction(place).expect("it is seen");
    assert!((rises_slowly.place(d).expect("it is seen") - place).length() < 1e-6);
}

#[test]
fn each_place_of_a_picture_that_folds_over_aslant_shows_one_direction() {
    for coefficients in [
        [-0.1, 0.0, 0.2, 0.0].as_slice(),
        &[0.0, 0.0, -0.1, 0.3],
        &[-0.2, 0.05, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.2, -0.3, 0.1, 0.0],
    ] {
        let brown = Brown::new(coefficients);
        let mut seen = 0;
        for i in 0..40 {
            let (sin, cos) = libm::sincos(f64::from(i) * 0.157);
            for r in 0..200 {
                let d = (DVec2::new(cos, sin) * (f64::from(r) * 0.02)).extend(1.0);
                let Some(place) = brown.place(d) else { continue };
                seen += 1;
                let back = brown.direction(place).expect("it is seen");
                assert!(
                    (back - d).length() < 1e-6 * (1.0 + d.length()),
                    "{coefficients:?}: {d} {back}"
                );
            }
        }
        assert!(seen > 200, "{coefficients:?}: {seen}");
    }
}

#[test]
fn an_inverse_takes_few_steps() {
    let calls = std::cell::Cell::new(0);
    let cube = |x: f64| {
        calls.set(calls.get() + 1);
        [x + x * x * x, 1.0 + 3.0 * x * x]
    };
    for i in 0..1000 {
        let x = f64::from(i) * 0.01;
        let found = rising::invert(cube(x)[0], 10.0, cube).expect("it rises");
        assert!((found - x).abs() <= 1e-14);
    }
    assert!(calls.get() < 20 * 1000, "{}", calls.get());
}
