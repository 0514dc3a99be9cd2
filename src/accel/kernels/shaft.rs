//! The bounds of a group of coherent rays.
//!
//! A shaft is the space between two boxes, around the rays' origins and around their ends. It is
//! narrow at a light that the rays go to, and wide if one of the rays ends far beyond the others.
//!
//! After Haines and Wallace, "Shaft Culling for Efficient Ray-Traced Radiosity", 1991, with time as
//! a fourth axis instead of planes between the boxes' edges.

use super::{
    ray_rows::{fours, numbers, three},
    traversal_state::TraversalState,
    triangle::{boxes, load3},
};
use crate::{
    accel::wide::node::{TriangleBlock, WideNode},
    geometry::slab::{END_PADDING, EXIT_PADDING, MIN_PADDING, ORIGIN_PADDING},
    math::Ray,
    simd::lanes::{Eight, Floats, Mask, SimdLevel},
};

/// The length of rays without an end, relative to the scene's extent.
const MAX_LENGTH: f32 = 8.0;

/// The largest distance of a shaft's origins from the scene's origin, and the smallest extent along
/// one axis of rays that leave the scene, relative to the scene's extent.
const MAX_ORIGIN_DISTANCE: f32 = 2.0;
const MIN_EXIT_LENGTH: f32 = 4.0;

/// The smallest extent of the rays along each axis, relative to the scene's extent. It keeps values
/// that are computed from the reciprocal finite.
const MIN_EXTENT: f32 = 1e-12;

/// A shaft enters a box no later, and leaves it no earlier, than any of its rays. It reaches a
/// plane `x = b` at `b * inv + near` and `b * inv_far + far`, where 0 is the start of all rays and
/// 1 is their end.
#[derive(Clone, Default)]
pub struct Shaft {
    state: TraversalState,
    inv_far: [f32; 4],
    /// The bounds of the rays' origins.
    o: [[f32; 4]; 2],
}

impl Shaft {
    /// Computes the bounds of these rays, of which there is at least one. Returns whether the rays
    /// are coherent and regular, so that the shaft is valid.
    ///
    /// At each time between start and end, the rays are between two corners of their bounding box,
    /// each of which moves along a line. The foremost corner reaches a plane first, the hindmost
    /// one last.
    #[inline(always)]
    pub fn enclose<L: SimdLevel>(&mut self, level: L, rays: &[Ray], ids: &[u32], reach: f32) -> bool {
        let long = MAX_LENGTH * reach / rays[ids[0] as usize].d.abs().max_element();
        let load = |id: u32| {
            let ray = &rays[id as usize];
            let [o, d] = fours(level, numbers(ray));
            let t = if ray.tmax < long { ray.tmax } else { long };
            (level.load8(numbers(ray)), d.mul_add(level.splat4(t), o))
        };
        let (mut low, mut e_low) = load(ids[0]);
        let (mut high, mut e_high) = (low, e_low);
        for &id in &ids[1..] {
            // NaN is ignored: such a ray hits nothing.
            let (x, e) = load(id);
            (low, high) = (x.min(low), x.max(high));
            (e_low, e_high) = (e.min(e_low), e.max(e_high));
        }
        let (low, high) = (low.to_array(), high.to_array());
        let (tmin, shortest, longest) = (low[3], low[7], high[7]);
        let ([o_low, d_low], [o_high, d_high]) = (fours(level, &low), fours(level, &high));
        let zero = level.splat4(0.0);
        let (negative, positive) = (d_high.lt(zero), zero.lt(d_low));
        let one = level.splat4(1.0);
        let inv_near = one.div(e_low.sub(o_low).select(negative, e_high.sub(o_high)));
        let inv_far = one.div(e_high.sub(o_high).select(negative, e_low.sub(o_low)));

        // Twice the padding of a single ray, plus one for the rounding of its end.
        let away = o_low.abs().max(o_high.abs());
        let beyond = e_low.abs().max(e_high.abs());
        let pad = away
            .add(beyond)
            .mul(level.splat4(2.0 * ORIGIN_PADDING))
            .add(level.splat4(4.0 * MIN_PADDING));
        let (less, more) = (o_low.sub(pad), o_high.add(pad));
        let back = level.splat4(-1.0);
        let near = less.select(negative, more).mul(inv_near).mul(back);
        let far = more.select(negative, less).mul(inv_far).mul(back);
        self.state.inv = three(inv_near);
        self.state.near = three(near);
        self.state.far = three(far);
        self.inv_far = inv_far.to_array();
        self.state.tmin = 0.0;
        self.state.end = END_PADDING;
        self.state.set_octant(negative.bits());
        self.o = [o_low.to_array(), o_high.to_array()];

        let steepest = inv_near.abs().max(inv_far.abs());
        let goes = steepest.lt(level.splat4(1.0 / (MIN_EXTENT * reach)));
        let starts_near = away.le(level.splat4(MAX_ORIGIN_DISTANCE * reach));
        let fits = negative.or(positive).and(goes).and(starts_near).bits();
        let [x, y, z] = three(d_low.abs().min(d_high.abs()));
        let is_whole = longest < long || x.max(y).max(z) * long >= MIN_EXIT_LENGTH * reach;
        fits & 0b111 == 0b111 && tmin >= 0.0 && shortest >= 0.0 && is_whole
    }

    /// Returns the boxes of a node that the shaft intersects.
    #[inline(always)]
    pub fn intersect_node<L: SimdLevel>(&self, level: L, node: &WideNode) -> Eight {
        let (enter, leave) = self.state.intersect_node(level, node, Some(&self.inv_far));
        level.met(enter, leave.mul(level.splat8(EXIT_PADDING)))
    }

    /// Returns the set of a block's triangles that rays of the shaft may hit. The other triangles
    /// are hit by no ray: the shaft misses their bounds, or they are axis-aligned and behind the
    /// rays' origins.
    ///
    /// Bounds are slightly larger than triangles, so the box of a floor contains the origins of
    /// rays that leave it. For an axis-aligned triangle, the distance to its plane has the correct
    /// sign, since it is a product. So a triangle behind the origin is not hit.
    #[inline(always)]
    pub fn possible_occluders<L: SimdLevel>(&self, level: L, block: &TriangleBlock) -> u32 {
        let [a, b, c] = block.corners.each_ref();
        let corners = [
            load3(level, a.each_ref()),
            load3(level, b.each_ref()),
            load3(level, c.each_ref()),
        ];
        let met = self.state.meets(&boxes(&corners), &self.inv_far);
        let [a, b, c] = corners;
        let negative = self.state.negative();
        let mut left = 0;
        for axis in 0..3 {
            let is_behind = if negative[axis] {
                level.splat4(self.o[1][axis]).le(a[axis])
            } else {
                a[axis].le(level.splat4(self.o[0][axis]))
            };
            left |= a[axis].eq(b[axis]).and(a[axis].eq(c[axis])).and(is_behind).bits();
        }
        let exists = a[0].eq(a[0]);
        met.and(exists).bits() & !left & 0b1111
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        accel::kernels::{query::NOTHING, ray_state::RayState},
        geometry::padding::BoundsPadding,
        math::{Aabb, Vec3, hash},
        shape::triangle,
        simd::portable::Portable,
    };

    const GROUP: u32 = 64;

    /// For scenes with an extent of 1.
    const UNIT: BoundsPadding = BoundsPadding {
        reach: 1.0,
        origin: 0.0,
    };

    fn unit(i: u32, k: u32) -> f32 {
        hash::unit_f32(hash::pcg4d([i, k, 5, 7])[0])
    }

    fn vec(i: u32, k: u32) -> Vec3 {
        Vec3::new(unit(i, k), unit(i, k + 1), unit(i, k + 2)) - 0.5
    }

    /// Returns a node with boxes of many sizes around the origin.
    fn node(i: u32) -> WideNode {
        let mut node = WideNode::NOTHING;
        for lane in 0..7 {
            let (center, half) = (
                vec(i, 10 * lane),
                vec(i, 10 * lane + 3).abs() * unit(i, 10 * lane + 6).powi(3),
            );
            let bounds = Aabb {
                min: center - half,
                max: center + half,
            };
            node.set(lane as usize, &bounds, lane << 4);
        }
        node
    }

    #[test]
    fn what_any_ray_of_a_group_meets_its_shaft_meets() {
        let ids: Vec<u32> = (0..GROUP).collect();
        let (mut together, mut met_alone, mut met_together) = (0, 0, 0);
        for i in 0..4000 {
            let (at, to) = (vec(i, 100) * 2.0, vec(i, 103) * 3.0);
            let is_narrow = i % 3 == 0;
            let most = if is_narrow { 1e-3 } else { 0.5 };
            let [apart, wide] = [unit(i, 106), unit(i, 107)].map(|x| most * x * x * x);
            let rays: Vec<Ray> = (0..GROUP)
                .map(|k| {
                    let (o, end) = (at + vec(i, 200 + 10 * k) * apart, to + vec(i, 203 + 10 * k) * wide);
                    if is_narrow {
                        return Ray::segment(o, end - o, unit(i, 206));
                    }
                    let mut ray = Ray::segment(o, end - o, unit(i, 206 + 10 * k));
                    match (i + k) % 200 {
                        0 => ray.tmax = f32::NAN,
                        1 => ray.tmin = f32::NAN,
                        2 => ray.o.x = f32::NAN,
                        3 => ray.d.z = f32::NAN,
                        4 => ray.tmax = f32::INFINITY,
                        5 => ray.tmin = 0.5 * ray.tmax,
                        6 => ray.tmax = -ray.tmax,
                        _ => {}
                    }
                    ray
                })
                .collect();
            let mut shaft = Shaft::default();
            if !shaft.enclose(Portable, &rays, &ids, UNIT.reach) {
                continue;
            }
            together += 1;
            let node = node(i);
            let met = shaft.intersect_node(Portable, &node).bits();
            let mut any = 0;
            for ray in &rays {
                let mut slot = RayState::default();
                if slot.start(Portable, ray, 0, UNIT) {
                    let (enter, leave) = slot.state.intersect_node(Portable, &node, None);
                    any |= Portable.met(enter, leave.mul(Portable.splat8(EXIT_PADDING))).bits();
                }
            }
            assert_eq!(any & !met, 0, "group {i}");
            if is_narrow {
                met_alone += any.count_ones();
                met_together += met.count_ones();
            }
        }
        assert!(together > 1000, "{together}");
        // A narrow group with nearby ends hits hardly any box that none of its rays hits.
        assert!(
            met_alone > 50 && met_together < met_alone * 11 / 10,
            "{met_together} {met_alone}"
        );
    }

    #[test]
    fn what_is_not_in_the_way_no_ray_meets() {
        let (mut left, mut met) = (0, 0);
        for i in 0..3000 {
            let axis = (i % 3) as usize;
            let at = vec(i, 0)[axis];
            let mut block = TriangleBlock::NOTHING;
            for lane in 0..i % 5 {
                let mut corners = [0, 1, 2].map(|k| vec(i, 10 + 9 * lane + 3 * k) * 2.0);
                corners.iter_mut().for_each(|corner| corner[axis] = at);
                if i % 7 == 0 {
                    corners[1][axis] = at.next_up();
                }
                block.set(lane as usize, corners, lane);
            }
            // In the plane itself and up to three floats beside it.
            let up = if i % 2 == 0 { 1.0 } else { -1.0 };
            let rays: Vec<Ray> = (0..GROUP)
                .map(|k| {
                    let mut o = vec(i, 100 + 9 * k) * 0.3;
                    o[axis] = (0..k % 4).fold(at, |x, _| if i % 4 < 2 { x.next_up() } else { x.next_down() });
                    let mut d = vec(i, 103 + 9 * k) * 0.1 + Vec3::splat(0.5);
                    d[axis] = up * unit(i, 106 + 9 * k).powi(4);
                    Ray::new(o, d)
                })
                .collect();
            let ids: Vec<u32> = (0..GROUP).collect();
            let mut shaft = Shaft::default();
            if !shaft.enclose(Portable, &rays, &ids, 1.0) {
                continue;
            }
            let way = shaft.possible_occluders(Portable, &block);
            for lane in 0..4 {
                let [a, b, c] = [0, 1, 2].map(|k| Vec3::from([0, 1, 2].map(|axis| block.corners[k][axis][lane])));
                let hits = |ray: &&Ray| triangle::intersect(ray, a, b, c).is_some();
                let count = rays.iter().filter(hits).count();
                if way >> lane & 1 == 0 {
                    left += u32::from(block.ids[lane] != NOTHING);
                    assert_eq!(count, 0, "group {i}, triangle {lane}");
                } else {
                    met += count;
                }
            }
        }
        assert!(left > 1500 && met > 500, "{left} {met}");
    }

    #[test]
    fn only_a_ceiling_is_in_the_way_of_what_is_below_and_nothing_of_what_leaves_it() {
        let mut block = TriangleBlock::NOTHING;
        let wall = Vec3::new(2.0, 1.0, -2.0);
        let corners = [
            [
                Vec3::new(-2.0, 1.0, -2.0),
                Vec3::new(2.0, 1.0, -2.0),
                Vec3::new(2.0, 1.0, 2.0),
            ],
            [
                Vec3::new(-2.0, 1.0, -2.0),
                Vec3::new(2.0, 1.0, 2.0),
                Vec3::new(-2.0, 1.0, 2.0),
            ],
            [wall, wall + Vec3::Z * 4.0, wall - Vec3::Y * 2.0],
        ];
        for (lane, corners) in corners.into_iter().enumerate() {
            block.set(lane, corners, lane as u32);
        }
        let ids: Vec<u32> = (0..GROUP).collect();
        for (height, expected) in [(1.0_f32.next_up(), 0), (-0.5, 0b11)] {
            let rays: Vec<Ray> = (0..GROUP)
                .map(|k| {
                    let at = vec(k, 1) * 0.1;
                    let o = Vec3::new(at.x, height, at.z);
                    Ray::segment(o, Vec3::new(1.0, 9.0, 2.0) - o, 0.999)
                })
                .collect();
            let mut shaft = Shaft::default();
            assert!(shaft.enclose(Portable, &rays, &ids, 4.0));
            assert_eq!(shaft.possible_occluders(Portable, &block), expected, "from {height}");
        }
    }
}
