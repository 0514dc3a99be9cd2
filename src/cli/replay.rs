//! Command lines made from the one of this process.
//!
//! A [`Replay`] holds what clap has parsed, in one form: `--flag=value` for each value that was given, whatever the spelling was
//! (`-vr 1-5`, `-r1-5`, `--range 1-5`). Flags are left out or replaced by their long names.

use std::{
    ffi::{OsStr, OsString},
    path::Path,
};

use batch_render::error::Error;
use clap::{Arg, ArgAction, ArgMatches, CommandFactory, parser::ValueSource};

use super::{args::Args, arguments::arguments, standard_input::STANDARD_INPUT};

/// The arguments of a command line, after the subcommand.
#[derive(Clone, Debug)]
pub struct Replay {
    program: OsString,
    /// Each word with the long name of its flag; `None` for a positional argument.
    words: Vec<(Option<String>, OsString)>,
}

impl Replay {
    /// The arguments of this process.
    ///
    /// # Errors
    /// They are wrong usage; a process with such arguments has ended before.
    pub fn of_process() -> Result<Self, Error> {
        Self::parse(arguments())
    }

    /// The arguments of a whole command line, whose first word is the program.
    pub fn parse(typed: impl IntoIterator<Item = OsString>) -> Result<Self, Error> {
        let typed: Vec<OsString> = typed.into_iter().collect();
        let program = typed.first().cloned().unwrap_or_default();
        let mut command = Args::command();
        let matches = command
            .try_get_matches_from_mut(typed)
            .map_err(|e| Error::Usage(e.to_string()))?;
        let (command, matches) = match matches.subcommand() {
            Some((name, matches)) => (command.find_subcommand(name).expect("clap has parsed it"), matches),
            None => (&command, &matches),
        };
        let words = command
            .get_arguments()
            .flat_map(|arg| {
                words(arg, matches)
                    .into_iter()
                    .map(|word| (arg.get_long().map(str::to_owned), word))
            })
            .collect();
        Ok(Self { program, words })
    }

    /// Leaves out flags, by their long names.
    pub fn without(mut self, flags: &[&str]) -> Self {
        self.words
            .retain(|(own, _)| !own.as_deref().is_some_and(|own| flags.contains(&own)));
        self
    }

    /// Leaves out the values of a flag that are not to be kept.
    pub fn retain(mut self, flag: &str, keep: impl Fn(&Path) -> bool) -> Self {
        let start = assignment(flag, OsStr::new(""));
        self.words.retain(|(own, word)| {
            let value = word.as_encoded_bytes().strip_prefix(start.as_encoded_bytes());
            let value = value.map(String::from_utf8_lossy);
            own.as_deref() != Some(flag) || value.is_none_or(|value| keep(Path::new(&*value)))
        });
        self
    }

    /// Replaces all values of a flag by this one.
    pub fn with(self, flag: &str, value: impl AsRef<OsStr>) -> Self {
        let mut new = self.without(&[flag]);
        new.words
            .push((Some(flag.to_owned()), assignment(flag, value.as_ref())));
        new
    }

    /// Replaces the scenes by this one.
    pub fn with_scene(mut self, scene: &Path) -> Self {
        self.words.retain(|(own, _)| own.is_some());
        self.words.insert(0, (None, positional(scene.as_os_str())));
        self
    }

    /// Replaces the value of each flag that has one by what `value` makes of the long name and it. What is not UTF-8 is kept.
    pub fn map_values(mut self, value: impl Fn(&str, &str) -> String) -> Self {
        for (flag, word) in &mut self.words {
            let Some(flag) = flag else { continue };
            let start = format!("--{flag}=");
            if let Some(old) = word.to_str().and_then(|word| word.strip_prefix(&start)) {
                *word = assignment(flag, value(flag, old).as_ref());
            }
        }
        self
    }

    /// The values of flags, with their long names, as far as they are UTF-8.
    pub fn values(&self) -> impl Iterator<Item = (&str, &str)> {
        self.words.iter().filter_map(|(flag, word)| {
            let flag = flag.as_deref()?;
            let value = word
                .to_str()?
                .strip_prefix("--")?
                .strip_prefix(flag)?
                .strip_prefix('=')?;
            Some((flag, value))
        })
    }

    /// The command line, with the program.
    pub fn command_line(self) -> Vec<OsString> {
        let program = self.program.clone();
        [program].into_iter().chain(self.arguments()).collect()
    }

    /// Adds a flag without a value, unless it is there.
    pub fn with_flag(self, flag: &str) -> Self {
        let mut new = self.without(&[flag]);
        new.words.push((Some(flag.to_owned()), format!("--{flag}").into()));
        new
    }

    /// Whether a flag was given, by its long name.
    pub fn has(&self, flag: &str) -> bool {
        self.words.iter().any(|(own, _)| own.as_deref() == Some(flag))
    }

    /// The arguments, without the program and the subcommand.
    pub fn arguments(self) -> Vec<OsString> {
        self.words.into_iter().map(|(_, word)| word).collect()
    }

    /// The line for a shell, which begins with this program.
    pub fn shell_line(self) -> String {
        shell_line(self.command_line())
    }
}

/// The words of one argument, as far as it was typed.
fn words(arg: &Arg, matches: &ArgMatches) -> Vec<OsString> {
    let id = arg.get_id().as_str();
    let is_typed = matches.value_source(id) == Some(ValueSource::CommandLine);
    let is_value = matches!(arg.get_action(), ArgAction::Set | ArgAction::Append);
    match (arg.get_long(), arg.get_action()) {
        _ if !is_typed => Vec::new(),
        (Some(flag), ArgAction::SetTrue) => vec![format!("--{flag}").into()],
        (Some(flag), ArgAction::Count) => vec![format!("--{flag}").into(); matches.get_count(id).into()],
        _ if !is_value => Vec::new(),
        (flag, _) => {
            let delimiter = arg.get_value_delimiter().unwrap_or(',').to_string();
            let occurrences = matches.get_raw_occurrences(id).into_iter().flatten();
            let join = |values: Vec<&OsStr>| values.join(OsStr::new(&delimiter));
            match flag {
                Some(flag) => occurrences
                    .map(|values| assignment(flag, &join(values.collect())))
                    .collect(),
                None => occurrences.flatten().map(positional).collect(),
            }
        }
    }
}

fn assignment(flag: &str, value: &OsStr) -> OsString {
    let mut word = OsString::from(format!("--{flag}="));
    word.push(value);
    word
}

/// A path as a positional argument, which no parser takes for a flag.
fn positional(path: &OsStr) -> OsString {
    if path.as_encoded_bytes().starts_with(b"-") && path != STANDARD_INPUT {
        Path::new(".").join(path).into()
    } else {
        path.to_owned()
    }
}

/// The words for the shell of this system: on Windows for its command prompt and PowerShell.
pub fn shell_line(words: impl IntoIterator<Item = impl AsRef<OsStr>>) -> String {
    let word = |word| match cfg!(windows) {
        true => windows_quoted(word),
        false => quoted(word),
    };
    let words: Vec<String> = words.into_iter().map(word).collect();
    words.join(" ")
}

/// The word for the command prompt. PowerShell reads it alike if it has neither `$`, a backquote nor a quote.
fn windows_quoted(word: impl AsRef<OsStr>) -> String {
    let text = word.as_ref().to_string_lossy();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_=+./\\:#".contains(c);
    if !text.is_empty() && !text.starts_with('#') && text.chars().all(is_plain) {
        return text.into_owned();
    }
    // Programs take backslashes before a quote by twos.
    let (mut quoted, mut backslashes) = (String::from('"'), 0);
    for c in text.chars() {
        if c == '"' {
            quoted.extend(std::iter::repeat_n('\\', backslashes + 1));
        }
        backslashes = if c == '\\' { backslashes + 1 } else { 0 };
        quoted.push(c);
    }
    quoted.extend(std::iter::repeat_n('\\', backslashes));
    quoted.push('"');
    quoted
}

/// The word for a shell of Unix. A word that is not UTF-8 becomes `$'...'` with octal numbers.
pub fn quoted(word: impl AsRef<OsStr>) -> String {
    let word = word.as_ref();
    match word.to_str() {
        Some(text) => {
            let quoter = shlex::Quoter::new().allow_nul(true);
            // A shell needs no quotes around `--flag=`.
            let start = text
                .strip_prefix("--")
                .and_then(|rest| rest.find('='))
                .map_or(0, |at| at + 3);
            let (flag, value) = text.split_at(start);
            let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '=';
            let (flag, value) = if flag.chars().all(is_plain) {
                (flag, value)
            } else {
                ("", text)
            };
            let value = quoter.quote(value).expect("only NUL is refused, and it is allowed");
            format!("{flag}{value}")
        }
        None => {
            let escaped: String = word
                .as_encoded_bytes()
                .iter()
                .map(|byte| format!("\\{byte:03o}"))
                .collect();
            format!("$'{escaped}'")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(typed: &[&str]) -> Replay {
        Replay::parse(typed.iter().map(OsString::from)).expect("the command line is right")
    }

    fn line(typed: &[&str]) -> String {
        let words = parse(typed).arguments();
        words
            .iter()
            .map(|word| word.to_str().expect("UTF-8"))
            .collect::<Vec<_>>()
            .join(" ")
    }

    #[test]
    fn every_spelling_of_a_flag_has_one_form() {
        for range in [
            &["-r", "1-5"][..],
            &["-r1-5"],
            &["-r=1-5"],
            &["--range", "1-5"],
            &["--range=1-5"],
        ] {
            assert_eq!(line(&[&["b", "s.toml"], range].concat()), "s.toml --range=1-5");
        }
        assert_eq!(line(&["b", "s.toml", "-vr", "1-5"]), "s.toml --range=1-5 --verbose");
        assert_eq!(
            line(&["b", "s.toml", "-vvr1-5"]),
            "s.toml --range=1-5 --verbose --verbose"
        );
    }

    #[test]
    fn a_flag_is_left_out_or_replaced_whatever_its_spelling() {
        let replay = parse(&["b", "s.toml", "-vr", "1-5", "--samples", "4"]);
        let words = replay.clone().without(&["range"]).arguments();
        assert_eq!(words, ["s.toml", "--samples=4", "--verbose"]);
        let words = replay.with("range", "-5").arguments();
        assert_eq!(words, ["s.toml", "--samples=4", "--verbose", "--range=-5"]);
    }

    #[test]
    fn values_that_start_with_a_hyphen_stay_values() {
        assert_eq!(
            line(&["b", "--exposure", "-1.5", "-r", "-5-5", "--", "-s.toml"]),
            "./-s.toml --range=-5-5 --exposure=-1.5"
        );
    }

    #[test]
    fn repeated_flags_and_lists_keep_their_order() {
        assert_eq!(
            line(&[
                "b",
                "s.toml",
                "-o",
                "b.exr",
                "--aovs",
                "N,depth",
                "-oa.png",
                "--aovs=denoise"
            ]),
            "s.toml --output=b.exr --output=a.png --aovs=N,depth --aovs=denoise"
        );
    }

    #[test]
    fn a_flag_without_its_value_has_the_same_meaning() {
        assert_eq!(line(&["b", "s.toml", "--png-depth"]), "s.toml --png-depth=");
    }

    #[test]
    fn arguments_begin_after_the_subcommand() {
        let typed = [
            "b",
            "submit",
            "-v",
            "submit",
            "--engine=slurm",
            "--bundle",
            "out",
            "--samples=4",
        ];
        let words = parse(&typed).without(&["engine", "bundle"]).arguments();
        assert_eq!(words, ["submit", "--samples=4", "--verbose"]);
    }

    #[test]
    fn a_shell_reads_the_words_that_were_typed() {
        for word in [
            "",
            "a b",
            "it's",
            "$HOME",
            "\"",
            "a\\b",
            "`x`",
            "#1",
            "~",
            "*",
            "a\nb",
            "^!",
            "--x=f.####.exr",
        ] {
            assert_eq!(shlex::split(&quoted(word)), Some(vec![word.to_owned()]));
        }
    }

    #[test]
    fn words_for_windows_have_double_quotes_and_plain_backslashes() {
        let cases = [
            ("C:\\out\\f.####.exr", "C:\\out\\f.####.exr"),
            ("C:\\my out\\", "\"C:\\my out\\\\\""),
            (
                "--stereo=ipd=0.063,convergence=2",
                "\"--stereo=ipd=0.063,convergence=2\"",
            ),
            ("a=\\\"b\"", "\"a=\\\\\\\"b\\\"\""),
            ("f.%04d.png", "\"f.%04d.png\""),
            ("", "\"\""),
        ];
        for (word, expected) in cases {
            assert_eq!(windows_quoted(word), expected);
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_path_that_is_not_utf8_is_kept() {
        use std::os::unix::ffi::OsStringExt;

        let path = OsString::from_vec(b"a\xff1.toml".to_vec());
        let replay = Replay::parse(["b".into(), path.clone()]).expect("the command line is right");
        assert_eq!(replay.clone().arguments(), [path]);
        assert_eq!(replay.shell_line(), "b $'\\141\\377\\061\\056\\164\\157\\155\\154'");
    }
}
