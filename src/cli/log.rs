//! The log, on stderr.

use std::io::{IsTerminal, Write};

use batch_render::error::Error;
use tracing::Level;

use super::args::Args;

/// Starts logging as the arguments want it.
pub fn start(args: &Args) {
    let level = match (args.quiet, args.verbose) {
        (true, _) => Level::ERROR,
        (false, 0) => Level::WARN,
        (false, 1) => Level::INFO,
        (false, _) => Level::DEBUG,
    };
    let plain = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal() && !plain)
        .with_target(false)
        .without_time()
        .init();
}

/// Warns whatever level the arguments want: a picture is not what it should be.
pub fn warn_always(text: &str) {
    if tracing::enabled!(Level::WARN) {
        tracing::warn!("{text}");
    } else {
        let _ = writeln!(std::io::stderr(), "warning: {text}");
    }
}

/// Says why the program ends.
pub fn report(error: &anyhow::Error) {
    let own = error.downcast_ref::<Error>();
    let messages = own.map_or_else(|| vec![format!("{error:#}")], Error::messages);
    for message in messages {
        // A closed stderr leaves nobody to tell.
        let _ = writeln!(std::io::stderr(), "error: {message}");
    }
    if let Some(help) = own.and_then(Error::help) {
        let _ = writeln!(std::io::stderr(), "help: {help}");
    }
}
