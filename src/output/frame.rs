//! A finished frame, as every format receives it.

use super::FrameMetadata;
use crate::film::{Film, Plane};

/// A finished frame, as every format receives it.
#[derive(Clone, Copy, Debug)]
pub struct FrameImage<'a> {
    pub film: &'a Film,
    pub shown: Shown,
    /// Whether its alpha says anything.
    pub coverage: Coverage,
    pub metadata: &'a FrameMetadata,
}

/// The planes of a film that go into its files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shown {
    /// All of them; formats for displays show the first, which the integrator computed.
    #[default]
    All,
    /// The one with this index, in place of the picture.
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

    /// The planes that go into files which hold layers.
    pub fn planes(&self) -> &'a [Plane] {
        match self.shown {
            Shown::All => self.film.planes(),
            Shown::Plane(plane) => &self.film.planes()[plane..=plane],
        }
    }

    /// Whether a plane that goes into files holds light.
    pub(super) fn has_light(&self) -> bool {
        self.planes().iter().any(|plane| plane.spec.pass.is_light())
    }
}

/// Whether the alpha of a picture says anything. It belongs to the job and not to the frame's pixels, so that all files of a
/// sequence have the same channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coverage {
    /// A visible background: alpha is 1 everywhere, and formats for displays leave it out.
    Full,
    /// Pixels may be empty.
    Partial,
}
