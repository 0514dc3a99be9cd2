//! The tables of flags in `docs/interface.md` are those of the program's own help.
//!
//! A table stands between the lines `<!-- From COMMAND --help: HEADING -->` and `<!-- end -->`. With `BLESS=1` the tables are
//! written anew: read the difference.

use std::fs;

use crate::common::{Folder, repo};
use libtest_mimic::{Failed, Trial};

const DOCUMENT: &str = "docs/interface.md";
const BEGIN: &str = "<!-- From ";
const END: &str = "<!-- end -->";

pub fn trials() -> Vec<Trial> {
    vec![
        trial!("tables", tables_are_those_of_the_help),
        trial!("no heading without a table", every_heading_has_a_table),
    ]
}

/// An entry of the help: an argument, a flag or a command.
#[derive(Clone, PartialEq, Eq)]
struct Entry {
    name: String,
    about: String,
    default: String,
}

/// A section of the help.
struct Section {
    heading: String,
    entries: Vec<Entry>,
}

/// The sections of the help of a command, such as `batch-render check --help`.
fn help(command: &str) -> Result<Vec<Section>, Failed> {
    let arguments: Vec<&str> = command.split(' ').skip(1).collect();
    let output = Folder::new().run(&arguments);
    if !output.status.success() {
        return Err(format!("{command}: {}", crate::common::stderr(&output)).into());
    }
    Ok(sections(&String::from_utf8(output.stdout)?))
}

/// Headings are not indented and end in a colon; names of entries are indented by at most six spaces.
fn sections(help: &str) -> Vec<Section> {
    let mut sections: Vec<Section> = Vec::new();
    for line in help.lines() {
        let text = line.trim();
        let indent = line.len() - line.trim_start().len();
        if indent == 0 && !text.is_empty() {
            if let Some(heading) = text.strip_suffix(':') {
                let heading = heading.to_owned();
                sections.push(Section {
                    heading,
                    entries: Vec::new(),
                });
            }
            continue;
        }
        let Some(section) = sections.last_mut() else { continue };
        if indent <= 6 && !text.is_empty() {
            let (name, about) = text.split_once("  ").unwrap_or((text, ""));
            section.entries.push(Entry {
                name: name.to_owned(),
                about: String::new(),
                default: String::new(),
            });
            add(section, about.trim());
        } else {
            add(section, text);
        }
    }
    sections.retain(|section| !section.entries.is_empty());
    sections
}

/// Adds a line to the description of the last entry; an empty line has ended a paragraph before.
fn add(section: &mut Section, line: &str) {
    let Some(entry) = section.entries.last_mut() else {
        return;
    };
    let item = line
        .strip_prefix("- ")
        .filter(|_| entry.about.contains("Possible values"));
    match item {
        _ if line.is_empty() => {
            if !entry.about.is_empty() && !entry.about.ends_with(['.', ':']) {
                entry.about.push('.');
            }
        }
        Some(item) => {
            let (value, about) = item.split_once(':').unwrap_or((item, ""));
            let about = about.trim();
            let before = if entry.about.ends_with(':') { "" } else { ";" };
            entry.about += &format!("{before} `{value}` ({about})");
        }
        None => {
            if !entry.about.is_empty() {
                entry.about.push(' ');
            }
            entry.about += line;
        }
    }
}

/// Moves `[default: ...]` out of the description, and `[possible values: ...]` and `[alias: ...]` to its end.
fn finished(mut entry: Entry) -> Entry {
    for (label, is_default) in [("[default: ", true), ("[possible values: ", false), ("[alias: ", false)] {
        let Some((before, rest)) = entry.about.split_once(label) else {
            continue;
        };
        let Some((value, after)) = rest.split_once(']') else {
            continue;
        };
        // A full stop after the label is that of an empty line, see [`add`].
        let after = after.trim_start_matches('.').trim();
        let about = format!("{} {after}", before.trim_end().trim_end_matches('.'));
        if is_default {
            entry.default = value.to_owned();
            entry.about = about;
        } else {
            let label = label.trim_matches(['[', ' ']);
            entry.about = format!("{} ({label} {value})", about.trim_end());
        }
    }
    entry.about = entry.about.trim().trim_end_matches('.').replace('|', "\\|");
    entry.name = entry.name.replace('|', "\\|");
    entry
}

/// The table of the sections of a command that are headed `heading`; of all but the general ones without it. Flags of jobs are
/// named in one row where they mean the same for another command.
fn table(command: &str, heading: Option<&str>) -> Result<String, Failed> {
    let job: Vec<Entry> = if heading.is_none() {
        help("batch-render --help")?
            .into_iter()
            .flat_map(|section| section.entries)
            .collect()
    } else {
        Vec::new()
    };
    let (mut entries, mut shared) = (Vec::new(), Vec::new());
    for section in help(command)? {
        let is_wanted = |entry: &Entry| match heading {
            Some(heading) => section.heading == heading && entry.name != "help",
            None => is_own(&section, entry),
        };
        for entry in section.entries.iter().filter(|entry| is_wanted(entry)) {
            if entry.name.starts_with('-') && job.contains(entry) {
                shared.push(format!("`{}`", long_name(&entry.name)));
                continue;
            }
            entries.push(finished(entry.clone()));
        }
    }
    if entries.is_empty() {
        return Err(format!("{command} has no {heading:?}").into());
    }
    let has_defaults = entries.iter().any(|entry| !entry.default.is_empty());
    let row = |name: &str, about: &str, default: &str| match has_defaults {
        true => format!("| {name} | {about} | {default} |\n"),
        false => format!("| {name} | {about} |\n"),
    };
    let mut table = row(heading.map_or("argument", first_column), "meaning", "default")
        + &row("---", "---", "---").replace(' ', "");
    for Entry { name, about, default } in &entries {
        table += &row(&format!("`{name}`"), about, default);
    }
    if !shared.is_empty() {
        table += &row(&shared.join(", "), "as for a job", "");
    }
    Ok(table)
}

/// Whether an entry is an argument or a flag of its command, and none of all commands. The keys of a page are neither.
fn is_own(section: &Section, entry: &Entry) -> bool {
    section.heading != "General" && entry.name.starts_with(['-', '<', '['])
}

/// The first column of the table of a heading.
fn first_column(heading: &str) -> &str {
    match heading {
        "Commands" => "command",
        _ => "flag",
    }
}

/// The long flag of a name such as `-r, --range <SPEC>`.
fn long_name(name: &str) -> &str {
    let long = name.find("--").map_or(name, |at| &name[at..]);
    long.split([' ', '[']).next().unwrap_or(long)
}

/// The command and the heading of a table's first line.
fn source(line: &str) -> Option<(&str, Option<&str>)> {
    let source = line.strip_prefix(BEGIN)?.strip_suffix(" -->")?;
    match source.split_once(": ") {
        Some((command, heading)) => Some((command, Some(heading))),
        None => Some((source, None)),
    }
}

fn tables_are_those_of_the_help() -> Result<(), Failed> {
    let path = repo(DOCUMENT);
    let found = fs::read_to_string(&path)?;
    let mut made = String::new();
    let mut lines = found.lines();
    while let Some(line) = lines.next() {
        made += line;
        made.push('\n');
        if let Some((command, heading)) = source(line) {
            let table = table(command, heading)?;
            made += &format!("\n{table}\n{END}\n");
            if !lines.any(|line| line == END) {
                return Err(format!("the table below {line} has no end").into());
            }
        }
    }
    if std::env::var_os("BLESS").is_some() {
        fs::write(&path, &made)?;
        return Ok(());
    }
    if found == made {
        return Ok(());
    }
    Err(
        format!("{DOCUMENT} differs from the help: BLESS=1 cargo test --test trials interface writes its tables")
            .into(),
    )
}

fn every_heading_has_a_table() -> Result<(), Failed> {
    let text = fs::read_to_string(repo(DOCUMENT))?;
    let main = help("batch-render --help")?;
    let shown = |command: &str| text.contains(&format!("{BEGIN}{command} -->"));
    for section in &main {
        let heading = format!("batch-render --help: {}", section.heading);
        // Examples are no flags; a test of their own parses them.
        let has_flags = !["Arguments", "Examples"].contains(&section.heading.as_str());
        if has_flags && !shown(&heading) {
            return Err(format!("{DOCUMENT} has no table of {heading}").into());
        }
    }
    let commands = main.iter().filter(|section| section.heading == "Commands");
    let commands = commands.flat_map(|section| &section.entries);
    for command in commands.filter(|command| command.name != "help") {
        let name = format!("batch-render {}", command.name);
        let page = format!("{name} --help");
        let sections = help(&page)?;
        let has_own = |section: &Section| section.entries.iter().any(|entry| is_own(section, entry));
        // A command without arguments has an empty table.
        let is_told = match sections.iter().any(has_own) {
            true => shown(&page),
            false => text.contains(&format!("`{name}`")),
        };
        if !is_told {
            return Err(format!("{DOCUMENT} has no table of {page}").into());
        }
    }
    Ok(())
}
