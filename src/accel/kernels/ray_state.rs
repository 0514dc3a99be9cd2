//! The state of an active ray, and its initialisation.

use super::ray_rows::{fours, numbers};
use crate::geometry::InstanceId;
use std::{mem::offset_of, ptr};

use super::{query::Best, traversal_state::TraversalState};
use crate::{
    geometry::{
        padding::BoundsPadding,
        slab::{END_PADDING, MAX_RECIPROCAL, MAX_T_NOISE, MIN_PADDING, ORIGIN_PADDING, Planes},
    },
    math::Ray,
    simd::lanes::{Floats, Mask, SimdLevel},
};

/// A bound on the distance by which the unclipped `t` of a hit may lie beyond the ray's ends. It is
/// more than [`MAX_T_NOISE`], to make up for a division that is omitted.
pub const BEYOND: f32 = 4.0 * MAX_T_NOISE;

/// The smallest component of a regular direction, and the largest coordinate of a regular origin, both
/// relative to the largest component of the direction. Then the distances to planes do not overflow.
const MIN_RELATIVE_COMPONENT: f32 = 1e-20;
const MAX_RELATIVE_ORIGIN: f32 = 1e18;

const _: () = assert!(
    MIN_RELATIVE_COMPONENT >= 2.0 / MAX_RECIPROCAL && MAX_RELATIVE_ORIGIN / MIN_RELATIVE_COMPONENT <= 0.5 * f32::MAX
);

/// An active ray, in two cache lines; the test of a node reads only the first one.
#[repr(C, align(64))]
#[derive(Clone, Default)]
pub struct RayState {
    /// The ray as in [`Planes`], with negated shifts.
    pub state: TraversalState,
    pub best: Best,
    /// The origin and the direction, in the order of [`RayState::axes`]. No hit has an unclipped
    /// `t` outside of `begin` and `until`.
    pub o: [f32; 3],
    pub begin: f32,
    pub d: [f32; 3],
    pub until: f32,
    /// See [`crate::shape::triangle::Shear`].
    pub shear: [f32; 2],
    /// The index of the ray.
    pub ray: u32,
    /// The order of the axes, the main axis last, as byte offsets of their rows in a vertex. The
    /// fourth element is unused.
    axes: [u8; 4],
}

const _: () =
    assert!(size_of::<RayState>() == 128 && offset_of!(RayState, o) == 80 && offset_of!(RayState, shear) == 112);

/// A row of a vertex: one coordinate of four triangles.
type CornerRow = [f32; 4];

const ROW: u8 = size_of::<CornerRow>() as u8;

/// [`RayState::axes`] for the index of the main axis plus one.
const AXES: [[u8; 4]; 4] = {
    let [x, y, z] = [0, ROW, 2 * ROW];
    [[x, y, z, 0], [y, z, x, 0], [z, x, y, 0], [x, y, z, 0]]
};

/// Returns the axis of an entry of [`RayState::axes`].
fn axis(entry: u8) -> usize {
    usize::from(entry / ROW)
}

/// Written out, since a closure over a part of an array is not always compiled with the
/// instructions of its caller.
#[inline(always)]
fn permute_axes(corner: &[CornerRow; 3], [x, y, z]: [usize; 3]) -> [&CornerRow; 3] {
    [row(corner, x), row(corner, y), row(corner, z)]
}

#[inline(always)]
fn row(corner: &[CornerRow; 3], place: usize) -> &CornerRow {
    debug_assert!(place.is_multiple_of(ROW.into()) && axis(place as u8) < 3);
    // SAFETY: a vertex has three rows, and offsets are those of [`AXES`].
    unsafe { &*corner.as_ptr().byte_add(place) }
}

/// The instances of a slot's ray.
#[derive(Clone, Copy)]
pub struct InstanceState {
    /// The instance that the ray is in.
    pub current: InstanceId,
    /// The instance of the nearest hit so far.
    pub best: InstanceId,
}

impl InstanceState {
    pub const NOTHING: Self = Self {
        current: InstanceId::NONE,
        best: InstanceId::NONE,
    };
}

/// The extent of a ray: [`TraversalState::tmin`], [`RayState::begin`], [`TraversalState::end`] and
/// [`RayState::until`].
struct Span {
    tmin: f32,
    begin: f32,
    end: f32,
    until: f32,
}

/// Returns three elements and a fourth one, to be stored at once.
#[inline(always)]
fn row_with<L: SimdLevel>(level: L, three: L::F4, fourth: f32) -> CornerRow {
    let of_three = level.load4(&[0.0, 0.0, 0.0, 1.0]).lt(level.splat4(0.5));
    three.select(of_three, level.splat4(fourth)).to_array()
}

impl RayState {
    /// Initialises the slot for a ray without an earlier result. Returns whether the ray can hit
    /// anything.
    #[inline(always)]
    pub fn start<L: SimdLevel>(&mut self, level: L, ray: &Ray, number: usize, padding: BoundsPadding) -> bool {
        self.best = Best::none(ray.tmax);
        self.ray = number as u32;
        self.state.stack.clear();
        let span = Span {
            tmin: ray.tmin,
            begin: ray.tmin - ray.tmin.abs() * BEYOND,
            end: ray.tmax * END_PADDING,
            until: ray.tmax + ray.tmax.abs() * BEYOND,
        };
        ray.tmin <= ray.tmax && self.set_line(level, ray, span, padding)
    }

    /// Continues along the line of `ray`, which is the slot's ray in another space. Returns whether
    /// it can hit anything.
    #[inline(always)]
    pub fn continue_along<L: SimdLevel>(&mut self, level: L, ray: &Ray, padding: BoundsPadding) -> bool {
        let span = Span {
            tmin: self.state.tmin,
            begin: self.begin,
            end: self.state.end,
            until: self.until,
        };
        self.set_line(level, ray, span, padding)
    }

    #[inline(always)]
    fn set_line<L: SimdLevel>(&mut self, level: L, ray: &Ray, span: Span, padding: BoundsPadding) -> bool {
        self.set_planes(level, ray, span, padding) || self.set_any_planes(ray, padding)
    }

    #[inline(always)]
    pub fn set_best(&mut self, best: Best) {
        self.best = best;
        self.state.end = best.t * END_PADDING;
        self.until = best.t + best.t.abs() * BEYOND;
    }

    /// Does what [`Shear::new`] does and, for a regular ray, what [`Planes::new`] does. Returns
    /// whether the ray is regular.
    ///
    /// [`Shear::new`]: crate::shape::triangle::Shear::new
    #[inline(always)]
    fn set_planes<L: SimdLevel>(&mut self, level: L, ray: &Ray, span: Span, padding: BoundsPadding) -> bool {
        // The fourth elements are unused.
        let [o, d] = fours(level, numbers(ray));
        let (away, length) = (o.abs(), d.abs());
        let inv = level.splat4(1.0).div(d);

        // The last one of the axes along which the direction is longest.
        let longest = length.max(level.rotate4(length, 1)).max(level.rotate4(length, 2));
        let main = ((length.eq(longest).bits() & 0b111) << 1 | 1).ilog2() as usize & 3;
        self.axes = AXES[main];
        let turned = level.rotate4(d, main);
        // From the register, since a load would have to wait for the store above.
        let [_, _, inv_main, _] = level.rotate4(inv, main).to_array();
        let [x, y, ..] = turned.mul(level.splat4(inv_main)).to_array();
        self.shear = [x, y];
        let [line, ends] = self.line_mut();
        *line = row_with(level, level.rotate4(o, main), span.begin);
        *ends = row_with(level, turned, span.until);

        let negative = d.lt(level.splat4(0.0));
        let mut pad = away
            .mul(level.splat4(ORIGIN_PADDING))
            .add(level.splat4(4.0 * MIN_PADDING));
        if padding.origin != 0.0 {
            let most = away.max(level.rotate4(away, 1)).max(level.rotate4(away, 2));
            pad = pad.add(most.mul(level.splat4(padding.origin)));
        }
        let (less, more) = (o.sub(pad), o.add(pad));
        let back = inv.mul(level.splat4(-1.0));
        let near = less.select(negative, more).mul(back);
        let far = more.select(negative, less).mul(back);
        *self.state.rows_mut() = [
            row_with(level, inv, span.tmin),
            row_with(level, near, span.end),
            row_with(level, far, 0.0),
        ];
        self.state.set_octant(negative.bits());

        let steep = longest
            .mul(level.splat4(MIN_RELATIVE_COMPONENT))
            .max(level.splat4(f32::MIN_POSITIVE));
        let reach = longest.mul(level.splat4(MAX_RELATIVE_ORIGIN));
        let ordinary = steep.lt(length).and(away.le(reach)).bits();
        ordinary & 0b111 == 0b111 && ray.tmin >= 0.0
    }

    /// Does what [`Planes::new`] does, for any ray. Returns whether the ray can hit anything.
    #[cold]
    fn set_any_planes(&mut self, ray: &Ray, padding: BoundsPadding) -> bool {
        let planes = Planes::new(ray, padding);
        self.state.inv = planes.inv.to_array();
        self.state.near = (-planes.shift_near).to_array();
        self.state.far = (-planes.shift_far).to_array();
        self.state
            .set_octant((0..3).map(|axis| u32::from(planes.negative[axis]) << axis).sum());
        planes.can_hit
    }

    /// Returns [`RayState::o`] and [`RayState::begin`], [`RayState::d`] and [`RayState::until`],
    /// [`RayState::shear`] and the two fields after it.
    #[inline(always)]
    pub fn line(&self) -> &[[f32; 4]; 3] {
        // SAFETY: this is the layout of the fields, and every bit pattern is a valid number.
        unsafe { &*ptr::from_ref(self).byte_add(offset_of!(Self, o)).cast() }
    }

    /// Returns the first two rows of [`RayState::line`].
    #[inline(always)]
    fn line_mut(&mut self) -> [&mut CornerRow; 2] {
        // SAFETY: this is the layout of the fields.
        let [o, d] = unsafe {
            &mut *ptr::from_mut(self)
                .byte_add(offset_of!(Self, o))
                .cast::<[CornerRow; 2]>()
        };
        [o, d]
    }

    /// Returns the rows of vertices in the order of the axes.
    #[inline(always)]
    pub fn permute_axes<'a>(&self, [a, b, c]: &'a [[CornerRow; 3]; 3]) -> [[&'a CornerRow; 3]; 3] {
        let places = [self.place(0), self.place(1), self.place(2)];
        [
            permute_axes(a, places),
            permute_axes(b, places),
            permute_axes(c, places),
        ]
    }

    /// Returns the byte offset of an axis's row in a vertex.
    #[inline(always)]
    fn place(&self, k: usize) -> usize {
        // SAFETY: a normal read. It is volatile so that the compiler does not load a vector and
        // extract its elements.
        usize::from(unsafe { ptr::read_volatile(&self.axes[k]) })
    }

    /// Returns the argument of [`rotate4`](crate::simd::lanes::EightLanes::rotate4) that permutes world axes to the slot's order.
    #[inline(always)]
    pub fn last(&self) -> usize {
        self.place(0) / size_of::<CornerRow>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::Vec3,
        shape::triangle::Shear,
        simd::{lanes::EightLanes, portable::Portable},
    };

    #[test]
    fn lines_are_sheared_as_by_the_scalar_routine_whatever_axes_tie() {
        let padding = BoundsPadding {
            reach: 1.0,
            origin: 0.0,
        };
        let numbers = [-2.0, -1.0, -1e-30, -0.0, 0.0, 0.3, 1.0, 2.0];
        for d in numbers.iter().flat_map(|&x| {
            let with_y = move |&y| numbers.map(|z| Vec3::new(x, y, z));
            numbers.iter().flat_map(with_y).collect::<Vec<_>>()
        }) {
            let mut slot = RayState::default();
            let ray = Ray::new(Vec3::new(0.1, 0.2, 0.3), d);
            if !slot.continue_along(Portable, &ray, padding) {
                assert!(d.abs().max_element() == 0.0, "{d}");
                continue;
            }
            let shear = Shear::new(&d);
            assert_eq!(slot.axes.map(axis)[..3], shear.axes, "{d}");
            assert_eq!(slot.shear, [shear.x, shear.y], "{d}");
            assert_eq!(slot.o, shear.permute(&ray.o).to_array());
            assert_eq!(slot.d, shear.permute(&d).to_array());
            let o = Portable.load4(&[ray.o.x, ray.o.y, ray.o.z, 0.0]);
            assert_eq!(Portable.rotate4(o, slot.last()).to_array()[..3], slot.o, "{d}");
            assert_eq!(slot.state.negative(), [d.x, d.y, d.z].map(f32::is_sign_negative), "{d}");
        }
    }
}
