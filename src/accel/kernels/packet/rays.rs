//! The rays of a packet and their bounds.

use super::order::PacketRays;
use crate::{
    accel::kernels::{
        query::{Best, NOTHING, Nearest, Query},
        ray_state::BEYOND,
        ray16::{RAYS, Ray16, Sorted},
        traversal_state::TraversalState,
        triangle::{Vec3s, each},
    },
    geometry::{
        Hit, InstanceId,
        slab::{END_PADDING, MIN_PADDING, ORIGIN_PADDING},
    },
    math::Ray,
    shape::triangle::Shear,
    simd::lanes::{Floats, SimdLevel},
};

/// A number per ray.
#[repr(C, align(64))]
#[derive(Clone, Copy, Default)]
pub struct Each(pub [f32; RAYS]);

#[inline(always)]
pub fn load16s<L: SimdLevel>(level: L, v: &[Each; 3]) -> Vec3s<L::F16> {
    [level.load16(&v[0].0), level.load16(&v[1].0), level.load16(&v[2].0)]
}

/// The number of active packets. They hide each other's latency; more of them would not fit into
/// the L1 cache.
pub const PACKETS: usize = 32;

/// An active packet. The bounds of its rays come first, in two cache lines. The bounds enter a box
/// no later, and leave it no earlier, than any of the rays. They reach a plane `x = b` at the
/// distances `b * inv + near` and `b * inv_far + far` along the main axis.
#[repr(C, align(64))]
#[derive(Clone, Default)]
pub struct Packet {
    /// The start and the end are distances along the main axis, the minimum and the maximum over
    /// all rays. The reciprocals are the smallest in magnitude; they belong to the entry distance.
    pub state: TraversalState,
    /// The reciprocals that are largest in magnitude, for the exit distance; the fourth element is
    /// unused.
    pub inv_far: [f32; 4],
    /// Whether all rays have a common origin.
    pub shared: bool,
    /// The order of the axes, which is the same for all rays; see [`Shear`]. Each is below three.
    pub axes: [u8; 3],
    /// The origin of the first ray.
    pub origin: [f32; 4],
    /// The shears of all rays are within `half` of `middle`.
    pub middle: [f32; 2],
    pub half: [f32; 2],
    /// In the order of [`Packet::axes`].
    pub d: [Each; 3],
    pub shear: [Each; 2],
    pub begin: Each,
    pub until: Each,
    /// The nearest hits so far; keys are stored as bits.
    pub t: Each,
    pub u: Each,
    pub v: Each,
    pub key: Each,
    pub tmins: Each,
    /// The offset of each ray's origin along the main axis, relative to the foremost one; zero or
    /// negative.
    behind: Each,
    /// In the order of the world's axes.
    pub o: [Each; 3],
    pub inv: [Each; 3],
    list: [u32; RAYS],
    count: usize,
}

/// The largest distance between the origin of a packet's first ray and the others, relative to the
/// scene's extent.
const MAX_ORIGIN_DISTANCE: f32 = 0.1;

/// The factor by which chords extend beyond the rays' ends, and the smallest extension relative to
/// the coordinates.
const CHORD_REACH: f32 = 1.0 + 1e-4;
const MIN_CHORD_REACH: f32 = 1e-7;

/// A bound on the error of the distance to a plane, relative to its terms.
const BLUR: f32 = 8.0 * f32::EPSILON;

/// The rays of a list that form a packet.
pub enum Gathered {
    All,
    /// The lanes that form a packet, and those that must be traced on their own.
    Some {
        together: u32,
        alone: u32,
    },
}

impl Packet {
    /// Loads the rays of `list`, either all or none.
    #[inline(always)]
    pub fn gather<L: SimdLevel>(
        &mut self,
        level: L,
        rays: &[Ray],
        list: &PacketRays,
        hits: &[Option<Hit>],
        reach: f32,
    ) -> Gathered {
        let sixteen = Ray16::load(level, rays, &list.ids);
        let Sorted {
            ordinary, alike, below, ..
        } = sixteen.sort(reach);
        let Ray16 { o, d, inv, tmin, tmax } = sixteen;
        if ordinary & alike & 0xffff != 0xffff {
            return Gathered::Some {
                together: ordinary & alike & list.lanes(),
                alone: !ordinary & list.lanes(),
            };
        }
        let ray = &rays[list.ids[0] as usize];
        self.origin = [ray.o.x, ray.o.y, ray.o.z, 0.0];
        let first = [
            level.splat16(self.origin[0]),
            level.splat16(self.origin[1]),
            level.splat16(self.origin[2]),
        ];
        let [x, y, z] = each(o, first, L::F16::sub);
        let apart = x.abs().max(y.abs()).max(z.abs()).reduce_max();
        if apart > MAX_ORIGIN_DISTANCE * reach {
            return Gathered::Some {
                together: 0,
                alone: list.lanes(),
            };
        }
        self.shared = apart == 0.0;
        let [x, y, z] = below;
        self.state.set_octant(x & 1 | y & 2 | z & 4);
        self.aim(&d, &inv, Shear::new(&ray.d).axes);
        let speed = level.load16(&self.d[2].0).abs();
        self.enclose([&o, &d, &inv], tmax, speed, reach);
        self.state.stack.clear();
        self.list = list.ids;
        self.count = list.len;
        self.tmins.0 = tmin.to_array();
        self.state.tmin = tmin.mul_sub(speed, level.load16(&self.behind.0)).reduce_min();
        self.begin.0 = tmin.mul(level.splat16(1.0 - BEYOND)).to_array();
        self.t.0 = tmax.to_array();
        self.u = Each([0.0; RAYS]);
        self.v = Each([0.0; RAYS]);
        self.key = Each([f32::from_bits(NOTHING); RAYS]);
        if list.ids.iter().any(|&id| hits[id as usize].is_some()) {
            self.recall(rays, hits);
        }
        self.set_ends(level);
        Gathered::All
    }

    /// Stores the lines and their common bounds; `speed` is the rays' speed along the main axis.
    ///
    /// Distances are measured along the main axis, so that adjacent rays reach a box at the same
    /// distance, wherever they start. The minimum of the distances to a plane is a concave function
    /// of the plane's position. So it lies above its chord between the start of the first ray and
    /// the end of the last one; no box beyond these is hit. The maximum is convex and lies below
    /// its chord.
    #[inline(always)]
    fn enclose<F: Floats<Array = [f32; RAYS]>>(&mut self, [o, d, inv]: [&Vec3s<F>; 3], tmax: F, speed: F, reach: f32) {
        for axis in 0..3 {
            self.o[axis].0 = o[axis].to_array();
            self.inv[axis].0 = inv[axis].to_array();
        }
        let [x, y, main] = self.axes.map(usize::from);
        let negative = self.state.negative();
        let start = self.first(o, main);
        let sign = if negative[main] { -1.0 } else { 1.0 };
        let behind = speed.fill(start).sub(o[main]).mul(speed.fill(sign));
        self.behind.0 = behind.to_array();
        let most = if self.shared { 0.0 } else { -behind.reduce_min() };
        self.set_line(main, start, [0.0, 1.0, 0.0, 1.0]);
        for axis in [x, y] {
            let from = self.first(o, axis);
            let per = inv[axis].mul(speed).abs();
            if self.shared {
                self.set_line(axis, from, [0.0, per.reduce_min(), 0.0, per.reduce_max()]);
                continue;
            }
            let ends = tmax.mul(d[axis]).add(o[axis]);
            let way = if negative[axis] {
                from - ends.reduce_min().max(-reach)
            } else {
                ends.reduce_max().min(reach) - from
            };
            let way = (way * CHORD_REACH).max((from.abs() + reach) * MIN_CHORD_REACH);
            let begin = o[axis].sub(speed.fill(from)).abs().mul(per).add(behind);
            let begin = speed.fill(0.0).sub(begin);
            let end = speed.fill(way).mul(per).add(begin);
            let (first, last) = (begin.reduce_min(), begin.reduce_max());
            let blur = (2.0 * most - first) * BLUR;
            let (first, last) = (first - blur, last + blur);
            let slope = |rise: f32| rise.max(0.0) / way;
            let (near, far) = (
                slope(end.reduce_min() - blur - first),
                slope(end.reduce_max() + blur - last),
            );
            self.set_line(axis, from, [first, near, last, far]);
        }
    }

    /// Returns the smallest coordinate in the direction of the rays.
    #[inline(always)]
    fn first<F: Floats>(&self, o: &Vec3s<F>, axis: usize) -> f32 {
        if self.shared {
            self.origin[axis]
        } else if self.state.negative()[axis] {
            o[axis].reduce_max()
        } else {
            o[axis].reduce_min()
        }
    }

    /// Sets the distances at which the rays reach planes across an axis: the value at `from` and
    /// the slope, for the first ray that reaches the plane and for the last one.
    #[inline(always)]
    fn set_line(&mut self, axis: usize, from: f32, [first, near, last, far]: [f32; 4]) {
        let sign = if self.state.negative()[axis] { -1.0 } else { 1.0 };
        let (from, pad) = (from * sign, from.abs() * (2.0 * ORIGIN_PADDING) + 4.0 * MIN_PADDING);
        (self.state.inv[axis], self.state.near[axis]) = (sign * near, first - (from + pad) * near);
        (self.inv_far[axis], self.state.far[axis]) = (sign * far, last - (from - pad) * far);
    }

    /// Stores the directions and the shears.
    #[inline(always)]
    fn aim<F: Floats<Array = [f32; RAYS]>>(&mut self, d: &Vec3s<F>, inv: &Vec3s<F>, axes: [usize; 3]) {
        self.axes = axes.map(|axis| axis as u8);
        for (k, &axis) in axes.iter().enumerate() {
            self.d[k].0 = d[axis].to_array();
        }
        for (k, &axis) in axes.iter().take(2).enumerate() {
            let shear = d[axis].mul(inv[axes[2]]);
            self.shear[k].0 = shear.to_array();
            let (low, high) = (shear.reduce_min(), shear.reduce_max());
            self.middle[k] = (low + high) * 0.5;
            self.half[k] = (high - self.middle[k]).max(self.middle[k] - low) * (1.0 + 4.0 * f32::EPSILON);
        }
    }

    /// Loads the earlier results.
    #[cold]
    #[inline(never)]
    fn recall(&mut self, rays: &[Ray], hits: &[Option<Hit>]) {
        for (k, &id) in self.list.iter().enumerate() {
            let tmax = rays[id as usize].tmax;
            let known = Best::of(&hits[id as usize], tmax);
            (self.t.0[k], self.u.0[k], self.v.0[k]) = (known.t, known.u, known.v);
            self.key.0[k] = f32::from_bits(known.key);
        }
    }

    /// Updates the bounds after `t` has changed.
    #[inline(always)]
    pub fn set_ends<L: SimdLevel>(&mut self, level: L) {
        let t = level.load16(&self.t.0);
        self.until.0 = t.add(t.abs().mul(level.splat16(BEYOND))).to_array();
        let speed = level.load16(&self.d[2].0).abs();
        self.state.end = t.mul_sub(speed, level.load16(&self.behind.0)).reduce_max() * END_PADDING;
    }

    /// Writes the results to `hits`.
    #[inline(always)]
    pub fn scatter(&self, hits: &mut [Option<Hit>]) {
        for (k, &id) in self.rays().iter().enumerate() {
            hits[id as usize] = Nearest::end(
                &Best {
                    t: self.t.0[k],
                    u: self.u.0[k],
                    v: self.v.0[k],
                    key: self.key.0[k].to_bits(),
                },
                InstanceId::NONE,
            );
        }
    }

    /// Returns the indices of the packet's rays.
    pub fn rays(&self) -> &[u32] {
        &self.list[..self.count]
    }

    /// Returns the set of lanes that have a ray; the others have an arbitrary one of the batch.
    pub fn used(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// Returns the index of the ray in a lane.
    #[inline(always)]
    pub fn ray(&self, lane: usize) -> u32 {
        self.list[lane % RAYS]
    }

    /// Returns a key that is equal for packets with the same order of axes and the same octant.
    #[inline(always)]
    pub fn way(&self) -> u32 {
        let [x, y, z] = self.axes;
        u32::from_le_bytes([x, y, z, self.state.octant()[0] as u8])
    }
}
