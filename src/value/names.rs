//! Unknown names: one message and one help text for all of them.

use std::{collections::HashSet, error, fmt};

use serde::de;

use super::{Problem, Span, one_line};

/// The longest name that is shown whole and compared with known ones, in bytes.
const LONGEST_NAME: usize = 80;

/// A name that is not known.
///
/// Displayed on one line: "unknown key `radus` (did you mean `radius`?)".
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownName {
    /// The message, without the help.
    message: String,
    /// The name that was probably meant.
    suggestion: Option<String>,
    /// The help where no known name is similar.
    fallback: Option<String>,
}

impl UnknownName {
    /// A `name` that is not among the `known` ones. `what` says what it is the name of, such as
    /// "key" or "format".
    pub fn new<'a>(what: &str, name: &str, known: impl IntoIterator<Item = &'a str>) -> Self {
        let mut known: Vec<&str> = known.into_iter().collect();
        // Models may name several things alike.
        let mut seen = HashSet::new();
        known.retain(|name| seen.insert(*name));
        let is_short = name.len() <= LONGEST_NAME;
        let suggestion = if is_short { most_similar(name, &known) } else { None };
        Self {
            message: format!("unknown {what} `{}`", one_line(name, LONGEST_NAME)),
            suggestion: suggestion.map(str::to_owned),
            fallback: Some(if known.is_empty() {
                format!("no {what} is allowed here")
            } else {
                format!("expected {}", one_of(known))
            }),
        }
    }

    /// The same with another help text, or with none, where no known name is similar.
    pub fn with_fallback(mut self, help: Option<String>) -> Self {
        self.fallback = help;
        self
    }

    /// The same with the known name that is meant, whatever its spelling.
    pub fn with_suggestion(mut self, name: &str) -> Self {
        self.suggestion = Some(name.to_owned());
        self
    }

    /// The known name that was probably meant.
    pub fn suggestion(&self) -> Option<&str> {
        self.suggestion.as_deref()
    }

    /// The hint for the correction of the name.
    pub fn help(&self) -> Option<String> {
        match &self.suggestion {
            Some(name) => Some(format!("did you mean `{name}`?")),
            None => self.fallback.clone(),
        }
    }

    /// The problem of the name at `span` in a scene file.
    pub fn at(&self, span: Span) -> Problem {
        Problem {
            span: Some(span),
            message: self.message.clone(),
            help: self.help(),
        }
    }
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        match self.help() {
            Some(help) => write!(f, " ({help})"),
            None => Ok(()),
        }
    }
}

impl error::Error for UnknownName {}

/// The error of serde about a name that is not among the `known` ones, in serde's words.
pub fn unknown_name<E: de::Error>(what: &str, name: &str, known: &[&str]) -> E {
    E::custom(format_args!(
        "unknown {what} `{name}`, expected {}",
        one_of(known.iter().copied())
    ))
}

/// The text "one of `a`, `b`".
pub fn one_of<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let quoted: Vec<_> = names.into_iter().map(|name| format!("`{name}`")).collect();
    format!("one of {}", quoted.join(", "))
}

/// The candidate with the most similar spelling, if it is similar enough to be a suggestion. Case
/// and the characters between words do not count.
fn most_similar<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let plain = |s: &str| s.to_lowercase().replace([' ', '.', '-'], "_");
    let word = plain(word);
    candidates
        .iter()
        .map(|c| (strsim::damerau_levenshtein(&word, &plain(c)), *c))
        .filter(|(distance, c)| *distance <= 1 + c.len().min(word.len()) / 4)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, c)| c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similar_names_are_suggested_and_others_are_listed() {
        let text = |name| UnknownName::new("key", name, ["center", "radius"]).to_string();
        assert_eq!(text("radus"), "unknown key `radus` (did you mean `radius`?)");
        assert_eq!(text("Centre"), "unknown key `Centre` (did you mean `center`?)");
        let filter = UnknownName::new("filter", "Blackman Harris", ["box", "blackman-harris"]);
        assert_eq!(filter.suggestion(), Some("blackman-harris"));
        let twice = UnknownName::new("node", "wheel", ["c", "c", "lamp", "c"]).to_string();
        assert_eq!(twice, "unknown node `wheel` (expected one of `c`, `lamp`)");
        assert_eq!(
            text("banana"),
            "unknown key `banana` (expected one of `center`, `radius`)"
        );
    }

    #[test]
    fn the_help_for_a_name_that_is_not_similar_can_be_replaced() {
        let name = UnknownName::new("key", "banana", ["radius"]);
        assert_eq!(name.clone().with_fallback(None).to_string(), "unknown key `banana`");
        assert_eq!(
            name.with_fallback(Some("peel it".into())).help().as_deref(),
            Some("peel it")
        );
        assert_eq!(
            UnknownName::new("key", "radius", []).help().as_deref(),
            Some("no key is allowed here")
        );
    }
}
