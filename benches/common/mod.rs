//! Scenes and rays that every benchmark measures, made by formulas and fixed seeds.

#![allow(dead_code, reason = "each benchmark uses its own part")]

use std::sync::Arc;

use batch_render::{
    geometry::Geometry,
    math::{
        Ray, Vec3,
        hash::{pcg4d, unit_f32},
        trig,
    },
};

/// A hilly square of `2 n n` triangles, 10 m wide.
pub fn terrain(n: u32) -> Arc<Geometry> {
    let height = |x: f32, z: f32| {
        0.6 * trig::sin(x * 1.3) * trig::cos(z * 1.7)
            + 0.15 * trig::sin(x * 7.1 + z * 5.3)
            + 0.03 * trig::sin(x * 31.0 - z * 27.0)
    };
    let at = |i: u32, j: u32| {
        let (x, z) = (i as f32 / n as f32 * 10.0 - 5.0, j as f32 / n as f32 * 10.0 - 5.0);
        Vec3::new(x, height(x, z), z)
    };
    let vertices = (0..=n).flat_map(|j| (0..=n).map(move |i| at(i, j))).collect();
    let quad = |i: u32, j: u32| {
        let a = j * (n + 1) + i;
        [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]
    };
    let triangles = (0..n).flat_map(|j| (0..n).flat_map(move |i| quad(i, j))).collect();
    Arc::new(Geometry {
        vertices,
        triangles,
        ..Geometry::default()
    })
}

/// Three uniform numbers for index `i`.
pub fn uniform(i: u32, seed: u32) -> [f32; 3] {
    let [a, b, c, _] = pcg4d([i, seed, 7, 11]);
    [unit_f32(a), unit_f32(b), unit_f32(c)]
}

/// Rays of a camera above the terrain, in tiles of 16 x 16 pixels.
pub fn primary_rays(side: u32) -> Vec<Ray> {
    let eye = Vec3::new(0.0, 3.0, 7.0);
    let tiles = side / 16;
    (0..side * side)
        .map(|k| {
            let (tile, inside) = (k / 256, k % 256);
            let x = (tile % tiles * 16 + inside % 16) as f32 / side as f32 - 0.5;
            let y = (tile / tiles * 16 + inside / 16) as f32 / side as f32 - 0.5;
            Ray::new(eye, Vec3::new(x * 1.2, -0.35 - y * 0.8, -1.0).normalize())
        })
        .collect()
}

/// Rays from random places above the terrain into random directions.
pub fn random_rays(count: u32) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let [x, y, z] = uniform(i, 1);
            let o = Vec3::new(x * 10.0 - 5.0, 1.0 + y, z * 10.0 - 5.0);
            let [a, b, c] = uniform(i, 2);
            let d = Vec3::new(a - 0.5, b - 0.7, c - 0.5);
            Ray::new(o, d.try_normalize().unwrap_or(Vec3::Y))
        })
        .collect()
}
