//! Sixteen rays together: the kernel for rays that leave one place in nearly one direction, as camera rays do.
//!
//! A node is tested once for all of them, with intervals of their origins and reciprocals, eight boxes at a time. Of the
//! children that pass, each is tested exactly, one box and sixteen rays, before the packet descends: without this
//! second test packets visit much that none of their rays meets. A triangle is tested with sixteen rays.
//!
//! Rays of different octants, with a component of nearly zero or with a negative `tmin` are left to the other kernel.

use super::{
    super::{
        Geometry, Hit, Instance, PrimRef,
        slab::{END, FAR, LEAVE, PAD, STEEPEST, TINY},
        wide::node::{Block, EMPTY, LEAF, Node, SHAPE, blocks},
    },
    inflight::{Scratch, load3},
    lanes::{Floats, Level, Mask, Top},
    query::{Best, NOTHING, Nearest, Query},
    slot::BEYOND,
    tree::Tree,
    triangle::{Line, Plane, Sides, Vec3s, candidates, each, meet, plane, sides},
};
use crate::{math::Ray, shape::triangle::Shear};

/// Rays in a packet.
pub const RAYS: usize = 16;

/// The numbers of rays in arrays: origin, `tmin`, direction, `tmax`.
#[repr(C, align(64))]
struct Transposed([[f32; RAYS]; 8]);

struct Packet<L: Level> {
    line: Line<L::F16>,
    /// See [`crate::shape::triangle::Shear`]: the directions in the order of the axes, which is the same for all rays.
    axes: [usize; 3],
    d: Vec3s<L::F16>,
    shear: [L::F16; 2],
    shift_near: Vec3s<L::F16>,
    shift_far: Vec3s<L::F16>,
    tmin: L::F16,
    /// See [`super::slot::Slot`].
    begin: L::F16,
    until: L::F16,
    /// The nearest hits so far; the numbers of primitives as bits.
    t: L::F16,
    u: L::F16,
    v: L::F16,
    id: L::F16,
    /// What is farther is passed over, by a ray and by all.
    end: L::F16,
    last_end: f32,
    bounds: Bounds<L>,
    /// The first ray's origin, and whether it is that of all.
    origin: [f32; 3],
    shared: bool,
}

/// What encloses the rays of a packet, for tests of eight boxes.
struct Bounds<L: Level> {
    /// The origins' extremes that come nearest to a plane which is entered, or left, through.
    near: Vec3s<L::F8>,
    far: Vec3s<L::F8>,
    least_inv: Vec3s<L::F8>,
    most_inv: Vec3s<L::F8>,
    tmin: L::F8,
}

/// Finds the nearest hits of all rays, if nearer than what `hits` has for them; puts the numbers of the rays that make
/// no packet into `left`.
#[inline(always)]
pub fn trace<L: Level>(
    level: L,
    tree: &Tree,
    geometry: &Geometry,
    rays: &[Ray],
    hits: &mut [Option<Hit>],
    scratch: &mut Scratch,
    left: &mut Vec<u32>,
) {
    let (enter, child) = scratch.stack(tree);
    for first in (0..rays.len()).step_by(RAYS) {
        let last = (first + RAYS).min(rays.len());
        let (rays, hits) = (&rays[first..last], &mut hits[first..last]);
        match Packet::gather(level, rays, hits, tree.spread.reach) {
            None => left.extend(first as u32..last as u32),
            Some(mut packet) => {
                packet.descend(level, tree, geometry, rays, enter, child);
                packet.scatter(hits);
            }
        }
    }
}

impl<L: Level> Packet<L> {
    /// `None` where the rays make no packet. Where they are fewer than sixteen the last one is repeated.
    #[inline(always)]
    fn gather(level: L, rays: &[Ray], hits: &[Option<Hit>], reach: f32) -> Option<Self> {
        let mut soa = Transposed([[0.0; RAYS]; 8]);
        let mut best = Transposed([[0.0; RAYS]; 8]);
        for k in 0..RAYS {
            let i = k.min(rays.len() - 1);
            let ray = &rays[i];
            let numbers = [ray.o.x, ray.o.y, ray.o.z, ray.tmin, ray.d.x, ray.d.y, ray.d.z];
            for (array, number) in soa.0.iter_mut().zip(numbers) {
                array[k] = number;
            }
            let known = Nearest::begin(&hits[i], ray.tmax).unwrap_or(Best::none(ray.tmax));
            let numbers = [known.t, known.u, known.v, f32::from_bits(known.id)];
            for (array, number) in best.0.iter_mut().zip(numbers) {
                array[k] = number;
            }
        }
        let o = [
            level.load16(&soa.0[0]),
            level.load16(&soa.0[1]),
            level.load16(&soa.0[2]),
        ];
        let d = [
            level.load16(&soa.0[4]),
            level.load16(&soa.0[5]),
            level.load16(&soa.0[6]),
        ];
        let tmin = level.load16(&soa.0[3]);
        let t = level.load16(&best.0[0]);

        let zero = level.splat16(0.0);
        let most = level.splat16(f32::MAX);
        let length = [d[0].abs(), d[1].abs(), d[2].abs()];
        let steep = length[0]
            .max(length[1])
            .max(length[2])
            .mul(level.splat16(2.0 / STEEPEST));
        let one = level.splat16(1.0);
        let inv = [one.div(d[0]), one.div(d[1]), one.div(d[2])];
        let mut ordinary = zero.le(tmin);
        let mut shared = true;
        let mut negative = [false; 3];
        let (mut shift_near, mut shift_far) = (inv, inv);
        let (mut near, mut far) = ([level.splat8(0.0); 3], [level.splat8(0.0); 3]);
        let (mut least_inv, mut most_inv) = (near, far);
        for axis in 0..3 {
            shared &= o[axis].eq(level.splat16(soa.0[axis][0])).bits() == 0xffff;
            let below = d[axis].lt(zero).bits();
            if below != 0 && below != 0xffff {
                return None;
            }
            negative[axis] = below != 0;
            let pad = o[axis].abs().mul(level.splat16(PAD)).add(level.splat16(4.0 * TINY));
            let (less, more) = (o[axis].sub(pad), o[axis].add(pad));
            let (forward, back) = if negative[axis] { (less, more) } else { (more, less) };
            shift_near[axis] = forward.mul(inv[axis]);
            shift_far[axis] = back.mul(inv[axis]);
            let (lowest, highest) = (level.splat8(less.lowest()), level.splat8(more.highest()));
            (near[axis], far[axis]) = if negative[axis] {
                (lowest, highest)
            } else {
                (highest, lowest)
            };
            (least_inv[axis], most_inv[axis]) = (level.splat8(inv[axis].lowest()), level.splat8(inv[axis].highest()));
            let finite = o[axis]
                .abs()
                .le(level.splat16(FAR * reach))
                .and(length[axis].le(most))
                .and(shift_near[axis].abs().le(most));
            ordinary = ordinary
                .and(finite)
                .and(shift_far[axis].abs().le(most))
                .and(steep.lt(length[axis]));
        }
        if ordinary.bits() != 0xffff {
            return None;
        }
        // The main axis, by the comparisons of [`Shear::new`].
        let first = length[1].lt(length[0]).and(length[2].lt(length[0])).bits();
        let second = length[2].lt(length[1]).bits() & !first;
        let axes = Shear::new(&rays[0].d).axes;
        if (first, second) != [(0, 0), (0xffff, 0), (0, 0xffff)][(axes[2] + 1) % 3] {
            return None;
        }
        let end = t.mul(level.splat16(END));
        Some(Self {
            line: Line { o, inv, negative },
            axes,
            d: [d[axes[0]], d[axes[1]], d[axes[2]]],
            shear: [d[axes[0]].mul(inv[axes[2]]), d[axes[1]].mul(inv[axes[2]])],
            shift_near,
            shift_far,
            tmin,
            begin: tmin.mul(level.splat16(1.0 - BEYOND)),
            until: t.add(t.abs().mul(level.splat16(BEYOND))),
            t,
            u: level.load16(&best.0[1]),
            v: level.load16(&best.0[2]),
            id: level.load16(&best.0[3]),
            end,
            last_end: end.highest(),
            bounds: Bounds {
                near,
                far,
                least_inv,
                most_inv,
                tmin: level.splat8(tmin.lowest()),
            },
            origin: [soa.0[0][0], soa.0[1][0], soa.0[2][0]],
            shared,
        })
    }

    /// Writes the hits of as many rays as there were.
    #[inline(always)]
    fn scatter(&self, hits: &mut [Option<Hit>]) {
        let (t, u, v, id) = (
            self.t.to_array(),
            self.u.to_array(),
            self.v.to_array(),
            self.id.to_array(),
        );
        for (k, hit) in hits.iter_mut().enumerate().take(RAYS) {
            *hit = Nearest::end(
                &Best {
                    t: t[k],
                    u: u[k],
                    v: v[k],
                    id: id[k].to_bits(),
                },
                Instance::NONE,
            );
        }
    }

    /// Goes through the tree. What waits on the stack is a node's number times eight and a lane.
    #[inline(always)]
    fn descend(
        &mut self,
        level: L,
        tree: &Tree,
        geometry: &Geometry,
        rays: &[Ray],
        enter: &mut [f32],
        child: &mut [u32],
    ) {
        let octant = 3
            * (0..3)
                .map(|axis| u32::from(self.line.negative[axis]) << axis)
                .sum::<u32>();
        let mut waiting = 0;
        let mut current = tree.root();
        loop {
            // SAFETY: a root, or an inner child.
            let node = unsafe { tree.node(current) };
            let (near, far) = self.interval(level, node);
            let lanes = [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| current << 3 | lane);
            let to = Top {
                enter: enter[waiting..]
                    .first_chunk_mut()
                    .expect("a stack has room for all that may wait"),
                child: child[waiting..]
                    .first_chunk_mut()
                    .expect("a stack has room for all that may wait"),
            };
            let pushed = level.push_ordered(near, far, &lanes, &node.order, octant, to);
            for &entry in &child[waiting..waiting + pushed] {
                level.prefetch::<3>(tree.address(node.child[entry as usize & 7]));
            }
            waiting += pushed;
            current = loop {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                if enter[waiting] > self.last_end {
                    continue;
                }
                let (number, lane) = (child[waiting] >> 3, child[waiting] as usize & 7);
                // SAFETY: what waits was pushed above, with the number of a node.
                let node = unsafe { tree.node(number) };
                let meets = self.meets(level, node, lane);
                let next = node.child[lane];
                if meets.bits() == 0 || next == EMPTY {
                    continue;
                }
                if next & LEAF == 0 {
                    break next;
                }
                if next & SHAPE != 0 {
                    self.shape(level, geometry, rays, next & !(LEAF | SHAPE), meets.bits());
                } else {
                    for index in blocks(next) {
                        // SAFETY: a leaf of a node of this tree.
                        let block = unsafe { tree.block(index) };
                        if self.shared {
                            self.seen_block(level, block, meets);
                        } else {
                            self.block(level, block, meets);
                        }
                    }
                }
            };
        }
    }

    /// Bounds on where the rays enter a node's boxes and leave them.
    #[inline(always)]
    fn interval(&self, level: L, node: &Node) -> (L::F8, L::F8) {
        let mut enter = self.bounds.tmin;
        let mut leave = level.splat8(self.last_end);
        for axis in 0..3 {
            let side = usize::from(self.line.negative[axis]);
            let (least, most) = (self.bounds.least_inv[axis], self.bounds.most_inv[axis]);
            let near = level.load8(&node.planes[2 * axis + side]).sub(self.bounds.near[axis]);
            let far = level
                .load8(&node.planes[2 * axis + (side ^ 1)])
                .sub(self.bounds.far[axis]);
            enter = near.mul(least).min(near.mul(most)).max(enter);
            leave = far.mul(least).max(far.mul(most)).min(leave);
        }
        (enter, leave.mul(level.splat8(LEAVE)))
    }

    /// Which rays may meet one of a node's boxes.
    #[inline(always)]
    fn meets(&self, level: L, node: &Node, lane: usize) -> <L::F16 as Floats>::Mask {
        let mut enter = self.tmin;
        let mut leave = self.end;
        for axis in 0..3 {
            let side = usize::from(self.line.negative[axis]);
            let inv = self.line.inv[axis];
            let near = level
                .splat16(node.planes[2 * axis + side][lane])
                .mul_sub(inv, self.shift_near[axis]);
            let far = level
                .splat16(node.planes[2 * axis + (side ^ 1)][lane])
                .mul_sub(inv, self.shift_far[axis]);
            enter = near.max(enter);
            leave = far.min(leave);
        }
        enter.le(leave.mul(level.splat16(LEAVE)))
    }

    /// Tests the triangles of a block where all rays see them from one place: for the most part once for all rays.
    #[inline(always)]
    fn seen_block(&mut self, level: L, block: &Block, asked: <L::F16 as Floats>::Mask) {
        let [x, y, z] = self.axes;
        let o = [
            level.splat4(self.origin[x]),
            level.splat4(self.origin[y]),
            level.splat4(self.origin[z]),
        ];
        let [a, b, c] = &block.corners;
        let corners = [
            each(load3(level, [&a[x], &a[y], &a[z]]), o, L::F4::sub),
            each(load3(level, [&b[x], &b[y], &b[z]]), o, L::F4::sub),
            each(load3(level, [&c[x], &c[y], &c[z]]), o, L::F4::sub),
        ];
        let planes = plane(&corners);
        let (normals, distances) = (arrays(planes.normal), planes.distance.to_array());
        let [a, b, c] = [arrays(corners[0]), arrays(corners[1]), arrays(corners[2])];
        for (k, &distance) in distances.iter().enumerate() {
            if block.ids[k] == NOTHING {
                break;
            }
            let corners = [
                spread(level, a.each_ref(), k),
                spread(level, b.each_ref(), k),
                spread(level, c.each_ref(), k),
            ];
            let sides = sides(&corners, self.shear);
            if sides.inside.and(asked).bits() != 0 {
                let plane = Plane {
                    normal: spread(level, normals.each_ref(), k),
                    distance: level.splat16(distance),
                };
                self.triangle(level, &plane, sides, block, k, asked);
            }
        }
    }

    /// Tests the triangles of a block.
    #[inline(always)]
    fn block(&mut self, level: L, block: &Block, asked: <L::F16 as Floats>::Mask) {
        let [x, y, z] = self.axes;
        let o = [self.line.o[x], self.line.o[y], self.line.o[z]];
        let [a, b, c] = &block.corners;
        for k in 0..4 {
            if block.ids[k] == NOTHING {
                break;
            }
            let corners = [
                each(spread(level, [&a[x], &a[y], &a[z]], k), o, L::F16::sub),
                each(spread(level, [&b[x], &b[y], &b[z]], k), o, L::F16::sub),
                each(spread(level, [&c[x], &c[y], &c[z]], k), o, L::F16::sub),
            ];
            let sides = sides(&corners, self.shear);
            if sides.inside.and(asked).bits() != 0 {
                self.triangle(level, &plane(&corners), sides, block, k, asked);
            }
        }
    }

    #[inline(always)]
    fn triangle(
        &mut self,
        level: L,
        plane: &Plane<L::F16>,
        sides: Sides<L::F16>,
        block: &Block,
        k: usize,
        asked: <L::F16 as Floats>::Mask,
    ) {
        let candidates = candidates(self.d, plane, sides, self.begin, self.until);
        if candidates.mask.and(asked).bits() == 0 {
            return;
        }
        let [a, b, c] = &block.corners;
        let corners = &[
            spread(level, a.each_ref(), k),
            spread(level, b.each_ref(), k),
            spread(level, c.each_ref(), k),
        ];
        let id = block.ids[k];
        let meets = meet(&self.line, corners, &candidates);
        let valid = meets.valid.and(asked).and(self.tmin.lt(meets.t));
        let mut nearer = valid.and(meets.t.lt(self.t));
        let equal = valid.and(meets.t.eq(self.t)).bits();
        if equal != 0 {
            let ids = self.id.to_array();
            let wins = (0..RAYS).filter(|&k| equal >> k & 1 == 1 && id < ids[k].to_bits());
            nearer = nearer.or(level.mask16(wins.fold(0, |bits, k| bits | 1 << k)));
        }
        if nearer.bits() == 0 {
            return;
        }
        self.t = meets.t.select(nearer, self.t);
        self.u = meets.u.select(nearer, self.u);
        self.v = meets.v.select(nearer, self.v);
        self.id = level.splat16(f32::from_bits(id)).select(nearer, self.id);
        self.set_ends(level);
    }

    /// After `t` has changed.
    #[inline(always)]
    fn set_ends(&mut self, level: L) {
        self.until = self.t.add(self.t.abs().mul(level.splat16(BEYOND)));
        self.end = self.t.mul(level.splat16(END));
        self.last_end = self.end.highest();
    }

    /// Tests an analytic primitive with those rays whose bits are set.
    #[inline(always)]
    fn shape(&mut self, level: L, geometry: &Geometry, rays: &[Ray], index: u32, asked: u32) {
        let mut best = [
            self.t.to_array(),
            self.u.to_array(),
            self.v.to_array(),
            self.id.to_array(),
        ];
        shape(&mut best, geometry, rays, index, asked);
        let [t, u, v, id] = &best;
        (self.t, self.u) = (level.load16(t), level.load16(u));
        (self.v, self.id) = (level.load16(v), level.load16(id));
        self.set_ends(level);
    }
}

/// Tests an analytic primitive by its scalar routine; apart from the kernel, so that none of its vectors are used where
/// the level's instructions are not enabled.
#[inline(never)]
fn shape(best: &mut [[f32; RAYS]; 4], geometry: &Geometry, rays: &[Ray], index: u32, asked: u32) {
    let [t, u, v, id] = best;
    for (k, ray) in rays.iter().enumerate().filter(|(k, _)| asked >> k & 1 == 1) {
        let best = Best {
            t: t[k],
            u: u[k],
            v: v[k],
            id: id[k].to_bits(),
        };
        let ray = Ray { tmax: best.t, ..*ray };
        if let Some(hit) = geometry.intersect(PrimRef::new(index), &ray)
            && best.loses_to(hit.t, index + 1)
        {
            (t[k], u[k], v[k], id[k]) = (hit.t, hit.u, hit.v, f32::from_bits(index + 1));
        }
    }
}

/// One of four triangles' numbers, for all rays.
#[inline(always)]
fn spread<L: Level>(level: L, [x, y, z]: [&[f32; 4]; 3], k: usize) -> Vec3s<L::F16> {
    [level.splat16(x[k]), level.splat16(y[k]), level.splat16(z[k])]
}

/// Three numbers of four triangles, as they are needed to spread each over all rays.
#[inline(always)]
fn arrays<F: Floats<Array = [f32; 4]>>(v: Vec3s<F>) -> [[f32; 4]; 3] {
    [v[0].to_array(), v[1].to_array(), v[2].to_array()]
}
