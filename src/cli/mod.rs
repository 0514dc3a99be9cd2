//! The process: arguments, exit codes, progress, logs.

mod ahead;
mod all_scenes;
mod args;
mod arguments;
mod bench;
mod bench_args;
mod choices;
mod closed_pipe;
mod compare;
mod compare_args;
mod completions;
mod convert;
mod convert_args;
mod create;
mod denoise;
mod denoise_args;
mod events;
mod examples;
mod existing_args;
mod exit;
mod failures;
mod figure_files;
mod figures;
#[cfg(feature = "viewer")]
mod fly;
#[cfg(feature = "viewer")]
mod fly_args;
mod gif;
mod heading;
mod inventory;
mod job;
mod log;
mod man;
mod memory;
mod opened;
mod outlets;
mod preview;
mod progress;
mod replay;
mod report_page;
mod request;
mod scene_failures;
mod scenes;
mod scenes_page;
mod settings;
mod signals;
mod simd;
mod small_picture;
mod standard_input;
mod stats;
mod stray;
mod stream;
mod submit;
mod submit_help;
mod summary;
mod threads;
mod turns;
mod values;
mod version;
mod view_args;
mod y4m;

use std::{path::PathBuf, process::ExitCode};

use clap::Parser;

use args::Args;
use arguments::arguments;
use stream::PipeClosed;

/// Runs the program; the exit code tells who must act (docs/interface.md).
pub fn main() -> ExitCode {
    let args = match Args::try_parse_from(arguments()) {
        Ok(args) => args,
        Err(e) => {
            // Help goes to stdout, errors to stderr; a closed pipe is nobody's fault.
            let e = stray::reworded(&e).unwrap_or(e);
            let _ = e.print();
            return ExitCode::from(if e.use_stderr() { exit::USAGE } else { exit::OK });
        }
    };
    let render = &args.render;
    let scenes = render
        .scene
        .iter()
        .chain(&render.more)
        .filter(|_| args.command.is_none());
    if let Some(e) = stray::mistyped_command(scenes.map(PathBuf::as_path)) {
        let _ = e.print();
        return ExitCode::from(exit::USAGE);
    }
    log::start(&args);
    signals::survive_large_files();
    match job::run(&args) {
        Ok(()) => ExitCode::from(exit::OK),
        Err(e) => {
            if !e.is::<PipeClosed>() {
                log::report(&e);
            }
            ExitCode::from(exit::code(&e))
        }
    }
}
