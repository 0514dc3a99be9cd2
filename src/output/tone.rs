//! Tone curves: from scene-linear light, with the primaries of Rec. 709, to linear light of a display between 0 and 1.
//!
//! Numbers below 0 and NaN are black, and no light is so bright that it is not shown.

use crate::math::exponential;

/// Brighter light than any display transform tells apart.
const BRIGHTEST: f32 = 1e6;

/// The weights of red, green and blue in luminance, IEC 61966-2-1.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

type Rows = [[f32; 3]; 3];

/// Luminance `L` becomes `L / (1 + L)`, and colours keep their hue.
///
/// Source: Reinhard, Stark, Shirley, Ferwerda, "Photographic Tone Reproduction for Digital Images", SIGGRAPH 2002,
/// doi:10.1145/566570.566575, equation 3.
pub(super) fn reinhard(c: [f32; 3]) -> [f32; 3] {
    let c = bounded(c);
    let scale = 1.0 / (1.0 + dot(LUMINANCE, c));
    unit(c.map(|v| v * scale))
}

/// The reference rendering of ACES for an sRGB display.
///
/// Source: Hill's fit of RRT and ODT, in "Baking Lab", 2016; the transforms are those of the Academy Color Encoding System 1.0.
pub(super) fn aces(c: [f32; 3]) -> [f32; 3] {
    const TO_AP1: Rows = [
        [0.59719, 0.35458, 0.04823],
        [0.07600, 0.90834, 0.01566],
        [0.02840, 0.13383, 0.83777],
    ];
    const TO_REC_709: Rows = [
        [1.60475, -0.53108, -0.07367],
        [-0.10208, 1.10813, -0.00605],
        [-0.00327, -0.07276, 1.07602],
    ];
    let curve = |v: f32| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    unit(times(&TO_REC_709, times(&TO_AP1, bounded(c)).map(curve)))
}

/// AgX, which turns bright colours towards white.
///
/// Source: Sobotka, "AgX", 2022, as fitted by Wrensch, "Minimal AgX Implementation", 2023.
pub(super) fn agx(c: [f32; 3]) -> [f32; 3] {
    const INSET: Rows = [
        [0.842_479_06, 0.078_433_6, 0.079_223_745],
        [0.042_328_242, 0.878_468_64, 0.079_166_13],
        [0.042_375_655, 0.078_433_6, 0.879_143],
    ];
    const OUTSET: Rows = [
        [1.196_879, -0.098_020_88, -0.099_029_74],
        [-0.052_896_852, 1.151_903_1, -0.098_961_18],
        [-0.052_971_636, -0.098_043_45, 1.151_073_7],
    ];
    /// Light in stops.
    const BLACK: f32 = -12.473_93;
    const WHITE: f32 = 4.026_069;
    let contrast = |v: f32| {
        let x = ((exponential::log2(v.max(1e-10)) - BLACK) / (WHITE - BLACK)).clamp(0.0, 1.0);
        let terms = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32];
        terms.into_iter().fold(0.0, |sum, term| sum * x + term)
    };
    let display = times(&OUTSET, times(&INSET, bounded(c)).map(contrast));
    unit(display).map(|v| exponential::pow(v, 2.2))
}

/// The neutral curve of Khronos: colours below 0.8 stay what they are.
///
/// Source: Khronos Group, "Khronos PBR Neutral Tone Mapper Specification", 2024.
pub(super) fn neutral(c: [f32; 3]) -> [f32; 3] {
    /// The reflection of a surface at normal incidence, which is taken off.
    const F90: f32 = 0.04;
    const START: f32 = 0.8 - F90;
    const DESATURATION: f32 = 0.15;
    let c = bounded(c);
    let least = c.into_iter().fold(f32::INFINITY, f32::min);
    let offset = if least < 2.0 * F90 {
        least - least * least / (4.0 * F90)
    } else {
        F90
    };
    let c = c.map(|v| v - offset);
    let peak = c.into_iter().fold(0.0, f32::max);
    if peak < START {
        return c;
    }
    let room = 1.0 - START;
    let new_peak = 1.0 - room * room / (peak + room - START);
    let white = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    c.map(|v| v * (new_peak / peak)).map(|v| v + (new_peak - v) * white)
}

fn bounded(c: [f32; 3]) -> [f32; 3] {
    c.map(|v| if v.is_nan() { 0.0 } else { v.clamp(0.0, BRIGHTEST) })
}

fn unit(c: [f32; 3]) -> [f32; 3] {
    c.map(|v| v.clamp(0.0, 1.0))
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn times(rows: &Rows, c: [f32; 3]) -> [f32; 3] {
    rows.map(|row| dot(row, c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::srgb;

    const CURVES: [fn([f32; 3]) -> [f32; 3]; 4] = [reinhard, aces, agx, neutral];

    #[test]
    fn every_curve_rises_from_black_to_white_and_keeps_grays_gray() {
        for (i, curve) in CURVES.into_iter().enumerate() {
            assert!(curve([0.0; 3])[0] < 0.002, "{i}");
            assert!(curve([1e5; 3])[0] > 0.98, "{i}");
            let mut last = 0.0;
            for step in -80..60 {
                let [r, g, b] = curve([exponential::pow(2.0, step as f32 / 8.0); 3]);
                assert!((r - g).abs() < 4e-3 && (g - b).abs() < 4e-3, "{i}: {r} {g} {b}");
                assert!(r >= last - 1e-4, "{i}: {r} after {last}");
                last = r;
            }
        }
    }

    #[test]
    fn nothing_that_is_no_light_is_shown() {
        for curve in CURVES {
            for c in [
                [f32::NAN; 3],
                [-1.0; 3],
                [f32::INFINITY; 3],
                [f32::NEG_INFINITY, 5.0, f32::NAN],
            ] {
                assert!(
                    curve(c).iter().all(|v| (-1e-6..=1.0).contains(v)),
                    "{c:?}: {:?}",
                    curve(c)
                );
            }
        }
    }

    #[test]
    fn middle_gray_is_where_the_sources_put_it() {
        let shown = |curve: fn([f32; 3]) -> [f32; 3], l| srgb::encode(curve([l; 3])[0]);
        assert!((reinhard([0.18; 3])[0] - 0.18 / 1.18).abs() < 1e-6);
        // AgX places middle gray in the middle of the display's values.
        assert!((shown(agx, 0.18) - 0.5).abs() < 0.01, "{}", shown(agx, 0.18));
        // The fit of ACES, whose exposure is lower than that of the other curves.
        assert!((aces([0.18; 3])[0] - 0.106).abs() < 0.004, "{}", aces([0.18; 3])[0]);
        // Above the toe Khronos' curve takes 0.04 off, and has its peak at 1.
        assert!((neutral([0.5, 0.3, 0.2])[0] - 0.46).abs() < 1e-6);
    }
}
