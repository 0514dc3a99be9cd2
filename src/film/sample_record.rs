//! The finished samples of a wave, as accumulators receive them.

use crate::{math::Rgb, scene::FirstHit};

/// A finished sample.
#[derive(Clone, Copy, Debug)]
pub struct SampleRecord<'a> {
    /// Radiance, in W m^-2 sr^-1.
    pub l: Rgb,
    /// The same without other objects, if the sample meets a shadow catcher.
    pub without: Option<Rgb>,
    /// The radiance of the background behind that catcher, if the camera sees backgrounds.
    pub behind: Option<Rgb>,
    pub alpha: f32,
    /// 1, or -1 if the pixel filter is negative.
    pub weight: f32,
    /// Its index within the pixel.
    pub index: u32,
    /// The squared distance from the pixel's centre, in pixels.
    pub distance_squared: f32,
    /// The first hit of its camera ray; used if the layout needs first hits.
    pub first: Option<&'a FirstHit>,
    /// Its layers of light; empty if the layout does not need them.
    pub light: &'a [Rgb],
}
