//! Tests of rays that are traced in packets: camera rays, in tiles.

use super::*;
use crate::accel::{
    kernels::{self, packet::PacketBatch, ray_selection::RaySelection, scratch::Scratch},
    wide::{Wide, packet_order},
};

/// The width and height of an image.
const SIDE: usize = 16;

/// Returns the rays of many small images from random points in random directions: from one point
/// each, from a lens, parallel, or to a light. Every 16th ray goes to a point on a triangle. Some
/// rays are short, begin later, or are not suited to packets. Every twentieth image is regular, so
/// that the samples of the detection find coherent rays.
fn pictures(g: &Geometry, count: usize, size: f32) -> Vec<Ray> {
    let mut r = Random(23);
    let mut rays = Vec::new();
    for picture in 0..count {
        let eye = match picture % 5 {
            0 if !g.triangles.is_empty() => g.corners(r.below(g.triangles.len()))[0],
            1 => r.vec(20.0 * size),
            _ => r.vec(2.0 * size),
        };
        // Along an axis, and so in several octants, or in any direction.
        let forward = match picture % 3 {
            0 => [Vec3::X, Vec3::NEG_Y, Vec3::Z][picture / 3 % 3],
            _ => (r.vec(0.5 * size) - eye).normalize_or(Vec3::Z),
        };
        let right = forward.any_orthonormal_vector();
        let up = forward.cross(right);
        let (lens, apart, width) = match picture % 4 {
            0 => (0.005 * size, 0.0, 0.4),
            1 if picture % 8 == 1 => (0.0, 0.02 * size, 0.0),
            1 => (0.0, 0.05 * size, 0.1),
            2 => (0.0, 0.0, 0.01),
            _ => (0.0, 0.0, 0.4),
        };
        let plain = picture % 20 == 0;
        let (lens, apart, width) = if plain { (0.0, 0.0, 0.1) } else { (lens, apart, width) };
        for i in 0..SIDE * SIDE {
            let x = (i % SIDE) as f32 / SIDE as f32 - 0.5;
            let y = (i / SIDE) as f32 / SIDE as f32 - 0.5;
            let o = eye + r.vec(lens) + (right * x + up * y) * (apart * SIDE as f32);
            let mut ray = Ray::new(o, (forward + (right * x + up * y) * width).normalize());
            if picture % 6 == 5 {
                // From points on a surface to a light.
                let lamp = eye + forward * (3.0 * size);
                let o = o + right * (4.0 * apart * SIDE as f32 * x) + r.vec(0.02 * size);
                ray = Ray::segment(o, lamp - o, 0.999);
            }
            if i % 16 == 5 && !plain && !g.triangles.is_empty() {
                let [a, b, c] = g.corners(r.below(g.triangles.len()));
                let to = [a, (a + b) * 0.5, (a + b + c) / 3.0][i / 16 % 3];
                let straight = ray.d;
                ray.d = (to - o).normalize_or(ray.d);
                if ray.d.dot(straight) < 0.99 {
                    ray.d = straight;
                }
            }
            match r.below(if plain { 1000 } else { 40 }) {
                0 => ray.tmax = r.unit() * 3.0 * size,
                1 => ray.tmin = r.unit() * 3.0 * size,
                2 => ray.tmin = -r.unit() * size,
                3 if picture % 7 == 0 => ray.d.x = 0.0,
                4 => ray.d *= 3.0,
                _ => {}
            }
            rays.push(ray);
        }
    }
    let extent = g.world_bounds().extent().max_element();
    let batch = RayBatch {
        rays: &rays,
        layout: BatchLayout::Rows(SIDE as u32),
    };
    assert!(packet_order::nearest(batch, extent).is_some());
    rays
}

/// Compares every accelerator with the linear scan, and packets that are never abandoned, abandoned
/// at once, and abandoned later, with the accelerator. Returns the number of hits.
fn compare_packets(g: Geometry, rays: &[Ray]) -> usize {
    let g = Arc::new(g);
    let count = compare(Geometry::clone(&g), rays);
    let mut truth = vec![None; rays.len()];
    build(AccelKind::Wide, g.clone())
        .expect("the scene is valid")
        .nearest(rays, &mut truth);
    let layout = BatchLayout::Rows(SIDE as u32);
    let extent = g.world_bounds().extent().max_element();
    let order = packet_order::nearest(RayBatch { rays, layout }, extent).expect("coherent samples");
    let mut scratch = Scratch::new();
    for simd in Isa::available() {
        let wide = Wide::build(g.clone(), simd).expect("the scene is valid");
        for visits in [u32::MAX, 0, 12] {
            let (mut hits, mut remaining) = (vec![None; rays.len()], Vec::new());
            let batch = PacketBatch { rays, order, visits };
            kernels::nearest_packets(simd, &wide.tree, &g, batch, &mut hits, &mut remaining, &mut scratch);
            assert!(if visits == 0 {
                remaining.len() == rays.len()
            } else {
                visits == 12 || remaining.len() < rays.len()
            });
            let remaining = RaySelection::Some(&remaining);
            kernels::nearest_stream(simd, &wide.tree, &g, rays, remaining, &mut hits, &mut scratch);
            for i in 0..rays.len() {
                assert_eq!(
                    bits(&hits[i]),
                    bits(&truth[i]),
                    "{simd}, {visits}, ray {i}: {:?}",
                    rays[i]
                );
            }
        }
    }
    count
}

fn scaled(mut g: Geometry, size: f32) -> Geometry {
    g.vertices.iter_mut().for_each(|p| *p *= size);
    g
}

#[test]
fn packets_equal_the_linear_scan() {
    for (g, least) in [
        (soup(300, 40, 0.3), 2_500),
        (grid(16, 0.1), 2_500),
        (grid(12, 0.0), 1_000),
        // Triangles smaller than the distance between rays.
        (grid(48, 0.02), 2_500),
        (rooms(), 5_000),
    ] {
        let rays = pictures(&g, 61, 1.0);
        assert!(compare_packets(g, &rays) > least);
    }
}

#[test]
fn packets_equal_the_linear_scan_on_slivers() {
    let mut g = soup(200, 0, 0.5);
    for i in 0..200 {
        let [a, b] = [g.vertices[3 * i], g.vertices[3 * i + 1]];
        g.vertices[3 * i + 2] = a + (b - a) * 0.37 + Vec3::splat(if i % 2 == 0 { 0.0 } else { 1e-6 });
    }
    let rays = pictures(&g, 61, 1.0);
    compare_packets(g, &rays);
}

#[test]
fn packets_equal_the_linear_scan_in_scenes_of_any_size() {
    for (size, least) in [(1e-18, 0), (1e-9, 700), (1e9, 700)] {
        let g = scaled(soup(200, 0, 0.3), size);
        let rays = pictures(&g, 61, size);
        assert!(compare_packets(g, &rays) >= least, "{size}");
    }
}
