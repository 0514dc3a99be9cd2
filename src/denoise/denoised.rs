//! A frame with less noise.

use super::signal::Color;

/// A frame with less noise.
#[derive(Clone, Debug)]
pub struct Denoised {
    pub beauty: Color,
    /// The layers of the frame's signal, in its order.
    pub light: Vec<Color>,
    /// The estimated error of the beauty: root mean square over the channels, times the albedo. Open Image Denoise tells none.
    pub error: Option<Color>,
    /// The alpha, where it is not that of the frame.
    pub alpha: Option<Vec<f32>>,
    /// Whether a pixel had no noise; it is to stay as it is.
    pub is_exact: Vec<bool>,
}
