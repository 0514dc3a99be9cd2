//! The SIMD level that every processor has: plain arrays, which the compiler may vectorise. It does
//! so for arrays of four and of sixteen, so eight floats are two arrays of four.

use std::cmp::Ordering;

use super::{
    lanes::{Eight, EightLanes, Floats, Mask, SimdLevel, Top},
    pair::Pair,
};

/// A token that requires no instructions.
#[derive(Clone, Copy)]
pub struct Portable;

#[derive(Clone, Copy)]
pub struct Array<const N: usize>([f32; N]);

#[derive(Clone, Copy)]
pub struct Bits<const N: usize>([bool; N]);

impl<const N: usize> Array<N> {
    #[inline(always)]
    fn zip(self, b: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], b.0[i])))
    }

    #[inline(always)]
    fn test(self, b: Self, f: impl Fn(&f32, &f32) -> bool) -> Bits<N> {
        Bits(std::array::from_fn(|i| f(&self.0[i], &b.0[i])))
    }
}

impl<const N: usize> Floats for Array<N> {
    type Mask = Bits<N>;
    type Array = [f32; N];

    #[inline(always)]
    fn to_array(self) -> [f32; N] {
        self.0
    }
    #[inline(always)]
    fn fill(self, x: f32) -> Self {
        Self([x; N])
    }
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        self.zip(b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        self.zip(b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        self.zip(b, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, b: Self) -> Self {
        self.zip(b, |a, b| a / b)
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self.mul(b).add(c)
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        self.mul(b).sub(c)
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        self.zip(b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        self.zip(b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
    #[inline(always)]
    fn with_sign_of(self, b: Self) -> Self {
        self.zip(b, |a, b| f32::from_bits(a.to_bits() ^ (b.to_bits() & 1 << 31)))
    }
    #[inline(always)]
    fn le(self, b: Self) -> Bits<N> {
        self.test(b, f32::le)
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Bits<N> {
        self.test(b, f32::lt)
    }
    #[inline(always)]
    fn eq(self, b: Self) -> Bits<N> {
        self.test(b, f32::eq)
    }
    #[inline(always)]
    fn ne(self, b: Self) -> Bits<N> {
        self.test(b, |a, b| a.partial_cmp(b).is_some_and(Ordering::is_ne))
    }
    #[inline(always)]
    fn select(self, mask: Bits<N>, b: Self) -> Self {
        Self(std::array::from_fn(|i| if mask.0[i] { self.0[i] } else { b.0[i] }))
    }
    #[inline(always)]
    fn reduce_min(self) -> f32 {
        self.0.into_iter().fold(f32::INFINITY, f32::min)
    }
    #[inline(always)]
    fn reduce_max(self) -> f32 {
        self.0.into_iter().fold(f32::NEG_INFINITY, f32::max)
    }
}

impl<const N: usize> Mask for Bits<N> {
    const LANES: u32 = N as u32;

    #[inline(always)]
    fn and(self, b: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] & b.0[i]))
    }
    #[inline(always)]
    fn or(self, b: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] | b.0[i]))
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        (0..N).fold(0, |bits, i| bits | u32::from(self.0[i]) << i)
    }
}

impl EightLanes for Portable {
    type F4 = Array<4>;
    type F8 = Pair<Array<4>>;
    type Order = [u32; 8];

    #[inline(always)]
    fn splat4(self, x: f32) -> Array<4> {
        Array([x; 4])
    }
    #[inline(always)]
    fn load4(self, x: &[f32; 4]) -> Array<4> {
        Array(*x)
    }
    #[inline(always)]
    fn transpose(self, rows: [Pair<Array<4>>; 8]) -> [Pair<Array<4>>; 8] {
        let rows = rows.map(Floats::to_array);
        std::array::from_fn(|i| self.load8(&rows.map(|row| row[i])))
    }
    #[inline(always)]
    fn rotate4(self, v: Array<4>, last: usize) -> Array<4> {
        let [x, y, z, w] = v.0;
        Array(match last {
            1 => [y, z, x, w],
            2 => [z, x, y, w],
            _ => v.0,
        })
    }
    #[inline(always)]
    fn join4(self, first: Array<4>, second: Array<4>) -> Pair<Array<4>> {
        Pair(first, second)
    }
    #[inline(always)]
    fn quads(self, v: Pair<Array<4>>) -> [Pair<Array<4>>; 4] {
        let (a, b) = (v.0.0, v.1.0);
        let quad = |k: usize| Pair(self.splat4(a[k]), self.splat4(b[k]));
        [quad(0), quad(1), quad(2), quad(3)]
    }
    #[inline(always)]
    fn order(self, order: &[u32; 8], shift: &[u32; 4]) -> [u32; 8] {
        order.map(|place| place >> shift[0])
    }

    #[inline(always)]
    fn met_in(self, _order: [u32; 8], enter: Pair<Array<4>>, leave: Pair<Array<4>>) -> Eight {
        self.met(enter, leave)
    }

    #[inline(always)]
    fn push(self, met: Eight, order: [u32; 8], enter: Pair<Array<4>>, child: &[u32; 8], to: Top) -> u32 {
        let (mut n, enter) = (0, enter.to_array());
        for lane in order.into_iter().rev() {
            let lane = lane as usize & 7;
            to.enter[(7 - n) & 7] = enter[lane];
            to.child[(7 - n) & 7] = child[lane];
            n += (met.bits() >> lane & 1) as usize;
        }
        n as u32
    }

    #[inline(always)]
    fn push_any(self, lanes: Eight, child: &[u32; 8], to: &mut [u32; 8]) -> u32 {
        let mut n = 0;
        for (lane, child) in child.iter().enumerate().rev() {
            to[(7 - n) & 7] = *child;
            n += (lanes.bits() >> lane & 1) as usize;
        }
        n as u32
    }

    #[inline(always)]
    fn flags8(self, words: &[u32; 8]) -> [u64; 2] {
        let mut bits = [0; 2];
        for (i, word) in words.iter().enumerate() {
            bits[0] |= u64::from(word & 1) << i;
            bits[1] |= u64::from(word >> 1 & 1) << i;
        }
        bits
    }
}

impl SimdLevel for Portable {
    type F16 = Array<16>;

    #[inline(always)]
    fn splat16(self, x: f32) -> Array<16> {
        Array([x; 16])
    }
    #[inline(always)]
    fn load16(self, x: &[f32; 16]) -> Array<16> {
        Array(*x)
    }
    #[inline(always)]
    fn join(self, first: Pair<Array<4>>, second: Pair<Array<4>>) -> Array<16> {
        Array(Pair(first, second).to_array())
    }
    #[inline(always)]
    fn mask16(self, bits: u32) -> Bits<16> {
        Bits(std::array::from_fn(|i| bits >> i & 1 == 1))
    }
}
