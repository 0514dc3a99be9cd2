//! What a kernel asks of a processor: floats side by side, in three widths.
//!
//! A kernel is written once over [`SimdLevel`] and compiled once for each level, inside a function that enables the level's
//! instructions. A level's type is a token: to have one is to know that the processor can do it, so the operations
//! themselves are safe.

use crate::math::Dispatch;

/// Floats side by side.
///
/// Every operation rounds as the scalar one does, so all levels give the same bits; [`Floats::mul_add`] and
/// [`Floats::mul_sub`] alone may or may not round in between.
pub trait Floats: Copy {
    type Mask: Mask;
    /// `[f32; lanes]`.
    type Array: Copy;

    fn to_array(self) -> Self::Array;
    /// `x` in every lane; `self` only says of what kind.
    fn fill(self, x: f32) -> Self;
    fn add(self, b: Self) -> Self;
    fn sub(self, b: Self) -> Self;
    fn mul(self, b: Self) -> Self;
    fn div(self, b: Self) -> Self;
    /// `self * b + c`.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// `self * b - c`.
    fn mul_sub(self, b: Self, c: Self) -> Self;
    /// The smaller one; `b` where either is NaN.
    fn min(self, b: Self) -> Self;
    /// The larger one; `b` where either is NaN.
    fn max(self, b: Self) -> Self;
    fn abs(self) -> Self;
    /// Negated where `b` is negative.
    fn with_sign_of(self, b: Self) -> Self;
    fn le(self, b: Self) -> Self::Mask;
    fn lt(self, b: Self) -> Self::Mask;
    fn eq(self, b: Self) -> Self::Mask;
    /// Whether they differ; false where either is NaN.
    fn ne(self, b: Self) -> Self::Mask;
    /// `self` where `mask` is set, `b` elsewhere.
    fn select(self, mask: Self::Mask, b: Self) -> Self;
    fn reduce_min(self) -> f32;
    fn reduce_max(self) -> f32;
}

/// One bit for each lane.
pub trait Mask: Copy {
    const LANES: u32;

    fn and(self, b: Self) -> Self;
    fn or(self, b: Self) -> Self;
    fn bits(self) -> u32;
}

/// A set of eight: a bit for each.
#[derive(Clone, Copy)]
pub struct Eight(u32);

impl Eight {
    /// # Safety
    /// Only the lowest eight bits are set.
    #[inline(always)]
    pub unsafe fn new(bits: u32) -> Self {
        Self(bits)
    }

    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.0
    }
}

/// Where the children that a ray meets go: before those in its two lists.
pub struct Top<'a> {
    pub enter: &'a mut [f32; 8],
    pub child: &'a mut [u32; 8],
}

/// What a processor can do.
pub trait SimdLevel: Dispatch {
    /// Whether sixteen floats are one vector.
    const SIXTEEN: bool;

    type F4: Floats<Array = [f32; 4]>;
    type F8: Floats<Array = [f32; 8]>;
    type F16: Floats<Array = [f32; 16]>;
    /// Which of a node's children comes at each place.
    type Order: Copy;

    fn splat4(self, x: f32) -> Self::F4;
    fn splat8(self, x: f32) -> Self::F8;
    fn splat16(self, x: f32) -> Self::F16;
    /// Each of them in all lanes.
    fn four8(self, x: &[f32; 4]) -> [Self::F8; 4];
    fn load4(self, x: &[f32; 4]) -> Self::F4;
    fn load8(self, x: &[f32; 8]) -> Self::F8;
    fn load16(self, x: &[f32; 16]) -> Self::F16;
    /// Eight vectors' first lanes in one, then their second ones and so on.
    fn transpose(self, rows: [Self::F8; 8]) -> [Self::F8; 8];
    /// The first three lanes, turned so that lane `last - 1` comes last; as they are for a `last` of zero.
    fn turn4(self, v: Self::F4, last: usize) -> Self::F4;
    fn join(self, first: Self::F8, second: Self::F8) -> Self::F16;
    fn join4(self, first: Self::F4, second: Self::F4) -> Self::F8;
    /// Of both halves the first number in all lanes of that half, then the second one and so on.
    fn quads(self, v: Self::F8) -> [Self::F8; 4];
    /// The lanes whose bits are set.
    fn mask16(self, bits: u32) -> <Self::F16 as Floats>::Mask;

    /// That of a node's `order` from bit `shift` on; the first two of which are one number of 64 bits.
    fn order(self, order: &[u32; 8], shift: &[u32; 4]) -> Self::Order;

    /// The lanes in which `enter` is at most `leave`.
    fn met(self, enter: Self::F8, leave: Self::F8) -> Eight;

    /// The lanes in which `enter` is at most `leave`, as [`SimdLevel::push`] wants them: themselves or their places in the order.
    fn met_in(self, order: Self::Order, enter: Self::F8, leave: Self::F8) -> Eight;

    /// Writes the children that are met in their order to the end of `to`, with their `enter`; what is before them is undefined.
    /// Returns how many there are.
    fn push(self, met: Eight, order: Self::Order, enter: Self::F8, child: &[u32; 8], to: Top) -> u32;

    /// Writes the children of these lanes to the end of `to`, as they come; returns how many there are.
    fn push_any(self, lanes: Eight, child: &[u32; 8], to: &mut [u32; 8]) -> u32;

    /// The sets of those `words` whose lowest bit, and whose second lowest one, is set; a multiple of sixteen of them, at
    /// most 64.
    fn flags<const N: usize>(self, words: &[u32; N]) -> [u64; 2];

    /// The place of each of the `keys`, of which no two are the same, in their order; a multiple of sixteen of them, at most
    /// 64.
    fn places<const N: usize>(self, keys: &[i16; N]) -> [i16; N];

    /// The same address, in a register of its own: the compiler would rather add up its parts at every use, and lacks
    /// registers for them.
    fn launder<T>(self, p: *mut T) -> *mut T;

    /// Asks for the cache lines at `p`, 64 bytes each.
    fn prefetch<const LINES: usize>(self, p: *const u8);
}
