//! Several scenes in one command, rendered one after the other. The next one is loaded meanwhile.
//!
//! `{scene}` in any argument stands for the name of the scene: its file without the ending, with the folders that tell it from the
//! others.

use std::{
    collections::HashSet,
    ffi::{OsStr, OsString},
    path::{Path, PathBuf},
    sync::Arc,
};

use batch_render::{
    error::{Blame, Error},
    render::Cancelled,
    simd::Isa,
};
use clap::Parser as _;

use super::{
    ahead::Ahead,
    args::{Args, RenderArgs},
    choices::ProgressKind,
    failures::FramesFailed,
    log,
    progress::say,
    request::files_of_caller,
    signals,
    standard_input::STANDARD_INPUT,
    summary::plural,
};

/// Stands for the name of a scene.
const NAME: &str = "{scene}";

/// The turn of a scene.
pub struct Turn<'a> {
    pub simd: Isa,
    pub quiet: bool,
    /// This scene, if it is loaded already, and the next.
    pub ahead: &'a mut Ahead,
}

/// Calls `render` with the arguments for each scene.
///
/// A scene that fails is reported, and the others are rendered; with `--fail-fast` it ends the command.
///
/// # Errors
/// Two scenes would write one file, scenes have failed, or a signal has come.
pub fn run(
    args: &RenderArgs,
    (simd, quiet): (Isa, bool),
    render: fn(&RenderArgs, &mut Turn<'_>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut ahead = Ahead::default();
    let mut turn = Turn {
        simd,
        quiet,
        ahead: &mut ahead,
    };
    let words: Vec<OsString> = std::env::args_os().collect();
    if args.more.is_empty() && !words.iter().any(|word| names_a_scene(word)) {
        return render(args, &mut turn);
    }
    let scenes: Vec<&Path> = args.scene.iter().chain(&args.more).map(PathBuf::as_path).collect();
    let names = names(&scenes)?;
    let of_scenes: Result<Vec<Arc<RenderArgs>>, _> = scenes
        .iter()
        .zip(&names)
        .map(|(scene, name)| of_scene(&words, scene, name).map(Arc::new))
        .collect();
    let of_scenes = of_scenes?;
    if let [only] = &of_scenes[..] {
        return render(only, &mut turn);
    }
    check(&scenes, &of_scenes)?;
    let is_told = !quiet
        && !matches!(
            args.progress,
            ProgressKind::None | ProgressKind::Json | ProgressKind::Openjd
        );
    let mut failed = Vec::new();
    for (i, (scene, own)) in scenes.iter().zip(&of_scenes).enumerate() {
        if signals::is_received() {
            return Err(Error::Cancelled(Cancelled).into());
        }
        if is_told {
            say(&format!("scene {} of {}: {}", i + 1, scenes.len(), scene.display()));
        }
        turn.ahead.set_next(of_scenes.get(i + 1).cloned());
        match render(own, &mut turn) {
            Ok(()) => {}
            Err(error) if args.fail_fast || ends_the_command(&error, i == 0) => return Err(error),
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

fn names_a_scene(word: &OsStr) -> bool {
    word.to_string_lossy().contains(NAME)
}

/// The arguments for one scene.
fn of_scene(words: &[OsString], scene: &Path, name: &str) -> anyhow::Result<RenderArgs> {
    let own = words.iter().map(|word| match word.to_str() {
        Some(text) => text.replace(NAME, name).into(),
        None => word.clone(),
    });
    let mut render = Args::try_parse_from(own)?.render;
    render.scene = Some(scene.to_owned());
    render.more.clear();
    Ok(render)
}

/// Refuses what several scenes cannot share.
fn check(scenes: &[&Path], args: &[Arc<RenderArgs>]) -> Result<(), Error> {
    let refuse = |message: String| Err(Error::Usage(message));
    if scenes.contains(&Path::new(STANDARD_INPUT)) {
        return refuse("standard input (-) is one scene: name the others in commands of their own".to_owned());
    }
    if args[0].settings.has_stream {
        return refuse("-o -: standard output holds the frames of one scene".to_owned());
    }
    let mut written = HashSet::new();
    for own in args {
        if let Some(path) = written_by(own).into_iter().find(|path| !written.insert(path.clone())) {
            let path = path.display();
            return refuse(format!(
                "several scenes would write {path}: tell their files apart by {NAME} in the name"
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
