//! Intersection of single rays of packets with single triangles, eight pairs at a time.
//!
//! If triangles are as small as the distance between a packet's rays, few of the sixteen rays
//! intersect each of them.

use std::ptr;

use super::rays::{PACKETS, Packet};
use crate::{
    accel::{
        kernels::{
            ray_state::BEYOND,
            ray16::{RAYS, load_eight},
            triangle::{Vec3s, candidates, each, faces, meet, plane, sides, stretch},
        },
        wide::node::TriangleBlock,
    },
    math::Ray,
    simd::lanes::{Floats, Mask, SimdLevel},
};

/// The smallest number of rays for which a triangle is tested with all sixteen rays; fewer are
/// tested as pairs.
pub const MIN_PACKET_LANES: u32 = 9;

/// The number of triangles in a block.
pub const BLOCK_TRIANGLES: usize = 4;

/// The number of pairs that are tested together.
const EIGHT: usize = 8;

/// The capacity of the queue.
const PAIRS: usize = 256;

/// The pairs of rays and triangles in the queue. In each group of eight, all packets have the same
/// [`Packet::way`].
pub struct Singles {
    rays: [u32; PAIRS],
    /// The first element of each triangle in its block; the others follow at a stride of
    /// [`BLOCK_TRIANGLES`].
    triangles: [*const f32; PAIRS],
    /// [`RAYS`] times the index of a packet, plus the lane of its ray.
    lanes: [u32; PAIRS],
    count: usize,
    way: u32,
}

impl Singles {
    pub fn new() -> Self {
        Self {
            rays: [0; PAIRS],
            triangles: [ptr::null(); PAIRS],
            lanes: [0; PAIRS],
            count: 0,
            way: 0,
        }
    }

    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Returns whether there is room for the rays of one more triangle and for padding groups.
    #[inline(always)]
    pub fn has_room(&self) -> bool {
        self.count + MIN_PACKET_LANES as usize + 2 * EIGHT <= PAIRS
    }

    /// Adds rays of the packet `id`, each with triangle `k` of a block.
    #[inline(always)]
    pub fn add(&mut self, id: usize, packet: &Packet, mut lanes: u32, block: &TriangleBlock, k: usize) {
        let way = packet.way();
        if way != self.way {
            self.fill();
            self.way = way;
        }
        let triangle = ptr::from_ref(block).cast::<f32>().wrapping_add(k);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % RAYS;
            lanes &= lanes - 1;
            let at = self.count % PAIRS;
            self.rays[at] = packet.ray(lane);
            self.triangles[at] = triangle;
            self.lanes[at] = (id * RAYS + lane) as u32;
            self.count += 1;
        }
    }

    /// Pads the last group with its last pair, which is then tested several times.
    #[inline(always)]
    fn fill(&mut self) {
        while !self.count.is_multiple_of(EIGHT) {
            let (last, at) = ((self.count - 1) % PAIRS, self.count % PAIRS);
            self.rays[at] = self.rays[last];
            self.triangles[at] = self.triangles[last];
            self.lanes[at] = self.lanes[last];
            self.count += 1;
        }
    }

    /// Stores the nearer hits. Returns the set of packets that have rays which were
    /// shortened.
    ///
    /// # Safety
    /// The blocks of all pairs still exist.
    #[inline(always)]
    pub unsafe fn test<L: SimdLevel>(&mut self, level: L, packets: &mut [Packet; PACKETS], rays: &[Ray]) -> u64 {
        self.fill();
        let mut nearer = 0;
        for group in 0..self.count.min(PAIRS) / EIGHT {
            let ids = &self.rays.as_chunks::<EIGHT>().0[group];
            let lanes = &self.lanes.as_chunks::<EIGHT>().0[group];
            let triangles = &self.triangles.as_chunks::<EIGHT>().0[group];
            // SAFETY: by this function's own contract.
            nearer |= unsafe { test(level, rays, ids, triangles, lanes, packets) };
        }
        nearer
    }
}

/// Tests eight pairs. Returns the set of packets that have rays which were shortened.
///
/// # Safety
/// The triangles exist, and their packets have the same [`Packet::way`].
#[inline(always)]
unsafe fn test<L: SimdLevel>(
    level: L,
    rays: &[Ray],
    ids: &[u32; EIGHT],
    triangles: &[*const f32; EIGHT],
    lanes: &[u32; EIGHT],
    packets: &mut [Packet; PACKETS],
) -> u64 {
    let first = &packets[lanes[0] as usize / RAYS % PACKETS];
    let [x, y, z] = first.axes.map(|axis| usize::from(axis) % 3);
    let negative = first.state.negative();
    let negative = [negative[x], negative[y], negative[z]];

    let [ox, oy, oz, tmin, dx, dy, dz, tmax] = load_eight(level, rays, ids);
    let o = [ox.to_array(), oy.to_array(), oz.to_array()];
    let o = [level.load8(&o[x]), level.load8(&o[y]), level.load8(&o[z])];
    let d = [dx.to_array(), dy.to_array(), dz.to_array()];
    let d = [level.load8(&d[x]), level.load8(&d[y]), level.load8(&d[z])];

    // SAFETY: by this function's own contract.
    let corners = unsafe {
        [
            corner(level, triangles, 0, [x, y, z]),
            corner(level, triangles, 1, [x, y, z]),
            corner(level, triangles, 2, [x, y, z]),
        ]
    };
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
    let meets = meet(stretch(&inv, &faces(&o, negative, &corners)), &candidates.crossing);
    let mut valid = candidates.mask.and(meets.valid).and(tmin.lt(meets.t)).bits();
    let (t, u, v) = (meets.t.to_array(), meets.u.to_array(), meets.v.to_array());

    let mut nearer = 0;
    while valid != 0 {
        let i = valid.trailing_zeros() as usize % EIGHT;
        valid &= valid - 1;
        let (id, lane) = (lanes[i] as usize / RAYS % PACKETS, lanes[i] as usize % RAYS);
        // SAFETY: the keys follow the vertices of a block.
        let key = unsafe { *triangles[i].add(9 * BLOCK_TRIANGLES) }.to_bits();
        let found = packets[id].keep(lane, [t[i], u[i], v[i]], key);
        nearer |= u64::from(found) << id;
    }
    nearer
}

/// Loads a vertex of the triangles, in the order of the axes.
#[inline(always)]
unsafe fn corner<L: SimdLevel>(
    level: L,
    triangles: &[*const f32; EIGHT],
    corner: usize,
    [x, y, z]: [usize; 3],
) -> Vec3s<L::F8> {
    // SAFETY: by this function's own contract.
    unsafe {
        [
            row(level, triangles, (3 * corner + x) * BLOCK_TRIANGLES),
            row(level, triangles, (3 * corner + y) * BLOCK_TRIANGLES),
            row(level, triangles, (3 * corner + z) * BLOCK_TRIANGLES),
        ]
    }
}

#[inline(always)]
unsafe fn row<L: SimdLevel>(level: L, [a, b, c, d, e, f, g, h]: &[*const f32; EIGHT], at: usize) -> L::F8 {
    // SAFETY: by this function's own contract.
    unsafe {
        level.load8(&[
            *a.add(at),
            *b.add(at),
            *c.add(at),
            *d.add(at),
            *e.add(at),
            *f.add(at),
            *g.add(at),
            *h.add(at),
        ])
    }
}

impl Packet {
    /// Stores a hit of one ray if it is nearer. Returns whether it is.
    #[inline(always)]
    fn keep(&mut self, lane: usize, [t, u, v]: [f32; 3], key: u32) -> bool {
        let (best, before) = (self.t.0[lane], self.key.0[lane].to_bits());
        let is_nearer = t < best || (t == best && key < before);
        if is_nearer {
            (self.t.0[lane], self.u.0[lane], self.v.0[lane]) = (t, u, v);
            self.key.0[lane] = f32::from_bits(key);
        }
        is_nearer
    }
}
