//! Several scenes in one command, rendered one after the other. The next one is loaded meanwhile.
//!
//! `{scene}` in any argument stands for the name of the scene: its file without the ending, with the folders that tell it from the
//! others. The two eyes of stereo are rendered in the same way, unless one picture shows both, and `{eye}` is the name of theirs.

use std::{
    collections::HashSet,
    ffi::{OsStr, OsString},
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use batch_render::{
    camera::stereo::Side,
    error::{Blame, Error},
    render::Cancelled,
    simd::Isa,
};
use clap::Parser as _;

use super::{
    ahead::Ahead,
    all_scenes::{AllScenes, SceneFigures},
    args::{Args, RenderArgs},
    choices::{DenoiseStep, ProgressKind},
    failures::FramesFailed,
    figures::State,
    log,
    progress::say,
    replay::Replay,
    request::files_of_caller,
    signals,
    standard_input::STANDARD_INPUT,
    summary::plural,
};

/// Stands for the name of a scene.
const NAME: &str = "{scene}";

/// Stands for the name of an eye.
const EYE: &str = "{eye}";

/// The turn of a scene.
pub struct Turn<'a> {
    pub simd: Isa,
    pub quiet: bool,
    /// This scene, if it is loaded already, and the next.
    pub ahead: &'a mut Ahead,
    /// Its place among the figures of all scenes, if they are kept together.
    pub figures: Option<SceneFigures<'a>>,
    /// The command that renders this scene alone.
    pub typed: &'a Replay,
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
    let words: Vec<OsString> = std::env::args_os().collect();
    let alone = |args: &RenderArgs| {
        let (ahead, typed) = (&mut Ahead::default(), &Replay::of_process()?);
        let turn = Turn {
            simd,
            quiet,
            ahead,
            figures: None,
            typed,
        };
        render(args, turn)
    };
    let is_pair = args.views.stereo.is_some_and(|stereo| stereo.pictures().len() > 1);
    if args.more.is_empty() && !is_pair && !words.iter().any(|word| has_name(word)) {
        return alone(args);
    }
    let scenes: Vec<&Path> = args.scene.iter().chain(&args.more).map(PathBuf::as_path).collect();
    let names = names(&scenes)?;
    let sides: Vec<Option<Side>> = match args.views.stereo {
        Some(stereo) => stereo.pictures(),
        None => vec![None],
    };
    // The eyes of a scene come one after the other.
    let named = scenes.iter().zip(&names);
    let turns: Vec<_> = named
        .flat_map(|own| sides.iter().map(move |side| (own, *side)))
        .collect();
    let named = turns.iter().map(|((_, name), side)| words_of(&words, name, *side));
    let words: Vec<Vec<OsString>> = named.collect();
    let of_scenes = turns.iter().zip(&words);
    let of_scenes = of_scenes.map(|(((scene, _), side), words)| of_scene(words, scene, *side));
    let mut of_scenes: Vec<RenderArgs> = of_scenes.collect::<Result<_, _>>()?;
    let names = turns.iter().map(|((_, name), side)| match side {
        Some(side) if sides.len() > 1 => format!("{name}/{}", side.name()),
        _ => (*name).clone(),
    });
    let names: Vec<String> = names.collect();
    let scenes: Vec<&Path> = turns.iter().map(|((scene, _), _)| **scene).collect();
    if let [only] = &of_scenes[..] {
        return alone(only);
    }
    let all = together(&mut of_scenes, &names);
    check(&scenes, &of_scenes, all.as_ref())?;
    let writes = !(args.check || args.dry_run || args.existing.list_stale);
    if !writes && let Some(all) = &all {
        of_scenes[0].of_command = all.files().collect();
    }
    let all = all.filter(|_| writes);
    if let Some(all) = &all {
        let is_new = args.existing.fail_existing && !is_chunk(args);
        all.check(is_new)?;
        // Those that are to be new are there once the first scene has written them.
        let of_command = all.files().filter(|_| !is_new);
        let of_command: Vec<PathBuf> = of_command.collect();
        of_scenes
            .iter_mut()
            .for_each(|own| own.of_command.clone_from(&of_command));
    }
    let typed = words.into_iter().zip(&of_scenes);
    let typed: Vec<Replay> = typed
        .map(|(words, own)| command(words, own))
        .collect::<Result<_, _>>()?;
    let of_scenes = of_scenes.into_iter().map(Arc::new).zip(typed).collect();
    let result = each((&scenes, of_scenes), (simd, quiet), all.as_ref(), render);
    let errors = all
        .map(|all| all.finish(State::of_command(&result)))
        .unwrap_or_default();
    let mut errors = errors.into_iter().map(|error| Error::from(error).into());
    let first = result.err().or_else(|| errors.next());
    errors.for_each(|other| log::report(&other));
    first.map_or(Ok(()), Err)
}

/// Renders one scene after the other.
fn each(
    (scenes, of_scenes): (&[&Path], Vec<(Arc<RenderArgs>, Replay)>),
    (simd, quiet): (Isa, bool),
    all: Option<&AllScenes>,
    render: Render,
) -> anyhow::Result<()> {
    let progress = of_scenes[0].0.progress;
    let is_told = !quiet && !matches!(progress, ProgressKind::None | ProgressKind::Json | ProgressKind::Openjd);
    let (mut ahead, mut failed) = (Ahead::default(), Vec::new());
    for (i, (scene, (own, typed))) in scenes.iter().zip(&of_scenes).enumerate() {
        if signals::is_received() {
            return Err(Error::Cancelled(Cancelled).into());
        }
        if is_told {
            let side = own.views.stereo.and_then(|stereo| stereo.side);
            let eye = side.map_or_else(String::new, |side| format!(", {} eye", side.name()));
            say(&format!(
                "scene {} of {}: {}{eye}",
                i + 1,
                scenes.len(),
                scene.display()
            ));
        }
        ahead.set_next(of_scenes.get(i + 1).map(|(next, _)| Arc::clone(next)));
        let turn = Turn {
            simd,
            quiet,
            ahead: &mut ahead,
            figures: all.map(|all| all.scene(i)),
            typed,
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
                failed.push(scene.display().to_string());
            }
        }
    }
    match &failed[..] {
        [] => Ok(()),
        failed => anyhow::bail!(
            "{} of {} failed: {}",
            failed.len(),
            plural(scenes.len(), "scene"),
            failed.join(", ")
        ),
    }
}

/// The files of figures that several scenes keep together, since their names are those of all scenes. The arguments of the scenes have
/// none of them afterwards, but a folder in that of the page.
fn together(of_scenes: &mut [RenderArgs], names: &[String]) -> Option<AllScenes> {
    let shared = |file: fn(&RenderArgs) -> &Option<PathBuf>| {
        let (first, second) = (file(&of_scenes[0]).as_ref()?, file(&of_scenes[1]).as_ref());
        (second == Some(first)).then(|| first.clone())
    };
    let [json, page] = [shared(|own| &own.stats), shared(|own| &own.report)];
    let joins = is_chunk(&of_scenes[0])
        || of_scenes[0].existing.skip_existing
        || of_scenes[0].denoise_step == Some(DenoiseStep::Denoise);
    let scenes = names.iter().cloned().zip(of_scenes.iter().map(|own| {
        let scene = own.scene.as_deref().unwrap_or(Path::new(""));
        scene.display().to_string()
    }));
    let all = AllScenes::new([json.as_ref(), page.as_ref()], scenes, joins)?;
    for (own, name) in of_scenes.iter_mut().zip(names) {
        own.stats.take_if(|_| json.is_some());
        if let Some(folder) = &page {
            own.report = Some(folder.join(name));
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

fn has_name(word: &OsStr) -> bool {
    let word = word.to_string_lossy();
    word.contains(NAME) || word.contains(EYE)
}

/// The words of the command for the scene of this name, or for an eye of it.
fn words_of(words: &[OsString], name: &str, side: Option<Side>) -> Vec<OsString> {
    let own = words.iter().map(|word| match word.to_str() {
        Some(text) => {
            let text = text.replace(NAME, name);
            side.map_or_else(|| text.clone(), |side| text.replace(EYE, side.name()))
                .into()
        }
        None => word.clone(),
    });
    own.collect()
}

/// The arguments for one scene, or for an eye of it, of which these are the words.
fn of_scene(words: &[OsString], scene: &Path, side: Option<Side>) -> anyhow::Result<RenderArgs> {
    let mut render = Args::try_parse_from(words)?.render;
    render.scene = Some(scene.to_owned());
    render.more.clear();
    if let Some(stereo) = &mut render.views.stereo {
        stereo.side = side;
    }
    Ok(render)
}

/// The command that renders one scene with these arguments, made of its words. It writes no figures over those of all scenes.
fn command(words: Vec<OsString>, own: &RenderArgs) -> Result<Replay, Error> {
    let mut typed = Replay::parse(words)?.with_scene(own.scene.as_deref().expect("each scene has a path"));
    if let Some(stereo) = own.views.stereo {
        typed = typed.with("stereo", stereo.to_string());
    }
    if own.stats.is_none() {
        typed = typed.without(&["stats"]);
    }
    Ok(match &own.report {
        Some(folder) => typed.with("report", folder),
        None => typed,
    })
}

/// Refuses what several scenes cannot share.
fn check(scenes: &[&Path], args: &[RenderArgs], all: Option<&AllScenes>) -> Result<(), Error> {
    let refuse = |message: String| Err(Error::Usage(message));
    if scenes.contains(&Path::new(STANDARD_INPUT)) {
        return refuse("standard input (-) is one scene: name the others in commands of their own".to_owned());
    }
    if args[0].settings.has_stream {
        return refuse("-o -: standard output holds the frames of one scene".to_owned());
    }
    let is_same = |a: &Path, b: &Path| fs::canonicalize(a).is_ok_and(|a| fs::canonicalize(b).is_ok_and(|b| a == b));
    for output in all.iter().flat_map(|all| all.files()) {
        if let Some(scene) = scenes.iter().find(|scene| is_same(scene, &output)) {
            let input = scene.to_path_buf();
            return Err(Error::OverwritesInput { output, input });
        }
    }
    let mut written: HashSet<PathBuf> = all.iter().flat_map(|all| all.files()).collect();
    for own in args {
        if let Some(path) = &written_by(own).into_iter().find(|path| !written.insert(path.clone())) {
            let of_scene = args.iter().filter(|other| other.scene == own.scene);
            let (who, name) = match of_scene.filter(|other| written_by(other).contains(path)).count() {
                0 | 1 => ("several scenes", NAME),
                _ => ("both eyes", EYE),
            };
            let path = path.display();
            return refuse(format!(
                "{who} would write {path}: tell their files apart by {name} in the name"
            ));
        }
    }
    Ok(())
}

/// The patterns of the files that a job writes by its arguments.
fn written_by(args: &RenderArgs) -> HashSet<PathBuf> {
    let pictures = args.settings.files.iter().map(PathBuf::from);
    let films: Vec<PathBuf> = args.settings.films.iter().map(PathBuf::from).collect();
    let mut all: HashSet<PathBuf> = pictures.chain(files_of_caller(args, &films)).collect();
    // Files beside the pictures are in the folder of the first of them.
    let first = args.settings.files.first().map_or("", String::as_str);
    let folder = Path::new(first).parent().unwrap_or(Path::new(""));
    all.extend(args.metadata.iter().map(|name| folder.join(format!("{name}.json"))));
    let maps = [
        ("depth", &args.png_depth),
        ("normals", &args.png_normals),
        ("ids", &args.png_ids),
    ];
    for (name, pattern) in maps {
        all.extend(pattern.as_ref().map(|pattern| match &pattern[..] {
            "" => folder.join(format!("{name}.####.png")),
            named => PathBuf::from(named),
        }));
    }
    all
}

/// The name of each scene: its path without the ending and without the folders that are not needed to tell it from others.
fn names(scenes: &[&Path]) -> Result<Vec<String>, Error> {
    let parts = |scene: &Path| -> Vec<String> {
        let whole = scene.with_extension("");
        let parts = whole
            .components()
            .filter(|part| matches!(part, std::path::Component::Normal(_)));
        parts
            .map(|part| part.as_os_str().to_string_lossy().into_owned())
            .collect()
    };
    let parts: Vec<Vec<String>> = scenes.iter().map(|scene| parts(scene)).collect();
    let deepest = parts.iter().map(Vec::len).max().unwrap_or(0);
    for depth in 1..=deepest {
        let names: Vec<String> = parts
            .iter()
            .map(|parts| parts[parts.len().saturating_sub(depth)..].join("/"))
            .collect();
        if names.iter().collect::<HashSet<_>>().len() == names.len() {
            return Ok(names);
        }
    }
    let mut seen = HashSet::new();
    let twice = scenes.iter().zip(&parts).find(|(_, parts)| !seen.insert(*parts));
    let twice = twice.map_or(Path::new(""), |(scene, _)| scene);
    Err(Error::Usage(format!(
        "two scenes have the name of {} without its ending: render them by commands of their own",
        twice.display()
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_as_long_as_it_takes_to_tell_scenes_apart() {
        let of = |scenes: &[&str]| {
            let paths: Vec<&Path> = scenes.iter().map(Path::new).collect();
            names(&paths).map_err(|error| error.to_string())
        };
        let ok = |names: &[&str]| Ok(names.iter().map(|name| (*name).to_owned()).collect());
        assert_eq!(of(&["a/car.v2.glb", "bike.toml"]), ok(&["car.v2", "bike"]));
        assert_eq!(
            of(&["a/x/scene.gltf", "b/x/scene.gltf", "/c/other.glb"]),
            ok(&["a/x/scene", "b/x/scene", "c/other"])
        );
        assert!(of(&["car.glb", "car.obj"]).unwrap_err().contains("car.obj"));
    }
}
