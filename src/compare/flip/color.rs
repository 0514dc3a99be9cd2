//! The colour spaces of FLIP.

use crate::math::Rgb;

/// CIE XYZ of linear Rec. 709 primaries with the white of D65.
const XYZ: [[f32; 3]; 3] = [
    [0.412_386_56, 0.357_591_49, 0.180_450_49],
    [0.212_636_82, 0.715_182_98, 0.072_180_16],
    [0.019_330_62, 0.119_197_16, 0.950_372_6],
];

/// The inverse of [`XYZ`].
const RGB: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_398_9, -0.498_615_86],
    [-0.969_224_33, 1.875_930_1, 0.041_554_22],
    [0.055_639_42, -0.204_011_2, 1.057_148_9],
];

/// XYZ of white.
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_3];

/// CIE L*, a* and b*, a and b scaled by the brightness as Hunt's effect does.
#[derive(Clone, Copy, Default)]
pub struct Lab([f32; 3]);

impl Lab {
    /// HyAB: the distance of colours that are far apart. Source: Abasi, Tehran and Fairchild, 2020.
    pub fn distance(self, other: Self) -> f32 {
        let [l, a, b] = std::array::from_fn(|i| self.0[i] - other.0[i]);
        l.abs() + (a * a + b * b).sqrt()
    }
}

fn product(matrix: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// The opponent colour YCxCz of a linear colour, which is linear in it.
pub fn opponent(rgb: Rgb) -> [f32; 3] {
    let xyz = product(&XYZ, rgb.to_array());
    let [x, y, z] = std::array::from_fn(|i| xyz[i] / WHITE[i]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The inverse of [`opponent`].
pub fn rgb_of_opponent([y, cx, cz]: [f32; 3]) -> Rgb {
    let y = (y + 16.0) / 116.0;
    let xyz = [y + cx / 500.0, y, y - cz / 200.0];
    Rgb::from_array(product(&RGB, std::array::from_fn(|i| xyz[i] * WHITE[i])))
}

/// The colour in CIELAB with Hunt's adjustment.
pub fn hunt_lab(rgb: Rgb) -> Lab {
    const DELTA: f32 = 6.0 / 29.0;
    let xyz = product(&XYZ, rgb.to_array());
    let curve = |v: f32| {
        if v > DELTA * DELTA * DELTA {
            libm::cbrtf(v)
        } else {
            v / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let [x, y, z] = std::array::from_fn(|i| curve(xyz[i] / WHITE[i]));
    let l = 116.0 * y - 16.0;
    Lab([l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)])
}

/// The largest distance of two colours: green and blue.
pub fn max_distance() -> f32 {
    hunt_lab(Rgb::new(0.0, 1.0, 0.0)).distance(hunt_lab(Rgb::new(0.0, 0.0, 1.0)))
}
