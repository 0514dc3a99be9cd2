//! Keys of numbers over time, with the three interpolations of glTF.
//!
//! At a key the numbers are those of the key. Before the first key and after the last one they keep its numbers.
//!
//! Source: Khronos, "glTF 2.0 Specification", appendix C.

use std::sync::Arc;

use glam::DQuat;

use super::track::{hermite_rise, slerp};

/// The numbers between two keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyInterp {
    /// Those of the earlier key.
    Step,
    /// On a straight line; rotations on the shorter arc.
    Linear,
    /// On the cubic Hermite polynomial whose slopes the keys give.
    CubicSpline,
}

/// Why keys cannot be read. Keys count from 0.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KeysError {
    #[error("it has no keys")]
    Empty,
    #[error("the time of key {0} is not finite")]
    TimeNotFinite(usize),
    #[error("the time of key {0} is before that of the key before it")]
    NotRising(usize),
    #[error("key {0} has a number that is not finite")]
    NotFinite(usize),
    #[error("it has {found} numbers instead of {expected}")]
    WrongLength { found: usize, expected: usize },
}

/// Numbers over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Keys {
    /// Rising, in s. Of equal ones the last counts.
    times: Arc<[f32]>,
    /// The numbers of the keys, `width` for each; with [`KeyInterp::CubicSpline`] the slope before it, the
    /// numbers, and the slope after it.
    numbers: Vec<f32>,
    width: usize,
    interp: KeyInterp,
}

/// The place of a time among keys.
enum Place {
    /// The numbers of this key.
    At(usize),
    /// This part of the way to the next key.
    After(usize, f64),
}

impl Keys {
    /// Makes keys of `width` numbers each.
    pub fn new(times: Arc<[f32]>, numbers: Vec<f32>, width: usize, interp: KeyInterp) -> Result<Self, KeysError> {
        let stored = if interp == KeyInterp::CubicSpline {
            3 * width
        } else {
            width
        };
        let expected = times.len().saturating_mul(stored);
        if times.is_empty() {
            return Err(KeysError::Empty);
        }
        if let Some(key) = times.iter().position(|t| !t.is_finite()) {
            return Err(KeysError::TimeNotFinite(key));
        }
        if let Some(key) = times.windows(2).position(|t| t[1] < t[0]) {
            return Err(KeysError::NotRising(key + 1));
        }
        if numbers.len() != expected {
            let found = numbers.len();
            return Err(KeysError::WrongLength { found, expected });
        }
        if let Some(at) = numbers.iter().position(|v| !v.is_finite()) {
            return Err(KeysError::NotFinite(at / stored));
        }
        Ok(Self {
            times,
            numbers,
            width,
            interp,
        })
    }

    /// The time of the last key, in s.
    pub fn end(&self) -> f32 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// The bytes of its arrays.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.times[..]) + size_of_val(&self.numbers[..])) as u64
    }

    fn place(&self, time: f32) -> Place {
        let next = self.times.partition_point(|t| *t <= time);
        let Some(key) = next.checked_sub(1) else {
            return Place::At(0);
        };
        let from = self.times[key];
        match self.times.get(next) {
            Some(&to) if from < time && self.interp != KeyInterp::Step => {
                let [from, to, time] = [from, to, time].map(f64::from);
                Place::After(key, (time - from) / (to - from))
            }
            _ => Place::At(key),
        }
    }

    /// One of the three parts of a key's numbers: 0 for the slope before it, 1 for its own numbers, 2 for the slope after it.
    fn part(&self, key: usize, part: usize) -> &[f32] {
        let first = match self.interp {
            KeyInterp::CubicSpline => (3 * key + part) * self.width,
            KeyInterp::Step | KeyInterp::Linear => key * self.width,
        };
        &self.numbers[first..first + self.width]
    }

    /// The numbers of a key.
    pub fn of_key(&self, key: usize) -> &[f32] {
        self.part(key, 1)
    }

    /// The number of keys.
    pub fn count(&self) -> usize {
        self.times.len()
    }

    /// Whether the numbers between two keys may lie beyond those of both.
    pub fn overshoots(&self) -> bool {
        self.interp == KeyInterp::CubicSpline
    }

    /// The number with this index at `time`.
    fn number(&self, place: &Place, index: usize) -> f64 {
        let of = |key: usize, part: usize| f64::from(self.part(key, part)[index]);
        match *place {
            Place::At(key) => of(key, 1),
            Place::After(key, u) => {
                let (from, to) = (of(key, 1), of(key + 1, 1));
                from + match self.interp {
                    KeyInterp::CubicSpline => {
                        let [start, end] = self.times[key..][..2] else {
                            unreachable!("a key follows")
                        };
                        let length = f64::from(end) - f64::from(start);
                        hermite_rise(to - from, [of(key, 2) * length, of(key + 1, 0) * length], u)
                    }
                    KeyInterp::Step | KeyInterp::Linear => (to - from) * u,
                }
            }
        }
    }

    /// The numbers at `time`.
    pub fn at(&self, time: f32) -> impl Iterator<Item = f64> + '_ {
        let place = self.place(time);
        (0..self.width).map(move |index| self.number(&place, index))
    }

    /// The first `N` numbers at `time`, which every key has.
    pub fn array<const N: usize>(&self, time: f32) -> [f64; N] {
        let place = self.place(time);
        std::array::from_fn(|index| self.number(&place, index))
    }

    /// The rotation at `time`, of keys of four numbers: those of a quaternion, which need not be unit.
    pub fn rotation(&self, time: f32) -> DQuat {
        let of = |key: usize| unit(self.part(key, 1));
        match self.place(time) {
            Place::At(key) => of(key),
            Place::After(key, u) if self.interp == KeyInterp::Linear => slerp(of(key), of(key + 1), u),
            Place::After(key, u) => {
                let length = f64::from(self.times[key + 1]) - f64::from(self.times[key]);
                let slope = |key: usize, part: usize| quaternion(self.part(key, part)) * length;
                let (from, to) = (of(key), of(key + 1));
                let rise = hermite_rise(to - from, [slope(key, 2), slope(key + 1, 0)], u);
                normalized(from + rise)
            }
        }
    }
}

fn quaternion(numbers: &[f32]) -> DQuat {
    DQuat::from_array(std::array::from_fn(|i| f64::from(numbers[i])))
}

fn unit(numbers: &[f32]) -> DQuat {
    normalized(quaternion(numbers))
}

/// The rotation of a quaternion that need not be unit; none where it has no axis.
pub fn normalized(q: DQuat) -> DQuat {
    let length = q.length();
    if length > 0.0 && length.is_finite() {
        q / length
    } else {
        DQuat::IDENTITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(times: &[f32], numbers: &[f32], width: usize, interp: KeyInterp) -> Keys {
        Keys::new(times.into(), numbers.to_vec(), width, interp).expect("keys")
    }

    #[test]
    fn numbers_are_held_outside_and_are_the_keys_at_the_keys() {
        for interp in [KeyInterp::Step, KeyInterp::Linear] {
            let k = keys(&[1.0, 2.0, 4.0], &[3.0, 5.0, -1.0], 1, interp);
            let at = |time| k.array::<1>(time)[0];
            assert_eq!([0.0, 1.0, 2.0, 4.0, 9.0].map(at), [3.0, 3.0, 5.0, -1.0, -1.0]);
            assert_eq!(at(3.0), if interp == KeyInterp::Step { 5.0 } else { 2.0 });
        }
    }

    #[test]
    fn a_spline_is_the_cubic_that_its_keys_are_on() {
        // t^3 - t at 1 and 3, with its slopes 3 t^2 - 1.
        let k = keys(
            &[1.0, 3.0],
            &[9.0, 0.0, 2.0, 26.0, 24.0, 9.0],
            1,
            KeyInterp::CubicSpline,
        );
        for time in [1.0, 1.5, 2.0, 2.875, 3.0, 7.0] {
            let t = f64::from(time).clamp(1.0, 3.0);
            assert!((k.array::<1>(time)[0] - (t * t * t - t)).abs() < 1e-13, "{time}");
        }
    }

    #[test]
    fn rotations_are_unit_as_read_and_between_keys() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        // A quarter turn about y in keys of length 2 and 3, the second of the opposite sign.
        let turned = |interp| {
            let q = [0.0, 0.0, 0.0, 2.0, 0.0, -3.0 * half as f32, 0.0, -3.0 * half as f32];
            keys(&[0.0, 1.0], &q, 4, interp)
        };
        let linear = turned(KeyInterp::Linear);
        for (time, degrees) in [(0.0, 0.0), (0.25, 22.5), (0.5, 45.0), (1.0, 90.0_f64)] {
            let (sin, cos) = libm::sincos(degrees.to_radians() * 0.5);
            let q = linear.rotation(time);
            assert!((q.y.abs() - sin).abs() < 1e-7 && (q.w.abs() - cos).abs() < 1e-7, "{q}");
            assert!((q.length() - 1.0).abs() < 1e-15);
        }
        let flat = [0.0_f32; 4];
        let [a, b] = [[0.0, 0.0, 0.0, 2.0], [0.0, 0.5, 0.0, 0.5_f32]];
        let cubic = keys(
            &[0.0, 1.0],
            &[flat, a, flat, flat, b, flat].concat(),
            4,
            KeyInterp::CubicSpline,
        );
        assert!((cubic.rotation(0.3).length() - 1.0).abs() < 1e-15);
        // The mean of both, normalised.
        let q = cubic.rotation(0.5);
        assert!((libm::atan2(q.y, q.w).to_degrees() * 2.0 - 45.0).abs() < 1e-6, "{q}");
        assert_eq!(
            keys(&[0.0], &[0.0; 4], 4, KeyInterp::Linear).rotation(0.0),
            DQuat::IDENTITY
        );
    }

    #[test]
    fn faults_of_keys_are_said_with_their_number() {
        let fault = |times: &[f32], numbers: &[f32]| {
            let keys = Keys::new(times.into(), numbers.to_vec(), 1, KeyInterp::Linear);
            keys.expect_err("a fault").to_string()
        };
        assert_eq!(fault(&[], &[]), "it has no keys");
        assert_eq!(fault(&[0.0, f32::NAN], &[0.0; 2]), "the time of key 1 is not finite");
        assert_eq!(
            fault(&[0.0, 2.0, 1.0], &[0.0; 3]),
            "the time of key 2 is before that of the key before it"
        );
        assert_eq!(fault(&[0.0, 1.0], &[0.0; 3]), "it has 3 numbers instead of 2");
        assert_eq!(
            fault(&[0.0, 1.0], &[0.0, f32::INFINITY]),
            "key 1 has a number that is not finite"
        );
        assert_eq!(
            keys(&[1.0, 1.0], &[3.0, 4.0], 1, KeyInterp::Linear).array::<1>(1.0),
            [4.0]
        );
    }
}
