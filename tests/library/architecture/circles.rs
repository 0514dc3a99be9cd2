//! No circle of files inside a room: what a file uses can be read without reading that file first.

use std::collections::{BTreeMap, BTreeSet};

use super::{code, files, paths::Sources, room};

/// Rooms of kinds. The `mod.rs` states the contract of the kinds and is the closed list of them, so that it names each of
/// them and each names it. There a use of the folder's own `mod.rs` does not count.
const REGISTRIES: [&str; 8] = [
    "bsdf",
    "camera",
    "integrator",
    "light",
    "material",
    "sampler",
    "shape",
    "texture",
];

/// Whether a file holds tests only. These see everything and nothing uses them, so they do not count.
fn is_test(file: &str) -> bool {
    file.ends_with("/tests.rs") || ["/tests/", "/battery/", "battery.rs"].iter().any(|p| file.contains(p))
}

/// Code without comments and without the module of tests at its end.
fn tested_code(text: &str) -> String {
    let code = code(text);
    let end = [
        "#[cfg(test)]\nmod ",
        "#[cfg(test)]\npub mod ",
        "#[cfg(test)]\npub(crate) mod ",
    ]
    .iter()
    .filter_map(|start| {
        let at = code.find(start)?;
        // A module in a file of its own is one line among others.
        let line = code[at..].lines().nth(1)?;
        line.ends_with('{').then_some(at)
    })
    .min();
    code[..end.unwrap_or(code.len())].to_owned()
}

/// The files that use one another in a circle, a set for each circle.
fn circles<'a>(edges: &BTreeMap<&'a str, BTreeSet<&'a str>>) -> Vec<BTreeSet<&'a str>> {
    let reach = |from: &'a str| {
        let mut reached = BTreeSet::new();
        let mut next = vec![from];
        while let Some(file) = next.pop() {
            let used = edges.get(file).into_iter().flatten();
            next.extend(used.filter(|to| reached.insert(**to)));
        }
        reached
    };
    let reached: BTreeMap<&str, BTreeSet<&str>> = edges.keys().map(|file| (*file, reach(file))).collect();
    let mut circles: Vec<BTreeSet<&str>> = Vec::new();
    for (file, to) in &reached {
        if to.contains(file) && !circles.iter().any(|circle| circle.contains(file)) {
            let back = |other: &&str| reached.get(*other).is_some_and(|r| r.contains(file));
            circles.push(to.iter().copied().filter(|other| back(other)).collect());
        }
    }
    circles
}

/// A `mod.rs` is a file like others, but a path through a name that it only hands on leads to the file that defines it,
/// and declaring a module is no use of it. Tests do not count.
#[test]
fn no_files_of_a_room_use_one_another_in_a_circle() {
    let files: BTreeMap<String, String> = files(&["src"])
        .into_iter()
        .filter(|(file, _)| !is_test(file))
        .map(|(file, text)| (file, tested_code(&text)))
        .collect();
    let sources = Sources::read(&files);
    let mut edges = sources.edges();
    for (from, used) in &mut edges {
        let registry = format!("src/{}/mod.rs", room(from));
        let in_registry = REGISTRIES.contains(&room(from));
        used.retain(|to| room(from) == room(to) && !(in_registry && *to == registry));
    }
    let found = circles(&edges);
    assert!(found.is_empty(), "files in circles: {found:#?}");
}

#[test]
fn a_circle_is_seen_and_a_name_that_is_handed_on_leads_to_its_file() {
    let file = |name: &str, code: &str| (format!("src/room/{name}.rs"), code.to_owned());
    let mut files = BTreeMap::from([
        file("mod", "mod a;\nmod b;\nmod c;\npub use a::{A, a2};"),
        file("a", "use super::{\n    b::{self, B},\n};"),
        file("b", "fn f() { super::c::g() }"),
        file("c", "use std::fmt;"),
    ]);
    let seen = |files: &BTreeMap<String, String>| {
        let sources = Sources::read(files);
        let found = circles(&sources.edges());
        found
            .iter()
            .map(|c| c.iter().map(|f| (*f).to_owned()).collect::<Vec<_>>())
            .collect::<Vec<_>>()
    };
    assert!(seen(&files).is_empty());
    files.insert("src/room/c.rs".to_owned(), "use crate::room::A;".to_owned());
    assert_eq!(seen(&files), [["src/room/a.rs", "src/room/b.rs", "src/room/c.rs"]]);
    files.insert("src/room/c.rs".to_owned(), "use super::D;".to_owned());
    assert!(seen(&files).is_empty());
    files.insert(
        "src/room/mod.rs".to_owned(),
        "mod a;\nmod b;\nmod c;\nfn f() { a::f() }".to_owned(),
    );
    assert_eq!(seen(&files)[0].len(), 4);
}
