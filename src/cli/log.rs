//! The log, on stderr.

use std::{fmt, io::Write};

use batch_render::{
    error::Error,
    value::{one_line, visible},
    warnings::Warnings,
};
use tracing::{Event, Level, Subscriber, field::Field};
use tracing_subscriber::{
    fmt::{FmtContext, FormatEvent, FormatFields, format::Writer},
    registry::LookupSpan,
};

use super::args::Args;

/// The most characters of a message before it is shortened.
const LONGEST_MESSAGE: usize = 2000;

/// Starts logging at the level of the arguments.
pub fn start(args: &Args) {
    let level = match (args.quiet, args.verbose) {
        (true, _) => Level::ERROR,
        (false, 0) => Level::WARN,
        (false, 1) => Level::INFO,
        (false, _) => Level::DEBUG,
    };
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .event_format(OneLine)
        .init();
}

/// The level and the message of an event on one line, without control characters.
struct OneLine;

impl<S, N> FormatEvent<S, N> for OneLine
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    N: for<'a> FormatFields<'a> + 'static,
{
    fn format_event(&self, _: &FmtContext<'_, S, N>, mut writer: Writer<'_>, event: &Event<'_>) -> fmt::Result {
        let mut message = String::new();
        event.record(&mut |field: &Field, value: &dyn fmt::Debug| {
            if field.name() == "message" {
                message = format!("{value:?}");
            }
        });
        let level = match *event.metadata().level() {
            Level::ERROR => "error",
            Level::WARN => "warning",
            Level::INFO => "info",
            _ => "debug",
        };
        writeln!(writer, "{level}: {}", one_line(&message, LONGEST_MESSAGE))
    }
}

/// Logs the warnings of a job that were not logged before, one line for each kind.
pub fn warnings(warnings: &Warnings) {
    for line in warnings.take_lines() {
        tracing::warn!("{line}");
    }
}

/// Logs the warnings that are left when a command ends, also by an error.
pub struct LastWarnings(pub Warnings);

impl Drop for LastWarnings {
    fn drop(&mut self) {
        warnings(&self.0);
    }
}

/// Says why the program ends.
pub fn report(error: &anyhow::Error) {
    let own = error.downcast_ref::<Error>();
    let messages = own.map_or_else(|| vec![format!("{error:#}")], Error::messages);
    for message in messages {
        let shown = match own {
            // The message contains lines of a file.
            Some(error) if error.has_excerpts() => visible(&message),
            _ => one_line(&message, LONGEST_MESSAGE),
        };
        // Ignores a closed stderr.
        let _ = writeln!(std::io::stderr(), "error: {shown}");
    }
    if let Some(help) = own.and_then(Error::help) {
        let _ = writeln!(std::io::stderr(), "help: {help}");
    }
}
