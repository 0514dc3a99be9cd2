//! A job that is opened, and whose scene is loaded: in its turn, or ahead of it.

use std::{
    path::PathBuf,
    time::{Duration, Instant},
};

use batch_render::{
    batch::{Job, Request},
    error::Error,
    scene::SceneBuilder,
    simd::Isa,
    warnings::Warnings,
};
use rayon::ThreadPool;

use super::{
    args::RenderArgs, outlets::Outlets, progress::leave_stdout, request::request, stream::refuse_terminal,
    threads::threads,
};

/// A job with the threads that it runs on.
pub struct Opened {
    pub outlets: Outlets,
    pub pool: ThreadPool,
    pub job: Job,
    /// The scene, as the messages name it.
    pub path: PathBuf,
    pub warnings: Warnings,
    /// The scene, once [`Opened::load`] has loaded it.
    pub scene: Option<SceneBuilder>,
    /// The time of opening and loading so far.
    pub took: Duration,
}

impl Opened {
    /// Opens the job of these arguments. `warnings` collects what a user should know, also where it
    /// fails. `change` changes the request.
    ///
    /// # Errors
    /// The arguments do not fit together, or the scene is wrong.
    pub fn new(
        args: &RenderArgs,
        simd: Isa,
        warnings: &Warnings,
        change: impl FnOnce(&mut Request),
    ) -> anyhow::Result<Self> {
        let start = Instant::now();
        let path = args.scene.clone().expect("the scene is a required argument");
        let outlets = Outlets::new(args)?;
        let mut request = Request {
            warnings: warnings.clone(),
            ..request(args, &outlets, simd)?
        };
        change(&mut request);
        let path = request.supplied.as_ref().map_or(path, |(path, _)| path.clone());
        if outlets.stream.is_some() {
            leave_stdout();
            if !(args.check || args.dry_run || args.existing.list_stale) {
                refuse_terminal()?;
            }
        }
        let pool = threads(args.threads)?;
        let job = pool.install(|| Job::open(&path, &request))?;
        Ok(Self {
            outlets,
            pool,
            job,
            path,
            warnings: warnings.clone(),
            scene: None,
            took: start.elapsed(),
        })
    }

    /// Loads the scene, and keeps it.
    ///
    /// # Errors
    /// The scene or its files are wrong, or too large.
    pub fn load(&mut self) -> Result<(), Error> {
        let start = Instant::now();
        self.scene = Some(self.pool.install(|| self.job.load())?);
        self.took += start.elapsed();
        Ok(())
    }
}
