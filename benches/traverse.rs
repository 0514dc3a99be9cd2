//! Rays per second of every accelerator, on 200,000 triangles.

mod common;

use batch_render::accel::{self, AccelKind};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

fn traverse(c: &mut Criterion) {
    let geometry = common::terrain(316);
    let kinds = [
        ("primary", common::primary_rays(256)),
        ("random", common::random_rays(65_536)),
    ];
    for (name, rays) in kinds {
        let mut group = c.benchmark_group(format!("traverse/{name}"));
        group
            .sample_size(20)
            .throughput(Throughput::Elements(rays.len() as u64));
        for kind in AccelKind::ALL.into_iter().filter(|kind| *kind != AccelKind::Linear) {
            let accel = accel::build(kind, geometry.clone()).expect("finite");
            let mut hits = vec![None; rays.len()];
            group.bench_function(BenchmarkId::new("nearest", kind), |b| {
                b.iter(|| accel.nearest(&rays, &mut hits))
            });
            let mut blocked = vec![false; rays.len()];
            group.bench_function(BenchmarkId::new("occluded", kind), |b| {
                b.iter(|| accel.occluded(&rays, &mut blocked))
            });
        }
        group.finish();
    }
}

criterion_group!(benches, traverse);
criterion_main!(benches);
