//! Points of rectangles as seen from many points at once, chosen by area.

use super::rectangle::Rectangle;
use crate::math::{
    DVec3, Dispatch, Vec2, Vec3, VectorLoop,
    block::{Each, LANES, get, set},
};

/// Rectangles, each with the point that it is seen from and two uniform numbers; and a point on each.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct RectangleBlock {
    from: [Each; 3],
    u: [Each; 2],
    corner: [Each<f64>; 3],
    edges: [[Each<f64>; 3]; 2],
    lengths: [Each<f64>; 2],
    normal: [Each<f64>; 3],
    p: [Each; 3],
    pdf: Each,
    is_known: Each<u32>,
}

impl RectangleBlock {
    pub const EMPTY: Self = Self {
        from: [[0.0; LANES]; 3],
        u: [[0.0; LANES]; 2],
        corner: [[0.0; LANES]; 3],
        edges: [[[0.0; LANES]; 3]; 2],
        lengths: [[0.0; LANES]; 2],
        normal: [[0.0; LANES]; 3],
        p: [[0.0; LANES]; 3],
        pdf: [0.0; LANES],
        is_known: [0; LANES],
    };

    /// Sets the point from which the rectangle of a lane is seen, and its uniform numbers in `[0, 1)`.
    #[inline(always)]
    pub fn set_observer(&mut self, lane: usize, from: Vec3, u: Vec2) {
        let lane = lane % LANES;
        set(&mut self.from, lane, from);
        (self.u[0][lane], self.u[1][lane]) = (u.x, u.y);
    }

    #[inline(always)]
    pub(super) fn set_rectangle(&mut self, lane: usize, rectangle: &Rectangle) {
        let lane = lane % LANES;
        for axis in 0..3 {
            self.corner[axis][lane] = rectangle.corner[axis];
            self.normal[axis][lane] = rectangle.normal[axis];
            for (to, edge) in self.edges.iter_mut().zip(rectangle.edges) {
                to[axis][lane] = edge[axis];
            }
        }
        for (to, length) in self.lengths.iter_mut().zip(rectangle.lengths) {
            to[lane] = length;
        }
    }

    /// Chooses the points of all lanes.
    #[inline]
    pub fn sample(&mut self, on: impl Dispatch) {
        on.dispatch(Sample(self));
    }

    #[inline(always)]
    pub fn from(&self, lane: usize) -> Vec3 {
        get(&self.from, lane)
    }

    /// Returns what [`ShapeKind::sample`](super::ShapeKind::sample) chooses: the point, the unit normal as authored, and the
    /// density of the direction in sr^-1; not above 0 where there is no sample.
    #[inline(always)]
    pub fn point(&self, lane: usize) -> (Vec3, Vec3, f32) {
        let normal = double(&self.normal, lane).as_vec3();
        (get(&self.p, lane), normal, self.pdf[lane])
    }

    /// The lanes, as bits, whose points are those of [`ShapeKind::sample`](super::ShapeKind::sample). A rectangle that is sampled
    /// by solid angle has to be asked itself.
    #[inline(always)]
    pub fn known(&self) -> u32 {
        (0..LANES).map(|lane| u32::from(self.is_known[lane] != 0) << lane).sum()
    }
}

#[inline(always)]
fn double(v: &[Each<f64>; 3], lane: usize) -> DVec3 {
    DVec3::new(v[0][lane], v[1][lane], v[2][lane])
}

struct Sample<'a>(&'a mut RectangleBlock);

impl VectorLoop for Sample<'_> {
    #[inline(always)]
    fn run(self) {
        let block = self.0;
        // Results go to local arrays, so that the compiler knows that reads and writes do not alias.
        let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let (mut pdf, mut is_known) = ([0.0; LANES], [0; LANES]);
        for i in 0..LANES {
            let rectangle = Rectangle {
                corner: double(&block.corner, i),
                edges: [double(&block.edges[0], i), double(&block.edges[1], i)],
                lengths: [block.lengths[0][i], block.lengths[1][i]],
                normal: double(&block.normal, i),
            };
            let from = block.from(i).as_dvec3();
            let p = rectangle.point(block.u[0][i].into(), block.u[1][i].into());
            pdf[i] = rectangle.pdf_by_area(from, p);
            is_known[i] = u32::from(rectangle.is_sampled_by_area(from));
            (x[i], y[i], z[i]) = (p.x as f32, p.y as f32, p.z as f32);
        }
        block.p = [x, y, z];
        (block.pdf, block.is_known) = (pdf, is_known);
    }
}
