//! Colours of black bodies.

use crate::{
    math::Rgb,
    value::{Finite, Problem, Spanned, Stops},
};

/// The lowest and the highest temperature of a light, in K.
const RANGE: [f32; 2] = [500.0, 100_000.0];

/// The factor of a light's strength by its temperature in K, which colours it and keeps its luminance, and its exposure in stops.
///
/// # Errors
/// The temperature is out of range.
pub(super) fn factor(temperature: &Option<Spanned<Finite>>, exposure: Option<Stops>) -> Result<Rgb, Problem> {
    let stops = libm::exp2f(exposure.map_or(0.0, |stops| stops.0));
    let Some(kelvin) = temperature else {
        return Ok(Rgb::gray(stops));
    };
    let t = kelvin.get_ref().0;
    let [low, high] = RANGE;
    if !(low..=high).contains(&t) {
        let message = format!("expected a temperature from {low} to {high} K, found {t}");
        return Err(Problem::at(kelvin.span(), message));
    }
    Ok(black_body(t.into()) * stops)
}

/// The colour of a black body of `t` K in linear Rec. 709, with a luminance of 1. Channels below 0, of
/// which red-hot bodies have one, are 0.
///
/// Planck's law, weighted by the colour matching functions of the CIE 1931 observer as they are approximated in Wyman, Sloan,
/// Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2), 2013.
fn black_body(t: f64) -> Rgb {
    let mut xyz = [0.0; 3];
    for nm in (360..=830).step_by(5).map(f64::from) {
        // The exponent is h c / (k lambda t), with the constants of the SI.
        let radiance = libm::pow(nm / 560.0, -5.0) / libm::expm1(1.438_776_877e7 / (nm * t));
        for (sum, weight) in xyz.iter_mut().zip(observer(nm)) {
            *sum += radiance * weight;
        }
    }
    let [x, y, z] = xyz.map(|v| v / xyz[1]);
    let rgb = [
        3.240_97 * x - 1.537_383 * y - 0.498_611 * z,
        -0.969_244 * x + 1.875_968 * y + 0.041_555 * z,
        0.055_63 * x - 0.203_977 * y + 1.056_972 * z,
    ];
    let [r, g, b] = rgb.map(|v| v.max(0.0));
    let luminance = 0.212_639 * r + 0.715_169 * g + 0.072_192 * b;
    Rgb::from_array([r, g, b].map(|v| (v / luminance) as f32))
}

/// The colour matching functions of the CIE 1931 observer at a wavelength in nm.
fn observer(nm: f64) -> [f64; 3] {
    let lobe = |peak: f64, left: f64, right: f64| {
        let t = (nm - peak) * if nm < peak { left } else { right };
        libm::exp(-0.5 * t * t)
    };
    [
        1.056 * lobe(599.8, 0.0264, 0.0323) + 0.362 * lobe(442.0, 0.0624, 0.0374) - 0.065 * lobe(501.1, 0.0490, 0.0382),
        0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322),
        1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_bodies_lie_on_the_planckian_locus() {
        // x and y of the CIE 1931 observer, Wyszecki and Stiles, "Color Science", table 1(3.11).
        let locus = [
            (1500.0, [0.5857, 0.3931]),
            (2856.0, [0.4476, 0.4074]),
            (4000.0, [0.3805, 0.3768]),
            (6500.0, [0.3135, 0.3237]),
            (10_000.0, [0.2807, 0.2884]),
        ];
        for (t, [x, y]) in locus {
            let [r, g, b] = black_body(t).to_array().map(f64::from);
            let xyz = [
                0.412_391 * r + 0.357_584 * g + 0.180_481 * b,
                0.212_639 * r + 0.715_169 * g + 0.072_192 * b,
                0.019_331 * r + 0.119_195 * g + 0.950_532 * b,
            ];
            let sum: f64 = xyz.iter().sum();
            // The blue of the first is clipped.
            let near = if t < 1900.0 { 0.02 } else { 0.004 };
            assert!(
                (xyz[0] / sum - x).abs() < near && (xyz[1] / sum - y).abs() < near,
                "{t}"
            );
            assert!((xyz[1] - 1.0).abs() < 1e-3, "{t}: luminance {}", xyz[1]);
        }
    }

    #[test]
    fn a_stop_doubles_and_temperatures_have_a_range() {
        let kelvin = |t: f32| Some(Spanned::new(0..1, Finite(t)));
        assert_eq!(factor(&None, Some(Stops(-1.0))), Ok(Rgb::gray(0.5)));
        assert_eq!(
            factor(&kelvin(3200.0), Some(Stops(3.0))).unwrap(),
            factor(&kelvin(3200.0), None).unwrap() * 8.0
        );
        let message = factor(&kelvin(20.0), None).unwrap_err().message;
        assert_eq!(message, "expected a temperature from 500 to 100000 K, found 20");
    }
}
