//! Several scenes in one command, rendered one after the other. The next one is loaded meanwhile.
//!
//! The two eyes of stereo are rendered in the same way, unless one picture shows both: see [`turns`](super::turns).

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use batch_render::{
    error::{Blame, Error},
    render::Cancelled,
    simd::Isa,
    warnings::Warnings,
};

use super::{
    ahead::Ahead,
    all_scenes::{AllScenes, SceneFigures},
    args::RenderArgs,
    choices::{DenoiseStep, ProgressKind},
    failures::FramesFailed,
    figures::State,
    log,
    opened::Opened,
    progress::say,
    replay::Replay,
    scene_failures::ScenesFailed,
    signals,
    standard_input::STANDARD_INPUT,
    turns::{SceneTurn, Written, is_plain, refuse_shared_names, turns},
};

/// The turn of a scene.
pub struct Turn<'a> {
    pub simd: Isa,
    pub quiet: bool,
    /// This scene, if it is loaded already, and the next.
    pub ahead: &'a mut Ahead,
    /// The files of the scenes before it.
    pub written: &'a mut Written,
    /// Its place among the figures of all scenes, if they are kept together.
    pub figures: Option<SceneFigures<'a>>,
    /// The command that renders this scene alone.
    pub typed: &'a Replay,
    /// The number of turns before it, and of all.
    pub share: (usize, usize),
}

/// Renders one scene.
type Render = fn(&RenderArgs, Turn<'_>) -> anyhow::Result<()>;

/// Calls `render` with the arguments for each scene.
///
/// A scene that fails is reported, and the others are rendered; with `--fail-fast` it ends the command.
///
/// # Errors
/// Two scenes would write one file, scenes have failed, or a signal has come.
pub fn run(args: &RenderArgs, (simd, quiet): (Isa, bool), render: Render) -> anyhow::Result<()> {
    let typed = Replay::of_process()?;
    let alone = |args: &RenderArgs| {
        let turn = Turn {
            simd,
            quiet,
            ahead: &mut Ahead::default(),
            written: &mut Written::default(),
            figures: None,
            typed: &typed,
            share: (0, 1),
        };
        render(args, turn)
    };
    if is_plain(args, &typed) {
        return alone(args);
    }
    let mut turns = turns(args, &typed)?;
    if let [only] = &turns[..] {
        return alone(&only.args);
    }
    let all = together(&mut turns);
    check(&turns, all.as_ref(), simd)?;
    let writes = !(args.check || args.dry_run || args.existing.list_stale);
    if !writes && let Some(all) = &all {
        turns[0].args.of_command = all.files().collect();
    }
    let is_new = writes && args.existing.fail_existing;
    if is_new {
        turns.iter().try_for_each(|own| refuse_existing(own, simd))?;
    }
    let all = all.filter(|_| writes);
    if let Some(all) = &all {
        let is_new = is_new && !is_chunk(args);
        all.check(is_new)?;
        // Those that are to be new are there once the first scene has written them.
        let of_command = all.files().filter(|_| !is_new);
        let of_command: Vec<PathBuf> = of_command.collect();
        for own in &mut turns {
            own.args.of_command.clone_from(&of_command);
        }
    }
    for own in &mut turns {
        own.typed = command(own.typed.clone(), &own.args);
    }
    let result = each(turns, (simd, quiet), all.as_ref(), render);
    let errors = all
        .map(|all| all.finish(State::of_command(&result)))
        .unwrap_or_default();
    let mut errors = errors.into_iter().map(|error| Error::from(error).into());
    let first = result.err().or_else(|| errors.next());
    errors.for_each(|other| log::report(&other));
    first.map_or(Ok(()), Err)
}

/// Refuses files of frames that exist. Whatever else is wrong with the scene is told in its turn.
fn refuse_existing(own: &SceneTurn, simd: Isa) -> Result<(), Error> {
    let opened = Opened::new(&own.args, simd, &Warnings::default(), |_| {});
    match opened.map(|opened| opened.job.compare_files()) {
        Ok(Err(error @ Error::Exists { .. })) => Err(error),
        _ => Ok(()),
    }
}

/// Renders one scene after the other.
fn each(
    turns: Vec<SceneTurn>,
    (simd, quiet): (Isa, bool),
    all: Option<&AllScenes>,
    render: Render,
) -> anyhow::Result<()> {
    let progress = turns[0].args.progress;
    let is_told = !quiet && !matches!(progress, ProgressKind::None | ProgressKind::Json | ProgressKind::Openjd);
    let noun = noun(&turns);
    let labels: Vec<String> = turns.iter().map(SceneTurn::label).collect();
    let turns: Vec<(Arc<RenderArgs>, Replay)> = turns.into_iter().map(|own| (Arc::new(own.args), own.typed)).collect();
    let (mut ahead, mut written) = (Ahead::default(), Written::default());
    let mut failed = ScenesFailed::new(noun, turns.len());
    for (i, (label, (own, typed))) in labels.into_iter().zip(&turns).enumerate() {
        if signals::is_received() {
            return Err(Error::Cancelled(Cancelled).into());
        }
        if is_told {
            say(&format!("{noun} {} of {}: {label}", i + 1, turns.len()));
        }
        ahead.set_next(turns.get(i + 1).map(|(next, _)| Arc::clone(next)));
        let turn = Turn {
            simd,
            quiet,
            ahead: &mut ahead,
            written: &mut written,
            figures: all.map(|all| all.scene(i)),
            typed,
            share: (i, turns.len()),
        };
        let result = render(own, turn);
        if let Some(all) = all {
            all.end(i, &result);
        }
        match result {
            Ok(()) => {}
            Err(error) if own.fail_fast || ends_the_command(&error, i == 0) => return Err(error),
            Err(error) => {
                log::report(&error);
                failed.add(label, &error);
            }
        }
    }
    failed.check()
}

/// The word for a turn of these.
fn noun(turns: &[SceneTurn]) -> &'static str {
    if turns.iter().any(|own| own.side.is_some()) {
        "eye"
    } else {
        "scene"
    }
}

/// The files of figures that several scenes keep together, since their names are those of all scenes. The arguments of the scenes
/// have none of them afterwards, but a folder in that of the page.
fn together(turns: &mut [SceneTurn]) -> Option<AllScenes> {
    let shared = |file: fn(&RenderArgs) -> &Option<PathBuf>| {
        let (first, second) = (file(&turns[0].args).as_ref()?, file(&turns[1].args).as_ref());
        (second == Some(first)).then(|| first.clone())
    };
    let [json, page] = [shared(|own| &own.stats), shared(|own| &own.report)];
    let first = &turns[0].args;
    let joins = is_chunk(first) || first.existing.skip_existing || first.denoise_step == Some(DenoiseStep::Denoise);
    let scenes = turns.iter().map(|own| (own.path(), own.scene.display().to_string()));
    let all = AllScenes::new([json.as_ref(), page.as_ref()], (noun(turns), scenes), joins)?;
    for own in turns {
        own.args.stats.take_if(|_| json.is_some());
        if let Some(folder) = &page {
            own.args.report = Some(folder.join(own.path()));
        }
    }
    Some(all)
}

/// Whether the command renders a part of the frames of each scene.
fn is_chunk(args: &RenderArgs) -> bool {
    args.range.is_some() || args.part.is_some()
}

/// Whether the other scenes would fail in the same way, or were cancelled. Wrong usage is that of all scenes if the first one finds
/// it; later ones may lack a camera or an animation that the others have.
fn ends_the_command(error: &anyhow::Error, is_first: bool) -> bool {
    if error.is::<FramesFailed>() {
        return false;
    }
    match error.downcast_ref::<Error>().map(Error::blame) {
        Some(Blame::Cancelled | Blame::System | Blame::Io) => true,
        Some(Blame::Usage) => is_first,
        _ => false,
    }
}

/// The command that renders one scene alone, of these arguments. It writes no figures over those of all scenes.
fn command(typed: Replay, own: &RenderArgs) -> Replay {
    let typed = if own.stats.is_none() {
        typed.without(&["stats"])
    } else {
        typed
    };
    match &own.report {
        Some(folder) => typed.with("report", folder),
        None => typed,
    }
}

/// Refuses what several scenes cannot share.
fn check(turns: &[SceneTurn], all: Option<&AllScenes>, simd: Isa) -> Result<(), Error> {
    let refuse = |message: &str| Err(Error::Usage(message.to_owned()));
    let is_one = turns.iter().all(|own| own.scene == turns[0].scene);
    if turns.iter().any(|own| own.scene == Path::new(STANDARD_INPUT)) {
        return refuse(match is_one {
            true => {
                "standard input (-) is read once, and each eye reads the scene: render each by a command (eye=left), or a file"
            }
            false => "standard input (-) is one scene: name the others in commands of their own",
        });
    }
    if turns[0].args.settings.has_stream {
        return refuse(match is_one {
            true => "-o -: standard output holds the frames of one eye: render each by a command (eye=left)",
            false => "-o -: standard output holds the frames of one scene",
        });
    }
    let is_same = |a: &Path, b: &Path| fs::canonicalize(a).is_ok_and(|a| fs::canonicalize(b).is_ok_and(|b| a == b));
    let of_command: Vec<PathBuf> = all.iter().flat_map(|all| all.files()).collect();
    for output in &of_command {
        if let Some(own) = turns.iter().find(|own| is_same(&own.scene, output)) {
            let (output, input) = (output.clone(), own.scene.clone());
            return Err(Error::OverwritesInput { output, input });
        }
    }
    refuse_shared_names(turns, &of_command, simd)
}
