//! The sampling probabilities of the lobes of layers.

/// The sampling probabilities of the lobes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LobeProbabilities {
    pub sheen: f32,
    pub coat: f32,
    pub diffuse: f32,
    /// The facets of the base.
    pub base: f32,
    /// The part of `base` that is of facets that let nothing pass.
    pub opaque: f32,
}

/// A lobe that was chosen.
pub(super) enum ChosenLobe {
    Sheen,
    Coat,
    /// With a fresh uniform number.
    Diffuse(f32),
    /// With a fresh uniform number.
    Base(f32),
}

impl LobeProbabilities {
    /// Makes their sum 1; `None` where it is 0.
    pub fn scale(&mut self) -> Option<()> {
        let sum = self.sheen + self.coat + self.diffuse + self.base;
        if sum <= 0.0 {
            return None;
        }
        let scale = 1.0 / sum;
        for probability in [&mut self.sheen, &mut self.coat, &mut self.diffuse, &mut self.base] {
            *probability *= scale;
        }
        Some(())
    }

    /// The lobe of the uniform number `uc`.
    pub fn choose(&self, uc: f32) -> ChosenLobe {
        let mut rest = uc;
        for (probability, choice) in [(self.sheen, ChosenLobe::Sheen), (self.coat, ChosenLobe::Coat)] {
            if rest < probability {
                return choice;
            }
            rest -= probability;
        }
        if rest < self.diffuse {
            return ChosenLobe::Diffuse(rest / self.diffuse);
        }
        rest -= self.diffuse;
        if self.base > 0.0 {
            ChosenLobe::Base((rest / self.base).min(1.0 - f32::EPSILON))
        } else {
            // Rounding went past the last of them.
            ChosenLobe::Diffuse(0.0)
        }
    }
}
