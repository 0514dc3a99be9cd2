//! Frame rates: that of animations, and fractions for metadata.

use crate::batch::Request;

/// The frames of a second, if nothing says it: those of Blender.
const FPS: f64 = 24.0;

/// The frames of a second of animations.
pub(in crate::batch) fn fps(request: &Request) -> f64 {
    request.fps.unwrap_or(FPS)
}

/// Frames per second as a fraction: whole numbers, the rates of television (24000/1001 and kin), or thousandths.
pub(in crate::batch) fn rational(fps: f64) -> (i32, u32) {
    let whole = fps.round();
    if (fps - whole).abs() < 1e-6 {
        (whole as i32, 1)
    } else if (fps - fps.ceil() * 1000.0 / 1001.0).abs() < 5e-4 {
        (fps.ceil() as i32 * 1000, 1001)
    } else {
        ((fps * 1000.0).round() as i32, 1000)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_rates_become_the_fractions_they_stand_for() {
        assert_eq!(rational(24.0), (24, 1));
        assert_eq!(rational(23.976), (24000, 1001));
        assert_eq!(rational(29.97), (30000, 1001));
        assert_eq!(rational(12.5), (12500, 1000));
    }
}
