//! The arguments of `batch-render compare`.

use std::path::PathBuf;

use batch_render::compare::{Measures, PassMeasures};
use clap::{Args as ClapArgs, ValueEnum};

use super::values::not_negative;

pub const EXAMPLES: &str = "\
Examples:
  batch-render compare expected.exr out.exr                      exit code 1 if they differ at all
  batch-render compare expected/ out/ --tolerance 0.02           each picture of two folders, by FLIP
  batch-render compare expected/ out/ --metric pixels --limit 0.01 --tolerance 0.001
  batch-render compare expected/ out/ -o differences/            a map of FLIP for each picture
  batch-render compare expected.exr out.exr --passes=depth,N     two passes beside the picture
  batch-render compare expected/ out/ --tolerance 0.02 --update  take what differs as the new references";

#[derive(Debug, ClapArgs)]
pub struct CompareArgs {
    /// The picture that is right, or a folder of such
    pub reference: PathBuf,

    /// The picture to judge, or a folder of pictures of the same names
    pub test: PathBuf,

    /// Measure that the tolerance is for
    #[arg(long, value_enum, value_name = "NAME", default_value_t = Metric::Flip)]
    pub metric: Metric,

    /// Largest value of the measure that is accepted; beyond it the exit code is 1. With 0 pictures are equal
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = not_negative)]
    pub tolerance: f64,

    /// Difference of a number that `pixels` does not count [default: 1/255]
    #[arg(long, value_name = "X", default_value_t = 1.0 / 255.0, hide_default_value = true, value_parser = not_negative)]
    pub limit: f64,

    /// Also compare the passes of EXR files, those of the list, or `all`: depth,N,objectId
    ///
    /// Numbers are judged by --metric, or by `pixels` where that is flip or relmse; ids, also those of Cryptomatte, by
    /// the share of pixels that differ.
    #[arg(long, value_name = "LIST", num_args = 0..=1, require_equals = true, value_delimiter = ',')]
    pub passes: Option<Vec<String>>,

    /// Write a map of FLIP as PNG: black where pictures are equal; for folders a folder
    #[arg(short, long, value_name = "PATH")]
    pub output: Option<PathBuf>,

    /// Copy pictures beyond the tolerance, and new ones, over the references
    #[arg(long)]
    pub update: bool,

    /// Print one JSON object a picture
    #[arg(long)]
    pub json: bool,

    /// Threads to work on [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// A measure of the difference of two pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Metric {
    /// Mean of the difference that a viewer sees, from 0 to 1
    Flip,
    /// Root of the mean squared difference
    Rmse,
    /// Mean squared difference, relative to the reference
    Relmse,
    /// Share of pixels that differ by more than the limit
    Pixels,
    /// Largest difference of a number
    Largest,
}

impl CompareArgs {
    /// Whether these measures are within the tolerance. FLIP, RMSE and relMSE say nothing of alpha,
    /// whose error must be within it, too.
    pub fn accepts(&self, measures: &Measures) -> bool {
        let (value, alpha) = match self.metric {
            // What no display shows is a difference, too.
            Metric::Flip if self.tolerance == 0.0 => (measures.largest, 0.0),
            Metric::Flip => (measures.flip, measures.alpha_rmse),
            Metric::Rmse => (measures.rmse, measures.alpha_rmse),
            Metric::Relmse => (measures.relmse, measures.alpha_rmse),
            Metric::Pixels => (measures.pixels, 0.0),
            Metric::Largest => (measures.largest, 0.0),
        };
        value <= self.tolerance && alpha <= self.tolerance
    }

    /// Whether these measures of a pass are within the tolerance.
    pub fn accepts_pass(&self, measures: &PassMeasures) -> bool {
        let value = match self.metric {
            Metric::Flip | Metric::Relmse if self.tolerance == 0.0 => measures.largest,
            Metric::Flip | Metric::Relmse | Metric::Pixels => None,
            Metric::Rmse => measures.rmse,
            Metric::Largest => measures.largest,
        };
        value.unwrap_or(measures.pixels) <= self.tolerance
    }
}
