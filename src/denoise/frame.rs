//! A frame as the denoiser reads it.

use super::{
    blur,
    level::{levels, noise_around},
    outliers,
    signal::{Color, Signal},
    vectors::Vectors,
};

/// The features of the surfaces that a frame shows, with the variances of their means.
#[derive(Clone, Debug, Default)]
pub struct Guides {
    pub albedo: Color,
    /// Summed over the channels.
    pub albedo_variance: Vec<f32>,
    pub normal: Color,
    /// Summed over the axes.
    pub normal_variance: Vec<f32>,
    /// One over the depth, 1/m; 0 where nothing is met. On planes it is linear in the pixels.
    pub inverse_depth: Vec<f32>,
    pub inverse_depth_variance: Vec<f32>,
    /// The number of the object, where files have it.
    pub object: Option<Vec<u32>>,
}

impl Guides {
    /// Divides albedo and normal by the alpha, so that they are those of the surface also where it covers a part of the pixel.
    pub fn divide_by_alpha(&mut self, alpha: &[f32]) {
        for plane in self.albedo.iter_mut().chain(&mut self.normal) {
            divide(plane, alpha);
        }
        for variance in [&mut self.albedo_variance, &mut self.normal_variance] {
            divide(variance, alpha);
            divide(variance, alpha);
        }
    }
}

/// Divides each number by its alpha; 0 where that is 0.
pub(super) fn divide(values: &mut [f32], alpha: &[f32]) {
    for (value, alpha) in values.iter_mut().zip(alpha) {
        *value = if *alpha > 0.0 { *value / alpha } else { 0.0 };
    }
}

/// A camera as its shutter opens: matrices for row vectors, and its lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraMatrices {
    /// The matrix to camera space: x to the right, y up and z along the line of sight.
    pub camera_from_world: [f32; 16],
    /// The matrix to NDC, 0 0 in the upper left corner of the picture and 1 1 in the lower right one; panoramas have none.
    pub ndc_from_world: Option<[f32; 16]>,
    /// The f-number and the distance of focus, where it has a lens.
    pub lens: Option<[f32; 2]>,
}

/// The alpha of a picture with shadow catchers, of all samples and of each half.
#[derive(Clone, Debug, Default)]
pub struct CatcherAlpha {
    pub all: Vec<f32>,
    pub halves: [Vec<f32>; 2],
}

/// A frame as the denoiser reads it.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// The number of the frame: motion vectors lead to that before and to the next one.
    pub number: i32,
    /// Columns and rows.
    pub size: [usize; 2],
    /// The top left pixel of the frame in the whole picture, and the picture's columns and rows.
    pub origin: [i32; 2],
    pub resolution: [u32; 2],
    /// The part of each pixel that is covered; light is premultiplied by it.
    pub alpha: Vec<f32>,
    /// The same of each half of the samples.
    pub alpha_halves: [Vec<f32>; 2],
    /// The alpha of the picture, where shadow catchers make it less than the part that is covered.
    pub catcher_alpha: Option<CatcherAlpha>,
    /// Light divided by `modulation`.
    pub signal: Signal,
    pub modulation: Color,
    /// The light of outliers that was cut from the signal.
    pub cut: Color,
    pub guides: Guides,
    /// The hash of the scene's inputs, where the file tells it: frames of one scene show the same things under the same light.
    pub scene: Option<String>,
    /// The part of each pixel's light that mirrors and glass send, where files tell it.
    pub specular: Option<Vec<f32>>,
    /// Layers of the signal, by their indices, that sum to the beauty.
    pub families: Vec<Vec<usize>>,
    /// The camera, where the file tells it.
    pub camera: Option<CameraMatrices>,
    /// The motion of what pixels show, where the file tells it.
    pub vectors: Option<Vectors>,
}

impl Frame {
    /// Divides light by the alpha and the albedo, cuts outliers, and finds the variance of the halves.
    pub fn set_light(&mut self, halves: [Color; 2], light: Vec<Color>) {
        /// Pixels with so many times the variance of those around them (fireflies) keep their own.
        const OUTLIER: f32 = 4.0;
        self.modulation = modulation(&self.guides, &self.alpha, &halves, self.size);
        let modulation = &self.modulation;
        let divide = |mut color: Color| -> Color {
            for (plane, by) in color.iter_mut().zip(modulation) {
                divide(plane, by);
            }
            color
        };
        let mut halves = halves.map(divide);
        let mut light: Vec<Color> = light.into_iter().map(divide).collect();
        self.cut = outliers::cut(&mut halves, &mut light, self.size);
        let levels = levels(&halves, self.size);
        let variance: Color = std::array::from_fn(|c| {
            let pairs = halves[0][c].iter().zip(&halves[1][c]);
            let squares: Vec<f32> = pairs.map(|(a, b)| 0.5 * (a - b) * (a - b)).collect();
            let mut smooth = noise_around(&squares, &levels, self.size);
            for (smooth, own) in smooth.iter_mut().zip(squares) {
                if own > OUTLIER * *smooth {
                    *smooth = own;
                }
            }
            smooth
        });
        self.leave_alpha_out(&mut halves);
        self.signal = Signal {
            halves,
            variance,
            light,
        };
    }

    /// The alpha of the picture, of all samples and of each half.
    pub(super) fn picture_alpha(&self) -> (&[f32], &[Vec<f32>; 2]) {
        match &self.catcher_alpha {
            Some(alpha) => (&alpha.all, &alpha.halves),
            None => (&self.alpha, &self.alpha_halves),
        }
    }

    /// Whether both show one scene: the same things under the same light.
    pub(super) fn is_of_scene_of(&self, other: &Self) -> bool {
        self.scene.is_some() && self.scene == other.scene
    }

    /// 1 where both halves of the samples meet something, so that their difference is noise; else 0.
    pub(super) fn tells_noise(&self, i: usize) -> f32 {
        f32::from(self.alpha_halves.iter().all(|half| half[i] > 0.0))
    }

    /// Makes halves, which are divided by the alpha of all samples, differ as much as they do when each is divided by its own
    /// alpha: the noise of the coverage is no noise of the light. Their mean stays.
    fn leave_alpha_out(&self, halves: &mut [Color; 2]) {
        let [alpha_a, alpha_b] = &self.alpha_halves;
        let [half_a, half_b] = halves;
        for (a, b) in half_a.iter_mut().zip(half_b) {
            for (i, (a, b)) in a.iter_mut().zip(b).enumerate() {
                let (alpha, own) = (self.alpha[i], [alpha_a[i], alpha_b[i]]);
                if own == [alpha; 2] {
                    continue;
                }
                let mean = 0.5 * (*a + *b);
                let apart = match self.tells_noise(i) > 0.0 {
                    true => 0.5 * alpha * (*a / own[0] - *b / own[1]),
                    false => 0.0,
                };
                let apart = apart.clamp(-mean.abs(), mean.abs());
                (*a, *b) = (mean + apart, mean - apart);
            }
        }
    }

    /// The number of pixels with outliers that were cut, and the part of all light that they held.
    pub fn cut_light(&self) -> (usize, f64) {
        let is_cut = |i: &usize| self.cut.iter().any(|plane| plane[*i] > 0.0);
        let (mut lost, mut left) = (0.0, 0.0);
        for c in 0..3 {
            for i in 0..self.pixels() {
                let by = f64::from(self.modulation[c][i]);
                let [a, b] = [0, 1].map(|half: usize| f64::from(self.signal.halves[half][c][i]));
                lost += by * f64::from(self.cut[c][i]);
                left += by * 0.5 * (a + b);
            }
        }
        let part = if lost > 0.0 { lost / (lost + left) } else { 0.0 };
        ((0..self.pixels()).filter(is_cut).count(), part)
    }

    pub(super) fn pixels(&self) -> usize {
        self.size[0] * self.size[1]
    }
}

/// The divisor of light: the alpha times the albedo, of the pixel itself or the mean around it.
///
/// The pixel's own albedo carries textures; but where it is noisy, as at the edges of lamps, it would put its noise into the
/// light. The one that leaves the light smoother divides; where both do alike, the own one if its noise is low.
fn modulation(guides: &Guides, alpha: &[f32], halves: &[Color; 2], size: [usize; 2]) -> Color {
    /// Albedos below count as this much, so that light without a surface stays as it is but for a factor.
    const LEAST_ALBEDO: f32 = 0.02;
    /// One over the square of the error, in parts of the albedo, with which albedos are replaced by the mean of those around.
    const NOISY: f32 = 1.0 / (0.3 * 0.3);
    let albedos = |planes: &Color| {
        planes
            .each_ref()
            .map(|plane| plane.iter().map(|v| v.max(LEAST_ALBEDO)).collect())
    };
    let own: Color = albedos(&guides.albedo);
    let smooth: Color = albedos(&guides.albedo.each_ref().map(|plane| blur::binomial(plane, size)));
    let noise = blur::binomial(&guides.albedo_variance, size);
    let by_own = roughness(&own, alpha, halves, size);
    let by_smooth = roughness(&smooth, alpha, halves, size);
    std::array::from_fn(|c| {
        let pixel = |i: usize| {
            let square = own[c][i] * own[c][i];
            let low_noise = (1.0 - NOISY * noise[i] / square).max(0.0);
            let better = smoother(by_own[i], by_smooth[i]) * (1.0 - low_noise);
            let worse = smoother(by_smooth[i], by_own[i]) * low_noise;
            alpha[i] * (smooth[c][i] + (low_noise + better - worse) * (own[c][i] - smooth[c][i]))
        };
        (0..alpha.len()).map(pixel).collect()
    })
}

/// Whether the first roughness is clearly less than the second: from 0 to 1.
fn smoother(first: f32, second: f32) -> f32 {
    const FROM: f32 = 1.1;
    const TO: f32 = 1.5;
    ((second - FROM * first) / ((TO - FROM) * first).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0)
}

/// The variation of light over albedo around each pixel: its variance over its squared mean, summed over the channels.
fn roughness(albedo: &Color, alpha: &[f32], halves: &[Color; 2], size: [usize; 2]) -> Vec<f32> {
    const RADIUS: usize = 2;
    let covered = blur::mean(alpha, size, RADIUS);
    let mut rough = vec![0.0; alpha.len()];
    for c in 0..3 {
        // Premultiplied by the alpha: pixels count as far as they are covered.
        let light = |i: usize| 0.5 * (halves[0][c][i] + halves[1][c][i]) / albedo[c][i];
        let lights: Vec<f32> = (0..alpha.len()).map(light).collect();
        let square = |(light, alpha): (&f32, &f32)| if *alpha > 0.0 { light * light / alpha } else { 0.0 };
        let squares: Vec<f32> = lights.iter().zip(alpha).map(square).collect();
        let (mean, square) = (blur::mean(&lights, size, RADIUS), blur::mean(&squares, size, RADIUS));
        for (i, rough) in rough.iter_mut().enumerate() {
            let of_mean = mean[i] * mean[i];
            if of_mean > 0.0 {
                *rough += (square[i] * covered[i] / of_mean - 1.0).max(0.0);
            }
        }
    }
    rough
}
