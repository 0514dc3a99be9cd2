//! The session: the single view of all pages, and its changes.
//!
//! Input is state: a page sends the wanted camera, and the newest one counts. A change cancels the rendering of the last view.

use std::{
    path::Path,
    sync::{
        Arc, Condvar, Mutex, MutexGuard,
        atomic::{AtomicU64, Ordering},
    },
    thread::JoinHandle,
    time::Duration,
};

use tokio::sync::watch;

use super::{
    base::{Base, Source},
    camera::{LensNumbers, ViewCamera},
    keyframes::{Keyframes, SaveError},
    look::Look,
    message::{Answer, Facts, JobFacts, KeyFact, SceneFacts, unsupported},
    pick,
    picture::{Picture, Stage},
    view::{Task, View},
};
use crate::{
    assets::SuppliedFile,
    batch::{Plan, Request},
    camera::path::{CameraPath, MAX_FRAME, PathError},
    error::Error,
    math::Vec2,
    render::Cancel,
};

struct State {
    base: Arc<Base>,
    view: View,
    /// The look of the request.
    first_look: Look,
    look: Look,
    plan: Arc<Plan>,
    keyframes: Keyframes,
    /// Cancels the rendering of the current view.
    cancel: Arc<Cancel>,
    is_stopped: bool,
    /// Whether a page has asked for the scene to be loaded again.
    needs_load: bool,
}

/// A job that a page has started.
pub struct RunningJob {
    pub cancel: Arc<Cancel>,
    pub thread: JoinHandle<()>,
}

/// The view, and the pages that show it.
pub struct Session {
    pub source: Source,
    state: Mutex<State>,
    changed: Condvar,
    running_job: Mutex<Option<RunningJob>>,
    pages: AtomicU64,
    pub pictures: watch::Sender<Option<Arc<Picture>>>,
    pub facts: watch::Sender<Arc<str>>,
    pub keys: watch::Sender<Arc<[KeyFact]>>,
    pub scene: watch::Sender<SceneFacts>,
    pub job: watch::Sender<JobFacts>,
    pub job_pictures: watch::Sender<Option<Arc<Picture>>>,
}

impl Session {
    /// Loads the scene and the camera path of `source`.
    pub fn open(source: Source) -> Result<Self, Error> {
        let mut keyframes = Keyframes::open(&source.options.camera_path, &source.request)?;
        let base = source.load(keyframes.file(), source.request.warnings.clone())?;
        keyframes.set_scene_timing(base.job.desc.timing);
        let look = base.look();
        let plan = Arc::new(base.plan(&look)?);
        let (frame, path) = match keyframes.path() {
            Some(path) => (first_frame(path), Some(Arc::clone(path))),
            None => (base.plan.first_frame, None),
        };
        let camera = base.camera_at(path.as_deref(), frame);
        let is_home = camera.is_none();
        let camera = camera.or_else(|| base.home_camera(frame.round() as i32));
        let camera = camera.ok_or_else(|| Error::NoCamera {
            path: source.scene.clone(),
        })?;
        let session = Self {
            state: Mutex::new(State {
                base: Arc::new(base),
                view: View {
                    version: 1,
                    client: 0,
                    seq: 0,
                    frame,
                    camera,
                    path,
                    lens: None,
                    is_home,
                },
                plan,
                first_look: look.clone(),
                look,
                keyframes,
                cancel: Arc::default(),
                is_stopped: false,
                needs_load: false,
            }),
            source,
            changed: Condvar::new(),
            running_job: Mutex::default(),
            pages: AtomicU64::new(0),
            pictures: watch::Sender::new(None),
            facts: watch::Sender::new(Arc::from("")),
            keys: watch::Sender::default(),
            scene: watch::Sender::new(SceneFacts {
                t: "scene",
                ..SceneFacts::default()
            }),
            job: watch::Sender::new(JobFacts {
                t: "job",
                state: "idle",
                ..JobFacts::default()
            }),
            job_pictures: watch::Sender::new(None),
        };
        session.tell_keys(&session.lock());
        session.tell(&session.lock());
        Ok(session)
    }

    /// The number of a new page, from 1.
    pub fn join(&self) -> u64 {
        self.pages.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// The scene as it was last loaded.
    pub fn base(&self) -> Arc<Base> {
        Arc::clone(&self.lock().base)
    }

    /// Waits for a view newer than `version`; `None` once the session has stopped.
    pub fn next_task(&self, version: u64) -> Option<Task> {
        let mut state = self.lock();
        while !state.is_stopped && state.view.version <= version {
            state = self
                .changed
                .wait(state)
                .expect("no thread panics while it holds the session");
        }
        (!state.is_stopped).then(|| Task {
            base: Arc::clone(&state.base),
            view: state.view.clone(),
            look: state.look.clone(),
            plan: Arc::clone(&state.plan),
            cancel: Arc::clone(&state.cancel),
        })
    }

    /// Waits for a view newer than `version`, at most for `time`; returns whether there is one, or the session has stopped.
    pub fn waits_for_newer(&self, version: u64, time: Duration) -> bool {
        let state = self.lock();
        let is_same = |state: &mut State| !state.is_stopped && state.view.version <= version;
        let waited = self.changed.wait_timeout_while(state, time, is_same);
        !waited
            .expect("no thread panics while it holds the session")
            .1
            .timed_out()
    }

    /// Whether a picture shows all samples of the current view.
    pub fn is_final(&self, picture: &Picture) -> bool {
        picture.stage == Stage::Final && picture.version == self.lock().view.version
    }

    /// Ends the rendering.
    pub fn stop(&self) {
        let mut state = self.lock();
        state.is_stopped = true;
        state.cancel.cancel();
        self.changed.notify_all();
    }

    pub fn has_unsaved_keys(&self) -> bool {
        self.lock().keyframes.is_changed()
    }

    /// Moves the camera.
    pub fn set_camera(&self, (client, seq): (u64, u64), camera: ViewCamera) -> Result<(), String> {
        if !camera.is_bounded() {
            return Err("a number of the camera is out of range".to_owned());
        }
        let mut state = self.lock();
        let mut view = state.view.clone();
        view.leave_path(&state.base);
        let lens = view.lens(&state.base);
        if let Some(column) = unsupported(&camera.lens, lens.columns()) {
            return Err(format!("the scene's {} camera has no use for {column}", lens.name()));
        }
        camera.state(state.view.frame).map_err(|e| e.to_string())?;
        state.view = View { camera, ..view };
        self.change(&mut state, (client, seq));
        Ok(())
    }

    /// Moves the camera to that of the scene, which it follows from frame to frame.
    pub fn go_home(&self, from: (u64, u64)) -> Result<(), String> {
        let mut state = self.lock();
        let home = state.base.home_camera(state.view.whole_frame());
        state.view.camera = home.ok_or("the scene has no camera of its own")?;
        (state.view.path, state.view.lens, state.view.is_home) = (None, None, true);
        self.change(&mut state, from);
        Ok(())
    }

    /// Goes to a frame, with the camera of the path if it has one there, or that of the scene if it is shown.
    pub fn set_frame(&self, from: (u64, u64), frame: f64) -> Result<(), String> {
        if frame.abs() > MAX_FRAME as f64 {
            return Err(PathError::FrameNumber(frame).to_string());
        }
        let mut state = self.lock();
        state.view.frame = frame;
        self.follow_path(&mut state);
        self.change(&mut state, from);
        Ok(())
    }

    pub fn set_look(&self, from: (u64, u64), look: Look) -> Result<(), String> {
        if !look.is_bounded() {
            return Err("a number of the look is out of range".to_owned());
        }
        let mut state = self.lock();
        let plan = state.base.plan(&look).map_err(|e| e.to_string())?;
        (state.look, state.plan) = (look, Arc::new(plan));
        self.change(&mut state, from);
        self.tell(&state);
        Ok(())
    }

    /// Adds or replaces the key of the current frame.
    pub fn set_key(&self) -> Result<(), String> {
        let mut state = self.lock();
        let key = state.view.camera.key(state.view.frame);
        let lens = state.base.lens;
        let set = state.keyframes.set(&key, &lens);
        state.view.frame = set.map_err(|e| e.to_string())?;
        self.edited(&mut state);
        Ok(())
    }

    pub fn move_key(&self, from: f64, to: f64) -> Result<(), String> {
        let mut state = self.lock();
        state.keyframes.move_key(from, to).map_err(|e| e.to_string())?;
        self.edited(&mut state);
        Ok(())
    }

    pub fn delete_key(&self, frame: f64) -> Result<(), String> {
        let mut state = self.lock();
        state.keyframes.remove(frame).map_err(|e| e.to_string())?;
        self.edited(&mut state);
        Ok(())
    }

    pub fn save(&self, force: bool) -> Answer {
        let mut state = self.lock();
        let answer = match state.keyframes.save(force) {
            Ok(()) => Answer::done(format!("saved {}", self.source.options.camera_path.display())),
            Err(SaveError::Foreign) => Answer::Foreign,
            Err(error) => Answer::error(error),
        };
        self.tell(&state);
        answer
    }

    pub fn load(&self) -> Result<(), String> {
        let mut state = self.lock();
        state.keyframes.load().map_err(|e| e.to_string())?;
        self.edited(&mut state);
        Ok(())
    }

    /// The surface at a point of the picture, from 0 to 1 to the right and down.
    pub fn pick(&self, id: u64, [x, y]: [f32; 2]) -> Answer {
        let (base, view) = {
            let state = self.lock();
            (Arc::clone(&state.base), state.view.clone())
        };
        let film = base.resolution();
        let point = Vec2::new(x * film[0] as f32, y * film[1] as f32);
        let camera = view.frame_camera(&base, film).ok();
        Answer::Picked {
            id,
            found: camera.and_then(|camera| base.shown.look(|scene| pick::pick(scene, &camera, point))?),
        }
    }

    /// The request of the job that renders the page's path.
    ///
    /// # Errors
    /// The path was not saved, or the scene on disk is not that of the page.
    pub fn job_request(&self) -> Result<Request, String> {
        if self.look_at_files() {
            return Err("the scene has changed on disk: reload it before it is rendered".to_owned());
        }
        let state = self.lock();
        if state.keyframes.is_changed() {
            return Err("save the keys before they are rendered".to_owned());
        }
        if state.keyframes.has_keys() && state.keyframes.has_changed_on_disk() {
            return Err(
                "another program has changed the camera path: load or save it before it is rendered".to_owned(),
            );
        }
        let request = state.look.apply_changes(&state.first_look, &state.base.request);
        let camera_path = &self.source.options.camera_path;
        Ok(Request {
            camera_path: state.keyframes.has_keys().then(|| camera_path.clone()),
            ..request
        })
    }

    /// Compares the files of the scene with those on disk, and tells the pages. Returns whether they have changed.
    pub fn look_at_files(&self) -> bool {
        let has_changed = self.base().files.have_changed();
        self.scene.send_if_modified(|facts| {
            let is_news = facts.has_changed != has_changed;
            facts.has_changed = has_changed;
            if is_news {
                facts.error.clear();
            }
            is_news
        });
        has_changed
    }

    /// Tells the pages why the frame of the view has no picture, or that it has one.
    pub fn tell_frame(&self, error: Option<Error>) {
        let text = error.map_or_else(String::new, |error| error.messages().join("\n"));
        self.scene.send_if_modified(|facts| {
            let is_news = facts.frame_error != text;
            facts.frame_error = text;
            is_news
        });
    }

    /// The camera path with its keys; without keys that with which the scene was loaded.
    pub fn path(&self) -> Option<SuppliedFile> {
        let state = self.lock();
        state.keyframes.file().or_else(|| state.base.path.clone())
    }

    /// Asks for the scene to be loaded again.
    pub fn ask_for_load(&self) {
        self.lock().needs_load = true;
        self.changed.notify_all();
    }

    /// Waits until the scene is to be loaded again, at most for `time`, and returns whether it is;
    /// `None` once the session has stopped.
    pub fn next_load(&self, time: Duration) -> Option<bool> {
        let is_idle = |state: &mut State| !state.is_stopped && !state.needs_load;
        let waited = self.changed.wait_timeout_while(self.lock(), time, is_idle);
        let (mut state, _) = waited.expect("no thread panics while it holds the session");
        (!state.is_stopped).then(|| std::mem::take(&mut state.needs_load))
    }

    /// Shows another scene with the camera and the changes of the look that pages have made.
    pub fn replace(&self, base: Base) -> Result<(), Error> {
        let mut state = self.lock();
        let first_look = base.look();
        let look = state.look.rebased(&state.first_look, &first_look);
        state.plan = Arc::new(base.plan(&look)?);
        (state.look, state.first_look) = (look, first_look);
        let frame = state.view.whole_frame();
        let is_home = state.view.path.is_none() && state.view.is_home;
        if let Some(home) = base.home_camera(frame).filter(|_| is_home) {
            state.view.camera = home;
        }
        if unsupported(&state.view.camera.lens, base.lens.columns()).is_some() {
            state.view.camera.lens = LensNumbers::default();
        }
        state.keyframes.set_scene_timing(base.job.desc.timing);
        state.base = Arc::new(base);
        if state.view.path.is_some() {
            self.follow_path(&mut state);
        }
        // Pages hear of the scene before they get a picture of it.
        self.scene.send_modify(|facts| {
            (facts.has_changed, facts.is_loading) = (false, false);
            facts.error.clear();
            facts.loads += 1;
        });
        let from = (state.view.client, state.view.seq);
        self.change(&mut state, from);
        self.tell(&state);
        Ok(())
    }

    /// The current or last job.
    pub fn running_job(&self) -> MutexGuard<'_, Option<RunningJob>> {
        self.running_job
            .lock()
            .expect("no thread panics while it holds the job")
    }

    pub fn cancel_job(&self) {
        if let Some(job) = &*self.running_job() {
            job.cancel.cancel();
        }
    }

    /// Cancels the job and waits for its end.
    pub fn finish_job(&self) {
        let job = self.running_job().take();
        if let Some(RunningJob { cancel, thread }) = job {
            cancel.cancel();
            // The panic of a job has already been reported.
            let _ = thread.join();
        }
    }

    fn edited(&self, state: &mut State) {
        let from = (state.view.client, state.view.seq);
        self.follow_path(state);
        self.change(state, from);
        self.tell_keys(state);
        self.tell(state);
    }

    /// Sets the camera to that of the path at the frame.
    fn follow_path(&self, state: &mut State) {
        let path = state.keyframes.path().cloned();
        let camera = state.base.camera_at(path.as_deref(), state.view.frame);
        state.view.path = path.filter(|_| camera.is_some());
        state.view.is_home &= camera.is_none();
        let home = || state.base.home_camera(state.view.whole_frame());
        if let Some(camera) = camera.or_else(|| state.view.is_home.then(home).flatten()) {
            state.view.camera = camera;
        }
    }

    fn change(&self, state: &mut State, (client, seq): (u64, u64)) {
        state.view.version += 1;
        (state.view.client, state.view.seq) = (client, seq);
        state.cancel.cancel();
        state.cancel = Arc::default();
        self.changed.notify_all();
    }

    /// Sends the keys to all pages.
    fn tell_keys(&self, state: &State) {
        self.keys
            .send_replace(state.keyframes.keys().map(KeyFact::of).collect());
    }

    /// Sends changed facts to all pages.
    fn tell(&self, state: &State) {
        let options = &self.source.options;
        let mut changes = state.look.options(&state.first_look);
        if state.keyframes.has_keys() {
            changes.push(("frames", file_name(&options.camera_path)));
        }
        let facts = Facts {
            t: "facts",
            look: &state.look,
            file: file_name(&options.camera_path),
            is_changed: state.keyframes.is_changed(),
            command: (options.command)(&changes),
        };
        let json = serde_json::to_string(&facts).expect("facts are numbers and words");
        self.facts.send_replace(Arc::from(json));
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("no thread panics while it holds the session")
    }
}

/// The first whole frame of a path, or its beginning if all of it lies between two frames.
fn first_frame(path: &CameraPath) -> f64 {
    let frames = path.frames();
    if frames.is_empty() {
        path.first()
    } else {
        *frames.start() as f64
    }
}

fn file_name(path: &Path) -> String {
    path.display().to_string()
}
