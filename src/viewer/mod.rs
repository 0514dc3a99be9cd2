//! The live viewer: a page that flies the camera through a scene and keeps its path.
//!
//! A [`Viewer`] serves one page on one address. The page sends the wanted camera, never a list of moves; the viewer renders the
//! newest one and cancels older ones. It uses the plan of the batch job: the last picture of a view has the pixels that the job
//! writes.
//!
//! Every request needs the secret of the address. The viewer writes only the camera path file, with a copy of
//! the old one, and, on request, the files of the job.

use std::{
    io,
    net::TcpListener,
    panic::resume_unwind,
    path::Path,
    sync::Arc,
    thread::{self, JoinHandle},
};

use crate::{batch::Request, error::Error, render::Cancel, warnings::WarningKind};

mod base;
mod camera;
mod canvas;
mod connection;
mod guard;
mod input_files;
mod job;
mod keyframes;
mod live;
mod look;
mod message;
mod numbers;
mod options;
mod pace;
mod page;
mod pick;
mod picture;
mod reload;
mod seeker;
mod server;
mod session;
mod shown;
mod view;
mod visitors;

pub use options::ViewerOptions;

use base::Source;
use guard::Guard;
use session::Session;

/// A live viewer, ready to serve.
pub struct Viewer {
    session: Arc<Session>,
    listener: TcpListener,
    guard: Guard,
}

impl Viewer {
    /// Loads a scene and its camera path, builds the acceleration structure on the threads of the current rayon pool, and binds the
    /// address.
    ///
    /// # Errors
    /// The scene or the camera path is invalid, or the address is in use.
    pub fn open(scene: &Path, request: &Request, options: &ViewerOptions) -> Result<Self, Error> {
        let source = Source {
            scene: scene.to_owned(),
            request: request.clone(),
            options: options.clone(),
            threads: rayon::current_num_threads(),
        };
        let session = Arc::new(Session::open(source)?);
        let failed = |cause: io::Error| Error::Listen {
            address: options.listen,
            cause,
        };
        let listener = TcpListener::bind(options.listen).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let guard = Guard::new(address).map_err(failed)?;
        Ok(Self {
            session,
            listener,
            guard,
        })
    }

    /// The address of the page, with its secret.
    pub fn url(&self) -> String {
        self.guard.url()
    }

    /// Serves until `stop` is cancelled, and renders on `threads` threads.
    ///
    /// # Errors
    /// The system allows no more threads, or the server failed. Stopping the viewer is no error.
    pub fn run(self, threads: usize, stop: &Cancel) -> Result<(), Error> {
        let renderer = start(&self.session, "view", move |session| live::run(session, threads))?;
        let loader = start(&self.session, "scene", move |session| reload::run(session, threads))?;
        // The viewer also stops when its renderer ends.
        let is_over = || stop.is_cancelled() || renderer.is_finished();
        let served = server::run(self.listener, self.guard, &self.session, &is_over);
        self.session.stop();
        loader.join().unwrap_or_else(|panic| resume_unwind(panic));
        renderer.join().unwrap_or_else(|panic| resume_unwind(panic))?;
        self.session.finish_job();
        if self.session.has_unsaved_keys() {
            let Source { request, options, .. } = &self.session.source;
            request.warnings.add_live(
                WarningKind::UNSAVED_KEYS,
                options.camera_path.display(),
                "keys of the camera path were not saved",
            );
        }
        served
    }
}

/// Starts a thread that ends when the session stops.
fn start<T: Send + 'static>(
    session: &Arc<Session>,
    name: &str,
    work: impl FnOnce(&Session) -> T + Send + 'static,
) -> Result<JoinHandle<T>, Error> {
    let own = Arc::clone(session);
    let thread = thread::Builder::new().name(name.to_owned());
    thread.spawn(move || work(&own)).map_err(|e| {
        session.stop();
        Error::threads("the threads of the viewer", &e)
    })
}
