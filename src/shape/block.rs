//! Blocks of rays that are tested at once on vectors, each with a shape of its own; all are of one kind.

use std::marker::PhantomData;

use super::ShapeHit;
use crate::math::{
    DVec3, Dispatch, Ray, VectorLoop,
    block::{Each, LANES, get, set},
};

/// The largest number of numbers by which a shape is tested.
const MAX_NUMBERS: usize = 12;

/// The known facts about a ray and a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attempt {
    /// The hit, if the ray hits the shape.
    pub hit: ShapeHit,
    /// [`Attempt::MISSES`], [`Attempt::MEETS`] or [`Attempt::UNKNOWN`]; a number, for vectors of
    /// them.
    pub answer: u32,
}

impl Attempt {
    pub const MISSES: u32 = 0;
    pub const MEETS: u32 = 1;
    /// Only [`ShapeKind::intersect`](super::ShapeKind::intersect) can tell.
    pub const UNKNOWN: u32 = 2;

    /// The attempt at a ray that meets the shape or does not.
    #[inline(always)]
    pub(super) fn of(hit: ShapeHit, meets: bool) -> Self {
        let answer = if meets { Self::MEETS } else { Self::MISSES };
        Self { hit, answer }
    }
}

/// A kind of shape whose rays are tested in blocks.
pub(super) trait BlockKind<const N: usize> {
    /// Returns what [`BlockKind::attempt`] reads of a shape.
    fn numbers(&self) -> [f64; N];

    /// Attempts [`ShapeKind::intersect`](super::ShapeKind::intersect) of the shape with these numbers: the same operations
    /// for every ray, without branches.
    fn attempt(numbers: &[f64; N], ray: &Ray) -> Attempt;
}

/// Intersects a ray with a shape.
#[inline(always)]
pub(super) fn intersect_one<K: BlockKind<N>, const N: usize>(shape: &K, ray: &Ray) -> Option<ShapeHit> {
    let Attempt { hit, answer } = K::attempt(&shape.numbers(), ray);
    (answer == Attempt::MEETS).then_some(hit)
}

/// The methods of [`ShapeKind`](super::ShapeKind) for a [`BlockKind`].
macro_rules! intersected_in_blocks {
    () => {
        #[inline]
        fn intersect(&self, ray: &$crate::math::Ray) -> Option<$crate::shape::ShapeHit> {
            $crate::shape::block::intersect_one(self, ray)
        }

        fn block_numbers(&self) -> $crate::shape::Numbers {
            $crate::shape::block::numbers(self)
        }

        fn attempt_block(&self, on: impl $crate::math::Dispatch, block: &mut $crate::shape::RayBlock<'_>) {
            block.attempt::<Self, _>(on);
        }
    };
}
pub(super) use intersected_in_blocks;

/// The vector that begins at place `at` of a shape's numbers.
#[inline(always)]
pub(super) fn vector(numbers: &[f64], at: usize) -> DVec3 {
    DVec3::new(numbers[at], numbers[at + 1], numbers[at + 2])
}

/// The numbers of a shape of any kind; those that its kind does not have are 0.
pub type Numbers = [f64; MAX_NUMBERS];

/// Returns the numbers of a shape.
pub(super) fn numbers<const N: usize>(shape: &impl BlockKind<N>) -> Numbers {
    let mut all = [0.0; MAX_NUMBERS];
    all[..N].copy_from_slice(&shape.numbers());
    all
}

/// Rays in the local spaces of their shapes, the shapes, and the attempts.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct RayBlock<'a> {
    o: [Each; 3],
    d: [Each; 3],
    tmin: Each,
    shapes: [&'a Numbers; LANES],
    numbers: [Each<f64>; MAX_NUMBERS],
    pub t: Each,
    pub u: Each,
    pub v: Each,
    pub answer: Each<u32>,
}

impl<'a> RayBlock<'a> {
    pub const EMPTY: Self = Self {
        o: [[0.0; LANES]; 3],
        d: [[0.0; LANES]; 3],
        tmin: [0.0; LANES],
        shapes: [&[0.0; MAX_NUMBERS]; LANES],
        numbers: [[0.0; LANES]; MAX_NUMBERS],
        t: [0.0; LANES],
        u: [0.0; LANES],
        v: [0.0; LANES],
        answer: [Attempt::UNKNOWN; LANES],
    };

    /// Sets the ray and the shape of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, ray: &Ray, shape: &'a Numbers) {
        let lane = lane % LANES;
        set(&mut self.o, lane, ray.o);
        set(&mut self.d, lane, ray.d);
        self.tmin[lane] = ray.tmin;
        self.shapes[lane] = shape;
    }

    /// Attempts the intersections of all lanes; the shapes are of the kind `K`.
    #[inline(always)]
    pub(super) fn attempt<K: BlockKind<N>, const N: usize>(&mut self, on: impl Dispatch) {
        on.dispatch(Attempts {
            block: self,
            kind: PhantomData::<K>,
        });
    }
}

/// Attempts the intersections of a block.
struct Attempts<'a, 'b, K, const N: usize> {
    block: &'a mut RayBlock<'b>,
    kind: PhantomData<K>,
}

impl<K: BlockKind<N>, const N: usize> VectorLoop for Attempts<'_, '_, K, N> {
    #[inline(always)]
    fn run(self) {
        const { assert!(N <= MAX_NUMBERS) };
        // Closures are not always compiled with the instructions of their caller, so there are none.
        let block = self.block;
        let RayBlock {
            o,
            d,
            tmin,
            shapes,
            numbers,
            ..
        } = &mut *block;
        for (i, shape) in shapes.iter().enumerate() {
            for k in 0..N {
                numbers[k][i] = shape[k];
            }
        }
        // Results go to local arrays, so that the compiler knows that reads and writes do not alias.
        let (mut t, mut u, mut v) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let mut answers = [0; LANES];
        for i in 0..LANES {
            let ray = Ray {
                o: get(o, i),
                tmin: tmin[i],
                d: get(d, i),
                tmax: f32::INFINITY,
            };
            let mut shape = [0.0; N];
            for k in 0..N {
                shape[k] = numbers[k][i];
            }
            let Attempt { hit, answer } = K::attempt(&shape, &ray);
            (t[i], u[i], v[i], answers[i]) = (hit.t, hit.u, hit.v, answer);
        }
        (block.t, block.u, block.v, block.answer) = (t, u, v, answers);
    }
}
