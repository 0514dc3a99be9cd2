//! The moments of a shutter: the times at which the samples of a moving scene are taken.
//!
//! A frame of a moving scene is rendered moment by moment. The scene is sought once for each of them, and then holds still while
//! the samples of that moment are traced. So rays need no time, boxes do not grow, and reflections, shadows, lights, deformed
//! meshes and the camera are all at the same moment.
//!
//! A sample's moment is a function of its address. A run of samples of a pixel has one in each stratum of the shutter, and so has
//! each of its aligned parts of a power of two. Where a pixel has fewer samples than there are moments, the moments of a
//! stratum are dealt out to the pixels of a square, so that neighbours take different ones: `2^m` by `2^m` pixels with `n` samples
//! each take `4^m n` different moments, as long as there are so many.

use super::{Content, Settings, scene_time::SceneTime, schedule::WAVE_SIZE};
use crate::{
    camera::{FilmSize, FrameCamera, Timing},
    film::{TileAccumulator, Window},
    math::hash::mix32,
    sampler::SampleKeys,
};

/// The logarithms of the least and of the most moments of a shutter.
const BITS: [u32; 2] = [6, 8];

/// The side of the squares of pixels that samples are listed by, so that neighbouring rays are traced together.
const SQUARE: i32 = 8;

/// The moments of a frame's shutter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moments {
    /// The logarithm of their number.
    bits: u32,
    /// The logarithm of the samples of a run, at most `bits`.
    run_bits: u32,
    seed: u32,
    /// The lines of a rolling shutter.
    lines: Option<Lines>,
}

/// The lines of a sensor that are exposed one after the other.
#[derive(Clone, Copy, Debug)]
struct Lines {
    timing: Timing,
    film: FilmSize,
}

/// One of the moments of a shutter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    all: Moments,
    index: u32,
}

/// Samples of the pixels of several tiles, of which a wave takes those of a moment.
pub(super) struct Sweep<'a> {
    /// The tiles with their accumulators.
    pub tiles: Vec<(Window, &'a mut TileAccumulator)>,
    /// The first sample, and the end.
    pub samples: [u32; 2],
    pub moment: Moment,
}

impl Moments {
    /// At least 64, and as many as the samples of a pixel up to 256; with a rolling shutter 256 for all lines together.
    pub fn new(settings: &Settings, camera: &FrameCamera) -> Self {
        let mut timing = camera.timing();
        if settings.content == Content::FirstHits {
            timing.shutter.close = timing.shutter.open;
        }
        let lines = Lines {
            timing,
            film: settings.resolution,
        };
        let run = settings.samples.max.clamp(1, 1 << BITS[1]).next_power_of_two();
        let run_bits = run.trailing_zeros();
        Self {
            bits: run_bits.max(BITS[0]),
            run_bits,
            seed: mix32(settings.seed) ^ (settings.noise_frame as u32).wrapping_mul(0x9e37_79b9),
            lines: (!timing.readout.is_global()).then_some(lines),
        }
    }

    pub fn count(self) -> u32 {
        match self.lines {
            Some(_) => 1 << BITS[1],
            None => 1 << self.bits,
        }
    }

    /// The least number of moments that the samples of a pixel are spread over.
    pub fn of_pixel(self) -> u32 {
        let share = |lines: Lines| lines.timing.exposure() / lines.timing.duration();
        let count = self.lines.map_or(1.0, share) * f64::from(self.count());
        (count as u32).max(1)
    }

    pub fn get(self, index: u32) -> Moment {
        Moment { all: self, index }
    }
}

/// The times of the shutter at which a scene that moves is sought.
pub fn moment_times(settings: &Settings, camera: &FrameCamera) -> impl Iterator<Item = SceneTime> + use<> {
    let moments = Moments::new(settings, camera);
    (0..moments.count()).map(move |index| moments.get(index).time())
}

impl Moment {
    /// Its number, from 0.
    pub fn index(self) -> u32 {
        self.index
    }

    /// Its time as a fraction of the shutter, in the middle of its part.
    pub fn fraction(self) -> f64 {
        (f64::from(self.index) + 0.5) / f64::from(self.all.count())
    }

    pub fn time(self) -> SceneTime {
        SceneTime::Shutter(self.fraction())
    }

    /// The number of tiles of this area whose samples of the moment make a wave, if they get so many samples.
    pub fn tiles_of_wave(self, area: usize, samples: usize) -> usize {
        WAVE_SIZE * self.all.of_pixel() as usize / (area * samples).max(1)
    }

    /// Appends those of the samples `first..end` of the pixels of `tile` that belong to the moment.
    pub fn list(self, tile: Window, samples: [u32; 2], keys: &mut SampleKeys) {
        let Some(lines) = self.all.lines else {
            return self.list_exposed(tile, samples, keys);
        };
        let exposed = Moments {
            lines: None,
            ..self.all
        };
        let index_at = |part: u32, line: Window| {
            let read = lines
                .timing
                .readout
                .fraction([line.x0, line.y0].map(|at| f64::from(at) + 0.5), lines.film);
            let time = lines.timing.fraction(exposed.get(part).fraction(), read);
            ((time * f64::from(self.all.count())) as u32).min(self.all.count() - 1)
        };
        for line in lines.of(tile) {
            let last = exposed.count() - 1;
            if index_at(0, line) > self.index || index_at(last, line) < self.index {
                continue;
            }
            for part in (0..=last).filter(|part| index_at(*part, line) == self.index) {
                exposed.get(part).list_exposed(line, samples, keys);
            }
        }
    }

    /// Appends those of the samples that belong to the moment of the exposure.
    fn list_exposed(self, tile: Window, [first, end]: [u32; 2], keys: &mut SampleKeys) {
        let Moments { run_bits, seed, .. } = self.all;
        let (choice, stratum) = (PlaceInStratum::new(self), self.stratum());
        for square in squares(tile) {
            for [x, y] in choice.of_square(square) {
                if !(tile.x0..tile.x1).contains(&x) || !(tile.y0..tile.y1).contains(&y) {
                    continue;
                }
                let (x, y) = (x as u32, y as u32);
                for run in first >> run_bits..=(end - 1) >> run_bits {
                    // Its lowest bits are the highest of the stratum.
                    let order = hash(mix32(seed ^ (1 << 31 | run)), [x, y]) ^ stratum;
                    let in_run = order.reverse_bits().checked_shr(32 - run_bits).unwrap_or(0);
                    let sample = run << run_bits | in_run;
                    if (first..end).contains(&sample) {
                        keys.columns.push(x);
                        keys.rows.push(y);
                        keys.samples.push(sample);
                    }
                }
            }
        }
    }

    /// The part of the shutter in which every run of a pixel has one sample.
    fn stratum(self) -> u32 {
        self.index >> (self.all.bits - self.all.run_bits)
    }
}

impl Lines {
    /// The lines of a tile.
    fn of(self, tile: Window) -> impl Iterator<Item = Window> {
        let reads_columns = self.timing.readout.direction.reads_columns();
        let range = if reads_columns {
            tile.x0..tile.x1
        } else {
            tile.y0..tile.y1
        };
        range.map(move |at| match reads_columns {
            true => Window::new(at, tile.y0, at + 1, tile.y1),
            false => Window::new(tile.x0, at, tile.x1, at + 1),
        })
    }
}

/// The choice of the pixels that take a moment in its stratum: two bits of its place there are the place of a pixel in a square
/// of two by two, two more that of the square in a larger one, and so on.
struct PlaceInStratum {
    levels: [Level; BITS[0].div_ceil(2) as usize],
    count: usize,
}

/// The squares of a level, the wanted place in them, its bits, and the seed of their random numbers.
#[derive(Clone, Copy, Default)]
struct Level {
    place: u32,
    bits: u32,
    seed: u32,
}

impl PlaceInStratum {
    fn new(moment: Moment) -> Self {
        let mut left = moment.all.bits - moment.all.run_bits;
        let (mut levels, mut count) = ([Level::default(); _], 0);
        while left > 0 {
            let bits = left.min(2);
            left -= bits;
            levels[count] = Level {
                place: moment.index >> left & ((1 << bits) - 1),
                bits,
                seed: mix32(moment.all.seed ^ (1 + ((count as u32) << 16 | moment.stratum()))),
            };
            count += 1;
        }
        Self { levels, count }
    }

    /// The pixels of a square of two by two that take the moment.
    #[inline(always)]
    fn of_square(&self, [x, y]: [i32; 2]) -> impl Iterator<Item = [i32; 2]> {
        let levels = &self.levels[..self.count];
        let is_chosen = (0..).zip(levels).skip(1).all(|(level, own)| {
            let at = [x as u32 >> level, y as u32 >> level];
            own.chosen(at) >> ((at[1] & 1) << 1 | at[0] & 1) & 1 == 1
        });
        let chosen = match levels.first() {
            _ if !is_chosen => 0,
            None => 0b1111,
            Some(own) => own.chosen([x as u32, y as u32]),
        };
        let places = [[0, 0], [1, 0], [0, 1], [1, 1]].into_iter().enumerate();
        places.filter_map(move |(k, [right, down])| (chosen >> k & 1 == 1).then_some([x + right, y + down]))
    }
}

impl Level {
    /// The places in the square of two by two around `at` that are chosen: bit 0 for the first, bit 1 for that to its right, bit 2
    /// for that below.
    #[inline(always)]
    fn chosen(&self, [x, y]: [u32; 2]) -> u32 {
        let random = hash(self.seed, [x >> 1, y >> 1]);
        let place = self.place ^ random;
        if self.bits == 1 {
            return if place & 1 == 0 { 0b1001 } else { 0b0110 };
        }
        // Each row and each column of two has one of both halves of the places.
        let (own, other) = (place & 1, place & 1 ^ place >> 1 & 1);
        let [right, down] = if random & 4 == 0 { [other, own] } else { [own, other] };
        1 << (down << 1 | right)
    }
}

/// A random number of a pixel or of a square of them.
#[inline(always)]
fn hash(seed: u32, [x, y]: [u32; 2]) -> u32 {
    mix32(seed ^ x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77))
}

/// The squares of two by two pixels that a tile has a part of, by larger squares.
fn squares(tile: Window) -> impl Iterator<Item = [i32; 2]> {
    let step = |from: i32, to: i32, by: i32| (from & !(by - 1)..to).step_by(by as usize);
    step(tile.y0, tile.y1, SQUARE).flat_map(move |top| {
        step(tile.x0, tile.x1, SQUARE).flat_map(move |left| {
            let row = move |y: i32| step(left, tile.x1.min(left + SQUARE), 2).map(move |x| [x, y]);
            step(top, tile.y1.min(top + SQUARE), 2).flat_map(row)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Lens, LookAt, Pose, Readout, ReadoutDirection, Shutter};

    /// A camera whose shutter is open for `exposure` frames.
    fn camera(exposure: f64, readout: Readout) -> FrameCamera {
        let pose = Pose::look_at(glam::DVec3::Z, &LookAt::new(glam::DVec3::ZERO)).expect("a pose");
        let shutter = Shutter {
            open: 0.0,
            close: exposure,
        };
        FrameCamera::from(Camera::new(&pose, &Lens::default(), [64, 64])).with_timing(Timing { shutter, readout })
    }

    fn still() -> FrameCamera {
        camera(1.0, Readout::default())
    }

    #[test]
    fn every_sample_of_a_rolling_shutter_has_the_moment_of_its_line() {
        use ReadoutDirection::*;
        for direction in [TopToBottom, BottomToTop, LeftToRight, RightToLeft] {
            for (exposure, samples) in [(0.0, 4), (0.25, 16), (1.0, 3)] {
                let readout = Readout { time: 0.75, direction };
                let settings = Settings::new([64, 64], samples);
                let moments = Moments::new(&settings, &camera(exposure, readout));
                let tile = Window::new(3, 5, 29, 41);
                let mut seen = Vec::new();
                for moment in (0..moments.count()).map(|index| moments.get(index)) {
                    let mut keys = SampleKeys::default();
                    moment.list(tile, [0, samples], &mut keys);
                    for i in 0..keys.len() {
                        let (x, y) = (keys.columns[i], keys.rows[i]);
                        let line = match direction {
                            TopToBottom => y,
                            BottomToTop => 63 - y,
                            LeftToRight => x,
                            RightToLeft => 63 - x,
                        };
                        // From when its line is exposed until it is not.
                        let from = 0.75 * (f64::from(line) + 0.5) / 64.0;
                        let time = moment.fraction() * (exposure + 0.75);
                        let part = 0.5 * (exposure + 0.75) / f64::from(moments.count());
                        assert!(time > from - part - 1e-9 && time < from + exposure + part + 1e-9);
                        seen.push((x, y, keys.samples[i]));
                    }
                }
                let count = seen.len();
                seen.sort_unstable();
                seen.dedup();
                assert_eq!(
                    (count, seen.len()),
                    (tile.area() * samples as usize, count),
                    "{direction:?} {exposure}"
                );
            }
        }
    }

    /// For each moment, the samples of the pixels of `tile` that belong to it.
    fn by_moment(samples: u32, tile: Window, range: [u32; 2]) -> Vec<SampleKeys> {
        let moments = Moments::new(&Settings::new([64, 64], samples), &still());
        let of = |index| {
            let mut keys = SampleKeys::default();
            moments.get(index).list(tile, range, &mut keys);
            keys
        };
        (0..moments.count()).map(of).collect()
    }

    fn of_pixel(all: &[SampleKeys], [x, y]: [u32; 2]) -> Vec<(usize, u32)> {
        let mut found = Vec::new();
        for (moment, keys) in all.iter().enumerate() {
            let own = (0..keys.len()).filter(|i| [keys.columns[*i], keys.rows[*i]] == [x, y]);
            found.extend(own.map(|i| (moment, keys.samples[i])));
        }
        found
    }

    #[test]
    fn every_sample_of_every_pixel_has_one_moment_in_every_window_and_range() {
        for samples in [1, 3, 16, 20, 64, 100, 256, 700] {
            let whole = by_moment(samples, Window::full([11, 9]), [0, samples]);
            let mut all: Vec<_> = whole
                .iter()
                .flat_map(|keys| (0..keys.len()).map(|i| (keys.columns[i], keys.rows[i], keys.samples[i])))
                .collect();
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len(), 99 * samples as usize, "{samples}");
            assert_eq!(whole.iter().map(SampleKeys::len).sum::<usize>(), all.len());
            // A crop and a part of the samples are the same choice.
            let part = by_moment(samples, Window::new(3, 2, 8, 9), [samples / 3, samples]);
            let own = |pixel| {
                let mut own = of_pixel(&whole, pixel);
                own.retain(|(_, sample)| *sample >= samples / 3);
                own
            };
            assert_eq!(of_pixel(&part, [5, 7]), own([5, 7]), "{samples}");
        }
    }

    #[test]
    fn the_samples_of_a_pixel_and_their_halves_are_one_in_each_stratum() {
        let all = by_moment(16, Window::full([8, 8]), [0, 16]);
        for pixel in [[0, 0], [3, 5], [7, 7]] {
            for (first, end) in [(0, 16), (0, 8), (8, 16), (4, 8)] {
                let own = of_pixel(&all, pixel);
                let own = own.iter().filter(|(_, sample)| (first..end).contains(sample));
                let mut strata: Vec<_> = own.map(|(moment, _)| *moment as u32 * (end - first) / 64).collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..end - first).collect::<Vec<_>>(), "{pixel:?} {first}");
            }
        }
    }

    #[test]
    fn neighbouring_pixels_take_different_moments_and_a_square_takes_all_of_them() {
        for (samples, side) in [(16, 2), (4, 4), (1, 8)] {
            let all = by_moment(samples, Window::full([16, 16]), [0, samples]);
            for [left, top] in [[0, 0], [8, 8]] {
                let mut taken: Vec<usize> = Vec::new();
                for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (left + x, top + y))) {
                    taken.extend(of_pixel(&all, [x, y]).iter().map(|(moment, _)| moment));
                }
                taken.sort_unstable();
                assert_eq!(taken, (0..64).collect::<Vec<_>>(), "{samples}");
            }
        }
    }
}
