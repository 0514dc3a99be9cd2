//! Single rays of packets at single triangles, eight pairs at a time.
//!
//! Where triangles are as small as what lies between a packet's rays, few of sixteen go through each.

use super::{
    super::{
        super::wide::node::Block,
        lanes::{Floats, Level, Mask},
        query::Query,
        scratch::PACKETS,
        slot::BEYOND,
        triangle::{Vec3s, candidates, each, faces, meet, plane, sides},
    },
    RAYS,
    rays::{NO_MORE, Packet, load_eight},
};
use crate::math::Ray;

/// How many are tested together.
pub const EIGHT: usize = 8;

/// A ray of a packet, and a triangle of a block.
#[derive(Clone, Copy)]
pub struct Single {
    pub packet: usize,
    pub lane: usize,
    pub block: *const Block,
    pub k: usize,
}

/// Keeps the hits that are nearer; the set of packets some of whose rays end nearer now, or are blocked.
///
/// # Safety
/// All blocks exist, and all packets have the same [`Packet::way`].
#[inline(always)]
pub unsafe fn test<L: Level, Q: Query>(
    level: L,
    singles: &[Single; EIGHT],
    packets: &mut [Packet; PACKETS],
    rays: &[Ray],
) -> u64 {
    let first = &packets[singles[0].packet % PACKETS];
    let [x, y, z] = first.axes.map(|axis| usize::from(axis) % 3);
    let negative = first.course.negative();
    let negative = [negative[x], negative[y], negative[z]];

    let ids = singles.each_ref().map(|one| packets[one.packet % PACKETS].ray(one.lane));
    let [ox, oy, oz, tmin, dx, dy, dz, tmax] = load_eight(level, rays, &ids);
    let o = [ox.to_array(), oy.to_array(), oz.to_array()];
    let o = [level.load8(&o[x]), level.load8(&o[y]), level.load8(&o[z])];
    let d = [dx.to_array(), dy.to_array(), dz.to_array()];
    let d = [level.load8(&d[x]), level.load8(&d[y]), level.load8(&d[z])];

    // SAFETY: by this function's own contract.
    let blocks = unsafe { singles.each_ref().map(|one| &*one.block) };
    let ks = singles.each_ref().map(|one| one.k % 4);
    let corners = [
        corner(level, &blocks, &ks, 0, [x, y, z]),
        corner(level, &blocks, &ks, 1, [x, y, z]),
        corner(level, &blocks, &ks, 2, [x, y, z]),
    ];
    let relative = [
        each(corners[0], o, L::F8::sub),
        each(corners[1], o, L::F8::sub),
        each(corners[2], o, L::F8::sub),
    ];
    let one = level.splat8(1.0);
    let inv = [one.div(d[0]), one.div(d[1]), one.div(d[2])];
    let sides = sides(&relative, [d[0].mul(inv[2]), d[1].mul(inv[2])]);
    let begin = tmin.mul(level.splat8(1.0 - BEYOND));
    let until = tmax.add(tmax.abs().mul(level.splat8(BEYOND)));
    let candidates = candidates(d, &plane(&relative), sides, begin, until);
    let meets = meet(&inv, &faces(&o, negative, &corners), &candidates);
    let mut valid = meets.valid.and(tmin.lt(meets.t)).bits();
    let (t, u, v) = (meets.t.to_array(), meets.u.to_array(), meets.v.to_array());

    let mut nearer = 0;
    while valid != 0 {
        let i = valid.trailing_zeros() as usize % EIGHT;
        valid &= valid - 1;
        let packet = singles[i].packet % PACKETS;
        let found = packets[packet].keep::<Q>(singles[i].lane, [t[i], u[i], v[i]], blocks[i].ids[ks[i]]);
        nearer |= u64::from(found) << packet;
    }
    nearer
}

/// A corner of the triangles, in the order of the axes.
#[inline(always)]
fn corner<L: Level>(
    level: L,
    blocks: &[&Block; EIGHT],
    ks: &[usize; EIGHT],
    corner: usize,
    [x, y, z]: [usize; 3],
) -> Vec3s<L::F8> {
    [
        row(level, blocks, ks, corner, x),
        row(level, blocks, ks, corner, y),
        row(level, blocks, ks, corner, z),
    ]
}

#[inline(always)]
fn row<L: Level>(level: L, blocks: &[&Block; EIGHT], ks: &[usize; EIGHT], corner: usize, axis: usize) -> L::F8 {
    level.load8(&[
        blocks[0].corners[corner][axis][ks[0]],
        blocks[1].corners[corner][axis][ks[1]],
        blocks[2].corners[corner][axis][ks[2]],
        blocks[3].corners[corner][axis][ks[3]],
        blocks[4].corners[corner][axis][ks[4]],
        blocks[5].corners[corner][axis][ks[5]],
        blocks[6].corners[corner][axis][ks[6]],
        blocks[7].corners[corner][axis][ks[7]],
    ])
}

impl Packet {
    /// Keeps a hit of one ray if it is nearer; whether it is.
    #[inline(always)]
    fn keep<Q: Query>(&mut self, lane: usize, [t, u, v]: [f32; 3], id: u32) -> bool {
        let lane = lane % RAYS;
        let (best, number) = (self.t.0[lane], self.id.0[lane].to_bits());
        if Q::ANY {
            if t <= best {
                (self.t.0[lane], self.id.0[lane]) = (NO_MORE.t, f32::from_bits(NO_MORE.id));
            }
            return t <= best;
        }
        let is_nearer = t < best || (t == best && id < number);
        if is_nearer {
            (self.t.0[lane], self.u.0[lane], self.v.0[lane]) = (t, u, v);
            self.id.0[lane] = f32::from_bits(id);
        }
        is_nearer
    }
}
