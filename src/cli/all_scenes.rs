//! The figures of all scenes of a command in one file (`--stats`) and on one page (`--report`),
//! where their names have no `{scene}`.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

use batch_render::{
    error::Error,
    output::{OutputError, atomic, job_file::FolderGate},
};

use super::{
    arguments::arguments,
    figure_files::{ALBUM, Joining, PAGE, read, write_text},
    figures::{Album, SceneReport, SceneReports, State},
    scenes_page::{SceneRow, scenes_page},
};

/// The files are written again when figures change, but no more often than this, ...
const WRITE_EVERY: Duration = Duration::from_secs(1);
/// ... and only if as many times the duration of the last writing have passed.
const PAUSE: u32 = 50;

/// The files of a command, with the figures so far.
pub struct AllScenes {
    json: Option<PathBuf>,
    /// The word for a scene: an eye in stereo.
    noun: &'static str,
    /// The folder of the page. The page of each scene is in the folder of its name there.
    page: Option<PathBuf>,
    /// Whether other processes may write the files as well.
    joins: bool,
    start: Instant,
    state: Mutex<Collected>,
}

struct Collected {
    scenes: Vec<Scene>,
    written: Instant,
    /// The duration of the last writing.
    took: Duration,
}

struct Scene {
    report: SceneReport,
    joining: Option<Joining>,
    row: Option<SceneRow>,
    /// Whether the figures are newer than those in the file.
    is_new: bool,
}

/// The place of one scene among the figures.
#[derive(Clone, Copy)]
pub struct SceneFigures<'a> {
    all: &'a AllScenes,
    index: usize,
}

impl SceneFigures<'_> {
    /// Puts in the figures so far of the scene's job, which keeps those of other jobs in this way.
    pub fn put(&self, album: &Album, joining: Option<&Joining>) {
        let mut state = self.all.lock();
        let scene = &mut state.scenes[self.index];
        // The end of the job is not yet that of the scene.
        scene.report.state = State::Running;
        scene.report.figures = Some(album.figures.clone());
        scene.joining = joining.cloned();
        scene.row = Some(SceneRow::new(&album.figures, album.thumbnails.values().next()));
        scene.is_new = true;
        self.all.write_sometimes(&mut state);
    }
}

impl AllScenes {
    /// The files with these paths, if any, of scenes with this word for one, and these names and paths. With `joins` other
    /// processes may write them as well.
    pub fn new(
        [json, page]: [Option<&PathBuf>; 2],
        (noun, scenes): (&'static str, impl Iterator<Item = (String, String)>),
        joins: bool,
    ) -> Option<Self> {
        let scene = |(name, scene)| Scene {
            report: SceneReport {
                name,
                scene,
                state: State::Waiting,
                reason: None,
                figures: None,
            },
            joining: None,
            row: None,
            is_new: false,
        };
        (json.is_some() || page.is_some()).then(|| Self {
            json: json.cloned(),
            noun,
            page: page.cloned(),
            joins,
            start: Instant::now(),
            state: Mutex::new(Collected {
                scenes: scenes.map(scene).collect(),
                written: Instant::now(),
                took: Duration::ZERO,
            }),
        })
    }

    /// The files.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        let page = self.page.iter().map(|folder| folder.join(PAGE));
        self.json.iter().cloned().chain(page)
    }

    /// Finds out whether the files can be written, and makes their folders.
    ///
    /// # Errors
    /// They cannot, or one exists and `is_new` says that none may.
    pub fn check(&self, is_new: bool) -> Result<(), Error> {
        self.files().try_for_each(|path| match is_new && path.exists() {
            true => Err(Error::Exists { path }),
            false => {
                atomic::check_kind(&path)?;
                Ok(atomic::check(&path)?)
            }
        })
    }

    /// The place of the scene with this index.
    pub fn scene(&self, index: usize) -> SceneFigures<'_> {
        SceneFigures { all: self, index }
    }

    /// Says how a scene has ended.
    pub fn end(&self, index: usize, result: &anyhow::Result<()>) {
        let mut state = self.lock();
        let scene = &mut state.scenes[index];
        scene.report.state = State::of_command(result);
        scene.report.reason = result.as_ref().err().map(|error| format!("{error:#}"));
        scene.is_new = true;
        self.write_sometimes(&mut state);
    }

    /// Writes the files for the last time, of a command that has ended in this state. Returns the errors
    /// of those that cannot be written.
    pub fn finish(&self, end: State) -> Vec<OutputError> {
        let mut state = self.lock();
        if let Some(folder) = self.page.as_ref().filter(|_| self.joins) {
            for scene in &mut state.scenes {
                let album = read::<Album>(&folder.join(&scene.report.name).join(ALBUM))
                    .ok()
                    .flatten();
                let row = album.map(|album| SceneRow::new(&album.figures, album.thumbnails.values().next()));
                scene.row = row.or(scene.row.take());
            }
        }
        let written = self.write(&mut state, end);
        written.into_iter().map(|(_, error)| error).collect()
    }

    fn lock(&self) -> MutexGuard<'_, Collected> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn write_sometimes(&self, state: &mut Collected) {
        if state.written.elapsed() >= WRITE_EVERY.max(PAUSE * state.took) {
            // No reason to stop rendering.
            for (flag, error) in self.write(state, State::Running) {
                tracing::warn!("{flag}: {error}");
            }
        }
    }

    /// Writes the files. Returns the errors of those that cannot be written, each with its flag.
    fn write(&self, state: &mut Collected, of_all: State) -> Vec<(&'static str, OutputError)> {
        let begin = Instant::now();
        let json = self.json.as_ref();
        let json = json.map(|path| self.write_json(path, &mut state.scenes, of_all));
        let page = self.page.as_ref().map(|folder| {
            let rows = state.scenes.iter().map(|scene| (&scene.report, scene.row.as_ref()));
            write_text(
                &folder.join(PAGE),
                &scenes_page(self.noun, of_all, self.start.elapsed(), rows),
            )
        });
        (state.written, state.took) = (Instant::now(), begin.elapsed());
        let written = [("--stats", json), ("--report", page)].into_iter();
        written
            .filter_map(|(flag, written)| Some((flag, written?.err()?)))
            .collect()
    }

    fn write_json(&self, path: &Path, scenes: &mut [Scene], state: State) -> Result<(), OutputError> {
        // Other processes change nothing between reading and writing.
        let _gate = self.joins.then(|| FolderGate::close(&atomic::folder_of(path), None));
        let others = self.others(path);
        let scenes_of_file = scenes.iter().map(|scene| {
            let mut own = scene.report.clone();
            let Some(theirs) = others.get(&own.name) else {
                return own;
            };
            if !scene.is_new {
                return theirs.clone();
            }
            if let (Some(figures), Some(joining), Some(theirs)) = (&mut own.figures, &scene.joining, &theirs.figures) {
                let mut theirs = theirs.clone();
                if joining.select(&mut theirs, path) {
                    figures.join(theirs.frames);
                }
            }
            own
        });
        let scenes_of_file: Vec<SceneReport> = scenes_of_file.collect();
        let all = SceneReports {
            version: env!("CARGO_PKG_VERSION").into(),
            command: arguments().map(|word| word.to_string_lossy().into_owned()).collect(),
            wall_s: self.start.elapsed().as_secs_f64(),
            state,
            is_finished: scenes_of_file.iter().all(SceneReport::is_finished),
            scenes: scenes_of_file,
        };
        let text = serde_json::to_string_pretty(&all).expect("figures are plain data");
        write_text(path, &(text + "\n"))?;
        scenes.iter_mut().for_each(|scene| scene.is_new = false);
        Ok(())
    }

    /// The scenes in the file at `path`, by their names.
    fn others(&self, path: &Path) -> HashMap<String, SceneReport> {
        let found = match self.joins {
            true => read::<SceneReports>(path),
            false => Ok(None),
        };
        let found = found.unwrap_or_else(|cause| {
            tracing::warn!("the figures of other jobs are lost, {cause}: {}", path.display());
            None
        });
        let scenes = found.into_iter().flat_map(|found| found.scenes);
        scenes.map(|scene| (scene.name.clone(), scene)).collect()
    }
}
