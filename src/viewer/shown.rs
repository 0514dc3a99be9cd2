//! The scene that pages see.

use std::sync::{Arc, Mutex, MutexGuard};

use crate::scene::Scene;

/// The scene that pages see; none while it changes.
pub struct Shown(Mutex<Option<Arc<Scene>>>);

impl Shown {
    pub fn new(scene: Arc<Scene>) -> Self {
        Self(Mutex::new(Some(scene)))
    }

    /// Returns what `look` finds in the scene; `None` while the scene changes.
    pub fn look<T>(&self, look: impl FnOnce(&Scene) -> T) -> Option<T> {
        self.lock().as_deref().map(look)
    }

    /// Takes the scene away, to change it.
    pub fn take(&self) -> Option<Arc<Scene>> {
        self.lock().take()
    }

    pub fn set(&self, scene: Arc<Scene>) {
        *self.lock() = Some(scene);
    }

    fn lock(&self) -> MutexGuard<'_, Option<Arc<Scene>>> {
        self.0.lock().expect("no thread panics while it looks at the scene")
    }
}
