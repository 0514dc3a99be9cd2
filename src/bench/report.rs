//! The results of a benchmark, as data, as JSON and as tables.

use std::fmt::Write;

use serde::Serialize;

/// The speed of one accelerator on one kind of rays.
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    pub accel: String,
    pub rays: String,
    /// Median of the repetitions, in millions of rays per second, for all threads together.
    pub mrays_per_s: f64,
    pub min: f64,
    pub max: f64,
    /// The speed relative to Embree's single-ray calls on the same rays.
    pub ratio_to_embree1: Option<f64>,
    /// Boxes tested per nearest hit; all boxes of a wide node count as one.
    pub nodes_per_ray: Option<f64>,
    /// Primitives tested per nearest hit.
    pub primitives_per_ray: Option<f64>,
    /// Rays whose result differs by more than a tie or a relative difference of 1e-5 in distance
    /// explains.
    pub mismatches: u64,
}

/// The build time of one accelerator.
#[derive(Clone, Debug, Serialize)]
pub struct BuildRow {
    pub accel: String,
    /// Median of the repetitions.
    pub ms: f64,
    /// `None` in a scene without triangles.
    pub ns_per_triangle: Option<f64>,
    /// Memory of the structure without the vertices; `None` if it is unknown, or in a scene without triangles.
    pub bytes_per_triangle: Option<f64>,
}

/// All results of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    pub scene: String,
    pub triangles: usize,
    /// Triangles and all other shapes.
    pub primitives: usize,
    pub instances: usize,
    /// Primitives that rays can hit: those of instanced meshes count once per instance.
    pub seen: u64,
    pub threads: usize,
    /// The best SIMD level of this processor.
    pub simd: String,
    pub cells: Vec<Cell>,
    pub build: Vec<BuildRow>,
}

impl Report {
    /// Formats the report as JSON with a final newline.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("figures are plain data");
        text.push('\n');
        text
    }

    /// Returns the number of instanced primitives, with a final comma; empty if there are no
    /// instances.
    pub(super) fn instanced(&self) -> String {
        match self.instances {
            0 => String::new(),
            n => format!("{n} instances, {} primitives seen, ", self.seen),
        }
    }

    /// Formats the report as plain-text tables.
    pub fn to_text(&self) -> String {
        let mut out = format!(
            "{}: {} triangles, {} primitives, {}{}, {}\n\n",
            self.scene,
            self.triangles,
            self.primitives,
            self.instanced(),
            threads(self.threads),
            self.simd
        );
        let header = [
            "rays",
            "accelerator",
            "Mrays/s",
            "min",
            "max",
            "x Embree",
            "nodes/ray",
            "prims/ray",
            "mismatches",
        ];
        let mut rows = vec![header.map(str::to_owned).to_vec()];
        for c in &self.cells {
            rows.push(vec![
                c.rays.clone(),
                c.accel.clone(),
                format!("{:.2}", c.mrays_per_s),
                format!("{:.2}", c.min),
                format!("{:.2}", c.max),
                figure(c.ratio_to_embree1, 2),
                figure(c.nodes_per_ray, 1),
                figure(c.primitives_per_ray, 1),
                c.mismatches.to_string(),
            ]);
        }
        table(&mut out, &rows);
        out.push('\n');
        let mut rows = vec![
            ["build", "ms", "ns/triangle", "bytes/triangle"]
                .map(str::to_owned)
                .to_vec(),
        ];
        for b in &self.build {
            rows.push(vec![
                b.accel.clone(),
                format!("{:.1}", b.ms),
                figure(b.ns_per_triangle, 0),
                figure(b.bytes_per_triangle, 1),
            ]);
        }
        table(&mut out, &rows);
        out
    }
}

fn figure(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
}

/// A number of threads, as `1 thread` and `2 threads`.
pub(super) fn threads(n: usize) -> String {
    format!("{n} thread{}", if n == 1 { "" } else { "s" })
}

/// Appends a table whose first two columns are left-aligned and whose numbers are right-aligned.
pub(super) fn table(out: &mut String, rows: &[Vec<String>]) {
    let columns = rows.first().map_or(0, Vec::len);
    let widths: Vec<usize> = (0..columns)
        .map(|c| rows.iter().map(|r| r[c].chars().count()).max().unwrap_or(0))
        .collect();
    let text_columns = if columns > 4 { 2 } else { 1 };
    for row in rows {
        let cells: Vec<String> = row
            .iter()
            .zip(&widths)
            .enumerate()
            .map(|(c, (text, &w))| {
                if c < text_columns {
                    format!("{text:<w$}")
                } else {
                    format!("{text:>w$}")
                }
            })
            .collect();
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{}", cells.join("  ").trim_end());
    }
}
