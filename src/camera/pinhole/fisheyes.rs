//! Fisheyes whose distance from the middle is a polynomial of the angle, or whose angle is one of the distance.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::{
    model::{Model, padded},
    rising::{around_end, invert, rising_end},
};
use crate::camera::ViewDistortion;

/// The place at this distance from the middle, in the direction of `d`.
fn towards(d: DVec3, distance: f64) -> DVec2 {
    d.truncate().normalize_or_zero() * distance
}

/// The angle between a direction and the axis.
fn angle(d: DVec3) -> f64 {
    libm::atan2(d.truncate().length(), d.z)
}

/// The direction at this angle, seen towards `place`.
fn at_angle(place: DVec2, angle: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(angle);
    (place.normalize_or_zero() * sin).extend(cos)
}

/// A polynomial and its slope.
fn polynomial(coefficients: &[f64], x: f64) -> [f64; 2] {
    let terms = coefficients.iter().rev();
    terms.fold([0.0, 0.0], |[value, slope], c| [value * x + c, slope * x + value])
}

/// The model of Kannala and Brandt, up to the angle at which its pictures fold over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct KannalaBrandt {
    k: [f64; 4],
    /// In radians.
    end: f64,
}

impl KannalaBrandt {
    /// The distance of an angle from the middle and its slope.
    fn distance(&self, angle: f64) -> [f64; 2] {
        let [k1, k2, k3, k4] = self.k;
        polynomial(&[0.0, 1.0, 0.0, k1, 0.0, k2, 0.0, k3, 0.0, k4], angle)
    }
}

impl Model for KannalaBrandt {
    const COUNTS: &'static [usize] = &[4];
    const HAS_PLANE: bool = false;

    fn new(coefficients: &[f64]) -> Self {
        let k = padded(coefficients);
        let whole = Self { k, end: PI };
        Self {
            end: rising_end(PI, |angle| whole.distance(angle)[1] > 0.0),
            ..whole
        }
    }

    fn place(&self, d: DVec3) -> Option<DVec2> {
        let angle = angle(d);
        (angle <= self.end && d != DVec3::ZERO).then(|| towards(d, self.distance(angle)[0]))
    }

    fn direction(&self, place: DVec2) -> Option<DVec3> {
        let angle = invert(place.length(), self.end, |angle| self.distance(angle))?;
        Some(at_angle(place, angle))
    }

    fn middle_slope(&self) -> f64 {
        1.0
    }

    fn of_data_sets(&self) -> Option<ViewDistortion> {
        Some(ViewDistortion::OpenCvFisheye(self.k))
    }
}

/// A fisheye whose angle is a polynomial of the distance from the middle, as long as it rises.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FisheyePolynomial {
    c: [f64; 6],
    /// The distance up to which it rises, in focal lengths.
    end: f64,
}

impl FisheyePolynomial {
    /// In radians, and its slope.
    fn angle(&self, distance: f64) -> [f64; 2] {
        polynomial(&self.c, distance)
    }
}

impl Model for FisheyePolynomial {
    const COUNTS: &'static [usize] = &[2, 3, 4, 5, 6];
    const HAS_PLANE: bool = false;

    fn new(coefficients: &[f64]) -> Self {
        let c = padded(coefficients);
        let whole = Self { c, end: f64::INFINITY };
        let rises = |distance: f64| {
            let [angle, slope] = whole.angle(distance);
            slope > 0.0 && angle <= PI
        };
        Self {
            // Were it a straight line, it would end at this distance.
            end: rising_end(around_end(PI / c[1], rises), rises),
            ..whole
        }
    }

    fn flaw(&self) -> Option<&'static str> {
        (self.c[1] <= 0.0).then_some("the second coefficient is not above 0, so that no angle rises from the middle")
    }

    fn place(&self, d: DVec3) -> Option<DVec2> {
        let distance = invert(angle(d), self.end, |distance| self.angle(distance))?;
        (d != DVec3::ZERO).then(|| towards(d, distance))
    }

    fn direction(&self, place: DVec2) -> Option<DVec3> {
        let distance = place.length();
        let [angle, _] = self.angle(distance);
        (distance <= self.end && angle >= 0.0).then(|| at_angle(place, angle))
    }

    fn middle_slope(&self) -> f64 {
        self.c[1]
    }
}
