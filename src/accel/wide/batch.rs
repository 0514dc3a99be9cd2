//! What a batch of rays is: coherent or not.
//!
//! Packets of sixteen rays are three times as fast as rays in flight where the rays of each packet stay together, and
//! half as fast where they do not. Camera rays stay together: sixteen in a row share their origin and nearly their
//! direction. So a few packets of a batch are looked at, and the whole batch is treated as they are; it costs less than
//! one ray. What a packet holds does not change hits, so a wrong guess costs time only.
//!
//! Occlusion never uses packets: a ray that is blocked early leaves its packet with nothing to share.

use super::super::simd::PACKET;
use crate::math::Ray;

/// Packets that are looked at.
const SAMPLES: usize = 4;

/// How far apart the directions of a packet may be, as the distance of unit vectors.
const SPREAD: f32 = 0.1;

/// How far apart its origins may be, relative to the scene's size.
const DISTANCE: f32 = 0.01;

/// Whether packets suit these rays in a scene of this size.
pub(super) fn is_coherent(rays: &[Ray], size: f32) -> bool {
    let packets = rays.len() / PACKET;
    if packets == 0 {
        return false;
    }
    (0..SAMPLES).all(|i| {
        let first = i * (packets - 1) / (SAMPLES - 1) * PACKET;
        stay_together(&rays[first..first + PACKET], size)
    })
}

fn stay_together(packet: &[Ray], size: f32) -> bool {
    let (o, d) = (packet[0].o, packet[0].d.normalize_or_zero());
    packet.iter().all(|ray| {
        ray.o.distance_squared(o) <= (DISTANCE * size).powi(2)
            && ray.d.normalize_or_zero().distance_squared(d) <= SPREAD * SPREAD
    })
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
        assert!(is_coherent(&rays(0.05, 0.0), 10.0));
        assert!(is_coherent(&rays(0.0, 0.05), 10.0));
        assert!(!is_coherent(&rays(2.0, 0.0), 10.0));
        assert!(!is_coherent(&rays(0.0, 5.0), 10.0));
        assert!(!is_coherent(&rays(0.0, 0.0)[..15], 10.0));
    }
}
