//! Thin-film interference: the colours of soap bubbles and of oil on water.
//!
//! Light is reflected at the top and at the bottom of the film and interferes; the series of
//! bounces is cut after the second, and each order is integrated over the sensitivity of the eye,
//! approximated by Gaussians, to the working space.
//!
//! Source: Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of
//! Varying Iridescence", ACM TOG 36(4), 2017, doi:10.1145/3072959.3073620.

use std::f32::consts::{PI, TAU};

use super::fresnel::{dielectric, schlick_term};
use crate::math::{Rgb, WorkingSpace, exponential, trig};

/// A thin film on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinFilm {
    /// The fraction of the surface that it covers, from 0 to 1.
    pub weight: f32,
    /// Index of refraction.
    pub ior: f32,
    /// In metres.
    pub thickness: f32,
    /// The space of the colours.
    pub space: WorkingSpace,
}

impl ThinFilm {
    /// No film.
    pub const NONE: Self = Self {
        weight: 0.0,
        ior: 1.3,
        thickness: 0.0,
        space: WorkingSpace::Rec709,
    };

    /// The reflectance at normal incidence that makes Schlick's approximation right at the cosine
    /// `cos`, for a surface whose own is `f0`. Blended by the film's weight.
    #[inline]
    pub fn f0(&self, f0: Rgb, cos: f32) -> Rgb {
        if self.weight == 0.0 {
            return f0;
        }
        let grazing = schlick_term(cos).min(0.9999);
        let flat = self
            .reflectance(f0, cos)
            .map(|r| ((r - grazing) / (1.0 - grazing)).clamp(0.0, 1.0));
        f0 * (1.0 - self.weight) + flat * self.weight
    }

    /// The part of the light that a covered surface of reflectance `f0` reflects at the cosine
    /// `cos`.
    pub fn reflectance(&self, f0: Rgb, cos: f32) -> Rgb {
        // A film thinner than 30 nm fades away: without a thickness it has no index either.
        let presence = (self.thickness / 30e-9).clamp(0.0, 1.0);
        let presence = presence * presence * (3.0 - 2.0 * presence);
        let schlick = |f0: f32, cos: f32| f0 + (1.0 - f0) * schlick_term(cos);
        let bare = f0.map(|f0| schlick(f0, cos));
        if presence == 0.0 {
            return bare;
        }
        let ior = 1.0 + (self.ior - 1.0) * presence;
        let sin2 = (1.0 - cos * cos) / (ior * ior);
        if sin2 >= 1.0 {
            return Rgb::WHITE;
        }
        let cos_inside = (1.0 - sin2).sqrt();
        let squared = |x: f32| x * x;
        let top = dielectric(cos, ior);
        let passed = squared(1.0 - top);
        // A wave is turned over where it meets the denser side.
        let turn_inside_top = if ior < 1.0 { 0.0 } else { PI };
        let path = 2.0 * ior * self.thickness * cos_inside;
        let channel = |f0: f32| {
            let root = f0.clamp(0.0, 0.9999).sqrt();
            let below = (1.0 + root) / (1.0 - root);
            let bottom = schlick(squared((below - ior) / (below + ior)), cos_inside);
            let turn = turn_inside_top + if below < ior { PI } else { 0.0 };
            let round = (top * bottom).clamp(1e-5, 0.9999);
            (round, passed * bottom / (1.0 - round), turn)
        };
        let channels = f0.to_array().map(channel);
        let mut sum = channels.map(|(_, bounced, _)| top + bounced);
        let mut order = channels.map(|(_, bounced, _)| bounced - (1.0 - top));
        for m in [1.0, 2.0] {
            for (i, (round, _, turn)) in channels.iter().enumerate() {
                order[i] *= round.sqrt();
                sum[i] += order[i] * 2.0 * self.space.from_rec709(sensitivity(m * path, m * turn)).to_array()[i];
            }
        }
        // The bounds of the series leave a rest of a film that is no more.
        bare * (1.0 - presence) + Rgb::from_array(sum).map(|r| r.clamp(0.0, 1.0)) * presence
    }
}

/// The linear sRGB response of the eye to a wave whose paths differ by `path` (m) and `shift`
/// (radians).
fn sensitivity(path: f32, shift: f32) -> Rgb {
    // Of each Gaussian: height, position and variance in reciprocal metres; the last adds to X.
    const CURVES: [[f32; 3]; 4] = [
        [5.4856e-13, 1.6810e6, 4.3278e9],
        [4.4201e-13, 1.7953e6, 9.3046e9],
        [5.2481e-13, 2.2084e6, 6.6121e9],
        [9.7470e-14, 2.2399e6, 4.5282e9],
    ];
    let phase = TAU * path;
    let [x, y, z, x2] = CURVES.map(|[height, position, variance]| {
        let value = height * (TAU * variance).sqrt() * trig::cos(position * phase + shift);
        value * exponential::exp(-variance * phase * phase) / 1.0685e-7
    });
    let x = x + x2;
    Rgb::new(
        3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
        -0.969266 * x + 1.8760108 * y + 0.041556 * z,
        0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_without_thickness_changes_nothing_and_one_that_fades_has_no_step() {
        let film = |thickness| ThinFilm {
            weight: 1.0,
            ior: 1.4,
            thickness,
            ..ThinFilm::NONE
        };
        for f0 in [0.0, 0.04, 0.9] {
            for cos in [0.05, 0.5, 1.0] {
                let bare = f0 + (1.0 - f0) * schlick_term(cos);
                let at = |thickness: f32| film(thickness).reflectance(Rgb::gray(f0), cos).g;
                assert_eq!(at(0.0), bare, "{f0} {cos}");
                assert!((film(0.0).f0(Rgb::gray(f0), cos).g - f0).abs() < 1e-4, "{f0} {cos}");
                let mut last = bare;
                for nm in 1..60 {
                    let next = at(nm as f32 * 1e-9);
                    assert!((next - last).abs() < 0.04, "{f0} {cos} {nm}: {last} {next}");
                    last = next;
                }
            }
        }
    }
}
