//! Seconds to encode an EXR file of 1920x1080 pixels in memory, on all threads: the picture alone, and twenty channels.
//!
//! With `WRITE_SAMPLE` set to a path the file of twenty channels is written there, for comparisons with other writers.

use batch_render::{
    film::Window,
    math::hash::{pcg4d, unit_f32},
    output::{
        BlockShape, Compression,
        exr::{Channel, ChannelData, Image, Samples, write},
    },
};
use criterion::{Criterion, criterion_group, criterion_main};

const SIZE: [u32; 2] = [1920, 1080];

/// Smooth shades with the noise of a few samples, as pictures have them.
fn noisy(seed: u32) -> Vec<f32> {
    let pixel = |i: u32| {
        let (x, y) = (i % SIZE[0], i / SIZE[0]);
        let [a, b, ..] = pcg4d([i, seed, 7, 9]);
        let shade = 0.2 + (x as f32 / 1920.0) * 0.5 + (y / 64 % 3) as f32 * 0.1;
        shade * (1.0 + 0.2 * (unit_f32(a) + unit_f32(b) - 1.0))
    };
    (0..SIZE[0] * SIZE[1]).map(pixel).collect()
}

/// One number for each square of 96 pixels.
fn ids(seed: u32) -> Vec<u32> {
    let pixel = |i: u32| pcg4d([i % SIZE[0] / 96, i / SIZE[0] / 96, seed, 0])[0] % 40;
    (0..SIZE[0] * SIZE[1]).map(pixel).collect()
}

fn encode(c: &mut Criterion) {
    let light: Vec<Vec<f32>> = (0..16).map(noisy).collect();
    let numbers: Vec<Vec<u32>> = (0..4).map(ids).collect();
    let names: Vec<String> = (0..20).map(|i| format!("c{i:02}")).collect();
    let mattes: Vec<Vec<f32>> = numbers
        .iter()
        .map(|n| n.iter().map(|n| f32::from_bits(n * 0x0101_0101)).collect())
        .collect();
    let half = |i: usize| Samples::Half(ChannelData::dense(&light[i]));
    // Ten halves, six floats, two ids of Cryptomatte and two of whole numbers.
    let samples = |i: usize| match i {
        0..10 => half(i),
        10..16 => Samples::Float(ChannelData::dense(&light[i])),
        16..18 => Samples::Float(ChannelData::dense(&mattes[i - 16])),
        _ => Samples::Uint(ChannelData::dense(&numbers[i - 16])),
    };
    let channel = |i: usize, samples| Channel {
        name: &names[i],
        samples,
    };
    let twenty: Vec<Channel> = (0..20).map(|i| channel(i, samples(i))).collect();
    let picture: Vec<Channel> = (0..4).map(|i| channel(i, half(i))).collect();
    let mut group = c.benchmark_group("write");
    group.sample_size(20);
    for (name, channels) in [("picture", &picture), ("twenty", &twenty)] {
        let image = Image {
            display: Window::full(SIZE),
            data: Window::full(SIZE),
            channels,
            attributes: &[],
            compression: Compression::Zips,
            blocks: BlockShape::Lines,
        };
        let file = || {
            let mut file = Vec::new();
            write(&image, &mut file).expect("memory takes every byte");
            file
        };
        if let Some(path) = std::env::var_os("WRITE_SAMPLE").filter(|_| name == "twenty") {
            std::fs::write(path, file()).expect("a place for the sample");
        }
        group.bench_function(name, |b| b.iter(file));
    }
    group.finish();
}

criterion_group!(benches, encode);
criterion_main!(benches);
