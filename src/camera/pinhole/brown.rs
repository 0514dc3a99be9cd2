//! OpenCV's distortion of the plane at distance 1: radial with a rational factor, tangential, thin prism.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DMat2, DVec2, DVec3};
use serde::Serialize;

use super::{
    model::{Model, padded},
    rising::{invert, rising_end},
};
use crate::camera::ViewDistortion;

/// The most steps of Newton's method, halvings of a step among them.
const MAX_STEPS: u32 = 64;

/// The largest error of a solution, in focal lengths, or in parts of a longer distance from the axis: a millionth of a
/// pixel where these are 100,000 pixels.
const TOLERANCE: f64 = 1e-11;

/// The points of a circle at which it is checked whether the picture folds over.
const AZIMUTHS: u32 = 32;

/// OpenCV's model, up to the radius at which its pictures fold over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Brown {
    /// `k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4`.
    coefficients: [f64; 12],
    /// The radius on the plane at distance 1.
    end: f64,
}

impl Brown {
    /// The radial factor and its derivative by the square of the radius.
    fn factor(&self, r2: f64) -> [f64; 2] {
        let [k1, k2, _, _, k3, k4, k5, k6, ..] = self.coefficients;
        let above = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
        let above_slope = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
        let below_slope = k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6);
        [
            above / below,
            (above_slope * below - above * below_slope) / (below * below),
        ]
    }

    /// The distorted radius and its slope.
    fn radius(&self, r: f64) -> [f64; 2] {
        let [factor, slope] = self.factor(r * r);
        [r * factor, factor + 2.0 * r * r * slope]
    }

    /// The place of a point of the plane, and its derivatives.
    fn distorted(&self, p: DVec2) -> (DVec2, DMat2) {
        let [_, _, p1, p2, _, _, _, _, s1, s2, s3, s4] = self.coefficients;
        let (x, y, r2) = (p.x, p.y, p.length_squared());
        let [factor, slope] = self.factor(r2);
        let place = DVec2::new(
            x * factor + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + r2 * (s1 + s2 * r2),
            y * factor + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + r2 * (s3 + s4 * r2),
        );
        let (prism_x, prism_y) = (s1 + 2.0 * s2 * r2, s3 + 2.0 * s4 * r2);
        let cross = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
        let by_x = DVec2::new(
            factor + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x + 2.0 * x * prism_x,
            cross + 2.0 * x * prism_y,
        );
        let by_y = DVec2::new(
            cross + 2.0 * y * prism_x,
            factor + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x + 2.0 * y * prism_y,
        );
        (place, DMat2::from_cols(by_x, by_y))
    }

    /// A point of the plane that is seen at a place, by Newton's method from `p`. Steps that lead away, or over a fold, are halved.
    fn solve(&self, place: DVec2, mut p: DVec2) -> Option<DVec2> {
        let most = TOLERANCE * place.length().max(1.0);
        let (mut at, mut slopes) = self.distorted(p);
        let mut step = slopes.inverse() * (place - at);
        for _ in 0..MAX_STEPS {
            let error = (place - at).length_squared();
            if error <= most * most {
                return Some(p);
            }
            let next = p + step;
            if next == p {
                return None;
            }
            let (at_next, slopes_next) = self.distorted(next);
            let is_nearer = (place - at_next).length_squared() < error;
            if is_nearer && slopes_next.determinant() > 0.0 {
                (p, at, slopes) = (next, at_next, slopes_next);
                step = slopes.inverse() * (place - at);
            } else {
                step *= 0.5;
            }
        }
        None
    }

    /// Whether it moves points along their radius only.
    fn is_radial(&self) -> bool {
        let [_, _, p1, p2, _, _, _, _, prism @ ..] = self.coefficients;
        [p1, p2] == [0.0; 2] && prism == [0.0; 4]
    }

    /// Whether the picture folds over nowhere on the circle of radius `r`.
    fn is_unfolded(&self, r: f64) -> bool {
        let [at, slope] = self.radius(r);
        let unfolds = |azimuth: u32| {
            let angle = f64::from(azimuth) * (TAU / f64::from(AZIMUTHS));
            let (sin, cos) = libm::sincos(angle);
            self.distorted(DVec2::new(cos, sin) * r).1.determinant() > 0.0
        };
        slope > 0.0 && at.is_finite() && at >= 0.0 && (self.is_radial() || (0..AZIMUTHS).all(unfolds))
    }
}

impl Model for Brown {
    const COUNTS: &'static [usize] = &[4, 5, 8, 12];
    const HAS_PLANE: bool = true;

    fn new(coefficients: &[f64]) -> Self {
        let coefficients = padded(coefficients);
        let whole = Self {
            coefficients,
            end: f64::INFINITY,
        };
        let most = FRAC_PI_2 - 1e-4;
        Self {
            end: libm::tan(rising_end(most, |angle| whole.is_unfolded(libm::tan(angle)))),
            ..whole
        }
    }

    fn place(&self, d: DVec3) -> Option<DVec2> {
        let p = d.truncate() / d.z;
        let is_seen = d.z > 0.0 && p.length() <= self.end;
        let (place, slopes) = self.distorted(p);
        (is_seen && slopes.determinant() > 0.0).then_some(place)
    }

    fn direction(&self, place: DVec2) -> Option<DVec3> {
        let radius = place.length();
        // All but the tangential terms and those of the prism.
        let most = self.radius(self.end)[0];
        let straight = invert(radius.min(most), self.end, |r| self.radius(r))?;
        let p = if radius > 0.0 {
            place * (straight / radius)
        } else {
            place
        };
        if self.is_radial() {
            return (radius <= most).then(|| p.extend(1.0));
        }
        // Near a fold the first may lead nowhere.
        let starts = [p, 0.5 * p, DVec2::ZERO];
        let found = starts.into_iter().find_map(|start| self.solve(place, start))?;
        (found.length() <= self.end).then(|| found.extend(1.0))
    }

    fn middle_slope(&self) -> f64 {
        1.0
    }

    fn of_data_sets(&self) -> Option<ViewDistortion> {
        Some(ViewDistortion::OpenCv(self.coefficients))
    }
}
