//! A pool of waves, whose memory is reused from tile to tile and from frame to frame.

use std::sync::{Mutex, MutexGuard};

use super::wave::Wave;

/// The unused waves.
#[derive(Default)]
pub(super) struct WavePool {
    waves: Mutex<Vec<Wave>>,
}

impl WavePool {
    /// Takes a wave out, or makes a new one.
    pub fn take(&self) -> Wave {
        self.lock().pop().unwrap_or_default()
    }

    /// Puts a wave back.
    pub fn put(&self, wave: Wave) {
        self.lock().push(wave);
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Wave>> {
        self.waves.lock().expect("no thread panics while it holds the waves")
    }
}
