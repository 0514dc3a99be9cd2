//! Every kind has a scene in `scenes/kinds`, which renders the same on any threads, and a manual page whose examples compile.

mod common;

use std::{fs, path::Path, sync::Arc};

use batch_render::{
    accel::AccelKind,
    camera::CameraDesc,
    compile,
    describe::{self, BackgroundDesc, Source},
    filter::FilterDesc,
    integrator::IntegratorDesc,
    light::LightDesc,
    material::MaterialDesc,
    sampler::SamplerDesc,
    shape::ShapeDesc,
    texture::{MappingDesc, PatternDesc},
};
use common::{Folder, repo};
use libtest_mimic::{Arguments, Failed, Trial};

/// The names of all kinds of all registries.
const REGISTRIES: [&[&str]; 10] = [
    ShapeDesc::NAMES,
    PatternDesc::NAMES,
    MappingDesc::NAMES,
    MaterialDesc::NAMES,
    LightDesc::NAMES,
    CameraDesc::NAMES,
    IntegratorDesc::NAMES,
    FilterDesc::NAMES,
    SamplerDesc::NAMES,
    BackgroundDesc::NAMES,
];

fn main() {
    let args = Arguments::from_args();
    let kinds = REGISTRIES.concat();
    let mut trials: Vec<Trial> = kinds
        .iter()
        .map(|&kind| Trial::test(format!("scene {kind}"), move || scene_renders(kind)))
        .collect();
    let known: Vec<String> = kinds.iter().map(|k| format!("{k}.toml")).collect();
    trials.push(Trial::test("no scene without a kind", move || {
        let stray: Vec<_> = common::names(&repo("scenes/kinds"))
            .into_iter()
            .filter(|n| n.ends_with(".toml") && !known.contains(n))
            .collect();
        if stray.is_empty() {
            Ok(())
        } else {
            Err(format!("{stray:?}").into())
        }
    }));
    for room in [
        "shape",
        "texture",
        "material",
        "light",
        "camera",
        "integrator",
        "sampler",
    ] {
        for file in common::names(&repo(&format!("src/{room}"))) {
            let path = format!("src/{room}/{file}");
            if path.ends_with(".rs") {
                trials.push(Trial::test(format!("manual {path}"), move || examples_compile(&path)));
            }
        }
    }
    libtest_mimic::run(&args, trials).exit();
}

fn scene_renders(kind: &str) -> Result<(), Failed> {
    let scene = repo(&format!("scenes/kinds/{kind}.toml"));
    let folder = Folder::new();
    let small = ["--resolution", "48x27", "--samples", "2", "--progress", "none"];
    // Pictures are cut into other tiles for more threads, and each thread renders several.
    for threads in ["1", "7"] {
        let (png, exr) = (format!("{threads}.png"), format!("{threads}.exr"));
        let files = ["--threads", threads, "-o", &png, "-o", &exr];
        let output = folder.program().arg(&scene).args(small).args(files).output()?;
        if !output.status.success() {
            return Err(common::stderr(&output).into());
        }
    }
    if folder.read("1.exr") != folder.read("7.exr") {
        return Err("seven threads make another picture than one".into());
    }
    let image = image::load_from_memory(&folder.read("1.png"))?.into_rgb8();
    let first = image.get_pixel(0, 0);
    if image.pixels().all(|p| p == first) {
        return Err("the picture is of one colour".into());
    }
    Ok(())
}

/// The TOML examples of a module's documentation, made whole.
fn examples_compile(path: &str) -> Result<(), Failed> {
    let text = fs::read_to_string(repo(path))?;
    let doc: String = text
        .lines()
        .map_while(|l| l.strip_prefix("//!"))
        .map(|l| format!("{}\n", l.strip_prefix(' ').unwrap_or(l)))
        .collect();
    for example in doc.split("```toml\n").skip(1) {
        let example = example.split("```").next().unwrap_or_default();
        let whole = match example.trim_start() {
            e if e.starts_with("shape.") => {
                format!("[material.m]\nmatte = {{ albedo = [1, 1, 1] }}\n[[object]]\nmaterial = \"m\"\n{e}")
            }
            e => e.to_owned(),
        };
        let source = Source {
            path: Path::new("example.toml").into(),
            text: Arc::from(whole.as_str()),
        };
        let desc = describe::parse(source).map_err(|e| format!("{e}\n{whole}"))?;
        match compile::scene(&desc, AccelKind::Linear) {
            Ok(_) | Err(compile::Error::Assets(_)) => {}
            Err(e) => return Err(format!("{e}\n{whole}").into()),
        }
    }
    Ok(())
}
