//! The report of a job as one self-contained HTML page (`--report`).

use std::{
    collections::{BTreeMap, HashMap},
    fmt::{Display, Write},
};

use base64::{Engine as _, engine::general_purpose::STANDARD};
use batch_render::{math::sorting, output::FrameImage};
use image::codecs::png::PngEncoder;

use super::{
    figures::{Album, Frame, Report, State, Status},
    replay::quoted,
    small_picture::small_picture,
    summary::{count, plural, seconds},
};

/// The width of a thumbnail, in pixels.
const THUMBNAIL: u32 = 192;

/// The most bars of a chart; where there are more frames, a bar stands for several.
const MAX_BARS: usize = 240;

pub const STYLE: &str = "\
:root{color-scheme:light dark;--text:#1d1f23;--faint:#667;--page:#fff;--line:#d8dbe2;--bar:#3a6fd8;--bad:#b3261e;--card:#f4f5f8}\
@media(prefers-color-scheme:dark){:root{--text:#e6e7ea;--faint:#9aa0ad;--page:#16181c;--line:#343842;--bar:#7ea6ff;--bad:#ff8a80;--card:#1f2228}}\
body{font:15px/1.5 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1.5rem;color:var(--text);background:var(--page)}\
h1{font-size:1.5rem;margin:0}h2{font-size:1.1rem;margin:2rem 0 .5rem}p,dl{margin:.3rem 0}.faint{color:var(--faint)}.bad{color:var(--bad)}\
code{font:13px ui-monospace,monospace;background:var(--card);padding:.5rem .7rem;border-radius:4px;display:block;overflow-x:auto}\
progress{width:100%;height:.8rem;accent-color:var(--bar)}table{border-collapse:collapse}\
td,th{padding:.15rem 1rem .15rem 0;text-align:right;border-bottom:1px solid var(--line)}td:first-child,th:first-child{text-align:left}\
svg{width:100%;height:9rem;background:var(--card);border-radius:4px}svg rect{fill:var(--bar)}\
.sheet{display:grid;grid-template-columns:repeat(auto-fill,minmax(12rem,1fr));gap:.8rem}\
figure{margin:0;background:var(--card);border-radius:4px;overflow:hidden}img{display:block;width:100%;height:auto}\
figcaption{padding:.25rem .5rem;font-size:13px;display:flex;justify-content:space-between}";

/// A small picture of a frame, as the address of an image.
pub fn thumbnail(image: &FrameImage<'_>) -> Option<String> {
    let small = small_picture(image, THUMBNAIL);
    let mut file = Vec::new();
    small.write_with_encoder(PngEncoder::new(&mut file)).ok()?;
    Some(format!("data:image/png;base64,{}", STANDARD.encode(file)))
}

/// The page. It is whole at any moment while frames finish.
pub fn page(album: &Album) -> String {
    let Album {
        figures: report,
        thumbnails,
    } = album;
    let mut out = String::new();
    let done = |status| report.frames.iter().filter(|f| f.status == status).count();
    let [written, skipped, failed] = [Status::Written, Status::Skipped, Status::Failed].map(done);
    let command: Vec<String> = report.command.iter().map(quoted).collect();
    let [width, height] = report.resolution;
    let state = match (report.state, remaining(report)) {
        (State::Running, Some(left)) => format!("running, about {left} left"),
        (state, _) => state.name().to_owned(),
    };
    let state = match &report.part {
        Some(part) if !report.is_finished => format!("part {part} {state}"),
        _ => state,
    };
    let refresh = refresh(report.state);
    let scene = match &report.eye {
        Some(eye) => format!("{}, {eye} eye", report.scene),
        None => report.scene.clone(),
    };
    let samples = match report.min_samples {
        Some(min) => format!("{min} to {}", report.samples),
        None => report.samples.to_string(),
    };
    // Writing to a string cannot fail.
    let _ = write!(
        out,
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\">{refresh}<title>{scene}: {state}</title><style>{STYLE}</style></head><body>\n\
         <h1>{scene}</h1>\n<p>{state}: {written} frames written, {skipped} skipped, {failed} failed, of {total}; {wall}</p>\n\
         <progress max=\"{total}\" value=\"{}\"></progress>\n\
         <p class=\"faint\">{width} x {height}, {} samples per pixel, {}, batch-render {}</p>\n\
         <code>{}</code>\n",
        written + skipped + failed,
        samples,
        plural(report.threads, "thread"),
        report.version,
        escape(&command.join(" ")),
        scene = escape(&scene),
        total = report.total,
        wall = seconds(std::time::Duration::from_secs_f64(report.wall_s)),
    );
    let rendered: Vec<&Frame> = report.frames.iter().filter(|f| f.wall_s > 0.0).collect();
    if !rendered.is_empty() {
        let time = |f: &Frame| f.wall_s;
        let rays = |f: &Frame| (f.segments + f.shadow_rays) as f64;
        chart(&mut out, "Time per frame", &rendered, time, |s| {
            seconds(std::time::Duration::from_secs_f64(s))
        });
        chart(&mut out, "Rays per frame", &rendered, rays, count);
        slowest(&mut out, &rendered);
    }
    warnings(&mut out, report);
    sheet(&mut out, report, thumbnails);
    out.push_str("</body></html>\n");
    out
}

/// The HTML element that reloads the page every few seconds while the job runs.
pub fn refresh(state: State) -> &'static str {
    match state {
        State::Running => "<meta http-equiv=\"refresh\" content=\"5\">",
        _ => "",
    }
}

/// The time that the remaining frames will take, if they are like those so far.
fn remaining(report: &Report) -> Option<String> {
    let times = report.frames.iter().map(|f| f.wall_s).filter(|s| *s > 0.0);
    let (sum, n) = times.fold((0.0, 0), |(sum, n), s| (sum + s, n + 1));
    let left = report
        .total
        .saturating_sub(report.frames.iter().filter(|f| f.status != Status::Rendering).count());
    (n > 0).then(|| seconds(std::time::Duration::from_secs_f64(sum / f64::from(n) * left as f64)))
}

/// Bars of a figure over the frames, with the largest beside them.
fn chart(
    out: &mut String,
    title: &str,
    frames: &[&Frame],
    figure: impl Fn(&Frame) -> f64,
    text: impl Fn(f64) -> String,
) {
    let together = frames.len().div_ceil(MAX_BARS);
    let bars: Vec<(i32, f64)> = frames
        .chunks(together)
        .map(|group| (group[0].frame, group.iter().map(|f| figure(f)).fold(0.0, f64::max)))
        .collect();
    let most = bars.iter().map(|bar| bar.1).fold(f64::MIN_POSITIVE, f64::max);
    let (first, last) = (frames[0].frame, frames[frames.len() - 1].frame);
    let _ = write!(
        out,
        "<h2>{title}</h2>\n<p class=\"faint\">frames {first} to {last}; the most is {}</p>\n\
         <svg viewBox=\"0 0 {} 100\" preserveAspectRatio=\"none\" role=\"img\" aria-label=\"{title}\">",
        escape(&text(most)),
        bars.len() * 10,
    );
    for (i, (frame, value)) in bars.iter().enumerate() {
        let high = 96.0 * value / most;
        let _ = write!(
            out,
            "<rect x=\"{}\" y=\"{:.2}\" width=\"8\" height=\"{high:.2}\"><title>frame {frame}: {}</title></rect>",
            i * 10 + 1,
            100.0 - high,
            escape(&text(*value)),
        );
    }
    out.push_str("</svg>\n");
}

fn slowest(out: &mut String, frames: &[&Frame]) {
    const SHOWN: usize = 5;
    let mut sorted = frames.to_vec();
    sorting::sort_by(&mut sorted, |a, b| b.wall_s.total_cmp(&a.wall_s));
    out.push_str(
        "<h2>Slowest frames</h2>\n<table><tr><th>frame</th><th>time</th><th>rays</th><th>peak memory</th></tr>\n",
    );
    for frame in sorted.into_iter().take(SHOWN) {
        let memory = frame
            .peak_memory_bytes
            .map_or_else(|| "-".to_owned(), |bytes| format!("{} MiB", bytes >> 20));
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{memory}</td></tr>",
            frame.frame,
            seconds(std::time::Duration::from_secs_f64(frame.wall_s)),
            count((frame.segments + frame.shadow_rays) as f64),
        );
    }
    out.push_str("</table>\n");
}

fn warnings(out: &mut String, report: &Report) {
    const SHOWN: usize = 50;
    let told: Vec<(&Frame, &String)> = report
        .frames
        .iter()
        .filter_map(|f| Some((f, f.reason.as_ref()?)))
        .collect();
    if told.is_empty() {
        return;
    }
    out.push_str("<h2>What happened</h2>\n");
    for (frame, reason) in told.iter().take(SHOWN) {
        let (class, word) = match frame.status {
            Status::Failed => (" class=\"bad\"", "failed"),
            _ => ("", "rendered again"),
        };
        let _ = writeln!(out, "<p{class}>frame {} {word}: {}</p>", frame.frame, escape(reason));
    }
    if told.len() > SHOWN {
        let _ = writeln!(out, "<p class=\"faint\">and {} more</p>", told.len() - SHOWN);
    }
}

/// The contact sheet.
fn sheet(out: &mut String, report: &Report, thumbnails: &BTreeMap<i32, String>) {
    if thumbnails.is_empty() {
        return;
    }
    out.push_str("<h2>Frames</h2>\n<div class=\"sheet\">\n");
    let by_number: HashMap<i32, &Frame> = report.frames.iter().map(|f| (f.frame, f)).collect();
    for (number, address) in thumbnails {
        let time = by_number.get(number).map_or(0.0, |f| f.wall_s);
        let _ = writeln!(
            out,
            "<figure><img src=\"{address}\" alt=\"frame {number}\"><figcaption><span>{number}</span><span \
             class=\"faint\">{}</span></figcaption></figure>",
            seconds(std::time::Duration::from_secs_f64(time)),
        );
    }
    out.push_str("</div>\n");
}

/// Text without the marks of HTML.
pub fn escape(text: &impl Display) -> String {
    let text = batch_render::value::visible(&text.to_string()).to_string();
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_out_of_files_are_text_and_nothing_else() {
        assert_eq!(escape(&"<script>&\"\u{1b}[31m"), "&lt;script&gt;&amp;&quot;\\u{1b}[31m");
    }
}
