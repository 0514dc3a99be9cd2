//! Sixteen rays in structure-of-arrays layout.

use super::{ray_rows::numbers, triangle::Vec3s};
use crate::{
    geometry::slab::MAX_RECIPROCAL,
    math::Ray,
    simd::lanes::{Floats, Mask, SimdLevel},
};

/// The number of rays in a packet.
pub const RAYS: usize = 16;

/// The largest coordinate of the origins of a packet's rays, relative to the scene's extent.
const MAX_ORIGIN: f32 = 64.0;

pub struct Ray16<F> {
    pub o: Vec3s<F>,
    pub d: Vec3s<F>,
    /// The reciprocal of the direction: [`crate::geometry::slab::reciprocal`] for regular rays.
    pub inv: Vec3s<F>,
    pub tmin: F,
    pub tmax: F,
}

/// The lanes of sixteen rays by their properties, as bits.
pub struct Sorted {
    /// The rays whose numbers need no special treatment and that do not end before they begin.
    pub ordinary: u32,
    /// The rays with the same main axis and the same signs as the first of these.
    pub alike: u32,
    /// The rays whose direction is negative, for each axis.
    pub below: [u32; 3],
}

#[inline(always)]
pub fn load_eight<L: SimdLevel>(level: L, rays: &[Ray], ids: &[u32]) -> [L::F8; 8] {
    let load = |k: usize| level.load8(numbers(&rays[ids[k] as usize]));
    level.transpose([load(0), load(1), load(2), load(3), load(4), load(5), load(6), load(7)])
}

impl<F: Floats> Ray16<F> {
    #[inline(always)]
    pub fn load<L: SimdLevel<F16 = F>>(level: L, rays: &[Ray], ids: &[u32; RAYS]) -> Self {
        let [ox, oy, oz, tmin, dx, dy, dz, tmax] = load_eight(level, rays, &ids[..8]);
        let [ox2, oy2, oz2, tmin2, dx2, dy2, dz2, tmax2] = load_eight(level, rays, &ids[8..]);
        let d = [level.join(dx, dx2), level.join(dy, dy2), level.join(dz, dz2)];
        let one = level.splat16(1.0);
        Self {
            o: [level.join(ox, ox2), level.join(oy, oy2), level.join(oz, oz2)],
            d,
            inv: [one.div(d[0]), one.div(d[1]), one.div(d[2])],
            tmin: level.join(tmin, tmin2),
            tmax: level.join(tmax, tmax2),
        }
    }

    #[inline(always)]
    pub fn sort(&self, reach: f32) -> Sorted {
        let Self { o, d, inv, tmin, tmax } = *self;
        let zero = tmin.fill(0.0);
        let most = tmin.fill(f32::MAX);
        let length = [d[0].abs(), d[1].abs(), d[2].abs()];
        let longest = length[0].max(length[1]).max(length[2]);
        let steep = longest.mul(tmin.fill(2.0 / MAX_RECIPROCAL));
        let away = tmin.fill(MAX_ORIGIN * reach);
        let mut ordinary = zero.le(tmin).and(tmin.le(tmax));
        for axis in 0..3 {
            // Finite, and so are the shifts of planes.
            let start = o[axis].abs();
            ordinary = ordinary
                .and(start.le(away))
                .and(length[axis].le(most))
                .and(steep.lt(length[axis]))
                .and(start.add(start).mul(inv[axis]).abs().le(most));
        }
        let below = [d[0].lt(zero).bits(), d[1].lt(zero).bits(), d[2].lt(zero).bits()];
        // The main axis, by the comparisons of `Shear::new`.
        let first = length[1].lt(length[0]).and(length[2].lt(length[0])).bits();
        let second = length[2].lt(length[1]).bits() & !first;
        let ordinary = ordinary.bits() & 0xffff;
        let leader = ordinary.trailing_zeros() as usize % RAYS;
        let along = like(first, leader) & like(second, leader);
        Sorted {
            ordinary,
            alike: along & like(below[0], leader) & like(below[1], leader) & like(below[2], leader),
            below,
        }
    }
}

/// Returns `mask` if it contains lane `leader`, otherwise its complement.
fn like(mask: u32, leader: usize) -> u32 {
    if mask >> leader & 1 == 1 { mask } else { !mask }
}
