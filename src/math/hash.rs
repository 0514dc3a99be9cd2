//! Integer hashes: the source of every random number, so that a sample's bits depend on its address
//! alone.

/// Mixes 32 bits well. Source: Wellons, "Prospecting for Hash Functions", 2018 (the `lowbias32`
/// family), with the constants found by TheIronBorn.
#[inline]
pub const fn mix32(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x21f0_aaad);
    x ^= x >> 15;
    x = x.wrapping_mul(0xd35a_2d97);
    x ^ (x >> 15)
}

/// Four well-mixed words from four words. Source: Jarzynski and Olano, "Hash Functions for GPU
/// Rendering", JCGT 9(3), 2020.
#[inline]
pub const fn pcg4d(mut v: [u32; 4]) -> [u32; 4] {
    let mut k = 0;
    while k < 4 {
        v[k] = v[k].wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        k += 1;
    }
    v = pcg4d_round(v);
    k = 0;
    while k < 4 {
        v[k] ^= v[k] >> 16;
        k += 1;
    }
    pcg4d_round(v)
}

#[inline]
const fn pcg4d_round([mut x, mut y, mut z, mut w]: [u32; 4]) -> [u32; 4] {
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    [x, y, z, w]
}

/// Mixes 64 bits well. Source: Steele, Lea, Flood, "Fast Splittable Pseudorandom Number
/// Generators", OOPSLA 2014, doi:10.1145/2660193.2660195, with the constants of its SplitMix64.
#[inline]
pub const fn mix64(mut x: u64) -> u64 {
    x ^= x >> 30;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 27;
    x = x.wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Flips each bit of `x` or not, as `seed` and the bits *below* it say: on a number whose bits are
/// reversed, a random order of the halves of the unit interval, of the halves of each half, and so
/// on. `seed` is well mixed.
///
/// Source: Laine and Karras, "Stratified Sampling for Stochastic Transparency", EGSR 2011,
/// doi:10.1111/j.1467-8659.2011.01995.x; the steps and their constants are those of Vegdahl,
/// "Building a Better LK Hash", 2021.
#[inline]
pub const fn owen_reversed(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// MurmurHash3_x86_32 with seed 0. Source: Appleby, "SMHasher", 2011.
pub fn murmur3(bytes: &[u8]) -> u32 {
    const C: [u32; 2] = [0xcc9e_2d51, 0x1b87_3593];
    let scrambled = |k: u32| k.wrapping_mul(C[0]).rotate_left(15).wrapping_mul(C[1]);
    let (blocks, tail) = bytes.as_chunks::<4>();
    let mut h = 0_u32;
    for block in blocks {
        h ^= scrambled(u32::from_le_bytes(*block));
        h = h.rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64);
    }
    if !tail.is_empty() {
        let mut last = [0; 4];
        last[..tail.len()].copy_from_slice(tail);
        h ^= scrambled(u32::from_le_bytes(last));
    }
    h ^= bytes.len() as u32;
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// A name's hash as a float that is neither infinite, NaN nor subnormal. Source: Friedman and
/// Jones, "Cryptomatte Specification", version 1.2.0.
pub fn name_as_float(name: &str) -> f32 {
    let bits = murmur3(name.as_bytes());
    let exponent = bits >> 23 & 0xff;
    f32::from_bits(if matches!(exponent, 0 | 255) {
        bits ^ 1 << 23
    } else {
        bits
    })
}

/// A number in `[0, 1)` from the upper 24 bits of `x`.
#[inline]
pub const fn unit_f32(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A number in `[0, 1)` from all bits of `x`.
#[inline]
pub const fn unit_f64(x: u32) -> f64 {
    x as f64 * (1.0 / 4_294_967_296.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_numbers_stay_below_one() {
        assert_eq!(unit_f32(0), 0.0);
        assert!(unit_f32(u32::MAX) < 1.0 && unit_f64(u32::MAX) < 1.0);
    }

    #[test]
    fn an_owen_scramble_flips_a_bit_by_the_bits_below_it_alone_and_half_of_the_time() {
        for bit in 0..32 {
            let mut flips = 0;
            for i in 0..2000_u32 {
                let (x, seed) = (mix32(i), mix32(i ^ 0xaaaa_0000));
                let there = owen_reversed(x, seed);
                let changed = there ^ owen_reversed(x ^ (1 << bit), seed);
                assert_eq!(changed & ((2 << bit) as u32).wrapping_sub(1), 1 << bit);
                flips += ((there ^ x) >> bit) & 1;
            }
            assert!((850..1150).contains(&flips), "bit {bit}: {flips}");
        }
    }

    #[test]
    fn names_have_the_hashes_of_cryptomattes_specification() {
        for (name, hash, bits) in [
            ("hello", 0x248b_fa47, 0x248b_fa47),
            ("bunny", 0x1385_1a76, 0x1385_1a76),
            (
                "\u{440}\u{430}\u{432}\u{43d}\u{438}\u{43d}\u{430}",
                0x9623_511e,
                0x9623_511e,
            ),
            ("obj45", 0x0073_4d5c, 0x00f3_4d5c),
            ("obj520", 0x7fbb_01ed, 0x7f3b_01ed),
        ] {
            assert_eq!(
                (murmur3(name.as_bytes()), name_as_float(name).to_bits()),
                (hash, bits),
                "{name}"
            );
        }
    }

    #[test]
    fn pcg4d_changes_half_of_the_bits_when_one_flips() {
        let mut flips = 0;
        for i in 0..1000_u32 {
            let a = pcg4d([i, 1, 2, 3]);
            let b = pcg4d([i ^ 1, 1, 2, 3]);
            flips += (a[0] ^ b[0]).count_ones();
        }
        assert!((14_000..18_000).contains(&flips), "{flips}");
    }
}
