//! Problems shown in the file that has them: the offending line, underlined.

use std::{fmt, path::PathBuf, sync::Arc};

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

use crate::value::Problem;

/// A scene file's text and where it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    pub path: PathBuf,
    pub text: Arc<str>,
}

/// Everything wrong with a scene file, in the order in which it stands there.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostics {
    source: Source,
    problems: Vec<Problem>,
}

impl Diagnostics {
    /// `None` where there is no problem.
    pub fn new(source: &Source, mut problems: Vec<Problem>) -> Option<Self> {
        problems.sort_by_key(|p| p.span.as_ref().map_or(usize::MAX, |s| s.start));
        problems.dedup();
        (!problems.is_empty()).then(|| Self {
            source: source.clone(),
            problems,
        })
    }

    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// Each problem with the line that has it.
    pub fn messages(&self) -> Vec<String> {
        self.problems.iter().map(|p| self.message(p)).collect()
    }

    fn message(&self, problem: &Problem) -> String {
        let path = self.source.path.display().to_string();
        let text: &str = &self.source.text;
        let title = Level::ERROR.no_name().primary_title(problem.message.as_str());
        let span = problem.span.clone().filter(|s| s.start < text.len().max(1));
        let mut report = match span {
            Some(span) => title.element(
                Snippet::source(text)
                    .path(path.as_str())
                    .annotation(AnnotationKind::Primary.span(first_line(text, span))),
            ),
            None => title.element(annotate_snippets::Origin::path(path.as_str())),
        };
        if let Some(help) = &problem.help {
            report = report.element(Level::HELP.message(help.as_str()));
        }
        Renderer::plain().render(&[report])
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.messages().join("\n"))
    }
}

/// A span of several lines underlines its first only: the rest of a table says nothing more.
fn first_line(text: &str, span: std::ops::Range<usize>) -> std::ops::Range<usize> {
    let end = span.end.min(text.len());
    let cut = text[span.start..end].find('\n').map_or(end, |n| span.start + n);
    span.start..cut.max(span.start)
}

impl std::error::Error for Diagnostics {}
