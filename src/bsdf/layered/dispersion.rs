//! Dispersion: clear bodies whose index of refraction is another one for red, green and blue.
//!
//! A dispersive body refracts each channel in another direction. A path with several channels follows one of them, selected with
//! equal probabilities: refracted light is scaled by the number of channels in that channel and 0 in the others, so that
//! the mean is correct. Reflected light keeps its colour, with the reflectance for the selected channel's index, which is
//! right on average over the channels.
//!
//! The indices of the channels are those of Khronos, "KHR_materials_dispersion": green has the index of the body, and red
//! and blue are as far apart as the Abbe number's lines F and C, (n - 1) / V.

use super::{Boundary, Layers, hero_channel::HeroChannel};

/// The difference of the index of refraction of green to those of blue and red, for an index of 2 and a dispersion of 1, which is
/// an Abbe number of 20.
const HALF_SPREAD: f32 = 0.025;

impl Layers {
    /// Whether its channels are refracted in different directions, and none is chosen.
    #[inline]
    pub fn disperses(&self) -> bool {
        self.dispersion > 0.0 && self.hero.is_none() && self.refraction() == Boundary::Solid && self.transmission > 0.0
    }

    /// The same for a path that follows one channel.
    pub fn for_channel(self, hero: HeroChannel) -> Self {
        let spread = (self.ior - 1.0).max(0.0) * HALF_SPREAD * self.dispersion;
        let ior = self.ior + spread * (f32::from(hero.index()) - 1.0);
        Self {
            ior: ior.max(self.ior.min(1.0)),
            hero: Some(hero),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        bsdf::{BsdfKind, Lobe, layered::Layered},
        math::{Rgb, Vec2, Vec3, hash},
    };

    fn prism(roughness: f32) -> Layers {
        Layers {
            transmission: 1.0,
            facets: crate::bsdf::microfacet::Ggx::from_roughness(roughness, 0.0),
            ior: 1.5,
            dispersion: 4.0,
            boundary: Boundary::Solid,
            ..Layers::default()
        }
    }

    #[test]
    fn the_indices_of_red_and_blue_differ_by_that_of_the_body_less_one_over_the_abbe_number() {
        let ior = |throughput| {
            let hero = HeroChannel::choose(throughput, 0.3).expect("light");
            prism(0.0).for_channel(hero).ior
        };
        let [red, green, blue] = [
            Rgb::new(0.2, 0.0, 0.0),
            Rgb::new(0.0, 1.0, 0.0),
            Rgb::new(0.0, 0.0, 3.0),
        ]
        .map(ior);
        assert_eq!(green, 1.5);
        assert!((blue - red - 0.5 / (20.0 / 4.0)).abs() < 1e-6 && (blue + red - 3.0).abs() < 1e-6);
        assert_eq!(HeroChannel::choose(Rgb::BLACK, 0.3), None);
    }

    #[test]
    fn each_channel_is_refracted_by_its_own_index() {
        let wo = Vec3::new(0.6, 0.0, 0.8);
        for (uc, index) in [(0.2, 0), (0.5, 1), (0.9, 2)] {
            let hero = HeroChannel::choose(Rgb::WHITE, uc).expect("light");
            let layers = prism(0.0).for_channel(hero);
            // The rest of the number, 0.6, 0.5 and 0.7, chooses what passes.
            let sample = Layered::new(layers)
                .sample(wo, uc, Vec2::splat(0.5).into())
                .expect("a direction");
            assert_eq!(sample.lobe, Lobe::Transmission);
            assert!((-sample.wi.x * layers.ior - wo.x).abs() < 1e-6, "Snell's law");
            let lit = sample.weight.to_array().map(|w| w > 0.0);
            assert_eq!(lit, [0, 1, 2].map(|k| k == index));
        }
    }

    #[test]
    fn white_light_stays_white_on_average() {
        for (roughness, throughput) in [(0.0, Rgb::WHITE), (0.5, Rgb::WHITE), (0.3, Rgb::new(1.0, 0.0, 1.0))] {
            let (mut sum, count) = ([0.0_f64; 3], 200_000);
            for i in 0..count {
                let [uc, a, b, _] = hash::pcg4d([i, 5, 8, 2]).map(|v| (v >> 8) as f32 / (1 << 24) as f32);
                let hero = HeroChannel::choose(throughput, uc).expect("light");
                let layered = Layered::new(prism(roughness).for_channel(hero));
                let sample = layered.sample(Vec3::new(0.6, 0.0, 0.8), uc, Vec2::new(a, b).into());
                let weight = sample.map_or(Rgb::BLACK, |s| s.weight * throughput);
                for (sum, w) in sum.iter_mut().zip(weight.to_array()) {
                    *sum += f64::from(w) / f64::from(count);
                }
            }
            for (mean, of) in sum.into_iter().zip(throughput.to_array()) {
                assert!(
                    (mean - f64::from(of)).abs() < 0.015,
                    "{roughness} {throughput:?}: {sum:?}"
                );
            }
        }
    }
}
