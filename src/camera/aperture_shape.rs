//! The shape of the aperture.

use std::f32::consts::TAU;

use serde::Serialize;

use crate::math::{Vec2, trig, warp};

/// The shape of an aperture of radius 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub enum ApertureShape {
    #[default]
    Round,
    /// A regular polygon with its corners on the circle.
    Polygon {
        /// Number of corners, at least 3.
        blades: u32,
        /// Angle of the first corner, counterclockwise from the right as seen from behind the
        /// camera, in radians.
        rotation: f32,
    },
}

impl ApertureShape {
    /// Samples a point uniformly by area, from two uniform numbers, with low distortion.
    pub fn sample(self, u: Vec2) -> Vec2 {
        match self {
            Self::Round => warp::square_to_disk(u),
            Self::Polygon { blades, rotation } => {
                let n = blades as f32;
                let along = u.x * n;
                let side = along.floor().min(n - 1.0);
                // Of the triangle between the middle and a side: along the side, and from the
                // middle to it.
                let (t, r) = (along - side, u.y.sqrt());
                let corner = |k: f32| {
                    let (sin, cos) = trig::sin_cos(rotation + TAU * k / n);
                    Vec2::new(cos, sin)
                };
                r * ((1.0 - t) * corner(side) + t * corner(side + 1.0))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: u32) -> impl Iterator<Item = Vec2> {
        (0..n * n).map(move |i| Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32)
    }

    #[test]
    fn a_round_opening_is_filled_evenly() {
        let inside = grid(400)
            .filter(|u| ApertureShape::Round.sample(*u).length() < 0.5)
            .count();
        assert!((inside as f64 / 160_000.0 - 0.25).abs() < 2e-3);
    }

    #[test]
    fn a_polygon_is_filled_evenly_and_never_left() {
        for blades in [3_u32, 5, 6, 11] {
            let rotation = 0.3;
            let aperture_shape = ApertureShape::Polygon { blades, rotation };
            let sector = TAU / blades as f32;
            let apothem = trig::cos(0.5 * sector);
            // The distance from the middle, in apothems, along the side's own normal.
            let reach = |p: Vec2| {
                (0..blades)
                    .map(|k| {
                        let (sin, cos) = trig::sin_cos(rotation + (k as f32 + 0.5) * sector);
                        p.dot(Vec2::new(cos, sin)) / apothem
                    })
                    .fold(0.0, f32::max)
            };
            let points: Vec<_> = grid(300).map(|u| aperture_shape.sample(u)).collect();
            assert!(points.iter().all(|p| reach(*p) <= 1.0 + 1e-6), "{blades}");
            let n = points.len() as f64;
            // A similar polygon of half the size has a quarter of the points; so has every half
            // plane one half.
            let inner = points.iter().filter(|p| reach(**p) < 0.5).count() as f64;
            assert!((inner / n - 0.25).abs() < 2e-3, "{blades}");
            let mean = points.iter().sum::<Vec2>() / n as f32;
            assert!(mean.length() < 1e-3, "{blades} {mean}");
            // Twice the second moment about an axis is the moment about the middle: (2 +
            // cos(sector)) / 6 for a side.
            let moment = points.iter().map(|p| f64::from(p.length_squared())).sum::<f64>() / n;
            assert!(
                (moment - f64::from(2.0 + trig::cos(sector)) / 6.0).abs() < 1e-3,
                "{blades} {moment}"
            );
        }
    }

    #[test]
    fn many_blades_are_round() {
        let aperture_shape = ApertureShape::Polygon {
            blades: 100_000,
            rotation: 0.0,
        };
        let mean = grid(200)
            .map(|u| aperture_shape.sample(u).length_squared())
            .sum::<f32>()
            / 40_000.0;
        assert!((mean - 0.5).abs() < 1e-3);
    }
}
