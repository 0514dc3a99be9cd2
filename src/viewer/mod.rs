//! The live viewer: a page that flies the camera through a scene and keeps its path.
//!
//! A [`Viewer`] serves one page on one address. The page sends the wanted camera, never a list of moves; the viewer renders the
//! newest one and cancels older ones. It uses the plan of the batch job: the last picture of a view has the pixels that the job
//! writes.
//!
//! Every request needs the secret of the address. The viewer writes only the camera path file and, on request, the files of the job.

use std::{io, net::TcpListener, path::Path, sync::Arc, thread};

use crate::{batch::Request, error::Error, render::Cancel, warnings::WarningKind};

mod base;
mod camera;
mod canvas;
mod connection;
mod guard;
mod job;
mod keyframes;
mod live;
mod look;
mod message;
mod options;
mod pace;
mod page;
mod pick;
mod picture;
mod server;
mod session;
mod visitors;

pub use options::ViewerOptions;

use base::Base;
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
        let base = Base::load(scene, request, options)?;
        let failed = |cause: io::Error| Error::Listen {
            address: options.listen,
            cause,
        };
        let listener = TcpListener::bind(options.listen).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let guard = Guard::new(address).map_err(failed)?;
        let session = Arc::new(Session::new(base)?);
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
        let session = Arc::clone(&self.session);
        let renderer = thread::Builder::new()
            .name("view".to_owned())
            .spawn(move || live::run(&session, threads))
            .map_err(|e| Error::threads("the thread that renders the view", &e))?;
        // The viewer also stops when its renderer ends.
        let is_over = || stop.is_cancelled() || renderer.is_finished();
        let served = server::run(self.listener, self.guard, &self.session, &is_over);
        self.session.stop();
        renderer
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        self.session.finish_job();
        if self.session.has_unsaved_keys() {
            let (path, warnings) = (
                self.session.base.camera_path.display(),
                &self.session.base.request.warnings,
            );
            warnings.add_live(
                WarningKind::UNSAVED_KEYS,
                path,
                "keys of the camera path were not saved",
            );
        }
        served
    }
}
