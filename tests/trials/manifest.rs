//! Every file of a folder of real models does what the folder's manifest expects of it.
//!
//! The folder is the one that `BATCH_RENDER_ASSETS` names; without it the test is ignored. `MANIFEST.md` there has tables with
//! the columns `file` and `expect` under headings that name the folder of the files.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use crate::common::{Folder, stderr};
use libtest_mimic::{Failed, Trial};
use rayon::prelude::*;

/// Expectations that the specifications do not bear out, each with the reason.
const ARGUED: &[(&str, &str)] = &[
    (
        "CubeNoBuffer.glb",
        "a GLB needs no binary chunk if its buffers are data URIs (glTF 2.0, section 4.4.3)",
    ),
    ("white space.gltf", "it has no mesh: its picture is the background"),
    (
        "issue-356-leading-spaces-newmtl.obj",
        "it has no face: its picture is the background",
    ),
    ("line-prim.obj", "it has lines alone: its picture is the background"),
    ("lines.obj", "it has lines alone: its picture is the background"),
    ("points-prim.obj", "it has points alone: its picture is the background"),
];

/// The time in which a file must be loaded and rendered, on a machine that does other things too.
const MAX_TIME: Duration = Duration::from_secs(10);

pub fn trials() -> Vec<Trial> {
    let trial = asset_trial!("the manifest of real models holds", &["MANIFEST.md"], walk);
    vec![trial]
}

/// The files of the manifest with what is expected of each.
fn entries(folder: &Path) -> Vec<(PathBuf, String)> {
    let text = fs::read_to_string(folder.join("MANIFEST.md")).expect("a manifest");
    let (mut section, mut columns, mut entries) = (PathBuf::new(), Vec::new(), Vec::new());
    for line in text.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            section = heading.split_whitespace().next().unwrap_or_default().into();
            columns.clear();
        }
        if !line.starts_with('|') || line.starts_with("|---") {
            continue;
        }
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        if cells[0] == "file" {
            columns = cells.iter().map(|c| (*c).to_owned()).collect();
        } else if let Some(expect) = columns.iter().position(|c| c == "expect") {
            let file = folder.join(&section).join(cells[0]);
            entries.push((file, cells.get(expect).copied().unwrap_or_default().to_owned()));
        }
    }
    entries
}

fn walk(folder: &Path) -> Result<(), Failed> {
    let models = ["gltf", "glb", "obj"];
    let is_model = |path: &Path| {
        path.extension()
            .is_some_and(|e| models.iter().any(|m| e.eq_ignore_ascii_case(m)))
    };
    let entries: Vec<_> = entries(folder).into_iter().filter(|(file, _)| is_model(file)).collect();
    if entries.is_empty() {
        return Err("the manifest names no model".into());
    }
    let outcomes: Vec<_> = entries
        .par_iter()
        .map(|(file, expect)| (file, expect, outcome(file, expect)))
        .collect();
    let (mut counts, mut wrong) = (BTreeMap::<String, usize>::new(), Vec::new());
    for (file, expect, outcome) in outcomes {
        let (word, problem) = match outcome {
            Ok(word) => (word, None),
            Err(problem) => ("wrong", Some(problem)),
        };
        let class = expect.split([':', '(', ' ']).next().unwrap_or_default();
        *counts.entry(format!("{class}: {word}")).or_default() += 1;
        if let Some(problem) = problem {
            wrong.push(format!("{} ({expect}): {problem}", file.display()));
        }
    }
    for (what, count) in counts {
        println!("{count:5} {what}");
    }
    if wrong.is_empty() {
        Ok(())
    } else {
        Err(wrong.join("\n").into())
    }
}

/// The outcome of a file, or the reason why it is wrong.
fn outcome(file: &Path, expect: &str) -> Result<&'static str, String> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let is_argued = ARGUED.iter().any(|(argued, _)| *argued == name);
    let folder = Folder::new();
    let start = Instant::now();
    let output = folder.run(&[
        &file.to_string_lossy(),
        "--resolution",
        "64x64",
        "--samples",
        "1",
        "--threads",
        "1",
        "--max-memory",
        "2G",
        "--progress",
        "none",
        "-o",
        "f.exr",
    ]);
    if start.elapsed() > MAX_TIME {
        return Err(format!("it took {:?}", start.elapsed()));
    }
    let said = stderr(&output);
    match output.status.code() {
        Some(0) => {
            let pixels = crate::common::pixels(&folder.path("f.exr")).1;
            if pixels.iter().flatten().any(|v| !v.is_finite()) {
                return Err("its picture has numbers that are not finite".into());
            }
            let is_constant = pixels.iter().all(|p| *p == pixels[0]);
            rendered(expect, is_argued, is_constant, &said)
        }
        Some(65 | 66) if !said.contains(&*file.to_string_lossy()) => Err(format!("the message names no file: {said}")),
        Some(65 | 66) if expect == "LOAD" => Err(said),
        Some(65 | 66) => Ok("refused"),
        code => Err(format!("exit code {code:?}: {said}")),
    }
}

fn rendered(expect: &str, is_argued: bool, is_constant: bool, said: &str) -> Result<&'static str, String> {
    if is_argued {
        return Ok("argued");
    }
    // Those that fit the file; that nothing is seen fits any.
    let fits = |line: &&str| line.starts_with("warning: ") && !line.contains("there is nothing to see");
    match expect {
        "LOAD" if is_constant => Err(format!("nothing is to be seen: {said}")),
        "REFUSE" => Err(format!("it was rendered: {said}")),
        _ if expect.starts_with("REFUSE") && !said.lines().any(|l| fits(&l)) => {
            Err(format!("no warning fits its fault: {said}"))
        }
        _ if expect.starts_with("REFUSE") => Ok("warned of"),
        _ => Ok("rendered"),
    }
}
