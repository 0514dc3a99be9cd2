//! `batch-render denoise`: denoising of a rendered sequence.

use std::{
    env,
    path::{Path, PathBuf},
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

use super::{choices::DenoiserKind, denoise_args::DenoiseArgs, failures::list, progress::say, threads::threads};

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
    let lines = Lines { is_quiet: quiet };
    threads(args.threads)?.install(|| denoise(&request, &lines, None))?;
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

/// The library in the folder that the environment names, or in its `lib`, on Windows `bin`.
fn oidn_of_environment() -> Option<PathBuf> {
    let folder = PathBuf::from(env::var_os("OIDN_DIR")?);
    let inside = folder.join(Oidn::LIBRARY);
    Some(if inside.exists() {
        inside
    } else {
        folder.join(Oidn::FOLDER).join(Oidn::LIBRARY)
    })
}

/// A line for each frame, unless the command is quiet.
struct Lines {
    is_quiet: bool,
}

impl DenoiseObserver for Lines {
    fn done(&self, _frame: i32, path: &Path) {
        if !self.is_quiet {
            say(&format!("{}: denoised", path.display()));
        }
    }

    fn skipped(&self, frame: i32) {
        tracing::info!("frame {frame} is there already");
    }

    fn lacking(&self, frames: &[i32], missing: &[i32]) {
        let (frames, missing) = (list(frames), list(missing));
        tracing::warn!(
            "denoised without the frames beside them, which are not there: {frames} (without {missing}). Once they are rendered, repeat the command"
        );
    }
}
