//! The SIMD level of processors with AVX-512 (F and VL alone, see [`dispatch`](super::dispatch)): sixteen floats
//! per register, and mask registers.
//!
//! Compaction of eight lanes uses the table of AVX2. The compress instruction (`vpcompressd`) and
//! the move of its mask have a higher latency, which makes ray streams 5 to 20 % slower on Zen 5.

use std::arch::x86_64::*;

use super::{
    avx2::{Avx, F8, floats},
    lanes::{Floats, Mask, SimdLevel, operations},
};

pub type Avx512 = Avx<true>;

floats! {
    F16(__m512), M16(__mmask16), 16,
    _mm512_storeu_ps, _mm512_set1_ps, blend, and, xor, andnot,
    {
        add = _mm512_add_ps; sub = _mm512_sub_ps; mul = _mm512_mul_ps; div = _mm512_div_ps;
        min = _mm512_min_ps; max = _mm512_max_ps;
    }
    {
        le = _mm512_cmp_ps_mask::<_CMP_LE_OQ>; lt = _mm512_cmp_ps_mask::<_CMP_LT_OQ>;
        eq = _mm512_cmp_ps_mask::<_CMP_EQ_OQ>; ne = _mm512_cmp_ps_mask::<_CMP_NEQ_OQ>;
    }
    { and = _kand_mask16; or = _kor_mask16; }
    _cvtmask16_u32 _mm512_fmadd_ps _mm512_fmsub_ps _mm512_reduce_min_ps _mm512_reduce_max_ps
}

/// Returns `b` where `mask` is set, `a` elsewhere.
///
/// # Safety
/// The processor has AVX-512 F.
#[inline(always)]
unsafe fn blend(a: __m512, b: __m512, mask: __mmask16) -> __m512 {
    // SAFETY: by this function's own contract.
    unsafe { _mm512_mask_blend_ps(mask, a, b) }
}

/// Declares operations on the bits of floats, by the instructions for integers: those for floats are of AVX-512 DQ.
macro_rules! bitwise {
    ($( $name:ident = $instruction:ident; )*) => {
        $(
            /// # Safety
            /// The processor has AVX-512 F.
            #[inline(always)]
            unsafe fn $name(a: __m512, b: __m512) -> __m512 {
                // SAFETY: by this function's own contract.
                unsafe { _mm512_castsi512_ps($instruction(_mm512_castps_si512(a), _mm512_castps_si512(b))) }
            }
        )*
    };
}

bitwise! {
    and = _mm512_and_si512;
    xor = _mm512_xor_si512;
    andnot = _mm512_andnot_si512;
}

impl SimdLevel for Avx512 {
    const SIXTEEN: bool = true;

    type F16 = F16;

    #[inline(always)]
    fn splat16(self, x: f32) -> F16 {
        // SAFETY: the token proves that the processor has AVX-512.
        F16(unsafe { _mm512_set1_ps(x) })
    }
    #[inline(always)]
    fn load16(self, x: &[f32; 16]) -> F16 {
        // SAFETY: the token proves that the processor has AVX-512; the array is as long as the
        // vector.
        F16(unsafe { _mm512_loadu_ps(x.as_ptr()) })
    }
    #[inline(always)]
    fn join(self, first: F8, second: F8) -> F16 {
        // SAFETY: the token proves that the processor has AVX-512.
        F16(unsafe {
            let (first, second) = (_mm512_castps256_ps512(first.0), _mm256_castps_pd(second.0));
            _mm512_castpd_ps(_mm512_insertf64x4::<1>(_mm512_castps_pd(first), second))
        })
    }
    #[inline(always)]
    fn mask16(self, bits: u32) -> M16 {
        M16(bits as __mmask16)
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
}
