//! The documents are whole: links lead somewhere, and the map of the rooms shows those that there are.

use std::{collections::BTreeSet, fs, path::Path};

use crate::common::{files, repo};

/// The documents by path, without their blocks of code.
fn documents() -> Vec<(std::path::PathBuf, String)> {
    let mut paths = files(&repo("docs"));
    paths.retain(|path| path.extension().is_some_and(|e| e == "md"));
    paths.extend([repo("README.md"), repo("benches/README.md")]);
    let read = |path: std::path::PathBuf| {
        let text = fs::read_to_string(&path).expect("readable");
        (path, prose(&text))
    };
    paths.into_iter().map(read).collect()
}

/// A text without its blocks of code.
fn prose(text: &str) -> String {
    let blocks = text.split("```").step_by(2);
    blocks.collect::<Vec<_>>().join("\n")
}

/// The targets of all links in a text.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](")
        .skip(1)
        .filter_map(|rest| Some(rest.split_once(')')?.0))
}

/// The anchors that a text's headings have on the web.
fn anchors(text: &str) -> Vec<String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let anchor = |heading: &str| {
        let words = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = words.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

/// The pages of a repository on GitHub, as its README names them.
const PAGES: [&str; 2] = ["../../actions/", "../../releases/"];

/// The error in a link from the document at `path`, if there is one.
fn broken(path: &Path, link: &str) -> Option<String> {
    if link.contains("://") || PAGES.iter().any(|page| link.starts_with(page)) {
        return None;
    }
    let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
    let target = match file {
        "" => path.to_owned(),
        file => path.parent().expect("a folder").join(file),
    };
    if !target.exists() {
        return Some(format!("{}: {link} does not exist", path.display()));
    }
    let known = anchor.is_empty() || anchors(&fs::read_to_string(&target).ok()?).contains(&anchor.to_owned());
    (!known).then(|| format!("{}: {link} is no heading", path.display()))
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let mut seen = 0;
    let mut wrong = Vec::new();
    for (path, text) in documents() {
        for link in links(&text) {
            seen += 1;
            wrong.extend(broken(&path, link));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(seen > 100, "{seen} links");
}

#[test]
fn a_broken_link_is_found() {
    let path = repo("README.md");
    assert_eq!(broken(&path, "docs/guide.md#camera-paths"), None);
    assert!(broken(&path, "docs/guide.md#camera-path").is_some());
    assert!(broken(&path, "docs/gude.md").is_some());
    assert!(broken(&path, "../../release").is_some());
}

#[test]
fn the_architecture_shows_every_room() {
    let text = fs::read_to_string(repo("docs/architecture.md")).expect("readable");
    let rows = text
        .lines()
        .filter(|line| line.starts_with("| ") && !line.starts_with("| floor"));
    let cells = rows.filter_map(|row| row.split(" | ").nth(1));
    let shown: BTreeSet<String> = cells
        .flat_map(|cell| cell.split('`').skip(1).step_by(2))
        .map(str::to_owned)
        .collect();
    let entries = crate::common::names(&repo("src")).into_iter();
    let rooms: BTreeSet<String> = entries
        .map(|name| name.trim_end_matches(".rs").to_owned())
        .filter(|name| name != "lib")
        .collect();
    assert_eq!(shown, rooms);
}
