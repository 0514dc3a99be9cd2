//! From the command line to a rendered sequence.

use std::{
    io::{self, Write},
    path::Path,
    sync::Arc,
    time::Instant,
};

use batch_render::{
    accel::BuildOptions,
    batch::{Job, Observer, Plan, Request, Stale, merge},
    error::{Blame, Error},
    render::{Cancel, Control, Counters, ShowRequest},
    simd::Isa,
};

use clap::CommandFactory as _;

use super::{
    args::{Args, CheckArgs, Command, RenderArgs},
    choices::ProgressKind,
    closed_pipe::is_closed_pipe,
    completions,
    events::{EventFormat, Events},
    failures::{self, FramesFailed},
    figures::State,
    inventory, log, man, memory,
    opened::Opened,
    preview::{Preview, PreviewSize},
    progress::{Progress, say},
    request::animation,
    scenes::{self, Turn},
    signals, simd,
    stats::{Observers, Stats, StatsFiles},
    stream::{PipeClosed, Stream},
    summary,
    threads::threads,
};

/// The JSON Schema of scene files, which a test makes of their types.
const SCENE_SCHEMA: &str = include_str!("../../docs/schema/scene.json");

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let simd = simd::from_environment()?;
    match &args.command {
        Some(Command::Check(args)) => check(args, simd),
        Some(Command::Bench(bench)) => super::bench::run(bench, simd, args.quiet),
        #[cfg(feature = "viewer")]
        Some(Command::Fly(fly)) => super::fly::run(fly, simd),
        Some(Command::Merge { out, crops }) => {
            threads(None)?.install(|| merge(out, crops))?;
            if !args.quiet {
                let crops = summary::plural(crops.len(), "crop");
                say(&format!("{}: merged from {crops}", out.display()));
            }
            Ok(())
        }
        Some(Command::Denoise(denoise)) => super::denoise::run(denoise, simd, args.quiet),
        Some(Command::ConvertCamera(convert)) => super::convert::run(convert, args.quiet),
        Some(Command::Compare(compare)) => super::compare::run(compare, args.quiet),
        Some(Command::Schema) => print(SCENE_SCHEMA),
        Some(Command::Completions { shell }) => print(&completions::script(*shell, &whole())),
        Some(Command::Man) => print(&man::page(&whole())),
        Some(Command::Submit(submit)) => super::submit::run(submit, simd),
        None => scenes::run(&args.render, (simd, args.quiet), render),
    }
}

/// Validates a scene and prints its inventory.
fn check(args: &CheckArgs, simd: Isa) -> anyhow::Result<()> {
    args.settings.refuse_stream()?;
    let request = Request {
        camera_path: args.frames.clone(),
        values: args.values.clone(),
        random: args.random.clone(),
        animation: animation(&args.animation),
        overrides: args.settings.overrides.clone(),
        allow_outside: args.allow_outside,
        strict: args.strict,
        missing_assets: args.missing_assets.into(),
        light_units: args.light_units,
        max_memory: Some(memory::default_limit()),
        texture_memory: Some(memory::default_textures()),
        accel: BuildOptions {
            simd,
            ..BuildOptions::default()
        },
        ..Request::default()
    };
    let _last = log::LastWarnings(request.warnings.clone());
    let pool = threads(None)?;
    let job = pool.install(|| Job::open(&args.scene, &request))?;
    let loaded = pool.install(|| job.load())?;
    pool.install(|| job.check(&loaded))?;
    let inventory = job.inventory(&loaded);
    drop(loaded);
    pool.install(|| job.check_named_files())?;
    log::warnings(&request.warnings);
    inventory::print(&args.scene, &job, &inventory, args.json).map_err(Error::Stdout)?;
    Ok(())
}

fn render(args: &RenderArgs, turn: Turn<'_>) -> anyhow::Result<()> {
    let (simd, quiet) = (turn.simd, turn.quiet);
    let ahead = turn.ahead.take();
    let warnings = ahead.as_ref().map(|opened| opened.warnings.clone()).unwrap_or_default();
    let _last = log::LastWarnings(warnings.clone());
    let opened = match ahead {
        Some(opened) => opened,
        None => Opened::new(args, simd, &warnings, |_| {})?,
    };
    let Opened {
        outlets,
        pool,
        job,
        path,
        scene,
        took,
        ..
    } = opened;
    turn.written.add(&path, &job.plan, &args.of_command)?;
    log_settings(&job, pool.current_num_threads());
    let (plan, cancel) = (&job.plan, Arc::new(Cancel::default()));
    let stream = outlets
        .stream
        .map(|form| Stream::new(form, plan, &cancel))
        .transpose()?;
    let small = args.preview.iter().map(|path| (path, PreviewSize::Small));
    let films = outlets.films.iter().map(|path| (path, PreviewSize::Full));
    let previews = small.chain(films).map(|(path, size)| Preview::new(path, size, &job));
    let previews: Vec<Preview> = previews.collect::<Result<_, _>>()?;
    if args.dry_run {
        list(plan).map_err(Error::Stdout)?;
    }
    let start = Instant::now();
    let scene = match scene {
        Some(scene) => scene,
        None => pool.install(|| job.load())?,
    };
    log::warnings(&warnings);
    let files = job.files().manifest();
    tracing::info!(
        "{} input files loaded in {}",
        files.len(),
        summary::seconds(took + start.elapsed())
    );
    for (path, hash) in files {
        tracing::debug!("{hash} {}", path.display());
    }
    if args.check || args.dry_run {
        job.compare_files()?;
        pool.install(|| job.build(scene).map(drop))?;
        pool.install(|| job.check_named_files())?;
        report_valid(&path, &job, quiet);
        return Ok(());
    }
    if args.existing.list_stale {
        if plan.files.picture.is_none() {
            let message = "--list-stale: the frames have no files: name them, too (-o f.####.png)";
            return Err(Error::Usage(message.to_owned()).into());
        }
        let stale = pool.install(|| job.stale(&plan.frames))?;
        return Ok(list_stale(plan, &stale).map_err(Error::Stdout)?);
    }
    // Figures of a refused job would be written over those that are to stay.
    job.compare_files()?;
    let (counters, show) = (Arc::new(Counters::default()), Arc::new(ShowRequest::default()));
    signals::listen(Arc::clone(&cancel), Arc::clone(&show))?;
    let kind = if quiet { ProgressKind::None } else { args.progress };
    let frames = (plan.frames.len(), plan.picture.max_samples());
    let progress = Progress::new(kind, frames, &counters, turn.typed);
    let control = Control {
        cancel: Some(&cancel),
        counters: Some(&counters),
        show: Some(&show),
        ..Control::default()
    };
    let files = StatsFiles {
        json: args.stats.clone(),
        page: args.report.clone(),
        of_all: turn.figures,
    };
    let stats = files
        .are_wanted()
        .then(|| pool.install(|| Stats::new(files, args.part, &job, (&counters, &cancel))));
    let format = match kind {
        ProgressKind::Json => Some(EventFormat::Json),
        ProgressKind::Openjd => Some(EventFormat::OpenJd),
        _ => None,
    };
    let eye = args.views.stereo.and_then(|stereo| stereo.side);
    let events = format.map(|format| Events::new(format, &job, eye, turn.share));
    let mut observers = Observers(vec![&progress]);
    observers
        .0
        .extend(events.as_ref().map(|events| events as &dyn Observer));
    observers.0.extend(stats.as_ref().map(|stats| stats as &dyn Observer));
    observers
        .0
        .extend(previews.iter().map(|preview| preview as &dyn Observer));
    observers
        .0
        .extend(stream.as_ref().map(|stream| stream as &dyn Observer));
    turn.ahead.begin(simd);
    let done = pool.install(|| job.run(scene, &observers, &control));
    drop(observers);
    let streamed = stream.map_or(Ok(()), Stream::finish);
    let state = match &streamed {
        Ok(()) => State::of(&done),
        Err(_) => State::Failed,
    };
    let figures = stats.map(|stats| stats.finish(state)).unwrap_or_default();
    let figures = figures.into_iter().map(Error::from);
    let previews = previews.into_iter();
    let previews = previews.filter_map(|preview| pool.install(|| preview.finish(&cancel)).err());
    let previews: Vec<Error> = previews.collect();
    let closing = done.as_ref().map(|summary| summary::lines(summary, &job));
    if let Some(closed) = streamed.as_ref().err().filter(|error| error.is::<PipeClosed>()) {
        tracing::debug!("{closed}");
        progress.stop();
        return streamed;
    }
    progress.finish(state, closing.as_deref().ok());
    if let Some(line) = done
        .iter()
        .find_map(|summary| failures::unfinished(summary, plan, turn.typed))
    {
        tracing::warn!("{line}");
    }
    for line in done.iter().flat_map(summary::invalid) {
        tracing::warn!("{line}");
    }
    let failed = done.map_err(Into::into).and_then(FramesFailed::check).err();
    // The first error tells the exit code.
    let mut errors = streamed
        .err()
        .into_iter()
        .chain(failed)
        .chain(figures.chain(previews).map(Into::into));
    let Some(first) = errors.next() else {
        return Ok(());
    };
    // After the first error another one is not reported if it has the same text, if it says that work was cancelled, or if both
    // say that a file cannot be created.
    let blame = |error: &anyhow::Error| error.downcast_ref::<Error>().map(Error::blame);
    let is_of_place = |error: &anyhow::Error| blame(error) == Some(Blame::CannotCreate);
    let is_told = |other: &anyhow::Error| {
        other.to_string() == first.to_string()
            || blame(other) == Some(Blame::Cancelled)
            || is_of_place(other) && is_of_place(&first)
    };
    let others = errors.filter(|other| !is_told(other));
    others.for_each(|other| log::report(&other));
    Err(first)
}

fn log_settings(job: &Job, threads: usize) {
    let plan = &job.plan;
    let [width, height] = plan.picture.resolution();
    let budget = &plan.picture.settings.samples;
    let samples = match &budget.adaptive {
        Some(rule) => format!(
            "{} to {} samples for noise below {}",
            rule.min, budget.max, rule.threshold
        ),
        None => summary::plural(budget.max as usize, "sample"),
    };
    tracing::info!(
        "{}: {width}x{height}, {samples}, seed {}, {}, vectors {}",
        frames(plan.frames.len()),
        plan.picture.settings.seed,
        summary::plural(threads, "thread"),
        plan.picture.accel.simd.name(),
    );
}

fn report_valid(path: &Path, job: &Job, quiet: bool) {
    if !quiet {
        let frames = frames(job.plan.frames.len());
        say(&format!("{}: {frames} to render, nothing wrong", path.display()));
    }
}

fn frames(n: usize) -> String {
    summary::plural(n, "frame")
}

/// Prints the frames of a dry run with their files and what they draw, a line each, and the files beside them.
fn list(plan: &Plan) -> io::Result<()> {
    let frames = plan.frames.iter().map(|frame| {
        let files = plan.files_of(frame).map(|path| display(&path));
        let cells: Vec<_> = files.chain(plan.drawn_at(frame.number)).collect();
        format!("{}\t{}", frame.number, cells.join("\t"))
    });
    print_lines(frames.chain(plan.files_beside().map(|path| format!("-\t{}", display(&path)))))
}

/// Prints the frames that are to be rendered again, with the file and the reason, a line each.
fn list_stale(plan: &Plan, stale: &[Option<Stale>]) -> io::Result<()> {
    let frames = plan.frames.iter().zip(stale);
    print_lines(frames.filter_map(|(frame, stale)| {
        let Stale { path, reason } = stale.as_ref()?;
        Some(format!("{}\t{}\t{reason}", frame.number, display(path)))
    }))
}

/// The command line with all that its commands share.
fn whole() -> clap::Command {
    let mut command = Args::command();
    command.build();
    command
}

/// Prints a text.
fn print(text: &str) -> anyhow::Result<()> {
    Ok(print_lines(text.lines().map(str::to_owned)).map_err(Error::Stdout)?)
}

/// Prints lines. A closed pipe is no error.
fn print_lines(mut lines: impl Iterator<Item = String>) -> io::Result<()> {
    let mut out = io::stdout().lock();
    let written = lines.try_for_each(|line| writeln!(out, "{line}"));
    match written.and_then(|()| out.flush()) {
        Err(error) if !is_closed_pipe(&error) => Err(error),
        _ => Ok(()),
    }
}

fn display(path: &Path) -> String {
    path.display().to_string()
}
