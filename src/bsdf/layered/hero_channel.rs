//! The channel of colour that a path through dispersive bodies follows.

use crate::math::Rgb;

/// The channel that a path follows through a dispersive body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeroChannel {
    index: u8,
    /// The number of channels that it is one of.
    of: u8,
}

impl HeroChannel {
    /// Chooses one of the channels in which `throughput` is not 0, by the uniform number `uc`; `None` where it is black.
    pub fn choose(throughput: Rgb, uc: f32) -> Option<Self> {
        let throughput = throughput.to_array();
        let mut lit = (0..3u8).filter(|k| throughput[usize::from(*k)] > 0.0);
        let of = lit.clone().count() as u8;
        let index = lit
            .clone()
            .nth((uc * f32::from(of)) as usize)
            .or_else(|| lit.next_back())?;
        Some(Self { index, of })
    }

    /// Its number, from 0 for red.
    pub fn index(self) -> u8 {
        self.index
    }

    /// A fresh uniform number out of the one that chose the channel.
    pub fn fresh(self, uc: f32) -> f32 {
        (uc * f32::from(self.of)).fract()
    }

    /// The weight of refracted light.
    pub fn weight(self) -> Rgb {
        let mut weight = [0.0; 3];
        weight[usize::from(self.index)] = f32::from(self.of);
        Rgb::from_array(weight)
    }
}
