//! Grouping of rays by origin.

use crate::{
    accel::kernels::ray16::RAYS,
    math::Ray,
    simd::lanes::{Floats, SimdLevel},
};

/// The number of rays that are reordered together.
pub const BAND: usize = 4 * RAYS;

/// Reorders `ids` so that the rays of each chunk of [`RAYS`] have nearby origins. The rays are
/// split in halves along the axis of the largest extent of their origins, and the halves are split
/// again.
#[inline(always)]
pub fn group<L: SimdLevel>(level: L, rays: &[Ray], ids: &[u32; BAND]) -> [u32; BAND] {
    let mut o = [[0.0; BAND]; 3];
    for (i, id) in ids.iter().enumerate() {
        let start = rays[*id as usize].o;
        (o[0][i], o[1][i], o[2][i]) = (start.x, start.y, start.z);
    }
    let place = places(level, &o);
    let (mut halved, mut halves) = ([0; BAND], [[0.0; BAND]; 3]);
    for (i, place) in place.into_iter().enumerate() {
        let place = place as usize % BAND;
        halved[place] = ids[i];
        for axis in 0..3 {
            halves[axis][place] = o[axis][i];
        }
    }
    let mut grouped = [0; BAND];
    for first in [0, BAND / 2] {
        let place = places(
            level,
            &[
                half(&halves[0], first),
                half(&halves[1], first),
                half(&halves[2], first),
            ],
        );
        for (i, place) in place.into_iter().enumerate() {
            grouped[first + place as usize % (BAND / 2)] = halved[first + i];
        }
    }
    grouped
}

#[inline(always)]
fn half(x: &[f32; BAND], first: usize) -> [f32; BAND / 2] {
    *x[first..].first_chunk().expect("a half begins there")
}

/// Returns the rank of each ray along the axis of the largest extent.
#[inline(always)]
fn places<L: SimdLevel, const N: usize>(level: L, o: &[[f32; N]; 3]) -> [i16; N] {
    let mut widest = (f32::NEG_INFINITY, 0, 0.0);
    for (axis, x) in o.iter().enumerate() {
        let (least, most) = extremes(level, x);
        if most - least > widest.0 {
            widest = (most - least, axis, least);
        }
    }
    let (width, axis, least) = widest;
    // All keys differ, since the lowest six bits are the index.
    const { assert!(BAND <= 64) };
    let scale = 511.0 / width;
    let mut keys = [0_i16; N];
    for (i, (key, x)) in keys.iter_mut().zip(&o[axis]).enumerate() {
        *key = (((x - least) * scale) as i32 as i16) << 6 | i as i16;
    }
    level.places(&keys)
}

#[inline(always)]
fn extremes<L: SimdLevel, const N: usize>(level: L, x: &[f32; N]) -> (f32, f32) {
    let (first, others) = x.as_chunks::<RAYS>().0.split_first().expect("there are some");
    let mut least = level.load16(first);
    let mut most = least;
    for x in others {
        let x = level.load16(x);
        (least, most) = (least.min(x), most.max(x));
    }
    (least.reduce_min(), most.reduce_max())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::{Vec3, hash},
        simd::portable::Portable,
    };

    /// Rays that start at the points of a grid of 8 x 8, in some order.
    fn rays() -> Vec<Ray> {
        let mut cells: Vec<u32> = (0..64).collect();
        cells.sort_by_key(|&i| hash::pcg4d([i, 1, 2, 3])[0]);
        let start = |i: u32| Vec3::new((i % 8) as f32, 7.0, (i / 8) as f32 * 1.1);
        cells.into_iter().map(|i| Ray::new(start(i), Vec3::Y)).collect()
    }

    #[test]
    fn rays_that_start_next_to_one_another_go_together() {
        let rays = rays();
        let grouped = group(Portable, &rays, &std::array::from_fn(|i| i as u32));
        for four_by_four in grouped.chunks(RAYS) {
            let first = rays[four_by_four[0] as usize].o;
            let corner = |x: f32| x - x % 4.0;
            for &id in four_by_four {
                let o = rays[id as usize].o;
                assert_eq!(corner(o.x), corner(first.x));
                assert_eq!(corner(o.z / 1.1 + 0.1), corner(first.z / 1.1 + 0.1));
            }
        }
    }

    #[test]
    fn every_ray_stays() {
        for nan in [false, true] {
            let mut rays = rays();
            rays[5].o.x = if nan { f32::NAN } else { f32::INFINITY };
            let mut grouped = group(Portable, &rays, &std::array::from_fn(|i| 63 - i as u32));
            grouped.sort_unstable();
            assert!(grouped.into_iter().eq(0..64));
        }
    }
}
