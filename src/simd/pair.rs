//! Vectors of floats that consist of two vectors of half the width.

use super::lanes::{Floats, Mask};

/// The lower and the upper half of a vector or of a mask.
#[derive(Clone, Copy)]
pub struct Pair<T>(pub T, pub T);

/// An array type and the array type of twice its length.
pub trait Double {
    type Twice: Copy;
    fn followed_by(self, next: Self) -> Self::Twice;
}

impl Double for [f32; 4] {
    type Twice = [f32; 8];

    #[inline(always)]
    fn followed_by(self, next: Self) -> [f32; 8] {
        let ([a, b, c, d], [e, f, g, h]) = (self, next);
        [a, b, c, d, e, f, g, h]
    }
}

impl Double for [f32; 8] {
    type Twice = [f32; 16];

    #[inline(always)]
    fn followed_by(self, next: Self) -> [f32; 16] {
        let ([a, b, c, d, e, f, g, h], [i, j, k, l, m, n, o, p]) = (self, next);
        [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p]
    }
}

/// Applies the same operation to both halves.
macro_rules! both {
    ({ $( $op:ident )* } { $( $test:ident )* }) => {
        $(
            #[inline(always)]
            fn $op(self, b: Self) -> Self {
                Self(self.0.$op(b.0), self.1.$op(b.1))
            }
        )*
        $(
            #[inline(always)]
            fn $test(self, b: Self) -> Self::Mask {
                Pair(self.0.$test(b.0), self.1.$test(b.1))
            }
        )*
    };
}

impl<F: Floats<Array: Double>> Floats for Pair<F> {
    type Mask = Pair<F::Mask>;
    type Array = <F::Array as Double>::Twice;

    both! { { add sub mul div min max with_sign_of } { le lt eq ne } }

    #[inline(always)]
    fn to_array(self) -> Self::Array {
        self.0.to_array().followed_by(self.1.to_array())
    }
    #[inline(always)]
    fn fill(self, x: f32) -> Self {
        Self(self.0.fill(x), self.1.fill(x))
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(self.0.mul_add(b.0, c.0), self.1.mul_add(b.1, c.1))
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        Self(self.0.mul_sub(b.0, c.0), self.1.mul_sub(b.1, c.1))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }
    #[inline(always)]
    fn select(self, mask: Self::Mask, b: Self) -> Self {
        Self(self.0.select(mask.0, b.0), self.1.select(mask.1, b.1))
    }
    #[inline(always)]
    fn reduce_min(self) -> f32 {
        self.0.min(self.1).reduce_min()
    }
    #[inline(always)]
    fn reduce_max(self) -> f32 {
        self.0.max(self.1).reduce_max()
    }
}

impl<M: Mask> Mask for Pair<M> {
    const LANES: u32 = 2 * M::LANES;

    #[inline(always)]
    fn and(self, b: Self) -> Self {
        Self(self.0.and(b.0), self.1.and(b.1))
    }
    #[inline(always)]
    fn or(self, b: Self) -> Self {
        Self(self.0.or(b.0), self.1.or(b.1))
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.bits_of_two(self.1)
    }
}
