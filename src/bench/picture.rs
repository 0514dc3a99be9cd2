//! The time that a whole picture takes, stage by stage.

use std::{
    num::NonZeroUsize,
    time::{Duration, Instant},
};

use cpu_time::ProcessTime;
use serde::Serialize;

use super::report::{table, threads};
use crate::{
    film::Film,
    integrator::{Stage, StageTimes},
    math::sorting,
    output::EncodeError,
    render::{Control, Counters, Settings},
    simd::Isa,
};

/// The processor time of one stage, summed over the threads.
#[derive(Clone, Debug, Serialize)]
pub struct StageRow {
    pub stage: String,
    pub ms: f64,
    pub ns_per_segment: f64,
    /// The part of the sum of all stages, from 0 to 1.
    pub share: f64,
}

/// The times of the first frame of a job, of the repetition with the median of the wall's time.
#[derive(Clone, Debug, Serialize)]
pub struct PictureReport {
    pub scene: String,
    pub resolution: [u32; 2],
    /// Samples per pixel.
    pub samples: u32,
    pub threads: usize,
    pub simd: String,
    /// From the first camera ray to the last pixel, without loading, building and writing; with the changes of a scene that moves.
    pub wall_ms: f64,
    pub msamples_per_s: f64,
    /// Segments of paths, without shadow rays.
    pub segments: u64,
    pub stages: Vec<StageRow>,
}

/// A picture that can be rendered and encoded again and again.
pub trait Subject {
    type Error: From<EncodeError>;

    /// Renders it on the threads of the current rayon pool.
    ///
    /// # Errors
    /// There is no such picture.
    fn render(&mut self, control: &Control<'_>) -> Result<Film, Self::Error>;

    /// Makes the bytes of its files and drops them.
    ///
    /// # Errors
    /// A format cannot hold it.
    fn encode(&self, film: &Film) -> Result<(), EncodeError>;
}

/// Renders a picture `repetitions` times; the median counts. `scene` is its scene's name, `simd` the level of its loops.
///
/// # Errors
/// It cannot be rendered or encoded.
pub fn measure<S: Subject>(
    scene: &str,
    simd: Isa,
    settings: &Settings,
    subject: &mut S,
    repetitions: NonZeroUsize,
) -> Result<PictureReport, S::Error> {
    let once = |_| measure_once(scene, simd, settings, subject);
    let mut reports: Vec<PictureReport> = (0..repetitions.get()).map(once).collect::<Result<_, _>>()?;
    sorting::sort_by(&mut reports, |a, b| a.wall_ms.total_cmp(&b.wall_ms));
    Ok(reports.swap_remove(reports.len() / 2))
}

fn measure_once<S: Subject>(
    scene: &str,
    simd: Isa,
    settings: &Settings,
    subject: &mut S,
) -> Result<PictureReport, S::Error> {
    let (times, counters) = (StageTimes::default(), Counters::default());
    let control = Control {
        stages: Some(&times),
        counters: Some(&counters),
        ..Control::default()
    };
    let start = Instant::now();
    let film = subject.render(&control)?;
    let wall = start.elapsed();
    let start = ProcessTime::now();
    subject.encode(&film)?;
    let output = start.elapsed();
    let segments = times.segments();
    let mut spent: Vec<(&str, Duration)> = Stage::TABLE.map(|(stage, name)| (name, times.of(stage))).to_vec();
    spent.push(("output", output));
    let total = spent
        .iter()
        .map(|(_, time)| time.as_secs_f64())
        .sum::<f64>()
        .max(f64::MIN_POSITIVE);
    let stages = spent.into_iter().map(|(stage, time)| StageRow {
        stage: stage.to_owned(),
        ms: time.as_secs_f64() * 1e3,
        ns_per_segment: time.as_secs_f64() * 1e9 / segments.max(1) as f64,
        share: time.as_secs_f64() / total,
    });
    Ok(PictureReport {
        scene: scene.to_owned(),
        resolution: settings.resolution,
        samples: settings.samples.max,
        threads: rayon::current_num_threads(),
        simd: simd.to_string(),
        wall_ms: wall.as_secs_f64() * 1e3,
        msamples_per_s: counters.samples() as f64 / wall.as_secs_f64() / 1e6,
        segments,
        stages: stages.collect(),
    })
}

impl PictureReport {
    /// Formats the report as JSON with a final newline.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("figures are plain data");
        text.push('\n');
        text
    }

    /// Formats the report as a plain-text table.
    pub fn to_text(&self) -> String {
        let [width, height] = self.resolution;
        let mut out = format!(
            "{}: {width}x{height}, {} samples, {}, {}: {:.0} ms, {:.2} Msamples/s, {:.1} M segments\n\n",
            self.scene,
            self.samples,
            threads(self.threads),
            self.simd,
            self.wall_ms,
            self.msamples_per_s,
            self.segments as f64 / 1e6
        );
        let mut rows = vec![["stage", "CPU ms", "ns/segment", "share"].map(str::to_owned).to_vec()];
        for row in &self.stages {
            rows.push(vec![
                row.stage.clone(),
                format!("{:.1}", row.ms),
                format!("{:.1}", row.ns_per_segment),
                format!("{:.1} %", 100.0 * row.share),
            ]);
        }
        table(&mut out, &rows);
        out
    }
}
