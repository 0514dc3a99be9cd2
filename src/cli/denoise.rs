//! `batch-render denoise`: denoising of a rendered sequence.

use std::{
    env,
    path::{Path, PathBuf},
    sync::atomic::{AtomicUsize, Ordering},
};

use batch_render::{
    batch::{
        DenoiseOptions, FilterKind,
        denoise::{DenoiseObserver, DenoiseRequest, Helpers, denoise},
    },
    denoise::Oidn,
    error::Error,
    output::FilePattern,
    simd::Isa,
};
use serde_json::json;

use super::{
    choices::{DenoiserKind, ProgressKind},
    denoise_args::DenoiseArgs,
    progress::say,
    threads::threads,
};

/// Runs the command.
pub fn run(args: &DenoiseArgs, simd: Isa, quiet: bool) -> anyhow::Result<()> {
    let pattern = |text: &str| FilePattern::parse(text).map_err(Error::Pattern);
    let range = args.range.as_deref().map(str::parse).transpose();
    let request = DenoiseRequest {
        input: pattern(&args.input)?,
        output: pattern(&args.output)?,
        frames: range.map_err(|error| Error::Usage(format!("--range: {error}")))?,
        options: options(args.filter, args.temporal, args.oidn_lib.as_deref()),
        helpers: Helpers::Complete,
        skip_existing: args.skip_existing,
        simd,
    };
    let kind = if quiet { ProgressKind::None } else { ProgressKind::Plain };
    threads(args.threads)?.install(|| denoise(&request, &Lines::new(kind), None))?;
    Ok(())
}

/// The options of the flags.
pub fn options(filter: DenoiserKind, temporal: u32, library: Option<&Path>) -> DenoiseOptions {
    DenoiseOptions {
        temporal,
        filter: match filter {
            DenoiserKind::Nlm => FilterKind::NonLocalMeans,
            DenoiserKind::Oidn => FilterKind::Oidn {
                library: library.map(Path::to_owned).or_else(oidn_of_environment),
            },
        },
    }
}

/// The library in the folder that the environment names, or in its `lib`.
fn oidn_of_environment() -> Option<PathBuf> {
    let folder = PathBuf::from(env::var_os("OIDN_DIR")?);
    let inside = folder.join(Oidn::LIBRARY);
    Some(if inside.exists() {
        inside
    } else {
        folder.join("lib").join(Oidn::LIBRARY)
    })
}

/// A line for each frame.
pub struct Lines {
    pub kind: ProgressKind,
    frames: AtomicUsize,
    done: AtomicUsize,
}

impl Lines {
    pub fn new(kind: ProgressKind) -> Self {
        Self {
            kind,
            frames: AtomicUsize::new(0),
            done: AtomicUsize::new(0),
        }
    }

    fn openjd(&self, status: &str) {
        let (done, frames) = (
            self.done.fetch_add(1, Ordering::SeqCst) + 1,
            self.frames.load(Ordering::SeqCst),
        );
        say(&format!("openjd_status: {status}"));
        say(&format!(
            "openjd_progress: {:.1}",
            100.0 * done as f64 / frames.max(1) as f64
        ));
    }
}

impl DenoiseObserver for Lines {
    fn started(&self, frames: usize) {
        self.frames.store(frames, Ordering::SeqCst);
    }

    fn done(&self, frame: i32, path: &Path) {
        let file = path.display().to_string();
        match self.kind {
            ProgressKind::None => {}
            ProgressKind::Json => say(&json!({ "event": "frame_denoised", "frame": frame, "file": file }).to_string()),
            ProgressKind::Openjd => self.openjd(&format!("frame {frame} is denoised")),
            ProgressKind::Auto | ProgressKind::Bar | ProgressKind::Plain => say(&format!("{file}: denoised")),
        }
    }

    fn skipped(&self, frame: i32) {
        match self.kind {
            ProgressKind::Json => say(&json!({ "event": "frame_skipped", "frame": frame }).to_string()),
            ProgressKind::Openjd => self.openjd(&format!("frame {frame} is there")),
            _ => tracing::info!("frame {frame} is there already"),
        }
    }
}
