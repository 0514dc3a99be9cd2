//! The distribution of a lamp's intensity over directions, as a goniometer measures it.
//!
//! All types of photometry become one grid: angles from a pole, and angles about it. The intensity between the angles of the
//! file is bilinear. Where the file has no angles the lamp gives no light.
//!
//! Source: ANSI/IES LM-63-19, and the types A, B and C of IES LM-75.

use std::f64::consts::PI;

use super::LUMENS_PER_WATT;
use crate::math::{Vec3, trig};

/// An index into the scene's profiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProfileId(pub u32);

/// The type of the photometry: the axis about which the planes of the measurement turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Photometry {
    /// About the vertical axis of a lamp that hangs, which shines downwards.
    C,
    /// About the horizontal axis across a lamp that shines forwards.
    B,
    /// About the vertical axis of a lamp that shines forwards.
    A,
}

/// Measured intensities.
#[derive(Clone, Debug)]
pub struct Measurement {
    pub photometry: Photometry,
    /// In degrees, ascending, at least two. Type C: from 0 at the nadir to 180. Types A and B: from -90 to 90.
    pub vertical: Vec<f32>,
    /// In degrees, ascending, at least one, by the [`Symmetry`].
    pub horizontal: Vec<f32>,
    pub symmetry: Symmetry,
    /// In cd, finite and at least 0: for each horizontal angle those of all vertical angles.
    pub candela: Vec<f32>,
}

/// The horizontal angles that are not listed because they repeat others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// All angles are listed.
    None,
    /// One angle is listed; the intensities at all others are the same.
    Axial,
    /// Angles beyond the last are those before it, mirrored, up to the first one and 360 degrees.
    Mirrored,
    /// Angles go from 0 to 90, and the other three quadrants mirror them.
    Quadrants,
    /// The last angle lies before 360, where the first one follows.
    Closed,
    /// Types A and B: angles below 0 are as those above it.
    AboutZero,
}

/// The intensity of a lamp over directions. The lamp shines along +z in its own space, where +y is up and +x to the right as
/// seen along +z.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    photometry: Photometry,
    /// Degrees from the pole, ascending.
    polar: Vec<f32>,
    /// Degrees about the pole, ascending, over 360 at most.
    around: Vec<f32>,
    /// In W sr^-1: for each angle about the pole those of all angles from it.
    intensities: Vec<f32>,
    power: f32,
    front_power: f32,
    cone: ProfileCone,
}

/// A bound of the directions of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileCone {
    /// The largest intensity, in W sr^-1.
    pub max: f32,
    /// Whether the axis is opposite to the direction of the lamp.
    pub is_backward: bool,
    /// The angle to the axis, in radians, up to which the intensity may be the largest. Beyond it is at most
    /// that times the cosine of the rest.
    pub full: f32,
    /// The angle to the axis, in radians, beyond which there is no light.
    pub end: f32,
}

/// A list of angles with the index of a row of the measurement for each.
type Rows = Vec<(f32, usize)>;

impl Symmetry {
    /// All angles, each with the index of the listed angle whose intensities it has.
    fn complete(self, listed: &[f32]) -> Rows {
        let own = || listed.iter().copied().zip(0..listed.len());
        let mirrored = |about: f32| {
            let others = own().rev().map(move |(angle, row)| (2.0 * about - angle, row));
            others.filter(move |(angle, _)| *angle > about)
        };
        let last = listed.last().copied().unwrap_or(0.0);
        match self {
            Self::None => own().collect(),
            Self::Axial => vec![(0.0, 0), (360.0, 0)],
            Self::Mirrored => own().chain(mirrored(last)).collect(),
            Self::Quadrants => {
                let half: Rows = own().chain(mirrored(last)).collect();
                let rest = half.iter().rev().map(|(angle, row)| (360.0 - angle, *row)).skip(1);
                half.iter().copied().chain(rest).collect()
            }
            Self::Closed => own().chain([(listed[0] + 360.0, 0)]).collect(),
            Self::AboutZero => {
                let below = own().rev().map(|(angle, row)| (-angle, row));
                below.filter(|(angle, _)| *angle < 0.0).chain(own()).collect()
            }
        }
    }
}

impl Profile {
    pub fn new(measurement: &Measurement) -> Self {
        let Measurement {
            photometry,
            vertical,
            horizontal,
            symmetry,
            candela,
        } = measurement;
        let across = symmetry.complete(horizontal);
        let down = match photometry {
            Photometry::C => Symmetry::None.complete(vertical),
            _ if vertical[0] == 0.0 => Symmetry::AboutZero.complete(vertical),
            _ => Symmetry::None.complete(vertical),
        };
        let at = |row: usize, column: usize| candela[row * vertical.len() + column];
        // The pole of types A and B lies at 90 degrees.
        let from_pole = |rows: &Rows| -> Rows { rows.iter().rev().map(|(a, row)| (90.0 - a, *row)).collect() };
        let (polar, around, is_turned) = match photometry {
            Photometry::C => (down, across, false),
            Photometry::A => (from_pole(&down), across, false),
            Photometry::B => (from_pole(&across), down, true),
        };
        let value = |(_, around): &(f32, usize), (_, polar): &(f32, usize)| {
            let candela = if is_turned {
                at(*polar, *around)
            } else {
                at(*around, *polar)
            };
            (f64::from(candela) / f64::from(LUMENS_PER_WATT)) as f32
        };
        let rows = around.iter();
        let intensities = rows.flat_map(|a| polar.iter().map(move |p| value(a, p))).collect();
        let angles = |rows: &Rows| rows.iter().map(|(angle, _)| *angle).collect();
        let mut profile = Self {
            photometry: *photometry,
            polar: angles(&polar),
            around: angles(&around),
            intensities,
            power: 0.0,
            front_power: 0.0,
            cone: ProfileCone {
                max: 0.0,
                is_backward: false,
                full: 0.0,
                end: 0.0,
            },
        };
        profile.power = profile.power_up_to(180.0) as f32;
        profile.front_power = match photometry {
            Photometry::C => profile.power_up_to(90.0) as f32,
            Photometry::A | Photometry::B => profile.power,
        };
        profile.cone = profile.find_cone();
        profile
    }

    /// All the light, in W.
    pub fn power(&self) -> f32 {
        self.power
    }

    /// The light in the directions that are less than 90 degrees off that of the lamp, in W.
    pub fn front_power(&self) -> f32 {
        self.front_power
    }

    pub fn cone(&self) -> ProfileCone {
        self.cone
    }

    /// The intensity in the unit direction `w` of the lamp's own space, in W sr^-1.
    #[inline]
    pub fn intensity(&self, w: Vec3) -> f32 {
        let [pole, zero, quarter] = match self.photometry {
            Photometry::C => [w.z, w.y, -w.x],
            Photometry::A => [w.y, w.z, w.x],
            Photometry::B => [w.x, w.z, w.y],
        };
        let from_pole = trig::atan2((zero * zero + quarter * quarter).sqrt(), pole).to_degrees();
        let about = trig::atan2(quarter, zero).to_degrees();
        let first = self.around[0];
        let about = if about < first { about + 360.0 } else { about };
        // Rounding may lead out of a full circle.
        let about = about.clamp(first, first + 360.0);
        let (Some((row, down)), Some((column, across))) =
            (place(&self.around, about), place(&self.polar, from_pole.min(180.0)))
        else {
            return 0.0;
        };
        let at = row * self.polar.len() + column;
        let [near, far] = [at, at + self.polar.len()].map(|at| {
            let pair = &self.intensities[at..at + 2];
            pair[0] * (1.0 - across) + pair[1] * across
        });
        near * (1.0 - down) + far * down
    }

    /// The light up to an angle from the pole in degrees, in W: the integral of the interpolated intensities.
    fn power_up_to(&self, end: f64) -> f64 {
        let columns = self.polar.len();
        let row = |row: usize| {
            let values = &self.intensities[row * columns..(row + 1) * columns];
            let pairs = self.polar.windows(2).zip(values.windows(2));
            pairs
                .map(|(angles, values)| {
                    let [a, b] = [0, 1].map(|k| f64::from(angles[k]));
                    let [from, to] = [0, 1].map(|k| f64::from(values[k]));
                    let slope = (to - from) / (b - a).to_radians();
                    let b = b.min(end);
                    if b <= a {
                        return 0.0;
                    }
                    // The integral of (from + slope t) sin(a + t).
                    let [a, b] = [a, b].map(f64::to_radians);
                    let to = from + slope * (b - a);
                    from * libm::cos(a) - to * libm::cos(b) + slope * (libm::sin(b) - libm::sin(a))
                })
                .sum::<f64>()
        };
        let between = |k: usize| {
            let width = f64::from(self.around[k + 1] - self.around[k]).to_radians();
            (row(k) + row(k + 1)) * 0.5 * width
        };
        (0..self.around.len() - 1).map(between).sum()
    }

    fn find_cone(&self) -> ProfileCone {
        let max = self.intensities.iter().copied().fold(0.0, f32::max);
        let is_backward = self.photometry == Photometry::C && f64::from(self.front_power) < 0.5 * f64::from(self.power);
        // The angle of a corner of the grid to the axis. Those in between are closer to it than one of the corners around them.
        let from_axis = |around: f32, polar: f32| {
            let [around, polar] = [around, polar].map(|a| f64::from(a).to_radians());
            match self.photometry {
                Photometry::C if is_backward => PI - polar,
                Photometry::C => polar,
                Photometry::A | Photometry::B => libm::acos(libm::sin(polar) * libm::cos(around)),
            }
        };
        let columns = self.polar.len();
        let (mut full, mut end) = (0.0_f64, 0.0_f64);
        for (i, intensity) in self.intensities.iter().enumerate().filter(|(_, v)| **v > 0.0) {
            let (row, column) = (i / columns, i % columns);
            let rest = libm::acos((f64::from(*intensity) / f64::from(max)).min(1.0));
            full = full.max(from_axis(self.around[row], self.polar[column]) - rest);
            // The intensity falls to 0 at the next angles.
            for row in row.saturating_sub(1)..=(row + 1).min(self.around.len() - 1) {
                for column in column.saturating_sub(1)..=(column + 1).min(columns - 1) {
                    let angle = from_axis(self.around[row], self.polar[column]);
                    end = end.max(angle);
                    full = full.max(angle - PI * 0.5);
                }
            }
        }
        ProfileCone {
            max,
            is_backward,
            full: full as f32,
            end: end as f32,
        }
    }
}

/// The index of the last angle at or before `x`, at most that of the last but one, and the fraction of the
/// way to the next; `None` outside.
#[inline]
fn place(angles: &[f32], x: f32) -> Option<(usize, f32)> {
    let (first, last) = (angles[0], angles[angles.len() - 1]);
    if !(first..=last).contains(&x) {
        return None;
    }
    let i = angles.partition_point(|angle| *angle <= x).clamp(1, angles.len() - 1) - 1;
    Some((i, (x - angles[i]) / (angles[i + 1] - angles[i])))
}

#[cfg(test)]
mod tests;
