//! Curves through keys: the interpolation of camera paths and tables of values.
//!
//! At a key a curve *is* the key's value, bit for bit. Between two keys the interpolation of the
//! earlier one says what happens ([`Interp`]); a smooth curve looks one key further on either side.

use glam::{DQuat, DVec3};

/// The interpolation of a curve from one key to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interp {
    /// Runs through all keys in a row that are smooth without a corner. Where smooth keys meet
    /// others, the curve ends as if there were no key beyond.
    #[default]
    Smooth,
    /// Goes straight and at an even rate.
    Linear,
    /// Stays until the next key and then jumps: a cut.
    Step,
}

/// A curve. Before its first key and after its last one it keeps their values.
#[derive(Clone, Debug, PartialEq)]
pub struct Track<T> {
    knots: Vec<Knot<T>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot<T> {
    time: f64,
    value: T,
    interp: Interp,
}

/// The stretch between two keys, with the keys before and after it that a smooth curve takes into
/// account.
pub struct Segment<T> {
    pub before: Option<(f64, T)>,
    pub from: (f64, T),
    pub to: (f64, T),
    pub after: Option<(f64, T)>,
}

/// A value that can move along a curve.
pub trait Channel: Copy {
    /// The value at `u` of the way.
    fn linear(from: Self, to: Self, u: f64) -> Self;

    /// The value at `time`, strictly between `from` and `to`.
    fn smooth(segment: &Segment<Self>, time: f64) -> Self;
}

impl<T: Channel> Track<T> {
    /// From keys in rising order of their times; those without a value are left out.
    pub fn new(keys: impl IntoIterator<Item = (f64, Option<T>, Interp)>) -> Self {
        let knots = keys
            .into_iter()
            .filter_map(|(time, value, interp)| value.map(|value| Knot { time, value, interp }));
        Self { knots: knots.collect() }
    }

    /// The times of its keys.
    pub fn times(&self) -> impl Iterator<Item = f64> {
        self.knots.iter().map(|knot| knot.time)
    }

    /// The value at `time`; `None` for a track without keys.
    pub fn at(&self, time: f64) -> Option<T> {
        let next = self.knots.partition_point(|k| k.time <= time);
        let Some(i) = next.checked_sub(1) else {
            return self.knots.first().map(|k| k.value);
        };
        let from = self.knots[i];
        let Some(to) = self.knots.get(next) else {
            return Some(from.value);
        };
        if from.time == time {
            return Some(from.value);
        }
        Some(match from.interp {
            Interp::Step => from.value,
            Interp::Linear => T::linear(from.value, to.value, (time - from.time) / (to.time - from.time)),
            Interp::Smooth => T::smooth(&self.segment(i), time),
        })
    }

    /// The stretch from knot `i`, which has a knot after it.
    fn segment(&self, i: usize) -> Segment<T> {
        let knot = |k: &Knot<T>| (k.time, k.value);
        let before = i.checked_sub(1).map(|k| &self.knots[k]);
        let after = self.knots.get(i + 2);
        Segment {
            before: before.filter(|k| k.interp == Interp::Smooth).map(knot),
            from: knot(&self.knots[i]),
            to: knot(&self.knots[i + 1]),
            after: after.filter(|_| self.knots[i + 1].interp == Interp::Smooth).map(knot),
        }
    }
}

impl<T: Copy> Segment<T> {
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> Segment<U> {
        let f = |(t, v)| (t, f(v));
        Segment {
            before: self.before.map(f),
            from: f(self.from),
            to: f(self.to),
            after: self.after.map(f),
        }
    }
}

/// The cubic Hermite polynomial at `u` of `[0, 1]`, by how far it goes and its slopes at both ends.
/// Computed as an offset from its start, so that rounding errors do not move a value at rest.
pub fn hermite_rise<V>(rise: V, slopes: [V; 2], u: f64) -> V
where
    V: std::ops::Mul<f64, Output = V> + std::ops::Add<Output = V> + std::ops::Sub<Output = V>,
{
    let w = 1.0 - u;
    let [start, end] = slopes;
    rise * (u * u * (3.0 - 2.0 * u)) + start * (u * w * w) - end * (u * u * w)
}

/// A number on a smooth curve that never leaves the range of the two keys around it, so that a
/// focal length stays positive.
///
/// Source: Fritsch and Butland, "A Method for Constructing Local Monotone Piecewise Cubic
/// Interpolants", SIAM J. Sci. Stat. Comput. 5(2), 1984, doi:10.1137/0905021, with the weights of
/// their equation (5) for uneven keys. At an end the slope is that of the stretch.
pub fn monotone(segment: &Segment<f64>, time: f64) -> f64 {
    let ((t1, v1), (t2, v2)) = (segment.from, segment.to);
    let h = t2 - t1;
    let secant = (v2 - v1) / h;
    // The slope at the key between two stretches, by their lengths and secants.
    let slope = |h_other: f64, other: f64| {
        if other * secant <= 0.0 {
            return 0.0;
        }
        let (w_other, w) = (2.0 * h + h_other, h + 2.0 * h_other);
        (w_other + w) / (w_other / other + w / secant)
    };
    let start = segment
        .before
        .map_or(secant, |(t0, v0)| slope(t1 - t0, (v1 - v0) / (t1 - t0)));
    let end = segment
        .after
        .map_or(secant, |(t3, v3)| slope(t3 - t2, (v3 - v2) / (t3 - t2)));
    let v = v1 + hermite_rise(v2 - v1, [start * h, end * h], (time - t1) / h);
    v.clamp(v1.min(v2), v1.max(v2))
}

/// A point on a centripetal Catmull-Rom spline through the keys, reached at the keys' own times.
///
/// The curve's shape: knots `s` that are apart by the square root of the keys' distance, `d = |b -
/// a|^(1/2)`; between `p1` and `p2` the cubic with the slopes `dp/ds` of Barry and Goldman, `(p1 -
/// p0) / d01 - (p2 - p0) / (d01 + d12) + (p2 - p1) / d12` at `p1` and likewise at `p2`. It has
/// neither cusps nor loops between two keys, and through keys on one line it stays between
/// neighbours: it never overshoots. How fast it is run through: `s` as the monotone cubic function
/// of the time that is `s` of each key at the key's time, however uneven the times are; so the
/// velocity has no jump, and a camera rests between two equal keys. Beyond an end, and beyond a
/// rest, the spline goes on as if mirrored: its slope there is that of the stretch.
///
/// Source: Barry and Goldman, "A Recursive Evaluation Algorithm for a Class of Catmull-Rom
/// Splines", SIGGRAPH 1988, doi:10.1145/54852.378511; Yuksel, Schaefer, Keyser, "Parameterization
/// and Applications of Catmull-Rom Curves", Computer-Aided Design 43(7), 2011,
/// doi:10.1016/j.cad.2010.08.008.
fn centripetal(segment: &Segment<DVec3>, time: f64) -> DVec3 {
    let (p1, p2) = (segment.from.1, segment.to.1);
    let d12 = p1.distance(p2).sqrt();
    if d12 == 0.0 {
        return p1;
    }
    let before = segment.before.map(|(t, p)| (t, p, p.distance(p1).sqrt()));
    let after = segment.after.map(|(t, p)| (t, p, p.distance(p2).sqrt()));
    let s = monotone(
        &Segment {
            before: before.map(|(t, _, d)| (t, -d)),
            from: (segment.from.0, 0.0),
            to: (segment.to.0, d12),
            after: after.map(|(t, _, d)| (t, d12 + d)),
        },
        time,
    );
    let secant = (p2 - p1) / d12;
    let start = before.filter(|(.., d)| *d > 0.0).map_or(secant, |(_, p0, d01)| {
        (p1 - p0) / d01 - (p2 - p0) / (d01 + d12) + secant
    });
    let end = after.filter(|(.., d)| *d > 0.0).map_or(secant, |(_, p3, d23)| {
        secant - (p3 - p1) / (d12 + d23) + (p3 - p2) / d23
    });
    p1 + hermite_rise(p2 - p1, [start * d12, end * d12], s / d12)
}

/// The rotation at `u` of the way along the shorter arc, at an even rate.
///
/// Source: Shoemake, "Animating Rotation with Quaternion Curves", SIGGRAPH 1985,
/// doi:10.1145/325334.325242.
pub fn slerp(from: DQuat, to: DQuat, u: f64) -> DQuat {
    let to = if from.dot(to) < 0.0 { -to } else { to };
    // Exact for small angles too, where the arc cosine is not.
    let angle = 2.0 * libm::atan2((to - from).length(), (to + from).length());
    let sin = libm::sin(angle);
    let mix = if sin < 1e-12 {
        from * (1.0 - u) + to * u
    } else {
        from * (libm::sin((1.0 - u) * angle) / sin) + to * (libm::sin(u * angle) / sin)
    };
    mix / mix.length()
}

impl Channel for f64 {
    fn linear(from: Self, to: Self, u: f64) -> Self {
        (from + (to - from) * u).clamp(from.min(to), from.max(to))
    }

    fn smooth(segment: &Segment<Self>, time: f64) -> Self {
        monotone(segment, time)
    }
}

impl Channel for DVec3 {
    fn linear(from: Self, to: Self, u: f64) -> Self {
        from + (to - from) * u
    }

    fn smooth(segment: &Segment<Self>, time: f64) -> Self {
        centripetal(segment, time)
    }
}

impl Channel for DQuat {
    fn linear(from: Self, to: Self, u: f64) -> Self {
        slerp(from / from.length(), to / to.length(), u)
    }

    fn smooth(segment: &Segment<Self>, time: f64) -> Self {
        let ((t1, from), (t2, to)) = (segment.from, segment.to);
        Self::linear(from, to, (time - t1) / (t2 - t1))
    }
}

#[cfg(test)]
mod tests;
