//! One step of building a tree from the top: where a set of boxes is best cut in two.
//!
//! The boxes' centres are counted in bins along each axis, and the cut between two bins is taken for which the surface
//! area heuristic is least. What it cannot tell apart is halved by count, along the longest axis, so that every set of
//! boxes is cut and the time is linear in their number for each level.
//!
//! Source: Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007,
//! <https://doi.org/10.1109/RT.2007.4342588>.

use std::ops::Range;

use glam::Vec4;
use rayon::prelude::*;

use crate::math::{Aabb, Vec3};

/// A box that goes into a tree, with the index of what it is around.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ref {
    /// The index' bits are in the last component.
    min: Vec4,
    max: Vec4,
}

impl Ref {
    pub fn new(bounds: &Aabb, index: u32) -> Self {
        Self {
            min: bounds.min.extend(f32::from_bits(index)),
            max: bounds.max.extend(0.0),
        }
    }

    pub fn index(&self) -> u32 {
        self.min.w.to_bits()
    }

    pub fn bounds(&self) -> Aabb {
        Aabb {
            min: self.min.truncate(),
            max: self.max.truncate(),
        }
    }

    #[inline(always)]
    fn half_area(&self) -> f32 {
        let e = self.max - self.min;
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    /// Twice the centre.
    #[inline(always)]
    fn center(&self) -> Vec4 {
        self.min + self.max
    }
}

/// A box whose last component means nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box4 {
    pub min: Vec4,
    pub max: Vec4,
}

impl Box4 {
    pub const EMPTY: Self = Self {
        min: Vec4::INFINITY,
        max: Vec4::NEG_INFINITY,
    };

    pub fn add(&mut self, r: &Ref) {
        self.grow(r.min, r.max);
    }

    #[inline(always)]
    fn grow(&mut self, min: Vec4, max: Vec4) {
        self.min = self.min.min(min);
        self.max = self.max.max(max);
    }

    pub fn union(mut self, other: Self) -> Self {
        self.grow(other.min, other.max);
        self
    }

    pub fn aabb(&self) -> Aabb {
        Aabb {
            min: self.min.truncate(),
            max: self.max.truncate(),
        }
    }

    fn extent(&self) -> Vec3 {
        (self.max - self.min).truncate()
    }
}

/// What is known of a set before it is cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Around all boxes.
    pub boxes: Box4,
    /// Around twice their centres.
    centers: Box4,
}

impl Default for Bounds {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Bounds {
    pub const EMPTY: Self = Self {
        boxes: Box4::EMPTY,
        centers: Box4::EMPTY,
    };

    #[inline(always)]
    pub fn add(&mut self, r: &Ref) {
        self.boxes.grow(r.min, r.max);
        let center = r.center();
        self.centers.grow(center, center);
    }

    pub fn union(self, other: Self) -> Self {
        Self {
            boxes: self.boxes.union(other.boxes),
            centers: self.centers.union(other.centers),
        }
    }

    pub fn of(refs: &[Ref]) -> Self {
        let serial = |refs: &[Ref]| {
            let mut bounds = Self::EMPTY;
            refs.iter().for_each(|r| bounds.add(r));
            bounds
        };
        if refs.len() < PARALLEL {
            return serial(refs);
        }
        refs.par_chunks(PARALLEL / 4)
            .map(serial)
            .reduce(|| Self::EMPTY, Self::union)
    }

    /// A length by which edges count beside surfaces.
    pub fn thin(&self) -> f32 {
        self.boxes.extent().max_element() * THIN
    }

    /// Whether all boxes have the same centre.
    pub fn is_point(&self) -> bool {
        self.centers.extent().max_element() == 0.0
    }
}

/// More boxes are counted by several threads.
const PARALLEL: usize = 1 << 16;

/// Adding it to a number from 0 to 2^21 leaves the nearest integer in the last bits.
const TO_INTEGER: f32 = 12_582_912.0;

/// How many primitives are tested together.
const TOGETHER: u32 = 4;

/// How centres become numbers of `N` bins.
#[derive(Clone, Copy)]
struct Binning<const N: usize> {
    start: Vec4,
    scale: Vec4,
}

impl<const N: usize> Binning<N> {
    fn new(bounds: &Bounds) -> Self {
        // A little less than all of the last bin. An extent without a finite reciprocal gets one bin.
        let scale = bounds.centers.extent().map(|e| {
            let scale = N as f32 * 0.999 / e;
            if scale.is_finite() { scale } else { 0.0 }
        });
        Self {
            start: bounds.centers.min,
            scale: scale.extend(0.0),
        }
    }

    #[inline(always)]
    fn bins(&self, r: &Ref) -> [usize; 3] {
        let x = (r.center() - self.start) * self.scale + Vec4::splat(-0.5) + Vec4::splat(TO_INTEGER);
        [x.x, x.y, x.z].map(|x| x.to_bits() as usize & (N - 1))
    }
}

/// What is in the bins of three axes.
#[derive(Clone)]
struct Bins<const N: usize> {
    boxes: [[Box4; N]; 3],
    counts: [[u32; N]; 3],
    /// How many are large.
    large: u32,
}

impl<const N: usize> Bins<N> {
    fn of(refs: &[Ref], binning: &Binning<N>, axes: &Range<usize>, large: f32) -> Self {
        let mut bins = Self {
            boxes: [[Box4::EMPTY; N]; 3],
            counts: [[0; N]; 3],
            large: 0,
        };
        for r in refs {
            bins.large += u32::from(r.half_area() > large);
            let at = binning.bins(r);
            for axis in axes.clone() {
                bins.boxes[axis][at[axis]].grow(r.min, r.max);
                bins.counts[axis][at[axis]] += 1;
            }
        }
        bins
    }

    fn union(mut self, other: Self) -> Self {
        for axis in 0..3 {
            for i in 0..N {
                self.boxes[axis][i] = self.boxes[axis][i].union(other.boxes[axis][i]);
                self.counts[axis][i] += other.counts[axis][i];
            }
        }
        self.large += other.large;
        self
    }
}

/// Half a box's surface, and a little of its edges, by which boxes without a surface differ.
fn size(b: &Box4, thin: f32) -> f32 {
    let e = b.extent();
    e.x * e.y + e.y * e.z + e.z * e.x + thin * (e.x + e.y + e.z)
}

/// How much the edges count beside the surface, relative to the longest one of all.
const THIN: f32 = 1.0 / (1 << 20) as f32;

/// A cut between the bins `at - 1` and `at` of an axis.
#[derive(Clone, Copy)]
struct Cut {
    cost: f32,
    axis: usize,
    at: usize,
}

fn best_cut<const N: usize>(bins: &Bins<N>, binning: &Binning<N>, axes: &Range<usize>, thin: f32) -> Option<Cut> {
    let mut best: Option<Cut> = None;
    for axis in axes.clone() {
        if binning.scale[axis] == 0.0 {
            continue;
        }
        let (boxes, counts) = (&bins.boxes[axis], &bins.counts[axis]);
        let mut right = [0.0_f32; N];
        let (mut all, mut count) = (Box4::EMPTY, 0);
        for i in (1..N).rev() {
            if counts[i] > 0 {
                all = all.union(boxes[i]);
                count += counts[i];
            }
            right[i] = cost(&all, count, thin);
        }
        let (mut all, mut count) = (Box4::EMPTY, 0);
        for i in 1..N {
            if counts[i - 1] == 0 {
                continue;
            }
            all = all.union(boxes[i - 1]);
            count += counts[i - 1];
            let cost = cost(&all, count, thin) + right[i];
            if best.is_none_or(|best| cost < best.cost) {
                best = Some(Cut { cost, axis, at: i });
            }
        }
    }
    best.filter(|cut| cut.cost > 0.0 && cut.cost.is_finite())
}

/// What testing so many primitives in a box costs.
pub(super) fn cost(b: &Box4, count: u32, thin: f32) -> f32 {
    size(b, thin) * count.div_ceil(TOGETHER) as f32
}

/// How a set is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum How {
    /// Where the heuristic is least on any axis, or of small sets on the longest one.
    ByArea,
    /// Where it is least on the axis along which the centres reach farthest.
    AlongLongest,
    ByCount,
}

/// Puts `refs`, at least two, in an order in which they are cut in two; returns how many are on the left and what is
/// known of both sides.
pub(super) fn split(refs: &mut [Ref], bounds: &Bounds, how: How) -> (usize, Bounds, Bounds) {
    let axes = match how {
        How::ByArea if refs.len() >= MANY => 0..3,
        How::ByArea | How::AlongLongest => {
            let axis = bounds.centers.extent().max_position();
            axis..axis + 1
        }
        How::ByCount => return halve(refs, bounds),
    };
    let parted = match refs.len() {
        few if few <= FEW_ENOUGH_TO_SORT => by_order(refs, bounds),
        ..1024 => by_area::<16>(refs, bounds, axes),
        _ => by_area::<32>(refs, bounds, axes),
    };
    parted.unwrap_or_else(|| halve(refs, bounds))
}

/// Boxes are large that have more than this part of the surface around all.
const LARGE: f32 = 0.2;

/// The most that are large, as a part of all.
const FEW: usize = 16;

fn by_area<const N: usize>(refs: &mut [Ref], bounds: &Bounds, axes: Range<usize>) -> Option<(usize, Bounds, Bounds)> {
    let thin = bounds.thin();
    let large = LARGE * size(&bounds.boxes, 0.0);
    let (binning, bins) = count::<N>(refs, bounds, &axes, large)?;
    let cut = best_cut(&bins, &binning, &axes, thin)?;
    // Some large boxes among many small ones, as walls are, make every cut's sides large. Where it pays they go first.
    if bins.large > 0 && bins.large as usize <= refs.len() / FEW {
        let apart = part(refs, |r| r.half_area() > large);
        let (middle, _, rest) = &apart;
        let (binning, bins) = count::<N>(&refs[*middle..], rest, &axes, f32::INFINITY)?;
        let next = best_cut(&bins, &binning, &axes, thin).map_or(f32::INFINITY, |cut| cut.cost);
        if cost(&bounds.boxes, *middle as u32, thin) + next < cut.cost {
            return Some(apart);
        }
    }
    Some(part(refs, |r| binning.bins(r)[cut.axis] < cut.at))
}

fn count<const N: usize>(
    refs: &[Ref],
    bounds: &Bounds,
    axes: &Range<usize>,
    large: f32,
) -> Option<(Binning<N>, Bins<N>)> {
    let binning = Binning::<N>::new(bounds);
    let bins = if refs.len() < PARALLEL {
        Bins::of(refs, &binning, axes, large)
    } else {
        refs.par_chunks(PARALLEL / 4)
            .map(|refs| Bins::of(refs, &binning, axes, large))
            .reduce_with(Bins::union)?
    };
    Some((binning, bins))
}

/// So few are sorted rather than counted in bins.
const FEW_ENOUGH_TO_SORT: usize = 12;

/// From so many on all axes are looked at: below, the longest is the best nearly always.
const MANY: usize = 64;

/// Tries every cut along the axis on which the centres reach farthest.
fn by_order(refs: &mut [Ref], bounds: &Bounds) -> Option<(usize, Bounds, Bounds)> {
    let axis = bounds.centers.extent().max_position();
    let key = |r: &Ref| r.min[axis] + r.max[axis];
    for i in 1..refs.len() {
        let moving = refs[i];
        let at = key(&moving);
        let mut to = i;
        while to > 0 && key(&refs[to - 1]) > at {
            refs[to] = refs[to - 1];
            to -= 1;
        }
        refs[to] = moving;
    }
    let (count, thin) = (refs.len(), bounds.thin());
    let mut right = [0.0_f32; FEW_ENOUGH_TO_SORT];
    let mut all = Box4::EMPTY;
    for i in (1..count).rev() {
        all.add(&refs[i]);
        right[i] = cost(&all, (count - i) as u32, thin);
    }
    let (mut best, mut middle) = (f32::INFINITY, 0);
    let mut all = Box4::EMPTY;
    for i in 1..count {
        all.add(&refs[i - 1]);
        let cost = cost(&all, i as u32, thin) + right[i];
        if cost < best {
            (best, middle) = (cost, i);
        }
    }
    if !(best > 0.0 && best.is_finite()) {
        return None;
    }
    let mut sides = [Bounds::EMPTY; 2];
    refs[..middle].iter().for_each(|r| sides[0].add(r));
    refs[middle..].iter().for_each(|r| sides[1].add(r));
    Some((middle, sides[0], sides[1]))
}

/// Moves those that are `left` to the front.
fn part(refs: &mut [Ref], left: impl Fn(&Ref) -> bool) -> (usize, Bounds, Bounds) {
    let (mut a, mut b) = (Bounds::EMPTY, Bounds::EMPTY);
    let (mut i, mut end) = (0, refs.len());
    loop {
        while i < end && left(&refs[i]) {
            a.add(&refs[i]);
            i += 1;
        }
        while i < end && !left(&refs[end - 1]) {
            end -= 1;
            b.add(&refs[end]);
        }
        if i >= end {
            return (i, a, b);
        }
        refs.swap(i, end - 1);
    }
}

/// Cuts by count along the axis on which the centres reach farthest; where they are all in one place, the small boxes
/// from the large ones.
fn halve(refs: &mut [Ref], bounds: &Bounds) -> (usize, Bounds, Bounds) {
    let extent = bounds.centers.extent();
    let axis = extent.max_position();
    let middle = refs.len() / 2;
    if extent[axis] > 0.0 {
        let key = |r: &Ref| (r.min[axis] + r.max[axis], r.index());
        refs.select_nth_unstable_by(middle, |a, b| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        });
    } else {
        let key = |r: &Ref| (r.max - r.min).truncate().element_sum();
        refs.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.index().cmp(&b.index())));
    }
    let (left, right) = refs.split_at(middle);
    (middle, Bounds::of(left), Bounds::of(right))
}
