//! The log, on stderr.

use std::{fmt, io::Write};

use batch_render::{
    batch::FrameFailure,
    error::Error,
    value::{one_line, visible},
    warnings::Warnings,
};
use tracing::{Event, Level, Subscriber, field::Field};
use tracing_subscriber::{
    fmt::{FmtContext, FormatEvent, FormatFields, format::Writer},
    registry::LookupSpan,
};

use super::{args::Args, failures::advice, replay::Replay};

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
        // It would panic where nobody reads stderr.
        .log_internal_errors(false)
        .event_format(OneLine)
        .init();
}

/// The level and the message of an event on one line, without control characters. A message with the field `excerpt` has lines of a
/// file below it.
struct OneLine;

impl<S, N> FormatEvent<S, N> for OneLine
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    N: for<'a> FormatFields<'a> + 'static,
{
    fn format_event(&self, _: &FmtContext<'_, S, N>, mut writer: Writer<'_>, event: &Event<'_>) -> fmt::Result {
        let (mut message, mut has_excerpt) = (String::new(), false);
        event.record(&mut |field: &Field, value: &dyn fmt::Debug| match field.name() {
            "message" => message = format!("{value:?}"),
            "excerpt" => has_excerpt = true,
            _ => {}
        });
        let level = match *event.metadata().level() {
            Level::ERROR => "error",
            Level::WARN => "warning",
            Level::INFO => "info",
            _ => "debug",
        };
        let shown = match has_excerpt {
            true => visible(&message),
            false => one_line(&message, LONGEST_MESSAGE),
        };
        writeln!(writer, "{level}: {shown}")
    }
}

/// Logs the warnings of a job that were not logged before, one line for each kind.
pub fn warnings(warnings: &Warnings) {
    for line in warnings.take_lines() {
        tracing::warn!("{line}");
    }
}

/// Logs a warning.
pub fn warn(text: &str) {
    tracing::warn!("{text}");
}

/// Logs the warnings that are left when a command ends, also by an error.
pub struct LastWarnings(pub Warnings);

impl Drop for LastWarnings {
    fn drop(&mut self) {
        warnings(&self.0);
    }
}

/// Logs why a frame of a job with this command has failed, and the command to type after that.
pub fn failure(FrameFailure { frame, cause }: &FrameFailure, typed: &Replay) {
    let messages = cause.messages();
    let advice = advice(typed, *frame);
    if let ([message], false) = (&messages[..], cause.has_excerpts()) {
        tracing::error!("frame {frame}: {message}; {advice}");
        return;
    }
    for message in messages {
        match cause.has_excerpts() {
            true => tracing::error!(excerpt = true, "frame {frame}: {message}"),
            false => tracing::error!("frame {frame}: {message}"),
        }
    }
    tracing::error!("frame {frame}: {advice}");
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
