//! Noisy light as the filters see it: two halves of the samples, their variance, and the layers that share their weights.

/// Red, green and blue of each pixel, row by row from the top.
pub type Color = [Vec<f32>; 3];

/// Noisy light of each pixel.
#[derive(Clone, Debug, Default)]
pub struct Signal {
    /// The means of two halves of the samples.
    pub halves: [Color; 2],
    /// The variance of the mean of a half.
    pub variance: Color,
    /// Layers of other light, of all samples, that are to get the same weights.
    pub light: Vec<Color>,
}

impl Signal {
    /// A copy of the beauty alone.
    pub(super) fn without_layers(&self) -> Self {
        Self {
            halves: self.halves.clone(),
            variance: self.variance.clone(),
            light: Vec::new(),
        }
    }
}

/// Black pixels.
pub fn black(pixels: usize) -> Color {
    std::array::from_fn(|_| vec![0.0; pixels])
}
