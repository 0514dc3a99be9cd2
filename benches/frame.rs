//! Samples per second of the assignment's scene, 1280x720, on all threads.

use std::path::Path;

use batch_render::{
    batch::{Job, Request},
    describe::Overrides,
    render::{Control, Renderer},
};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn frame(c: &mut Criterion) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/assignment/scene.toml");
    let samples = 16_u32;
    let request = Request {
        overrides: Overrides::default()
            .with("render.width", 1280)
            .with("render.height", 720)
            .with("render.samples", samples),
        ..Request::default()
    };
    let job = Job::open(&scene, &request).expect("the assignment's scene and a valid request");
    let scene = job.compile().expect("the assignment's scene");
    let plan = &job.plan;
    let (renderer, integrator) = (Renderer::new(), plan.picture.integrator.as_dyn());
    let mut group = c.benchmark_group("frame");
    group
        .sample_size(10)
        .throughput(Throughput::Elements(1280 * 720 * u64::from(samples)));
    group.bench_function("assignment", |b| {
        b.iter(|| {
            renderer.render(
                &scene,
                &plan.frames[0].camera,
                integrator,
                &plan.picture.settings,
                &Control::default(),
            )
        });
    });
    group.finish();
}

criterion_group!(benches, frame);
criterion_main!(benches);
