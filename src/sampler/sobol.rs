//! Owen-scrambled Sobol points whose errors cancel between neighbouring pixels (the default).
//!
//! No keys.
//!
//! ```toml
//! [render]
//! sampler = "sobol"
//! ```
//!
//! Noise is lower than with independent samples, and fine-grained (blue). Any number of samples works; powers of two are
//! best. Pictures with different numbers of samples do not share their samples, unless they are rendered with
//! `--keep-sums`: then their sequence is one of 65,536 samples of each pixel.
//!
//! # Implementation
//!
//! Each three dimensions are the three-dimensional Sobol sequence, a (1,3)-sequence in base 2, under an Owen scramble of their own.
//! The first two of them are a (0,2)-sequence. The third one selects the light on which these choose a point, or the lobe of the
//! direction that they choose, so that the points of each light are well distributed too.
//!
//! All pixels share that sequence: a pixel has a run of 2^k of its points, `k` the logarithm of the samples of a pixel,
//! rounded up, and runs follow each other in Morton order of the pixels, the four quarters of each square of the
//! hierarchy in a random order. The samples of a run are shuffled within it in the same nested way.
//!
//! The first two dimensions of three have these properties:
//! * Any `2^j` samples of a pixel from a multiple of `2^j` on (`j <= k`), so the first `2^j` too, are one in each elementary
//!   interval: each of the boxes of `2^-i` by `2^-(j-i)` has one. Other numbers of samples are made of such runs.
//! * So are all samples of each square of `2^m` by `2^m` pixels in the hierarchy: where the picture is smooth, the errors of
//!   neighbours cancel. This is at its best once all samples are taken, and for powers of two.
//! * They are independent of all others, by their scrambles and shuffles.
//!
//! Up to 65,536 samples of a pixel are one run; more come in independent runs. Pixels further apart than 256 (65,536 samples
//! of each) to 65,536 (one) are independent of each other.
//!
//! Source: Owen, "Randomly Permuted (t,m,s)-Nets and (t,s)-Sequences", 1995,
//! doi:10.1007/978-1-4612-2552-2_19; for the third coordinate Niederreiter, "Low-Discrepancy and Low-Dispersion Sequences", Journal
//! of Number Theory 30(1), 1988, doi:10.1016/0022-314X(88)90025-X; Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4),
//! 2020; Ahmed and Wonka, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via
//! Hierarchical Ordering of Pixels", ACM TOG 39(6), 2020, doi:10.1145/3414685.3417881.

use serde::{Deserialize, Serialize};

use super::{Dimension, Filled, SampleKey, SampleKeys, UnitBits};
use crate::{
    math::{
        Dispatch, Vec2, VectorLoop,
        hash::{mix32, mix64, owen_reversed, unit_f32},
    },
    value::Problem,
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SobolDesc {}

impl SobolDesc {
    /// Compiles the sampler for `samples` samples of each pixel.
    pub fn compile(&self, samples: u32) -> Result<Sobol, Problem> {
        Ok(Sobol::new(samples))
    }
}

/// Points of one sequence over all pixels.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sobol {
    /// Bits of a point's index that count the samples of a pixel.
    sample_bits: u32,
    /// Bits of a column or a row that are in the index: the upper bits of the index count the
    /// pixels of a square of so many levels.
    levels: u32,
}

/// The index has 32 bits, of which at least half are for the pixels.
const MAX_SAMPLE_BITS: u32 = 16;

impl Sobol {
    /// Creates the sampler for `samples` samples of each pixel, at least 1.
    pub fn new(samples: u32) -> Self {
        let run = samples.clamp(1, 1 << MAX_SAMPLE_BITS);
        let sample_bits = run.next_power_of_two().trailing_zeros();
        Self {
            sample_bits,
            levels: (32 - sample_bits) / 2,
        }
    }

    /// Returns two random numbers in `[0, 1)`.
    #[inline]
    pub fn get_2d(self, key: &SampleKey, dimension: Dimension) -> Vec2 {
        let seeds = self.seeds(key, dimension);
        seeds.first_two(self.index(&seeds, key.pixel, key.sample))
    }

    /// Returns the same two numbers and a third one.
    #[inline]
    pub fn get_3d(self, key: &SampleKey, dimension: Dimension) -> (Vec2, UnitBits) {
        let seeds = self.seeds(key, dimension);
        let index = self.index(&seeds, key.pixel, key.sample);
        (seeds.first_two(index), seeds.third(index))
    }

    /// Replaces the contents of `numbers` with those of all `keys`.
    #[inline(never)]
    pub fn fill(self, on: impl Dispatch, keys: &SampleKeys, dimension: Dimension, numbers: Filled<'_>) {
        let Filled { pairs, thirds } = numbers;
        pairs.clear();
        pairs.resize(keys.len(), Vec2::ZERO);
        let thirds = thirds.map_or(&mut [][..], |thirds| {
            thirds.clear();
            thirds.resize(keys.len(), UnitBits::default());
            thirds.as_mut_slice()
        });
        if keys.is_empty() {
            return;
        }
        if self.share_sequence(keys) {
            on.dispatch(Points {
                sobol: self,
                seeds: self.seeds(&keys.get(0), dimension),
                keys,
                pairs,
                thirds,
            });
            return;
        }
        for (i, pair) in pairs.iter_mut().enumerate() {
            let (own, third) = self.get_3d(&keys.get(i), dimension);
            *pair = own;
            if let Some(to) = thirds.get_mut(i) {
                *to = third;
            }
        }
    }

    /// Returns whether the points of all keys have the same seeds.
    fn share_sequence(self, keys: &SampleKeys) -> bool {
        let same = |values: &[u32], bits: u32| {
            let differ = values.iter().fold(0, |all, v| all | (v ^ values[0]));
            differ >> bits == 0
        };
        same(&keys.columns, self.levels) && same(&keys.rows, self.levels) && same(&keys.samples, self.sample_bits)
    }

    /// Returns the index of a sample's point in the sequence with these seeds.
    #[inline(always)]
    fn index(self, seeds: &Seeds, pixel: [u32; 2], sample: u32) -> u32 {
        let sample = sample & ((1 << self.sample_bits) - 1);
        // The lowest bits are the coarsest level, whose digits decide about those above them.
        let pixel = morton_reversed(pixel) >> (32 - 2 * self.levels);
        let pixel = permute_axes(pixel, seeds.axes);
        let run = pixel << (32 - self.sample_bits - 2 * self.levels);
        owen_reversed(run | sample.reverse_bits(), seeds.order).reverse_bits()
    }

    /// Returns the seeds of all points that share a sequence.
    #[inline]
    fn seeds(self, key: &SampleKey, dimension: Dimension) -> Seeds {
        let picture = mix32(key.seed) ^ (key.frame as u32).wrapping_mul(0x9e37_79b9);
        let far = |v: u32| u64::from(v >> self.levels);
        let square = (far(key.pixel[0]) << 32 | far(key.pixel[1])).wrapping_mul(0xd6e8_feb8_6659_fd93);
        let run = u64::from(key.sample >> self.sample_bits).wrapping_mul(0xa076_1d64_78bd_642f);
        let address = (u64::from(picture) << 32 | u64::from(dimension.0)) ^ square ^ run;
        let first = mix64(address);
        let second = (first ^ first >> 29).wrapping_mul(0xe703_7ed1_a0b4_28db);
        Seeds {
            order: first as u32,
            axes: (first >> 32) as u32,
            scrambles: [second as u32, (second >> 32) as u32, mix32((second >> 16) as u32)],
        }
    }
}

/// The seeds of a sequence, each pair of them independent.
#[derive(Clone, Copy, Debug)]
struct Seeds {
    order: u32,
    axes: u32,
    /// Of each coordinate.
    scrambles: [u32; 3],
}

impl Seeds {
    /// Returns the first two coordinates of a point.
    #[inline(always)]
    fn first_two(&self, index: u32) -> Vec2 {
        let [scramble_x, scramble_y, _] = self.scrambles;
        // With its bits reversed, the first coordinate of a Sobol point is its index.
        let x = owen_reversed(index, scramble_x);
        let y = owen_reversed(second_coordinate_reversed(index), scramble_y);
        Vec2::new(unit_f32(x.reverse_bits()), unit_f32(y.reverse_bits()))
    }

    /// Returns the third coordinate of a point.
    #[inline(always)]
    fn third(&self, index: u32) -> UnitBits {
        let z = owen_reversed(third_coordinate_reversed(index), self.scrambles[2]);
        UnitBits(z.reverse_bits())
    }
}

/// The points of samples that share a sequence.
struct Points<'a> {
    sobol: Sobol,
    seeds: Seeds,
    keys: &'a SampleKeys,
    /// As long as `keys`.
    pairs: &'a mut [Vec2],
    /// As long as `keys`, or empty.
    thirds: &'a mut [UnitBits],
}

impl VectorLoop for Points<'_> {
    #[inline(always)]
    fn run(self) {
        let Self {
            sobol,
            seeds,
            keys,
            pairs,
            thirds,
        } = self;
        let pixels = || keys.columns.iter().zip(&keys.rows).zip(&keys.samples);
        if thirds.is_empty() {
            for (pair, ((&column, &row), &sample)) in pairs.iter_mut().zip(pixels()) {
                *pair = seeds.first_two(sobol.index(&seeds, [column, row], sample));
            }
        } else {
            for ((pair, third), ((&column, &row), &sample)) in pairs.iter_mut().zip(thirds).zip(pixels()) {
                let index = sobol.index(&seeds, [column, row], sample);
                (*pair, *third) = (seeds.first_two(index), seeds.third(index));
            }
        }
    }
}

/// The lower 16 bits of column and row, interleaved with the column lower, then all bits in
/// reverse.
#[inline]
fn morton_reversed([x, y]: [u32; 2]) -> u32 {
    let spread = |v: u32| {
        let v = v.reverse_bits() >> 16;
        let v = (v | v << 8) & 0x00ff_00ff;
        let v = (v | v << 4) & 0x0f0f_0f0f;
        let v = (v | v << 2) & 0x3333_3333;
        (v | v << 1) & 0x5555_5555
    };
    spread(y) | spread(x) << 1
}

/// Parts the quarters of each square of a Morton code with reversed bits into pairs at random: side
/// by side, above each other, or crosswise (twice as often). Followed by a binary Owen scramble all
/// orders of the quarters may come.
#[inline]
fn permute_axes(code: u32, seed: u32) -> u32 {
    const ROWS: u32 = 0x5555_5555;
    // Two random bits for each digit, both of which depend on the coarser digits alone: the one is
    // that digit's own, the other belongs to the digit below it.
    let random = owen_reversed(code, seed);
    let cross = random ^ code;
    let swap = (random << 1) & !cross;
    let (row, column) = (code & ROWS, (code >> 1) & ROWS);
    let swapped = (row ^ column) & swap;
    let pair = row ^ (column & cross) ^ swapped;
    let within = column ^ swapped;
    pair | within << 1
}

/// The second coordinate of the Sobol point `index`, its bits reversed, that is its first bit
/// lowest.
///
/// Bit j is the sum over k of `binomial(k, j)` times bit k of the index, modulo 2: Pascal's
/// triangle, which modulo 2 is the same triangle of blocks on every scale (Lucas), so that five
/// steps do for 32 bits.
#[inline]
fn second_coordinate_reversed(index: u32) -> u32 {
    let mut v = index;
    v ^= v >> 16;
    v ^= (v >> 8) & 0x00ff_00ff;
    v ^= (v >> 4) & 0x0f0f_0f0f;
    v ^= (v >> 2) & 0x3333_3333;
    v ^ ((v >> 1) & 0x5555_5555)
}

/// The third coordinate of the Sobol point `index`, its bits reversed, that is its first bit lowest.
///
/// The index is a polynomial over GF(2), and its digits in base `p = x^2 + x + 1`, two bits each, are those of the coordinate. As
/// `p^s = x^2s + x^s + 1` for powers of two, each step divides blocks of 4s bits by `p^s`: of the quarters h, g, b, a of a block,
/// the highest first, the quotient is h, g + h and the remainder b + g, a + g + h.
#[inline]
fn third_coordinate_reversed(index: u32) -> u32 {
    let mut v = index;
    v ^= (v >> 8) & 0x00ff_ff00;
    v ^= (v >> 16) & 0x0000_00ff;
    v ^= (v >> 4) & 0x0ff0_0ff0;
    v ^= (v >> 8) & 0x000f_000f;
    v ^= (v >> 2) & 0x3c3c_3c3c;
    v ^= (v >> 4) & 0x0303_0303;
    v ^= (v >> 1) & 0x6666_6666;
    v ^ ((v >> 2) & 0x1111_1111)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Plain;

    #[test]
    fn the_third_coordinate_has_the_digits_of_its_index_in_base_x2_x_1() {
        // Horner's rule: times p is times 4, plus times 2, plus itself.
        let value = |digits: u32| {
            (0..16).rev().fold(0_u64, |n, i| {
                let n = n << 2 ^ n << 1 ^ n;
                n ^ u64::from(digits >> (2 * i) & 3)
            })
        };
        for index in (0..32).map(|bit| 1 << bit).chain((0..100).map(mix32)) {
            assert_eq!(value(third_coordinate_reversed(index)), u64::from(index));
        }
    }

    #[test]
    fn the_second_coordinate_has_the_direction_numbers_of_sobol() {
        // Of the primitive polynomial x + 1: each is the one before, xor itself shifted by one.
        let mut direction = 0x8000_0000_u32;
        for bit in 0..32 {
            assert_eq!(second_coordinate_reversed(1 << bit).reverse_bits(), direction);
            direction ^= direction >> 1;
        }
        let (a, b) = (0x1234_5678, 0x9abc_def0);
        let both = second_coordinate_reversed(a) ^ second_coordinate_reversed(b);
        assert_eq!(both, second_coordinate_reversed(a ^ b));
    }

    #[test]
    fn turned_axes_permute_the_quarters_of_every_square() {
        for seed in 0..64 {
            let seed = mix32(seed);
            let mut seen = [false; 256];
            for code in 0..256_u32 {
                let turned = permute_axes(code, seed);
                // The same coarser squares go to the same coarser square.
                for digits in [2, 4, 6] {
                    let mask = (1 << digits) - 1;
                    assert_eq!(turned & mask, permute_axes(code & mask, seed) & mask);
                }
                assert!(!std::mem::replace(&mut seen[turned as usize & 255], true));
            }
        }
    }

    #[test]
    fn morton_codes_interleave_columns_and_rows() {
        let morton = |pixel| morton_reversed(pixel).reverse_bits();
        assert_eq!(morton([0b11, 0b00]), 0b0101);
        assert_eq!(morton([0b01, 0b10]), 0b1001);
        assert_eq!(morton([0xffff, 0]), 0x5555_5555);
        assert_eq!(morton([0, 0xffff]), 0xaaaa_aaaa);
    }

    #[test]
    fn many_points_are_those_of_each_alone() {
        for samples in [1, 5, 64, 65_536, 1 << 20] {
            let mut keys = SampleKeys::default();
            keys.start(7, -3);
            for i in 0..1000 {
                // First of a few neighbours, then from all over a large picture.
                let pixel = if i < 500 {
                    [i / 16, 3]
                } else {
                    [mix32(i) >> 12, mix32(i + 1) >> 12]
                };
                let sample = mix32(i + 2) % samples;
                keys.push(pixel, sample..sample + 1);
            }
            for part in [0..500, 0..1000] {
                let mut keys = keys.clone();
                keys.columns.truncate(part.end);
                keys.rows.truncate(part.end);
                keys.samples.truncate(part.end);
                let (sobol, dimension) = (Sobol::new(samples), Dimension(12));
                let (mut pairs, mut same, mut thirds) = (Vec::new(), Vec::new(), Vec::new());
                for (pairs, thirds) in [(&mut pairs, None), (&mut same, Some(&mut thirds))] {
                    sobol.fill(Plain, &keys, dimension, Filled { pairs, thirds });
                }
                let each: Vec<_> = (0..part.end).map(|i| sobol.get_2d(&keys.get(i), dimension)).collect();
                assert!(pairs == each && same == each);
                let each: Vec<_> = (0..part.end).map(|i| sobol.get_3d(&keys.get(i), dimension).1).collect();
                assert_eq!(thirds, each);
            }
        }
    }

    #[test]
    fn a_point_has_an_index_of_thirty_two_bits_at_most() {
        for (samples, bits, levels) in [
            (1, 0, 16),
            (2, 1, 15),
            (5, 3, 14),
            (64, 6, 13),
            (65_536, 16, 8),
            (u32::MAX, 16, 8),
        ] {
            let sobol = Sobol::new(samples);
            assert_eq!((sobol.sample_bits, sobol.levels), (bits, levels));
        }
    }
}
