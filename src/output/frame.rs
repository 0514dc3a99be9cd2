//! Finished frames, the input of every format.

use serde::Serialize;

use super::{FrameMetadata, PixelDisplay};
use crate::{
    film::{Film, Plane},
    math::parallel,
};

/// A finished frame, the input of every format.
#[derive(Clone, Copy, Debug)]
pub struct FrameImage<'a> {
    pub film: &'a Film,
    pub shown: Shown,
    /// Whether its alpha carries information.
    pub coverage: Coverage,
    pub metadata: &'a FrameMetadata,
}

/// The planes of a film that files show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Shown {
    /// All planes; formats for displays show the first, the integrator's picture.
    #[default]
    All,
    /// Only the plane with this index.
    Plane(usize),
}

impl<'a> FrameImage<'a> {
    /// The plane that formats for displays show.
    pub fn picture(&self) -> &'a Plane {
        match self.shown {
            Shown::All => &self.film.planes()[0],
            Shown::Plane(plane) => &self.film.planes()[plane],
        }
    }

    /// The display of that plane.
    pub fn display(&self) -> PixelDisplay {
        let metadata = self.metadata;
        let display = self.picture().spec.pass.display;
        PixelDisplay::new(display, metadata.view, metadata.exposure, metadata.working_space)
    }

    /// The first three channels of a pixel of that plane; missing channels are 0.
    pub(super) fn channels(&self, pixel: usize) -> [f32; 3] {
        let values = self.picture().pixel(pixel);
        std::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0))
    }

    /// The display values of all pixels of that plane, over black, row by row.
    pub fn pixels_over_black(&self) -> Vec<[u8; 3]> {
        let display = self.display();
        let pixel = |i: usize| display.rgb8(self.channels(i));
        parallel::table(self.film.window.area(), pixel)
    }

    /// The planes of formats with layers.
    pub fn planes(&self) -> &'a [Plane] {
        match self.shown {
            Shown::All => self.film.planes(),
            Shown::Plane(plane) => &self.film.planes()[plane..=plane],
        }
    }

    /// Whether a shown plane holds light.
    pub(super) fn has_light(&self) -> bool {
        self.planes().iter().any(|plane| plane.spec.pass.is_light())
    }
}

/// Whether the alpha of a picture carries information. This is a property of the job, not of the pixels, so that all files of a
/// sequence have the same channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coverage {
    /// The background is visible, so that alpha is 1 everywhere, or the picture has surfaces that alpha leaves
    /// out: formats for displays have none.
    Full,
    /// Pixels may be empty.
    Partial,
}

impl Coverage {
    /// The light of a premultiplied pixel as formats for displays show it: straight where alpha carries information. An empty pixel
    /// cannot be divided by its alpha.
    pub fn shown(self, [r, g, b, alpha]: [f32; 4]) -> [f32; 3] {
        match self == Self::Partial && alpha > 0.0 {
            true => [r, g, b].map(|v| v / alpha),
            false => [r, g, b],
        }
    }
}
