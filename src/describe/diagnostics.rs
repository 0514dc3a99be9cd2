//! Diagnostics of scene files: each problem with its line, underlined.

use std::{fmt, ops::Range, path::PathBuf, sync::Arc};

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

use super::{FileKind, Overrides};
use crate::{
    math::sorting,
    value::{Problem, one_line, visible},
};

/// The most characters of a message before it is shortened.
const LONGEST_MESSAGE: usize = 1000;
/// The most bytes of a line before it is shortened.
const LONGEST_LINE: usize = 400;

/// A scene file's text, where it came from, and the values that replace some of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    pub path: PathBuf,
    pub text: Arc<str>,
    pub overrides: Overrides,
    pub kind: FileKind,
}

impl Source {
    /// A text without overrides.
    pub fn new(path: PathBuf, text: impl Into<Arc<str>>) -> Self {
        Self {
            path,
            text: text.into(),
            overrides: Overrides::default(),
            kind: FileKind::Scene,
        }
    }

    /// The text that a model by itself stands for.
    pub fn of_model(path: PathBuf, text: impl Into<Arc<str>>) -> Self {
        Self {
            kind: FileKind::Model,
            ..Self::new(path, text)
        }
    }

    /// The text, if it is in the file.
    pub(super) fn shown_text(&self) -> &str {
        match self.kind {
            FileKind::Scene => &self.text,
            FileKind::Model => "",
        }
    }

    /// The same text with these overrides.
    pub fn with(self, overrides: Overrides) -> Self {
        Self { overrides, ..self }
    }
}

/// All problems of a scene file, in the order of their places.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostics {
    source: Source,
    problems: Vec<Problem>,
}

impl Diagnostics {
    /// `None` if there is no problem.
    pub fn new(source: &Source, mut problems: Vec<Problem>) -> Option<Self> {
        sorting::sort_by_key(&mut problems, |p| p.span.as_ref().map_or(usize::MAX, |s| s.start));
        problems.dedup();
        (!problems.is_empty()).then(|| Self {
            source: source.clone(),
            problems,
        })
    }

    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// Whether no problem is that of a file.
    pub fn are_of_overrides(&self) -> bool {
        let spans = self.problems.iter().map(|problem| problem.span.as_ref());
        spans
            .into_iter()
            .all(|span| span.is_some_and(|span| self.source.overrides.is_request(span)))
    }

    /// Each problem with the line that has it, or with the origin of its value.
    pub fn messages(&self) -> Vec<String> {
        self.problems.iter().map(|p| self.message(p)).collect()
    }

    fn message(&self, problem: &Problem) -> String {
        let path = self.source.path.display().to_string();
        let text = self.source.shown_text();
        let message = one_line(&problem.message, LONGEST_MESSAGE);
        let help = problem.help.as_deref().map(|help| one_line(help, LONGEST_MESSAGE));
        let span = problem.span.clone();
        if let Some(origin) = span.as_ref().and_then(|span| self.source.overrides.origin(span)) {
            let help = help.map(|help| format!(" ({help})")).unwrap_or_default();
            return format!("{origin}: {message}{help}");
        }
        let title = Level::ERROR.no_name().primary_title(message.as_ref());
        let span = span.filter(|s| s.start < text.len().max(1));
        let mut report = match span {
            Some(span) => {
                let excerpt = Excerpt::new(text, first_line(text, span));
                title.element(
                    Snippet::source(excerpt.text)
                        .line_start(excerpt.line)
                        .path(path.as_str())
                        .annotation(AnnotationKind::Primary.span(excerpt.span)),
                )
            }
            None => title.element(annotate_snippets::Origin::path(path.as_str())),
        };
        if let Some(help) = &help {
            report = report.element(Level::HELP.message(help.as_ref()));
        }
        visible(&Renderer::plain().render(&[report])).into_owned()
    }
}

/// The text around a span.
struct Excerpt<'a> {
    text: &'a str,
    /// The number of its first line, from 1.
    line: usize,
    span: Range<usize>,
}

impl<'a> Excerpt<'a> {
    /// The whole `text`, or only the part near the span if its line is very long.
    fn new(text: &'a str, span: Range<usize>) -> Self {
        let from = text[..span.start].rfind('\n').map_or(0, |n| n + 1);
        let to = text[span.start..].find('\n').map_or(text.len(), |n| span.start + n);
        if to - from <= LONGEST_LINE {
            return Self { text, line: 1, span };
        }
        let boundary = |at: usize| (0..=at).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
        let begin = boundary(span.start.saturating_sub(LONGEST_LINE / 4).max(from));
        let end = boundary((span.start + LONGEST_LINE / 2).min(to));
        Self {
            text: &text[begin..end],
            line: 1 + text[..begin].bytes().filter(|b| *b == b'\n').count(),
            span: span.start - begin..span.end.min(end) - begin,
        }
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.messages().join("\n"))
    }
}

/// Shortens a span of several lines, such as a table, to its first line.
fn first_line(text: &str, span: Range<usize>) -> Range<usize> {
    let end = span.end.min(text.len());
    let cut = text[span.start..end].find('\n').map_or(end, |n| span.start + n);
    span.start..cut.max(span.start)
}

impl std::error::Error for Diagnostics {}
