//! Surfaces of many hits on vectors: what is the same for all of them, sixteen at a time.

use super::{Surface, interaction::Spot};
use crate::{
    math::{Loop, Runner, Vec3},
    shape::triangle,
};

/// Surfaces of a block.
const LANES: usize = 16;

type Column = [f32; LANES];
/// By axis.
type Column3 = [Column; 3];

/// Sixteen surfaces, number by number.
#[derive(Debug, Default)]
#[repr(align(64))]
struct Block {
    /// Not 0 for triangles in the world, which are placed by their corners and the weights of the last two.
    is_triangle: [u32; LANES],
    corners: [Column3; 3],
    weights: [Column; 2],
    /// Not 0 where single precision is not enough to place one.
    failed: [u32; LANES],
    p: Column3,
    p_error: Column3,
    ng: Column3,
    smooth: Column3,
    /// Direction of the ray.
    d: Column3,
    wo: Column3,
    ns: Column3,
    sides: [Column3; 2],
    frame: [Column3; 3],
}

#[inline(always)]
fn get([x, y, z]: &Column3, i: usize) -> Vec3 {
    Vec3::new(x[i], y[i], z[i])
}

#[inline(always)]
fn put([x, y, z]: &mut Column3, i: usize, v: Vec3) {
    (x[i], y[i], z[i]) = (v.x, v.y, v.z);
}

impl Block {
    #[inline(always)]
    fn spot(&self, i: usize) -> Spot {
        Spot {
            p: get(&self.p, i),
            p_error: get(&self.p_error, i),
            ng: get(&self.ng, i),
            smooth: get(&self.smooth, i),
        }
    }

    #[inline(always)]
    fn corners(&self, i: usize) -> [Vec3; 3] {
        let [a, b, c] = &self.corners;
        [get(a, i), get(b, i), get(c, i)]
    }

    #[inline(always)]
    fn set_place(&mut self, i: usize, p: Vec3, p_error: Vec3, ng: Vec3) {
        put(&mut self.p, i, p);
        put(&mut self.p_error, i, p_error);
        put(&mut self.ng, i, ng);
    }
}

/// Places triangles.
struct Triangles<'a>(&'a mut [Block]);

impl Loop for Triangles<'_> {
    #[inline(always)]
    fn run(self) {
        for block in self.0 {
            for i in 0..LANES {
                let [u, v] = [block.weights[0][i], block.weights[1][i]];
                let (place, is_exact) = triangle::place_in_single(block.corners(i), u, v);
                let is_triangle = block.is_triangle[i] != 0;
                block.failed[i] = u32::from(is_triangle & !is_exact);
                let known = block.spot(i);
                // In numbers, for the compiler to see that there is no branch.
                let either = |a: f32, b: f32| if is_triangle { a } else { b };
                let new = |a: Vec3, b: Vec3| Vec3::new(either(a.x, b.x), either(a.y, b.y), either(a.z, b.z));
                block.set_place(
                    i,
                    new(place.p, known.p),
                    new(place.p_error, known.p_error),
                    new(place.ng, known.ng),
                );
            }
        }
    }
}

/// Finds how surfaces are seen.
struct Views<'a>(&'a mut [Block]);

impl Loop for Views<'_> {
    #[inline(always)]
    fn run(self) {
        for block in self.0 {
            for i in 0..LANES {
                let view = block.spot(i).seen_along(get(&block.d, i));
                put(&mut block.wo, i, view.wo);
                put(&mut block.ns, i, view.ns);
                let [above, below] = &mut block.sides;
                put(above, i, view.sides[0]);
                put(below, i, view.sides[1]);
                let [s, t, n] = &mut block.frame;
                put(s, i, view.frame.s);
                put(t, i, view.frame.t);
                put(n, i, view.frame.n);
            }
        }
    }
}

/// The numbers of some surfaces.
#[derive(Debug, Default)]
pub struct Columns {
    blocks: Vec<Block>,
    len: usize,
}

impl Columns {
    /// Begins anew.
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    /// Where the next surface goes.
    #[inline(always)]
    fn next(&mut self, d: Vec3) -> (&mut Block, usize) {
        let (block, i) = (self.len / LANES, self.len % LANES);
        self.len += 1;
        if block == self.blocks.len() {
            self.blocks.push(Block::default());
        }
        let block = &mut self.blocks[block];
        put(&mut block.d, i, d);
        (block, i)
    }

    /// Adds a place that a ray along `d` met.
    #[inline(always)]
    pub(super) fn push_spot(&mut self, spot: &Spot, d: Vec3) {
        let (block, i) = self.next(d);
        block.is_triangle[i] = 0;
        block.set_place(i, spot.p, spot.p_error, spot.ng);
        put(&mut block.smooth, i, spot.smooth);
    }

    /// Adds a place on a triangle by the weights of its last two corners.
    #[inline(always)]
    pub(super) fn push_triangle(&mut self, corners: [Vec3; 3], [u, v]: [f32; 2], smooth: Vec3, d: Vec3) {
        let (block, i) = self.next(d);
        block.is_triangle[i] = 1;
        for (column, corner) in block.corners.iter_mut().zip(corners) {
            put(column, i, corner);
        }
        (block.weights[0][i], block.weights[1][i]) = (u, v);
        put(&mut block.smooth, i, smooth);
    }

    /// Finds all that follows from what was pushed.
    pub(super) fn find(&mut self, on: impl Runner) {
        let blocks = &mut self.blocks[..self.len.div_ceil(LANES)];
        on.run(Triangles(blocks));
        for block in &mut *blocks {
            let failed = block.failed;
            if failed == [0; LANES] {
                continue;
            }
            for i in (0..LANES).filter(|i| failed[*i] != 0) {
                let place = triangle::place(block.corners(i), block.weights[0][i], block.weights[1][i]);
                block.set_place(i, place.p, place.p_error, place.ng);
            }
        }
        on.run(Views(blocks));
    }

    /// Enters in `surface` what was found for the `k`th.
    #[inline(always)]
    pub(super) fn stand(&self, k: usize, surface: &mut Surface) {
        let (block, i) = (&self.blocks[k / LANES], k % LANES);
        surface.p = get(&block.p, i);
        surface.ng = get(&block.ng, i);
        surface.wo = get(&block.wo, i);
        surface.ns = get(&block.ns, i);
        let [above, below] = &block.sides;
        surface.sides = [get(above, i), get(below, i)];
        let [s, t, n] = &block.frame;
        surface.frame.s = get(s, i);
        surface.frame.t = get(t, i);
        surface.frame.n = get(n, i);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{
        accel::Simd,
        math::{Frame, Plain},
    };

    fn point(size: f32) -> impl Strategy<Value = Vec3> {
        [-1.0..1.0_f32, -1.0..1.0, -1.0..1.0].prop_map(move |p| Vec3::from(p) * size)
    }

    /// Of some size, or with hardly an area, or with none.
    fn corners() -> impl Strategy<Value = [Vec3; 3]> {
        let size = prop_oneof![Just(1.0), Just(1e-9), Just(1e9)];
        let corner = size.prop_flat_map(|size| [point(size), point(size), point(size)]);
        prop_oneof![
            4 => corner,
            1 => point(1.0).prop_map(|a| [a, a, a]),
        ]
    }

    /// A ray's direction, and a triangle or a place with its normal and what the shading normal is.
    type Met = (Vec3, Result<([Vec3; 3], [f32; 2]), (Vec3, Vec3)>, Vec3);

    fn met() -> impl Strategy<Value = Met> {
        let spot = (point(100.0), point(1.0).prop_map(|n| n.normalize_or(Vec3::Y)));
        let triangle = (corners(), [0.0..0.5_f32, 0.0..0.5]);
        let smooth = prop_oneof![Just(Vec3::ZERO), point(1.0)];
        let d = point(3.0).prop_filter("a direction", |d| d.length() > 0.01);
        (d, prop_oneof![triangle.prop_map(Ok), spot.prop_map(Err)], smooth)
    }

    fn bits(surface: &Surface) -> Vec<u32> {
        let Frame { s, t, n } = surface.frame;
        let [above, below] = surface.sides;
        [surface.p, surface.ng, surface.ns, surface.wo, above, below, s, t, n]
            .iter()
            .flat_map(|v| v.to_array().map(f32::to_bits))
            .collect()
    }

    proptest! {
        #[test]
        fn many_are_found_as_one_by_one(met in prop::collection::vec(met(), 1..40)) {
            let mut columns = Columns::default();
            let find = |columns: &mut Columns, on: Option<Simd>| {
                columns.clear();
                for (d, what, smooth) in &met {
                    match what {
                        Ok((corners, weights)) => columns.push_triangle(*corners, *weights, *smooth, *d),
                        Err((p, ng)) => {
                            let p_error = p.abs() * 1e-6;
                            columns.push_spot(&Spot { p: *p, p_error, ng: *ng, smooth: *smooth }, *d);
                        }
                    }
                }
                match on {
                    Some(simd) => columns.find(simd),
                    None => columns.find(Plain),
                }
                (0..met.len()).map(|k| {
                    let mut surface = Surface::nowhere();
                    columns.stand(k, &mut surface);
                    surface
                }).collect::<Vec<_>>()
            };
            let mut levels = vec![find(&mut columns, None)];
            levels.extend(Simd::available().into_iter().map(|simd| find(&mut columns, Some(simd))));
            for (k, (d, what, smooth)) in met.iter().enumerate() {
                let spot = match *what {
                    Ok((corners, [u, v])) => {
                        let place = triangle::place(corners, u, v);
                        Spot { p: place.p, p_error: place.p_error, ng: place.ng, smooth: *smooth }
                    }
                    Err((p, ng)) => Spot { p, p_error: p.abs() * 1e-6, ng, smooth: *smooth },
                };
                let mut alone = Surface::nowhere();
                alone.stand(&spot, &spot.seen_along(*d));
                for level in &levels {
                    prop_assert_eq!(bits(&level[k]), bits(&alone));
                }
            }
        }
    }
}
