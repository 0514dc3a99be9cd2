//! Differences as colours.

/// Nine colours of the map "magma", evenly spaced: black for 0, light yellow for 1. Source: van der Walt and Smith, Matplotlib 1.5,
/// CC0.
const MAGMA: [[f32; 3]; 9] = [
    [0.0, 0.0, 4.0],
    [28.0, 16.0, 68.0],
    [79.0, 18.0, 123.0],
    [129.0, 37.0, 129.0],
    [181.0, 54.0, 122.0],
    [229.0, 80.0, 100.0],
    [251.0, 135.0, 97.0],
    [254.0, 194.0, 135.0],
    [252.0, 253.0, 191.0],
];

/// The display values of an error from 0 to 1.
pub fn color(error: f32) -> [u8; 3] {
    let at = error.clamp(0.0, 1.0) * (MAGMA.len() - 1) as f32;
    let low = (at as usize).min(MAGMA.len() - 2);
    let part = at - low as f32;
    std::array::from_fn(|i| {
        let [a, b] = [MAGMA[low][i], MAGMA[low + 1][i]];
        (a + (b - a) * part).round() as u8
    })
}
