//! Loading the next scene of a command while the present one renders.
//!
//! The scene ahead may take a quarter of the memory of a job. One that needs more is loaded in its turn. So is one that could not
//! be loaded, which is told in its turn, and one whose files may have changed since, as they do where a scene shows what an earlier
//! one has rendered. Under `ulimit -v` no scene is loaded ahead: running out of addresses would end the process.

use std::{
    sync::Arc,
    thread::{Builder, JoinHandle},
    time::SystemTime,
};

use batch_render::{
    assets::MemoryKind,
    simd::Isa,
    warnings::{WarningKind, Warnings},
};

use super::{args::RenderArgs, memory, opened::Opened};

/// The share of the memory of a job that the scene ahead may take.
const SHARE: u64 = 4;
/// The scene ahead of the present one.
#[derive(Default)]
pub struct Ahead {
    next: Option<Arc<RenderArgs>>,
    loading: Option<Loading>,
}

/// A scene that is being loaded.
struct Loading {
    args: Arc<RenderArgs>,
    since: SystemTime,
    thread: JoinHandle<Option<Opened>>,
}

impl Ahead {
    /// Names the scene after the one whose turn is next.
    pub fn set_next(&mut self, args: Option<Arc<RenderArgs>>) {
        self.next = args;
    }

    /// Begins to load the next scene, if there is one.
    pub fn begin(&mut self, simd: Isa) {
        let Some(args) = self.next.take().filter(|_| !memory::has_limited_addresses()) else {
            return;
        };
        let (since, own) = (SystemTime::now(), Arc::clone(&args));
        let load = move || {
            let mut opened = Opened::new(&own, simd, &Warnings::default(), |request| {
                request.max_memory = request.max_memory.map(|bytes| bytes / SHARE);
            })
            .ok()?;
            opened.load().ok()?;
            Some(opened)
        };
        let thread = Builder::new().name("load ahead".to_owned()).spawn(load);
        self.loading = thread.ok().map(|thread| Loading { args, since, thread });
    }

    /// The scene that was loaded ahead, once that has ended, as if it were loaded now; `None` if it is to be loaded in its turn.
    pub fn take(&mut self) -> Option<Opened> {
        let Loading { args, since, thread } = self.loading.take()?;
        let opened = thread.join().ok().flatten().filter(|opened| is_as_now(opened, since))?;
        let memory = opened.job.files().memory();
        let scene = [MemoryKind::Images, MemoryKind::Models, MemoryKind::Shapes];
        let taken = memory.taken().into_iter().filter(|(kind, _)| scene.contains(kind));
        let taken = taken.map(|(_, bytes)| bytes).sum();
        memory.set_limit(args.max_memory.unwrap_or_else(|| memory::default_limit_with(taken)));
        tracing::info!(
            "{}: loaded while the scene before it was rendered",
            opened.path.display()
        );
        Some(opened)
    }
}

/// Whether a job that was opened at this time is as one that is opened now. A file that was missing may be there now.
fn is_as_now(opened: &Opened, since: SystemTime) -> bool {
    let lacks = |kind| kind == WarningKind::MISSING_FILE || kind == WarningKind::MISSING_MATERIAL;
    let has_all = opened.job.placeholders() == 0 && !opened.warnings.list().iter().any(|warning| lacks(warning.kind));
    has_all && opened.job.files().are_unchanged_since(since)
}
