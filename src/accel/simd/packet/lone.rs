//! A packet whose rays lie farther apart than triangles are large: few of them meet what is in a leaf, each by itself.

use super::{
    super::{
        super::{
            slab::{END, LEAVE, TINY},
            wide::node::Block,
        },
        inflight::load3,
        lanes::{Floats, Level, Mask},
        query::{Best, Query},
        triangle::{Vec3s, candidates, faces, meet, plane, sides},
    },
    RAYS,
    rays::{Each, NO_MORE, Packet},
};

/// By how much the box around a block is padded: by more than triangles' own boxes are, and than it is rounded relative to
/// where rays start.
const PADDING: f32 = 16.0 * f32::EPSILON;

impl Packet {
    /// Which rays may meet the box around the triangles of a block, given relative to the origin of all.
    #[inline(always)]
    pub fn near<L: Level>(&self, level: L, corners: &[Vec3s<L::F4>; 3]) -> u32 {
        let mut enter = level.load16(&self.tmins.0);
        let mut leave = level.load16(&self.t.0).mul(level.splat16(END));
        for (k, axis) in self.axes.map(usize::from).into_iter().enumerate() {
            let (axis, [a, b, c]) = (axis % 3, corners.map(|corner| corner[k]));
            // Where there is no triangle there are no numbers.
            let there = a.eq(a);
            let least = a.min(b).min(c).select(there, level.splat4(f32::INFINITY)).lowest();
            let most = a.max(b).max(c).select(there, level.splat4(f32::NEG_INFINITY)).highest();
            let pad = (least.abs().max(most.abs()) + self.origin[axis].abs()) * PADDING + 4.0 * TINY;
            let (least, most) = (least - pad, most + pad);
            let (near, far) = if self.negative()[axis] {
                (most, least)
            } else {
                (least, most)
            };
            let inv = level.load16(&self.inv[axis].0);
            enter = level.splat16(near).mul(inv).max(enter);
            leave = level.splat16(far).mul(inv).min(leave);
        }
        enter.le(leave.mul(level.splat16(LEAVE))).bits()
    }

    /// Tests four triangles, given relative to the origin of all, with the rays whose bits are set; whether one is met.
    #[inline(always)]
    pub fn lone_rays<L: Level, Q: Query>(
        &mut self,
        level: L,
        block: &Block,
        corners: &[Vec3s<L::F4>; 3],
        mut asked: u32,
    ) -> bool {
        let plane = plane(corners);
        let mut met = false;
        while asked != 0 {
            let k = asked.trailing_zeros() as usize % RAYS;
            asked &= asked - 1;
            let of = |each: &Each| level.splat4(each.0[k]);
            let all = |each: &[Each; 3]| [of(&each[0]), of(&each[1]), of(&each[2])];
            let sides = sides(corners, [of(&self.shear[0]), of(&self.shear[1])]);
            let candidates = candidates(all(&self.d), &plane, sides, of(&self.begin), of(&self.until));
            if candidates.mask.bits() != 0 {
                let [a, b, c] = &block.corners;
                let world = [
                    load3(level, a.each_ref()),
                    load3(level, b.each_ref()),
                    load3(level, c.each_ref()),
                ];
                let faces = faces(&all(&self.o), self.negative(), &world);
                let meets = meet(&all(&self.inv), &faces, &candidates);
                let within = of(&self.tmins).lt(meets.t).and(meets.t.le(of(&self.t)));
                let hits = within.and(meets.valid).bits();
                met |= hits != 0;
                let (t, u, v) = (meets.t.to_array(), meets.u.to_array(), meets.v.to_array());
                for i in (0..4).filter(|i| hits >> i & 1 == 1) {
                    self.keep::<Q>(
                        k,
                        Best {
                            t: t[i],
                            u: u[i],
                            v: v[i],
                            id: block.ids[i],
                        },
                    );
                }
            }
        }
        met
    }

    /// A hit of the ray in lane `k`, which may be nearer than what it has.
    #[inline(always)]
    fn keep<Q: Query>(&mut self, k: usize, hit: Best) {
        let (t, id) = (self.t.0[k], self.id.0[k].to_bits());
        if hit.t < t || hit.t == t && hit.id < id {
            let hit = if Q::ANY { NO_MORE } else { hit };
            (self.t.0[k], self.u.0[k], self.v.0[k]) = (hit.t, hit.u, hit.v);
            self.id.0[k] = f32::from_bits(hit.id);
        }
    }
}
