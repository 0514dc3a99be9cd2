//! A frame as the denoiser reads it.

use super::{
    blur,
    signal::{Color, Signal},
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

/// A frame as the denoiser reads it.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Columns and rows.
    pub size: [usize; 2],
    /// The top left pixel of the frame in the whole picture, and the picture's columns and rows.
    pub origin: [i32; 2],
    pub resolution: [u32; 2],
    /// Light divided by `modulation`.
    pub signal: Signal,
    pub modulation: Color,
    pub guides: Guides,
    /// The part of each pixel's light that mirrors and glass send, where files tell it.
    pub specular: Option<Vec<f32>>,
    /// Layers of the signal, by their indices, that sum to the beauty.
    pub families: Vec<Vec<usize>>,
    /// The camera, where the file tells it.
    pub camera: Option<CameraMatrices>,
}

impl Frame {
    /// Divides light by albedo, and finds the variance of the halves.
    pub fn set_light(&mut self, halves: [Color; 2], light: Vec<Color>) {
        /// Albedos below count as this much, so that light without a surface stays as it is but for a factor.
        const LEAST_ALBEDO: f32 = 0.02;
        /// One over the square of the error, in parts of the albedo, with which albedos are replaced by the mean of those around.
        const DOUBT: f32 = 1.0 / (0.3 * 0.3);
        /// Pixels with so many times the variance of those around them (fireflies) keep their own.
        const OUTLIER: f32 = 4.0;
        self.modulation = self.guides.albedo.each_ref().map(|albedo| {
            let smooth = blur::binomial(albedo, self.size);
            let noise = blur::binomial(&self.guides.albedo_variance, self.size);
            let pixel = |i: usize| {
                let square = albedo[i] * albedo[i];
                let trust = (1.0 - DOUBT * noise[i] / square.max(f32::MIN_POSITIVE)).max(0.0);
                (smooth[i] + trust * (albedo[i] - smooth[i])).max(LEAST_ALBEDO)
            };
            (0..albedo.len()).map(pixel).collect()
        });
        let modulation = &self.modulation;
        let divide = |color: Color| -> Color {
            std::array::from_fn(|c| color[c].iter().zip(&modulation[c]).map(|(v, by)| v / by).collect())
        };
        let halves = halves.map(divide);
        let variance: Color = std::array::from_fn(|c| {
            let pairs = halves[0][c].iter().zip(&halves[1][c]);
            let squares: Vec<f32> = pairs.map(|(a, b)| 0.5 * (a - b) * (a - b)).collect();
            let mut smooth = blur::binomial(&squares, self.size);
            for (smooth, own) in smooth.iter_mut().zip(squares) {
                if own > OUTLIER * *smooth {
                    *smooth = own;
                }
            }
            smooth
        });
        self.signal = Signal {
            halves,
            variance,
            light: light.into_iter().map(divide).collect(),
        };
    }

    pub(super) fn pixels(&self) -> usize {
        self.size[0] * self.size[1]
    }
}
