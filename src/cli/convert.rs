//! `batch-render convert-camera`: cameras of one program as files of another.

use std::path::PathBuf;

use super::{convert_args::ConvertArgs, log, memory, progress::say, summary::plural};
use batch_render::{
    assets::{
        Files, MemoryBudget,
        camera_path::{CameraPathOptions, Conversion, convert, files_of},
    },
    error::Error,
    output::atomic,
};

/// Runs the command.
pub fn run(args: &ConvertArgs, quiet: bool) -> anyhow::Result<()> {
    let files = Files::new(true, MemoryBudget::new(Some(memory::default_limit())));
    let settings = Conversion {
        options: CameraPathOptions {
            fps: args.fps.filter(|fps| *fps > 0.0),
            rotation_order: args.rotation_order,
            pose: None,
        },
        resolution: args.resolution,
        lens: args.lens.clone(),
    };
    let converted = convert(&args.from, &args.to, &settings, &files).map_err(Error::from)?;
    let inputs = files_of(&args.from).into_iter().chain(args.lens.clone());
    let inputs: Vec<PathBuf> = inputs.filter_map(|path| path.canonicalize().ok()).collect();
    for (output, _) in &converted.files {
        if output.canonicalize().is_ok_and(|path| inputs.contains(&path)) {
            let (output, input) = (output.clone(), args.from.clone());
            return Err(Error::OverwritesInput { output, input }.into());
        }
        atomic::check(output).map_err(Error::Output)?;
    }
    atomic::write_together(&converted.files).map_err(Error::Output)?;
    log::warnings(files.warnings());
    if let Some(lost) = &converted.lost {
        log::warn(&format!("{lost}: {}", args.to.display()));
    }
    if !quiet {
        let cameras = plural(converted.frames, "camera");
        say(&format!("{}: {cameras} written", args.to.display()));
    }
    Ok(())
}
