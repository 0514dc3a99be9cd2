//! The SIMD level of processors with AVX2 and FMA.

use std::{
    arch::{asm, x86_64::*},
    ptr,
};

use super::{
    compact_table::COMPACT_LANES,
    lanes::{Eight, EightLanes, Floats, Mask, SimdLevel, Top, operations},
    pair::Pair,
};

/// A token: the processor is known to have AVX2 and FMA, and AVX-512 (F, VL) if `SIXTEEN`.
#[derive(Clone, Copy)]
pub struct Avx<const SIXTEEN: bool>(());

pub type Avx2 = Avx<false>;

impl<const SIXTEEN: bool> Avx<SIXTEEN> {
    /// # Safety
    /// The processor has AVX2 and FMA, and AVX-512 F and VL if `SIXTEEN`.
    #[inline(always)]
    pub unsafe fn new() -> Self {
        Self(())
    }
}

/// Declares one width of floats with its mask and its operations.
macro_rules! floats {
    (
        $floats:ident($raw:ty), $mask:ident($raw_mask:ty), $lanes:literal,
        $store:ident, $splat:ident, $blend:ident, $and:ident, $xor:ident, $andnot:ident,
        $operations:tt $tests:tt $mask_operations:tt
        $movemask:ident $fmadd:ident $fmsub:ident $reduce_min:ident $reduce_max:ident
    ) => {
        #[derive(Clone, Copy)]
        pub struct $floats(pub(super) $raw);

        #[derive(Clone, Copy)]
        pub struct $mask(pub(super) $raw_mask);

        impl Floats for $floats {
            type Mask = $mask;
            type Array = [f32; $lanes];

            operations! { $mask $operations $tests }

            #[inline(always)]
            fn to_array(self) -> [f32; $lanes] {
                let mut a = [0.0; $lanes];
                // SAFETY: the value came from a level's token, and the array is as long as the vector.
                unsafe { $store(a.as_mut_ptr(), self.0) };
                a
            }
            #[inline(always)]
            fn fill(self, x: f32) -> Self {
                // SAFETY: the value came from a level's token.
                Self(unsafe { $splat(x) })
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                // SAFETY: the values came from a level's token.
                Self(unsafe { $fmadd(self.0, b.0, c.0) })
            }
            #[inline(always)]
            fn mul_sub(self, b: Self, c: Self) -> Self {
                // SAFETY: the values came from a level's token.
                Self(unsafe { $fmsub(self.0, b.0, c.0) })
            }
            #[inline(always)]
            fn abs(self) -> Self {
                // SAFETY: the value came from a level's token.
                Self(unsafe { $andnot($splat(-0.0), self.0) })
            }
            #[inline(always)]
            fn with_sign_of(self, b: Self) -> Self {
                // SAFETY: the values came from a level's token.
                Self(unsafe { $xor(self.0, $and($splat(-0.0), b.0)) })
            }
            #[inline(always)]
            fn select(self, mask: $mask, b: Self) -> Self {
                // SAFETY: the values came from a level's token.
                Self(unsafe { $blend(b.0, self.0, mask.0) })
            }
            #[inline(always)]
            fn reduce_min(self) -> f32 {
                // SAFETY: the value came from a level's token.
                unsafe { $reduce_min(self.0) }
            }
            #[inline(always)]
            fn reduce_max(self) -> f32 {
                // SAFETY: the value came from a level's token.
                unsafe { $reduce_max(self.0) }
            }
        }

        impl Mask for $mask {
            const LANES: u32 = $lanes;

            operations! { $mask $mask_operations {} }

            #[inline(always)]
            fn bits(self) -> u32 {
                // SAFETY: the value came from a level's token.
                unsafe { $movemask(self.0) as u32 }
            }
        }
    };
}
pub(super) use floats;

floats! {
    F4(__m128), M4(__m128), 4,
    _mm_storeu_ps, _mm_set1_ps, _mm_blendv_ps, _mm_and_ps, _mm_xor_ps, _mm_andnot_ps,
    { add = _mm_add_ps; sub = _mm_sub_ps; mul = _mm_mul_ps; div = _mm_div_ps; min = _mm_min_ps; max = _mm_max_ps; }
    {
        le = _mm_cmp_ps::<_CMP_LE_OQ>; lt = _mm_cmp_ps::<_CMP_LT_OQ>;
        eq = _mm_cmp_ps::<_CMP_EQ_OQ>; ne = _mm_cmp_ps::<_CMP_NEQ_OQ>;
    }
    { and = _mm_and_ps; or = _mm_or_ps; }
    _mm_movemask_ps _mm_fmadd_ps _mm_fmsub_ps lowest4 highest4
}

floats! {
    F8(__m256), M8(__m256), 8,
    _mm256_storeu_ps, _mm256_set1_ps, _mm256_blendv_ps, _mm256_and_ps, _mm256_xor_ps, _mm256_andnot_ps,
    {
        add = _mm256_add_ps; sub = _mm256_sub_ps; mul = _mm256_mul_ps; div = _mm256_div_ps;
        min = _mm256_min_ps; max = _mm256_max_ps;
    }
    {
        le = _mm256_cmp_ps::<_CMP_LE_OQ>; lt = _mm256_cmp_ps::<_CMP_LT_OQ>;
        eq = _mm256_cmp_ps::<_CMP_EQ_OQ>; ne = _mm256_cmp_ps::<_CMP_NEQ_OQ>;
    }
    { and = _mm256_and_ps; or = _mm256_or_ps; }
    _mm256_movemask_ps _mm256_fmadd_ps _mm256_fmsub_ps lowest8 highest8
}

/// Declares a horizontal minimum or maximum.
macro_rules! reductions {
    ($four:ident, $eight:ident, $op:ident) => {
        #[inline(always)]
        unsafe fn $four(a: __m128) -> f32 {
            // SAFETY: the caller has the vector from a level's token.
            unsafe {
                let a = $op(a, _mm_movehl_ps(a, a));
                _mm_cvtss_f32($op(a, _mm_shuffle_ps::<0b01>(a, a)))
            }
        }

        #[inline(always)]
        unsafe fn $eight(a: __m256) -> f32 {
            // SAFETY: the caller has the vector from a level's token.
            unsafe { $four($op(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a))) }
        }
    };
}

reductions!(lowest4, lowest8, _mm_min_ps);
reductions!(highest4, highest8, _mm_max_ps);

/// Returns the permutation that moves the lanes of `set` to the end.
///
/// # Safety
/// The processor has AVX2.
#[inline(always)]
unsafe fn together(set: Eight) -> __m256i {
    // SAFETY: by this function's own contract; the table has an entry for every set of eight lanes.
    unsafe {
        let lanes = COMPACT_LANES.get_unchecked(set.bits() as usize);
        _mm256_cvtepu8_epi32(_mm_loadl_epi64(ptr::from_ref(lanes).cast()))
    }
}

/// Hides a vector's origin from the compiler. Otherwise it would broadcast each element by a load
/// of its own, and the processor loads half as many vectors in a cycle as it shuffles.
#[inline]
#[target_feature(enable = "avx")]
fn opaque(mut v: __m256) -> __m256 {
    // SAFETY: the assembly contains no instruction.
    unsafe { asm!("/* {0} */", inout(ymm_reg) v, options(pure, nomem, nostack, preserves_flags)) };
    v
}

/// The order of the children, in the lowest three bits of each lane.
#[derive(Clone, Copy)]
pub struct Order(__m256i);

impl<const SIXTEEN: bool> EightLanes for Avx<SIXTEEN> {
    type F4 = F4;
    type F8 = F8;
    type Order = Order;

    #[inline(always)]
    fn splat4(self, x: f32) -> F4 {
        // SAFETY: the token proves that the processor has AVX2.
        F4(unsafe { _mm_set1_ps(x) })
    }
    #[inline(always)]
    fn splat8(self, x: f32) -> F8 {
        // SAFETY: the token proves that the processor has AVX2.
        F8(unsafe { _mm256_set1_ps(x) })
    }
    #[inline(always)]
    fn four8(self, x: &[f32; 4]) -> [F8; 4] {
        // SAFETY: the token proves that the processor has AVX2; the array is as long as half a
        // vector.
        self.quads(F8(unsafe { opaque(_mm256_broadcast_ps(&_mm_loadu_ps(x.as_ptr()))) }))
    }
    #[inline(always)]
    fn load4(self, x: &[f32; 4]) -> F4 {
        // SAFETY: the token proves that the processor has AVX2; the array is as long as the vector.
        F4(unsafe { _mm_loadu_ps(x.as_ptr()) })
    }
    #[inline(always)]
    fn load8(self, x: &[f32; 8]) -> F8 {
        // SAFETY: the token proves that the processor has AVX2; the array is as long as the vector.
        F8(unsafe { _mm256_loadu_ps(x.as_ptr()) })
    }
    #[inline(always)]
    fn transpose(self, rows: [F8; 8]) -> [F8; 8] {
        let [a, b, c, d, e, f, g, h] = rows;
        // Within each half of the rows: pairs, then fours, then eights.
        // SAFETY: the token proves that the processor has AVX2.
        unsafe {
            let (ab, ab_high) = (_mm256_unpacklo_ps(a.0, b.0), _mm256_unpackhi_ps(a.0, b.0));
            let (cd, cd_high) = (_mm256_unpacklo_ps(c.0, d.0), _mm256_unpackhi_ps(c.0, d.0));
            let (ef, ef_high) = (_mm256_unpacklo_ps(e.0, f.0), _mm256_unpackhi_ps(e.0, f.0));
            let (gh, gh_high) = (_mm256_unpacklo_ps(g.0, h.0), _mm256_unpackhi_ps(g.0, h.0));
            let first0 = _mm256_shuffle_ps::<0x44>(ab, cd);
            let first1 = _mm256_shuffle_ps::<0xee>(ab, cd);
            let first2 = _mm256_shuffle_ps::<0x44>(ab_high, cd_high);
            let first3 = _mm256_shuffle_ps::<0xee>(ab_high, cd_high);
            let second0 = _mm256_shuffle_ps::<0x44>(ef, gh);
            let second1 = _mm256_shuffle_ps::<0xee>(ef, gh);
            let second2 = _mm256_shuffle_ps::<0x44>(ef_high, gh_high);
            let second3 = _mm256_shuffle_ps::<0xee>(ef_high, gh_high);
            [
                F8(_mm256_permute2f128_ps::<0x20>(first0, second0)),
                F8(_mm256_permute2f128_ps::<0x20>(first1, second1)),
                F8(_mm256_permute2f128_ps::<0x20>(first2, second2)),
                F8(_mm256_permute2f128_ps::<0x20>(first3, second3)),
                F8(_mm256_permute2f128_ps::<0x31>(first0, second0)),
                F8(_mm256_permute2f128_ps::<0x31>(first1, second1)),
                F8(_mm256_permute2f128_ps::<0x31>(first2, second2)),
                F8(_mm256_permute2f128_ps::<0x31>(first3, second3)),
            ]
        }
    }
    #[inline(always)]
    fn rotate4(self, v: F4, last: usize) -> F4 {
        static TURNS: [[i32; 4]; 4] = [[0, 1, 2, 3], [1, 2, 0, 3], [2, 0, 1, 3], [0, 1, 2, 3]];
        let lanes = TURNS[last & 3].as_ptr().cast();
        // SAFETY: the token proves that the processor has AVX2; the lanes are as many as the
        // vector's.
        F4(unsafe { _mm_permutevar_ps(v.0, _mm_loadu_si128(lanes)) })
    }
    #[inline(always)]
    fn join4(self, first: F4, second: F4) -> F8 {
        // SAFETY: the token proves that the processor has AVX2.
        F8(unsafe { _mm256_set_m128(second.0, first.0) })
    }
    #[inline(always)]
    fn quads(self, v: F8) -> [F8; 4] {
        // SAFETY: the token proves that the processor has AVX2.
        unsafe {
            [
                F8(_mm256_permute_ps::<0x00>(v.0)),
                F8(_mm256_permute_ps::<0x55>(v.0)),
                F8(_mm256_permute_ps::<0xaa>(v.0)),
                F8(_mm256_permute_ps::<0xff>(v.0)),
            ]
        }
    }
    #[inline(always)]
    fn order(self, order: &[u32; 8], shift: &[u32; 4]) -> Order {
        // SAFETY: the token proves that the processor has AVX2; the arrays are as long as the
        // vectors.
        Order(unsafe {
            let order = _mm256_loadu_si256(order.as_ptr().cast());
            _mm256_srl_epi32(order, _mm_loadu_si128(shift.as_ptr().cast()))
        })
    }

    #[inline(always)]
    fn met_in(self, order: Order, enter: F8, leave: F8) -> Eight {
        // SAFETY: the token proves that the processor has AVX2; the mask has eight lanes.
        unsafe {
            let met = _mm256_permutevar8x32_ps(enter.le(leave).0, order.0);
            Eight::new(_mm256_movemask_ps(met) as u32)
        }
    }

    #[inline(always)]
    fn push(self, met: Eight, order: Order, enter: F8, child: &[u32; 8], to: Top) -> u32 {
        // SAFETY: the token proves that the processor has AVX2; all arrays are as long as a vector.
        unsafe {
            let from = _mm256_permutevar8x32_epi32(order.0, together(met));
            let child = _mm256_loadu_si256(child.as_ptr().cast());
            let child = _mm256_permutevar8x32_epi32(child, from);
            _mm256_storeu_ps(to.enter.as_mut_ptr(), _mm256_permutevar8x32_ps(enter.0, from));
            _mm256_storeu_si256(to.child.as_mut_ptr().cast(), child);
        }
        met.bits().count_ones()
    }

    #[inline(always)]
    fn push_any(self, lanes: Eight, child: &[u32; 8], to: &mut [u32; 8]) -> u32 {
        // SAFETY: the token proves that the processor has AVX2; both arrays are as long as a
        // vector.
        unsafe {
            let child = _mm256_loadu_si256(child.as_ptr().cast());
            let child = _mm256_permutevar8x32_epi32(child, together(lanes));
            _mm256_storeu_si256(to.as_mut_ptr().cast(), child);
        }
        lanes.bits().count_ones()
    }

    #[inline(always)]
    fn flags8(self, words: &[u32; 8]) -> [u64; 2] {
        // SAFETY: the token proves that the processor has AVX2; the array is as long as the vector.
        unsafe {
            let words = _mm256_loadu_si256(words.as_ptr().cast());
            let first = _mm256_castsi256_ps(_mm256_slli_epi32::<31>(words));
            let second = _mm256_castsi256_ps(_mm256_slli_epi32::<30>(words));
            [_mm256_movemask_ps(first) as u64, _mm256_movemask_ps(second) as u64]
        }
    }
}

impl SimdLevel for Avx2 {
    type F16 = Pair<F8>;

    #[inline(always)]
    fn join(self, first: F8, second: F8) -> Pair<F8> {
        Pair(first, second)
    }
    #[inline(always)]
    fn mask16(self, bits: u32) -> Pair<M8> {
        let half = |bits: u32| {
            // SAFETY: the token proves that the processor has AVX2.
            unsafe {
                let lanes = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
                let set = _mm256_and_si256(_mm256_set1_epi32(bits as i32), lanes);
                M8(_mm256_castsi256_ps(_mm256_cmpeq_epi32(set, lanes)))
            }
        };
        Pair(half(bits & 0xff), half(bits >> 8))
    }
}
