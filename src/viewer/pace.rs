//! The resolution of the first picture of a new camera, so that it takes about the same time on every machine.

use std::time::Duration;

/// The time for the first picture.
const FIRST_PICTURE: Duration = Duration::from_millis(14);

/// The divisors of the resolution of first pictures.
const DIVISORS: [u32; 9] = [1, 2, 3, 4, 6, 8, 12, 16, 24];

/// The time that a sample takes, from the pictures so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pace {
    seconds_per_sample: Option<f64>,
}

impl Pace {
    /// The divisor of the resolution with which a picture of `pixels` pixels is ready in time.
    pub fn divisor(&self, pixels: usize) -> u32 {
        let Some(seconds) = self.seconds_per_sample else {
            return 8;
        };
        let affordable = FIRST_PICTURE.as_secs_f64() / seconds;
        let fits = |divisor: &&u32| pixels as f64 <= affordable * f64::from(**divisor * **divisor);
        *DIVISORS.iter().find(fits).unwrap_or(&DIVISORS[DIVISORS.len() - 1])
    }

    /// Learns from the time of a picture with this many samples.
    pub fn learn(&mut self, samples: u64, took: Duration) {
        let seconds = took.as_secs_f64() / samples.max(1) as f64;
        self.seconds_per_sample = Some(match self.seconds_per_sample {
            // A busy machine delays single pictures; the next few correct the estimate.
            Some(before) => before + 0.25 * (seconds - before),
            None => seconds,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_picture_is_as_fine_as_its_time_allows() {
        let mut pace = Pace::default();
        assert_eq!(pace.divisor(1), 8);
        pace.learn(1000, Duration::from_millis(1));
        // A microsecond a sample: 14,000 samples.
        assert_eq!([14_000, 14_001, 56_000, 120_000].map(|n| pace.divisor(n)), [1, 2, 2, 3]);
        assert_eq!(pace.divisor(1 << 30), 24);
        for _ in 0..40 {
            pace.learn(1000, Duration::from_millis(4));
        }
        assert_eq!(pace.divisor(14_000), 2);
    }
}
