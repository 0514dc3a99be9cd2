//! Shadow catchers: surfaces of which a picture shows only how other objects change their light.
//!
//! A sample whose camera ray meets a catcher has two radiances: `l`, the light that leaves the catcher in the whole scene, and
//! `without`, that of a scene of catchers and lights alone. With the means of a pixel, `L` of its beauty, in which a catcher is an
//! ordinary surface, `W` and `O` of the two radiances, and `c`, the share of the pixel that catchers cover, the pixel is
//!
//! ```text
//! m = min(1, W / O)      the least of the channels
//! A = alpha - c m        RGB = L - m O
//! ```
//!
//! A background that the camera sees, unless it is black, is the plate, of the mean `B` over the same samples. It is
//! known, so each of its channels has a ratio of its own, and what the catcher reflects beyond `O` is as bright on it as
//! the plate is beside the catcher:
//!
//! ```text
//! A = alpha              RGB = L - W + min(1, W / O) B + min(1, B / O) max(0, W - O)
//! ```
//!
//! Over an unknown plate `P` this is `P c W / O` where the ratio is gray, and `W` for any ratio where the plate is the
//! catcher itself, `P c = O`. Darker plates show the light that is left of a coloured shadow as that of the catcher. Both
//! radiances are of the same random numbers: where no object changes the light of a catcher, they have the same bits, and its
//! alpha and its light are exactly 0.

use super::{
    SampleRecord,
    pixel_sum::{HalfSums, PixelSum},
    state,
};
use crate::math::Rgb;

/// The sums of the catchers in the pixels of a tile.
#[derive(Clone, Debug, Default)]
pub(super) struct TileCatchers {
    /// The sums of `l`, of `without` and of the background behind catchers of each pixel; empty if the scene has no catchers.
    sums: Vec<[PixelSum; 3]>,
    /// The same by halves of the samples; empty if no pass shows halves.
    halves: Vec<[HalfSums; 3]>,
}

impl TileCatchers {
    /// Those of this many pixels, and of this many by halves.
    pub fn new(pixels: usize, by_halves: usize) -> Self {
        Self {
            sums: vec![Default::default(); pixels],
            halves: vec![Default::default(); by_halves],
        }
    }

    /// The bytes of a pixel, and those by halves.
    pub const BYTES: [usize; 2] = [size_of::<[PixelSum; 3]>(), size_of::<[HalfSums; 3]>()];

    /// Adds a sample of this half.
    pub fn add(&mut self, pixel: usize, half: usize, sample: &SampleRecord<'_>) {
        let Some(sums) = self.sums.get_mut(pixel) else { return };
        let lights = match sample.without {
            Some(without) => [Some(sample.l), Some(without), sample.behind],
            None => [None; 3],
        };
        let lights = lights.map(|l| (l.unwrap_or(Rgb::BLACK), if l.is_some() { 1.0 } else { 0.0 }));
        for (sum, (l, alpha)) in sums.iter_mut().zip(lights) {
            sum.add(l, alpha, sample.weight);
        }
        for (sums, (l, alpha)) in self.halves.get_mut(pixel).into_iter().flatten().zip(lights) {
            sums.add(half, l, alpha, sample.weight);
        }
    }

    /// Adds the sums of later samples.
    pub fn append(&mut self, later: &Self) {
        for (own, later) in self.sums.as_flattened_mut().iter_mut().zip(later.sums.as_flattened()) {
            own.append(later);
        }
        for (own, later) in self
            .halves
            .as_flattened_mut()
            .iter_mut()
            .zip(later.halves.as_flattened())
        {
            own.append(later);
        }
    }

    /// Makes all samples so far the first half.
    pub fn start_second_half(&mut self) {
        for (halves, sums) in self.halves.iter_mut().zip(&self.sums) {
            *halves = sums.each_ref().map(HalfSums::of_first);
        }
    }

    /// The pixel, whose beauty with ordinary surfaces in place of catchers is `beauty`.
    pub fn pixel(&self, pixel: usize, beauty: [f32; 4]) -> [f32; 4] {
        let sums = self.sums.get(pixel);
        sums.map_or(beauty, |sums| uncover(beauty, sums.each_ref().map(PixelSum::resolve)))
    }

    /// The same of a half of the samples.
    pub fn half(&self, pixel: usize, half: usize, beauty: [f32; 4]) -> [f32; 4] {
        let halves = self.halves.get(pixel);
        halves.map_or(beauty, |both| {
            uncover(beauty, both.each_ref().map(|sums| sums.resolve(half)))
        })
    }

    /// Appends the sums as bytes.
    pub fn write_state(&self, out: &mut Vec<u8>) {
        state::put(out, self.sums.as_flattened());
        state::put(out, self.halves.as_flattened());
    }

    /// Reads the sums from the start of `input`, and advances it; `None` if it is too short.
    pub fn read_state(&mut self, input: &mut &[u8]) -> Option<()> {
        state::take(input, self.sums.as_flattened_mut())?;
        state::take(input, self.halves.as_flattened_mut())
    }
}

/// The pixel with this `beauty` and these means of both radiances of its catchers, and of the background behind.
fn uncover(beauty: [f32; 4], [with, without, behind]: [[f32; 4]; 3]) -> [f32; 4] {
    if behind[3] != 0.0 {
        return on_plate(beauty, [with, without, behind]);
    }
    let ratios = (0..3).filter(|&c| without[c] > 0.0).map(|c| with[c] / without[c]);
    let kept = ratios.fold(1.0, f32::min).max(0.0);
    let mut pixel: [f32; 4] = std::array::from_fn(|c| difference(beauty[c] + kept * behind[c], kept * without[c]));
    pixel[3] = pixel[3].clamp(0.0, 1.0);
    pixel
}

/// `a - b`, and 0 where rounding alone makes less than that of it.
fn difference(a: f32, b: f32) -> f32 {
    let is_rounding = a < b && b - a <= 4.0 * f32::EPSILON * b;
    if is_rounding { 0.0 } else { a - b }
}

/// The pixel before a background that is seen.
fn on_plate(beauty: [f32; 4], [with, without, behind]: [[f32; 4]; 3]) -> [f32; 4] {
    // Where the catcher has no light of its own, its ratio is 1, and what it reflects is added.
    let ratio = |a: f32, b: f32| if b > 0.0 { (a / b).clamp(0.0, 1.0) } else { 1.0 };
    let mut pixel = beauty;
    for c in 0..3 {
        let (w, o, b) = (with[c], without[c], behind[c]);
        pixel[c] = difference(beauty[c], w) + (ratio(w, o) * b + ratio(b, o) * (w - o).max(0.0));
    }
    pixel[3] = pixel[3].clamp(0.0, 1.0);
    pixel
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample<'a>(l: Rgb, without: Option<Rgb>, weight: f32) -> SampleRecord<'a> {
        SampleRecord {
            l,
            without,
            behind: None,
            alpha: 1.0,
            weight,
            index: 0,
            distance_squared: 0.0,
            first: None,
            light: &[],
        }
    }

    /// The pixel of these samples, each with its radiance and that without other objects, over a plate.
    fn over(plate: [f32; 3], samples: &[(Rgb, Option<Rgb>)]) -> [f32; 3] {
        let (mut beauty, mut catchers) = (PixelSum::default(), TileCatchers::new(1, 0));
        for &(l, without) in samples {
            beauty.add(l, 1.0, 1.0);
            catchers.add(0, 0, &sample(l, without, 1.0));
        }
        let [r, g, b, a] = catchers.pixel(0, beauty.resolve());
        std::array::from_fn(|c| [r, g, b][c] + (1.0 - a) * plate[c])
    }

    fn assert_near(a: [f32; 3], b: [f32; 3]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
    }

    #[test]
    fn a_gray_shadow_scales_every_plate() {
        let shaded = (Rgb::gray(0.3), Some(Rgb::gray(0.6)));
        assert_near(over([0.2, 0.4, 0.8], &[shaded]), [0.1, 0.2, 0.4]);
        // A quarter of the pixel is an object.
        let object = (Rgb::new(1.0, 0.0, 0.0), None);
        let pixel = over([0.2, 0.4, 0.8], &[shaded, object, shaded, shaded]);
        assert_near(pixel, [0.075 + 0.25, 0.15, 0.3]);
    }

    #[test]
    fn light_of_any_colour_is_right_over_the_catcher_itself() {
        for with in [Rgb::new(0.3, 0.1, 0.7), Rgb::new(0.9, 1.0, 1.1), Rgb::BLACK] {
            let plate = Rgb::new(0.5, 0.4, 0.6);
            assert_near(over(plate.to_array(), &[(with, Some(plate))]), with.to_array());
        }
        // Without any light of its own the catcher is black, and what it reflects is added.
        assert_near(over([0.5; 3], &[(Rgb::gray(0.2), Some(Rgb::BLACK))]), [0.7; 3]);
    }

    #[test]
    fn a_background_that_is_seen_is_the_plate() {
        let plate = Rgb::new(0.2, 0.4, 0.8);
        for (with, shown) in [
            (Rgb::gray(0.3), plate * 0.5),
            (Rgb::gray(0.6), plate),
            (Rgb::new(0.3, 0.0, 0.6), Rgb::new(0.1, 0.0, 0.8)),
            // More light than without objects: a plate as bright as the catcher or brighter shows all of it.
            (Rgb::gray(0.9), plate + Rgb::new(0.1, 0.2, 0.3)),
        ] {
            let without = Some(Rgb::gray(0.6));
            let (mut beauty, mut catchers) = (PixelSum::default(), TileCatchers::new(1, 0));
            for (l, without, behind) in [(with, without, Some(plate)), (Rgb::WHITE, None, None)] {
                beauty.add(l, 1.0, 1.0);
                let sample = sample(l, without, 1.0);
                catchers.add(0, 0, &SampleRecord { behind, ..sample });
            }
            let [r, g, b, a] = catchers.pixel(0, beauty.resolve());
            assert_near([r, g, b], (shown * 0.5 + Rgb::gray(0.5)).to_array());
            assert_eq!(a, 1.0);
        }
    }

    #[test]
    fn no_rounding_makes_light_negative() {
        for i in 0..10_000 {
            let part = |k: u32| (i as f32 * 0.618_034 * (k + 1) as f32).fract();
            let (without, ratio) = ([part(1), part(2), part(3), 1.0], part(4));
            // The channels have nearly the same ratio, which is that of the least.
            let with = [0, 1, 2, 3].map(|c| if c < 3 { without[c] * ratio } else { 1.0 });
            let pixel = uncover(with, [with, without, [0.0; 4]]);
            assert!(pixel.iter().all(|v| *v >= 0.0), "{pixel:?}");
        }
    }

    #[test]
    fn a_catcher_that_nothing_changes_is_exactly_transparent() {
        let (mut beauty, mut catchers) = (PixelSum::default(), TileCatchers::new(1, 1));
        for (i, weight) in [1.0, 1.0, -1.0, 1.0, 1.0].into_iter().enumerate() {
            let l = Rgb::new(0.1, 0.7, 0.3) * (i as f32 + 0.1);
            beauty.add(l, 1.0, weight);
            catchers.add(0, i / 3, &sample(l, Some(l), weight));
        }
        assert_eq!(catchers.pixel(0, beauty.resolve()), [0.0; 4]);
        let mut bytes = Vec::new();
        catchers.write_state(&mut bytes);
        let mut read = TileCatchers::new(1, 1);
        read.read_state(&mut &bytes[..]).expect("the same layout");
        assert_eq!(read.pixel(0, beauty.resolve()), [0.0; 4]);
        assert_eq!(bytes.len(), TileCatchers::BYTES.iter().sum::<usize>());
    }
}
