//! An integrator of one's own: the facing ratio, white where a surface faces the camera, black where it is seen edge-on.
//!
//! `cargo run --release --example custom_integrator -- SCENE OUT.png`

use std::path::Path;

use batch_render::{
    batch::{Job, Request},
    describe::Overrides,
    integrator::{Integrator, ShadingOutput, Vertex, VertexContext},
    math::Rgb,
    output::{self, DisplayTransform, FrameMetadata},
    render::{Control, Renderer},
};

struct FacingRatio;

impl Integrator for FacingRatio {
    fn vertex(&self, context: &VertexContext<'_>, out: &mut ShadingOutput) {
        // A vertex adds radiance and may send out rays: `out.add_shadow` and `out.spawn_path`. This one only adds.
        if let Vertex::Surface(surface, _) = context.vertex {
            out.add(Rgb::gray(surface.ns.dot(surface.wo).abs()));
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let scene_file = args.next().unwrap_or_else(|| "scenes/assignment/extended.toml".into());
    let out = args.next().unwrap_or_else(|| "out/custom_integrator.png".into());

    let request = Request {
        overrides: Overrides::default()
            .with("render.width", 320)
            .with("render.height", 320)
            .with("render.samples", 16),
        ..Request::default()
    };
    let job = Job::open(Path::new(&scene_file), &request)?;
    let scene = job.compile()?;
    let film = Renderer::new().render(
        &scene,
        &job.plan.frames[0].camera,
        &FacingRatio,
        &job.plan.picture.settings,
        &Control::default(),
    )?;

    let metadata = FrameMetadata {
        view: DisplayTransform::Raw,
        ..FrameMetadata::new(1, &job.plan.picture.settings, &FacingRatio)
    };
    output::write_still(Path::new(&out), &film, &metadata)?;
    println!("wrote {out}");
    Ok(())
}
