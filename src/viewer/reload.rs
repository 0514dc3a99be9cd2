//! The loading of a scene that changes on disk: its files are looked at, and it is loaded again when a page asks for it.

use std::time::Duration;

use rayon::ThreadPoolBuilder;

use super::{keyframes::Keyframes, session::Session};
use crate::{assets::SuppliedFile, error::Error, warnings::Warnings};

/// The time between two looks at the files of the scene.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// Watches the scene until the session stops, and loads it on `threads` threads.
pub fn run(session: &Session, threads: usize) {
    while let Some(needs_load) = session.next_load(LOOK_EVERY) {
        if !needs_load {
            session.look_at_files();
            continue;
        }
        session.scene.send_modify(|facts| facts.is_loading = true);
        if let Err(error) = load(session, threads) {
            session.scene.send_modify(|facts| {
                facts.is_loading = false;
                facts.error = error.messages().join("\n");
            });
        }
    }
}

/// Loads the scene; on an error the session keeps the one that it has.
fn load(session: &Session, threads: usize) -> Result<(), Error> {
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("scene {i}"))
        .build()
        .map_err(|e| Error::threads("the threads that load the scene", &e))?;
    // The page shows the warnings of the scene that it has.
    let base = pool.install(|| session.source.load(path(session), Warnings::default()))?;
    session.replace(base)
}

/// The camera path on disk, whose columns may have new values of the scene; where there is none, that of the page.
fn path(session: &Session) -> Option<SuppliedFile> {
    let source = &session.source;
    let on_disk = Keyframes::open(&source.options.camera_path, &source.request);
    on_disk.ok().and_then(|keys| keys.file()).or_else(|| session.path())
}
