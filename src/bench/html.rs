//! The report as one self-contained HTML page.

use std::fmt::Write;

use plotters::prelude::*;

use super::{Cell, RayKind, Report, report::threads};

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:56rem;margin:2rem auto;padding:0 1rem;color:#222}\
table{border-collapse:collapse;margin:1rem 0}th,td{padding:.2rem .7rem;text-align:right;border-bottom:1px solid #ddd}\
th:first-child,td:first-child{text-align:left}svg{max-width:100%;height:auto}";

/// Returns a description of a kind of rays.
fn describe(kind: RayKind) -> &'static str {
    match kind {
        RayKind::Primary => "Rays from the camera through neighbouring pixels: they start together and stay close.",
        RayKind::Shadow => {
            "Rays from what the camera sees to a light. Any obstacle will do, so these ask only whether there is one."
        }
        RayKind::Diffuse1 => {
            "Rays that leave what the camera sees in random directions, as from chalk: neighbours part at once."
        }
        RayKind::Diffuse2 => "The same once more, from where those end: nothing is near anything any more.",
    }
}

/// Renders the page.
pub fn page(report: &Report) -> String {
    let mut out = String::new();
    let scene = escape(&report.scene);
    // Writing to a string cannot fail.
    let _ = write!(
        out,
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Rays per second: {scene}</title>\
         <style>{STYLE}</style></head><body>\n<h1>Rays per second: {scene}</h1>\n\
         <p>{} triangles, {} primitives in all; {}{}; the best instructions here are {}.</p>\n\
         <p>To find what a ray meets, a renderer may test every primitive (<em>linear</em>) or ask a tree of boxes first. All \
         accelerators traced the same rays in the same run, in turn, several times; a bar is the median. More is better. A \
         <em>mismatch</em> is a ray whose answer differs from the linear scan's or the binary tree's.</p>\n",
        report.triangles,
        report.primitives,
        report.instanced(),
        threads(report.threads),
        escape(&report.simd)
    );
    for kind in RayKind::ALL {
        let cells: Vec<&Cell> = report.cells.iter().filter(|c| c.rays == kind.name()).collect();
        let _ = write!(out, "<h2>{}</h2>\n<p>{}</p>\n", capital(kind.name()), describe(kind));
        let bars: Vec<_> = cells.iter().map(|c| (c.accel.as_str(), c.mrays_per_s)).collect();
        out.push_str(&chart(&bars, "million rays per second"));
        cell_table(&mut out, &cells);
    }
    out.push_str(
        "<h2>Building</h2>\n<p>Time to build each structure, and its size without the vertices. Less is better.</p>\n",
    );
    let bars: Vec<_> = report.build.iter().map(|b| (b.accel.as_str(), b.ms)).collect();
    out.push_str(&chart(&bars, "milliseconds"));
    out.push_str("<table><tr><th>structure</th><th>ms</th><th>ns a triangle</th><th>bytes a triangle</th></tr>\n");
    for b in &report.build {
        let [ns, bytes] = [figure(b.ns_per_triangle, 0), figure(b.bytes_per_triangle, 1)];
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td>{:.1}</td><td>{ns}</td><td>{bytes}</td></tr>",
            escape(&b.accel),
            b.ms
        );
    }
    out.push_str("</table>\n</body></html>\n");
    out
}

fn cell_table(out: &mut String, cells: &[&Cell]) {
    out.push_str(
        "<table><tr><th>accelerator</th><th>Mrays/s</th><th>least</th><th>most</th><th>times Embree, one ray a call</th>\
         <th>nodes a ray</th><th>primitives a ray</th><th>mismatches</th></tr>\n",
    );
    for c in cells {
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td>{:.2}</td><td>{:.2}</td><td>{:.2}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escape(&c.accel),
            c.mrays_per_s,
            c.min,
            c.max,
            figure(c.ratio_to_embree1, 2),
            figure(c.nodes_per_ray, 1),
            figure(c.primitives_per_ray, 1),
            c.mismatches
        );
    }
    out.push_str("</table>\n");
}

/// Draws a bar chart as SVG.
fn chart(bars: &[(&str, f64)], unit: &str) -> String {
    let mut svg = String::new();
    let drawn = draw(&mut svg, bars, unit);
    if drawn.is_err() {
        // The same figures are in the table below, so a chart that cannot be drawn is left out.
        svg.clear();
    }
    svg
}

fn draw(svg: &mut String, bars: &[(&str, f64)], unit: &str) -> Result<(), Box<dyn std::error::Error>> {
    let most = bars.iter().map(|b| b.1).fold(0.0, f64::max).max(1e-9);
    let area = SVGBackend::with_string(svg, (860, 300)).into_drawing_area();
    let last = bars.len().saturating_sub(1);
    let places = (0..last).into_segmented();
    let mut chart = ChartBuilder::on(&area)
        .margin(8)
        .x_label_area_size(28)
        .y_label_area_size(64)
        .build_cartesian_2d(places, 0.0..most * 1.1)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .x_labels(bars.len())
        .x_label_formatter(&|place| match place {
            SegmentValue::CenterOf(i) => bars.get(*i).map_or_else(String::new, |b| b.0.to_owned()),
            SegmentValue::Exact(_) | SegmentValue::Last => String::new(),
        })
        .y_desc(unit)
        .draw()?;
    chart.draw_series(bars.iter().enumerate().map(|(i, (name, value))| {
        let color = if name.starts_with("embree") {
            RGBColor(180, 120, 60)
        } else {
            RGBColor(50, 110, 180)
        };
        let end = if i == last {
            SegmentValue::Last
        } else {
            SegmentValue::Exact(i + 1)
        };
        let mut bar = Rectangle::new([(SegmentValue::Exact(i), 0.0), (end, *value)], color.filled());
        bar.set_margin(0, 0, 12, 12);
        bar
    }))?;
    area.present()?;
    drop(chart);
    Ok(())
}

fn figure(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"))
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
