//! Ray cones: the width of a ray's footprint and its growth with distance.
//!
//! A ray represents a fraction of a pixel. Its cone determines the footprint over which textures
//! are filtered. The cone is isotropic; the surface projects it.
//!
//! Source: Akenine-Moeller, Crassin, Boksansky, Belcour, Panteleev, Wright, "Improved Shader and
//! Texture Level of Detail Using Ray Cones", JCGT 10(1), 2021; the cones themselves are of
//! Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984, doi:10.1145/800031.808589.

use std::f32::consts::PI;

/// The width of a ray's footprint and its growth. Both may be negative: behind a focus the cone is
/// inverted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayCone {
    /// In m, where the ray is now; a diameter, not a radius.
    pub width: f32,
    /// The growth of the width per metre; small angles, in radians.
    pub spread: f32,
}

/// The largest spread: about 53 degrees.
const MAX_SPREAD: f32 = 1.0;

/// The fraction of the solid angle 1/pdf that a sampled direction represents, since there are many
/// paths.
const SOLID_ANGLE_FRACTION: f32 = 1.0 / 64.0;

impl RayCone {
    /// One of `samples` of a pixel: it covers its share of the pixel's area, and never less than a
    /// 64th.
    pub fn shared(self, samples: u32) -> Self {
        let side = (1.0 / (samples.max(1) as f32).sqrt()).max(0.125);
        Self {
            width: self.width * side,
            spread: self.spread * side,
        }
    }

    /// Further along the ray, by `distance` (m).
    #[inline]
    pub fn moved(self, distance: f32) -> Self {
        Self {
            width: self.width + self.spread * distance,
            spread: self.spread,
        }
    }

    /// After a mirror that bends away from the ray by `curvature` (m^-1; negative where it is
    /// hollow, 0 where it is flat, as which it keeps the spread).
    #[inline]
    pub fn mirrored(self, curvature: f32) -> Self {
        Self {
            width: self.width,
            spread: (self.spread + 2.0 * curvature * self.width).clamp(-MAX_SPREAD, MAX_SPREAD),
        }
    }

    /// After a direction that was drawn with density `pdf` (sr^-1): at least as wide as a 64th of
    /// the solid angle 1/`pdf`, a quarter of a radian for chalk.
    #[inline]
    pub fn scattered(self, pdf: f32) -> Self {
        let spread = (4.0 * SOLID_ANGLE_FRACTION / (PI * pdf)).sqrt().min(MAX_SPREAD);
        Self {
            width: self.width.abs(),
            spread: self.spread.abs().max(spread),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_mirror_keeps_the_cone_and_a_hollow_one_brings_it_to_its_focus() {
        let cone = RayCone {
            width: 0.1,
            spread: 0.0,
        };
        assert_eq!(cone.mirrored(0.0), cone);
        // A sphere of radius 2 has its focus at half of that.
        assert!(cone.mirrored(-0.5).moved(1.0).width.abs() < 1e-6);
        assert!(cone.mirrored(0.5).moved(1.0).width > 0.1);
    }

    #[test]
    fn wide_scattering_widens_and_narrow_scattering_does_not_narrow() {
        let cone = RayCone {
            width: 0.0,
            spread: 0.01,
        };
        let chalk = cone.scattered(std::f32::consts::FRAC_1_PI).spread;
        assert!((chalk - 0.25).abs() < 1e-3, "{chalk}");
        assert_eq!(cone.scattered(1e9).spread, 0.01);
        assert_eq!(cone.scattered(1e-9).spread, MAX_SPREAD);
    }

    #[test]
    fn samples_share_a_pixel_by_area() {
        let pixel = RayCone {
            width: 0.0,
            spread: 1.0,
        };
        assert_eq!(pixel.shared(1).spread, 1.0);
        assert_eq!(pixel.shared(16).spread, 0.25);
        assert_eq!(pixel.shared(10_000).spread, 0.125);
    }
}
