//! Spatial splits: large primitives are split, and each part gets its own box.
//!
//! The box of a wall is as large as the room, and so are the boxes of all sets that contain the
//! wall. For [`Quality::High`], such triangles are split before the build, the largest first, while
//! they are large and the number of references is below a limit. Each part is a box of its own in
//! the tree. Whether the tree is used is decided after it has been built.
//!
//! Only triangles in an axis-aligned plane are split. Hits must not depend on the tree, and a hit
//! is what the rounded test of [`crate::shape::triangle`] reports. For such a plane, that test is
//! accurate even in directions along the surface. The normal has one component, so `t` is that of
//! the plane up to a few roundings. The coordinate of a sheared vertex across the plane has an
//! error of some roundings of its terms, and both terms shrink with the ray's slope. So the edge
//! functions are exact for vertices that are displaced in the plane by less than 8 [`f32::EPSILON`]
//! of the distances to them and to the hit. [`SLACK`] covers that for rays that start up to [`FAR_ORIGIN`]
//! times the scene's extent away, and [`crate::geometry::slab`] pads the boxes for other rays. In
//! an inclined plane, the error grows with the reciprocal of the angle, and only the box of the
//! whole triangle contains all possible hits. For the same reason, obvhs's own splitting of
//! arbitrary triangles is not used.
//!
//! Source: Karras and Aila, "Fast Parallel Construction of High-Quality Bounding Volume
//! Hierarchies", 2013, section 4.2, <https://doi.org/10.1145/2492045.2492055>.
//!
//! [`Quality::High`]: crate::accel::accelerator::Quality::High

use std::collections::BinaryHeap;

use super::median_split::{PrimBox, SetBounds};
use crate::{
    geometry::{Geometry, slab::FAR_ORIGIN},
    math::{Aabb, Vec3},
};

/// The padding of a box around its part of the triangle, relative to the largest coordinate of the
/// scene.
const SLACK: f32 = 16.0 * FAR_ORIGIN * f32::EPSILON;

/// The largest number of additional boxes, relative to the number of primitives.
const MAX_REFERENCE_GROWTH: f32 = 0.5;

/// The smallest surface area of a box that is split, relative to that of the boxes if all had the
/// same size and filled the scene.
const MIN_SIZE_RATIO: f32 = 4.0;

/// Splits triangles.
pub struct SpatialSplitter<'a> {
    pub geometry: &'a Geometry,
    /// The largest coordinate of the scene.
    pub reach: f32,
}

impl SpatialSplitter<'_> {
    /// Returns the parts of all `refs`, which have the bounds `bounds`; empty if nothing is split.
    pub fn cut(&self, refs: &[PrimBox], bounds: &SetBounds) -> Vec<PrimBox> {
        let slack = SLACK * self.reach;
        let cells = libm::cbrtf(refs.len() as f32).powi(2);
        let large = MIN_SIZE_RATIO * bounds.boxes.aabb().half_area() / cells;
        let mut spare = (refs.len() as f32 * MAX_REFERENCE_GROWTH) as usize;
        // Areas are not negative, so their bits sort like the floats.
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

    /// Returns the vertices of a triangle that can be split, and the axis that its plane is
    /// perpendicular to.
    fn flat(&self, r: &PrimBox) -> Option<([Vec3; 3], usize)> {
        let index = r.index() as usize;
        if index >= self.geometry.triangles.len() {
            return None;
        }
        let [a, b, c] = self.geometry.corners(index);
        let axis = (0..3).find(|&axis| a[axis] == b[axis] && b[axis] == c[axis])?;
        Some(([a, b, c], axis))
    }

    /// Returns the part of `r` between two planes, or `None` if it is empty.
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
