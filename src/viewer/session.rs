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
    base::Base,
    camera::ViewCamera,
    keyframes::{Keyframes, SaveError},
    look::Look,
    message::{Answer, Facts, Hello, JobFacts, KeyFact, supported},
    pick,
    picture::{Picture, Stage},
};
use crate::{
    batch::{Plan, Request},
    camera::{
        FilmSize, FrameCamera, Lens, LookAt,
        path::{CameraPath, Interp, MAX_FRAME, PathError},
    },
    error::Error,
    film::passes::{BEAUTY, PASSES, PassSource},
    integrator::IntegratorDesc,
    math::{DVec3, Vec2},
    output::DisplayTransform,
    render::Cancel,
};

/// The view that pages see.
#[derive(Clone, Debug)]
pub struct View {
    /// Increases with each change.
    pub version: u64,
    /// The page that made the last change, and the number of its message.
    pub client: u64,
    pub seq: u64,
    pub frame: i64,
    pub camera: ViewCamera,
    /// The path that gives the camera at the frame; `None` for `camera` itself.
    pub path: Option<Arc<CameraPath>>,
}

impl View {
    /// The camera for a film.
    pub fn frame_camera(&self, lens: &Lens, film: FilmSize) -> Result<FrameCamera, PathError> {
        match &self.path {
            Some(path) => path.frame_camera(self.frame, lens, film),
            None => self.camera.frame_camera(self.frame, lens, film),
        }
    }
}

/// A view to be rendered.
pub struct Task {
    pub view: View,
    pub look: Look,
    pub plan: Arc<Plan>,
    pub cancel: Arc<Cancel>,
}

struct State {
    view: View,
    look: Look,
    plan: Arc<Plan>,
    keyframes: Keyframes,
    /// Cancels the rendering of the current view.
    cancel: Arc<Cancel>,
    is_stopped: bool,
}

/// A job that a page has started.
pub struct RunningJob {
    pub cancel: Arc<Cancel>,
    pub thread: JoinHandle<()>,
}

/// The view, and the pages that show it.
pub struct Session {
    pub base: Base,
    state: Mutex<State>,
    changed: Condvar,
    first_look: Look,
    running_job: Mutex<Option<RunningJob>>,
    pages: AtomicU64,
    pub pictures: watch::Sender<Option<Arc<Picture>>>,
    pub facts: watch::Sender<Arc<str>>,
    pub job: watch::Sender<JobFacts>,
    pub job_pictures: watch::Sender<Option<Arc<Picture>>>,
}

impl Session {
    pub fn new(mut base: Base) -> Result<Self, Error> {
        let look = base.look();
        let plan = Arc::new(base.plan(&look)?);
        let keyframes = base.keyframes.take().expect("a base is made with keyframes");
        let (frame, path) = match keyframes.path() {
            Some(path) => (*path.frames().start(), Some(Arc::clone(path))),
            None => (1, None),
        };
        let camera = camera_at(&base, path.as_deref(), frame).or_else(|| home(&base));
        let camera = camera.ok_or_else(|| Error::NoCamera {
            path: base.scene_path.clone(),
        })?;
        let session = Self {
            state: Mutex::new(State {
                view: View {
                    version: 1,
                    client: 0,
                    seq: 0,
                    frame,
                    camera,
                    path,
                },
                plan,
                look: look.clone(),
                keyframes,
                cancel: Arc::default(),
                is_stopped: false,
            }),
            base,
            changed: Condvar::new(),
            first_look: look,
            running_job: Mutex::default(),
            pages: AtomicU64::new(0),
            pictures: watch::Sender::new(None),
            facts: watch::Sender::new(Arc::from("")),
            job: watch::Sender::new(JobFacts {
                t: "job",
                state: "idle",
                ..JobFacts::default()
            }),
            job_pictures: watch::Sender::new(None),
        };
        session.tell(&session.lock());
        Ok(session)
    }

    /// The number of a new page, from 1.
    pub fn join(&self) -> u64 {
        self.pages.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// The first message to the page `client`.
    pub fn hello(&self, client: u64) -> String {
        let passes: Vec<&str> = PASSES
            .iter()
            .filter(|pass| !matches!(pass.source, PassSource::Integrator | PassSource::LightGroup))
            .map(|pass| pass.name)
            .collect();
        let views = DisplayTransform::ALL.map(DisplayTransform::name);
        let fps = self.base.request.fps.unwrap_or(24.0);
        let hello = Hello {
            t: "hello",
            client,
            scene: &self.base.desc.name(),
            resolution: self.base.resolution(),
            integrators: IntegratorDesc::NAMES,
            views: &views,
            passes: &[&[BEAUTY.name], &passes[..]].concat(),
            columns: self.base.lens.columns(),
            step: self.base.step,
            fps,
            up: self.base.up().to_array(),
            has_home: self.base.home.is_some(),
            warnings: self.base.request.warnings.lines(),
        };
        serde_json::to_string(&hello).expect("a hello is numbers and words")
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
        if let Some(column) = supported(&camera.lens, self.base.lens.columns()) {
            return Err(format!(
                "the scene's {} camera has no use for {column}",
                self.base.lens.name()
            ));
        }
        if !camera.is_bounded() {
            return Err("a number of the camera is out of range".to_owned());
        }
        let mut state = self.lock();
        camera.state(state.view.frame).map_err(|e| e.to_string())?;
        state.view.camera = camera;
        state.view.path = None;
        self.change(&mut state, (client, seq));
        Ok(())
    }

    /// Moves the camera to that of the scene.
    pub fn go_home(&self, from: (u64, u64)) -> Result<(), String> {
        let camera = home(&self.base).ok_or("the scene has no camera of its own")?;
        self.set_camera(from, camera)
    }

    /// Goes to a frame, with the camera of the path if it has one there.
    pub fn set_frame(&self, from: (u64, u64), frame: i64) -> Result<(), String> {
        if frame.abs() > MAX_FRAME {
            return Err(PathError::FrameNumber(frame as f64).to_string());
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
        let plan = self.base.plan(&look).map_err(|e| e.to_string())?;
        let mut state = self.lock();
        (state.look, state.plan) = (look, Arc::new(plan));
        self.change(&mut state, from);
        self.tell(&state);
        Ok(())
    }

    /// Adds or replaces the key of the current frame.
    pub fn set_key(&self) -> Result<(), String> {
        let mut state = self.lock();
        let key = state.view.camera.key(state.view.frame as f64);
        let set = state.keyframes.set(&key, &self.base.lens);
        set.map_err(|e| e.to_string())?;
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
            Ok(()) => Answer::done(format!("saved {}", self.base.camera_path.display())),
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
        let film = self.base.resolution();
        let view = self.lock().view.clone();
        let point = Vec2::new(x * film[0] as f32, y * film[1] as f32);
        let camera = view.frame_camera(&self.base.lens, film).ok();
        Answer::Picked {
            id,
            found: camera.and_then(|camera| pick::pick(&self.base.scene, &camera, point)),
        }
    }

    /// The request of the job that renders the page's path.
    ///
    /// # Errors
    /// The path was not saved.
    pub fn job_request(&self) -> Result<Request, String> {
        let state = self.lock();
        if state.keyframes.is_changed() {
            return Err("save the keys before they are rendered".to_owned());
        }
        let request = state.look.apply_changes(&self.first_look, &self.base.request);
        Ok(Request {
            camera_path: state.keyframes.has_keys().then(|| self.base.camera_path.clone()),
            ..request
        })
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
        self.tell(state);
    }

    /// Sets the camera to that of the path at the frame.
    fn follow_path(&self, state: &mut State) {
        let path = state.keyframes.path().cloned();
        let camera = camera_at(&self.base, path.as_deref(), state.view.frame);
        state.view.path = path.filter(|_| camera.is_some());
        if let Some(camera) = camera {
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

    /// Sends changed facts to all pages.
    fn tell(&self, state: &State) {
        let interp = |interp| match interp {
            Interp::Smooth => "smooth",
            Interp::Linear => "linear",
            Interp::Step => "hold",
        };
        let keys = state.keyframes.keys().map(|key| KeyFact {
            frame: key.frame,
            name: key.name.as_deref(),
            interp: interp(key.interp),
        });
        let mut changes = state.look.options(&self.first_look);
        if state.keyframes.has_keys() {
            changes.push(("frames", file_name(&self.base.camera_path)));
        }
        let facts = Facts {
            t: "facts",
            look: &state.look,
            keys: keys.collect(),
            file: file_name(&self.base.camera_path),
            is_changed: state.keyframes.is_changed(),
            command: (self.base.command)(&changes),
        };
        let json = serde_json::to_string(&facts).expect("facts are numbers and words");
        self.facts.send_replace(Arc::from(json));
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("no thread panics while it holds the session")
    }
}

/// The scene's own camera.
fn home(base: &Base) -> Option<ViewCamera> {
    let (eye, at) = base.home.as_ref()?;
    Some(ViewCamera::new(*eye, at))
}

/// The camera of a path at a frame; `None` outside of the path.
fn camera_at(base: &Base, path: Option<&CameraPath>, frame: i64) -> Option<ViewCamera> {
    let state = path?.at(frame as f64).ok()?;
    Some(ViewCamera::of_state(&state, base.up(), base.distance()))
}

impl Base {
    /// The up direction.
    fn up(&self) -> DVec3 {
        self.home.as_ref().map_or(DVec3::Y, |(_, at)| at.up)
    }

    /// The default distance of a target, in m.
    fn distance(&self) -> f64 {
        let of_home = |(eye, at): &(DVec3, LookAt)| eye.distance(at.target);
        self.home.as_ref().map_or(10.0 * self.step, of_home)
    }
}

fn file_name(path: &Path) -> String {
    path.display().to_string()
}
