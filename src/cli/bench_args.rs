//! The arguments of `bench`.

use std::{num::NonZeroUsize, path::PathBuf};

use batch_render::batch::FrameRange;
use clap::Args as ClapArgs;

use super::settings::Settings;

#[derive(Debug, ClapArgs)]
pub struct BenchArgs {
    /// The scene file
    pub scene: PathBuf,

    /// Measure where the time of the whole picture goes, instead of rays alone
    #[arg(long, conflicts_with_all = ["embree", "report", "builds"])]
    pub picture: bool,

    /// Camera path of the picture; its first frame is measured unless `--range` names one
    #[arg(long, value_name = "FILE", requires = "picture")]
    pub frames: Option<PathBuf>,

    /// The frame to measure, in place of the first
    #[arg(short, long, value_name = "SPEC", allow_hyphen_values = true, requires = "picture")]
    pub range: Option<FrameRange>,

    #[command(flatten)]
    pub settings: Settings,

    /// Shared library of Embree 4, to measure it as well; the Python package embreex has one
    #[arg(long, value_name = "LIB")]
    pub embree: Option<PathBuf>,

    /// Write the figures here as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Write a page with tables and charts into this folder
    #[arg(long, value_name = "FOLDER")]
    pub report: Option<PathBuf>,

    /// Threads to measure with [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,

    /// Runs of each measurement, of which the median counts
    #[arg(long, value_name = "N", default_value = "5")]
    pub repetitions: NonZeroUsize,

    /// Builds of each tree, of which the median counts
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    pub builds: u16,
}
