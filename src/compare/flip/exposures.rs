//! The exposures under which pictures of light are compared.

use crate::math::Rgb;

/// The curve of ACES as a quotient of polynomials: (a x^2 + b x) / (c x^2 + d x + e). Source: Narkowicz, "ACES Filmic Tone Mapping
/// Curve", 2016, without its exposure of 0.6.
const A: f32 = 0.6 * 0.6 * 2.51;
const B: f32 = 0.6 * 0.03;
const C: f32 = 0.6 * 0.6 * 2.43;
const D: f32 = 0.6 * 0.59;
const E: f32 = 0.14;

/// The display value that the brightest pixel has at the first exposure and the median at the last.
const BRIGHT: f32 = 0.85;

/// The exposures for a reference, in stops.
pub fn of(reference: &[Rgb]) -> Vec<f32> {
    let mut luminances: Vec<f32> = reference.iter().map(|pixel| luminance(*pixel)).collect();
    luminances.sort_unstable_by(f32::total_cmp);
    let (Some(&most), Some(&median)) = (luminances.last(), luminances.get(luminances.len() / 2)) else {
        return Vec::new();
    };
    // The light that the curve shows as BRIGHT.
    let (a, b, c) = (A - BRIGHT * C, B - BRIGHT * D, -BRIGHT * E);
    let light = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    let stops = |luminance: f32| libm::log2f(light / luminance.max(f32::EPSILON));
    let (first, last) = (stops(most), stops(median));
    let count = (last - first).ceil().max(2.0);
    (0..count as u32)
        .map(|i| first + (last - first) * i as f32 / (count - 1.0))
        .collect()
}

/// The luminance by the weights of the paper.
fn luminance(rgb: Rgb) -> f32 {
    let rgb = rgb.max(Rgb::BLACK);
    0.2126 * rgb.r + 0.7152 * rgb.g + 0.0722 * rgb.b
}

/// A colour times `gain` through the curve, from 0 to 1.
pub fn tone_mapped(rgb: Rgb, gain: f32) -> Rgb {
    rgb.map(|v| {
        let x = v.max(0.0) * gain;
        let below = C * x * x + D * x + E;
        if below.is_infinite() {
            return 1.0;
        }
        ((A * x * x + B * x) / below).clamp(0.0, 1.0)
    })
}
