//! A kind is named by its own file and its table alone.

use super::{code, files};

/// The tables: their files, the macros that read them or the enums that they are, and the names of the enums.
const TABLES: [(&str, &str, &[&str]); 11] = [
    ("src/shape/mod.rs", "kinds! {", &["Shape", "ShapeDesc"]),
    ("src/texture/mod.rs", "kinds! {", &["Pattern", "PatternDesc"]),
    ("src/material/mod.rs", "kinds! {", &["Material", "MaterialDesc"]),
    ("src/light/mod.rs", "kinds! {", &["Light", "LightDesc"]),
    ("src/camera/mod.rs", "\ncameras! {", &["Camera", "CameraDesc", "Lens"]),
    ("src/integrator/mod.rs", "kinds! {", &["BuiltIn", "IntegratorDesc"]),
    ("src/bsdf/mod.rs", "\nbsdfs! {", &["Bsdf"]),
    ("src/sampler/mod.rs", "kinds! {", &["Sampler", "SamplerDesc"]),
    ("src/filter.rs", "\npub enum FilterDesc {", &["FilterDesc"]),
    (
        "src/texture/mapping.rs",
        "\npub enum Mapping {",
        &["Mapping", "MappingDesc"],
    ),
    (
        "src/scene/background.rs",
        "\npub enum BackgroundRadiance {",
        &["BackgroundRadiance"],
    ),
];

/// Files that may name kinds of an enum, and why.
const EXCEPTIONS: [(&str, &str, &str); 9] = [
    ("src/material/", "Bsdf", "a material chooses the BSDF of its surfaces"),
    (
        "src/compile/default_scene/camera.rs",
        "CameraDesc",
        "a model without a scene gets a camera",
    ),
    (
        "src/compile/model_lights.rs",
        "LightDesc",
        "lights of models become lights of scenes",
    ),
    (
        "src/compile/materials.rs",
        "Material",
        "materials of models become materials of scenes",
    ),
    (
        "src/compile/materials.rs",
        "Pattern",
        "images of models become textures of scenes",
    ),
    (
        "src/compile/objects.rs",
        "ShapeDesc",
        "a mesh has no compiled form and is read from a file",
    ),
    ("src/compile/points.rs", "Shape", "points of models are small spheres"),
    (
        "src/compile/materials.rs",
        "Mapping",
        "meshes of models have one or two sets of texture coordinates",
    ),
    (
        "src/compile/background.rs",
        "BackgroundRadiance",
        "a scene file names a colour or an environment",
    ),
];

/// The variants of a table or an enum, each with the module of its kind.
fn rows(table: &str, is_enum: bool) -> Vec<(String, String)> {
    let word = |text: &str| {
        text.chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect::<String>()
    };
    let mut rows = Vec::new();
    for line in table.lines().take_while(|line| !line.starts_with('}')) {
        // The kinds of an enum are those of its own file.
        let own = line
            .strip_prefix("    ")
            .map(word)
            .filter(|name| name.starts_with(char::is_uppercase));
        if let (true, Some(variant)) = (is_enum, own) {
            rows.push((variant, String::new()));
            continue;
        }
        let line = line.trim_start();
        let row = line.split_once("=> ").map_or(line, |(_, row)| row);
        let Some((variant, kind)) = row.split_once('(') else {
            continue;
        };
        let is_variant = variant.starts_with(char::is_uppercase) && variant.chars().all(char::is_alphanumeric);
        if is_variant && kind.contains("::") {
            rows.push((variant.to_owned(), word(kind)));
        }
    }
    rows
}

#[test]
fn kinds_are_named_by_their_own_files_and_tables_alone() {
    let files = files(&["src"]);
    let mut wrong = Vec::new();
    let mut used = [false; EXCEPTIONS.len()];
    for (table, start, enums) in TABLES {
        let text = &files[table];
        let (_, body) = text.split_once(start).expect("a table");
        let rows = rows(body, start.contains("enum"));
        assert!(rows.len() > 1, "{table} has {} rows", rows.len());
        for (file, text) in &files {
            if file == table || file.contains("/tests") || file.contains("/battery/") {
                continue;
            }
            let body = code(text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default());
            for (name, (variant, module)) in enums.iter().flat_map(|e| rows.iter().map(move |r| (e, r))) {
                let path = format!("{name}::{variant}");
                let is_named = body.match_indices(&path).any(|(at, _)| {
                    let is_word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
                    !is_word(body[..at].chars().next_back()) && !is_word(body[at + path.len()..].chars().next())
                });
                let own = format!("{}/{module}", table.trim_end_matches("/mod.rs"));
                let is_own = [format!("{own}.rs"), format!("{own}/")]
                    .iter()
                    .any(|own| file.starts_with(own));
                if !is_named || is_own {
                    continue;
                }
                match EXCEPTIONS.iter().position(|(f, e, _)| file.starts_with(f) && e == name) {
                    Some(i) => used[i] = true,
                    None => wrong.push(format!(
                        "{file} names {path}: let the kind answer by a method of its trait"
                    )),
                }
            }
        }
    }
    for (_, (file, name, _)) in used.iter().zip(EXCEPTIONS).filter(|(used, _)| !**used) {
        wrong.push(format!("{file} no longer names a `{name}`: remove the exception"));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
