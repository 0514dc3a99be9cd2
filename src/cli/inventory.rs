//! The inventory that `check` prints.

use std::{
    io::{self, Write},
    path::Path,
};

use batch_render::{
    batch::{
        Inventory, Job,
        inventory::{BoundsEntry, FeatureEntry, ModelEntry},
    },
    value::visible,
};

use super::{closed_pipe::is_closed_pipe, summary::plural};

/// Prints the inventory of a valid scene to standard output. A closed pipe is no error.
pub fn print(scene: &Path, job: &Job, inventory: &Inventory, json: bool) -> io::Result<()> {
    let mut out = io::stdout().lock();
    let written = if json {
        serde_json::to_string_pretty(inventory)
            .map_err(io::Error::other)
            .and_then(|text| writeln!(out, "{text}"))
    } else {
        write_lines(&mut out, scene, job, inventory)
    };
    match written.and_then(|()| out.flush()) {
        Err(error) if !is_closed_pipe(&error) => Err(error),
        _ => Ok(()),
    }
}

fn write_lines(out: &mut impl Write, scene: &Path, job: &Job, inventory: &Inventory) -> io::Result<()> {
    let frames = plural(job.plan.frames.len(), "frame");
    writeln!(out, "{}: {frames} to render, nothing wrong", scene.display())?;
    let instances = match inventory.instances {
        0 => String::new(),
        n => format!(", {}", plural(n, "instance")),
    };
    writeln!(
        out,
        "{}: {}{instances}, {}",
        plural(inventory.objects, "object"),
        plural(inventory.triangles, "triangle"),
        plural(inventory.shapes, "other shape")
    )?;
    writeln!(
        out,
        "{}, {} emit; {}; {}",
        plural(inventory.materials, "material"),
        inventory.emitting_materials,
        plural(inventory.textures, "texture"),
        plural(inventory.lights, "light")
    )?;
    let drawn = job.plan.values.as_ref().map_or(0, |values| values.drawn_at(1).count());
    if drawn > 0 {
        writeln!(out, "{} drawn for each frame", plural(drawn, "value"))?;
    }
    if let Some(BoundsEntry { min, max }) = inventory.bounds {
        // The bounds of a shape have the errors of rounding, also beside 0.
        let noise = min.iter().chain(&max).fold(0.0_f64, |most, x| most.max(x.abs())) * 1e-6;
        let shown = |x: f64| shown(if x.abs() < noise { 0.0 } else { x });
        let axis = |i: usize, name: &str| format!("{name} {} to {}", shown(min[i]), shown(max[i]));
        writeln!(out, "bounds: {}, {}, {} m", axis(0, "x"), axis(1, "y"), axis(2, "z"))?;
    }
    for image in &inventory.images {
        let (width, height, channels) = (image.width, image.height, image.channels);
        writeln!(out, "image: {width}x{height}, {}", plural(channels, "channel"))?;
    }
    for model in &inventory.models {
        write_model(out, model)?;
    }
    for entry in inventory.memory.iter().filter(|e| e.bytes > 0) {
        writeln!(out, "memory for {}: {} MiB", entry.kind, entry.bytes.div_ceil(1 << 20))?;
    }
    Ok(())
}

/// A coordinate with four digits.
fn shown(value: f64) -> String {
    format!("{value:.3e}")
        .parse()
        .map_or_else(|_| value.to_string(), |short: f64| short.to_string())
}

fn write_model(out: &mut impl Write, model: &ModelEntry) -> io::Result<()> {
    writeln!(out, "model {}", visible(&model.file))?;
    for (i, camera) in model.cameras.iter().enumerate() {
        match camera.as_str() {
            "" => writeln!(out, "  camera {i}")?,
            name => writeln!(out, "  camera {i}: {}", visible(name))?,
        }
    }
    for variant in &model.variants {
        writeln!(out, "  variant: {}", visible(variant))?;
    }
    for animation in &model.animations {
        let seconds = animation
            .seconds
            .map_or_else(|| "?".to_owned(), |seconds| seconds.to_string());
        let moves = animation.moves.iter().map(|(what, count)| plural(*count, what));
        let moves = moves.collect::<Vec<_>>().join(", ");
        let moves = if moves.is_empty() { "nothing" } else { &moves };
        let played = if animation.played { ", is played" } else { "" };
        writeln!(
            out,
            "  animation {}: {seconds} s, moves {moves}{played}",
            visible(&animation.name)
        )?;
    }
    for feature in &model.features {
        let FeatureEntry {
            name,
            count,
            used_by,
            treatment,
            detail,
        } = feature;
        let detail = match detail {
            &"" => String::new(),
            detail => format!(" ({detail})"),
        };
        writeln!(out, "  {}, {count} x {used_by}: {treatment}{detail}", visible(name))?;
    }
    Ok(())
}
