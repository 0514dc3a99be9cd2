//! The arguments of `batch-render denoise`.

use std::path::PathBuf;

use clap::Args as ClapArgs;

use super::choices::DenoiserKind;

#[derive(Debug, ClapArgs)]
pub struct DenoiseArgs {
    /// The files of the sequence: 'noisy.####.exr', with the passes of --aovs denoise
    pub input: String,

    /// The files to write: 'clean.####.exr'
    #[arg(short, long, value_name = "FILES")]
    pub output: String,

    /// Frames on each side of a frame that help it; 0 uses each frame alone
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(0..=16))]
    pub temporal: u32,

    /// Frames to denoise, such as 1-100 or 1,5,9; those around them are read too [default: all]
    #[arg(long, value_name = "FRAMES", allow_hyphen_values = true)]
    pub range: Option<String>,

    /// Filter that follows the mean over time
    #[arg(long, value_enum, value_name = "NAME", default_value_t = DenoiserKind::Nlm)]
    pub filter: DenoiserKind,

    /// Library of Open Image Denoise; without it that in the folder OIDN_DIR, or the system's
    #[arg(long, value_name = "LIB")]
    pub oidn_lib: Option<PathBuf>,

    /// Leave files that are there and are what would be written
    #[arg(long)]
    pub skip_existing: bool,

    /// Threads to work on [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}
