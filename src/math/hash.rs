//! Integer hashes: the source of every random number, so that a sample's bits depend on its address alone.

/// Mixes 32 bits well. Source: Wellons, "Prospecting for Hash Functions", 2018 (the `lowbias32` family), with the
/// constants found by TheIronBorn.
pub const fn mix32(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x21f0_aaad);
    x ^= x >> 15;
    x = x.wrapping_mul(0xd35a_2d97);
    x ^ (x >> 15)
}

/// Four well-mixed words from four words. Source: Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3),
/// 2020.
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

const fn pcg4d_round([mut x, mut y, mut z, mut w]: [u32; 4]) -> [u32; 4] {
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    [x, y, z, w]
}

/// A number in `[0, 1)` from the upper 24 bits of `x`.
pub const fn unit_f32(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_numbers_stay_below_one() {
        assert_eq!(unit_f32(0), 0.0);
        assert!(unit_f32(u32::MAX) < 1.0);
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
