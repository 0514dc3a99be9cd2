//! Adaptive sampling: blocks of pixels whose noise is low get no more samples.
//!
//! The blocks are the cells of a fixed grid over the picture. Whether a block has enough samples is decided by its own samples
//! alone, at powers of two, so its bits do not depend on crops, threads, rounds or neighbours. A crop renders the blocks at its
//! edges whole.

use serde::Serialize;

use crate::film::Window;

/// The side of a block, in pixels. A block with 16 samples per pixel fills a wave.
const BLOCK_SIDE: i32 = 16;

/// The least number of samples for a decision about a block.
const MIN_JUDGED: u32 = 4;

/// The rule by which a block of pixels has enough samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AdaptiveSampling {
    /// The least samples of each pixel.
    pub min: u32,
    /// The display error below which a block stops, see [`film::noise`](crate::film::noise).
    pub threshold: f32,
    /// The factor of the exposure.
    pub gain: f32,
}

impl AdaptiveSampling {
    /// The number of samples at which blocks are first checked.
    pub fn first_check(&self) -> u32 {
        let min = self.min.clamp(MIN_JUDGED, 1 << 31);
        min.next_power_of_two()
    }

    /// The number of samples, more than `done`, at which a block is checked next.
    pub fn next_check(&self, done: u32) -> u32 {
        let next = done.checked_add(1).and_then(u32::checked_next_power_of_two);
        next.map_or(u32::MAX, |next| next.max(self.first_check()))
    }
}

/// The blocks that contain pixels of `window`, row by row. The grid has lines on the edges of the picture, so overscan does not
/// change the blocks inside.
pub(super) fn blocks(window: Window, [width, height]: [u32; 2]) -> Vec<Window> {
    let columns: Vec<_> = cells(window.x0, window.x1, width).collect();
    let row = |(y0, y1): (i32, i32)| {
        let columns = columns.iter();
        columns.map(move |&(x0, x1)| Window::new(x0, y0, x1, y1))
    };
    cells(window.y0, window.y1, height).flat_map(row).collect()
}

/// The cells along one axis that contain pixels of `from..to`, in a picture of `size` pixels.
fn cells(from: i32, to: i32, size: u32) -> impl Iterator<Item = (i32, i32)> {
    let cell = move |x: i32| {
        let start = x.div_euclid(BLOCK_SIDE) * BLOCK_SIDE;
        let (end, edge) = (start + BLOCK_SIDE, size as i32);
        if x < edge {
            (start, end.min(edge))
        } else {
            (start.max(edge), end)
        }
    };
    std::iter::successors(Some(cell(from)), move |&(_, end)| (end < to).then(|| cell(end)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_judged_at_powers_of_two_from_the_least_number_on() {
        let checks = |min| {
            let rule = AdaptiveSampling {
                min,
                threshold: 0.01,
                gain: 1.0,
            };
            let next = |done: &u32| Some(rule.next_check(*done));
            let checks: Vec<u32> = std::iter::successors(next(&0), next).take(3).collect();
            (rule.first_check(), checks)
        };
        assert_eq!(checks(16), (16, vec![16, 32, 64]));
        assert_eq!(checks(17), (32, vec![32, 64, 128]));
        assert_eq!(checks(1), (4, vec![4, 8, 16]));
        assert_eq!(checks(u32::MAX), (1 << 31, vec![1 << 31, u32::MAX, u32::MAX]));
    }

    #[test]
    fn a_pixel_is_in_the_same_block_in_every_window_and_a_block_is_whole() {
        let size = [40, 37];
        let whole = blocks(Window::full(size), size);
        let pixels: usize = whole.iter().map(Window::area).sum();
        assert_eq!((whole.len(), pixels), (9, 40 * 37));
        for crop in [
            Window::new(5, 3, 6, 4),
            Window::new(15, 15, 33, 36),
            Window::new(0, 20, 40, 21),
        ] {
            let own = blocks(crop, size);
            assert!(own.iter().all(|block| whole.contains(block)));
            let inside = own.iter().map(|block| block.intersection(crop).area());
            assert_eq!(inside.sum::<usize>(), crop.area());
        }
        // Overscan does not change the picture's own blocks.
        let around = blocks(Window::new(-20, -1, 60, 40), size);
        assert!(whole.iter().all(|block| around.contains(block)));
        assert!(around.contains(&Window::new(40, 37, 48, 48)) && around.contains(&Window::new(-32, -16, -16, 0)));
    }
}
