//! Keys of objects that have no effect beside others: a warning says so, and only then.

use crate::{
    common::{Folder, stderr},
    parts::{HEAD, MODEL},
};

/// The lines of warnings about a scene with these objects.
fn warnings(objects: &str, args: &[&str]) -> Vec<String> {
    let folder = Folder::new();
    folder.write("car.gltf", MODEL);
    folder.write(
        "s.toml",
        &format!(
            "{HEAD}[material.wall]\nmatte = {{ albedo = 0.5 }}\n[material.lamp]\nemitter = {{ radiance = 2 }}\n\
             [material.paint]\nprincipled = {{ emissive_strength = 0 }}\n{objects}"
        ),
    );
    folder.write("v.csv", "frame,material.paint.principled.emissive_strength\n1,0\n2,3\n");
    let output = folder.run(&[&["check", "s.toml"], args].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    stderr(&output).lines().map(str::to_owned).collect()
}

/// An object of this shape with further keys.
fn object(name: &str, shape: &str, keys: &str) -> String {
    format!("[[object]]\nname = \"{name}\"\nshape.{shape}\n{keys}\n")
}

const BALL: &str = "sphere = { radius = 1 }";
const CAR: &str = "mesh = { file = \"car.gltf\" }";

#[test]
fn keys_without_an_effect_are_told() {
    let refined = |keys: &str| object("car", &CAR.replace(" }", &format!(", {keys} }}")), "");
    let cases = [
        (
            refined("crease_angle = 30"),
            "`crease_angle` has no effect, because the mesh has no `subdivide`",
        ),
        (
            refined("subdivide = 0, subdivision = \"linear\""),
            "`subdivision` has no effect, because the mesh has no `subdivide`",
        ),
        (
            refined("boundary = \"corners\""),
            "`boundary` has no effect, because the mesh has no `subdivide`",
        ),
        (
            object("car", CAR, "shadow_catcher = true\nray_visibility = { camera = false }"),
            "`shadow_catcher` has no effect, because the camera does not see it (`ray_visibility.camera = false`)",
        ),
        (
            object(
                "car",
                CAR,
                "ray_visibility = { camera = false }\n[[object.part]]\nnodes = [\"spare\"]\nholdout = true",
            ),
            "`holdout` has no effect, because the camera does not see it (`ray_visibility.camera = false`)",
        ),
        (
            object("car", BALL, "material = \"wall\"\ngroup = \"key\""),
            "`group` has no effect, because it emits no light",
        ),
        (
            object("car", BALL, "material = \"paint\"\ngroup = \"key\""),
            "`group` has no effect, because it emits no light",
        ),
        (
            object("car", CAR, "material = \"wall\"\ngroup = \"key\""),
            "`group` has no effect, because it emits no light",
        ),
        (
            object(
                "car",
                CAR,
                "nodes = [\"crowd\"]\n[[object.part]]\nnodes = [\"spare\"]\nmaterial = \"wall\"",
            ),
            "`part` has no effect, because `nodes` of the object and later parts leave it no node",
        ),
        (
            object(
                "car",
                CAR,
                "[[object.part]]\nnodes = [\"spare\"]\nmaterial = \"wall\"\n[[object.part]]\nnodes = [\"*\"]\nmaterial = \"wall\"",
            ),
            "`part` has no effect, because `nodes` of the object and later parts leave it no node",
        ),
    ];
    for (objects, expected) in cases {
        assert_eq!(
            warnings(&objects, &[]),
            [format!("warning: object `car`: {expected}")],
            "{objects}"
        );
    }
}

#[test]
fn a_backdrop_of_a_background_that_is_not_seen_is_told() {
    let ball = object("car", BALL, "material = \"wall\"");
    let backdrop = ["--set", "background.backdrop=0.2"];
    assert_eq!(warnings(&ball, &backdrop), [""; 0]);
    let expected = "warning: `backdrop` has no effect, because the background is not visible (`visible = false`)";
    let hidden = [&backdrop[..], &["--set", "background.visible=false"]].concat();
    assert_eq!(warnings(&ball, &hidden), [expected]);
}

#[test]
fn keys_with_an_effect_are_not() {
    for objects in [
        object("car", &CAR.replace(" }", ", subdivide = 1, crease_angle = 30 }"), ""),
        object("car", CAR, "shadow_catcher = true\nray_visibility = { shadow = false }"),
        object("car", BALL, "material = \"lamp\"\ngroup = \"key\""),
        // One of its materials glows.
        object("car", CAR, "group = \"key\""),
        object(
            "car",
            CAR,
            "group = \"key\"\n[object.material_overrides.Glow]\nemissive = 0",
        ),
        object(
            "car",
            CAR,
            "material = \"wall\"\n[[object.part]]\nnodes = [\"spare\"]\nmaterial = \"lamp\"\ngroup = \"key\"",
        ),
    ] {
        assert_eq!(warnings(&objects, &[]), [""; 0], "{objects}");
    }
    let paint = object("car", BALL, "material = \"paint\"\ngroup = \"key\"");
    assert_eq!(warnings(&paint, &["--values", "v.csv"]), [""; 0]);
}
