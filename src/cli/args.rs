//! What was typed.

use std::path::PathBuf;

use batch_render::{assets::store::MissingAssets, sampler::SeedMode};
use clap::{
    Args as ClapArgs, Parser, Subcommand, ValueEnum,
    builder::{PossibleValuesParser, TypedValueParser},
};

/// Renders a scene along a camera path into EXR and PNG sequences.
#[derive(Debug, Parser)]
#[command(
    name = "batch-render",
    version,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true
)]
pub struct Args {
    #[command(subcommand)]
    pub command: Option<Command>,

    #[command(flatten)]
    pub render: RenderArgs,

    /// Log more (-v: what is done, -vv: how)
    #[arg(short, long, action = clap::ArgAction::Count, global = true)]
    pub verbose: u8,

    /// Log errors only, and show no progress
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Validate a scene and everything that it names, and stop
    Check {
        /// The scene file
        scene: PathBuf,
    },
    /// Measure what acceleration gains on a scene: accelerators side by side, on the same rays
    Bench(BenchArgs),
}

#[derive(Debug, ClapArgs)]
pub struct BenchArgs {
    /// The scene file
    pub scene: PathBuf,

    /// Embree 4's shared library, to be measured beside ours; one is in the Python package embreex
    #[arg(long, value_name = "LIB")]
    pub embree: Option<PathBuf>,

    /// Write the figures here as JSON
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Write a page with tables and charts into this folder
    #[arg(long, value_name = "FOLDER")]
    pub report: Option<PathBuf>,

    /// Threads to measure with [default: one for each processor]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,

    /// Repetitions of each cell
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    pub repetitions: u16,

    /// Repetitions of each build
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    pub builds: u16,
}

/// The memory that pictures may take where `--max-memory` is not given, in bytes.
pub const DEFAULT_MAX_MEMORY: u64 = 4 << 30;

#[derive(Debug, ClapArgs)]
pub struct RenderArgs {
    /// The scene file, or a model: OBJ, glTF or GLB
    #[arg(required = true)]
    pub scene: Option<PathBuf>,

    /// The camera path, a CSV file; without it, one frame is rendered from the scene's own camera
    #[arg(long, value_name = "FILE")]
    pub frames: Option<PathBuf>,

    /// Instead of a camera path: N frames once around the scene, from its own camera
    #[arg(long, value_name = "N", conflicts_with = "frames", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub turntable: Option<u32>,

    /// Only these frames: 1-100x2, 1,3,5-10 or 1-10:3 (x and : both mean step)
    #[arg(short, long, value_name = "SPEC", allow_hyphen_values = true)]
    pub range: Option<String>,

    /// Where frames go instead of the scene's `files`: out.####.exr, %04d or $F4; repeatable
    #[arg(short, long, value_name = "PATTERN")]
    pub output: Vec<String>,

    #[command(flatten)]
    pub existing: ExistingArgs,

    /// Validate everything and stop
    #[arg(long)]
    pub check: bool,

    /// Validate everything, print the frames and their files, and stop
    #[arg(long)]
    pub dry_run: bool,

    /// Threads to render with [default: one for each processor]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,

    /// Samples of each pixel instead of the scene's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub samples: Option<u32>,

    /// Width and height instead of the scene's, in pixels
    #[arg(long, value_name = "WxH", value_parser = resolution)]
    pub resolution: Option<[u32; 2]>,

    /// Render only the pixels from column X0 and row Y0 up to, not including, X1 and Y1
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = crop)]
    pub crop: Option<[u32; 4]>,

    /// Seed of the random numbers instead of the scene's
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,

    /// Whether the noise changes from frame to frame or stays, instead of the scene's
    #[arg(long, value_name = "MODE", value_parser = seed_mode())]
    pub seed_mode: Option<SeedMode>,

    /// Integrator instead of the scene's, with its default settings unless the scene has the same
    #[arg(long, value_name = "NAME")]
    pub integrator: Option<String>,

    /// Passes that EXR files hold beside the beauty, in place of the scene's: depth,N,lightgroup or all
    #[arg(long, value_name = "LIST", value_delimiter = ',', conflicts_with = "show")]
    pub aovs: Vec<String>,

    /// Render one pass in place of the beauty, such as depth
    #[arg(long, value_name = "PASS")]
    pub show: Option<String>,

    /// What finds the nearest hits; all give the same picture
    #[arg(long, value_name = "NAME", default_value_t)]
    pub accel: batch_render::accel::AccelKind,

    /// Frames per second: makes frames of a camera path's times, and stands in the EXR
    #[arg(long, value_name = "N")]
    pub fps: Option<f64>,

    /// Order of the rotations of a camera path's rot_x, rot_y and rot_z, such as ZXY
    #[arg(long, value_name = "ORDER")]
    pub rotation_order: Option<batch_render::camera::RotationOrder>,

    /// Memory that pictures may take, such as 512M or 8G; a larger job is refused
    #[arg(long, value_name = "SIZE", default_value = "4G", value_parser = size)]
    pub max_memory: u64,

    /// What becomes of an image that is missing or broken
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = MissingKind::Error)]
    pub missing_assets: MissingKind,

    /// How progress is shown, on standard output
    #[arg(long, value_enum, default_value_t = ProgressKind::Auto)]
    pub progress: ProgressKind,
}

#[derive(Debug, ClapArgs)]
#[group(multiple = false)]
pub struct ExistingArgs {
    /// Render frames whose files exist again (the default)
    #[arg(long)]
    pub overwrite: bool,

    /// Leave out frames whose files exist and are whole
    #[arg(long)]
    pub skip_existing: bool,

    /// Stop before rendering if a file exists
    #[arg(long)]
    pub fail_existing: bool,
}

/// What becomes of an image that is missing or broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MissingKind {
    /// The scene is refused
    Error,
    /// Squares of magenta and black are shown in its place, and a warning says so
    Placeholder,
}

impl From<MissingKind> for MissingAssets {
    fn from(kind: MissingKind) -> Self {
        match kind {
            MissingKind::Error => Self::Error,
            MissingKind::Placeholder => Self::Placeholder,
        }
    }
}

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProgressKind {
    /// Bars on a terminal, plain lines elsewhere
    Auto,
    /// A bar for the sequence and one for the frame
    Bar,
    /// A line for each frame
    Plain,
    /// Nothing
    None,
}

fn seed_mode() -> impl TypedValueParser<Value = SeedMode> {
    PossibleValuesParser::new(SeedMode::ALL.map(SeedMode::name)).map(|name| {
        let found = SeedMode::ALL.into_iter().find(|mode| mode.name() == name);
        found.expect("a possible value is a mode's name")
    })
}

fn resolution(text: &str) -> Result<[u32; 2], String> {
    let parsed = text
        .split_once(['x', 'X'])
        .and_then(|(w, h)| Some([w.trim().parse().ok()?, h.trim().parse().ok()?]));
    match parsed {
        None => Err("expected WIDTHxHEIGHT, such as 1280x720".into()),
        Some([0, _] | [_, 0]) => Err("a picture has at least 1x1 pixels".into()),
        Some(size) => Ok(size),
    }
}

fn crop(text: &str) -> Result<[u32; 4], String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok([x0, y0, x1, y1]),
        Ok([_, _, _, _]) => Err("nothing is left: X1 must exceed X0, and Y1 exceed Y0".into()),
        _ => Err("expected four whole numbers X0,Y0,X1,Y1".into()),
    }
}

fn size(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let scale = match text[digits.len()..]
        .to_ascii_uppercase()
        .trim_end_matches("IB")
        .trim_end_matches('B')
    {
        "" => 0,
        "K" => 10,
        "M" => 20,
        "G" => 30,
        "T" => 40,
        _ => return Err("expected a size such as 512M or 8G".into()),
    };
    let value: u64 = digits
        .parse()
        .map_err(|_| "expected a size such as 512M or 8G".to_owned())?;
    value
        .checked_mul(1 << scale)
        .ok_or_else(|| "the size is too large".into())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn sizes_and_windows_are_read_as_typed() {
        assert_eq!(size("8G"), Ok(8 << 30));
        let render = Args::try_parse_from(["batch-render", "s.toml"])
            .expect("a scene alone")
            .render;
        assert_eq!(render.max_memory, DEFAULT_MAX_MEMORY);
        assert_eq!(size("512MiB"), Ok(512 << 20));
        assert_eq!(size("100"), Ok(100));
        assert!(size("lots").is_err());
        assert_eq!(resolution("640x480"), Ok([640, 480]));
        assert!(resolution("0x480").is_err());
        assert_eq!(crop("1,2,3,4"), Ok([1, 2, 3, 4]));
        assert!(crop("3,2,3,4").is_err());
    }
}
