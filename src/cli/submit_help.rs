//! The arguments that the help of `submit` shows.

use clap::Arg;

/// Arguments of a job that `submit` refuses, or that its tasks get with values of their own. The help leaves them out.
const HIDDEN: [&str; 11] = [
    "more",
    "input_format",
    "output_format",
    "part",
    "part_base",
    "list_stale",
    "fail_existing",
    "check",
    "dry_run",
    "denoise_step",
    "progress",
];

/// The argument as the help of `submit` has it.
pub fn shown(arg: Arg) -> Arg {
    match arg.get_id().as_str() {
        "scene" => arg.help("The scene file, or a model: OBJ, glTF, GLB, PLY or STL"),
        id if HIDDEN.contains(&id) => arg.hide(true),
        _ => arg,
    }
}
