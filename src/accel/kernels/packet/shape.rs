//! Intersection of a packet with an analytic primitive: first with its bounds, then with a
//! vectorised estimate, and then with the primitive's scalar routine for the rays that are left.

use super::rays::{NO_MORE, Packet, load16s};
use crate::{
    accel::kernels::{
        query::{Best, Query},
        ray16::RAYS,
    },
    geometry::{
        Geometry, PrimId,
        slab::{END_PADDING, EXIT_PADDING, MIN_PADDING, ORIGIN_PADDING, Slabs},
    },
    math::{Aabb, Ray, Vec3},
    shape::Attempt,
    simd::lanes::{Floats, Mask, SimdLevel},
};

/// Up to this number, rays are tested one by one.
const MAX_SINGLE_RAYS: u32 = 3;

/// Tests shape `index` of the geometry's primitives. Returns whether it is the nearest hit of any
/// ray.
#[inline(always)]
pub fn shape_step<L: SimdLevel, Q: Query>(
    level: L,
    packet: &mut Packet,
    index: u32,
    geometry: &Geometry,
    rays: &[Ray],
) -> bool {
    let asked = packet.meets(level, &geometry.bounds(PrimId::new(index)));
    asked != 0 && test::<L, Q>(level, packet, index, asked, geometry, rays)
}

impl Packet {
    /// Returns ray `k`, prepared for clipping to a shape's bounds.
    #[inline(always)]
    fn slabs(&self, k: usize) -> Slabs {
        Slabs {
            o: Vec3::new(self.o[0].0[k], self.o[1].0[k], self.o[2].0[k]),
            inv: Vec3::new(self.inv[0].0[k], self.inv[1].0[k], self.inv[2].0[k]),
        }
    }

    /// Returns the set of rays that may intersect a box.
    #[inline(always)]
    fn meets<L: SimdLevel>(&self, level: L, bounds: &Aabb) -> u32 {
        let (o, inv) = (load16s(level, &self.o), load16s(level, &self.inv));
        let negative = self.state.negative();
        let mut enter = level.load16(&self.tmins.0);
        let mut leave = level.load16(&self.t.0).mul(level.splat16(END_PADDING));
        for axis in 0..3 {
            let (least, most) = (level.splat16(bounds.min[axis]), level.splat16(bounds.max[axis]));
            let pad = o[axis]
                .abs()
                .mul(level.splat16(ORIGIN_PADDING))
                .add(level.splat16(4.0 * MIN_PADDING));
            let (less, more) = (o[axis].sub(pad), o[axis].add(pad));
            let (near, far) = if negative[axis] {
                (most.sub(less), least.sub(more))
            } else {
                (least.sub(more), most.sub(less))
            };
            enter = near.mul(inv[axis]).max(enter);
            leave = far.mul(inv[axis]).min(leave);
        }
        enter.le(leave.mul(level.splat16(EXIT_PADDING))).bits()
    }
}

/// Tests a shape with the rays whose bits are set. A function of its own, so that none of the
/// kernel's vectors are live in code where the level's instructions are not enabled.
#[inline(never)]
fn test<L: SimdLevel, Q: Query>(
    level: L,
    packet: &mut Packet,
    index: u32,
    asked: u32,
    geometry: &Geometry,
    rays: &[Ray],
) -> bool {
    let Some(placed) = geometry.shape(PrimId::new(index)) else {
        return false;
    };
    let mut attempts = [Attempt::NOTHING; RAYS];
    if asked.count_ones() >= MAX_SINGLE_RAYS && placed.shape.attempts() {
        let slabs: [Slabs; RAYS] = std::array::from_fn(|k| packet.slabs(k));
        let mut lines = packet.lanes().map(|ray| Ray {
            tmax: f32::INFINITY,
            ..rays[ray as usize]
        });
        geometry.attempt_shape(level, placed, &mut lines, &slabs, &mut attempts);
    }
    let mut nearer = false;
    for (k, ray) in packet.rays().filter(|(k, _)| asked >> k & 1 == 1) {
        let best = Best {
            t: packet.t.0[k],
            u: packet.u.0[k],
            v: packet.v.0[k],
            id: packet.id.0[k].to_bits(),
        };
        let hit = match attempts[k].answer {
            Attempt::MISSES => None,
            Attempt::MEETS => {
                let hit = attempts[k].hit;
                (hit.t > packet.tmins.0[k] && hit.t <= best.t).then_some(hit)
            }
            _ => {
                let ray = Ray {
                    tmax: best.t,
                    ..rays[ray as usize]
                };
                geometry.intersect_shape(placed, &ray, || packet.slabs(k))
            }
        };
        if let Some(hit) = hit
            && best.loses_to(hit.t, index + 1)
        {
            let best = if Q::ANY {
                NO_MORE
            } else {
                Best {
                    t: hit.t,
                    u: hit.u,
                    v: hit.v,
                    id: index + 1,
                }
            };
            (packet.t.0[k], packet.u.0[k], packet.v.0[k]) = (best.t, best.u, best.v);
            packet.id.0[k] = f32::from_bits(best.id);
            nearer = true;
        }
    }
    nearer
}
