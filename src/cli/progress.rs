//! Progress, on stdout, or on stderr where frames are on stdout: bars on a terminal, plain lines elsewhere.

use std::{
    io::{IsTerminal, Write},
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use batch_render::{
    batch::{JobEvent, Observer},
    render::Counters,
    value::visible,
};
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::{
    choices::ProgressKind,
    figures::State,
    log,
    replay::Replay,
    summary::{count, seconds},
};

/// The time between two updates of the bars.
const TICK: Duration = Duration::from_millis(100);

/// The longest time without a line while a frame renders, where there are no bars.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Shows what a job does.
pub struct Progress<'a> {
    work: Arc<Work>,
    display: Display,
    /// The command of the job, which messages about failed frames repeat.
    typed: &'a Replay,
}

/// The work of a job, and how much of it is done.
struct Work {
    frames: usize,
    /// The most samples of each frame.
    samples: u64,
    counters: Arc<Counters>,
    /// Frames whose files are all on disk, those that were skipped too.
    on_disk: AtomicUsize,
    now: Mutex<Now>,
}

/// The frame that renders.
#[derive(Clone, Copy)]
struct Now {
    /// `None` before the first frame and between two.
    number: Option<i32>,
    /// From 1.
    position: usize,
    /// Samples that were settled when the frame started.
    samples_before: u64,
    started: Instant,
    /// The time of the last line about the job.
    last_line: Instant,
}

enum Display {
    Bars(Bars),
    Lines(Ticker),
    Silent,
}

impl<'a> Progress<'a> {
    /// `frames` frames of at most `samples` samples each, of a job with this command.
    pub fn new(
        kind: ProgressKind,
        (frames, samples): (usize, u64),
        counters: &Arc<Counters>,
        typed: &'a Replay,
    ) -> Self {
        let kind = match kind {
            ProgressKind::Auto if is_terminal() => ProgressKind::Bar,
            ProgressKind::Auto => ProgressKind::Plain,
            said => said,
        };
        let work = Arc::new(Work {
            frames,
            samples,
            counters: Arc::clone(counters),
            on_disk: AtomicUsize::new(0),
            now: Mutex::new(Now {
                number: None,
                position: 0,
                samples_before: 0,
                started: Instant::now(),
                last_line: Instant::now(),
            }),
        });
        let display = match kind {
            ProgressKind::Bar => Display::Bars(Bars::new(&work)),
            ProgressKind::Plain => {
                let work = Arc::clone(&work);
                Display::Lines(Ticker::start(move |_| work.say_where_the_frame_is()))
            }
            _ => Display::Silent,
        };
        Self { work, display, typed }
    }

    /// Ends the display of a job, and shows nothing.
    pub fn stop(self) {
        self.display.stop();
    }

    /// Ends the display of a job and shows `closing` below it. The last line of a job that was not done says how much of it is
    /// on disk.
    pub fn finish(self, state: State, closing: Option<&str>) {
        let is_shown = !matches!(self.display, Display::Silent);
        let on_disk = self.work.on_disk.load(Ordering::SeqCst);
        self.display.stop();
        if !is_shown {
            return;
        }
        closing.into_iter().for_each(say);
        if state != State::Finished {
            let state = state.name();
            say(&format!(
                "{state}: {on_disk} of {} frames are on disk",
                self.work.frames
            ));
        }
    }
}

/// Whether stdout belongs to the frames of the job.
static STDOUT_IS_TAKEN: AtomicBool = AtomicBool::new(false);

/// From now on lines and bars are on stderr.
pub fn leave_stdout() {
    STDOUT_IS_TAKEN.store(true, Ordering::Relaxed);
}

fn is_stdout_taken() -> bool {
    STDOUT_IS_TAKEN.load(Ordering::Relaxed)
}

/// A line on stdout. A reader that has gone is no reason to stop rendering.
pub fn say(text: &str) {
    let text = visible(text);
    let _ = match is_stdout_taken() {
        true => writeln!(std::io::stderr(), "{text}"),
        false => writeln!(std::io::stdout(), "{text}"),
    };
}

fn is_terminal() -> bool {
    match is_stdout_taken() {
        true => std::io::stderr().is_terminal(),
        false => std::io::stdout().is_terminal(),
    }
}

fn target() -> ProgressDrawTarget {
    match is_stdout_taken() {
        true => ProgressDrawTarget::stderr(),
        false => ProgressDrawTarget::stdout(),
    }
}

impl Work {
    /// The part of the current frame's samples that is done, from 0 to 1.
    fn fraction(&self, now: &Now) -> f64 {
        let done = self.counters.settled().saturating_sub(now.samples_before);
        (done as f64 / self.samples.max(1) as f64).min(1.0)
    }

    fn say_where_the_frame_is(&self) {
        let mut now = lock(&self.now);
        if let Some(number) = now.number
            && now.last_line.elapsed() >= LINE_EVERY - Ticker::PERIOD
        {
            now.last_line = Instant::now();
            say(&format!(
                "frame {number} ({} of {}) {:.0} % after {}",
                now.position,
                self.frames,
                100.0 * self.fraction(&now),
                seconds(now.started.elapsed())
            ));
        }
    }

    fn say(&self, text: &str) {
        lock(&self.now).last_line = Instant::now();
        say(text);
    }
}

impl Progress<'_> {
    fn started(&self, number: i32, index: usize) {
        let mut now = lock(&self.work.now);
        *now = Now {
            number: Some(number),
            position: index + 1,
            samples_before: self.work.counters.settled(),
            started: Instant::now(),
            last_line: now.last_line,
        };
    }

    fn rendered(&self, number: i32, took: Duration) {
        let now = {
            let mut now = lock(&self.work.now);
            now.number = None;
            *now
        };
        if let Display::Lines(_) = self.display {
            self.work.say(&format!(
                "frame {number} ({} of {}) rendered in {}",
                now.position,
                self.work.frames,
                seconds(took)
            ));
        }
    }

    /// Shows a short text beside the bars, or a line.
    fn show(&self, beside_bars: impl FnOnce() -> String, line: impl FnOnce() -> String) {
        match &self.display {
            Display::Bars(bars) => bars.sequence.set_message(beside_bars()),
            Display::Lines(_) => self.work.say(&line()),
            Display::Silent => {}
        }
    }
}

impl Observer for Progress<'_> {
    fn event(&self, event: &JobEvent<'_>) {
        match event {
            JobEvent::FrameStarted { frame, index, .. } => self.started(*frame, *index),
            JobEvent::FrameRendered { frame, took } => self.rendered(*frame, *took),
            JobEvent::FrameSkipped { frame } => {
                self.work.on_disk.fetch_add(1, Ordering::SeqCst);
                self.show(
                    || format!("skipped {frame}"),
                    || format!("frame {frame} skipped, its files are there"),
                );
            }
            JobEvent::FrameFailed(failure) => log::failure(failure, self.typed),
            JobEvent::FrameStale { frame, stale } => {
                if !matches!(self.display, Display::Silent) {
                    self.work.say(&format!("frame {frame} is rendered again: {stale}"));
                }
            }
            JobEvent::FileWritten { file, .. } => {
                self.show(|| file.display().to_string(), || format!("wrote {}", file.display()));
            }
            JobEvent::FrameDenoised { file, .. } => {
                self.show(
                    || file.display().to_string(),
                    || format!("{}: denoised", file.display()),
                );
            }
            JobEvent::FrameWritten { .. } => {
                self.work.on_disk.fetch_add(1, Ordering::SeqCst);
            }
            JobEvent::FrameCutShort { .. } | JobEvent::FrameImage { .. } | JobEvent::DenoisedFingerprint { .. } => {}
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().expect("no thread panics while it holds the progress")
}

impl Display {
    fn stop(self) {
        match self {
            Self::Bars(bars) => bars.stop(),
            Self::Lines(ticker) => ticker.stop(),
            Self::Silent => {}
        }
    }
}

/// A thread that does the same thing again and again until it is stopped.
struct Ticker {
    stop: Arc<AtomicBool>,
    /// `None` where the system allows no more threads: progress is no reason to fail.
    thread: Option<JoinHandle<()>>,
}

impl Ticker {
    const PERIOD: Duration = TICK;

    /// Calls `tick` with the time since the last call.
    fn start(mut tick: impl FnMut(Duration) + Send + 'static) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let thread = {
            let stop = Arc::clone(&stop);
            thread::Builder::new().name("progress".to_owned()).spawn(move || {
                let mut last = Instant::now();
                while !stop.load(Ordering::Relaxed) {
                    thread::park_timeout(Self::PERIOD);
                    let now = Instant::now();
                    tick(now - last);
                    last = now;
                }
            })
        };
        Self {
            stop,
            thread: thread.ok(),
        }
    }

    fn stop(self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread {
            thread.thread().unpark();
            // A display that panicked has nothing left to show.
            let _ = thread.join();
        }
    }
}

/// A bar for the frames that are on disk and one for the frame that renders.
struct Bars {
    sequence: ProgressBar,
    frame: ProgressBar,
    ticker: Ticker,
}

/// The look of a bar; `template` is a constant.
fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template)
        .expect("the template is a constant")
        .progress_chars("=> ")
}

impl Bars {
    fn new(work: &Arc<Work>) -> Self {
        let bars = MultiProgress::with_draw_target(target());
        let sequence = bars.add(ProgressBar::new(work.frames as u64));
        sequence.set_style(style(
            "frames [{bar:30}] {pos}/{len}  {elapsed} elapsed, {eta} left  {wide_msg}",
        ));
        let frame = bars.add(ProgressBar::new(work.samples));
        frame.set_style(style("{prefix:>6} [{bar:30}] {percent:>3} %  {wide_msg}"));
        let ticker = {
            let (sequence, frame, work) = (sequence.clone(), frame.clone(), Arc::clone(work));
            let mut rays_before = 0;
            Ticker::start(move |elapsed| {
                let rays = work.counters.rays();
                let rate = (rays - rays_before) as f64 / elapsed.as_secs_f64();
                rays_before = rays;
                let now = *lock(&work.now);
                if let Some(number) = now.number {
                    frame.set_prefix(number.to_string());
                    frame.set_position((work.fraction(&now) * work.samples as f64) as u64);
                }
                frame.set_message(format!("{} rays/s", count(rate)));
                sequence.set_position(work.on_disk.load(Ordering::SeqCst) as u64);
                sequence.tick();
            })
        };
        Self {
            sequence,
            frame,
            ticker,
        }
    }

    /// Leaves the bar of the frames as it stands after a last look.
    fn stop(self) {
        self.ticker.stop();
        self.frame.finish_and_clear();
        self.sequence
            .set_style(style("frames [{bar:30}] {pos}/{len}  {elapsed} elapsed"));
        self.sequence.abandon();
        // The bar leaves the cursor on its line.
        say("");
    }
}
