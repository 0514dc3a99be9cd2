//! The pictures of the manual, which `cargo run --release --example pictures` makes.

use std::fs;

use libtest_mimic::Failed;

use super::pages::{Page, registries};
use crate::common::{files, repo};

/// The folder of the pictures, below that of the manual.
pub const FOLDER: &str = "pictures/";
/// The most bytes of one picture, and of all together.
const MOST_BYTES: u64 = 60_000;
const MOST_BYTES_TOGETHER: u64 = 6_000_000;
const COMMAND: &str = "cargo run --release --example pictures";

/// The pictures, by their paths below their folder.
fn pictures() -> Vec<String> {
    let root = repo("docs/scene").join(FOLDER);
    let name = |path: std::path::PathBuf| {
        let name = path
            .strip_prefix(&root)
            .expect("a file of the folder")
            .to_string_lossy();
        name.replace('\\', "/")
    };
    let mut names: Vec<String> = files(&root).into_iter().map(name).collect();
    // `a/b.jpg` comes before `a/b-c.jpg`.
    names.sort_by_key(|name| name.trim_end_matches(".jpg").to_owned());
    names
}

/// Whether the page `file` of the pages `all` shows a picture. A page `a/b.md` shows `a/b.jpg` and `a/b-c.jpg`. A page `a.md` shows
/// `a-b.jpg`, and `a/b.jpg` if there is no page `a/b.md`.
fn is_on_page(picture: &str, file: &str, all: &[String]) -> bool {
    let page = file.trim_end_matches(".md");
    match picture.strip_prefix(page).and_then(|rest| rest.chars().next()) {
        Some('.' | '-') => true,
        Some('/') => {
            let kind = picture.split(['.', '-']).next().unwrap_or_default();
            !all.contains(&format!("{kind}.md"))
        }
        _ => false,
    }
}

/// Inserts the pictures of a page below its first paragraph.
pub fn insert(page: &mut Page, all: &[String]) {
    let up = "../".repeat(page.file.matches('/').count());
    let mut shown = String::new();
    for picture in pictures().iter().filter(|picture| is_on_page(picture, &page.file, all)) {
        let name = picture.trim_end_matches(".jpg").replace(['/', '-'], " ");
        shown += &format!("\n\n![{name}]({up}{FOLDER}{picture})");
    }
    // The first two paragraphs are the note and the title.
    let end = page.text.match_indices("\n\n").nth(2).map(|(at, _)| at);
    page.text
        .insert_str(end.expect("a page has several paragraphs"), &shown);
}

pub fn every_kind_has_one() -> Result<(), Failed> {
    let pictures = pictures();
    for (folder, kinds) in registries() {
        for kind in kinds {
            let file = format!("{folder}/{kind}.jpg");
            if !pictures.contains(&file) {
                return Err(format!("docs/scene/{FOLDER}{file} is missing: {COMMAND} -- {folder}/{kind}").into());
            }
        }
    }
    Ok(())
}

/// Checks the sizes of all pictures, and that pages with these texts show each of them.
pub fn are_small_and_shown(pages: &[String]) -> Result<(), Failed> {
    let mut together = 0;
    for picture in pictures() {
        let path = repo("docs/scene").join(FOLDER).join(&picture);
        let bytes = fs::metadata(&path)?.len();
        together += bytes;
        if bytes > MOST_BYTES {
            return Err(format!("{picture} has {bytes} bytes").into());
        }
        image::open(&path)?;
        if !pages.iter().any(|text| text.contains(&format!("{FOLDER}{picture})"))) {
            return Err(format!("no page shows {picture}").into());
        }
    }
    if together > MOST_BYTES_TOGETHER {
        return Err(format!("all pictures have {together} bytes together").into());
    }
    Ok(())
}
