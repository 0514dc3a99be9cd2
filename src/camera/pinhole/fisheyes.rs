//! Fisheyes whose distance from the middle is a polynomial of the angle, or whose angle is one of the distance.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::{
    model::{Model, between, padded},
    rising::{invert, rising_end},
};
use crate::camera::ViewDistortion;

/// Films of chunks and overscan reach beyond the corners of the picture by up to this factor.
const OVERSCAN: f64 = 4.0;

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

    fn ended(k: [f64; 4]) -> Self {
        let whole = Self { k, end: PI };
        Self {
            end: rising_end(PI, |angle| whole.distance(angle)[1] > 0.0),
            ..whole
        }
    }
}

impl Model for KannalaBrandt {
    const COUNTS: &'static [usize] = &[4];
    const HAS_PLANE: bool = false;

    fn new(coefficients: &[f64]) -> Self {
        Self::ended(padded(coefficients))
    }

    fn within(self, _reach: f64) -> Self {
        self
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

    fn between(&self, to: &Self, u: f64) -> Self {
        if self.k == to.k {
            return *self;
        }
        Self::ended(between(&self.k, &to.k, u))
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
        Self {
            c: padded(coefficients),
            end: 0.0,
        }
    }

    fn flaw(&self) -> Option<&'static str> {
        (self.c[1] <= 0.0).then_some("the second coefficient is not above 0, so that no angle rises from the middle")
    }

    fn within(self, reach: f64) -> Self {
        let rises = |distance: f64| {
            let [angle, slope] = self.angle(distance);
            slope > 0.0 && angle <= PI
        };
        Self {
            end: rising_end(OVERSCAN * reach, rises),
            ..self
        }
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

    fn between(&self, to: &Self, u: f64) -> Self {
        Self {
            c: between(&self.c, &to.c, u),
            end: self.end.min(to.end),
        }
    }
}
