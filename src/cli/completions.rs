//! Completions of shells (`batch-render completions SHELL`), made of the commands and flags of the command line.

use std::fmt::Write;

use clap::{Arg, Command, ValueEnum};

/// A shell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Shell {
    Bash,
    Fish,
    Zsh,
}

/// A command whose flags are completed; the first has no name and is that of a job.
struct Known<'a> {
    name: &'a str,
    about: String,
    flags: Vec<&'a Arg>,
}

/// The script for a shell.
pub fn script(shell: Shell, root: &Command) -> String {
    let shown = root.get_subcommands().filter(|command| !command.is_hide_set());
    let known: Vec<Known<'_>> = [("", root)]
        .into_iter()
        .chain(shown.map(|command| (command.get_name(), command)))
        .map(|(name, command)| Known {
            name,
            about: command.get_about().map(ToString::to_string).unwrap_or_default(),
            flags: command
                .get_arguments()
                .filter(|flag| flag.get_long().is_some())
                .collect(),
        })
        .collect();
    match shell {
        Shell::Bash => bash(&known),
        Shell::Fish => fish(&known),
        Shell::Zsh => zsh(&known),
    }
}

/// All long names of a flag.
fn names(flag: &Arg) -> Vec<&str> {
    let aliases = flag.get_visible_aliases().unwrap_or_default();
    flag.get_long().into_iter().chain(aliases).collect()
}

fn takes_value(flag: &Arg) -> bool {
    flag.get_action().takes_values()
}

/// The words that its value may be, if they are known.
fn values(flag: &Arg) -> String {
    let values = flag.get_possible_values();
    let names: Vec<&str> = values.iter().map(|value| value.get_name()).collect();
    if takes_value(flag) {
        names.join(" ")
    } else {
        String::new()
    }
}

fn about(flag: &Arg) -> String {
    flag.get_help().map(ToString::to_string).unwrap_or_default()
}

/// The names of the commands.
fn commands<'a>(known: &[Known<'a>]) -> Vec<&'a str> {
    known[1..].iter().map(|command| command.name).collect()
}

fn bash(known: &[Known<'_>]) -> String {
    let commands = commands(known);
    // Writing to a string cannot fail.
    let mut out = format!(
        "_batch_render() {{\n    local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD - 1]}} command= words= word\n    \
         for word in \"${{COMP_WORDS[@]:1:COMP_CWORD - 1}}\"; do\n        case $word in {}) command=$word; break ;; esac\n    done\n    \
         case $command,$prev in\n",
        commands.join("|"),
    );
    for command in known {
        for flag in command.flags.iter().filter(|flag| !values(flag).is_empty()) {
            let names = names(flag);
            let patterns: Vec<String> = names.iter().map(|name| format!("{},--{name}", command.name)).collect();
            let _ = writeln!(out, "    {}) words=\"{}\" ;;", patterns.join("|"), values(flag));
        }
    }
    out += "    esac\n    if [[ -n $words ]]; then\n        COMPREPLY=($(compgen -W \"$words\" -- \"$cur\"))\n        return\n    fi\n    \
            case $command in\n";
    for command in known {
        let flags: Vec<String> = command
            .flags
            .iter()
            .flat_map(|flag| names(flag))
            .map(|name| format!("--{name}"))
            .collect();
        let pattern = if command.name.is_empty() { "''" } else { command.name };
        let _ = writeln!(out, "    {pattern}) words=\"{}\" ;;", flags.join(" "));
    }
    let _ = write!(
        out,
        "    esac\n    if [[ $cur == -* ]]; then\n        COMPREPLY=($(compgen -W \"$words\" -- \"$cur\"))\n        return\n    fi\n    \
         COMPREPLY=($(compgen -f -- \"$cur\"))\n    if [[ $COMP_CWORD == 1 ]]; then\n        \
         COMPREPLY+=($(compgen -W \"{}\" -- \"$cur\"))\n    fi\n}}\ncomplete -o filenames -F _batch_render batch-render\n",
        commands.join(" "),
    );
    out
}

/// A text in the single quotes of fish.
fn fish_quoted(text: &str) -> String {
    format!("'{}'", text.replace('\\', "\\\\").replace('\'', "\\'"))
}

/// A text in the single quotes of zsh.
fn zsh_quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', "'\\''"))
}

fn fish(known: &[Known<'_>]) -> String {
    let mut out = String::new();
    for command in &known[1..] {
        let about = fish_quoted(&command.about);
        let _ = writeln!(
            out,
            "complete -c batch-render -n __fish_use_subcommand -a {} -d {about}",
            command.name
        );
    }
    for command in known {
        let condition = match command.name {
            "" => format!("not __fish_seen_subcommand_from {}", commands(known).join(" ")),
            name => format!("__fish_seen_subcommand_from {name}"),
        };
        for flag in &command.flags {
            let _ = write!(out, "complete -c batch-render -n '{condition}'");
            for name in names(flag) {
                let _ = write!(out, " -l {name}");
            }
            if let Some(short) = flag.get_short() {
                let _ = write!(out, " -s {short}");
            }
            match &values(flag)[..] {
                "" if takes_value(flag) => out += " -r",
                "" => {}
                values => {
                    let _ = write!(out, " -x -a '{values}'");
                }
            }
            let _ = writeln!(out, " -d {}", fish_quoted(&about(flag)));
        }
    }
    out
}

fn zsh(known: &[Known<'_>]) -> String {
    let mut out = String::from(
        "#compdef batch-render\n_batch_render() {\n    local -a flags commands\n    case ${words[2]} in\n",
    );
    for command in known[1..].iter().chain(&known[..1]) {
        let pattern = if command.name.is_empty() { "*" } else { command.name };
        let _ = writeln!(out, "    {pattern}) flags=(");
        for flag in &command.flags {
            let about = about(flag).replace('[', "(").replace(']', ")").replace(':', "\\:");
            let value = match &values(flag)[..] {
                "" if takes_value(flag) => ":value:_files".to_owned(),
                "" => String::new(),
                values => format!(":value:({values})"),
            };
            let sign = if takes_value(flag) { "=" } else { "" };
            for name in names(flag) {
                let _ = writeln!(
                    out,
                    "        {}",
                    zsh_quoted(&format!("*--{name}{sign}[{about}]{value}"))
                );
            }
        }
        out += "    ) ;;\n";
    }
    out += "    esac\n    commands=(\n";
    for command in &known[1..] {
        let about = command.about.replace(':', "\\:");
        let _ = writeln!(out, "        {}", zsh_quoted(&format!("{}:{about}", command.name)));
    }
    out += "    )\n    if (( CURRENT == 2 )) && [[ ${words[2]} != -* ]]; then\n        _describe command commands\n        _files\n        return\n    \
            fi\n    _arguments -s $flags '*:file:_files'\n}\n_batch_render \"$@\"\n";
    out
}
