//! The settings of a frame, beside its scene and its camera.

use serde::Serialize;

use super::{SampleBudget, SampleRanges, adaptive};
use crate::{
    film::{AccumulatorLayout, FilmLayout, PassRequest, PassSpec, Window, coverage::DEFAULT_RANKS},
    filter::Filter,
    sampler::Sampler,
    value::UnknownName,
};

/// The settings of a frame, beside its scene and its camera.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Columns and rows of the full picture.
    pub resolution: [u32; 2],
    /// The part of the picture to render.
    pub window: Window,
    pub samples: SampleBudget,
    /// The samples of a pixel for which textures are filtered: all that the picture may ever get.
    pub planned_samples: u32,
    /// The ranges of the samples whose sums are added, if they are divided.
    pub ranges: Option<SampleRanges>,
    pub seed: u32,
    /// The frame number for the random numbers, see [`SeedMode`](crate::sampler::SeedMode).
    pub noise_frame: i32,
    pub sampler: Sampler,
    /// `None`: all samples are at the centres of their pixels.
    pub filter: Option<Filter>,
    pub content: Content,
    /// The passes of the film beside the beauty.
    pub passes: Vec<PassRequest>,
    /// The number of mattes per pixel of Cryptomatte passes, an even number.
    pub matte_ranks: u32,
}

/// The content of a rendered frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Content {
    /// The picture of the integrator, and passes.
    #[default]
    Light,
    /// First hits only, without light: rays through the centres of the pixels and of the lens when the shutter opens. Alpha is 0
    /// where they hit nothing.
    FirstHits,
}

impl Settings {
    /// The settings of a whole picture, frame 1, with the default filter.
    pub fn new(resolution: [u32; 2], samples: u32) -> Self {
        Self {
            resolution,
            window: Window::full(resolution),
            samples: SampleBudget::fixed(samples),
            planned_samples: samples,
            ranges: None,
            seed: 0,
            noise_frame: 1,
            sampler: Sampler::default_for(samples),
            filter: (samples > 1).then(Filter::default),
            content: Content::default(),
            passes: Vec::new(),
            matte_ranks: DEFAULT_RANKS,
        }
    }

    /// The number of rendered pixels, including those of adaptive blocks beyond the window.
    pub fn rendered_pixels(&self) -> u64 {
        let pixels: usize = match self.samples.adaptive {
            Some(_) => adaptive::blocks(self.window, self.resolution)
                .iter()
                .map(Window::area)
                .sum(),
            None => self.window.area(),
        };
        pixels as u64
    }

    /// The samples of each pixel, with adaptive sampling the most.
    pub fn pixel_samples(&self) -> u32 {
        let one = self
            .ranges
            .and_then(|ranges| Some(ranges.range(ranges.only?, self.samples.max)));
        one.map_or(self.samples.max, |range| range.end - range.start)
    }

    /// The most samples of a frame.
    pub fn max_samples(&self) -> u64 {
        self.rendered_pixels().saturating_mul(self.pixel_samples().into())
    }

    /// The order of the planes of a film in the accumulators of its tiles.
    pub fn accumulator_layout(&self, film: &FilmLayout) -> AccumulatorLayout {
        let layout = AccumulatorLayout::new(film, self.samples.next_stop(0));
        match self.samples.adaptive {
            Some(_) => layout.with_noise(),
            None => layout,
        }
    }

    /// The layout of a film that begins with `picture`, in a scene with these light groups.
    ///
    /// # Errors
    /// A pass shows a light group that the scene does not have.
    pub fn film_layout(&self, picture: &'static PassSpec, groups: &[String]) -> Result<FilmLayout, UnknownName> {
        Ok(FilmLayout::new(picture, &self.passes, groups)?.with_ranks(self.matte_ranks))
    }
}
