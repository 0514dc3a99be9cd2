//! Progress, on stdout: bars on a terminal, plain lines elsewhere.

use std::{
    io::{IsTerminal, Write},
    path::Path,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use batch_render::{batch::Observer, render::Counters};
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::{
    args::ProgressKind,
    summary::{count, seconds},
};

/// The time between two updates of the bars.
const TICK: Duration = Duration::from_millis(100);

/// Shows what a job does.
pub enum Progress {
    Bars(Bars),
    Lines(Lines),
    Silent,
}

impl Progress {
    /// `frames` frames of `samples` samples each.
    pub fn new(kind: ProgressKind, frames: usize, samples: u64, counters: &Arc<Counters>) -> Self {
        let kind = match kind {
            ProgressKind::Auto if std::io::stdout().is_terminal() => ProgressKind::Bar,
            ProgressKind::Auto => ProgressKind::Plain,
            said => said,
        };
        match kind {
            ProgressKind::Bar => Self::Bars(Bars::new(frames, samples, Arc::clone(counters))),
            ProgressKind::Plain => Self::Lines(Lines::default()),
            _ => Self::Silent,
        }
    }

    /// Ends the bars and shows `closing` below them.
    pub fn finish(self, closing: Option<&str>) {
        let silent = matches!(self, Self::Silent);
        if let Self::Bars(bars) = self {
            bars.stop();
        }
        if let Some(text) = closing.filter(|_| !silent) {
            say(text);
        }
    }
}

/// A line on stdout. A reader that has gone is no reason to stop rendering.
pub fn say(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

impl Observer for Progress {
    fn frame_started(&self, number: i32, index: usize, total: usize) {
        match self {
            Self::Bars(bars) => bars.frame_started(number),
            Self::Lines(lines) => *lock(&lines.position) = (index + 1, total),
            Self::Silent => {}
        }
    }

    fn frame_rendered(&self, number: i32, took: Duration) {
        match self {
            Self::Bars(bars) => bars.frame_done(),
            Self::Lines(lines) => {
                let (position, total) = *lock(&lines.position);
                say(&format!(
                    "frame {number} ({position} of {total}) rendered in {}",
                    seconds(took)
                ));
            }
            Self::Silent => {}
        }
    }

    fn frame_skipped(&self, number: i32) {
        match self {
            Self::Bars(bars) => bars.frame_skipped(number),
            Self::Lines(_) => say(&format!("frame {number} skipped, its files are whole")),
            Self::Silent => {}
        }
    }

    fn file_written(&self, _number: i32, path: &Path) {
        match self {
            Self::Bars(bars) => bars.written(path),
            Self::Lines(_) => say(&format!("wrote {}", path.display())),
            Self::Silent => {}
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().expect("no thread panics while it holds the progress")
}

/// Plain lines.
#[derive(Default)]
pub struct Lines {
    /// The position of the frame that renders, and the number of frames.
    position: Mutex<(usize, usize)>,
}

/// A bar for the sequence and one for the frame.
pub struct Bars {
    sequence: ProgressBar,
    frame: ProgressBar,
    /// Samples that were finished when the frame started.
    samples_before: Arc<AtomicU64>,
    stop: Arc<AtomicBool>,
    ticker: JoinHandle<()>,
}

impl Bars {
    fn new(frames: usize, samples: u64, counters: Arc<Counters>) -> Self {
        let bars = MultiProgress::with_draw_target(ProgressDrawTarget::stdout());
        let style = |template: &str| {
            ProgressStyle::with_template(template)
                .expect("the template is a constant")
                .progress_chars("=> ")
        };
        let sequence = bars.add(ProgressBar::new(frames as u64));
        sequence.set_style(style(
            "frames [{bar:30}] {pos}/{len}  {elapsed} elapsed, {eta} left  {wide_msg}",
        ));
        let frame = bars.add(ProgressBar::new(samples));
        frame.set_style(style("{prefix:>6} [{bar:30}] {percent:>3} %  {wide_msg}"));
        let samples_before = Arc::new(AtomicU64::new(0));
        let stop = Arc::new(AtomicBool::new(false));
        let ticker = {
            let (sequence, frame) = (sequence.clone(), frame.clone());
            let (before, stop) = (Arc::clone(&samples_before), Arc::clone(&stop));
            thread::spawn(move || {
                let mut last = (Instant::now(), 0);
                while !stop.load(Ordering::Relaxed) {
                    thread::park_timeout(TICK);
                    let rays = counters.rays();
                    let now = Instant::now();
                    let rate = (rays - last.1) as f64 / (now - last.0).as_secs_f64();
                    last = (now, rays);
                    frame.set_position(counters.samples() - before.load(Ordering::Relaxed));
                    frame.set_message(format!("{} rays/s", count(rate)));
                    sequence.tick();
                }
            })
        };
        Self {
            sequence,
            frame,
            samples_before,
            stop,
            ticker,
        }
    }

    fn frame_started(&self, number: i32) {
        self.frame.set_prefix(number.to_string());
    }

    fn frame_done(&self) {
        self.samples_before
            .fetch_add(self.frame.length().unwrap_or(0), Ordering::Relaxed);
        self.sequence.inc(1);
    }

    fn frame_skipped(&self, number: i32) {
        self.sequence.set_message(format!("skipped {number}"));
        self.sequence.inc(1);
    }

    fn written(&self, path: &Path) {
        self.sequence.set_message(path.display().to_string());
    }

    fn stop(self) {
        self.stop.store(true, Ordering::Relaxed);
        self.ticker.thread().unpark();
        // A bar that panicked has nothing left to draw.
        let _ = self.ticker.join();
        self.frame.finish_and_clear();
        self.sequence.finish();
    }
}
