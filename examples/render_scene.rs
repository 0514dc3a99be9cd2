//! Renders a scene file into one PNG, by the library: `cargo run --release --example render_scene -- SCENE OUT.png`.

use std::path::Path;

use batch_render::{
    batch::{Job, JobEvent, Observer, Request},
    describe::Overrides,
    render::Control,
};

/// Says what is written, and nothing else.
struct Lines;

impl Observer for Lines {
    fn event(&self, event: &JobEvent<'_>) {
        if let JobEvent::FileWritten { file, .. } = event {
            println!("wrote {}", file.display());
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let scene_file = args.next().unwrap_or_else(|| "scenes/assignment/extended.toml".into());
    let out = args.next().unwrap_or_else(|| "out/render_scene.png".into());

    // The scene decides about everything that has no other value here.
    let request = Request {
        overrides: Overrides::default()
            .with("output.files", out)
            .with("render.width", 320)
            .with("render.height", 320),
        ..Request::default()
    };
    // The scene file and the request, checked: which frames there will be, and which files.
    let job = Job::open(Path::new(&scene_file), &request)?;
    // The scene's models and images.
    let scene = job.load()?;
    let summary = job.run(scene, &Lines, &Control::default())?;
    println!("{} rays in {:.2} s", summary.rays, summary.wall.as_secs_f64());
    Ok(())
}
