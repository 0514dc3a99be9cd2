//! Errors in scene files about shapes, with their messages.

use serde::Deserialize;

use crate::{math::DVec3, shape::ShapeDesc, value::Problem};

#[derive(Deserialize)]
struct Object {
    shape: ShapeDesc,
}

/// The problem, and the text it points to.
fn problem(text: &str) -> (Problem, String) {
    let file = format!("shape.{text}\n");
    let object: Object = toml::from_str(&file).unwrap();
    let problem = object.shape.compile(DVec3::ZERO).unwrap_err();
    let place = file[problem.span.clone().unwrap()].to_owned();
    (problem, place)
}

fn refused(text: &str, message: &str, help: &str, place: &str) {
    let (problem, at) = problem(text);
    assert_eq!(problem.message, message);
    assert_eq!(problem.help.as_deref(), Some(help));
    assert_eq!(at, place);
}

/// The message of a description that cannot even be read.
fn unreadable(text: &str) -> String {
    let read = toml::from_str::<Object>(&format!("shape.{text}\n"));
    read.map(|o| o.shape).unwrap_err().message().to_owned()
}

#[test]
fn quads_without_area_are_refused() {
    let message = "the corners are on one line or in one point: the quad has no area";
    let help = "give four corners of a convex quadrilateral";
    for corners in [
        "[[1, 2, 3], [1, 2, 3], [1, 2, 3], [1, 2, 3]]",
        "[[0, 0, 0], [1, 2, 3], [2, 4, 6], [3, 6, 9]]",
        "[[0.1, 0.1, 0.1], [0.2, 0.2, 0.2], [0.3, 0.3, 0.3], [0.7, 0.7, 0.7]]",
        "[[0, 0, 0], [1, 0, 0], [0, 0, 0], [1, 0, 0]]",
    ] {
        refused(&format!("quad = {{ corners = {corners} }}"), message, help, corners);
    }
}

#[test]
fn quads_that_are_not_convex_are_refused() {
    let message = "the corners make a dent or cross each other";
    let help = "give the corners of a convex quadrilateral, in order around it";
    for corners in [
        // Crossed, in both ways, then a dent at each corner.
        "[[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]]",
        "[[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]",
        "[[0.2, 0.2, 0], [0, 1, 0], [0, 0, 0], [1, 0, 0]]",
        "[[1, 0, 0], [0.2, 0.2, 0], [0, 1, 0], [0, 0, 0]]",
        "[[0, 0, 0], [1, 0, 0], [0.2, 0.2, 0], [0, 1, 0]]",
        "[[0, 1, 0], [0, 0, 0], [1, 0, 0], [0.2, 0.2, 0]]",
    ] {
        refused(&format!("quad = {{ corners = {corners} }}"), message, help, corners);
    }
}

#[test]
fn quads_out_of_a_plane_are_refused_beyond_the_tolerance() {
    let with = |z: f64| format!("quad = {{ corners = [[0, 0, 0], [3, 0, 0], [3, 4, {z}], [0, 4, 0]] }}");
    refused(
        &with(0.5),
        "the corners are not in a plane: they are 2.47 % of the quad's size off it",
        "move them into a plane, or use a mesh of two triangles",
        "[[0, 0, 0], [3, 0, 0], [3, 4, 0.5], [0, 4, 0]]",
    );
    // One corner a quarter as far off the middle plane as it is off that of the other three.
    let compiles = |text: &str| {
        let object: Object = toml::from_str(&format!("shape.{text}\n")).unwrap();
        object.shape.compile(DVec3::ZERO).is_ok()
    };
    // A tilted quad of 20 cm, at 30 km, where numbers are 2 mm apart.
    assert!(compiles(
        "quad = { corners = [[30000.1, 20000.3, 0.07], [30000.27, 20000.38, 0.14], [30000.22, 20000.54, 0.08], [30000.05, 20000.46, 0.01]] }"
    ));
    assert!(compiles(&with(5.0 * 3.9e-4)));
    assert!(!compiles(&with(5.0 * 4.1e-4)));
}

#[test]
fn cuboids_without_extent_or_inside_out_are_refused() {
    refused(
        "cuboid = { min = [0, 0, 0], max = [1, -2, 1] }",
        "`max` has y = -2, below the 0 of `min`",
        "swap the two numbers",
        "[1, -2, 1]",
    );
    refused(
        "cuboid = { min = [0, 0, 0.5], max = [1, 2, 0.5] }",
        "a cuboid without extent along z: both `min` and `max` have 0.5",
        "for a flat rectangle, take `shape.quad`",
        "[1, 2, 0.5]",
    );
}

#[test]
fn one_sided_walls_with_caps_are_refused() {
    for kind in ["cylinder", "cone"] {
        refused(
            &format!("{kind} = {{ radius = 1, height = 2, outside_only = true }}"),
            "`outside_only` is for open walls, and this one has caps",
            "add `caps = false`",
            "true",
        );
    }
    let object: Object = toml::from_str("shape.cone = { radius = 1, height = 2, outside_only = false }").unwrap();
    assert!(object.shape.compile(DVec3::ZERO).is_ok());
}

#[test]
fn values_that_make_no_sense_are_refused_as_they_are_read() {
    for (text, message) in [
        ("sphere = { radius = 0 }", "expected a number above 0, found 0"),
        ("sphere = { radius = -1 }", "expected a number above 0, found -1"),
        ("sphere = { radius = 1e-60 }", "expected a number above 0, found 0"),
        ("sphere = { radius = inf }", "expected a finite number, found inf"),
        ("sphere = {}", "missing field `radius`"),
        (
            "sphere = { radus = 1 }",
            "unknown field `radus`, expected `center` or `radius`",
        ),
        (
            "disk = { radius = 1, normal = [0, 0, 0] }",
            "expected a direction, found a vector of length 0",
        ),
        (
            "cylinder = { radius = 1, height = 0 }",
            "expected a number above 0, found 0",
        ),
        (
            "cone = { radius = 1, height = 1, cap = true }",
            "unknown field `cap`, expected one of `base`, `axis`, `radius`, `height`, `caps`, `outside_only`",
        ),
        ("plane = { point = [0, nan, 0] }", "expected a finite number, found NaN"),
        ("cuboid = { min = [0, 0, 0] }", "missing field `max`"),
        (
            "quad = { corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0]] }",
            "invalid length 3, expected an array of length 4",
        ),
    ] {
        assert_eq!(unreadable(text), message, "{text}");
    }
    let known = ShapeDesc::NAMES.join("`, `");
    assert_eq!(
        unreadable("ball = { radius = 1 }"),
        format!("unknown variant `ball`, expected one of `{known}`")
    );
}
