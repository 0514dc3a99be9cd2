//! The closing summary.

use std::time::Duration;

use batch_render::batch::{Job, Summary};

use super::memory;

/// The figures of a job that has come to its end, a line for each kind.
pub fn lines(summary: &Summary, job: &Job) -> String {
    let (replaced, is_denoised) = (job.placeholders(), job.plan.denoises().is_some());
    let mut lines = Vec::new();
    let skipped = match summary.skipped {
        0 => String::new(),
        n => format!(", {n} skipped"),
    };
    let denoised = if is_denoised {
        format!(", {} denoised", summary.written)
    } else {
        String::new()
    };
    lines.push(format!(
        "{} rendered{denoised}{skipped} in {}",
        plural(summary.rendered, "frame"),
        seconds(summary.wall)
    ));
    if let Some((median, worst)) = summary.median_and_worst() {
        lines.push(format!(
            "time per frame: median {}, worst {}",
            seconds(median),
            seconds(worst)
        ));
    }
    let rendering: f64 = summary.frame_times.iter().map(Duration::as_secs_f64).sum();
    if rendering > 0.0 {
        lines.push(format!(
            "rays: {} ({}/s), samples: {} ({}/s)",
            count(summary.rays as f64),
            count(summary.rays as f64 / rendering),
            count(summary.samples as f64),
            count(summary.samples as f64 / rendering),
        ));
    }
    let scene = &summary.scene;
    let instances = match scene.instances {
        0 => String::new(),
        n => format!(
            " and {}, {} primitives to the eye",
            plural(n, "instance"),
            count(scene.instanced_primitives as f64)
        ),
    };
    let tree = match scene.build_time {
        Some(time) => format!("tree built in {}", seconds(time)),
        None => "no tree needed".to_owned(),
    };
    lines.push(format!(
        "scene: {}, {}{instances}, {tree}",
        plural(scene.triangles, "triangle"),
        plural(scene.shapes, "other shape"),
    ));
    if let Some(peak) = memory::peak() {
        lines.push(format!("peak memory: {} MiB", peak.div_ceil(1 << 20)));
    }
    if replaced > 0 {
        lines.push(format!("placeholders shown: {}", plural(replaced, "image")));
    }
    if summary.clamped > 0 {
        lines.push(format!(
            "clamped: {} beyond what a half float holds",
            plural(summary.clamped as usize, "value")
        ));
    }
    lines.join("\n")
}

/// A line for each of the first frames that left samples out, with the pixels that they are of: those that left out none have none.
pub fn invalid(summary: &Summary) -> Vec<String> {
    const FRAMES: usize = 10;
    let mut lines: Vec<String> = summary
        .invalid
        .iter()
        .take(FRAMES)
        .map(|(frame, invalid)| {
            let samples = plural(invalid.count as usize, "sample");
            let pixels: Vec<String> = invalid.pixels().map(|[x, y]| format!("({x}, {y})")).collect();
            format!(
                "frame {frame}: {samples} left out (not a number, or infinite); the first pixels, column and row: {}",
                pixels.join(", ")
            )
        })
        .collect();
    if let Some(rest) = summary.invalid.get(FRAMES..).filter(|rest| !rest.is_empty()) {
        let count: u64 = rest.iter().map(|(_, invalid)| invalid.count).sum();
        let frames = plural(rest.len(), "more frame");
        lines.push(format!("{frames}: {} left out", plural(count as usize, "sample")));
    }
    lines
}

pub fn plural(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// A duration in the unit in which it reads well.
pub fn seconds(d: Duration) -> String {
    let s = d.as_secs_f64();
    if s < 1.0 {
        format!("{:.1} ms", s * 1e3)
    } else if s < 120.0 {
        format!("{s:.2} s")
    } else {
        let minutes = d.as_secs() / 60;
        format!("{}:{:02}:{:02} h", minutes / 60, minutes % 60, d.as_secs() % 60)
    }
}

/// A large number with its magnitude: 1.23 M.
pub fn count(n: f64) -> String {
    for (scale, suffix) in [(1e9, " G"), (1e6, " M"), (1e3, " k")] {
        if n >= scale {
            return format!("{:.2}{suffix}", n / scale);
        }
    }
    format!("{n:.0}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_read_well_at_any_size() {
        assert_eq!(seconds(Duration::from_micros(1500)), "1.5 ms");
        assert_eq!(seconds(Duration::from_millis(2500)), "2.50 s");
        assert_eq!(seconds(Duration::from_secs(3725)), "1:02:05 h");
        assert_eq!(count(1_234_567.0), "1.23 M");
        assert_eq!(count(12.0), "12");
        assert_eq!(plural(1, "frame"), "1 frame");
    }
}
