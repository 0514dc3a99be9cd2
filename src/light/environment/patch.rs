//! The square between the centres of four texels, where the luminance is bilinear.

use crate::math::Vec2;

/// The luminances at the corners of a patch: left and right, in the upper and the lower row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch(pub [[f32; 2]; 2]);

/// The mean square of what is linear between `a` and `b` times what is linear between `c` and `d`.
fn mean_product([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    (2.0 * (a * c + b * d) + a * d + b * c) / 6.0
}

fn lerp([a, b]: [f32; 2], t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

/// Samples a number in `[0, 1]` by a uniform one, with a density that is linear between `a` and `b`.
fn sample_linear([a, b]: [f32; 2], u: f32) -> f32 {
    let divisor = a + lerp([a * a, b * b], u).sqrt();
    if divisor > 0.0 {
        (u * (a + b) / divisor).min(1.0)
    } else {
        u
    }
}

impl Patch {
    pub fn mean(self) -> f64 {
        let [upper, lower] = self.0.map(|row| f64::from(row[0]) + f64::from(row[1]));
        0.25 * (upper + lower)
    }

    pub fn mean_square(self) -> f64 {
        let [upper, lower] = self.0.map(|row| row.map(f64::from));
        (mean_product(upper, upper) + mean_product(upper, lower) + mean_product(lower, lower)) / 3.0
    }

    /// The patch times a factor such that its mean is 1; a black one is unchanged.
    pub fn normalized(self) -> Self {
        let mean = self.mean();
        let scale = if mean > 0.0 { 1.0 / mean } else { 0.0 };
        Self(self.0.map(|row| row.map(|l| (f64::from(l) * scale) as f32)))
    }

    /// The value at a point of the unit square, to the right and down.
    pub fn at(self, p: Vec2) -> f32 {
        lerp(self.0.map(|row| lerp(row, p.x)), p.y)
    }

    /// Samples a point by two uniform numbers in `[0, 1)`. The density of a normalized patch is [`Patch::at`].
    pub fn sample(self, u: Vec2) -> Vec2 {
        let y = sample_linear(self.0.map(|row| row[0] + row[1]), u.y);
        let [upper, lower] = self.0;
        let across = [0, 1].map(|k| lerp([upper[k], lower[k]], y));
        Vec2::new(sample_linear(across, u.x), y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_patch_are_sampled_in_proportion_to_its_luminance() {
        for corners in [
            [[1.0, 1.0], [1.0, 1.0]],
            [[0.0, 3.0], [1.0, 0.0]],
            [[0.0, 0.0], [0.0, 7.0]],
        ] {
            let patch = Patch(corners).normalized();
            let (side, mut found) = (400, [[0.0_f64; 4]; 4]);
            for k in 0..side * side {
                let u = Vec2::new((k % side) as f32 + 0.5, (k / side) as f32 + 0.5) / side as f32;
                let p = patch.sample(u);
                found[(p.y * 4.0).min(3.0) as usize][(p.x * 4.0).min(3.0) as usize] += 1.0 / f64::from(side * side);
            }
            for (j, row) in found.into_iter().enumerate() {
                for (i, share) in row.into_iter().enumerate() {
                    // The mean of a bilinear function is that of its middle.
                    let middle = Vec2::new(i as f32 + 0.5, j as f32 + 0.5) / 4.0;
                    let expected = f64::from(patch.at(middle)) / 16.0;
                    assert!(
                        (share - expected).abs() < 2e-3,
                        "{corners:?} {i} {j}: {share}, {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_mean_square_is_that_of_the_bilinear_luminance() {
        let patch = Patch([[0.3, 5.0], [2.0, 0.0]]);
        let side = 200;
        let at = |k: i32| Vec2::new((k % side) as f32 + 0.5, (k / side) as f32 + 0.5) / side as f32;
        let squares: f64 = (0..side * side).map(|k| f64::from(patch.at(at(k))).powi(2)).sum();
        let mean = squares / f64::from(side * side);
        assert!((patch.mean_square() / mean - 1.0).abs() < 1e-4, "{mean}");
    }
}
