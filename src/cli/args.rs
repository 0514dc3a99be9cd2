//! The command line: what was typed, before it means anything.
//!
//! Every flag stands under a heading. `-h` shows what most jobs need and fits on one screen; flags that few need have
//! `hide_short_help` and appear in `--help`.

use std::{path::PathBuf, time::Duration};

use batch_render::{
    batch::{CategoryKind, PartSpec, Turn},
    compile::default_scene::normalise::Normalise,
    output::DepthUnit,
    render::SampleRanges,
    shape::mesh::LightUnits,
};
use clap::{
    ArgAction, Args as ClapArgs, Parser, Subcommand, ValueEnum,
    builder::{OsStringValueParser, TypedValueParser},
};

use super::{
    choices::{DenoiseStep, DenoiserKind, IfBusyKind, MissingKind, PartBaseKind, ProgressKind},
    existing_args::ExistingArgs,
    heading,
    preview::preview_path,
    settings::Settings,
    standard_input::input_format,
    stream::StreamForm,
    values::{crop, duration, frame_rate, light_units, radius, size},
    view_args::ViewArgs,
};

/// The help, with both usages on one line.
const HELP: &str = "{about-with-newline}
{usage-heading} batch-render [OPTIONS] <SCENE> [SCENE]... or batch-render <COMMAND>

{all-args}{after-help}";

/// Renders a scene along a camera path into EXR, NPZ, PNG and JPEG sequences.
#[derive(Debug, Parser)]
#[command(
    name = "batch-render",
    version,
    help_template = HELP,
    long_version = super::version::long(),
    after_long_help = super::examples::RENDER,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    disable_help_flag = true,
    disable_version_flag = true
)]
pub struct Args {
    #[command(subcommand)]
    pub command: Option<Command>,

    #[command(flatten)]
    pub render: RenderArgs,

    /// Log settings and times; -vv also logs the input files
    #[arg(short, long, action = ArgAction::Count, global = true, help_heading = heading::GENERAL)]
    pub verbose: u8,

    /// Log errors only, and show no progress
    #[arg(short, long, global = true, conflicts_with = "verbose", help_heading = heading::GENERAL)]
    pub quiet: bool,

    /// Print this help; --help lists all flags
    #[arg(short, long, action = ArgAction::Help, global = true, help_heading = heading::GENERAL)]
    help: Option<bool>,

    /// Print the version; --version also tells features and vectors
    #[arg(short = 'V', long, action = ArgAction::Version, hide_short_help = true, help_heading = heading::GENERAL)]
    version: Option<bool>,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Validate a scene and every file that it names, and list what it consists of
    #[command(after_long_help = super::examples::CHECK)]
    Check(Box<CheckArgs>),
    /// Compare acceleration structures on the rays of a scene
    #[command(after_long_help = super::examples::BENCH)]
    Bench(super::bench_args::BenchArgs),
    /// Join crops of one frame into the file of the whole frame
    #[command(after_long_help = super::examples::MERGE)]
    Merge {
        /// The file to write, .exr, .npz or .png
        out: PathBuf,

        /// Crops of one frame, which cover each of its pixels once
        #[arg(required = true)]
        crops: Vec<PathBuf>,
    },
    /// Take the noise out of a sequence that was rendered with --aovs denoise
    #[command(after_long_help = super::examples::DENOISE)]
    Denoise(super::denoise_args::DenoiseArgs),
    /// Compare pictures with references: FLIP, errors, and an exit code
    #[command(after_long_help = super::compare_args::EXAMPLES)]
    Compare(super::compare_args::CompareArgs),
    /// Convert cameras: CSV, COLMAP, transforms.json, .chan, TUM, glTF, OpenCV
    #[command(after_long_help = super::convert_args::EXAMPLES)]
    ConvertCamera(super::convert_args::ConvertArgs),
    /// Write a job for a farm: a batch script of Slurm, or a template of OpenJD
    #[command(after_long_help = super::examples::SUBMIT, mut_args = super::submit_help::shown)]
    Submit(Box<SubmitArgs>),
    /// Fly the camera through a scene on a page in the browser, and keep its path
    #[cfg(feature = "viewer")]
    #[command(after_long_help = super::fly_args::KEYS)]
    Fly(super::fly_args::FlyArgs),
    /// Print the JSON Schema of scene files, by which editors complete and check them
    Schema,
    /// Print the completions of a shell
    #[command(hide = true)]
    Completions { shell: super::completions::Shell },
    /// Print the manual page
    #[command(hide = true)]
    Man,
}

#[derive(Debug, ClapArgs)]
pub struct CheckArgs {
    /// The scene file
    pub scene: PathBuf,

    /// The camera path that is to be rendered
    #[arg(long, value_name = "FILE")]
    pub frames: Option<PathBuf>,

    /// Values of the scene over frames
    #[arg(long, value_name = "FILE")]
    pub values: Option<PathBuf>,

    /// Distributions of values that are drawn for each frame
    #[arg(long, value_name = "FILE")]
    pub random: Option<PathBuf>,

    /// An animation of a glTF model by itself that is to be played, or all of them; repeatable
    #[arg(long, value_name = "NAME|all")]
    pub animation: Vec<String>,

    /// Let models name files outside of their own folders
    #[arg(long)]
    pub allow_outside: bool,

    /// Refuse models of which a part would not be rendered
    #[arg(long)]
    pub strict: bool,

    /// Treatment of missing and broken images
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = MissingKind::Error)]
    pub missing_assets: MissingKind,

    /// Unit of the lights of a glTF model: as its program writes them, candela and lux (683 lm/W), or W/sr and W/m2
    #[arg(long, value_name = "UNIT", value_parser = light_units())]
    pub light_units: Option<LightUnits>,

    /// Print the inventory as JSON
    #[arg(long)]
    pub json: bool,

    #[command(flatten)]
    pub settings: Settings,
}

/// The arguments of `submit`.
#[derive(Debug, ClapArgs)]
pub struct SubmitArgs {
    /// The farm's engine
    #[arg(long, value_enum, help_heading = heading::FARM)]
    pub engine: Engine,

    /// Folder of the files; it is made
    #[arg(long, value_name = "FOLDER", help_heading = heading::FARM)]
    pub bundle: PathBuf,

    /// Frames that a task renders at most
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..), help_heading = heading::FARM)]
    pub chunk: u32,

    /// Hand the files to the engine: `openjd run` or `sbatch`
    #[arg(long, help_heading = heading::FARM)]
    pub run: bool,

    #[command(flatten)]
    pub render: RenderArgs,
}

/// An engine that runs jobs on a farm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Engine {
    /// Open Job Description, which AWS Deadline Cloud runs: writes template.yaml
    Openjd,
    /// Slurm: writes frames.sbatch
    Slurm,
}

#[derive(Debug, ClapArgs)]
pub struct RenderArgs {
    /// The scene file, or a model: OBJ, glTF, GLB, PLY or STL; - is standard input
    #[arg(required = true)]
    pub scene: Option<PathBuf>,

    /// More scenes, rendered one after the other; {scene} in -o and other arguments is the name of each
    #[arg(value_name = "SCENE", hide_short_help = true)]
    pub more: Vec<PathBuf>,

    /// Cameras of the frames: CSV, COLMAP, .chan, .json, ...; without it, frame 1
    #[arg(long, value_name = "FILE", help_heading = heading::FRAMES)]
    pub frames: Option<PathBuf>,

    /// Form of the scene on standard input: toml, or the ending of a model, such as glb
    #[arg(long, value_name = "NAME", value_parser = input_format, hide_short_help = true, help_heading = heading::FRAMES)]
    pub input_format: Option<String>,

    /// Values over frames, a CSV file of columns such as light.key.point.intensity
    #[arg(long, value_name = "FILE", hide_short_help = true, help_heading = heading::FRAMES)]
    pub values: Option<PathBuf>,

    /// Values that are drawn at random for each frame, a TOML file of distributions such as "light.key.point.intensity" = [1, 10]
    #[arg(long, value_name = "FILE", hide_short_help = true, help_heading = heading::FRAMES)]
    pub random: Option<PathBuf>,

    /// See a model by its camera of this name, or of this number from 0
    #[arg(long, value_name = "NAME", hide_short_help = true, help_heading = heading::FRAMES)]
    pub camera: Option<String>,

    /// Play an animation of a glTF model by itself, or all of them; repeatable
    ///
    /// Without --range and --frames, the frames are those from 0 to its last key.
    #[arg(long, value_name = "NAME|all", hide_short_help = true, help_heading = heading::FRAMES)]
    pub animation: Vec<String>,

    /// Orbit the scene once in N frames, from its own camera
    ///
    /// N:DEGREES turns by another angle: counterclockwise as seen from above, clockwise below 0. The last
    /// frame is one step before the end.
    #[arg(long, value_name = "N", visible_alias = "orbit", conflicts_with = "frames", allow_hyphen_values = true, help_heading = heading::FRAMES)]
    pub turntable: Option<Turn>,

    #[command(flatten)]
    pub views: ViewArgs,

    /// Move the scene's camera along its line of sight until all of the scene fits into the picture
    ///
    /// So do all poses of its motion, and all angles of an orbit.
    #[arg(long, conflicts_with = "frames", hide_short_help = true, help_heading = heading::FRAMES)]
    pub frame_to_fit: bool,

    /// Put a model by itself on a ground that catches its shadow and shows the background behind
    #[arg(long, hide_short_help = true, help_heading = heading::STAGE)]
    pub ground: bool,

    /// Move and scale a model by itself, so that its bounds fill the unit-sphere (of radius 1) or the unit-cube (with edges of 1)
    ///
    /// Its middle is at the origin then. Its own cameras go with it, and its lights shine as bright on it. `transforms.json` tells
    /// scale and translate: a point p of the model is at scale * p + translate.
    #[arg(long, value_name = "SHAPE", visible_alias = "normalize", hide_short_help = true, help_heading = heading::STAGE)]
    pub normalise: Option<Normalise>,

    /// Render only these frames: 1-100, 1,3,5-10 or 1-100x2
    ///
    /// The step follows x or a colon: 1-100x2 and 1-100:2 are every second frame. Negative frames need an equals sign:
    /// --range=-5-5.
    #[arg(short, long, value_name = "SPEC", allow_hyphen_values = true, help_heading = heading::FRAMES)]
    pub range: Option<String>,

    /// Render only part I of N equal parts of the frames: 3/10, or 3/10:interleave for every tenth
    ///
    /// For array jobs of Slurm, SGE, AWS Batch and Kubernetes, where each task knows its own number: --part $ID/10.
    #[arg(long, value_name = "I/N", hide_short_help = true, help_heading = heading::FRAMES)]
    pub part: Option<PartSpec>,

    /// Number of the first part: 0 or 1
    #[arg(long, value_name = "0|1", value_enum, default_value_t, hide_short_help = true, help_heading = heading::FRAMES)]
    pub part_base: PartBaseKind,

    #[command(flatten)]
    pub settings: Settings,

    /// The files that the command keeps of all its scenes
    #[arg(skip)]
    pub of_command: Vec<PathBuf>,

    /// Form of the frames on standard output (-o -): png, jpg, exr, npz or, for films, y4m
    #[arg(long, value_name = "NAME", value_parser = StreamForm::parse, hide_short_help = true, help_heading = heading::OUTPUT)]
    pub output_format: Option<StreamForm>,

    /// Also write depth as PNG files of 16 bits: depth.####.png beside the pictures, or =PATTERN
    #[arg(long, value_name = "PATTERN", num_args = 0..=1, require_equals = true, default_missing_value = "", hide_short_help = true, help_heading = heading::OUTPUT)]
    pub png_depth: Option<String>,

    /// Unit of the numbers of --png-depth: mm, cm or m
    #[arg(long, value_name = "UNIT", default_value_t, requires = "png_depth", hide_short_help = true, help_heading = heading::OUTPUT)]
    pub png_depth_unit: DepthUnit,

    /// Also write normals as PNG files of 16 bits: normals.####.png beside the pictures, or =PATTERN
    #[arg(long, value_name = "PATTERN", num_args = 0..=1, require_equals = true, default_missing_value = "", hide_short_help = true, help_heading = heading::OUTPUT)]
    pub png_normals: Option<String>,

    /// Also write the numbers of objects as PNG files of 16 bits: ids.####.png beside the pictures, or =PATTERN
    #[arg(long, value_name = "PATTERN", num_args = 0..=1, require_equals = true, default_missing_value = "", hide_short_help = true, help_heading = heading::OUTPUT)]
    pub png_ids: Option<String>,

    /// Files beside the pictures: transforms (cameras, as NeRF programs read them), colmap (cameras, as COLMAP does), coco (boxes
    /// and masks of objects), ids (names of objects and materials)
    #[arg(long, value_name = "LIST", value_delimiter = ',', hide_short_help = true, help_heading = heading::OUTPUT)]
    pub metadata: Vec<String>,

    /// What the categories of coco are named after: object, material, file (of the geometry) or scene
    #[arg(long, value_name = "KIND", default_value_t, requires = "metadata", hide_short_help = true, help_heading = heading::OUTPUT)]
    pub categories: CategoryKind,

    #[command(flatten)]
    pub existing: ExistingArgs,

    /// Render all other frames when one fails (the default)
    #[arg(long, hide_short_help = true, conflicts_with = "fail_fast", help_heading = heading::JOB)]
    pub keep_going: bool,

    /// Stop at the first frame that fails
    #[arg(long, hide_short_help = true, help_heading = heading::JOB)]
    pub fail_fast: bool,

    /// Further attempts to write a file, where the disk is neither full nor read-only
    #[arg(long, value_name = "N", default_value_t = 2, hide_short_help = true, help_heading = heading::JOB)]
    pub retries: u32,

    /// Time that each frame has, such as 10m or 1h30m: it gets as many samples as fit, and at least one
    #[arg(long, value_name = "TIME", value_parser = duration, hide_short_help = true, help_heading = heading::JOB)]
    pub time_limit: Option<Duration>,

    /// Keep an unfinished frame beside its file at this interval, such as 60s; a killed frame goes on from there
    ///
    /// The next job with --checkpoint goes on from the file, with the same bits as if nobody had stopped it. SIGINT and SIGTERM
    /// keep the frame, too.
    #[arg(long, value_name = "TIME", value_parser = duration, hide_short_help = true, help_heading = heading::JOB)]
    pub checkpoint: Option<Duration>,

    /// Keep the sums of the samples of each frame beside its file; a later job with more --samples adds those that are missing
    ///
    /// Its files have the bits of a job with --keep-sums and all the samples. Frames in which objects move
    /// while the shutter is open start anew.
    #[arg(long, visible_alias = "continue", hide_short_help = true, help_heading = heading::JOB)]
    pub keep_sums: bool,

    /// Render the Ith of N ranges of the samples of each frame; all/N adds up the ranges that are there and renders the others
    #[arg(long, value_name = "I/N", hide_short_help = true, help_heading = heading::JOB)]
    pub sample_range: Option<SampleRanges>,

    /// Treatment of files that another job is writing
    #[arg(long, value_enum, value_name = "WHAT", default_value_t, hide_short_help = true, help_heading = heading::JOB)]
    pub if_busy: IfBusyKind,

    /// Keep a page in this folder that shows how the job goes: thumbnails, charts, the slowest frames
    #[arg(long, value_name = "FOLDER", hide_short_help = true, help_heading = heading::JOB)]
    pub report: Option<PathBuf>,

    /// Write the frames as a small moving picture when the job ends: .png (animated), or .mp4 by ffmpeg
    #[arg(long, value_name = "FILE", value_parser = OsStringValueParser::new().try_map(preview_path), hide_short_help = true, help_heading = heading::JOB)]
    pub preview: Option<PathBuf>,

    /// Keep the figures of each frame in this file as JSON
    #[arg(long, value_name = "FILE", hide_short_help = true, help_heading = heading::JOB)]
    pub stats: Option<PathBuf>,

    /// Validate everything and stop
    #[arg(long, hide_short_help = true, help_heading = heading::JOB)]
    pub check: bool,

    /// Validate everything, list the frames and their files, and stop
    #[arg(long, hide_short_help = true, help_heading = heading::JOB)]
    pub dry_run: bool,

    /// Threads to render with [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), help_heading = heading::JOB)]
    pub threads: Option<u16>,

    /// Render only columns X0 to X1 - 1 and rows Y0 to Y1 - 1
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = crop, hide_short_help = true, help_heading = heading::PICTURE)]
    pub crop: Option<[u32; 4]>,

    /// Also render N columns and rows beyond each edge; EXR files keep the picture as their display window
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with = "crop", value_parser = clap::value_parser!(u32).range(..=65536), hide_short_help = true, help_heading = heading::PICTURE)]
    pub overscan: u32,

    /// Denoise the frames with those around them; noisy ones stay in the folder noisy
    #[arg(long, value_enum, value_name = "FILTER", num_args = 0..=1, default_missing_value = "nlm", conflicts_with = "output.show", hide_short_help = true, help_heading = heading::PICTURE)]
    pub denoise: Option<DenoiserKind>,

    /// Frames on each side of a frame that help to denoise it
    #[arg(long, value_name = "N", default_value_t = 2, requires = "denoise", value_parser = clap::value_parser!(u32).range(0..=16), hide_short_help = true, help_heading = heading::PICTURE)]
    pub temporal: u32,

    /// Library of Open Image Denoise; without it that in the folder OIDN_DIR, or the system's
    #[arg(long, value_name = "LIB", requires = "denoise", hide_short_help = true, help_heading = heading::PICTURE)]
    pub oidn_lib: Option<PathBuf>,

    /// Do one half of the job only: render the noisy frames, or denoise those that are there
    #[arg(long, value_enum, value_name = "STEP", requires = "denoise", hide_short_help = true, help_heading = heading::FARM)]
    pub denoise_step: Option<DenoiseStep>,

    /// Acceleration structure; all give the same picture
    #[arg(long, value_name = "NAME", default_value_t, hide_short_help = true, help_heading = heading::PICTURE)]
    pub accel: batch_render::accel::AccelKind,

    /// Frames per second, for camera paths that give times; EXR files record it
    #[arg(long, value_name = "N", value_parser = frame_rate, hide_short_help = true, help_heading = heading::FRAMES)]
    pub fps: Option<f64>,

    /// Order of a camera path's rotations rot_x, rot_y and rot_z, such as ZXY
    #[arg(long, value_name = "ORDER", hide_short_help = true, help_heading = heading::FRAMES)]
    pub rotation_order: Option<batch_render::camera::RotationOrder>,

    /// Memory that a job may take, such as 512M or 8G; a larger job is refused [default: 3/4 of what is free]
    #[arg(long, value_name = "SIZE", value_parser = size, hide_short_help = true, help_heading = heading::JOB)]
    pub max_memory: Option<u64>,

    /// Memory for textures, such as 8G; above it the larger ones are shown at a lower resolution [default: half of the machine's]
    #[arg(long, value_name = "SIZE", value_parser = size, hide_short_help = true, help_heading = heading::JOB)]
    pub texture_memory: Option<u64>,

    /// Treatment of missing and broken images
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = MissingKind::Error, hide_short_help = true, help_heading = heading::JOB)]
    pub missing_assets: MissingKind,

    /// Refuse models of which a part would not be rendered
    #[arg(long, hide_short_help = true, help_heading = heading::JOB)]
    pub strict: bool,

    /// Let models name files outside of their own folders
    #[arg(long, hide_short_help = true, help_heading = heading::JOB)]
    pub allow_outside: bool,

    /// Show a glTF model with its materials of this variant
    #[arg(long, value_name = "NAME", hide_short_help = true, help_heading = heading::JOB)]
    pub variant: Option<String>,

    /// Unit of the lights of a glTF model: as its program writes them, candela and lux (683 lm/W), or W/sr and W/m2
    #[arg(long, value_name = "UNIT", value_parser = light_units(), hide_short_help = true, help_heading = heading::JOB)]
    pub light_units: Option<LightUnits>,

    /// Radius in metres of the points of a PLY file without faces
    #[arg(long, value_name = "METRES", value_parser = radius, hide_short_help = true, help_heading = heading::JOB)]
    pub point_radius: Option<f32>,

    /// Display of progress, on standard output
    #[arg(long, value_enum, value_name = "HOW", default_value_t = ProgressKind::Auto, hide_short_help = true, help_heading = heading::JOB)]
    pub progress: ProgressKind,
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
    fn the_short_help_fits_on_one_screen() {
        let help = Args::command().term_width(100).render_help().to_string();
        assert!(help.lines().count() <= 40, "{help}");
        assert!(help.lines().all(|line| line.chars().count() <= 100), "{help}");
    }

    #[test]
    fn the_long_help_has_every_flag_under_a_heading() {
        let command = Args::command();
        let help = command.clone().term_width(100).render_long_help().to_string();
        for flag in command.get_arguments().filter(|a| !a.is_positional()) {
            let name = format!("--{}", flag.get_long().expect("every flag has a long name"));
            assert!(help.contains(&name), "{name} is not in the help");
            assert!(flag.get_help_heading().is_some(), "{name} has no heading");
        }
    }

    #[test]
    fn memory_is_limited_by_what_is_free_where_no_limit_is_given() {
        let args = Args::try_parse_from(["batch-render", "s.toml"]).expect("a scene alone");
        assert_eq!(args.render.max_memory, None);
    }
}
