//! The house: which room may use which, who names which package, and how long a file may be.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

mod circles;
mod kinds;
mod paths;

/// Rooms by floor. A room uses the floors below its own.
const FLOORS: [(&str, u32); 29] = [
    ("main", 7),
    ("cli", 7),
    ("batch", 6),
    ("viewer", 6),
    ("bench", 6),
    ("error", 6),
    ("output", 5),
    ("describe", 5),
    ("compare", 5),
    ("compile", 5),
    ("render", 4),
    ("assets", 4),
    ("denoise", 4),
    ("integrator", 3),
    ("film", 3),
    ("scene", 2),
    ("accel", 2),
    ("geometry", 1),
    ("shape", 1),
    ("texture", 1),
    ("bsdf", 1),
    ("material", 1),
    ("light", 1),
    ("camera", 1),
    ("sampler", 1),
    ("filter", 1),
    ("math", 0),
    ("simd", 0),
    ("native", 0),
];

/// Also on the ground.
const GROUND: [&str; 3] = ["value", "kind", "warnings"];

/// Neighbours that may be used on one floor.
const NEIGHBOURS: [(&str, &str); 18] = [
    ("value", "math"),
    ("kind", "value"),
    ("warnings", "value"),
    ("simd", "math"),
    ("native", "math"),
    ("geometry", "shape"),
    ("main", "cli"),
    ("material", "bsdf"),
    ("material", "texture"),
    ("light", "shape"),
    ("light", "texture"),
    ("scene", "accel"),
    ("describe", "output"),
    ("compile", "describe"),
    ("viewer", "batch"),
    ("batch", "error"),
    ("bench", "error"),
    ("viewer", "error"),
];

/// Packages that only some places may name.
const PACKAGES: [(&str, &[&str]); 19] = [
    ("obvhs", &["src/accel/"]),
    ("flate2", &["src/assets/gzip.rs"]),
    ("bevy_mikktspace", &["src/assets/tangents.rs"]),
    ("earcutr", &["src/assets/obj/polygon.rs"]),
    ("gltf", &["src/assets/gltf/"]),
    ("tobj", &["src/assets/obj.rs", "src/assets/obj/"]),
    (
        "exr",
        &[
            "src/output/exr.rs",
            "src/output/exr/",
            "src/assets/image.rs",
            "src/assets/image/",
        ],
    ),
    ("clap", &["src/cli/"]),
    ("shlex", &["src/cli/"]),
    ("indicatif", &["src/cli/"]),
    ("anyhow", &["src/cli/"]),
    ("signal_hook", &["src/cli/"]),
    ("libloading", &["src/native/"]),
    ("windows_sys", &["src/native/"]),
    ("mimalloc", &["src/main.rs"]),
    ("axum", &["src/viewer/"]),
    ("tokio", &["src/viewer/"]),
    ("jpeg_encoder", &["src/viewer/"]),
    ("getrandom", &["src/viewer/"]),
];

/// The folders where code may be unsafe.
const UNSAFE: [&str; 3] = ["src/simd/", "src/accel/kernels/", "src/native/"];

const LONGEST: usize = 500;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn rust_files(folder: &Path, out: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.map(|e| e.expect("a readable folder").path()) {
        if entry.is_dir() {
            rust_files(&entry, out);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            out.push(entry);
        }
    }
}

fn files(folders: &[&str]) -> BTreeMap<String, String> {
    let mut paths = Vec::new();
    for folder in folders {
        rust_files(&root().join(folder), &mut paths);
    }
    paths
        .into_iter()
        .map(|p| {
            let name = p
                .strip_prefix(root())
                .expect("below the root")
                .to_string_lossy()
                .replace('\\', "/");
            (name, fs::read_to_string(&p).expect("readable"))
        })
        .collect()
}

fn floor(room: &str) -> Option<u32> {
    if GROUND.contains(&room) {
        return Some(0);
    }
    FLOORS.iter().find(|(name, _)| *name == room).map(|(_, floor)| *floor)
}

/// The room that a file is in: `src/shape/quad.rs` is in `shape`, `src/filter.rs` in `filter`.
fn room(file: &str) -> &str {
    let inside = file.strip_prefix("src/").expect("a source file");
    inside
        .split('/')
        .next()
        .and_then(|r| r.split('.').next())
        .expect("a name")
}

/// Code without comments, strings aside: good enough to find paths in.
fn code(text: &str) -> String {
    text.lines()
        .map(|l| l.split("//").next().unwrap_or_default())
        .collect::<Vec<_>>()
        .join("\n")
}

/// The rooms that `text` names as `crate::ROOM`, singly or in a braced list, or as `batch_render::ROOM`.
fn used_rooms(text: &str) -> Vec<String> {
    let mut rooms = Vec::new();
    for prefix in ["crate::", "batch_render::"] {
        for (at, _) in text.match_indices(prefix) {
            let rest = &text[at + prefix.len()..];
            match rest.strip_prefix('{') {
                None => rooms.push(word(rest)),
                Some(list) => rooms.extend(top_level_words(list)),
            }
        }
    }
    rooms
}

fn word(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// The first word of each item of a braced list, up to its closing brace.
fn top_level_words(list: &str) -> Vec<String> {
    let (mut depth, mut words, mut fresh) = (0, Vec::new(), true);
    for (i, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => fresh = true,
            c if fresh && (c.is_alphanumeric() || c == '_') => {
                words.push(word(&list[i..]));
                fresh = false;
            }
            _ => {}
        }
    }
    words
}

#[test]
fn rooms_use_the_floors_below_them_only() {
    let mut wrong = Vec::new();
    for (file, text) in files(&["src"]) {
        let from = room(&file);
        if from == "lib" {
            continue;
        }
        let Some(from_floor) = floor(from) else {
            wrong.push(format!("{file}: `{from}` has no floor"));
            continue;
        };
        for to in used_rooms(&code(&text)) {
            let Some(to_floor) = floor(&to) else { continue };
            let neighbour = NEIGHBOURS.contains(&(from, to.as_str()));
            if to != from && to_floor >= from_floor && !neighbour {
                wrong.push(format!(
                    "{file}: {from} (floor {from_floor}) uses {to} (floor {to_floor})"
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn packages_are_named_where_they_belong() {
    let mut wrong = Vec::new();
    for (file, text) in files(&["src"]) {
        if file.ends_with("/tests.rs") {
            // A test may check one package's work by another's.
            continue;
        }
        let code = code(&text);
        for (package, places) in PACKAGES {
            let named = [
                format!("use {package}::"),
                format!(" {package}::"),
                format!("({package}::"),
                format!("<{package}::"),
            ];
            let own_module = code.contains(&format!("mod {package};"));
            let allowed = own_module || places.iter().any(|p| file.starts_with(p));
            if !allowed && named.iter().any(|n| code.contains(n.as_str())) {
                wrong.push(format!("{file} names {package}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn unsafe_lives_in_vectors_kernels_and_native_libraries_only() {
    for (file, text) in files(&["src"]) {
        let allowed = UNSAFE.iter().any(|place| file.starts_with(place));
        let code = code(&text);
        let used = ["unsafe {", "unsafe fn", "unsafe impl", "unsafe extern"]
            .iter()
            .any(|u| code.contains(u));
        assert!(allowed || !used, "{file} is unsafe");
    }
}

/// Files that read files: the gate itself, and those whose files are no inputs of a picture.
const READERS: [(&str, &str); 14] = [
    ("src/assets/files.rs", "the gate"),
    ("src/bsdf/albedo/isotropic.rs", "a table that is compiled in"),
    ("src/output/atomic.rs", "folders of output"),
    ("src/output/held.rs", "temporary files of other processes"),
    ("src/output/facts.rs", "output of an earlier run"),
    ("src/output/job_file.rs", "other jobs"),
    ("src/output/sequence.rs", "names of files of an earlier run"),
    ("src/compare/pairs.rs", "names of pictures in folders"),
    ("src/batch/resume/checkpoint.rs", "the state of an earlier run"),
    (
        "src/batch/products/transforms.rs",
        "what other parts of the job have written",
    ),
    ("src/cli/memory/unix.rs", "the process's own memory"),
    ("src/cli/figure_files.rs", "what other parts of the job have written"),
    ("src/cli/signals/unix.rs", "the process's own signals"),
    ("src/native/windows/files.rs", "which file a name is, not its content"),
];

#[test]
fn input_files_are_read_through_one_gate() {
    const READING: [&str; 6] = [
        "fs::read",
        "File::open",
        "OpenOptions",
        "read_to_string(",
        "read_dir(",
        "include_bytes!",
    ];
    for (file, text) in files(&["src"]) {
        let body = code(text.split("#[cfg(test)]").next().unwrap_or_default());
        let is_test = file.contains("/battery/") || file.contains("/tests");
        let is_reader = READERS.iter().any(|(reader, _)| *reader == file);
        let found = READING.iter().find(|r| body.contains(**r));
        assert!(
            is_test || is_reader || found.is_none(),
            "{file} reads files ({}): inputs go through assets::Files",
            found.expect("checked")
        );
    }
}

#[test]
fn no_file_is_longer_than_a_reader_bears() {
    for (file, text) in files(&["src", "tests", "benches", "examples"]) {
        let lines = text.lines().count();
        assert!(lines <= LONGEST, "{file} has {lines} lines");
    }
}

#[test]
fn the_library_neither_prints_nor_exits() {
    for (file, text) in files(&["src"]) {
        if matches!(room(&file), "cli" | "main") {
            continue;
        }
        let body = code(text.split("#[cfg(test)]").next().unwrap_or_default());
        for forbidden in [
            "println!",
            "eprintln!",
            "print!(",
            "process::exit",
            "todo!",
            "unimplemented!",
            "dbg!",
        ] {
            assert!(!body.contains(forbidden), "{file} contains {forbidden}");
        }
    }
}

#[test]
fn braced_imports_are_seen() {
    let text = "use crate::{\n    math::{Aabb, Ray},\n    shape::Shape,\n};\nuse crate::film::Film;";
    assert_eq!(used_rooms(text), ["math", "shape", "film"]);
}

/// A file of a folder of tests that no program of tests includes would never run.
#[test]
fn no_test_file_is_forgotten() {
    let at_top: Vec<_> = files(&["tests"])
        .into_keys()
        .filter(|path| path.matches('/').count() == 1)
        .collect();
    assert!(at_top.is_empty(), "in no folder of tests: {at_top:?}");
    for folder in ["library", "program", "trials", "viewer"] {
        let folder = format!("tests/{folder}/");
        let files = files(&[&folder]);
        let main = &files[&format!("{folder}main.rs")];
        for path in files.keys() {
            let module = path.trim_start_matches(&folder).trim_end_matches(".rs");
            let is_included = module == "main" || module.contains('/') || main.contains(&format!("mod {module};"));
            assert!(is_included, "{path} is not included by {folder}main.rs");
        }
    }
}

#[test]
fn the_library_warns_by_values_only() {
    let is_library = |file: &String| {
        !["src/cli/", "src/main.rs", "src/warnings.rs"]
            .iter()
            .any(|p| file.starts_with(p))
    };
    for (file, text) in files(&["src"]).into_iter().filter(|(file, _)| is_library(file)) {
        assert!(
            !code(&text).contains("warn!"),
            "{file} logs a warning instead of adding it to `Warnings`"
        );
    }
}
