use proptest::prelude::*;

use super::*;
use crate::{
    camera::{Camera, CameraDesc, Lens},
    math::{Plain, Vec3, warp},
};

const CENTER: Vec2 = Vec2::splat(0.5);

fn describe(keys: &str) -> Result<CameraDesc, String> {
    #[derive(Deserialize)]
    struct File {
        camera: CameraDesc,
    }
    toml::from_str::<File>(&format!("[camera]\nperspective = {{ {keys} }}\n"))
        .map(|file| file.camera)
        .map_err(|e| e.message().to_owned())
}

fn lens(keys: &str) -> PerspectiveLens {
    let Lens::Perspective(lens) = compile(keys).expect("a camera").lens else {
        unreachable!("it is a perspective camera")
    };
    lens
}

fn compile(keys: &str) -> Result<crate::camera::SceneCamera, Vec<Problem>> {
    describe(&format!("eye = [0, 0, 15], target = [0, 0, 0], {keys}"))
        .expect("well-formed")
        .compile()
}

fn camera(keys: &str, film: FilmSize) -> Camera {
    let scene = compile(keys).expect("a camera");
    Camera::new(&scene.pose, &scene.lens, film)
}

/// The point where a ray meets the plane at `distance` before the eye (0, 0, 15).
fn on_plane(ray: &Ray, distance: f64) -> DVec2 {
    let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
    let t = (15.0 - distance - o.z) / d.z;
    (o + d * t).truncate()
}

#[test]
fn the_ray_of_a_pixel_meets_the_image_plane_at_its_centre() {
    let camera = camera("fov = 28.0724869", [600, 600]);
    for (i, j) in [(0, 0), (599, 0), (0, 599), (599, 599), (299, 300), (17, 423)] {
        let (i, j) = (f64::from(i), f64::from(j));
        let ray = camera
            .ray(DVec2::new(i + 0.5, j + 0.5).as_vec2(), CENTER)
            .expect("a ray");
        let want = DVec3::new(-10.0 + 20.0 * (i + 0.5) / 600.0, 10.0 - 20.0 * (j + 0.5) / 600.0, -40.0);
        assert!((ray.d.as_dvec3() - want.normalize()).length() < 1e-7);
        assert!((on_plane(&ray, 40.0) - want.truncate()).length() < 2.5e-6);
        assert_eq!(
            (ray.o, ray.tmin, ray.tmax),
            (Vec3::new(0.0, 0.0, 15.0), 0.0, f32::INFINITY)
        );
    }
}

#[test]
fn every_way_to_say_the_angle_gives_the_same_rays() {
    // 36 mm wide before a 3:2 film is 24 mm high.
    let vertical = 2.0 * libm::atan(12.0 / 50.0).to_degrees();
    let horizontal = 2.0 * libm::atan(18.0 / 50.0).to_degrees();
    let corner = Vec2::ZERO;
    let want = camera("focal_length = 50", [300, 200])
        .ray(corner, CENTER)
        .expect("a ray");
    for keys in [
        format!("fov = {vertical}"),
        format!("fov_x = {horizontal}"),
        "focal_length = 50, sensor_height = 24".to_owned(),
        "focal_length = 25, sensor_width = 18".to_owned(),
    ] {
        let ray = camera(&keys, [300, 200]).ray(corner, CENTER).expect("a ray");
        assert!((ray.d - want.d).length() < 1e-7, "{keys}");
    }
    assert_eq!(lens("up = [0, 1, 0]").view, FieldOfView::Vertical(40.0));
}

#[test]
fn an_automatic_fit_covers_the_longer_side_as_blender_does() {
    let along = |keys: &str, film: FilmSize, side: usize| {
        let mut corner = Vec2::new(film[0] as f32 * 0.5, film[1] as f32 * 0.5);
        corner[side] = 0.0;
        let ray = camera(keys, film).ray(corner, CENTER).expect("a ray");
        on_plane(&ray, 1.0)[side].abs()
    };
    let auto = "focal_length = 50, sensor_width = 36, sensor_fit = \"auto\"";
    assert!((along(auto, [320, 180], 0) - 0.36).abs() < 1e-6);
    assert!((along(auto, [180, 320], 1) - 0.36).abs() < 1e-6);
    let both = "focal_length = 50, sensor_width = 36, sensor_height = 24";
    for (fit, side, tangent) in [("width", 0, 0.36), ("height", 1, 0.24)] {
        let keys = format!("{both}, sensor_fit = \"{fit}\"");
        assert!((along(&keys, [180, 320], side) - tangent).abs() < 1e-6, "{fit}");
    }
    // The fit of the scene holds for the sensor of a camera path.
    let path = LensOverrides {
        view: Some(FieldOfView::FocalLength(50.0)),
        sensor: Some(Sensor::Width(36.0)),
        ..LensOverrides::default()
    };
    let fitted = lens("fov = 40, sensor_fit = \"auto\"").with_overrides(&path, None);
    assert_eq!(fitted.sensor, Sensor::LongSide(36.0));
}

#[test]
fn the_vertical_angle_holds_for_every_aspect() {
    for film in [[100, 100], [1920, 1080], [90, 400]] {
        let top = camera("fov = 90", film)
            .ray(Vec2::new(film[0] as f32 * 0.5, 0.0), CENTER)
            .expect("a ray");
        assert!((on_plane(&top, 1.0) - DVec2::Y).length() < 1e-6);
    }
}

#[test]
fn a_positive_shift_shows_what_is_further_right_and_up() {
    let shifted = camera("fov = 90, shift = [0.25, 0.5]", [400, 200]);
    let middle = on_plane(&shifted.ray(Vec2::new(200.0, 100.0), CENTER).expect("a ray"), 1.0);
    // The picture is 4 wide at distance 1.
    assert!((middle - DVec2::new(1.0, 2.0)).length() < 1e-6);
}

#[test]
fn an_f_number_is_the_focal_length_over_the_diameter() {
    let radius = |keys: &str| {
        let Camera::Perspective(camera) = camera(keys, [300, 200]) else {
            unreachable!("it is a perspective camera")
        };
        camera.lens_radius
    };
    assert_eq!(radius("focal_length = 50, fstop = 2"), 0.0125);
    assert_eq!(radius("aperture_radius = 0.25"), 0.25);
    assert_eq!(radius("fov = 30"), 0.0);
    // The angle of a 50 mm lens before 24 mm.
    let fov = 2.0 * libm::atan(12.0 / 50.0).to_degrees();
    assert!((radius(&format!("fov = {fov}, fstop = 2")) - 0.0125).abs() < 1e-15);
}

#[test]
fn a_lens_without_a_distance_is_focused_on_the_target() {
    let scene = lens("aperture_radius = 0.1");
    assert_eq!(scene.focus, Focus::OnTarget(15.0));
    let silent = LensOverrides::default();
    assert_eq!(scene.with_overrides(&silent, Some(3.0)).focus, Focus::OnTarget(3.0));
    assert_eq!(scene.with_overrides(&silent, None).focus, Focus::OnTarget(15.0));
    let given = lens("focus_distance = 7");
    assert_eq!(given.with_overrides(&silent, Some(3.0)).focus, Focus::At(7.0));
}

#[test]
fn overrides_replace_what_they_say_and_leave_the_rest() {
    let scene = lens("focal_length = 50, sensor_width = 24, fstop = 4");
    let overrides = LensOverrides {
        view: Some(FieldOfView::FocalLength(35.0)),
        shift_y: Some(0.1),
        ..LensOverrides::default()
    };
    let want = PerspectiveLens {
        view: FieldOfView::FocalLength(35.0),
        shift: [0.0, 0.1],
        ..scene
    };
    assert_eq!(scene.with_overrides(&overrides, None), want);
}

#[test]
fn contradictions_are_reported_together_and_at_the_value() {
    let problems = compile("fov = 40, focal_length = 50, fstop = 2, aperture_radius = 0").unwrap_err();
    let messages: Vec<_> = problems.iter().map(|p| p.message.as_str()).collect();
    assert_eq!(
        messages,
        [
            "`focal_length` and `fov` are both given",
            "`fstop` and `aperture_radius` are both given"
        ]
    );
    let text = "[camera]\nperspective = { eye = [0, 0, 15], target = [0, 0, 0], fov = 40, focal_length = 50";
    assert_eq!(problems[0].span, Some(text.len() - 2..text.len()));

    let sensor = compile("fov = 40, sensor_width = 24").unwrap_err();
    assert_eq!(
        sensor[0].message,
        "`sensor_width` has no effect without `focal_length` or `fstop`"
    );
    let at_eye = describe("eye = [1, 2, 3], target = [1, 2, 3]").expect("well-formed");
    assert_eq!(at_eye.compile().unwrap_err()[0].message, "the target is at the eye");
}

#[test]
fn angles_lie_between_0_and_180() {
    let with = |fov: &str| describe(&format!("eye = [0, 0, 1], target = [0, 0, 0], fov = {fov}")).err();
    for fov in ["0", "180", "-3", "nan", "inf"] {
        let message = with(fov).expect("an error");
        let found = if fov == "nan" { "NaN" } else { fov };
        assert_eq!(
            message,
            format!("expected an angle above 0 and below 180 degrees, found {found}")
        );
    }
    assert_eq!(with("179.9"), None);
    assert!(describe("eye = [0, 0, 1], target = [0, 0, 0], fovy = 3").is_err());
}

proptest! {
    #[test]
    fn rays_of_a_thin_lens_meet_on_the_sharp_plane(x in 0.0_f32..320.0, y in 0.0_f32..180.0, u in 0.0_f32..1.0, v in 0.0_f32..1.0) {
        let thin = camera("fov = 50, aperture_radius = 0.5, focus_distance = 8", [320, 180]);
        let pinhole = camera("fov = 50", [320, 180]);
        let film = Vec2::new(x, y);
        let ray = thin.ray(film, Vec2::new(u, v)).expect("a ray");
        prop_assert!((on_plane(&ray, 8.0) - on_plane(&pinhole.ray(film, CENTER).expect("a ray"), 8.0)).length() < 1e-5);
        prop_assert!((ray.o - Vec3::new(0.0, 0.0, 15.0)).length() <= 0.5 + 1e-6);
        prop_assert!((ray.d.length() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn rays_are_those_of_the_textbook_in_double_precision() {
    let keys = "fov = 50, shift = [0.1, -0.2], aperture_radius = 0.3, focus_distance = 7";
    let desc = describe(&format!(
        "eye = [3, -2, 15], target = [1, 2, -4], up = [1, 5, 1], {keys}"
    ));
    let scene = desc.expect("well-formed").compile().expect("a camera");
    let (width, height) = (8192.0, 4320.0);
    let camera = Camera::new(&scene.pose, &scene.lens, [8192, 4320]);
    let pixel = 2.0 * libm::tan(25.0_f64.to_radians()) / height;
    for i in 0..2000_u32 {
        let [a, b, c, d] = crate::math::hash::pcg4d([i, 0, 0, 0]).map(crate::math::hash::unit_f32);
        let (film, u) = (Vec2::new(a * 8192.0, b * 4320.0), Vec2::new(c, d));
        let ray = camera.ray(film, u).expect("a ray");
        let x = (f64::from(film.x) - 0.5 * width) * pixel + 0.1 * width * pixel;
        let y = (0.5 * height - f64::from(film.y)) * pixel - 0.2 * width * pixel;
        let p = warp::square_to_disk(u).as_dvec2() * 0.3;
        let to_world = scene.pose.world_from_camera();
        let o = to_world.transform_point3(p.extend(0.0));
        let d = to_world.transform_vector3(DVec3::new(7.0 * x, 7.0 * y, -7.0) - p.extend(0.0));
        assert!((ray.d.as_dvec3() - d.normalize()).length() < 1e-7);
        assert!((ray.o.as_dvec3() - o).length() < 2e-6);
    }
}

#[test]
fn the_cone_of_a_pixel_opens_by_its_angle() {
    let cone = camera("fov = 90", [200, 100]).pixel_cone();
    assert_eq!((cone.width, cone.spread), (0.0, 0.02));
}

#[test]
fn blades_give_the_opening_corners() {
    let aperture_shape = |keys: &str| lens(keys).aperture_shape;
    assert_eq!(aperture_shape("blades = 0"), ApertureShape::Round);
    let (blades, rotation) = (6, std::f32::consts::FRAC_PI_2);
    assert_eq!(
        aperture_shape("blades = 6, blade_rotation = 90"),
        ApertureShape::Polygon { blades, rotation }
    );
    // The corner of a triangle at the right is reached, the disk at the left is not.
    let triangle = camera("aperture_radius = 1, blades = 3", [100, 100]);
    let middle = Vec2::splat(50.0);
    let origins = (0..400).map(|i| {
        let u = Vec2::new((i % 20) as f32 / 20.0, (i / 20) as f32 / 20.0 + 0.049);
        triangle.ray(middle, u).expect("a ray").o.x
    });
    let (least, most) = origins.fold((0.0_f32, 0.0_f32), |(a, b), x| (a.min(x), b.max(x)));
    assert!(most > 0.99 && (-0.5..-0.45).contains(&least), "{least} {most}");
    for (keys, message) in [
        (
            "blades = 2",
            "expected at least 3 blades, or 0 for a round opening, found 2",
        ),
        ("blade_rotation = 9", "`blade_rotation` has no effect without `blades`"),
    ] {
        assert_eq!(compile(keys).unwrap_err()[0].message, message);
    }
}

#[test]
fn many_rays_are_those_of_each_place() {
    for keys in ["fov = 40", "fov = 40, fstop = 2.8, focus_distance = 3"] {
        let camera = camera(keys, [64, 48]);
        let places: Vec<Vec2> = (0..333).map(|i| Vec2::new(i as f32 * 0.19, i as f32 * 0.14)).collect();
        let lens: Vec<Vec2> = places.iter().map(|p| (*p * 0.37).fract()).collect();
        let mut many = vec![Ray::NONE];
        camera.rays(Plain, &places, &lens, &mut many);
        let each = places.iter().zip(&lens).map(|(place, lens)| camera.ray(*place, *lens));
        assert!(many.iter().skip(1).copied().map(Some).eq(each));
    }
}
