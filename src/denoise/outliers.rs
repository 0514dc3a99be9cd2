//! Outliers: pixels of one half of the samples that are far brighter than everything around them.
//!
//! A rare path of much light meets one half only, so the darker half of a pixel does not hold it. Outliers are cut before
//! any mean is made, so that they spread to no other pixel and no other frame. What is cut is kept, for the error that is told.
//!
//! Light that both halves of a pixel show stays, also where it is as small as a pixel, and so does light that three halves
//! around show. As samples grow, the halves agree.

use super::signal::{Color, black};
use crate::math::parallel;

/// Pixels on each side of a pixel that say how bright it may be.
const RADIUS: usize = 2;

/// The largest ratio of a pixel's brightness to the brightest of the darker halves around it, and to the third brightest half.
const OVER_DARKER: f32 = 2.0;
const OVER_THIRD: f32 = 2.0;

/// Cuts the outliers of both halves, and other light in the same proportion. Returns the light that was cut from the mean.
pub(super) fn cut(halves: &mut [Color; 2], light: &mut [Color], size: [usize; 2]) -> Color {
    let pixels = size[0] * size[1];
    let brightness =
        |color: &Color| -> Vec<f32> { (0..pixels).map(|i| color[0][i] + color[1][i] + color[2][i]).collect() };
    let bright = [brightness(&halves[0]), brightness(&halves[1])];
    let most = parallel::table(pixels, |i| most(&bright, size, i));
    let mut lost = black(pixels);
    for i in 0..pixels {
        let keep = [0, 1].map(|half: usize| match bright[half][i] > most[i] {
            true => most[i] / bright[half][i],
            false => 1.0,
        });
        if keep == [1.0; 2] {
            continue;
        }
        for c in 0..3 {
            for (half, keep) in halves.iter_mut().zip(keep) {
                if keep < 1.0 {
                    lost[c][i] += 0.5 * (1.0 - keep) * half[c][i];
                    half[c][i] *= keep;
                }
            }
            let left = 0.5 * (halves[0][c][i] + halves[1][c][i]);
            let all = left + lost[c][i];
            let part = if all > 0.0 { left / all } else { 1.0 };
            for layer in &mut *light {
                layer[c][i] *= part;
            }
        }
    }
    lost
}

/// The largest brightness that a half of this pixel may have.
fn most(bright: &[Vec<f32>; 2], [width, height]: [usize; 2], i: usize) -> f32 {
    let (x, y) = (i % width, i / width);
    let around = |at: usize, size: usize| at.saturating_sub(RADIUS)..=(at + RADIUS).min(size - 1);
    let mut darker = 0.0_f32;
    // The three brightest halves, in falling order.
    let mut brightest = [0.0_f32; 3];
    for y in around(y, height) {
        for i in around(x, width).map(|x| y * width + x) {
            let pair = [bright[0][i], bright[1][i]];
            darker = darker.max(pair[0].min(pair[1]));
            for mut value in pair {
                for place in &mut brightest {
                    (*place, value) = (place.max(value), place.min(value));
                }
            }
        }
    }
    (OVER_DARKER * darker).max(OVER_THIRD * brightest[2])
}
