//! Cuts through primitives: each side gets a box of its own.
//!
//! A wall's box is as large as the room, and with it every set that the wall is in. For [`Quality::High`] such triangles
//! are cut in two, before a tree is built, the largest first, as long as they are large and there are not too many
//! parts; each part is a box of its own in the tree. Whether that tree is kept is decided when it is there.
//!
//! Only triangles in a plane across an axis are cut. Hits must not depend on the tree, and a hit is what the rounded
//! test of [`crate::shape::triangle`] says it is. In such a plane that test is accurate even along the surface. The normal
//! has one component, so `t` is that of the plane to a few roundings. A sheared corner's coordinate across the plane
//! errs by some roundings of what it is made of, and both parts shrink with the ray's slope; so the edges' tests are
//! exact for corners that lie elsewhere in the plane by less than 8 [`f32::EPSILON`] of the way to them and to the hit.
//! [`SLACK`] covers that for rays that start up to [`FAR`] times as far away as anything is, and [`crate::geometry::slab`] widens
//! the boxes for others. In an inclined plane the error grows with the reciprocal of the angle, and no box but the
//! whole triangle's holds whatever may count as a hit. That is also why obvhs's own cutting, of any triangle, is not for us.
//!
//! Source: Karras and Aila, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", 2013, section 4.2,
//! <https://doi.org/10.1145/2492045.2492055>.
//!
//! [`Quality::High`]: crate::accel::accelerator::Quality::High

use std::collections::BinaryHeap;

use super::median_split::{PrimBox, SetBounds};
use crate::{
    geometry::{Geometry, slab::FAR},
    math::{Aabb, Vec3},
};

/// How much larger than its part of the triangle a box is, relative to the largest coordinate of the scene.
const SLACK: f32 = 16.0 * FAR * f32::EPSILON;

/// How many more boxes there may be than primitives, as a part of these.
const MAX_REFERENCE_GROWTH: f32 = 0.5;

/// What is cut has so many times the surface of a box of its own for each primitive, all alike and filling the scene.
const MIN_SIZE_RATIO: f32 = 4.0;

/// Cuts triangles.
pub struct SpatialSplitter<'a> {
    pub geometry: &'a Geometry,
    /// The largest coordinate of the scene.
    pub reach: f32,
}

impl SpatialSplitter<'_> {
    /// The parts of all `refs`, which `bounds` is around; nothing where nothing is cut.
    pub fn cut(&self, refs: &[PrimBox], bounds: &SetBounds) -> Vec<PrimBox> {
        let slack = SLACK * self.reach;
        let cells = libm::cbrtf(refs.len() as f32).powi(2);
        let large = MIN_SIZE_RATIO * bounds.boxes.aabb().half_area() / cells;
        let mut spare = (refs.len() as f32 * MAX_REFERENCE_GROWTH) as usize;
        // Areas are not negative, so that their bits are in their order.
        let mut open: BinaryHeap<(u32, usize)> = refs
            .iter()
            .enumerate()
            .map(|(i, r)| (r.bounds().half_area().to_bits(), i))
            .filter(|&(area, i)| f32::from_bits(area) > large && self.flat(&refs[i]).is_some())
            .collect();
        if open.is_empty() {
            return Vec::new();
        }
        let mut refs = refs.to_vec();
        while spare > 0
            && let Some((_, i)) = open.pop()
        {
            let b = refs[i].bounds();
            let (corners, _) = self.flat(&refs[i]).expect("only what can be cut is open");
            let axis = b.extent().max_position();
            let middle = b.center()[axis];
            if b.extent()[axis] < 64.0 * slack {
                continue;
            }
            let parts = [[b.min[axis], middle], [middle, b.max[axis]]];
            if let [Some(left), Some(right)] = parts.map(|ends| self.part(&refs[i], &corners, axis, ends)) {
                refs[i] = left;
                refs.push(right);
                spare -= 1;
                for at in [i, refs.len() - 1] {
                    let area = refs[at].bounds().half_area();
                    if area > large {
                        open.push((area.to_bits(), at));
                    }
                }
            }
        }
        refs
    }

    /// The corners of what can be cut, and the axis that its plane lies across.
    fn flat(&self, r: &PrimBox) -> Option<([Vec3; 3], usize)> {
        let index = r.index() as usize;
        if index >= self.geometry.triangles.len() {
            return None;
        }
        let [a, b, c] = self.geometry.corners(index);
        let axis = (0..3).find(|&axis| a[axis] == b[axis] && b[axis] == c[axis])?;
        Some(([a, b, c], axis))
    }

    /// The part of `r` between two planes, `None` where there is none.
    fn part(&self, r: &PrimBox, corners: &[Vec3; 3], axis: usize, [from, to]: [f32; 2]) -> Option<PrimBox> {
        let mut around = Aabb::EMPTY;
        for i in 0..3 {
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            if (from..=to).contains(&p[axis]) {
                around = around.extended(p);
            }
            for plane in [from, to] {
                if (p[axis] < plane) != (q[axis] < plane) {
                    let mut at = p + (q - p) * ((plane - p[axis]) / (q[axis] - p[axis]));
                    at[axis] = plane;
                    around = around.extended(at);
                }
            }
        }
        let (own, slack) = (r.bounds(), SLACK * self.reach);
        let part = Aabb {
            min: own.min.max(around.min - slack),
            max: own.max.min(around.max + slack),
        };
        (!part.is_empty()).then(|| PrimBox::new(&part, r.index()))
    }
}
