//! The coverage of a falling ball and of a spinning disk, which algebra gives along each camera ray, with every kind of camera.

use super::*;
use batch_render::math::{Ray, Vec2};

/// The camera rays of a pixel along each side.
const RAYS: u32 = 6;

const CAMERAS: [&str; 4] = [
    "perspective = { eye = [0.4, 0.3, 4], target = [0, 0, 0], fov = 50 }",
    "orthographic = { eye = [0.4, 0.3, 4], target = [0, 0, 0], height = 4 }",
    "panorama = { eye = [0, 0.2, 1.5], target = [0, 0, 0] }",
    "fisheye = { eye = [0, 0.2, 1.5], target = [0, 0, 0], fov = 150 }",
];

fn scene(camera: &str, shape: &str) -> String {
    format!(
        "[camera]\n{camera}\n[background]\ncolor = 0\nvisible = false\n[material.white]\n\
         emitter = {{ radiance = 1, two_sided = true }}\n[[object]]\nmaterial = \"white\"\nshape.{shape}\n"
    )
}

/// The mean of `coverage` over the rays of each pixel; nothing is where no ray is.
fn expected(stage: &Stage<'_>, coverage: impl Fn(DVec3, DVec3) -> f64) -> Vec<f32> {
    let camera = stage.camera.camera(0.0);
    let along = |ray: Ray| coverage(ray.o.as_dvec3(), ray.d.as_dvec3().normalize());
    let pixel = |i: u32| {
        let within = |n: u32, k: u32| n as f32 + (k as f32 + 0.5) / RAYS as f32;
        let rays = (0..RAYS * RAYS).map(|k| Vec2::new(within(i % SIDE, k % RAYS), within(i / SIDE, k / RAYS)));
        let sum: f64 = rays
            .filter_map(|film| camera.ray(film, Vec2::splat(0.5)))
            .map(along)
            .sum();
        (sum / f64::from(RAYS * RAYS)) as f32
    };
    (0..SIDE * SIDE).map(pixel).collect()
}

/// The largest difference of the means of blocks of eight by eight pixels.
fn difference(found: &[f32], expected: &[f32]) -> f32 {
    let blocks = |values: &[f32]| {
        let pixels: Vec<[f32; 4]> = values.iter().map(|v| [*v; 4]).collect();
        super::blocks(&pixels)
    };
    let (found, expected) = (blocks(found), blocks(expected));
    let pairs = found.iter().zip(&expected);
    pairs.map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f32::max)
}

fn alpha(film: &Film) -> Vec<f32> {
    film.beauty().iter().map(|pixel| pixel[3]).collect()
}

/// Compares a picture with what algebra says, and tells that a `wrong` coverage is far from it.
fn compare(camera: &str, stage: &Stage<'_>, right: &[f32], wrong: &[f32]) {
    let found = alpha(&stage.render());
    let away = difference(&found, right);
    assert!(away < 0.015, "{camera}: {away}");
    let sums = [&found, right].map(|values| values.iter().sum::<f32>());
    // The noise of the sum is about a hundredth of it.
    assert!((sums[0] / sums[1] - 1.0).abs() < 0.03, "{camera}: {sums:?}");
    let far = difference(&found, wrong);
    assert!(far > 0.04, "{camera}: {far}");
}

#[test]
fn a_falling_ball_is_where_its_parabola_says_with_every_camera() {
    const RADIUS: f64 = 0.4;
    let motion = |t: f64| vec![(ObjectId(0), moved(DVec3::Y * (0.8 - 1.6 * t * t)))];
    for camera in CAMERAS {
        let stage = Stage::new(
            &scene(camera, &format!("sphere = {{ radius = {RADIUS} }}")),
            64,
            &motion,
        );
        // The times between which the height of the ball is within those at which the ray touches it.
        let time_within = |o: DVec3, d: DVec3, passed: &dyn Fn(f64) -> f64| {
            let across = |v: DVec3| v - d * d.dot(v);
            let (e, w) = (across(DVec3::Y), across(o));
            let (a, b, c) = (e.dot(e), w.dot(e), w.dot(w) - RADIUS * RADIUS);
            let root = b * b - a * c;
            if root <= 0.0 || d.dot(o) > 0.0 {
                return 0.0;
            }
            let [low, high] = [-1.0, 1.0].map(|sign| (b + sign * root.sqrt()) / a);
            passed(low) - passed(high)
        };
        let falls = |height: f64| ((0.8 - height) / 1.6).clamp(0.0, 1.0).sqrt();
        let sinks = |height: f64| ((0.8 - height) / 1.6).clamp(0.0, 1.0);
        let right = expected(&stage, |o, d| time_within(o, d, &falls));
        let wrong = expected(&stage, |o, d| time_within(o, d, &sinks));
        compare(camera, &stage, &right, &wrong);
    }
}

#[test]
fn a_spinning_disk_covers_the_integral_of_its_turn_with_every_camera() {
    const RADIUS: f64 = 0.35;
    const AWAY: f64 = 0.7;
    let motion = |t: f64| vec![(ObjectId(0), turned(360.0 * t))];
    for camera in CAMERAS {
        let disk = format!("disk = {{ center = [{AWAY}, 0, 0], normal = [0, 0, 1], radius = {RADIUS} }}");
        let stage = Stage::new(&scene(camera, &disk), 64, &motion);
        // The part of the turn in which a point is within the disk.
        let turn = |r: f64| {
            let cosine = (r * r + AWAY * AWAY - RADIUS * RADIUS) / (2.0 * AWAY * r.max(1e-9));
            libm::acos(cosine.clamp(-1.0, 1.0)) / std::f64::consts::PI
        };
        let at = |o: DVec3, d: DVec3, part: &dyn Fn(f64) -> f64| {
            let s = -o.z / d.z;
            let p = o + d * s;
            if s > 0.0 { part(p.x.hypot(p.y)) } else { 0.0 }
        };
        let ring = |r: f64| {
            if (r - AWAY).abs() < RADIUS {
                0.5 * RADIUS / AWAY
            } else {
                0.0
            }
        };
        let right = expected(&stage, |o, d| at(o, d, &turn));
        let wrong = expected(&stage, |o, d| at(o, d, &|r| 1.6 * ring(r)));
        compare(camera, &stage, &right, &wrong);
    }
}
