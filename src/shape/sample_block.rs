//! Points of emitters as seen from many points at once: each lane has an emitter of a kind of its own.

use std::marker::PhantomData;

use super::{
    ball::Ball,
    rectangle::Rectangle,
    sampled::{SampledKind, SampledPoint},
};
use crate::math::{
    Dispatch, Vec2, Vec3, VectorLoop,
    block::{Each, LANES, get, set},
};

/// Emitters, each with the point that it is seen from and two uniform numbers; and a point on each.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct SampleBlock {
    from: [Each; 3],
    u: [Each; 2],
    rectangles: Columns<Rectangle, 14>,
    triangles: Columns<[Vec3; 3], 9>,
    balls: Columns<Ball, 4>,
    /// [`Parallelogram::plane_error`](super::Parallelogram::plane_error) of each lane's emitter.
    plane_errors: Each,
    points: Points,
}

/// The emitters of a kind.
#[derive(Clone, Debug)]
struct Columns<K, const N: usize> {
    numbers: [Each<f64>; N],
    /// Not 0 if the lane's emitter is of this kind.
    is_used: Each<u32>,
    kind: PhantomData<K>,
}

/// The points of all lanes.
#[derive(Clone, Debug)]
struct Points {
    /// The coordinates of the point, of its error and of the normal, and the density.
    numbers: [Each; 10],
    is_known: Each<u32>,
}

impl<K: SampledKind<N>, const N: usize> Columns<K, N> {
    const EMPTY: Self = Self {
        numbers: [[0.0; LANES]; N],
        is_used: [0; LANES],
        kind: PhantomData,
    };

    #[inline(always)]
    fn put(&mut self, lane: usize, emitter: &K) {
        for (to, number) in self.numbers.iter_mut().zip(&emitter.sample_numbers()) {
            to[lane] = *number;
        }
        self.is_used[lane] = 1;
    }

    #[inline(always)]
    fn sample(&self, on: impl Dispatch, observers: (&[Each; 3], &[Each; 2]), to: &mut Points) {
        if self.is_used != [0; LANES] {
            on.dispatch(Samples {
                columns: self,
                observers,
                to,
            });
        }
    }
}

impl SampleBlock {
    pub const EMPTY: Self = Self {
        from: [[0.0; LANES]; 3],
        u: [[0.0; LANES]; 2],
        rectangles: Columns::EMPTY,
        triangles: Columns::EMPTY,
        balls: Columns::EMPTY,
        plane_errors: [0.0; LANES],
        points: Points::EMPTY,
    };

    /// Sets the point from which the emitter of a lane is seen, and its uniform numbers in `[0, 1)`.
    #[inline(always)]
    pub fn set_observer(&mut self, lane: usize, from: Vec3, u: Vec2) {
        let lane = lane % LANES;
        set(&mut self.from, lane, from);
        (self.u[0][lane], self.u[1][lane]) = (u.x, u.y);
    }

    /// Removes the emitter of a lane.
    #[inline(always)]
    fn clear(&mut self, lane: usize) {
        self.rectangles.is_used[lane] = 0;
        self.triangles.is_used[lane] = 0;
        self.balls.is_used[lane] = 0;
        self.plane_errors[lane] = 0.0;
    }

    #[inline(always)]
    pub(super) fn set_rectangle(&mut self, lane: usize, rectangle: &Rectangle, plane_error: f32) {
        self.clear(lane % LANES);
        self.rectangles.put(lane % LANES, rectangle);
        self.plane_errors[lane % LANES] = plane_error;
    }

    #[inline(always)]
    pub(super) fn set_ball(&mut self, lane: usize, ball: &Ball) {
        self.clear(lane % LANES);
        self.balls.put(lane % LANES, ball);
    }

    #[inline(always)]
    pub fn set_triangle(&mut self, lane: usize, corners: &[Vec3; 3]) {
        self.clear(lane % LANES);
        self.triangles.put(lane % LANES, corners);
    }

    /// Chooses the points of all lanes.
    #[inline]
    pub fn sample(&mut self, on: impl Dispatch) {
        let Self { from, u, points, .. } = self;
        self.rectangles.sample(on, (from, u), points);
        self.triangles.sample(on, (from, u), points);
        self.balls.sample(on, (from, u), points);
    }

    #[inline(always)]
    pub fn from(&self, lane: usize) -> Vec3 {
        get(&self.from, lane)
    }

    /// Returns what the emitter of a lane samples.
    #[inline(always)]
    pub fn point(&self, lane: usize) -> SampledPoint {
        let Points { numbers, is_known } = &self.points;
        let vector = |k: usize| Vec3::new(numbers[k][lane], numbers[k + 1][lane], numbers[k + 2][lane]);
        SampledPoint {
            p: vector(0),
            p_error: vector(3) + self.plane_errors[lane],
            ng: vector(6),
            pdf: numbers[9][lane],
            is_known: is_known[lane] != 0,
        }
    }

    /// The lanes, as bits, whose points are known.
    #[inline(always)]
    pub fn known(&self) -> u32 {
        let is_known = &self.points.is_known;
        (0..LANES).map(|lane| u32::from(is_known[lane] != 0) << lane).sum()
    }
}

impl Points {
    const EMPTY: Self = Self {
        numbers: [[0.0; LANES]; 10],
        is_known: [0; LANES],
    };
}

/// Samples the emitters of a kind, as seen by the observers with their numbers.
struct Samples<'a, K, const N: usize> {
    columns: &'a Columns<K, N>,
    observers: (&'a [Each; 3], &'a [Each; 2]),
    to: &'a mut Points,
}

impl<K: SampledKind<N>, const N: usize> VectorLoop for Samples<'_, K, N> {
    #[inline(always)]
    fn run(self) {
        // Numbers are read from copies, and results go to local arrays, so that the compiler knows that they do not alias.
        let Columns { numbers, is_used, .. } = *self.columns;
        let (from, u) = (*self.observers.0, *self.observers.1);
        let Points {
            numbers: old,
            is_known: was_known,
        } = self.to.clone();
        let (mut points, mut is_known) = ([[0.0; LANES]; 10], [0; LANES]);
        for i in 0..LANES {
            let mut own = [0.0; N];
            for k in 0..N {
                own[k] = numbers[k][i];
            }
            let point = K::sample_by(&own, get(&from, i), Vec2::new(u[0][i], u[1][i]));
            let SampledPoint { p, p_error, ng, .. } = point;
            let row = [
                p.x, p.y, p.z, p_error.x, p_error.y, p_error.z, ng.x, ng.y, ng.z, point.pdf,
            ];
            let is_own = is_used[i] != 0;
            for k in 0..row.len() {
                points[k][i] = if is_own { row[k] } else { old[k][i] };
            }
            let known = u32::from(point.is_known);
            is_known[i] = if is_own { known } else { was_known[i] };
        }
        *self.to = Points {
            numbers: points,
            is_known,
        };
    }
}
