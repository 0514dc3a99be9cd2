//! Words of other programs' scenes, and what this program's scene files say instead.

/// Names of kinds in other programs, a kind of the table that takes their place, and how it is written.
const KINDS: &[(&[&str], &str, &str)] = &[
    (
        &["box", "cube"],
        "cuboid",
        "write shape.cuboid = { min = [-1, -1, -1], max = [1, 1, 1] }",
    ),
    (
        &["rectangle", "parallelogram", "polygon"],
        "quad",
        "write shape.quad = { corners = [..] } with four points",
    ),
    (
        &["obj", "ply", "stl", "gltf", "glb", "trianglemesh", "model"],
        "mesh",
        "write shape.mesh = { file = \"model.obj\" }",
    ),
    (
        &["torus", "blob", "sor", "lathe", "prism", "heightfield", "curve"],
        "mesh",
        "export it as a mesh, and write shape.mesh = { file = \"model.obj\" }",
    ),
    (
        &["diffuse", "lambertian", "lambert", "roughdiffuse"],
        "matte",
        "write matte = { albedo = [r, g, b] }",
    ),
    (
        &["dielectric", "roughdielectric", "thindielectric", "refraction"],
        "glass",
        "write glass = { .. }",
    ),
    (
        &["conductor", "roughconductor", "glossy"],
        "metal",
        "write metal = { preset = \"gold\", roughness = 0.2 }, or `mirror` for a perfect one",
    ),
    (
        &[
            "plastic",
            "roughplastic",
            "disney",
            "bsdf",
            "pbr",
            "standard",
            "coateddiffuse",
        ],
        "principled",
        "write principled = { base_color = [r, g, b], roughness = 0.5 }",
    ),
    (
        &["emission", "emissive", "light", "area"],
        "emitter",
        "write emitter = { radiance = [r, g, b] }",
    ),
    (
        &["pigment", "texture", "finish"],
        "phong",
        "write one of `matte`, `phong` and `principled`; a colour can be \"texture.NAME\"",
    ),
    (
        &["area", "quad", "rectangle"],
        "rect",
        "write rect = { position = [x, y, z], target = [x, y, z], size = [w, h], power = 60 }",
    ),
    (
        &["cylinder", "line", "linear"],
        "tube",
        "write tube = { from = [x, y, z], to = [x, y, z], radius = 0.02, power = 36 }",
    ),
    (
        &["mesh"],
        "point",
        "a mesh that shines is an object whose material is an `emitter`",
    ),
    (
        &["directional", "distant", "parallel"],
        "sun",
        "write sun = { direction = [x, y, z], irradiance = 3 }",
    ),
    (
        &["constant", "environment", "envmap", "infinite", "dome", "sky", "hdri"],
        "sun",
        "light from all around is the table [background]: `color`, `environment` or `sky`",
    ),
    (
        &["thinlens", "lens", "persp", "realistic"],
        "perspective",
        "write perspective = { .. }; its lens has `focal_length` in mm, `fstop` and `focus_distance`",
    ),
    (
        &["spherical", "equirectangular", "panoramic", "environment"],
        "panorama",
        "write panorama = { .. }",
    ),
    (
        &["pathtracer", "pt", "cycles", "volpath", "bdpt"],
        "path",
        "write integrator = \"path\"",
    ),
    (
        &["gauss", "lanczos", "catmullrom", "triangle"],
        "blackman-harris",
        "write filter = \"gaussian\", or leave it out",
    ),
    (
        &["halton", "stratified", "multijitter", "ldsampler", "random"],
        "sobol",
        "leave it out: the sampler only changes the noise",
    ),
];

/// Keys of other programs, and the key of this one that takes their place where a table has it.
const KEYS: &[(&[&str], &str)] = &[
    (&["lens", "focal", "focalLength"], "focal_length"),
    (&["angle", "field_of_view"], "fov"),
    (&["location", "origin", "from", "position"], "eye"),
    (&["look_at", "lookat", "at", "to"], "target"),
    (&["sky"], "up"),
    (&["fnumber", "f_stop", "aperture_fstop"], "fstop"),
    (&["location", "from", "origin"], "position"),
    (&["color", "rgb", "base_color", "reflectance", "diffuse"], "albedo"),
    (&["color", "albedo", "rgb", "diffuse"], "base_color"),
    (&["int_ior", "ior", "ext_ior"], "eta"),
    (&["eta", "int_ior"], "ior"),
    (&["energy", "power", "strength", "color"], "intensity"),
    (&["energy", "strength", "intensity", "color"], "irradiance"),
    (&["energy", "strength", "intensity", "color"], "radiance"),
    (&["to_world", "matrix_world"], "transform"),
    (&["location", "position", "offset"], "translate"),
    (&["rotation", "rotation_euler"], "rotate"),
    (
        &["location", "position", "rotation", "rotate", "translate", "scale"],
        "transform",
    ),
    (&["filename", "filepath", "path"], "file"),
    (&["bsdf", "texture"], "material"),
    (&["spp", "sample_count"], "samples"),
    (
        &[
            "two_sided",
            "twosided",
            "double_sided",
            "doubleSided",
            "one_sided",
            "sides",
            "backface_culling",
            "use_backface_culling",
        ],
        "back_faces",
    ),
    (&["resolution", "size", "resolution_x"], "width"),
];

/// Keys of an object that one looks for in its `shape.mesh`.
const OF_OBJECT: [&str; 5] = ["nodes", "node", "part", "material", "material_overrides"];

/// The help for a name that is not among the `known` ones, if another program has it.
pub(super) fn help(name: &str, known: &[&str]) -> Option<String> {
    let kind = KINDS
        .iter()
        .find(|(names, kind, _)| names.contains(&name) && known.contains(kind));
    if known.contains(&"subdivide") && OF_OBJECT.contains(&name) {
        return Some(format!("write `{name}` beside `shape`: it is a key of [[object]]"));
    }
    let key = || {
        let key = KEYS
            .iter()
            .find(|(names, key)| names.contains(&name) && known.contains(key));
        key.map(|(_, key)| match *key {
            "transform" => "write transform = { translate = [x, y, z] }".to_owned(),
            "back_faces" => "write `back_faces`: \"shaded\", \"black\" or \"culled\"".to_owned(),
            key => format!("write `{key}`"),
        })
    };
    kind.map(|(_, _, help)| (*help).to_owned()).or_else(key)
}

/// The help for the tables `what`, of which a file has one, or a list, or one for each name.
pub(super) fn table_help(what: &str) -> Option<String> {
    match what {
        "object" | "light" => Some(format!("write [[{what}]]: each {what} has its own, with two brackets")),
        "camera" => Some("write [camera]: a scene has one camera, which a camera path (--frames) moves".to_owned()),
        "material" | "texture" => Some(format!("write [{what}.NAME]: objects and colours use it by its name")),
        "render" | "output" | "background" => Some(format!("write [{what}]: a scene has one")),
        _ => None,
    }
}

/// The help for a line with a syntax error that has a decimal comma.
pub(super) fn decimal_comma(line: &str) -> Option<String> {
    line.match_indices(',').find_map(|(at, _)| {
        let whole = line[..at].rsplit_once('=')?.1.trim();
        let fraction = line[at + 1..].split(|c: char| !c.is_ascii_digit()).next()?;
        let is_number = whole.parse::<i64>().is_ok() && !fraction.is_empty();
        is_number.then(|| format!("the decimal point is a dot: {whole}.{fraction}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_help_names_a_kind_that_there_is() {
        let tables = crate::describe::kind_tables::all();
        for (names, kind, _) in KINDS {
            let table = tables.iter().find(|kinds| kinds.contains(kind));
            let table = table.unwrap_or_else(|| panic!("there is no kind {kind}"));
            assert!(names.iter().all(|name| !table.contains(name)), "{names:?}");
            assert!(help(names[0], table).is_some());
        }
    }

    #[test]
    fn a_decimal_comma_is_found_in_numbers_alone() {
        let found = |line| decimal_comma(line);
        assert_eq!(found("fov = 40,5").as_deref(), Some("the decimal point is a dot: 40.5"));
        assert_eq!(
            found("{ eye = [0, 0], fov = -4,25 }").as_deref(),
            Some("the decimal point is a dot: -4.25")
        );
        assert!(
            ["a = [1,2", "a = 1, b", "1,2", "a = ,2", ""]
                .into_iter()
                .all(|line| found(line).is_none())
        );
    }
}
