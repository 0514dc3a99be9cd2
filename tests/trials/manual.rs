//! The manual of scene files, `docs/scene`, is the documentation of their tables and kinds, and its examples are true.
//!
//! With `BLESS=1` the pages are written anew: read the difference.

mod pages;
mod pictures;

use std::{collections::BTreeSet, fs, path::Path};

use crate::common::repo;
use batch_render::{
    accel::AccelKind,
    compile,
    describe::{self, Source},
    output::DisplayTransform,
};
use libtest_mimic::{Failed, Trial};
use pages::Page;

const FOLDER: &str = "docs/scene";

pub fn trials() -> Vec<Trial> {
    let pages = pages::pages();
    let files: Vec<String> = pages.iter().map(|p| p.file.clone()).collect();
    let texts: Vec<String> = pages.iter().map(|p| p.text.clone()).collect();
    let sources: Vec<String> = pages.iter().map(|p| p.source.clone()).collect();
    let mut trials = vec![
        trial!("no page without a table or a kind", move || no_stray_page(&files)),
        trial!("no example outside of the manual", move || no_stray_example(&sources)),
        trial!("the page of the output shows every view", every_view_is_shown),
        trial!("every kind has a picture", pictures::every_kind_has_one),
        trial!("pictures are small and are shown", move || {
            pictures::are_small_and_shown(&texts)
        }),
    ];
    for page in pages {
        // The index has no example of its own, and the table of a kind may leave it to the kind's page.
        let examples = examples(&page.text);
        if !examples.is_empty() || page.file.contains('/') {
            let name = format!("examples {}", page.file);
            trials.push(trial!(name, move || compile_all(&examples)));
        }
        trials.push(trial!(format!("page {}", page.file), move || is_written(&page)));
    }
    trials
}

/// Whether pages are written anew.
fn is_blessed() -> bool {
    std::env::var_os("BLESS").is_some()
}

/// Compares a page with its file, which is written anew before where that is wanted.
fn is_written(page: &Page) -> Result<(), Failed> {
    let path = repo(FOLDER).join(&page.file);
    if is_blessed() {
        fs::create_dir_all(path.parent().ok_or("a page without a folder")?)?;
        fs::write(&path, &page.text)?;
    }
    let found = fs::read_to_string(&path).unwrap_or_default();
    if found == page.text {
        return Ok(());
    }
    let hint = "BLESS=1 cargo test --test trials manual writes the page";
    Err(format!("{FOLDER}/{} differs from {}; {hint}", page.file, page.source).into())
}

fn no_stray_page(known: &[String]) -> Result<(), Failed> {
    let root = repo(FOLDER);
    let mut stray = Vec::new();
    for path in crate::common::files(&root) {
        let name = path.strip_prefix(&root)?.to_string_lossy().replace('\\', "/");
        if !known.contains(&name) && !name.starts_with(pictures::FOLDER) {
            stray.push(name);
        }
    }
    if stray.is_empty() {
        Ok(())
    } else {
        Err(format!("{stray:?}").into())
    }
}

/// An example that nobody compiles may be wrong.
fn no_stray_example(sources: &[String]) -> Result<(), Failed> {
    let all = crate::common::files(&repo("src"));
    for path in all.iter().filter(|path| path.extension().is_some_and(|e| e == "rs")) {
        let name = path.strip_prefix(repo(""))?.to_string_lossy().replace('\\', "/");
        let text = fs::read_to_string(path)?;
        let example = text
            .lines()
            .any(|line| line.starts_with("//") && line.ends_with(" ```toml"));
        if example && !sources.contains(&name) {
            return Err(format!("{name} has an example, but no page").into());
        }
    }
    Ok(())
}

/// The rows of the table of views are the views.
fn every_view_is_shown() -> Result<(), Failed> {
    let page = fs::read_to_string(repo(FOLDER).join("output.md"))?;
    let table = page.split("| view |").nth(1).ok_or("there is no table of views")?;
    let rows = table.lines().skip(2).map_while(|row| row.strip_prefix("| `\""));
    let shown: BTreeSet<&str> = rows.filter_map(|row| Some(row.split_once("\"` |")?.0)).collect();
    let known: BTreeSet<&str> = DisplayTransform::ALL.into_iter().map(DisplayTransform::name).collect();
    if shown == known {
        Ok(())
    } else {
        Err(format!("the page shows {shown:?}, the views are {known:?}").into())
    }
}

fn examples(text: &str) -> Vec<String> {
    let blocks = text.split("```toml\n").skip(1);
    blocks
        .map(|rest| rest.split("```").next().unwrap_or_default().to_owned())
        .collect()
}

/// Each example is a scene, but for the object around a shape and for files that are not there.
fn compile_all(examples: &[String]) -> Result<(), Failed> {
    if examples.is_empty() {
        return Err("there is no example".into());
    }
    for example in examples {
        let scene = match example.trim_start() {
            shape if shape.starts_with("shape.") => {
                format!("[material.m]\nmatte = {{ albedo = [1, 1, 1] }}\n[[object]]\nmaterial = \"m\"\n{shape}")
            }
            scene => scene.to_owned(),
        };
        let source = Source::new(Path::new("example.toml").into(), scene.as_str());
        let desc = describe::parse(source).map_err(|e| format!("{e}\n{scene}"))?;
        match compile::scene(&desc, AccelKind::Linear) {
            Ok(_) | Err(compile::Error::Assets(_)) => {}
            Err(e) => return Err(format!("{e}\n{scene}").into()),
        }
    }
    Ok(())
}
