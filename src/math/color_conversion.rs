//! Conversion of colours from the primaries of a picture to those of a working space.

use glam::{DMat3, DVec3};

use super::{Rgb, WorkingSpace, working_space::product};

/// The chromaticities x and y of red, green, blue and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries(pub [f32; 8]);

impl Default for Primaries {
    fn default() -> Self {
        Self(WorkingSpace::Rec709.chromaticities())
    }
}

/// The largest difference between two roundings of the same chromaticity.
const ROUNDING: f32 = 1e-3;

impl Primaries {
    fn are_of(&self, space: WorkingSpace) -> bool {
        let own = self.0.iter().zip(space.chromaticities());
        own.into_iter().all(|(a, b)| (a - b).abs() < ROUNDING)
    }

    /// From linear RGB to XYZ, and the XYZ of white; `None` where the primaries span no space.
    fn to_xyz(self) -> Option<(DMat3, DVec3)> {
        let c = self.0.map(f64::from);
        let xyz = |i: usize| DVec3::new(c[i], c[i + 1], 1.0 - c[i] - c[i + 1]);
        let (primaries, white) = (DMat3::from_cols(xyz(0), xyz(2), xyz(4)), xyz(6) / c[7]);
        let matrix = primaries * DMat3::from_diagonal(primaries.inverse() * white);
        (matrix.is_finite() && matrix.determinant().abs() > 1e-9).then_some((matrix, white))
    }
}

/// A conversion of linear colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ColorConversion {
    /// By rows; `None` changes nothing.
    rows: Option<[[f32; 3]; 3]>,
    /// Whether channels below 0 become 0.
    clamps: bool,
}

impl ColorConversion {
    /// From the primaries of a picture to `space`, whose white is adapted as Bradford does. Channels below 0 become 0, which the
    /// space cannot show. Unusable primaries count as those of Rec. 709.
    pub fn new(from: Primaries, space: WorkingSpace) -> Self {
        if from.are_of(space) {
            return Self::default();
        }
        let own = from.to_xyz().filter(|_| !from.are_of(WorkingSpace::Rec709));
        let rows = match own {
            None => space.rows_from_rec709(),
            Some(own) => {
                let to = Primaries(space.chromaticities()).to_xyz();
                to.map(|to| adapted(own, to)).or(space.rows_from_rec709())
            }
        };
        let clamps = own.is_some();
        Self { rows, clamps }
    }

    /// The same, after which no channel is below 0.
    pub fn clamped(self) -> Self {
        Self { clamps: true, ..self }
    }

    #[inline]
    pub fn convert(&self, color: Rgb) -> Rgb {
        let converted = match &self.rows {
            None => color,
            Some(rows) => product(rows, color),
        };
        if self.clamps {
            converted.max(Rgb::BLACK)
        } else {
            converted
        }
    }
}

/// The rows of the matrix between two spaces, given with their whites.
///
/// Source: Lam, "Metamerism and Colour Constancy", PhD thesis, University of Bradford, 1985.
fn adapted((from, from_white): (DMat3, DVec3), (to, to_white): (DMat3, DVec3)) -> [[f32; 3]; 3] {
    let bradford = DMat3::from_cols_array(&[
        0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296,
    ]);
    let gains = (bradford * to_white) / (bradford * from_white);
    let adapt = bradford.inverse() * DMat3::from_diagonal(gains) * bradford;
    let rows = (to.inverse() * adapt * from).transpose();
    rows.to_cols_array_2d().map(|row| row.map(|v| v as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Rgb, b: Rgb) -> bool {
        (a - b).map(f32::abs).max_component() < 1e-4
    }

    #[test]
    fn pictures_in_the_working_space_keep_their_bits() {
        for space in [WorkingSpace::Rec709, WorkingSpace::AcesCg] {
            let rounded = space.chromaticities().map(|v| (v * 1e4).round() / 1e4);
            let color = Rgb::new(0.1, -0.2, 70.0);
            assert_eq!(ColorConversion::new(Primaries(rounded), space).convert(color), color);
        }
        let color = Rgb::new(0.9, 0.1, 0.4);
        let to_acescg = ColorConversion::new(Primaries::default(), WorkingSpace::AcesCg);
        assert_eq!(to_acescg.convert(color), WorkingSpace::AcesCg.from_rec709(color));
    }

    #[test]
    fn colours_of_other_primaries_are_the_same_colours() {
        let ap1 = Primaries(WorkingSpace::AcesCg.chromaticities());
        let from_ap1 = ColorConversion::new(ap1, WorkingSpace::Rec709);
        let red = WorkingSpace::AcesCg.from_rec709(Rgb::new(1.0, 0.0, 0.0));
        assert!(near(from_ap1.convert(red), Rgb::new(1.0, 0.0, 0.0)));
        // The linear red of Rec. 709 in Rec. 2020, by ITU-R BT.2087.
        let rec2020 = Primaries([0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290]);
        let from_2020 = ColorConversion::new(rec2020, WorkingSpace::Rec709);
        let found = from_2020.convert(Rgb::new(0.6274, 0.0691, 0.0164));
        assert!(
            (found - Rgb::new(1.0, 0.0, 0.0)).map(f32::abs).max_component() < 1e-3,
            "{found:?}"
        );
        // What the space cannot show is black there, and gray stays gray.
        assert_eq!(from_2020.convert(Rgb::new(0.0, 1.0, 0.0)).r, 0.0);
        assert!(near(from_2020.convert(Rgb::gray(0.5)), Rgb::gray(0.5)));
    }

    #[test]
    fn primaries_without_an_area_are_passed_over() {
        let broken = ColorConversion::new(Primaries([0.0; 8]), WorkingSpace::Rec709);
        assert_eq!(broken, ColorConversion::default());
    }
}
