//! Renders a scene file into one PNG, by the library: `cargo run --release --example render_scene -- SCENE OUT.png`.

use std::path::Path;

use batch_render::{
    batch::{self, Observer, Plan, Request},
    compile, describe,
    render::Watch,
};

/// Says what is written, and nothing else.
struct Quiet;

impl Observer for Quiet {
    fn frame_started(&self, _number: i32, _index: usize, _total: usize) {}
    fn frame_rendered(&self, _number: i32, _took: std::time::Duration) {}
    fn frame_skipped(&self, _number: i32) {}
    fn file_written(&self, _number: i32, path: &Path) {
        println!("wrote {}", path.display());
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let scene_file = args.next().unwrap_or_else(|| "scenes/assignment/extended.toml".into());
    let out = args.next().unwrap_or_else(|| "out/render_scene.png".into());

    // What the file says, checked.
    let desc = describe::load(Path::new(&scene_file), std::fs::read)?;
    // What is wanted of it: everything that is not said here is the scene's to say.
    let request = Request {
        outputs: vec![out],
        resolution: Some([320, 320]),
        ..Request::default()
    };
    let plan = Plan::new(&desc, &request)?;
    // The scene itself, with its acceleration structure; it could render any number of frames.
    let scene = compile::scene(&desc, plan.accel)?;
    let summary = batch::run(&plan, &scene, &Quiet, &Watch::default())?;
    println!("{} rays in {:.2} s", summary.rays, summary.wall.as_secs_f64());
    Ok(())
}
