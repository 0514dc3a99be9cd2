//! Mappings from the unit square to other domains, with their densities.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, TAU};

use super::{Dispatch, Vec2, Vec3, VectorLoop, exponential, trig};

/// Two uniform numbers in `[0, 1)`, and the point of the unit disk that they map to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample2D {
    pub square: Vec2,
    /// [`square_to_disk`].
    pub disk: Vec2,
}

impl From<Vec2> for Sample2D {
    fn from(square: Vec2) -> Self {
        Self {
            square,
            disk: square_to_disk(square),
        }
    }
}

impl Sample2D {
    /// A unit direction about +z with a density proportional to its cosine: it lies over the point
    /// of the disk.
    #[inline(always)]
    pub fn cosine_hemisphere(&self) -> Vec3 {
        over_disk(self.disk)
    }
}

/// The unit direction about +z over a point of the unit disk.
#[inline(always)]
pub fn over_disk(d: Vec2) -> Vec3 {
    d.extend((1.0 - d.length_squared()).max(0.0).sqrt())
}

/// [`square_to_disk`] for each of `squares`, in place of what `disks` held.
pub fn squares_to_disk(on: impl Dispatch, squares: &[Vec2], disks: &mut Vec<Vec2>) {
    disks.resize(squares.len(), Vec2::ZERO);
    on.dispatch(Disks { squares, disks });
}

struct Disks<'a> {
    squares: &'a [Vec2],
    disks: &'a mut [Vec2],
}

impl VectorLoop for Disks<'_> {
    #[inline(always)]
    fn run(self) {
        for (square, disk) in self.squares.iter().zip(self.disks) {
            *disk = square_to_disk(*square);
        }
    }
}

/// A point of the unit disk, uniform by area; neighbours stay neighbours.
///
/// Source: Shirley and Chiu, "A low distortion map between disk and square", JGT 2(3), 1997.
#[inline(always)]
pub fn square_to_disk(u: Vec2) -> Vec2 {
    let o = 2.0 * u - Vec2::ONE;
    // The larger one is unpredictable, so there is no branch.
    let wide = o.x.abs() > o.y.abs();
    let (major, minor) = if wide { (o.x, o.y) } else { (o.y, o.x) };
    // In the middle both are 0, and so is the radius.
    let ratio = if major == 0.0 { 0.0 } else { minor / major };
    let (sin, cos) = trig::sin_cos_eighth(FRAC_PI_4 * ratio);
    let (along, across) = (major * cos, major * sin);
    // The compiler would make a branch of it.
    let select = |a: f32, b: f32| {
        let mask = u32::from(wide).wrapping_neg();
        f32::from_bits(a.to_bits() & mask | b.to_bits() & !mask)
    };
    Vec2::new(select(along, across), select(across, along))
}

/// The density of [`Sample2D::cosine_hemisphere`] for a direction whose z is `cos`, in sr^-1.
#[inline(always)]
pub fn cosine_hemisphere_pdf(cos: f32) -> f32 {
    cos.max(0.0) * FRAC_1_PI
}

/// A unit direction of positive z, uniform by solid angle: its density is 1 / (2 pi) sr^-1.
pub fn square_to_hemisphere(u: Vec2) -> Vec3 {
    let (sin_phi, cos_phi) = trig::sin_cos(TAU * u.x);
    // In (0, 1], so that no direction grazes.
    let z = 1.0 - u.y;
    let sin = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(sin * cos_phi, sin * sin_phi, z)
}

/// A unit direction of positive z with a density proportional to z to the power `n`: `(n + 1) / (2
/// pi) z^n` sr^-1.
pub fn square_to_power_cosine(u: Vec2, n: f32) -> Vec3 {
    let (sin_phi, cos_phi) = trig::sin_cos(TAU * u.x);
    let z = exponential::pow(1.0 - u.y, 1.0 / (n + 1.0));
    let sin = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(sin * cos_phi, sin * sin_phi, z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disk_is_filled_evenly_and_the_hemisphere_by_its_cosine() {
        let n = 200;
        let (mut inner, mut cos) = (0, 0.0_f64);
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let d = square_to_disk(u);
            assert!(d.length() <= 1.0);
            inner += i32::from(d.length_squared() < 0.5);
            cos += f64::from(Sample2D::from(u).cosine_hemisphere().z);
        }
        let all = f64::from(n * n);
        assert!((f64::from(inner) / all - 0.5).abs() < 0.005);
        // The mean of the cosine under cos / pi is 2 / 3.
        assert!((cos / all - 2.0 / 3.0).abs() < 0.001);
    }
}
