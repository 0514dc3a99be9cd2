//! Working spaces: the primaries of the colours that a picture is computed with.

use serde::Deserialize;

use super::Rgb;

/// The primaries that all colours have while a picture is computed. Scene files, images and models have those of Rec. 709.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum WorkingSpace {
    /// Rec. 709 (sRGB), white D65.
    #[default]
    #[serde(rename = "rec709")]
    Rec709,
    /// ACEScg: the primaries AP1 with the white of ACES. Rec. 709 is adapted to it as Bradford does.
    ///
    /// Source: "ACEScg, a working space for CGI render and compositing", S-2014-004, Academy of Motion Picture Arts and
    /// Sciences.
    #[serde(rename = "acescg")]
    AcesCg,
}

/// By rows.
const AP1_FROM_REC_709: [[f32; 3]; 3] = [
    [0.613_097_4, 0.339_523_15, 0.047_379_45],
    [0.070_193_72, 0.916_353_9, 0.013_452_4],
    [0.020_615_593, 0.109_569_77, 0.869_814_63],
];

const REC_709_FROM_AP1: [[f32; 3]; 3] = [
    [1.705_051, -0.621_792_14, -0.083_258_87],
    [-0.130_256_41, 1.140_804_8, -0.010_548_319],
    [-0.024_003_357, -0.128_968_98, 1.152_972_3],
];

impl WorkingSpace {
    /// x and y of red, green, blue and white.
    pub fn chromaticities(self) -> [f32; 8] {
        match self {
            Self::Rec709 => [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290],
            Self::AcesCg => [0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767],
        }
    }

    /// The name of its scene-linear light, by the Color Interop Forum.
    pub fn interop_id(self) -> &'static str {
        match self {
            Self::Rec709 => "lin_rec709_scene",
            Self::AcesCg => "lin_ap1_scene",
        }
    }

    /// The matrix from Rec. 709, by rows; `None` where that changes nothing.
    pub(super) fn rows_from_rec709(self) -> Option<[[f32; 3]; 3]> {
        match self {
            Self::Rec709 => None,
            Self::AcesCg => Some(AP1_FROM_REC_709),
        }
    }

    /// A linear colour of Rec. 709 in this space. No channel of it is below 0 where none of the colour is.
    #[inline]
    pub fn from_rec709(self, color: Rgb) -> Rgb {
        match self {
            Self::Rec709 => color,
            Self::AcesCg => product(&AP1_FROM_REC_709, color),
        }
    }

    /// A colour of this space as a linear one of Rec. 709; below 0 where that cannot show it.
    #[inline]
    pub fn to_rec709(self, color: Rgb) -> Rgb {
        match self {
            Self::Rec709 => color,
            Self::AcesCg => product(&REC_709_FROM_AP1, color),
        }
    }
}

/// The product of a matrix, given by its rows, with a colour.
#[inline]
pub(super) fn product(rows: &[[f32; 3]; 3], Rgb { r, g, b }: Rgb) -> Rgb {
    let [x, y, z] = rows.map(|[of_r, of_g, of_b]| of_r * r + of_g * g + of_b * b);
    Rgb::new(x, y, z)
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;

    /// From linear RGB to XYZ, by the definition of primaries and white.
    fn xyz_from_rgb(space: WorkingSpace) -> (DMat3, DVec3) {
        let c = space.chromaticities().map(f64::from);
        let xyz = |i: usize| DVec3::new(c[i] / c[i + 1], 1.0, (1.0 - c[i] - c[i + 1]) / c[i + 1]);
        let (primaries, white) = (DMat3::from_cols(xyz(0), xyz(2), xyz(4)), xyz(6));
        let scale = primaries.inverse() * white;
        (primaries * DMat3::from_diagonal(scale), white)
    }

    #[test]
    fn the_matrices_follow_from_the_chromaticities_by_bradfords_adaptation() {
        let bradford = DMat3::from_cols_array(&[
            0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296,
        ]);
        let (from_709, d65) = xyz_from_rgb(WorkingSpace::Rec709);
        let (from_ap1, aces) = xyz_from_rgb(WorkingSpace::AcesCg);
        let gains = (bradford * aces) / (bradford * d65);
        let adapt = bradford.inverse() * DMat3::from_diagonal(gains) * bradford;
        let expected = from_ap1.inverse() * adapt * from_709;
        let check = |found: [[f32; 3]; 3], expected: DMat3| {
            for (i, row) in found.into_iter().enumerate() {
                for (j, v) in row.into_iter().enumerate() {
                    assert!(
                        (f64::from(v) - expected.col(j)[i]).abs() < 1e-6,
                        "{v} and {}",
                        expected.col(j)[i]
                    );
                }
            }
        };
        check(AP1_FROM_REC_709, expected);
        check(REC_709_FROM_AP1, expected.inverse());
    }

    #[test]
    fn gray_stays_gray_and_every_colour_comes_back() {
        let space = WorkingSpace::AcesCg;
        let near = |a: Rgb, b: Rgb| (a - b).map(f32::abs).max_component() < 1e-6;
        assert!(near(space.from_rec709(Rgb::gray(0.3)), Rgb::gray(0.3)));
        let color = Rgb::new(0.9, 0.1, 0.4);
        assert!(near(space.to_rec709(space.from_rec709(color)), color));
        assert_eq!(WorkingSpace::Rec709.from_rec709(color), color);
    }
}
