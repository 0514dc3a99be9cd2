//! The turns of a command: its scenes, and the eyes of each.
//!
//! `{scene}` in the value of a flag stands for the name of the scene: its file without the ending, with the folders that tell it
//! from the others. `{eye}` stands for the name of the eye. In patterns of files both are taken literally, whatever characters they
//! have; `{eye}` is left in these, since the plan of a job replaces it.

use std::{
    collections::{HashMap, HashSet},
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
};

use batch_render::{
    batch::{Plan, named_files},
    camera::stereo::{Side, Stereo},
    error::Error,
    output::{
        atomic,
        names::{EYE, NO_EYE, SCENE, has_field, with_names, with_plain_names, with_scene_name},
    },
    simd::Isa,
};
use clap::Parser as _;

use super::{
    args::{Args, RenderArgs},
    outlets::Outlets,
    preview::is_animated,
    replay::Replay,
    request::{files_of_caller, request},
    standard_input::STANDARD_INPUT,
};

/// The flags whose values are names of files that are written.
const FILES: [&str; 7] = [
    "output",
    "png-depth",
    "png-normals",
    "png-ids",
    "stats",
    "report",
    "preview",
];

/// A scene, or an eye of it.
pub struct SceneTurn {
    pub scene: PathBuf,
    /// The name that replaces `{scene}`.
    pub name: String,
    pub side: Option<Side>,
    pub args: RenderArgs,
    /// The command that renders it alone.
    pub typed: Replay,
}

impl SceneTurn {
    /// Its name in messages.
    pub fn label(&self) -> String {
        let scene = self.scene.display();
        let side = self.side.map(|side| format!("{scene}, {} eye", side.name()));
        side.unwrap_or_else(|| scene.to_string())
    }

    /// Its name among those of all: a folder for each scene with one for each eye.
    pub fn path(&self) -> String {
        let Self { name, side, .. } = self;
        side.map_or_else(|| name.clone(), |side| format!("{name}/{}", side.name()))
    }
}

/// Whether this is one scene whose arguments are as they were typed.
pub fn is_plain(args: &RenderArgs, typed: &Replay) -> bool {
    let is_pair = args.views.stereo.is_some_and(|stereo| stereo.pictures().len() > 1);
    args.more.is_empty()
        && !is_pair
        && !typed
            .values()
            .any(|(_, value)| value.contains(SCENE) || value.contains(EYE))
}

/// The turns of a command with these arguments and words. The eyes of a scene come one after the other.
///
/// # Errors
/// Two scenes have one name, or files are named after an eye where there is none.
pub fn turns(args: &RenderArgs, typed: &Replay) -> anyhow::Result<Vec<SceneTurn>> {
    let stereo = args.views.stereo;
    let misplaced = |(flag, value): &(&str, &str)| FILES.contains(flag) && has_field(value, EYE);
    let has_eyes = stereo.is_some_and(|stereo| stereo.layout.is_none());
    if let Some((flag, value)) = typed.values().find(misplaced).filter(|_| !has_eyes) {
        let message = format!("{NO_EYE}: --{flag} {value}");
        return Err(Error::Usage(message).into());
    }
    let scenes: Vec<&Path> = args.scene.iter().chain(&args.more).map(PathBuf::as_path).collect();
    refuse_twice(&scenes)?;
    let names = names(&scenes)?;
    let eyes: Vec<Option<Stereo>> = match stereo {
        Some(stereo) => {
            let of_side = |side| Some(Stereo { side, ..stereo });
            stereo.pictures().into_iter().map(of_side).collect()
        }
        None => vec![None],
    };
    let named = scenes.into_iter().zip(names);
    let turns = named.flat_map(|(scene, name)| {
        eyes.iter()
            .map(move |eye| turn((scene, &name), *eye, typed))
            .collect::<Vec<_>>()
    });
    turns.collect()
}

fn turn((scene, name): (&Path, &str), eye: Option<Stereo>, typed: &Replay) -> anyhow::Result<SceneTurn> {
    let side = eye.and_then(|eye| eye.side);
    let of_scene = (SCENE, name);
    let both: Vec<(&str, &str)> = [of_scene]
        .into_iter()
        .chain(side.map(|side| (EYE, side.name())))
        .collect();
    let value = |flag: &str, value: &str| match flag {
        // A film is no file of the plan.
        "output" if is_animated(Path::new(value)) => with_names(value, &both),
        "output" | "png-depth" | "png-normals" | "png-ids" => with_scene_name(value, name),
        "set" if value.starts_with("output.files") => with_scene_name(value, name),
        _ => with_plain_names(value, &both),
    };
    let mut typed = typed.clone().with_scene(scene).map_values(value);
    if let Some(eye) = eye {
        typed = typed.with("stereo", eye.to_string());
    }
    let words: Vec<OsString> = typed.clone().command_line();
    let mut args = Args::try_parse_from(words)?.render;
    args.scene = Some(scene.to_owned());
    Ok(SceneTurn {
        scene: scene.to_owned(),
        name: name.to_owned(),
        side,
        args,
        typed,
    })
}

/// Refuses turns that would write the same files, as far as that is known before any scene is loaded. `shared` are the files of the
/// command.
pub fn refuse_shared_names(turns: &[SceneTurn], shared: &[PathBuf], simd: Isa) -> Result<(), Error> {
    let mut written: HashMap<PathBuf, &SceneTurn> = HashMap::new();
    for own in turns {
        for path in names_of_files(own, simd) {
            if let Some(other) = written.insert(path.clone(), own) {
                return Err(shared_file(&path, other.scene == own.scene));
            }
            if shared.contains(&path) {
                return Err(shared_file(&path, false));
            }
        }
    }
    Ok(())
}

/// The names of the files that a turn writes, without the numbers of frames.
fn names_of_files(own: &SceneTurn, simd: Isa) -> Vec<PathBuf> {
    let Ok(outlets) = Outlets::new(&own.args) else {
        return Vec::new();
    };
    let named = request(&own.args, &outlets, simd);
    let named = named
        .ok()
        .and_then(|request| named_files(&own.scene, &own.args.settings.files, &request));
    let beside = files_of_caller(&own.args, &outlets.films).into_iter();
    let beside = beside.filter(|path| !own.args.of_command.contains(path));
    named.into_iter().flatten().chain(beside).collect()
}

fn shared_file(path: &Path, is_of_scene: bool) -> Error {
    let (who, name) = match is_of_scene {
        false => ("several scenes", SCENE),
        true => ("both eyes", EYE),
    };
    Error::Usage(format!(
        "{who} would write {}: tell their files apart by {name} in the name, or in the folder: -o '{name}/####.exr'",
        path.display()
    ))
}

/// The files that the turns so far have, each with the index of its turn.
#[derive(Default)]
pub struct Written(HashMap<PathBuf, PathBuf>);

impl Written {
    /// Adds the files of a plan for this scene, but for those of the command.
    ///
    /// # Errors
    /// One of them is that of an earlier turn.
    pub fn add(&mut self, scene: &Path, plan: &Plan, of_command: &[PathBuf]) -> Result<(), Error> {
        let of_frames = plan.all_frames().iter().flat_map(|frame| plan.files_of(frame));
        let files: HashSet<PathBuf> = of_frames.chain(plan.files_beside()).collect();
        for path in files.into_iter().filter(|path| !of_command.contains(path)) {
            let plain: PathBuf = path.components().collect();
            if let Some(other) = self.0.insert(plain, scene.to_owned()) {
                return Err(shared_file(&path, other == scene));
            }
        }
        Ok(())
    }
}

/// Refuses a file that two arguments name, by whatever path. Links to one file are scenes of their own.
fn refuse_twice(scenes: &[&Path]) -> Result<(), Error> {
    let mut known: HashMap<PathBuf, &Path> = HashMap::new();
    for scene in scenes {
        let place = fs::canonicalize(atomic::folder_of(scene)).unwrap_or_else(|_| atomic::folder_of(scene));
        let place = place.join(scene.file_name().unwrap_or_default());
        if let Some(other) = known.insert(place, scene) {
            let (other, scene) = (other.display(), scene.display());
            return Err(Error::Usage(match other.to_string() == scene.to_string() {
                true => format!("the scene is named twice: {scene}"),
                false => format!("the scene is named twice, as {other} and as {scene}"),
            }));
        }
    }
    Ok(())
}

/// The name of each scene: its path without the ending and without the folders that are not needed to tell it from others.
fn names(scenes: &[&Path]) -> Result<Vec<String>, Error> {
    let parts = |scene: &Path| -> Vec<String> {
        if scene == Path::new(STANDARD_INPUT) {
            return vec!["stdin".to_owned()];
        }
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
