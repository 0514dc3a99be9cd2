//! Building each accelerator over 200,000 triangles, on all threads.

mod common;

use batch_render::accel::{self, AccelKind};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

fn build(c: &mut Criterion) {
    let geometry = common::terrain(316);
    let mut group = c.benchmark_group("build");
    group
        .sample_size(10)
        .throughput(Throughput::Elements(geometry.triangles.len() as u64));
    for kind in AccelKind::ALL.into_iter().filter(|kind| *kind != AccelKind::Linear) {
        group.bench_function(BenchmarkId::from_parameter(kind), |b| {
            b.iter(|| accel::build(kind, geometry.clone()).expect("finite"));
        });
    }
    group.finish();
}

criterion_group!(benches, build);
criterion_main!(benches);
