//! The contract of distortions, and their coefficients.

use glam::{DVec2, DVec3};

use crate::camera::ViewDistortion;

/// The contract of every model.
///
/// Directions are those of a camera that looks along +z, with x to the right and y downwards, of any length. Places on the film are
/// in focal lengths from the optical axis.
pub(super) trait Model: Copy {
    /// The numbers of coefficients that it takes.
    const COUNTS: &'static [usize];

    /// Whether it sees only what is before the plane of the lens, so that depth is measured along the axis.
    const HAS_PLANE: bool;

    /// The model with these coefficients, as many as it takes.
    fn new(coefficients: &[f64]) -> Self;

    /// The reason why no picture can be made with it, if there is one.
    fn flaw(&self) -> Option<&'static str> {
        None
    }

    /// The place at which a direction is seen; `None` if it is not seen.
    fn place(&self, d: DVec3) -> Option<DVec2>;

    /// The direction that is seen at a place; `None` if there is none.
    fn direction(&self, place: DVec2) -> Option<DVec3>;

    /// The angle in radians for a focal length, in the middle.
    fn middle_slope(&self) -> f64;

    /// This distortion as data sets say it; `None` if they do not know it.
    fn of_data_sets(&self) -> Option<ViewDistortion> {
        None
    }
}

/// These coefficients, and zeros.
pub(super) fn padded<const N: usize>(given: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| given.get(i).copied().unwrap_or(0.0))
}
