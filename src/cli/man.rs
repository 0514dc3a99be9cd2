//! The manual page (`batch-render man`), made of the help.

use std::{collections::BTreeSet, fmt::Write};

use clap::{Arg, Command};

/// The page in the language of man.
pub fn page(root: &Command) -> String {
    let version = root.get_version().unwrap_or_default();
    let about = root.get_about().map(ToString::to_string).unwrap_or_default();
    // Writing to a string cannot fail.
    let mut out = format!(
        ".TH BATCH\\-RENDER 1 \"\" \"batch\\-render {version}\"\n.SH NAME\nbatch\\-render \\- {}\n.SH SYNOPSIS\n\
         .B batch\\-render\n[\\fIOPTIONS\\fR] \\fISCENE\\fR...\n.br\n.B batch\\-render\n\\fICOMMAND\\fR [\\fIOPTIONS\\fR]\n",
        text(&about)
    );
    options(&mut out, root, "OPTIONS");
    for command in root.get_subcommands().filter(|command| !command.is_hide_set()) {
        let name = text(command.get_name());
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        let _ = write!(out, ".SH BATCH\\-RENDER {}\n{}.\n", name.to_uppercase(), text(&about));
        options(&mut out, command, "");
    }
    for command in [root].into_iter().chain(root.get_subcommands()) {
        if let Some(after) = command.get_after_long_help() {
            let (title, lines) = match after.to_string().split_once('\n') {
                Some((title, lines)) => (title.trim_end_matches(':').to_owned(), lines.to_owned()),
                None => continue,
            };
            let _ = write!(out, ".SH {}", text(&title).to_uppercase());
            if command.get_name() != root.get_name() {
                let _ = write!(out, " OF {}", text(command.get_name()).to_uppercase());
            }
            let _ = write!(out, "\n.nf\n{}\n.fi\n", text(&lines));
        }
    }
    out
}

/// The arguments of a command, with those of each heading together.
fn options(out: &mut String, command: &Command, title: &str) {
    if !title.is_empty() {
        let _ = writeln!(out, ".SH {title}");
    }
    let arguments: Vec<&Arg> = command
        .get_arguments()
        .filter(|argument| !argument.is_hide_set())
        .collect();
    let mut headings = BTreeSet::new();
    for first in &arguments {
        let heading = first.get_help_heading().unwrap_or_default();
        if !headings.insert(heading) {
            continue;
        }
        if !heading.is_empty() {
            let _ = writeln!(out, ".SS {}", text(heading));
        }
        let of_heading = arguments
            .iter()
            .filter(|other| other.get_help_heading().unwrap_or_default() == heading);
        of_heading.for_each(|argument| option(out, argument));
    }
}

fn option(out: &mut String, argument: &Arg) {
    let short = argument.get_short().map(|short| format!("\\-{short}"));
    let aliases = argument.get_visible_aliases().unwrap_or_default();
    let long = argument
        .get_long()
        .into_iter()
        .chain(aliases)
        .map(|long| text(&format!("--{long}")));
    let flags: Vec<String> = short
        .into_iter()
        .chain(long)
        .map(|flag| format!("\\fB{flag}\\fR"))
        .collect();
    let values = argument.get_value_names().unwrap_or_default();
    let values: Vec<String> = match argument.get_action().takes_values() {
        true => values.iter().map(|value| format!("\\fI{}\\fR", text(value))).collect(),
        false => Vec::new(),
    };
    let _ = write!(out, ".TP\n{}\n", [flags.join(", "), values.join(" ")].join(" ").trim());
    let help = argument
        .get_long_help()
        .or(argument.get_help())
        .map(ToString::to_string);
    let mut about = text(&help.unwrap_or_default()).replace("\n\n", "\n.IP\n");
    let defaults: Vec<String> = argument
        .get_default_values()
        .iter()
        .map(|v| v.to_string_lossy().into_owned())
        .collect();
    if !defaults.is_empty() && argument.get_action().takes_values() {
        about += &text(&format!(" [default: {}]", defaults.join(" ")));
    }
    let possible: Vec<String> = argument
        .get_possible_values()
        .iter()
        .map(|value| value.get_name().to_owned())
        .collect();
    if !possible.is_empty() && argument.get_action().takes_values() {
        about += &text(&format!(" [possible values: {}]", possible.join(", ")));
    }
    let _ = writeln!(out, "{about}");
}

/// A text without the marks of man.
fn text(text: &str) -> String {
    let text = text.replace('\\', "\\e").replace('-', "\\-");
    let protected = text.lines().map(|line| match line.starts_with(['.', '\'']) {
        true => format!("\\&{line}"),
        false => line.to_owned(),
    });
    protected.collect::<Vec<_>>().join("\n")
}
