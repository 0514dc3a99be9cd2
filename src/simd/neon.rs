//! The SIMD level of 64-bit ARM processors: vectors of four floats. Eight and sixteen floats are two and four vectors.

use std::arch::aarch64::*;

use super::{
    compact_table::COMPACT_LANES,
    lanes::{Eight, EightLanes, Floats, Mask, SimdLevel, Top, operations},
    pair::Pair,
};

/// A token that requires no proof: every 64-bit ARM processor has NEON.
#[derive(Clone, Copy)]
pub struct Neon;

#[derive(Clone, Copy)]
pub struct F4(float32x4_t);

/// Four lanes, in each of which all bits are equal.
#[derive(Clone, Copy)]
pub struct M4(uint32x4_t);

/// The order of the children, a byte for each place.
#[derive(Clone, Copy)]
pub struct Order(uint8x8_t);

type F8 = Pair<F4>;
type F16 = Pair<F8>;

impl Floats for F4 {
    type Mask = M4;
    type Array = [f32; 4];

    operations! {
        M4
        { add = vaddq_f32; sub = vsubq_f32; mul = vmulq_f32; div = vdivq_f32; }
        { le = vcleq_f32; lt = vcltq_f32; eq = vceqq_f32; }
    }

    #[inline(always)]
    fn to_array(self) -> [f32; 4] {
        let mut a = [0.0; 4];
        // SAFETY: every processor of this architecture has NEON; the array is as long as the vector.
        unsafe { vst1q_f32(a.as_mut_ptr(), self.0) };
        a
    }
    #[inline(always)]
    fn fill(self, x: f32) -> Self {
        Neon.splat4(x)
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        // SAFETY: every processor of this architecture has NEON.
        Self(unsafe { vfmaq_f32(c.0, self.0, b.0) })
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        // SAFETY: every processor of this architecture has NEON.
        Self(unsafe { vnegq_f32(vfmsq_f32(c.0, self.0, b.0)) })
    }
    /// The minimum. NEON's own one is NaN where either is.
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        self.select(self.lt(b), b)
    }
    /// The maximum. NEON's own one is NaN where either is.
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        self.select(b.lt(self), b)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: every processor of this architecture has NEON.
        Self(unsafe { vabsq_f32(self.0) })
    }
    #[inline(always)]
    fn with_sign_of(self, b: Self) -> Self {
        // SAFETY: every processor of this architecture has NEON.
        Self(unsafe {
            let sign = vandq_u32(vreinterpretq_u32_f32(b.0), vdupq_n_u32(1 << 31));
            vreinterpretq_f32_u32(veorq_u32(vreinterpretq_u32_f32(self.0), sign))
        })
    }
    #[inline(always)]
    fn ne(self, b: Self) -> M4 {
        self.lt(b).or(b.lt(self))
    }
    #[inline(always)]
    fn select(self, mask: M4, b: Self) -> Self {
        // SAFETY: every processor of this architecture has NEON.
        Self(unsafe { vbslq_f32(mask.0, self.0, b.0) })
    }
    #[inline(always)]
    fn reduce_min(self) -> f32 {
        // SAFETY: every processor of this architecture has NEON.
        unsafe { vminnmvq_f32(self.0) }
    }
    #[inline(always)]
    fn reduce_max(self) -> f32 {
        // SAFETY: every processor of this architecture has NEON.
        unsafe { vmaxnmvq_f32(self.0) }
    }
}

impl Mask for M4 {
    const LANES: u32 = 4;

    operations! { M4 { and = vandq_u32; or = vorrq_u32; } {} }

    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: every processor of this architecture has NEON.
        unsafe { vaddvq_u32(vandq_u32(self.0, vld1q_u32([1, 2, 4, 8].as_ptr()))) }
    }
    #[inline(always)]
    fn bits_of_two(self, next: Self) -> u32 {
        // SAFETY: every processor of this architecture has NEON.
        unsafe { bits_of_bytes(narrow(self.0, next.0)) }
    }
}

/// Returns the lowest byte of each lane.
///
/// # Safety
/// The processor has NEON.
#[inline(always)]
unsafe fn narrow(a: uint32x4_t, b: uint32x4_t) -> uint8x8_t {
    // SAFETY: by this function's own contract.
    unsafe { vmovn_u16(vuzp1q_u16(vreinterpretq_u16_u32(a), vreinterpretq_u16_u32(b))) }
}

/// Returns one bit for each byte, all bits of which are equal.
///
/// # Safety
/// The processor has NEON.
#[inline(always)]
unsafe fn bits_of_bytes(mask: uint8x8_t) -> u32 {
    // SAFETY: by this function's own contract.
    unsafe { u32::from(vaddv_u8(vand_u8(mask, vcreate_u8(0x8040_2010_0804_0201)))) }
}

/// Returns the permutation that moves the lanes of `set` to the end.
///
/// # Safety
/// The processor has NEON.
#[inline(always)]
unsafe fn together(set: Eight) -> uint8x8_t {
    // SAFETY: by this function's own contract; the table has an entry for every set of eight lanes.
    unsafe { vcreate_u8(*COMPACT_LANES.get_unchecked(set.bits() as usize)) }
}

/// The places of the bytes of eight lanes of 32 bits, for a table lookup.
#[derive(Clone, Copy)]
struct Places(uint8x16_t, uint8x16_t);

impl Places {
    /// # Safety
    /// The processor has NEON, and each byte of `lanes` is below eight.
    #[inline(always)]
    unsafe fn new(lanes: uint8x8_t) -> Self {
        // SAFETY: by this function's own contract.
        unsafe {
            let twice = vreinterpretq_u16_u8(vcombine_u8(vzip1_u8(lanes, lanes), vzip2_u8(lanes, lanes)));
            let byte = vreinterpretq_u8_u32(vdupq_n_u32(0x0302_0100));
            let of = |lane| vsliq_n_u8::<2>(byte, vreinterpretq_u8_u16(lane));
            Self(of(vzip1q_u16(twice, twice)), of(vzip2q_u16(twice, twice)))
        }
    }

    /// Writes the lanes of `table` at these places.
    ///
    /// # Safety
    /// The processor has NEON.
    #[inline(always)]
    unsafe fn gather(self, table: [uint8x16_t; 2], to: &mut [u32; 8]) {
        // SAFETY: by this function's own contract; the array is as long as two vectors.
        unsafe {
            let table = uint8x16x2_t(table[0], table[1]);
            vst1q_u8(to.as_mut_ptr().cast(), vqtbl2q_u8(table, self.0));
            vst1q_u8(to[4..].as_mut_ptr().cast(), vqtbl2q_u8(table, self.1));
        }
    }
}

/// Loads eight words as bytes.
///
/// # Safety
/// The processor has NEON.
#[inline(always)]
unsafe fn bytes_of(words: &[u32; 8]) -> [uint8x16_t; 2] {
    // SAFETY: by this function's own contract; the array is as long as two vectors.
    unsafe { [vld1q_u8(words.as_ptr().cast()), vld1q_u8(words[4..].as_ptr().cast())] }
}

/// Transposes a 4 x 4 matrix.
#[inline(always)]
fn transpose4([a, b, c, d]: [F4; 4]) -> [F4; 4] {
    // SAFETY: every processor of this architecture has NEON.
    unsafe {
        let as_pairs = |v: float32x4_t| vreinterpretq_f64_f32(v);
        let (ab, ab_odd) = (as_pairs(vtrn1q_f32(a.0, b.0)), as_pairs(vtrn2q_f32(a.0, b.0)));
        let (cd, cd_odd) = (as_pairs(vtrn1q_f32(c.0, d.0)), as_pairs(vtrn2q_f32(c.0, d.0)));
        [
            F4(vreinterpretq_f32_f64(vzip1q_f64(ab, cd))),
            F4(vreinterpretq_f32_f64(vzip1q_f64(ab_odd, cd_odd))),
            F4(vreinterpretq_f32_f64(vzip2q_f64(ab, cd))),
            F4(vreinterpretq_f32_f64(vzip2q_f64(ab_odd, cd_odd))),
        ]
    }
}

impl EightLanes for Neon {
    type F4 = F4;
    type F8 = F8;
    type Order = Order;

    #[inline(always)]
    fn splat4(self, x: f32) -> F4 {
        // SAFETY: every processor of this architecture has NEON.
        F4(unsafe { vdupq_n_f32(x) })
    }
    #[inline(always)]
    fn load4(self, x: &[f32; 4]) -> F4 {
        // SAFETY: every processor of this architecture has NEON; the array is as long as the vector.
        F4(unsafe { vld1q_f32(x.as_ptr()) })
    }
    #[inline(always)]
    fn transpose(self, rows: [F8; 8]) -> [F8; 8] {
        let [a, b, c, d, e, f, g, h] = rows;
        let [first0, first1] = [[a.0, b.0, c.0, d.0], [e.0, f.0, g.0, h.0]].map(transpose4);
        let [second0, second1] = [[a.1, b.1, c.1, d.1], [e.1, f.1, g.1, h.1]].map(transpose4);
        let pair = |k: usize| match k {
            0..4 => Pair(first0[k], first1[k]),
            _ => Pair(second0[k - 4], second1[k - 4]),
        };
        [pair(0), pair(1), pair(2), pair(3), pair(4), pair(5), pair(6), pair(7)]
    }
    #[inline(always)]
    fn rotate4(self, v: F4, last: usize) -> F4 {
        static TURNS: [[u8; 16]; 4] = {
            let lanes = [[0, 1, 2, 3], [1, 2, 0, 3], [2, 0, 1, 3], [0, 1, 2, 3]];
            let mut turns = [[0; 16]; 4];
            let mut i = 0;
            while i < 64 {
                turns[i / 16][i % 16] = 4 * lanes[i / 16][i % 16 / 4] + (i % 4) as u8;
                i += 1;
            }
            turns
        };
        // SAFETY: every processor of this architecture has NEON; a row is as long as the vector.
        F4(unsafe {
            let turn = vld1q_u8(TURNS[last & 3].as_ptr());
            vreinterpretq_f32_u8(vqtbl1q_u8(vreinterpretq_u8_f32(v.0), turn))
        })
    }
    #[inline(always)]
    fn join4(self, first: F4, second: F4) -> F8 {
        Pair(first, second)
    }
    #[inline(always)]
    fn quads(self, v: F8) -> [F8; 4] {
        // SAFETY: every processor of this architecture has NEON.
        unsafe {
            let (a, b) = (v.0.0, v.1.0);
            [
                Pair(F4(vdupq_laneq_f32::<0>(a)), F4(vdupq_laneq_f32::<0>(b))),
                Pair(F4(vdupq_laneq_f32::<1>(a)), F4(vdupq_laneq_f32::<1>(b))),
                Pair(F4(vdupq_laneq_f32::<2>(a)), F4(vdupq_laneq_f32::<2>(b))),
                Pair(F4(vdupq_laneq_f32::<3>(a)), F4(vdupq_laneq_f32::<3>(b))),
            ]
        }
    }
    #[inline(always)]
    fn order(self, order: &[u32; 8], shift: &[u32; 4]) -> Order {
        // SAFETY: every processor of this architecture has NEON; the array is as long as two vectors.
        Order(unsafe {
            let right = vdupq_n_s32(-(shift[0] as i32));
            let [a, b] = bytes_of(order).map(|four| vshlq_u32(vreinterpretq_u32_u8(four), right));
            vand_u8(narrow(a, b), vdup_n_u8(7))
        })
    }

    #[inline(always)]
    fn met_in(self, order: Order, enter: F8, leave: F8) -> Eight {
        let Pair(first, second) = enter.le(leave);
        // SAFETY: every processor of this architecture has NEON; the mask has eight lanes.
        unsafe { Eight::new(bits_of_bytes(vtbl1_u8(narrow(first.0, second.0), order.0))) }
    }

    #[inline(always)]
    fn push(self, met: Eight, order: Order, enter: F8, child: &[u32; 8], to: Top) -> u32 {
        // SAFETY: every processor of this architecture has NEON; all lanes of an order are below eight.
        unsafe {
            let from = Places::new(vtbl1_u8(order.0, together(met)));
            let enter = [enter.0, enter.1].map(|four| vreinterpretq_u8_f32(four.0));
            from.gather(enter, bytemuck::cast_mut(to.enter));
            from.gather(bytes_of(child), to.child);
        }
        met.bits().count_ones()
    }

    #[inline(always)]
    fn push_any(self, lanes: Eight, child: &[u32; 8], to: &mut [u32; 8]) -> u32 {
        // SAFETY: every processor of this architecture has NEON; all lanes of the table are below eight.
        unsafe { Places::new(together(lanes)).gather(bytes_of(child), to) };
        lanes.bits().count_ones()
    }

    #[inline(always)]
    fn flags8(self, words: &[u32; 8]) -> [u64; 2] {
        // SAFETY: every processor of this architecture has NEON.
        unsafe {
            let [a, b] = bytes_of(words).map(|four| vreinterpretq_u32_u8(four));
            let low = narrow(a, b);
            [1, 2].map(|flag| u64::from(bits_of_bytes(vtst_u8(low, vdup_n_u8(flag)))))
        }
    }
}

impl SimdLevel for Neon {
    type F16 = F16;

    #[inline(always)]
    fn join(self, first: F8, second: F8) -> F16 {
        Pair(first, second)
    }
    #[inline(always)]
    fn mask16(self, bits: u32) -> <F16 as Floats>::Mask {
        let four = |bits: u32| {
            // SAFETY: every processor of this architecture has NEON.
            M4(unsafe { vtstq_u32(vdupq_n_u32(bits), vld1q_u32([1, 2, 4, 8].as_ptr())) })
        };
        Pair(
            Pair(four(bits), four(bits >> 4)),
            Pair(four(bits >> 8), four(bits >> 12)),
        )
    }
}
