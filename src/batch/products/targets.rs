//! The list of all files that a job writes, checked before the first ray.

use std::{
    collections::{HashMap, HashSet},
    ffi::OsString,
    fs,
    path::{Component, Path, PathBuf},
};

use crate::batch::{Existing, Plan, PlannedFrame, resume::checkpoint};
use crate::{
    assets::Files,
    error::Error,
    output::{FileNames, atomic, names::NO_EYE, sequence},
};

/// A file that a job writes.
struct Target {
    path: PathBuf,
    kind: TargetKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TargetKind {
    /// A file of a frame, rendered or denoised.
    Frame,
    /// The state or the picture of an unfinished frame.
    Unfinished,
    /// A file beside the frames.
    Beside,
}

impl Plan {
    /// The files of a frame: those that are rendered, and those that these become when they are denoised.
    pub fn files_of<'a>(&'a self, frame: &'a PlannedFrame) -> impl Iterator<Item = PathBuf> + 'a {
        let denoised = self.denoises().into_iter().flat_map(|denoise| &denoise.clean);
        let rendered = frame.files.iter().filter(|_| self.renders());
        let rendered = rendered.map(|file| file.path.clone());
        rendered.chain(denoised.map(|clean| clean.path(frame.number)))
    }

    /// The files beside the frames.
    pub fn files_beside(&self) -> impl Iterator<Item = PathBuf> + '_ {
        let sidecars = self
            .files
            .sidecars
            .iter()
            .filter(|_| self.renders())
            .filter_map(|sidecar| self.sidecar_path(*sidecar));
        sidecars.chain(self.files.files_of_caller.iter().cloned())
    }

    /// All files that a job with these frames writes.
    fn targets<'a>(&'a self, frames: &'a [PlannedFrame]) -> impl Iterator<Item = Target> + 'a {
        let target = |kind| move |path| Target { path, kind };
        let pictures = frames.iter().flat_map(|frame| self.files_of(frame));
        let has_checkpoints = self.policy.checkpoint.is_some() && self.renders();
        let checkpoints = frames
            .iter()
            .filter_map(checkpoint::path)
            .filter(move |_| has_checkpoints);
        let keeps_sums = self.keeps_sums() && self.renders();
        let sums = frames
            .iter()
            .filter_map(checkpoint::sums_path)
            .filter(move |_| keeps_sums);
        let rendered = frames.iter().filter(|_| self.renders());
        let unfinished = rendered.filter_map(checkpoint::picture_path);
        let beside = self.files_beside().map(target(TargetKind::Beside));
        let pictures = pictures.map(target(TargetKind::Frame));
        pictures
            .chain(checkpoints.map(target(TargetKind::Unfinished)))
            .chain(sums.map(target(TargetKind::Unfinished)))
            .chain(unfinished.map(target(TargetKind::Unfinished)))
            .chain(beside)
    }
}

/// Finds out whether the files of a job that is not refused can be written: what exists is a regular file, and the folders exist
/// afterwards.
pub(in crate::batch) fn check(plan: &Plan) -> Result<(), Error> {
    let own = || plan.targets(&plan.frames);
    for target in own() {
        atomic::check_kind(&target.path)?;
    }
    // The files of the first frame stand for the others, which lie in the same folders. A whole file that stays may be
    // read-only, and one that may not be replaced concerns its frame alone.
    for path in plan.frames.iter().take(1).flat_map(|frame| plan.files_of(frame)) {
        let stays = plan.policy.existing == Existing::Skip && path.exists();
        match atomic::check(&path) {
            Err(error) if !stays && !error.is_of_file() => return Err(error.into()),
            Err(_) => atomic::sweep(&path),
            Ok(()) => {}
        }
    }
    for path in plan.files_beside() {
        atomic::check(&path)?;
    }
    Ok(())
}

/// Refuses a job that would write over what it reads, or over files that are to stay. Changes nothing.
pub(in crate::batch) fn refuse(plan: &Plan, inputs: &Files) -> Result<(), Error> {
    if let Some(pattern) = &plan.files.lacks_eye {
        let message = format!("{NO_EYE}: {pattern}");
        return Err(Error::Usage(message));
    }
    compare(plan, inputs)?;
    let is_new = |target: &Target| match target.kind {
        TargetKind::Frame => true,
        TargetKind::Beside => !plan.is_chunk,
        TargetKind::Unfinished => false,
    };
    let is_in_the_way = |target: &Target| is_new(target) && target.path.exists();
    if plan.policy.existing == Existing::Fail
        && let Some(Target { path, .. }) = plan.targets(&plan.frames).find(is_in_the_way)
    {
        return Err(Error::Exists { path });
    }
    Ok(())
}

/// Refuses files that are inputs, or that are written twice, by whatever name or link.
fn compare(plan: &Plan, inputs: &Files) -> Result<(), Error> {
    let targets = plan.targets(plan.all_frames());
    let read = inputs.manifest().into_iter().map(|(path, _)| path);
    check_distinct(targets.map(|target| target.path), read)
}

/// Refuses outputs that are inputs or each other, by whatever name or link, and those whose names the system does not allow.
pub(in crate::batch) fn check_distinct(
    outputs: impl Iterator<Item = PathBuf>,
    inputs: impl Iterator<Item = PathBuf>,
) -> Result<(), Error> {
    let read: HashMap<Identity, PathBuf> = inputs.filter_map(|path| Some((identity(&path)?, path))).collect();
    let (mut folders, mut written) = (Folders::default(), HashMap::new());
    for output in outputs {
        if let Some(fault) = FileNames::HERE.fault(&output) {
            return Err(Error::Usage(format!("{fault}: {}", output.display())));
        }
        let may_exist = folders.may_have(&output);
        if may_exist && let Some(input) = identity(&output).and_then(|id| read.get(&id)) {
            let input = input.clone();
            return Err(Error::OverwritesInput { output, input });
        }
        if let Some(first) = written.insert(folders.place(&output, may_exist), output.clone()) {
            return Err(Error::WrittenTwice { first, second: output });
        }
    }
    let places = folders.places.iter().enumerate();
    for (number, folder) in places.flat_map(|(number, place)| place.ancestors().map(move |folder| (number, folder))) {
        let (parent, name) = (folder.parent(), folder.file_name().unwrap_or_default());
        let parent = parent.and_then(|parent| folders.places.iter().position(|place| place == parent));
        if let Some(folder) = parent.and_then(|parent| written.get(&(parent, FileNames::HERE.comparable(name)))) {
            let mut within = written.iter().filter(|((place, _), _)| *place == number);
            let (_, output) = within.next().expect("a folder has an output");
            return Err(Error::WithinOutput {
                output: output.clone(),
                folder: folder.clone(),
            });
        }
    }
    Ok(())
}

/// The folders of files. A job may have a million files in a few of them.
#[derive(Default)]
struct Folders {
    known: HashMap<PathBuf, Folder>,
    /// The folders of all places, without links.
    places: Vec<PathBuf>,
}

/// A folder by one of its names.
struct Folder {
    /// Its index in [`Folders::places`].
    place: usize,
    /// See [`sequence::names_in`].
    names: Option<HashSet<String>>,
}

impl Folders {
    fn folder(&mut self, path: PathBuf) -> &Folder {
        let places = &mut self.places;
        self.known.entry(path).or_insert_with_key(|path| {
            let place = without_links(path);
            let known = places.iter().position(|known| *known == place);
            Folder {
                place: known.unwrap_or_else(|| {
                    places.push(place);
                    places.len() - 1
                }),
                names: sequence::names_in(path),
            }
        })
    }

    /// Whether there may be a file at this path, or a link.
    fn may_have(&mut self, path: &Path) -> bool {
        match path.file_name() {
            Some(name) => {
                let name = name.to_string_lossy().to_lowercase();
                let names = &self.folder(atomic::folder_of(path)).names;
                names.as_ref().is_none_or(|names| names.contains(&name))
            }
            None => true,
        }
    }

    /// The place of a file that need not exist, its folder and its comparable name: equal for all names and symbolic links of it.
    /// Other hard links are other places, since files are replaced as a whole.
    fn place(&mut self, path: &Path, may_exist: bool) -> (usize, OsString) {
        let target = match may_exist {
            true => atomic::target_of(path).unwrap_or_else(|_| path.to_owned()),
            false => path.to_owned(),
        };
        let name = FileNames::HERE.comparable(target.file_name().unwrap_or_default());
        (self.folder(atomic::folder_of(&target)).place, name)
    }
}

/// The path of a folder without links and `..`, of which the end need not exist.
fn without_links(folder: &Path) -> PathBuf {
    match fs::canonicalize(folder) {
        Ok(found) => return found,
        // The current folder itself is gone.
        Err(_) if folder == Path::new(".") => return folder.to_owned(),
        Err(_) => {}
    }
    let parent = folder.parent().filter(|parent| *parent != Path::new(""));
    let mut whole = without_links(parent.unwrap_or(Path::new(".")));
    match folder.components().next_back() {
        Some(Component::ParentDir) => {
            whole.pop();
        }
        Some(Component::Normal(name)) => whole.push(name),
        _ => {}
    }
    whole
}

/// The identity of a file: equal for all its names.
#[cfg(any(unix, windows))]
type Identity = (u64, u64);
#[cfg(not(any(unix, windows)))]
type Identity = PathBuf;

/// The device and the number of an existing file.
#[cfg(unix)]
fn identity(path: &Path) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    let file = fs::metadata(path).ok()?;
    Some((file.dev(), file.ino()))
}

/// The volume and the number of an existing file.
#[cfg(windows)]
fn identity(path: &Path) -> Option<Identity> {
    let (volume, number) = crate::windows::file_identity(path)?;
    Some((volume.into(), number))
}

/// The path of an existing file without links.
#[cfg(not(any(unix, windows)))]
fn identity(path: &Path) -> Option<Identity> {
    fs::canonicalize(path).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compare(outputs: &[PathBuf], inputs: &[PathBuf]) -> Result<(), Error> {
        check_distinct(outputs.iter().cloned(), inputs.iter().cloned())
    }

    #[test]
    fn two_names_of_one_file_are_found_whether_it_exists_or_not() {
        let home = tempfile::tempdir().unwrap();
        let path = |name: &str| home.path().join(name);
        fs::create_dir(path("a")).unwrap();
        fs::write(path("a/old"), "").unwrap();
        for name in ["old", "new", "b/c/new"] {
            let first = path("a").join(name);
            for second in [
                format!("a/./{name}"),
                format!("a/../a/{name}"),
                format!("a/x/../{name}"),
            ] {
                let twice = compare(&[first.clone(), path(&second)], &[]);
                assert!(matches!(twice, Err(Error::WrittenTwice { .. })), "{second}");
            }
            compare(&[first, path("a/other"), path(name)], &[]).unwrap();
            for pair in [[name, "x"], ["x", name]].map(|[folder, file]| [path(folder), path(folder).join(file)]) {
                for pair in [pair.clone(), pair.map(|path| path.join("."))] {
                    let within = compare(&pair, &[]);
                    assert!(matches!(within, Err(Error::WithinOutput { .. })), "{pair:?}");
                }
            }
        }
        let over = compare(&[path("new"), path("a/../a/old")], &[path("a/old")]);
        assert!(matches!(over, Err(Error::OverwritesInput { .. })));
    }

    #[cfg(windows)]
    #[test]
    fn names_are_compared_without_case() {
        let home = tempfile::tempdir().unwrap();
        let twice = compare(&["New", "nEW"].map(|name| home.path().join(name)), &[]);
        assert!(matches!(twice, Err(Error::WrittenTwice { .. })));
    }

    #[cfg(windows)]
    #[test]
    fn names_that_cannot_be_written_are_refused() {
        let refused = compare(&["con.png".into()], &[]);
        assert!(matches!(refused, Err(Error::Usage(_))));
    }

    #[cfg(unix)]
    #[test]
    fn links_to_files_and_folders_are_followed() {
        use std::os::unix::fs::symlink;
        let home = tempfile::tempdir().unwrap();
        let path = |name: &str| home.path().join(name);
        fs::create_dir(path("a")).unwrap();
        symlink("a", path("b")).unwrap();
        symlink("a/new", path("link")).unwrap();
        for second in ["b/new", "link"] {
            let twice = compare(&[path("a/new"), path(second)], &[]);
            assert!(matches!(twice, Err(Error::WrittenTwice { .. })), "{second}");
        }
        fs::write(path("a/new"), "").unwrap();
        fs::hard_link(path("a/new"), path("hard")).unwrap();
        for output in ["b/new", "link", "hard"] {
            let over = compare(&[path(output)], &[path("a/new")]);
            assert!(matches!(over, Err(Error::OverwritesInput { .. })), "{output}");
        }
    }
}
