//! Detection of coherent rays.
//!
//! Packets of sixteen rays are three times as fast as a ray stream if the rays of a packet are
//! coherent, and half as fast if they are not. Camera rays are coherent: sixteen neighbours share
//! their origin and nearly their direction. The samples of a pixel are consecutive. If a pixel has
//! fewer than sixteen, blocks of pixels are more coherent than rows, and the rows of a tile lie a
//! fixed number of rays apart. So this module samples a few packets of the batch in each possible
//! order and decides for the whole batch; this costs less than ten rays. Packets do not change
//! hits, so a wrong guess costs time only, and little of it: packets that visit too much of the tree
//! are abandoned, as those of a wide lens are.

use crate::{
    accel::{
        accelerator::{BatchLayout, RayBatch},
        kernels::{packet::order::PacketOrder, ray16::RAYS},
    },
    math::Ray,
};

/// The number of packets that are sampled.
const SAMPLES: usize = 4;

/// The largest distance between the unit directions of a packet.
const SPREAD: f32 = 0.1;

/// The largest distance between the origins of a packet, relative to the scene's size.
const DISTANCE: f32 = 0.01;

/// Returns how the rays of a batch form packets in a scene of this size, or `None` if they are not
/// coherent.
pub fn nearest(RayBatch { rays, layout }: RayBatch<'_>, size: f32) -> Option<PacketOrder> {
    let packets = rays.len() / RAYS;
    if packets == 0 {
        return None;
    }
    let samples = [0, 1, 2, 3].map(|i| i * (packets - 1) / (SAMPLES - 1));
    // Every order has groups of four consecutive rays, so these rule out most incoherent batches.
    let four = |i| stay_together(rays, &PacketOrder::ROWS.list(i, rays.len()).ids[..4], DISTANCE * size);
    if !samples.into_iter().all(four) {
        return None;
    }
    let spread = |order: PacketOrder| {
        let of = |i| corner_spread(rays, &order.list(i, rays.len()).ids, size);
        samples.map(of).into_iter().fold(0.0, f32::max)
    };
    let mut best = (spread(PacketOrder::ROWS), PacketOrder::ROWS);
    if let BatchLayout::Rows(row) = layout
        && row >= 8
        && row.is_power_of_two()
    {
        for order in [4, 8].map(|run| PacketOrder::blocks(run, row as usize)) {
            let spread = spread(order);
            if spread < best.0 && order.band() <= rays.len() {
                best = (spread, order);
            }
        }
    }
    let together = |i| stay_together(rays, &best.1.list(i, rays.len()).ids, DISTANCE * size);
    samples.into_iter().all(together).then_some(best.1)
}

fn stay_together(rays: &[Ray], packet: &[u32], distance: f32) -> bool {
    let first = &rays[packet[0] as usize];
    let (o, d) = (first.o, first.d.normalize_or_zero());
    packet.iter().all(|&id| {
        let ray = &rays[id as usize];
        ray.o.distance_squared(o) <= distance.powi(2)
            && ray.d.normalize_or_zero().distance_squared(d) <= SPREAD * SPREAD
    })
}

/// Returns the largest squared distance between the corner rays of a packet: that of their
/// directions, or that of their origins in a scene of this size.
fn corner_spread(rays: &[Ray], packet: &[u32; RAYS], size: f32) -> f32 {
    let [a, b, c, d] = [0, 3, 12, 15].map(|k| &rays[packet[k] as usize]);
    let apart = |a: &Ray, b: &Ray| a.d.distance_squared(b.d) + a.o.distance_squared(b.o) / (size * size);
    apart(a, d).max(apart(b, c)).max(apart(a, b)).max(apart(a, c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    fn rays(spread: f32, apart: f32) -> Vec<Ray> {
        (0..100)
            .map(|i| {
                let x = (i % 16) as f32 / 16.0;
                Ray::new(Vec3::new(0.0, apart * x, 5.0), Vec3::new(spread * x, 0.3, -1.0))
            })
            .collect()
    }

    #[test]
    fn camera_rays_are_coherent_and_bounces_are_not() {
        let is_coherent = |rays: &[Ray]| nearest(RayBatch::unordered(rays), 10.0).is_some();
        assert!(is_coherent(&rays(0.05, 0.0)));
        assert!(is_coherent(&rays(0.0, 0.05)));
        assert!(!is_coherent(&rays(2.0, 0.0)));
        assert!(!is_coherent(&rays(0.0, 5.0)));
        assert!(!is_coherent(&rays(0.0, 0.0)[..15]));
    }

    #[test]
    fn packets_are_what_is_most_nearly_square() {
        let picture = |width: usize, samples: usize| {
            let ray = |i: usize| {
                let (pixel, sample) = (i / samples, (i % samples) as f32 / samples as f32);
                let (x, y) = ((pixel % width) as f32 + sample, (pixel / width) as f32 + sample);
                Ray::new(Vec3::ZERO, Vec3::new(x, y, 1000.0))
            };
            (0..4096).map(ray).collect::<Vec<_>>()
        };
        let order = |width: usize, samples: usize| {
            let batch = RayBatch {
                rays: &picture(width, samples),
                layout: BatchLayout::Rows((width * samples) as u32),
            };
            nearest(batch, 1.0)
        };
        assert_eq!(order(16, 1), Some(PacketOrder::blocks(4, 16)));
        assert_eq!(order(64, 1), Some(PacketOrder::blocks(4, 64)));
        assert_eq!(order(32, 4), Some(PacketOrder::blocks(8, 128)));
        assert_eq!(order(16, 16), Some(PacketOrder::ROWS));
        assert_eq!(order(24, 1), Some(PacketOrder::ROWS), "no power of two");
        assert_eq!(
            nearest(RayBatch::unordered(&picture(16, 1)), 1.0),
            Some(PacketOrder::ROWS)
        );
    }
}
