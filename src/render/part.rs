//! Which samples a wave takes, and where in it each lies.

use std::ops::Range;

use super::Settings;
use crate::{
    film::Window,
    integrator::Path,
    math::Divisor,
    sampler::{SampleKey, SampleKeys},
};

/// The samples of a wave: `together` of each pixel of `tile` from `first` on, a pixel's beside each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    tile: Window,
    first: u32,
    together: Divisor,
    width: Divisor,
}

impl Part {
    pub fn new(tile: Window, samples: &Range<u32>) -> Self {
        Self {
            tile,
            first: samples.start,
            together: Divisor::new(samples.len() as u32),
            width: Divisor::new(tile.x1 - tile.x0),
        }
    }

    /// The address of the sample in `slot`.
    #[inline]
    pub fn key(&self, settings: &Settings, slot: u32) -> SampleKey {
        let (pixel, sample) = self.together.divide(slot);
        let (row, column) = self.width.divide(pixel);
        SampleKey {
            seed: settings.seed,
            frame: settings.frame,
            pixel: [self.tile.x0 + column, self.tile.y0 + row],
            sample: self.first + sample,
        }
    }

    /// The addresses of the samples of the `chosen` paths, in place of what `keys` held.
    #[inline]
    pub fn keys(&self, settings: &Settings, chosen: &[u32], paths: &[Path], keys: &mut SampleKeys) {
        keys.start(settings.seed, settings.frame);
        for &i in chosen {
            let key = self.key(settings, paths[i as usize].slot);
            keys.push(key.pixel, key.sample);
        }
    }
}
