//! Intersection of packets with the triangles of leaves.
//!
//! Whether a triangle is hit is unpredictable, and a mispredicted branch stalls the processor. So
//! each step is a pass of its own over all packets that are at leaves, and filters a list without
//! branches. The steps find the triangles that the bounds of a packet intersect, four at a time;
//! the triangles that the line of at least one ray intersects; and the hits.

use super::rays::load16s;
use std::ptr;

use super::{
    edges::{Edges, flat, passed, range, side},
    rays::{PACKETS, Packet},
    singles::{BLOCK_TRIANGLES, MIN_PACKET_LANES, Singles},
};
use crate::{
    accel::{
        kernels::triangle::{
            Faces, TrianglePlane, Vec3s, boxes, candidates, each, faces, load3, meet, plane, sides, spread, stretch,
        },
        wide::node::{MAX_LEAF, TriangleBlock},
    },
    math::Ray,
    simd::lanes::{Floats, Mask, SimdLevel},
};

/// The set of all lanes.
const ALL: u32 = 0xffff;

/// The largest number of blocks that packets can visit in a pass, a power of two.
const MAX_VISITS: usize = PACKETS * MAX_LEAF;

/// A bound on the error of an edge function, relative to the extent of the triangle as seen from
/// the rays' origin and lines. The routine for single rays has an error of less than 12 units of
/// [`f32::EPSILON`], [`Edges`] of less than 32.
const MARGIN: f32 = 64.0 * f32::EPSILON;

/// The same for numbers so small that they have lost precision.
const MIN_MARGIN: f32 = 64.0 * f32::MIN_POSITIVE;

/// The direction-independent data of a block's triangles for a common origin: the contents of
/// [`TrianglePlane`] and [`Faces`], and the vertices relative to the origin.
#[derive(Default)]
struct OriginData {
    corners: [[[f32; BLOCK_TRIANGLES]; 3]; 3],
    normal: [[f32; BLOCK_TRIANGLES]; 3],
    distance: [f32; BLOCK_TRIANGLES],
    near: [[f32; BLOCK_TRIANGLES]; 3],
    far: [[f32; BLOCK_TRIANGLES]; 3],
}

/// A block that a packet visits.
#[derive(Clone, Copy)]
struct Visit {
    /// Valid if all rays have a common origin.
    edges: Edges,
    block: *const TriangleBlock,
    packet: usize,
}

/// The blocks that packets visit, and the triangles of these that may be hit.
pub struct PacketLeafQueue {
    blocks: [Visit; MAX_VISITS],
    block_count: usize,
    /// [`BLOCK_TRIANGLES`] times an index into `blocks`, plus the index of a triangle in the block.
    triangles: [u32; MAX_VISITS * BLOCK_TRIANGLES],
    /// The lanes whose lines intersect each triangle.
    lanes: [u32; MAX_VISITS * BLOCK_TRIANGLES],
    count: usize,
    singles: Singles,
}

impl PacketLeafQueue {
    pub fn new() -> Self {
        let edges = Edges {
            sides: [[[0.0; BLOCK_TRIANGLES]; 3]; 3],
            margin: [0.0; BLOCK_TRIANGLES],
        };
        let nothing = Visit {
            edges,
            block: ptr::null(),
            packet: 0,
        };
        Self {
            blocks: [nothing; MAX_VISITS],
            block_count: 0,
            triangles: [0; MAX_VISITS * BLOCK_TRIANGLES],
            lanes: [0; MAX_VISITS * BLOCK_TRIANGLES],
            count: 0,
            singles: Singles::new(),
        }
    }

    #[inline(always)]
    pub fn clear(&mut self) {
        self.block_count = 0;
    }

    /// Adds the blocks of the leaf that a packet visits; at most one leaf per packet. If the
    /// packet's rays have no common origin, nothing can be shared between them, and the blocks are
    /// tested at once. Returns whether that shortened any ray.
    #[inline(always)]
    pub fn add<L: SimdLevel>(&mut self, level: L, id: usize, packet: &mut Packet, blocks: &[TriangleBlock]) -> bool {
        if !packet.shared {
            let mut nearer = false;
            for block in blocks {
                nearer |= packet.block(level, block);
            }
            return nearer;
        }
        for block in blocks {
            // Prefetched for a second time, since the block may have been evicted meanwhile.
            level.prefetch::<3>(ptr::from_ref(block).cast());
            let visit = &mut self.blocks[self.block_count % MAX_VISITS];
            (visit.block, visit.packet) = (block, id);
            self.block_count += 1;
        }
        false
    }

    /// Tests all blocks in the queue. Returns the set of packets that have rays which were
    /// shortened.
    ///
    /// # Safety
    /// The blocks in the queue still exist.
    #[inline(always)]
    pub unsafe fn test<L: SimdLevel>(&mut self, level: L, packets: &mut [Packet; PACKETS], rays: &[Ray]) -> u64 {
        // SAFETY: by this function's own contract.
        unsafe {
            self.cull(level, packets);
            self.filter(level, packets);
            self.intersect(level, packets, rays)
        }
    }

    /// Lists the triangles that may be hit.
    ///
    /// # Safety
    /// The contract is that of [`PacketLeafQueue::test`], here and in the passes that follow.
    #[inline(always)]
    unsafe fn cull<L: SimdLevel>(&mut self, level: L, packets: &[Packet; PACKETS]) {
        self.count = 0;
        for at in 0..self.block_count.min(MAX_VISITS) {
            let visit = &mut self.blocks[at];
            let packet = &packets[visit.packet % PACKETS];
            // SAFETY: by this function's own contract.
            let block = unsafe { &*visit.block };
            let (possible, covered) = packet.cull(level, block, &mut visit.edges);
            for k in 0..BLOCK_TRIANGLES {
                let next = self.count % (MAX_VISITS * BLOCK_TRIANGLES);
                self.triangles[next] = (at * BLOCK_TRIANGLES + k) as u32;
                self.lanes[next] = covered >> k & 1;
                self.count += (possible >> k & 1) as usize;
            }
        }
    }

    /// Keeps the triangles that the line of at least one ray intersects, and stores these lanes.
    #[inline(always)]
    unsafe fn filter<L: SimdLevel>(&mut self, level: L, packets: &[Packet; PACKETS]) {
        let possible = self.count;
        self.count = 0;
        for i in 0..possible {
            let triangle = self.triangles[i % (MAX_VISITS * BLOCK_TRIANGLES)];
            let (at, k) = place(triangle);
            let visit = &self.blocks[at];
            let packet = &packets[visit.packet % PACKETS];
            let lanes = if self.lanes[i % (MAX_VISITS * BLOCK_TRIANGLES)] == 0 {
                packet.may_pass(level, &visit.edges, k)
            } else {
                ALL
            };
            let at = self.count % (MAX_VISITS * BLOCK_TRIANGLES);
            (self.triangles[at], self.lanes[at]) = (triangle, lanes);
            self.count += usize::from(lanes != 0);
        }
    }

    /// Stores the hits on the listed triangles.
    #[inline(always)]
    unsafe fn intersect<L: SimdLevel>(&mut self, level: L, packets: &mut [Packet; PACKETS], rays: &[Ray]) -> u64 {
        let mut nearer = 0;
        let (mut loaded, mut origin_data) = (MAX_VISITS, OriginData::default());
        let mut next = 0;
        while next < self.count {
            self.singles.clear();
            while next < self.count && self.singles.has_room() {
                let i = next % (MAX_VISITS * BLOCK_TRIANGLES);
                next += 1;
                let lanes = self.lanes[i];
                let (at, k) = place(self.triangles[i]);
                let visit = &self.blocks[at];
                let id = visit.packet % PACKETS;
                let packet = &mut packets[id];
                // SAFETY: by this function's own contract.
                let block = unsafe { &*visit.block };
                if lanes.count_ones() < MIN_PACKET_LANES {
                    self.singles.add(id, packet, lanes, block, k);
                    continue;
                }
                if loaded != at {
                    loaded = at;
                    packet.origin_data(level, block, &mut origin_data);
                }
                let found = packet.shared_triangle(level, &origin_data, k, block.keys[k]);
                nearer |= u64::from(found) << id;
            }
            // SAFETY: by this function's own contract.
            nearer |= unsafe { self.singles.test(level, packets, rays) };
        }
        nearer
    }
}

/// Returns the block of a listed triangle, and its index in the block.
#[inline(always)]
fn place(triangle: u32) -> (usize, usize) {
    (
        triangle as usize / BLOCK_TRIANGLES % MAX_VISITS,
        triangle as usize % BLOCK_TRIANGLES,
    )
}

impl Packet {
    /// Returns the `rows` of a vertex in the order of the axes.
    #[inline(always)]
    fn permute_axes<'a, T>(&self, rows: &'a [T; 3]) -> [&'a T; 3] {
        let [x, y, z] = self.axes.map(usize::from);
        [&rows[x], &rows[y], &rows[z]]
    }

    /// Returns the vertices of a block's triangles relative to the rays' common origin, in the
    /// order of the axes.
    #[inline(always)]
    fn relative<L: SimdLevel>(&self, level: L, block: &TriangleBlock) -> [Vec3s<L::F4>; 3] {
        let [x, y, z] = self.permute_axes(self.origin.first_chunk().expect("there are four"));
        let o = [level.splat4(*x), level.splat4(*y), level.splat4(*z)];
        let [a, b, c] = &block.corners;
        [
            each(load3(level, self.permute_axes(a)), o, L::F4::sub),
            each(load3(level, self.permute_axes(b)), o, L::F4::sub),
            each(load3(level, self.permute_axes(c)), o, L::F4::sub),
        ]
    }

    /// Culls the triangles of a block for rays with a common origin. Returns the triangles that any
    /// ray may hit, and those that the lines of all rays intersect.
    ///
    /// An edge function is linear in a ray's shear, so over the bounds of all shears its extremes
    /// are in the corners. A triangle that is so far away that the edge functions overflow is hit
    /// by no ray: its coordinates are rounded so much that the distance to its plane is not a
    /// number.
    #[inline(always)]
    fn cull<L: SimdLevel>(&self, level: L, block: &TriangleBlock, edges: &mut Edges) -> (u32, u32) {
        let [a, b, c] = self.relative(level, block);
        // Near the middle of the packet the shears are small, and so are the rounding errors of
        // products with them.
        let back = [level.splat4(-self.middle[0]), level.splat4(-self.middle[1])];
        let (a, b, c) = (flat(a, back), flat(b, back), flat(c, back));
        let mut sides = [side(c, b), side(a, c), side(b, a)];
        let half = [level.splat4(self.half[0]), level.splat4(self.half[1])];
        let [u, v, w] = [range(sides[0], half), range(sides[1], half), range(sides[2], half)];
        for side in &mut sides {
            side[2] = passed(*side, back);
        }
        for (to, from) in edges.sides.iter_mut().zip(&sides) {
            *to = [from[0].to_array(), from[1].to_array(), from[2].to_array()];
        }
        let wide = |p: Vec3s<L::F4>| p[0].abs().max(p[1].abs());
        let wide = wide(a).max(wide(b)).max(wide(c));
        let reach = a[2].abs().max(b[2].abs()).max(c[2].abs()).add(wide);
        let wide = reach.mul(half[0].max(half[1])).add(wide);
        let margin = reach.mul(wide).mul(level.splat4(MARGIN)).max(level.splat4(MIN_MARGIN));
        edges.margin = margin.to_array();
        let zero = level.splat4(0.0);
        let front = zero.le(u.1.min(v.1).min(w.1).add(margin));
        let back = u.0.max(v.0).max(w.0).le(margin);
        let in_front = margin.le(u.0.min(v.0).min(w.0));
        let behind = u.1.max(v.1).max(w.1).add(margin).le(zero);
        (front.or(back).bits(), in_front.or(behind).bits())
    }

    /// Returns the lanes whose lines may intersect a triangle, for a common origin.
    #[inline(always)]
    fn may_pass<L: SimdLevel>(&self, level: L, edges: &Edges, k: usize) -> u32 {
        let shear = [level.load16(&self.shear[0].0), level.load16(&self.shear[1].0)];
        let [u, v, w] = edges.sides.each_ref();
        let u = passed(spread(level, u.each_ref(), k), shear);
        let v = passed(spread(level, v.each_ref(), k), shear);
        let w = passed(spread(level, w.each_ref(), k), shear);
        let margin = edges.margin[k];
        let front = level.splat16(-margin).le(u.min(v).min(w));
        let back = u.max(v).max(w).le(level.splat16(margin));
        front.or(back).bits()
    }

    /// Tests the triangles of a block. Returns whether one of them is hit.
    #[inline(always)]
    fn block<L: SimdLevel>(&mut self, level: L, block: &TriangleBlock) -> bool {
        let o = load16s(level, &self.o);
        let [x, y, z] = self.permute_axes(&o);
        let turned = [*x, *y, *z];
        let [a, b, c] = &block.corners;
        let mut met = false;
        let mut triangles = self.in_the_way(level, block);
        while triangles != 0 {
            let k = triangles.trailing_zeros() as usize % BLOCK_TRIANGLES;
            triangles &= triangles - 1;
            let corners = [
                each(spread(level, self.permute_axes(a), k), turned, L::F16::sub),
                each(spread(level, self.permute_axes(b), k), turned, L::F16::sub),
                each(spread(level, self.permute_axes(c), k), turned, L::F16::sub),
            ];
            let negative = self.state.negative();
            let faces = || {
                let world = [
                    spread(level, a.each_ref(), k),
                    spread(level, b.each_ref(), k),
                    spread(level, c.each_ref(), k),
                ];
                faces(&o, negative, &world)
            };
            met |= self.triangle(level, &corners, || plane(&corners), faces, block.keys[k]);
        }
        met
    }

    /// Returns the set of a block's triangles that must be tested. With vectors of sixteen floats,
    /// testing a triangle takes no longer than culling its bounds.
    #[inline(always)]
    fn in_the_way<L: SimdLevel>(&self, level: L, block: &TriangleBlock) -> u32 {
        let [a, b, c] = block.corners.each_ref();
        let corners = [
            load3(level, a.each_ref()),
            load3(level, b.each_ref()),
            load3(level, c.each_ref()),
        ];
        let first = corners[0][0];
        let mut asked = first.eq(first);
        if !L::SIXTEEN {
            asked = asked.and(self.state.meets(&boxes(&corners), &self.inv_far));
        }
        asked.bits() & 0b1111
    }

    /// Computes the direction-independent data of a block for a common origin.
    #[inline(always)]
    fn origin_data<L: SimdLevel>(&self, level: L, block: &TriangleBlock, origin_data: &mut OriginData) {
        let corners = self.relative(level, block);
        let plane = plane(&corners);
        let [a, b, c] = &block.corners;
        let [x, y, z, _] = self.origin;
        let o = [level.splat4(x), level.splat4(y), level.splat4(z)];
        let world = [
            load3(level, a.each_ref()),
            load3(level, b.each_ref()),
            load3(level, c.each_ref()),
        ];
        let faces = faces(&o, self.state.negative(), &world);
        origin_data.corners = [arrays(corners[0]), arrays(corners[1]), arrays(corners[2])];
        origin_data.normal = arrays(plane.normal);
        origin_data.distance = plane.distance.to_array();
        origin_data.near = arrays(faces.near);
        origin_data.far = arrays(faces.far);
    }

    /// Stores the nearer hits on a triangle of such a block. Returns whether there are any.
    #[inline(always)]
    fn shared_triangle<L: SimdLevel>(&mut self, level: L, origin_data: &OriginData, k: usize, key: u32) -> bool {
        let [a, b, c] = origin_data.corners.each_ref();
        let corners = [
            spread(level, a.each_ref(), k),
            spread(level, b.each_ref(), k),
            spread(level, c.each_ref(), k),
        ];
        let plane = || TrianglePlane {
            normal: spread(level, origin_data.normal.each_ref(), k),
            distance: level.splat16(origin_data.distance[k]),
        };
        let faces = || Faces {
            near: spread(level, origin_data.near.each_ref(), k),
            far: spread(level, origin_data.far.each_ref(), k),
        };
        self.triangle(level, &corners, plane, faces, key)
    }

    /// Stores the nearer hits on a triangle. Returns whether there are any.
    #[inline(always)]
    fn triangle<L: SimdLevel>(
        &mut self,
        level: L,
        corners: &[Vec3s<L::F16>; 3],
        plane: impl FnOnce() -> TrianglePlane<L::F16>,
        faces: impl FnOnce() -> Faces<L::F16>,
        key: u32,
    ) -> bool {
        let sides = sides(
            corners,
            [level.load16(&self.shear[0].0), level.load16(&self.shear[1].0)],
        );
        // A line that passes the edge tests nearly always has a hit here, since all predictable
        // misses are culled before.
        if !self.shared && sides.inside.bits() == 0 {
            return false;
        }
        let (begin, until) = (level.load16(&self.begin.0), level.load16(&self.until.0));
        let candidates = candidates(load16s(level, &self.d), &plane(), sides, begin, until);
        if candidates.mask.bits() == 0 {
            return false;
        }
        let meets = meet(stretch(&load16s(level, &self.inv), &faces()), &candidates.crossing);
        let t = level.load16(&self.t.0);
        let begun = level.load16(&self.tmins.0).lt(meets.t);
        let valid = candidates.mask.and(meets.valid).and(begun);
        let mut nearer = valid.and(meets.t.lt(t));
        let equal = valid.and(meets.t.eq(t)).bits();
        if equal != 0 {
            nearer = nearer.or(level.mask16(self.wins(equal, key)));
        }
        self.t.0 = meets.t.select(nearer, t).to_array();
        self.u.0 = meets.u.select(nearer, level.load16(&self.u.0)).to_array();
        self.v.0 = meets.v.select(nearer, level.load16(&self.v.0)).to_array();
        let keys = level.splat16(f32::from_bits(key));
        self.key.0 = keys.select(nearer, level.load16(&self.key.0)).to_array();
        true
    }

    /// Returns the `equal` hits whose key is lower than that of the current hit.
    #[cold]
    #[inline(never)]
    fn wins(&self, equal: u32, key: u32) -> u32 {
        let wins = (0..self.key.0.len()).filter(|&k| equal >> k & 1 == 1 && key < self.key.0[k].to_bits());
        wins.fold(0, |bits, k| bits | 1 << k)
    }
}

/// Broadcasts three numbers of triangle `k` of a block to all rays.
#[inline(always)]
fn arrays<F: Floats<Array = [f32; 4]>>(v: Vec3s<F>) -> [[f32; 4]; 3] {
    [v[0].to_array(), v[1].to_array(), v[2].to_array()]
}
