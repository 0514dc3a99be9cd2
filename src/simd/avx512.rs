//! The SIMD level of processors with AVX-512 (F, VL, DQ, BW): sixteen floats per register, and mask
//! registers.
//!
//! Compaction of eight lanes uses the table of AVX2. The compress instruction (`vpcompressd`) and
//! the move of its mask have a higher latency, which makes ray streams 5 to 20 % slower on Zen 5.

use std::arch::x86_64::*;

use super::{
    avx2::{Avx2, F4, F8, Order},
    lanes::{Eight, Floats, Mask, SimdLevel, Top},
};

/// A token: the processor is known to have AVX-512 and everything that [`Avx2`] needs.
#[derive(Clone, Copy)]
pub struct Avx512(Avx2);

impl Avx512 {
    /// # Safety
    /// The processor has AVX-512 F, VL, DQ and BW, AVX2 and FMA.
    #[inline(always)]
    pub unsafe fn new() -> Self {
        // SAFETY: by this function's own contract.
        Self(unsafe { Avx2::new() })
    }
}

#[derive(Clone, Copy)]
pub struct F16(__m512);

impl Mask for __mmask16 {
    const LANES: u32 = 16;

    #[inline(always)]
    fn and(self, b: Self) -> Self {
        self & b
    }
    #[inline(always)]
    fn or(self, b: Self) -> Self {
        self | b
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
}

/// Declares the operations that are one instruction on two vectors.
macro_rules! operations {
    ({ $( $op:ident = $intrinsic:ident; )* } { $( $test:ident = $predicate:ident; )* }) => {
        $(
            #[inline(always)]
            fn $op(self, b: Self) -> Self {
                // SAFETY: the values came from a level's token.
                Self(unsafe { $intrinsic(self.0, b.0) })
            }
        )*
        $(
            #[inline(always)]
            fn $test(self, b: Self) -> __mmask16 {
                // SAFETY: the values came from a level's token.
                unsafe { _mm512_cmp_ps_mask::<$predicate>(self.0, b.0) }
            }
        )*
    };
}

impl Floats for F16 {
    type Mask = __mmask16;
    type Array = [f32; 16];

    operations! {
        {
            add = _mm512_add_ps; sub = _mm512_sub_ps; mul = _mm512_mul_ps; div = _mm512_div_ps;
            min = _mm512_min_ps; max = _mm512_max_ps;
        }
        { le = _CMP_LE_OQ; lt = _CMP_LT_OQ; eq = _CMP_EQ_OQ; ne = _CMP_NEQ_OQ; }
    }

    #[inline(always)]
    fn to_array(self) -> [f32; 16] {
        let mut a = [0.0; 16];
        // SAFETY: the value came from a level's token, and the array is as long as the vector.
        unsafe { _mm512_storeu_ps(a.as_mut_ptr(), self.0) };
        a
    }
    #[inline(always)]
    fn fill(self, x: f32) -> Self {
        // SAFETY: the value came from a level's token.
        Self(unsafe { _mm512_set1_ps(x) })
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        // SAFETY: the values came from a level's token.
        Self(unsafe { _mm512_fmadd_ps(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        // SAFETY: the values came from a level's token.
        Self(unsafe { _mm512_fmsub_ps(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: the value came from a level's token.
        Self(unsafe { _mm512_abs_ps(self.0) })
    }
    #[inline(always)]
    fn with_sign_of(self, b: Self) -> Self {
        // SAFETY: the values came from a level's token.
        Self(unsafe { _mm512_xor_ps(self.0, _mm512_and_ps(b.0, _mm512_set1_ps(-0.0))) })
    }
    #[inline(always)]
    fn select(self, mask: __mmask16, b: Self) -> Self {
        // SAFETY: the values came from a level's token.
        Self(unsafe { _mm512_mask_blend_ps(mask, b.0, self.0) })
    }
    #[inline(always)]
    fn reduce_min(self) -> f32 {
        // SAFETY: the value came from a level's token.
        unsafe { _mm512_reduce_min_ps(self.0) }
    }
    #[inline(always)]
    fn reduce_max(self) -> f32 {
        // SAFETY: the value came from a level's token.
        unsafe { _mm512_reduce_max_ps(self.0) }
    }
}

impl SimdLevel for Avx512 {
    const SIXTEEN: bool = true;

    type F4 = F4;
    type F8 = F8;
    type F16 = F16;
    type Order = Order;

    #[inline(always)]
    fn splat4(self, x: f32) -> F4 {
        self.0.splat4(x)
    }
    #[inline(always)]
    fn splat8(self, x: f32) -> F8 {
        self.0.splat8(x)
    }
    #[inline(always)]
    fn splat16(self, x: f32) -> F16 {
        // SAFETY: the token proves that the processor has AVX-512.
        F16(unsafe { _mm512_set1_ps(x) })
    }
    #[inline(always)]
    fn four8(self, x: &[f32; 4]) -> [F8; 4] {
        self.0.four8(x)
    }
    #[inline(always)]
    fn load4(self, x: &[f32; 4]) -> F4 {
        self.0.load4(x)
    }
    #[inline(always)]
    fn load8(self, x: &[f32; 8]) -> F8 {
        self.0.load8(x)
    }
    #[inline(always)]
    fn load16(self, x: &[f32; 16]) -> F16 {
        // SAFETY: the token proves that the processor has AVX-512; the array is as long as the
        // vector.
        F16(unsafe { _mm512_loadu_ps(x.as_ptr()) })
    }
    #[inline(always)]
    fn transpose(self, rows: [F8; 8]) -> [F8; 8] {
        self.0.transpose(rows)
    }
    #[inline(always)]
    fn rotate4(self, v: F4, last: usize) -> F4 {
        self.0.rotate4(v, last)
    }
    #[inline(always)]
    fn join(self, first: F8, second: F8) -> F16 {
        // SAFETY: the token proves that the processor has AVX-512.
        F16(unsafe { _mm512_insertf32x8::<1>(_mm512_castps256_ps512(first.0), second.0) })
    }
    #[inline(always)]
    fn join4(self, first: F4, second: F4) -> F8 {
        self.0.join4(first, second)
    }
    #[inline(always)]
    fn quads(self, v: F8) -> [F8; 4] {
        self.0.quads(v)
    }
    #[inline(always)]
    fn mask16(self, bits: u32) -> __mmask16 {
        bits as __mmask16
    }

    #[inline(always)]
    fn order(self, order: &[u32; 8], shift: &[u32; 4]) -> Order {
        self.0.order(order, shift)
    }

    #[inline(always)]
    fn met(self, enter: F8, leave: F8) -> Eight {
        self.0.met(enter, leave)
    }

    #[inline(always)]
    fn met_in(self, order: Order, enter: F8, leave: F8) -> Eight {
        self.0.met_in(order, enter, leave)
    }

    #[inline(always)]
    fn push(self, met: Eight, order: Order, enter: F8, child: &[u32; 8], to: Top) -> u32 {
        self.0.push(met, order, enter, child, to)
    }

    #[inline(always)]
    fn push_any(self, lanes: Eight, child: &[u32; 8], to: &mut [u32; 8]) -> u32 {
        self.0.push_any(lanes, child, to)
    }

    #[inline(always)]
    fn flags<const N: usize>(self, words: &[u32; N]) -> [u64; 2] {
        let mut bits = [0; 2];
        for (i, sixteen) in words.as_chunks::<16>().0.iter().enumerate() {
            // SAFETY: the token proves that the processor has AVX-512; the array is as long as the
            // vector.
            let [first, second] = unsafe {
                let sixteen = _mm512_loadu_si512(sixteen.as_ptr().cast());
                [
                    _mm512_test_epi32_mask(sixteen, _mm512_set1_epi32(1)),
                    _mm512_test_epi32_mask(sixteen, _mm512_set1_epi32(2)),
                ]
            };
            bits[0] |= u64::from(first) << (16 * i);
            bits[1] |= u64::from(second) << (16 * i);
        }
        bits
    }

    #[inline(always)]
    fn launder<T>(self, p: *mut T) -> *mut T {
        self.0.launder(p)
    }

    #[inline(always)]
    fn prefetch<const LINES: usize>(self, p: *const u8) {
        self.0.prefetch::<LINES>(p);
    }
}
