//! What a kernel asks of a processor: floats side by side, in three widths.
//!
//! A kernel is written once over [`Level`] and compiled once for each level, inside a function that enables the level's
//! instructions. A level's type is a token: to have one is to know that the processor can do it, so the operations
//! themselves are safe.

use crate::math::Runner;

/// Floats side by side.
///
/// Every operation rounds as the scalar one does, so all levels give the same bits; [`Floats::mul_sub`] alone may or
/// may not round in between.
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
    fn differs(self, b: Self) -> Self::Mask;
    /// `self` where `mask` is set, `b` elsewhere.
    fn select(self, mask: Self::Mask, b: Self) -> Self;
    fn lowest(self) -> f32;
    fn highest(self) -> f32;
}

/// One bit for each lane.
pub trait Mask: Copy {
    fn and(self, b: Self) -> Self;
    fn or(self, b: Self) -> Self;
    fn bits(self) -> u32;
}

/// Where the children that a ray meets go: the ends of its two lists.
pub struct Top<'a> {
    pub enter: &'a mut [f32; 8],
    pub child: &'a mut [u32; 8],
}

/// What a processor can do.
pub trait Level: Runner {
    type F4: Floats<Array = [f32; 4]>;
    type F8: Floats<Array = [f32; 8]>;
    type F16: Floats<Array = [f32; 16]>;

    fn splat4(self, x: f32) -> Self::F4;
    fn splat8(self, x: f32) -> Self::F8;
    fn splat16(self, x: f32) -> Self::F16;
    fn load4(self, x: &[f32; 4]) -> Self::F4;
    fn load8(self, x: &[f32; 8]) -> Self::F8;
    fn load16(self, x: &[f32; 16]) -> Self::F16;
    /// Eight vectors' first lanes in one, then their second ones and so on.
    fn transpose(self, rows: [Self::F8; 8]) -> [Self::F8; 8];
    fn join(self, first: Self::F8, second: Self::F8) -> Self::F16;
    /// The lanes whose bits are set.
    fn mask16(self, bits: u32) -> <Self::F16 as Floats>::Mask;

    /// Writes those of `child` whose `enter` is at most `leave`, in the order that `order >> shift` gives, with their
    /// `enter`; what is behind them in `to` is undefined. Returns how many there are, and the last of them.
    fn push_ordered(
        self,
        enter: Self::F8,
        leave: Self::F8,
        child: &[u32; 8],
        order: &[u32; 8],
        shift: u32,
        to: Top,
    ) -> (usize, u32);

    /// Writes those of `child` whose `enter` is at most `leave`, as they come.
    fn push_any(self, enter: Self::F8, leave: Self::F8, child: &[u32; 8], to: &mut [u32; 8]) -> usize;

    /// The sets of those `words` whose highest bit, and whose second highest one, is set; a multiple of sixteen of them, at
    /// most 64.
    fn top_bits<const N: usize>(self, words: &[u32; N]) -> [u64; 2];

    /// The place of each of the `keys`, of which no two are the same, in their order; a multiple of sixteen of them, at most
    /// 64.
    fn places<const N: usize>(self, keys: &[i16; N]) -> [i16; N];

    /// Asks for the cache lines at `p`, 64 bytes each.
    fn prefetch<const LINES: usize>(self, p: *const u8);
}
