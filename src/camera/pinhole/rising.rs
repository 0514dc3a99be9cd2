//! Functions of a radius up to the place where they stop rising, and their inverses.

/// The steps in which the end of the rising part is sought.
const STEPS: u32 = 4096;

/// The most steps of an inversion: those of a bisection to the last bit.
const MAX_STEPS: u32 = 64;

/// A number at which `rises` no longer holds, while it holds at half of it, found from a guess by doubling and halving; 0 if it
/// holds nowhere. It must not hold at infinity.
pub(super) fn around_end(guess: f64, rises: impl Fn(f64) -> bool) -> f64 {
    let mut end = guess.clamp(f64::MIN_POSITIVE, f64::MAX);
    while rises(end) {
        end *= 2.0;
    }
    while end > 0.0 && !rises(0.5 * end) {
        end *= 0.5;
    }
    end
}

/// The largest number up to `end` below which `rises` holds from 0 on, within a step of 1/4096 of `end`: a shorter fall may be
/// missed.
pub(super) fn rising_end(end: f64, rises: impl Fn(f64) -> bool) -> f64 {
    let step = end / f64::from(STEPS);
    let Some(first) = (0..=STEPS).find(|i| !rises(f64::from(*i) * step)) else {
        return end;
    };
    let (mut low, mut high) = (f64::from(first.saturating_sub(1)) * step, f64::from(first) * step);
    for _ in 0..MAX_STEPS {
        let middle = 0.5 * (low + high);
        if rises(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The argument up to `end` at which `f`, which rises there and returns its value and its slope, has this value; `None` if none
/// has. Newton's method inside of a bracket.
pub(super) fn invert(value: f64, end: f64, f: impl Fn(f64) -> [f64; 2]) -> Option<f64> {
    let (mut low, mut high) = (0.0, end);
    let in_range = f(low)[0] <= value && value <= f(high)[0];
    if !in_range {
        return None;
    }
    let mut x = value.clamp(low, high);
    for _ in 0..MAX_STEPS {
        let [at, slope] = f(x);
        if at < value {
            low = x;
        } else {
            high = x;
        }
        let newton = x + (value - at) / slope;
        let next = if newton >= low && newton <= high {
            newton
        } else {
            0.5 * (low + high)
        };
        if next == x || (next - x).abs() <= 4.0 * f64::EPSILON * end {
            return Some(next);
        }
        x = next;
    }
    Some(x)
}
