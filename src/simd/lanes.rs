//! The contract of a SIMD level: vectors of floats in three widths.
//!
//! A kernel is written once over [`SimdLevel`] and compiled once for each level, inside a function
//! that enables the level's instructions. A level's type is a token that proves that the processor
//! has the instructions, so the operations themselves are safe.

#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
use std::arch::asm;

use super::prefetch::prefetch_line;
use crate::math::Dispatch;

/// A vector of floats.
///
/// Every operation rounds as the scalar one does, so all levels give the same bits. Only
/// [`Floats::mul_add`] and [`Floats::mul_sub`] may be fused or not.
pub trait Floats: Copy {
    type Mask: Mask;
    /// `[f32; lanes]`.
    type Array: Copy;

    fn to_array(self) -> Self::Array;
    /// Returns a vector of the same type as `self` with `x` in every lane.
    fn fill(self, x: f32) -> Self;
    fn add(self, b: Self) -> Self;
    fn sub(self, b: Self) -> Self;
    fn mul(self, b: Self) -> Self;
    fn div(self, b: Self) -> Self;
    /// `self * b + c`.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// `self * b - c`.
    fn mul_sub(self, b: Self, c: Self) -> Self;
    /// The minimum; `b` where either is NaN.
    fn min(self, b: Self) -> Self;
    /// The maximum; `b` where either is NaN.
    fn max(self, b: Self) -> Self;
    fn abs(self) -> Self;
    /// Negates the lanes in which `b` is negative.
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

/// A mask with one bit per lane.
pub trait Mask: Copy {
    const LANES: u32;

    fn and(self, b: Self) -> Self;
    fn or(self, b: Self) -> Self;
    fn bits(self) -> u32;
    /// The bits of `self` below those of `next`.
    #[inline(always)]
    fn bits_of_two(self, next: Self) -> u32 {
        self.bits() | next.bits() << Self::LANES
    }
}

/// A set of eight lanes, one bit each.
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

/// The destination of the children that a ray hits: the memory before the top of its two stacks.
pub struct Top<'a> {
    pub enter: &'a mut [f32; 8],
    pub child: &'a mut [u32; 8],
}

/// The operations of a SIMD level on four and on eight floats.
pub trait EightLanes: Copy {
    type F4: Floats<Array = [f32; 4]>;
    type F8: Floats<Array = [f32; 8]>;
    /// The order of a node's children: the child at each place.
    type Order: Copy;

    fn splat4(self, x: f32) -> Self::F4;
    #[inline(always)]
    fn splat8(self, x: f32) -> Self::F8 {
        self.join4(self.splat4(x), self.splat4(x))
    }
    /// Broadcasts each element to all lanes of a vector.
    #[inline(always)]
    fn four8(self, x: &[f32; 4]) -> [Self::F8; 4] {
        x.map(|x| self.splat8(x))
    }
    fn load4(self, x: &[f32; 4]) -> Self::F4;
    #[inline(always)]
    fn load8(self, x: &[f32; 8]) -> Self::F8 {
        let (halves, _) = x.as_chunks::<4>();
        self.join4(self.load4(&halves[0]), self.load4(&halves[1]))
    }
    /// Transposes an 8 x 8 matrix.
    fn transpose(self, rows: [Self::F8; 8]) -> [Self::F8; 8];
    /// Rotates the first three lanes so that lane `last - 1` comes last. Zero keeps the order.
    fn rotate4(self, v: Self::F4, last: usize) -> Self::F4;
    fn join4(self, first: Self::F4, second: Self::F4) -> Self::F8;
    /// Broadcasts element `k` of each half to all lanes of that half, for `k` from 0 to 3.
    fn quads(self, v: Self::F8) -> [Self::F8; 4];

    /// Returns a node's `order` from bit `shift` on. The first two elements of `shift` are one
    /// 64-bit number.
    fn order(self, order: &[u32; 8], shift: &[u32; 4]) -> Self::Order;

    /// Returns the lanes in which `enter` is at most `leave`.
    #[inline(always)]
    fn met(self, enter: Self::F8, leave: Self::F8) -> Eight {
        // SAFETY: the mask has eight lanes.
        unsafe { Eight::new(enter.le(leave).bits()) }
    }

    /// Returns the lanes in which `enter` is at most `leave`, in the form that [`EightLanes::push`]
    /// expects: as lanes or as places in the order.
    fn met_in(self, order: Self::Order, enter: Self::F8, leave: Self::F8) -> Eight;

    /// Writes the children in `met`, in order and with their `enter`, to the end of `to`. The
    /// elements before them are undefined. Returns the number of children.
    fn push(self, met: Eight, order: Self::Order, enter: Self::F8, child: &[u32; 8], to: Top) -> u32;

    /// Writes the children of these lanes, in storage order, to the end of `to`. Returns the number
    /// of children.
    fn push_any(self, lanes: Eight, child: &[u32; 8], to: &mut [u32; 8]) -> u32;

    /// Returns [`SimdLevel::flags`] of eight words.
    fn flags8(self, words: &[u32; 8]) -> [u64; 2];

    /// Returns the same address in a register of its own. The compiler would recompute it at every
    /// use otherwise, for which there are too few registers.
    #[cfg_attr(
        any(target_arch = "x86_64", target_arch = "aarch64"),
        expect(clippy::pointers_in_nomem_asm_block, reason = "nothing looks at what is there")
    )]
    #[inline(always)]
    fn launder<T>(self, p: *mut T) -> *mut T {
        // Miri runs no assembly.
        if cfg!(miri) {
            return p;
        }
        #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
        let p = {
            let same;
            // SAFETY: the assembly contains no instruction.
            unsafe { asm!("/* {0} */", inout(reg) p => same, options(pure, nomem, nostack, preserves_flags)) };
            same
        };
        p
    }

    /// Prefetches `LINES` cache lines of 64 bytes from `p` on, on processors that have an instruction for it.
    #[inline(always)]
    fn prefetch<const LINES: usize>(self, p: *const u8) {
        for line in 0..LINES {
            prefetch_line(p.wrapping_add(64 * line));
        }
    }
}

/// The operations of a SIMD level.
pub trait SimdLevel: EightLanes + Dispatch {
    /// Whether sixteen floats fit into one vector.
    const SIXTEEN: bool = false;

    type F16: Floats<Array = [f32; 16]>;

    #[inline(always)]
    fn splat16(self, x: f32) -> Self::F16 {
        self.join(self.splat8(x), self.splat8(x))
    }
    #[inline(always)]
    fn load16(self, x: &[f32; 16]) -> Self::F16 {
        let (halves, _) = x.as_chunks::<8>();
        self.join(self.load8(&halves[0]), self.load8(&halves[1]))
    }
    fn join(self, first: Self::F8, second: Self::F8) -> Self::F16;
    /// Returns the mask with the lanes whose bits are set.
    fn mask16(self, bits: u32) -> <Self::F16 as Floats>::Mask;

    /// Returns two sets: the words whose lowest bit is set, and those whose second lowest bit is
    /// set. `N` is a multiple of sixteen and at most 64.
    #[inline(always)]
    fn flags<const N: usize>(self, words: &[u32; N]) -> [u64; 2] {
        let mut bits = [0; 2];
        for (i, eight) in words.as_chunks::<8>().0.iter().enumerate() {
            let [first, second] = self.flags8(eight);
            bits[0] |= first << (8 * i);
            bits[1] |= second << (8 * i);
        }
        bits
    }
}

/// Implements operations on two vectors that are one intrinsic each: those that return a vector,
/// and those that return a mask of this type.
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
macro_rules! operations {
    ($mask:ident { $( $op:ident = $intrinsic:path; )* } { $( $test:ident = $predicate:path; )* }) => {
        $(
            #[inline(always)]
            fn $op(self, b: Self) -> Self {
                // SAFETY: the values came from a level's token.
                Self(unsafe { $intrinsic(self.0, b.0) })
            }
        )*
        $(
            #[inline(always)]
            fn $test(self, b: Self) -> $mask {
                // SAFETY: the values came from a level's token.
                $mask(unsafe { $predicate(self.0, b.0) })
            }
        )*
    };
}
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
pub(super) use operations;
