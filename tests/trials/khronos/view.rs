//! Pictures of models as an orthographic camera sees them, and measures of their pixels by places of the model.

use std::path::Path;

use crate::common::{Folder, pixels};

/// Light that is the same from everywhere: a white matte surface has the radiance 1.
pub const WHITE_SKY: &str = "color = [1, 1, 1]";
/// No light but the model's own.
pub const DARK: &str = "color = [0, 0, 0]";

/// Rows of a picture.
const ROWS: f64 = 280.0;

pub type Rgb = [f32; 3];

/// An orthographic view. Places in the picture are metres to the right and upwards from the axis of the camera
/// that looks at the origin.
pub struct View<'a> {
    pub model: &'a str,
    /// The direction from the model to the camera, and which direction is up in the picture.
    pub back: [f64; 3],
    pub up: [f64; 3],
    /// The point in the middle of the picture, and the size of the picture, in metres.
    pub center: [f64; 2],
    pub size: [f64; 2],
    /// The entries of `[background]`.
    pub background: &'a str,
    pub samples: u32,
}

impl<'a> View<'a> {
    /// The view from +z onto a model of `gltf/khronos` under a white sky.
    pub fn front(model: &'a str, center: [f64; 2], size: [f64; 2]) -> Self {
        Self {
            model,
            back: [0.0, 0.0, 1.0],
            up: [0.0, 1.0, 0.0],
            center,
            size,
            background: WHITE_SKY,
            samples: 14,
        }
    }

    /// The picture, with the models in the folder `assets`.
    pub fn render(&self, assets: &Path) -> Picture {
        let [bx, by, bz] = self.back;
        let [ux, uy, uz] = self.up;
        let right = [uy * bz - uz * by, uz * bx - ux * bz, ux * by - uy * bx];
        let target = [0, 1, 2].map(|k| right[k] * self.center[0] + self.up[k] * self.center[1]);
        let eye = [0, 1, 2].map(|k| target[k] + 50.0 * self.back[k]);
        let model = assets.join("gltf/khronos").join(self.model);
        let columns = (ROWS * self.size[0] / self.size[1]).round();
        let folder = Folder::new();
        let rows = folder.render(&format!(
            "[render]\nwidth = {columns}\nheight = {ROWS}\nsamples = {}\nintegrator.path = {{ max_depth = 4 }}\n\
             [camera]\northographic = {{ eye = {eye:?}, target = {target:?}, up = {:?}, height = {} }}\n\
             [background]\n{}\n[[object]]\nshape.mesh = {{ file = {:?} }}\n",
            self.samples,
            self.up,
            self.size[1],
            self.background,
            model.display().to_string(),
        ));
        assert_eq!(pixels(&folder.path("f.exr")).0, columns as usize);
        Picture {
            pixels: rows,
            columns: columns as usize,
            left: self.center[0] - 0.5 * self.size[0],
            top: self.center[1] + 0.5 * self.size[1],
            pitch: self.size[1] / ROWS,
        }
    }
}

/// A rendered picture.
pub struct Picture {
    pixels: Vec<Rgb>,
    columns: usize,
    /// The left and the upper edge, and the width of a pixel, in metres.
    left: f64,
    top: f64,
    pitch: f64,
}

impl Picture {
    /// The pixels of the rectangle around a place, row by row; `half` are its half sides in metres.
    pub fn block(&self, at: [f64; 2], half: [f64; 2]) -> Vec<Rgb> {
        let half = half.map(|h| (h / self.pitch).floor() as isize);
        let column = ((at[0] - self.left) / self.pitch).floor() as isize;
        let row = ((self.top - at[1]) / self.pitch).floor() as isize;
        let rows = (row - half[1])..=(row + half[1]);
        rows.flat_map(|y| ((column - half[0])..=(column + half[0])).map(move |x| (x, y)))
            .map(|(x, y)| {
                let is_inside = x >= 0 && y >= 0 && (x as usize) < self.columns;
                assert!(is_inside, "{at:?} is not in the picture");
                self.pixels[y as usize * self.columns + x as usize]
            })
            .collect()
    }

    pub fn mean(&self, at: [f64; 2], half: [f64; 2]) -> Rgb {
        mean(&self.block(at, half))
    }

    /// The share of pixels around a place for which `is_so`.
    pub fn share(&self, at: [f64; 2], half: [f64; 2], is_so: impl Fn(Rgb) -> bool) -> f32 {
        let block = self.block(at, half);
        block.iter().filter(|p| is_so(**p)).count() as f32 / block.len() as f32
    }

    /// The mean difference of two equal rectangles, relative to the brightness of the second. Noise is taken out, and so
    /// is a shift of the first by a few pixels.
    pub fn difference(&self, a: [f64; 2], b: [f64; 2], half: [f64; 2]) -> f32 {
        let b = self.blurred(b, half);
        let shifts = (-3..=3).flat_map(|y| (-3..=3).map(move |x| [x, y].map(f64::from)));
        let at = shifts.map(|[x, y]| [a[0] + x * self.pitch, a[1] + y * self.pitch]);
        at.map(|a| difference(&self.blurred(a, half), &b))
            .fold(f32::INFINITY, f32::min)
    }

    /// The block around a place, each pixel the mean of nine.
    pub fn blurred(&self, at: [f64; 2], half: [f64; 2]) -> Vec<Rgb> {
        let wider = half.map(|h| h + self.pitch);
        let (block, width) = (self.block(at, wider), self.columns_of(wider));
        let rows = block.len() / width;
        let inner = (1..rows - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y)));
        let near = |x: usize, y: usize| (0..9).map(move |k| (y + k / 3 - 1) * width + x + k % 3 - 1);
        inner
            .map(|(x, y)| mean(&near(x, y).map(|i| block[i]).collect::<Vec<_>>()))
            .collect()
    }

    /// The width of a block in pixels.
    fn columns_of(&self, half: [f64; 2]) -> usize {
        2 * (half[0] / self.pitch).floor() as usize + 1
    }

    /// The blurred block around a place, from right to left.
    pub fn mirrored(&self, at: [f64; 2], half: [f64; 2]) -> Vec<Rgb> {
        let mut block = self.blurred(at, half);
        block.chunks_exact_mut(self.columns_of(half)).for_each(<[Rgb]>::reverse);
        block
    }
}

/// The mean difference of pixels, relative to the brightness of `b`.
pub fn difference(a: &[Rgb], b: &[Rgb]) -> f32 {
    let off: f32 = a
        .iter()
        .zip(b)
        .map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).abs()).sum::<f32>())
        .sum();
    off / b.iter().flatten().sum::<f32>()
}

pub fn mean(block: &[Rgb]) -> Rgb {
    let sum = block.iter().fold([0.0; 3], |sum, p| [0, 1, 2].map(|k| sum[k] + p[k]));
    sum.map(|v| v / block.len() as f32)
}

/// The share of a colour that is not gray, from 0 to 1.
pub fn saturation(color: Rgb) -> f32 {
    let most = color.into_iter().fold(0.0, f32::max);
    let least = color.into_iter().fold(f32::INFINITY, f32::min);
    if most > 0.0 { (most - least) / most } else { 0.0 }
}

/// Whether a colour's channels, of which it has the brightest at 1, are near these.
pub fn is_hue(color: Rgb, hue: Rgb, tolerance: f32) -> bool {
    let most = color.into_iter().fold(0.0, f32::max);
    most > 0.05 && (0..3).all(|k| (color[k] / most - hue[k]).abs() < tolerance)
}
