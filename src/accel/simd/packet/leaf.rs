//! A packet at a leaf: four triangles and what encloses all rays, then a triangle and sixteen rays.

use super::{
    super::{
        super::{
            Geometry,
            wide::node::{Block, EMPTY, SHAPE, count, number},
        },
        lanes::{Floats, Level, Mask},
        query::{NOTHING, Query},
        tree::Tree,
        triangle::{Faces, Plane, Vec3s, candidates, each, faces, load3, meet, plane, sides},
    },
    rays::{Each, NO_MORE, Packet},
    shape::shape_step,
};
use crate::math::Ray;

/// What a block of triangles costs, in tests of a node.
const BLOCK_COST: u32 = 6;

/// How far, relative to the square of the largest coordinate, an edge's side may be wrong: the routine for rays rounds it
/// by less than 20 units of [`f32::EPSILON`], [`Packet::seen`] by less than 20 as well.
const MARGIN: f32 = 64.0 * f32::EPSILON;

/// The same for numbers so small that they have lost their digits.
const LEAST: f32 = 64.0 * f32::MIN_POSITIVE;

/// Tests what is in a leaf.
///
/// # Safety
/// `leaf` is a leaf of `tree`.
#[inline(always)]
pub unsafe fn leaf_step<L: Level, Q: Query>(
    level: L,
    packet: &mut Packet,
    leaf: u32,
    tree: &Tree,
    geometry: &Geometry,
    rays: &[Ray],
) {
    let mut nearer = false;
    packet.cost += BLOCK_COST * count(leaf) as u32;
    if leaf & SHAPE != 0 {
        if leaf != EMPTY {
            nearer = shape_step::<L, Q>(level, packet, number(leaf), geometry, rays);
        }
    } else {
        // SAFETY: by this function's own contract.
        for block in unsafe { tree.leaf(leaf) } {
            nearer |= if packet.shared {
                packet.seen_block::<L, Q>(level, block)
            } else {
                packet.block::<L, Q>(level, block)
            };
        }
    }
    if nearer {
        packet.set_ends(level);
        // Nothing is left to ask.
        if Q::ANY && packet.course.end == f32::NEG_INFINITY {
            packet.course.stack.clear();
        }
    }
}

impl Packet {
    /// `rows` of a corner in the order of the axes.
    #[inline(always)]
    fn turn<'a, T>(&self, rows: &'a [T; 3]) -> [&'a T; 3] {
        let [x, y, z] = self.axes.map(usize::from);
        [&rows[x], &rows[y], &rows[z]]
    }

    /// Tests the triangles of a block where all rays see them from one place; whether one of them is met.
    ///
    /// What does not depend on directions is calculated once, for four triangles at a time.
    #[inline(always)]
    fn seen_block<L: Level, Q: Query>(&mut self, level: L, block: &Block) -> bool {
        let [x, y, z] = self.turn(self.origin.first_chunk().expect("there are four"));
        let o = [level.splat4(*x), level.splat4(*y), level.splat4(*z)];
        let [a, b, c] = &block.corners;
        let corners = [
            each(load3(level, self.turn(a)), o, L::F4::sub),
            each(load3(level, self.turn(b)), o, L::F4::sub),
            each(load3(level, self.turn(c)), o, L::F4::sub),
        ];
        let mut seen = self.seen(level, &corners);
        if seen == 0 {
            return false;
        }
        let planes = plane(&corners);
        let (normals, distances) = (arrays(planes.normal), planes.distance.to_array());
        let relative = [arrays(corners[0]), arrays(corners[1]), arrays(corners[2])];
        let [x, y, z, _] = self.origin;
        let o = [level.splat4(x), level.splat4(y), level.splat4(z)];
        let world = [
            load3(level, a.each_ref()),
            load3(level, b.each_ref()),
            load3(level, c.each_ref()),
        ];
        let own = faces(&o, self.course.negative(), &world);
        let (near, far) = (arrays(own.near), arrays(own.far));
        let mut met = false;
        while seen != 0 {
            let k = seen.trailing_zeros() as usize & 3;
            seen &= seen - 1;
            let corners = [
                spread(level, relative[0].each_ref(), k),
                spread(level, relative[1].each_ref(), k),
                spread(level, relative[2].each_ref(), k),
            ];
            let plane = || Plane {
                normal: spread(level, normals.each_ref(), k),
                distance: level.splat16(distances[k]),
            };
            let faces = || Faces {
                near: spread(level, near.each_ref(), k),
                far: spread(level, far.each_ref(), k),
            };
            met |= self.triangle::<L, Q>(level, &corners, plane, faces, block.ids[k]);
        }
        met
    }

    /// Tests the triangles of a block; whether one of them is met.
    #[inline(always)]
    fn block<L: Level, Q: Query>(&mut self, level: L, block: &Block) -> bool {
        let o = load16s(level, &self.o);
        let [x, y, z] = self.turn(&o);
        let turned = [*x, *y, *z];
        let [a, b, c] = &block.corners;
        let mut met = false;
        for k in 0..4 {
            if block.ids[k] == NOTHING {
                break;
            }
            let corners = [
                each(spread(level, self.turn(a), k), turned, L::F16::sub),
                each(spread(level, self.turn(b), k), turned, L::F16::sub),
                each(spread(level, self.turn(c), k), turned, L::F16::sub),
            ];
            let negative = self.course.negative();
            let faces = || {
                let world = [
                    spread(level, a.each_ref(), k),
                    spread(level, b.each_ref(), k),
                    spread(level, c.each_ref(), k),
                ];
                faces(&o, negative, &world)
            };
            met |= self.triangle::<L, Q>(level, &corners, || plane(&corners), faces, block.ids[k]);
        }
        met
    }

    /// Which of four triangles any ray may meet, given relative to the origin of all.
    ///
    /// The side on which a ray passes an edge is linear in its shear, so over all shears that lie around the rays' own it
    /// has its extremes in the corners.
    #[inline(always)]
    fn seen<L: Level>(&self, level: L, corners: &[Vec3s<L::F4>; 3]) -> u32 {
        let middle = [level.splat4(self.middle[0]), level.splat4(-self.middle[1])];
        let half = [level.splat4(self.half[0]), level.splat4(-self.half[1])];
        let edge = |p: &Vec3s<L::F4>, q: &Vec3s<L::F4>| {
            let x = p[1].mul_sub(q[2], p[2].mul(q[1]));
            let y = p[2].mul_sub(q[0], p[0].mul(q[2]));
            let z = p[0].mul_sub(q[1], p[1].mul(q[0]));
            let at = middle[0].mul_sub(x, middle[1].mul_sub(y, z));
            let around = half[0].mul_sub(x.abs(), half[1].mul(y.abs()));
            (at.sub(around), at.add(around))
        };
        let [a, b, c] = corners;
        let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
        let largest = |p: &Vec3s<L::F4>| p[0].abs().max(p[1].abs()).max(p[2].abs());
        let largest = largest(a).max(largest(b)).max(largest(c));
        let margin = largest.mul(largest).mul(level.splat4(MARGIN)).max(level.splat4(LEAST));
        let zero = level.splat4(0.0);
        let front = zero.le(u.1.min(v.1).min(w.1).add(margin));
        let back = u.0.max(v.0).max(w.0).le(margin);
        front.or(back).bits()
    }

    /// Keeps the hits of a triangle that are nearer; whether there is one.
    #[inline(always)]
    fn triangle<L: Level, Q: Query>(
        &mut self,
        level: L,
        corners: &[Vec3s<L::F16>; 3],
        plane: impl FnOnce() -> Plane<L::F16>,
        faces: impl FnOnce() -> Faces<L::F16>,
        id: u32,
    ) -> bool {
        let sides = sides(
            corners,
            [level.load16(&self.shear[0].0), level.load16(&self.shear[1].0)],
        );
        // Whose lines are inside seldom meets nothing, where all that can be foretold has been.
        if !self.shared && sides.inside.bits() == 0 {
            return false;
        }
        let (begin, until) = (level.load16(&self.begin.0), level.load16(&self.until.0));
        let candidates = candidates(load16s(level, &self.d), &plane(), sides, begin, until);
        if candidates.mask.bits() == 0 {
            return false;
        }
        let meets = meet(&load16s(level, &self.inv), &faces(), &candidates);
        let t = level.load16(&self.t.0);
        let valid = meets.valid.and(level.load16(&self.tmins.0).lt(meets.t));
        if Q::ANY {
            let blocked = valid.and(meets.t.le(t));
            self.t.0 = level.splat16(NO_MORE.t).select(blocked, t).to_array();
            let ids = level.splat16(f32::from_bits(NO_MORE.id));
            self.id.0 = ids.select(blocked, level.load16(&self.id.0)).to_array();
            return blocked.bits() != 0;
        }
        let mut nearer = valid.and(meets.t.lt(t));
        let equal = valid.and(meets.t.eq(t)).bits();
        if equal != 0 {
            nearer = nearer.or(level.mask16(self.wins(equal, id)));
        }
        self.t.0 = meets.t.select(nearer, t).to_array();
        self.u.0 = meets.u.select(nearer, level.load16(&self.u.0)).to_array();
        self.v.0 = meets.v.select(nearer, level.load16(&self.v.0)).to_array();
        let ids = level.splat16(f32::from_bits(id));
        self.id.0 = ids.select(nearer, level.load16(&self.id.0)).to_array();
        true
    }

    /// Those of the `equal` hits that have a lower number than what was hit so far.
    #[cold]
    #[inline(never)]
    fn wins(&self, equal: u32, id: u32) -> u32 {
        let wins = (0..self.id.0.len()).filter(|&k| equal >> k & 1 == 1 && id < self.id.0[k].to_bits());
        wins.fold(0, |bits, k| bits | 1 << k)
    }
}

#[inline(always)]
pub fn load16s<L: Level>(level: L, v: &[Each; 3]) -> Vec3s<L::F16> {
    [level.load16(&v[0].0), level.load16(&v[1].0), level.load16(&v[2].0)]
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
