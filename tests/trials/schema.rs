//! The JSON Schema of scene files, `docs/schema/scene.json`, is what the types of descriptions ask for when they are read, with the texts of
//! the manual.
//!
//! With `BLESS=1` the file is written anew: read the difference.

mod probe;
mod validate;

use std::{collections::BTreeMap, fs, path::Path};

use batch_render::{
    camera::{CameraDesc, ReadoutDirection, Timing},
    describe::{BackgroundDesc, LightGroupName, ObjectDesc, OutputDesc, RenderDesc},
    light::LightDesc,
    material::{BumpDesc, MaterialDesc, NormalDesc},
    scene::BackFaces,
    shape::ShapeDesc,
    texture::{MappingDesc, PatternDesc, StTransformDesc, WarpDesc},
    value::{List, RgbFactor},
};
use libtest_mimic::{Failed, Trial};
use serde::Serialize;
use serde_json::{Serializer, Value, json, ser::PrettyFormatter};

use crate::common::{files, repo};
use probe::schema_of;
use validate::faults;

const FILE: &str = "docs/schema/scene.json";

pub fn trials() -> Vec<Trial> {
    vec![
        trial!("the file is that of the types", is_written),
        trial!("every scene is valid", every_scene_is_valid),
        trial!("faults of scenes are found", faults_are_found),
    ]
}

fn is_written() -> Result<(), Failed> {
    // A line for each value, and no indents: they are half of the text, which the program holds.
    let mut text = Vec::new();
    let lines = PrettyFormatter::with_indent(b"");
    schema().serialize(&mut Serializer::with_formatter(&mut text, lines))?;
    text.push(b'\n');
    let text = String::from_utf8(text)?;
    if std::env::var_os("BLESS").is_some() {
        fs::write(repo(FILE), &text)?;
    }
    match fs::read_to_string(repo(FILE)).unwrap_or_default() == text {
        true => Ok(()),
        false => {
            Err(format!("{FILE} differs from the types; BLESS=1 cargo test --test trials schema writes it").into())
        }
    }
}

/// A scene file as JSON.
fn scene(path: &Path) -> Result<Value, Failed> {
    let table: toml::Table = fs::read_to_string(path)?.parse()?;
    Ok(serde_json::to_value(table)?)
}

fn every_scene_is_valid() -> Result<(), Failed> {
    let schema = schema();
    let scenes = files(&repo("scenes"));
    let scenes: Vec<_> = scenes
        .iter()
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    assert!(scenes.len() > 30, "{scenes:?}");
    for path in scenes {
        let found = faults(&schema, &scene(path)?);
        if !found.is_empty() {
            return Err(format!("{}: {found:?}", path.display()).into());
        }
    }
    Ok(())
}

fn faults_are_found() -> Result<(), Failed> {
    let schema = schema();
    for (text, place) in [
        ("[render]\nwdith = 4", "/render/wdith"),
        (
            "[camera]\nperspective = { eye = [0, 0, 1], target = [0, 0, 0], fow = 40 }",
            "/camera/perspective/fow",
        ),
        (
            "[camera]\nperspective = { target = [0, 0, 0] }",
            "/camera/perspective/eye",
        ),
        ("[material.m]\nmatte = { albedo = true }", "/material/m/matte/albedo"),
        (
            "[[object]]\nshape.sphere = { radius = \"1\" }",
            "/object/0/shape/sphere/radius",
        ),
        ("[[object]]\nshape.ball = { radius = 1 }", "/object/0/shape/ball"),
        ("[output]\nview = \"film\"", "/output/view"),
        (
            "[[light]]\npoint = { position = [0, 1], intensity = 1 }",
            "/light/0/point/position",
        ),
        ("[lights]\na = 1", "/lights"),
    ] {
        let table: toml::Table = text.parse()?;
        let found = faults(&schema, &serde_json::to_value(table)?);
        if !found.iter().any(|fault| fault.starts_with(place)) {
            return Err(format!("{text}: {found:?}").into());
        }
    }
    Ok(())
}

/// The schema of a scene file.
fn schema() -> Value {
    let texture = kinds(
        schema_of::<PatternDesc>(),
        [
            ("mapping", or_word(schema_of::<MappingDesc>(), MappingDesc::NAMES)),
            ("transform", schema_of::<StTransformDesc>()),
            ("warp", schema_of::<WarpDesc>()),
            ("factor", schema_of::<RgbFactor>()),
        ],
    );
    let material = kinds(
        schema_of::<MaterialDesc>(),
        [
            ("back_faces", schema_of::<BackFaces>()),
            ("bump", schema_of::<BumpDesc>()),
            ("normal", schema_of::<NormalDesc>()),
        ],
    );
    let [shutter, readout, direction] = Timing::KEYS else {
        panic!("the keys of the timing have changed: {:?}", Timing::KEYS);
    };
    let camera = kinds(
        schema_of::<CameraDesc>(),
        [
            (shutter, schema_of::<List<f64, 2>>()),
            (readout, schema_of::<f64>()),
            (direction, schema_of::<ReadoutDirection>()),
        ],
    );
    let light = kinds(
        schema_of::<LightDesc>(),
        [
            ("name", schema_of::<String>()),
            ("group", schema_of::<LightGroupName>()),
        ],
    );
    let mut object = schema_of::<ObjectDesc>();
    // The keys that are read by hand, whose names are those of a model.
    object["properties"]["node"] = json!({ "type": "object", "additionalProperties": {
        "type": "object",
        "additionalProperties": false,
        "properties": { "visible": { "type": "boolean" }, "transform": { "type": "object" } },
    } });
    object["properties"]["material_overrides"] = json!({ "type": "object" });
    let mut scene = json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "A scene file of batch-render",
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "values": { "type": "string" },
            "render": schema_of::<RenderDesc>(),
            "camera": camera,
            "background": schema_of::<BackgroundDesc>(),
            "texture": { "type": "object", "additionalProperties": or_word(texture, PatternDesc::NAMES) },
            "material": { "type": "object", "additionalProperties": or_word(material, MaterialDesc::NAMES) },
            "object": { "type": "array", "items": object },
            "light": { "type": "array", "items": light },
            "random": random(),
            "output": schema_of::<OutputDesc>(),
        },
    });
    describe(&mut scene);
    scene
}

/// The schema of distributions, which are read by hand: by names of values, or by tables of these.
fn random() -> Value {
    json!({
        "type": "object",
        "properties": { "seed": { "type": "integer" }, "scene": { "type": "string" } },
        "additionalProperties": { "anyOf": [{ "type": "array" }, { "type": "object" }] },
    })
}

/// The schema of a table that names one kind, with keys beside it.
fn kinds<const N: usize>(mut kinds: Value, beside: [(&str, Value); N]) -> Value {
    for (key, schema) in beside {
        kinds["properties"][key] = schema;
    }
    kinds
}

/// The same, or the name of a kind alone.
fn or_word(schema: Value, names: &[&str]) -> Value {
    json!({ "anyOf": [schema, { "enum": names }] })
}

/// The pages of the manual, and where the schemas of their tables are.
fn pages() -> Vec<(String, Vec<String>)> {
    let path = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
    let mut pages: Vec<(String, Vec<String>)> = ["render", "camera", "background", "random", "output"]
        .map(|name| (name.to_owned(), path(name)))
        .into();
    let entries = [
        ("texture", "texture *"),
        ("material", "material *"),
        ("object", "object *"),
        ("light", "light *"),
    ];
    pages.extend(entries.map(|(page, entry)| (page.to_owned(), path(entry))));
    let of_kinds = [
        (
            "integrator",
            "render integrator",
            &["path", "whitted", "cost", "occlusion"][..],
        ),
        ("camera", "camera", CameraDesc::NAMES),
        ("background", "background", BackgroundDesc::NAMES),
        ("texture", "texture *", PatternDesc::NAMES),
        ("material", "material *", MaterialDesc::NAMES),
        ("shape", "object * shape", ShapeDesc::NAMES),
        ("light", "light *", LightDesc::NAMES),
    ];
    for (folder, table, kinds) in of_kinds {
        pages.extend(
            kinds
                .iter()
                .map(|kind| (format!("{folder}/{kind}"), path(&format!("{table} {kind}")))),
        );
    }
    pages.push(("transform".to_owned(), path("texture * transform")));
    pages
}

/// Adds what the manual says of each key, and which keys are required.
fn describe(scene: &mut Value) {
    for (page, path) in pages() {
        let text = fs::read_to_string(repo(&format!("docs/scene/{page}.md"))).unwrap_or_default();
        let rows = rows(&text);
        each_at(scene, &path, &mut |table| {
            let mut required = Vec::new();
            for (key, (description, is_required)) in &rows {
                let Some(schema) = table["properties"].get_mut(key) else {
                    continue;
                };
                schema["description"] = json!(description);
                required.extend(is_required.then_some(key));
            }
            if !required.is_empty() {
                table["required"] = json!(required);
            }
        });
    }
}

/// Returns the description of each key in the tables of a page, and whether it is required.
fn rows(page: &str) -> BTreeMap<String, (String, bool)> {
    let mut rows = BTreeMap::new();
    let mut columns = Vec::new();
    for line in page.lines() {
        let Some(line) = line.strip_prefix("| ") else {
            if !line.starts_with("|---") {
                columns.clear();
            }
            continue;
        };
        let cells: Vec<&str> = line.trim_end_matches('|').split(" |").map(str::trim).collect();
        if columns.is_empty() {
            columns = cells;
            continue;
        }
        if columns[0] != "key" {
            continue;
        }
        let cell = |name: &str| {
            let at = columns.iter().position(|column| *column == name);
            at.and_then(|at| cells.get(at)).copied().unwrap_or_default()
        };
        let with = |before: &str, cell: &str| {
            if cell.is_empty() {
                String::new()
            } else {
                format!("{before}{cell}")
            }
        };
        let default = cell("default");
        let stated = if default == "required" { "" } else { default };
        let about = format!(
            "{}{}{}",
            cell("type"),
            with(", in ", cell("unit")),
            with("; default: ", stated)
        )
        .replace('`', "");
        for key in cells[0].split(", ") {
            let key = key.trim_matches('`').to_owned();
            rows.entry(key)
                .or_insert_with(|| (about.clone(), default == "required"));
        }
    }
    rows
}

/// Calls `change` for each table at a path of keys, in which `*` is any key of a table or a list.
fn each_at(schema: &mut Value, path: &[String], change: &mut dyn FnMut(&mut Value)) {
    if let Some(choices) = schema.get_mut("anyOf").and_then(Value::as_array_mut) {
        choices.iter_mut().for_each(|choice| each_at(choice, path, change));
        return;
    }
    let Some((first, rest)) = path.split_first() else {
        if schema.get("properties").is_some() {
            change(schema);
        }
        return;
    };
    let inner = match first.as_str() {
        "*" if schema.get("items").is_some() => schema.get_mut("items"),
        "*" => schema.get_mut("additionalProperties"),
        key => schema
            .get_mut("properties")
            .and_then(|properties| properties.get_mut(key)),
    };
    if let Some(inner) = inner {
        each_at(inner, rest, change);
    }
}
