//! Spectra of the sky: sunlight, what absorbs and scatters it, and the colours that they become.
//!
//! Sources: sunlight outside of the atmosphere from ASTM G173-03, the cross section of ozone at 223 K from Gorshelev et al.
//! and Serdyuchenko et al., "High spectral resolution ozone absorption cross-sections", AMT 7, 2014,
//! doi:10.5194/amt-7-609-2014 and doi:10.5194/amt-7-625-2014, both averaged around each wavelength; the colour matching
//! functions from Wyman et al., "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2), 2013.

use std::array;

/// The number of wavelengths.
pub(super) const COUNT: usize = 19;

/// A number for each of the wavelengths 380, 400 ... 740 nm.
pub(super) type Spectrum = [f64; COUNT];

/// The irradiance of the sun outside of the atmosphere, in W m^-2 nm^-1.
pub(super) const SUNLIGHT: Spectrum = [
    1.08, 1.58, 1.68, 1.87, 2.02, 1.96, 1.91, 1.86, 1.86, 1.84, 1.81, 1.75, 1.68, 1.59, 1.54, 1.48, 1.41, 1.34, 1.29,
];

/// The cross section of a molecule of ozone, in 1e-26 m^2.
pub(super) const OZONE: Spectrum = [
    0.0361, 0.162, 0.556, 1.58, 3.64, 7.36, 13.7, 21.6, 31.1, 41.8, 45.4, 47.6, 37.5, 26.9, 18.5, 12.1, 7.72, 5.23,
    3.96,
];

/// The spectrum of a function of the wavelength in micrometres.
pub(super) fn spectrum(of: impl Fn(f64) -> f64) -> Spectrum {
    array::from_fn(|k| of(0.38 + 0.02 * k as f64))
}

/// The albedo of a surface with a linear colour of Rec. 709: constant up to 490 nm, up to 590 nm and beyond.
pub(super) fn upsample([r, g, b]: [f64; 3]) -> Spectrum {
    spectrum(|l| match l {
        _ if l < 0.49 => b,
        _ if l < 0.59 => g,
        _ => r,
    })
}

/// The linear colour of Rec. 709 of spectra, such that its luminance is their mean by the luminous efficiency.
pub(super) struct ToRgb([Spectrum; 3]);

/// A lobe of the colour matching functions: its mean and its widths to either side, in nm.
fn lobe(l: f64, mean: f64, left: f64, right: f64) -> f64 {
    let t = (1e3 * l - mean) / if 1e3 * l < mean { left } else { right };
    libm::exp(-0.5 * t * t)
}

impl ToRgb {
    pub fn new() -> Self {
        let x = spectrum(|l| {
            1.056 * lobe(l, 599.8, 37.9, 31.0) + 0.362 * lobe(l, 442.0, 16.0, 26.7) - 0.065 * lobe(l, 501.1, 20.4, 26.2)
        });
        let y = spectrum(|l| 0.821 * lobe(l, 568.8, 46.9, 40.5) + 0.286 * lobe(l, 530.9, 16.3, 31.1));
        let z = spectrum(|l| 1.217 * lobe(l, 437.0, 11.8, 36.0) + 0.681 * lobe(l, 459.0, 26.0, 13.8));
        let total: f64 = y.iter().sum();
        // From XYZ to linear Rec. 709 with the white of D65 (IEC 61966-2-1).
        let matrix = [
            [3.2406, -1.5372, -0.4986],
            [-0.9689, 1.8758, 0.0415],
            [0.0557, -0.2040, 1.0570],
        ];
        Self(matrix.map(|[a, b, c]| array::from_fn(|k| (a * x[k] + b * y[k] + c * z[k]) / total)))
    }

    pub fn convert(&self, spectrum: &Spectrum) -> [f64; 3] {
        self.0
            .map(|weights| weights.iter().zip(spectrum).map(|(w, s)| w * s).sum())
    }
}
