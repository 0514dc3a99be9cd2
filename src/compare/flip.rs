//! FLIP: the difference that a viewer sees between two pictures that alternate in one place.
//!
//! Sources: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference Evaluator for Alternating
//! Images", HPG 2020; Andersson, Nilsson, Shirley and Akenine-Möller, "Visualizing Errors in Rendered High Dynamic Range Images",
//! Eurographics 2021. Constants are those of the papers.

mod color;
mod exposures;
mod filters;

use self::{
    color::{hunt_lab, max_distance, opponent, rgb_of_opponent},
    filters::{Features, Filters, Plane},
};
use super::Picture;
use crate::math::{Rgb, parallel};

/// Pixels of a degree of the viewer's sight: a display of 3,840 pixels and 0.7 m, 0.7 m away.
const PIXELS_PER_DEGREE: f32 = 3840.0 * std::f32::consts::PI / 180.0;

/// The exponent of colour differences.
const COLOR_EXPONENT: f32 = 0.7;

/// The share of the largest colour difference that becomes [`KNEE_ERROR`].
const KNEE: f32 = 0.4;
const KNEE_ERROR: f32 = 0.95;

/// LDR-FLIP of each pixel, from 0 to 1.
pub(super) fn of_display_values(reference: &Picture, test: &Picture) -> Vec<f32> {
    ldr(
        reference.size,
        &reference.linear(),
        &test.linear(),
        &Filters::new(PIXELS_PER_DEGREE),
    )
}

/// HDR-FLIP of each pixel, from 0 to 1: the largest LDR-FLIP under the exposures that show the reference.
pub(super) fn of_light(reference: &Picture, test: &Picture) -> Vec<f32> {
    let filters = Filters::new(PIXELS_PER_DEGREE);
    let mut most = vec![0.0_f32; reference.pixels.len()];
    for stops in exposures::of(&reference.pixels) {
        let shown = |picture: &Picture| -> Vec<Rgb> {
            let gain = libm::exp2f(stops);
            let pixels = &picture.pixels;
            parallel::table(pixels.len(), |i| exposures::tone_mapped(pixels[i], gain))
        };
        let errors = ldr(reference.size, &shown(reference), &shown(test), &filters);
        for (most, error) in most.iter_mut().zip(errors) {
            *most = most.max(error);
        }
    }
    most
}

/// LDR-FLIP of linear colours from 0 to 1.
fn ldr(size: [u32; 2], reference: &[Rgb], test: &[Rgb], filters: &Filters) -> Vec<f32> {
    let (a, b) = (Seen::new(size, reference, filters), Seen::new(size, test, filters));
    let largest = libm::powf(max_distance(), COLOR_EXPONENT);
    parallel::table(reference.len(), |i| {
        let color = redistributed(libm::powf(a.colors[i].distance(b.colors[i]), COLOR_EXPONENT), largest);
        let feature = a.features.difference(&b.features, i);
        libm::powf(color, 1.0 - feature)
    })
}

/// A picture as the eye takes it.
struct Seen {
    colors: Vec<color::Lab>,
    features: Features,
}

impl Seen {
    fn new(size: [u32; 2], linear: &[Rgb], filters: &Filters) -> Self {
        let opponents = parallel::table(linear.len(), |i| opponent(linear[i]));
        let plane = |channel: usize| Plane {
            size,
            values: opponents.iter().map(|color| color[channel]).collect(),
        };
        let planes = [plane(0), plane(1), plane(2)];
        let blurred = filters.contrast(&planes);
        let gray = Plane {
            size,
            values: planes[0].values.iter().map(|y| (y + 16.0) / 116.0).collect(),
        };
        let colors = parallel::table(linear.len(), |i| {
            let rgb = rgb_of_opponent([0, 1, 2].map(|channel: usize| blurred[channel].values[i]));
            hunt_lab(rgb.map(|v| v.clamp(0.0, 1.0)))
        });
        Self {
            colors,
            features: filters.features(&gray),
        }
    }
}

/// A colour difference as an error from 0 to 1. Few pairs of colours are far apart: most of the range is for the others.
fn redistributed(difference: f32, largest: f32) -> f32 {
    let knee = KNEE * largest;
    if difference < knee {
        KNEE_ERROR / knee * difference
    } else {
        KNEE_ERROR + (difference - knee) / (largest - knee) * (1.0 - KNEE_ERROR)
    }
}
