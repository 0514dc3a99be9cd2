//! Means over squares of pixels.

use crate::math::parallel;

/// The mean over the square of side `2 * radius + 1` around each pixel; beyond the edges the nearest pixel counts.
pub(super) fn mean(values: &[f32], [width, height]: [usize; 2], radius: usize) -> Vec<f32> {
    let taps = vec![1.0; 2 * radius + 1];
    separable(values, [width, height], &taps)
}

/// The mean by the weights of a 5 x 5 binomial around each pixel.
pub(super) fn binomial(values: &[f32], size: [usize; 2]) -> Vec<f32> {
    separable(values, size, &[1.0, 4.0, 6.0, 4.0, 1.0])
}

fn separable(values: &[f32], [width, height]: [usize; 2], taps: &[f32]) -> Vec<f32> {
    let radius = taps.len() / 2;
    let scale = 1.0 / taps.iter().sum::<f32>();
    let mut across = vec![0.0; values.len()];
    let rows = across.chunks_mut(width).zip(values.chunks(width));
    parallel::for_each(rows, |(out, row)| {
        let mut padded = vec![row[0]; radius];
        padded.extend(row);
        padded.resize(width + 2 * radius, row[width - 1]);
        for (i, tap) in taps.iter().enumerate() {
            for (out, value) in out.iter_mut().zip(&padded[i..]) {
                *out += tap * scale * value;
            }
        }
    });
    let mut down = vec![0.0; values.len()];
    parallel::for_each(down.chunks_mut(width).enumerate(), |(y, out)| {
        for (i, tap) in taps.iter().enumerate() {
            let from = (y + i).saturating_sub(radius).min(height - 1);
            for (out, value) in out.iter_mut().zip(&across[from * width..][..width]) {
                *out += tap * scale * value;
            }
        }
    });
    down
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_stay_and_a_point_spreads_over_its_square() {
        let size = [9, 7];
        let constant = mean(&[2.0; 63], size, 3);
        assert!(constant.iter().all(|v| (v - 2.0).abs() < 1e-6));
        let mut point = [0.0; 63];
        point[3 * 9 + 4] = 9.0;
        let spread = mean(&point, size, 1);
        for (i, v) in spread.iter().enumerate() {
            let (x, y) = (i % 9, i / 9);
            let inside = x.abs_diff(4) <= 1 && y.abs_diff(3) <= 1;
            assert!((v - f32::from(inside)).abs() < 1e-6, "{x} {y}: {v}");
        }
    }
}
