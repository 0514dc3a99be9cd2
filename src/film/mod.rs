//! The film: samples to pixels.
//!
//! A sample belongs to its own pixel, and a pixel's samples are added in their order, so a pixel's bits do not depend
//! on tiles, threads or crops.

use crate::math::Rgb;

pub mod view;
pub mod window;

pub use window::Window;

/// The samples of one pixel so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct PixelSum {
    rgb: Rgb,
    alpha: f32,
    weight: f32,
    /// The same without signs: what is left where the weights cancel.
    unsigned: Rgb,
    unsigned_alpha: f32,
    count: u32,
}

impl PixelSum {
    /// Adds a sample; `weight` is 1, or -1 where the filter is negative.
    #[inline]
    pub fn add(&mut self, l: Rgb, alpha: f32, weight: f32) {
        self.rgb += l * weight;
        self.alpha += alpha * weight;
        self.weight += weight;
        self.unsigned += l;
        self.unsigned_alpha += alpha;
        self.count += 1;
    }

    /// The pixel: premultiplied R, G, B and A.
    ///
    /// The weighted mean. Where so few samples were taken that negative weights leave less than a tenth of them, that
    /// mean would be noise without bound, and the plain mean stands in.
    pub fn resolve(&self) -> [f32; 4] {
        let n = self.count as f32;
        let (rgb, alpha) = if self.weight >= 0.1 * n {
            (self.rgb / self.weight, self.alpha / self.weight)
        } else {
            (self.unsigned / n, self.unsigned_alpha / n)
        };
        [rgb.r, rgb.g, rgb.b, alpha]
    }
}

/// The picture of one frame.
#[derive(Clone, Debug)]
pub struct Film {
    /// Columns and rows of the full picture.
    pub resolution: [u32; 2],
    /// The part of it that was rendered.
    pub window: Window,
    /// R, G, B, A of each pixel of the window, row by row from the top, premultiplied, scene-linear.
    pub pixels: Vec<[f32; 4]>,
    /// The same light sorted, where it was asked for: R, G, B of each pixel of the window, layer by layer. First the
    /// components, then the groups of lights; each family sums up to the picture.
    pub layers: Vec<Vec<[f32; 3]>>,
}

impl Film {
    pub fn new(resolution: [u32; 2], window: Window) -> Self {
        Self {
            resolution,
            window,
            pixels: vec![[0.0; 4]; window.area()],
            layers: Vec::new(),
        }
    }

    /// Copies a finished part in.
    pub fn put(&mut self, part: Window, pixels: &[[f32; 4]]) {
        put(&mut self.pixels, self.window, part, pixels);
    }

    /// The same for a layer, which is there from then on.
    pub fn put_layer(&mut self, layer: usize, part: Window, pixels: &[[f32; 3]]) {
        while self.layers.len() <= layer {
            self.layers.push(vec![[0.0; 3]; self.window.area()]);
        }
        put(&mut self.layers[layer], self.window, part, pixels);
    }
}

/// Copies the pixels of `part` to where they belong among `all` of `window`.
fn put<T: Copy>(all: &mut [T], window: Window, part: Window, pixels: &[T]) {
    let width = part.width() as usize;
    for (row, source) in (part.y0..part.y1).zip(pixels.chunks_exact(width)) {
        let at = (row - window.y0) as usize * window.width() as usize + (part.x0 - window.x0) as usize;
        all[at..at + width].copy_from_slice(source);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_stays_constant_under_signed_weights() {
        let mut sum = PixelSum::default();
        for weight in [1.0, 1.0, -1.0, 1.0] {
            sum.add(Rgb::gray(3.0), 1.0, weight);
        }
        assert_eq!(sum.resolve(), [3.0, 3.0, 3.0, 1.0]);
    }

    #[test]
    fn weights_that_cancel_leave_the_plain_mean() {
        let mut sum = PixelSum::default();
        sum.add(Rgb::gray(1.0), 1.0, 1.0);
        sum.add(Rgb::gray(3.0), 1.0, -1.0);
        assert_eq!(sum.resolve(), [2.0, 2.0, 2.0, 1.0]);
    }

    #[test]
    fn parts_land_where_they_belong() {
        let window = Window::new(10, 20, 14, 22);
        let mut film = Film::new([100, 100], window);
        film.put(Window::new(12, 21, 14, 22), &[[1.0; 4], [2.0; 4]]);
        assert_eq!(film.pixels[6], [1.0; 4]);
        assert_eq!(film.pixels[7], [2.0; 4]);
        assert_eq!(film.pixels.iter().filter(|p| p[0] == 0.0).count(), 6);
    }
}
