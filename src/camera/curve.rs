//! Curves of the quantities of a lens.

use super::lens::{Aperture, FieldOfView, Sensor, half_tan};
use crate::math::track::{Channel, Segment, monotone};

/// A quantity of the lens that moves as one number.
trait Amount: Copy {
    fn amount(self) -> f64;

    /// The same kind of quantity with another amount.
    fn with_amount(self, amount: f64) -> Self;
}

impl<T: Amount> Channel for T {
    fn linear(from: Self, to: Self, u: f64) -> Self {
        from.with_amount(f64::linear(from.amount(), to.amount(), u))
    }

    fn smooth(segment: &Segment<Self>, time: f64) -> Self {
        segment.from.1.with_amount(monotone(&segment.map(T::amount), time))
    }
}

/// Angles move as the focal lengths that they stand for, so that a zoom goes the same way however
/// it is written.
impl Amount for FieldOfView {
    fn amount(self) -> f64 {
        match self {
            Self::Vertical(degrees) | Self::Horizontal(degrees) => 1.0 / half_tan(degrees),
            Self::FocalLength(mm) => mm,
        }
    }

    fn with_amount(self, amount: f64) -> Self {
        let degrees = || 2.0 * libm::atan(1.0 / amount).to_degrees();
        match self {
            Self::Vertical(_) => Self::Vertical(degrees()),
            Self::Horizontal(_) => Self::Horizontal(degrees()),
            Self::FocalLength(_) => Self::FocalLength(amount),
        }
    }
}

impl Amount for Sensor {
    fn amount(self) -> f64 {
        match self {
            Self::Width(mm) | Self::Height(mm) | Self::LongSide(mm) => mm,
        }
    }

    fn with_amount(self, amount: f64) -> Self {
        match self {
            Self::Width(_) => Self::Width(amount),
            Self::Height(_) => Self::Height(amount),
            Self::LongSide(_) => Self::LongSide(amount),
        }
    }
}

impl Amount for Aperture {
    fn amount(self) -> f64 {
        match self {
            Self::Radius(v) | Self::FStop(v) => v,
        }
    }

    fn with_amount(self, amount: f64) -> Self {
        match self {
            Self::Radius(_) => Self::Radius(amount),
            Self::FStop(_) => Self::FStop(amount),
        }
    }
}

#[cfg(test)]
mod tests;
