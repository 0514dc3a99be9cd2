//! From what was typed to a rendered sequence.

use std::{path::Path, sync::Arc};

use anyhow::Context;
use batch_render::{
    accel::BuildOptions,
    assets::Store,
    batch::{self, Existing, FrameRange, Plan, Request},
    compile,
    error::Error,
    render::Watch,
    simd::Simd,
};
use clap::Parser;

use super::{
    args::{Args, Command, ProgressKind, RenderArgs},
    progress::{Progress, say},
    signals, simd, summary,
};

/// Does what the arguments say.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let simd = simd::from_environment()?;
    match &args.command {
        Some(Command::Check { scene }) => {
            let typed = [
                "batch-render".as_ref(),
                "--check".as_ref(),
                "--".as_ref(),
                scene.as_os_str(),
            ];
            let check = Args::try_parse_from(typed).context("--check takes any scene")?;
            render_job(&check.render, simd, args.quiet)
        }
        Some(Command::Bench(bench)) => super::bench::run(bench, simd, args.quiet),
        None => render_job(&args.render, simd, args.quiet),
    }
}

fn render_job(args: &RenderArgs, simd: Simd, quiet: bool) -> anyhow::Result<()> {
    let path = args.scene.as_deref().expect("the scene is a required argument");
    let request = request(args, simd)?;
    let pool = threads(args.threads)?;
    let store = Store::new(args.missing_assets.into());
    let desc = pool.install(|| batch::open(path, &request, &store))?;
    let plan = Plan::new(&desc, &request)?;
    if args.dry_run {
        list(&plan);
    }
    let scene = pool
        .install(|| compile::scene_with(&desc, plan.accel, &store))
        .map_err(Error::from)?;
    let replaced = store.replaced();
    drop(store);
    if args.check || args.dry_run {
        if !quiet {
            say(&format!(
                "{}: {} to render, nothing wrong",
                path.display(),
                frames(plan.frames.len())
            ));
        }
        return Ok(());
    }
    let watch = Arc::new(Watch::default());
    signals::cancel_on_signal(Arc::clone(&watch))?;
    let kind = if quiet { ProgressKind::None } else { args.progress };
    let progress = Progress::new(kind, plan.frames.len(), plan.settings.window.area() as u64, &watch);
    let done = pool.install(|| batch::run(&plan, &scene, &progress, &watch));
    match done {
        Ok(figures) => {
            progress.finish(Some(&summary::lines(&figures, &scene, replaced)));
            for line in summary::dropped(&figures) {
                tracing::warn!("{line}");
            }
            Ok(())
        }
        Err(e) => {
            progress.finish(None);
            Err(e.into())
        }
    }
}

/// The threads that a job renders on; one for each processor where no number is given.
pub fn threads(number: Option<u16>) -> anyhow::Result<rayon::ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(number.unwrap_or(0)))
        .thread_name(|i| format!("render {i}"))
        .build()
        .context("cannot start threads")
}

fn frames(n: usize) -> String {
    format!("{n} frame{}", if n == 1 { "" } else { "s" })
}

/// The frames and the files of a dry run, a line each.
fn list(plan: &Plan) {
    for frame in &plan.frames {
        let files: Vec<_> = frame.files.iter().map(|f| display(&f.path)).collect();
        say(&format!("{}\t{}", frame.number, files.join("\t")));
    }
}

fn display(path: &Path) -> String {
    path.display().to_string()
}

fn request(args: &RenderArgs, simd: Simd) -> Result<Request, Error> {
    let range: Option<FrameRange> = args
        .range
        .as_deref()
        .map(|text| text.parse().map_err(|e| Error::Usage(format!("--range: {e}"))))
        .transpose()?;
    if let Some(fps) = args.fps.filter(|f| !(f.is_finite() && *f > 0.0)) {
        return Err(Error::Usage(format!("--fps: expected a number above 0, found {fps}")));
    }
    let existing = match (args.existing.skip_existing, args.existing.fail_existing) {
        (true, _) => Existing::Skip,
        (_, true) => Existing::Fail,
        _ => Existing::Overwrite,
    };
    Ok(Request {
        camera_path: args.frames.clone(),
        turntable: args.turntable,
        range,
        outputs: args.output.clone(),
        existing,
        samples: args.samples,
        resolution: args.resolution,
        crop: args.crop,
        seed: args.seed,
        seed_mode: args.seed_mode,
        integrator: args.integrator.clone(),
        accel: BuildOptions {
            simd,
            ..args.accel.into()
        },
        fps: args.fps,
        rotation_order: args.rotation_order,
        max_memory: Some(args.max_memory),
    })
}
