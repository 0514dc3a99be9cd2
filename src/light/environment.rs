//! Light from an equirectangular image of all directions, infinitely far away.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `file` | path of an HDR, EXR or other image, relative to the scene file | W m^-2 sr^-1 | required |
//! | `intensity` | factor of at least 0 | | 1 |
//! | `rotate` | `[x, y, z]`: rotation about the fixed x, y and z axes, in this order | degrees | `[0, 0, 0]` |
//!
//! ```toml
//! [background]
//! environment = { file = "sky.exr", intensity = 1, rotate = [0, 90, 0] }
//! ```
//!
//! The centre of the image is in the direction -z, its right half towards +x, its top towards +y. The radiance is
//! interpolated linearly between texels. Values that are not finite count as 0 or 65504 and negative ones as 0, with a
//! warning. Colours of an EXR file have the primaries that it names (`colorInteropID`, `chromaticities`), else those of Rec. 709.
//!
//! # Implementation
//!
//! The density of a direction follows the luminance above the mean, by an importance map of at most 256 x 129 cells, within
//! which bright parts are sampled as linear interpolation shows them; BSDF sampling finds the rest. Source: Karlik et al., "MIS
//! Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling", ACM TOG 38(6), 2019, doi:10.1145/3355089.3356565.
//! An image of one colour is not sampled at all.

use std::{
    f32::consts::{PI, TAU},
    slice,
    sync::Arc,
};

use glam::Mat3;
use serde::Deserialize;

use super::LightSample;
use crate::{
    math::{ColorConversion, DMat3, Dispatch, Rgb, Vec2, Vec3, WorkingSpace, float, parallel, trig},
    texture::Bitmap,
    value::{NonNegative, Point, Spanned},
};
use importance::ImportanceMap;

mod batch;
mod importance;
mod patch;
#[cfg(test)]
mod tests;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnvironmentDesc {
    pub file: Spanned<String>,
    #[serde(default = "NonNegative::one")]
    pub intensity: NonNegative,
    #[serde(default)]
    pub rotate: Option<Point>,
}

/// An environment map.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Row by row from the top, in W m^-2 sr^-1.
    texels: Arc<[Rgb]>,
    width: usize,
    height: usize,
    world_from_map: Mat3,
    /// The density of directions; `None` if no direction is brighter than the others.
    importance: Option<Arc<ImportanceMap>>,
    /// Texels of the picture with a number below 0, which became 0.
    pub clamped: u64,
}

/// Columns from the left and rows from the top, in texels; texel (0, 0) goes to (1, 1).
type MapPoint = Vec2;

/// The texels around a point of the map.
struct Corners {
    /// Their indices: left and right, in the upper and the lower row.
    texels: [u32; 4],
    /// The weights of the right column and the lower row.
    f: Vec2,
}

/// The light from one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnvironmentLight {
    /// In W m^-2 sr^-1.
    pub radiance: Rgb,
    /// The density of the direction in light sampling, in sr^-1; 0 if it is not sampled.
    pub pdf: f32,
}

impl Environment {
    #[cfg(test)]
    pub(crate) fn texels_address(&self) -> *const Rgb {
        self.texels.as_ptr()
    }

    /// The light of `picture` times `intensity`, rotated by `world_from_map`.
    pub fn new(picture: &Bitmap, working_space: WorkingSpace, intensity: f32, world_from_map: DMat3) -> Self {
        let (width, height) = (picture.width as usize, picture.height as usize);
        let colors = ColorConversion::new(picture.primaries, working_space);
        let light = |own| colors.convert(own).map(|v| (v.max(0.0) * intensity).min(f32::MAX));
        let is_negative = |c: Rgb| c.r < 0.0 || c.g < 0.0 || c.b < 0.0;
        let mut texels = vec![Rgb::BLACK; width * height];
        let clamped = parallel::map(texels.chunks_mut(width).zip(0..picture.height), |(row, y)| {
            let mut clamped = 0;
            for (to, x) in row.iter_mut().zip(0..) {
                let own = picture.rgb(x, y);
                clamped += u64::from(is_negative(own));
                *to = light(own);
            }
            clamped
        });
        let mut environment = Self {
            texels: texels.into(),
            width,
            height,
            world_from_map: world_from_map.as_mat3(),
            importance: None,
            clamped: clamped.iter().sum(),
        };
        let luminances = parallel::table(width * height, |i| luminance(environment.texels[i]) as f32);
        environment.importance = ImportanceMap::new(&luminances, [width, height]).map(Arc::new);
        environment
    }

    /// The same light, rotated by `world_from_map` instead. It shares the texels.
    pub fn rotated(&self, world_from_map: DMat3) -> Self {
        Self {
            world_from_map: world_from_map.as_mat3(),
            ..self.clone()
        }
    }

    /// Whether [`Environment::sample`] returns samples.
    pub fn is_sampled(&self) -> bool {
        self.importance.is_some()
    }

    /// The radiance that arrives from the unit direction `w`, in W m^-2 sr^-1.
    #[inline]
    pub fn radiance(&self, w: Vec3) -> Rgb {
        self.at(self.map_point(w))
    }

    /// Samples a direction, by two uniform numbers in `[0, 1)`; `None` if no direction is brighter than the others.
    pub fn sample(&self, on: impl Dispatch, u: Vec2) -> Option<LightSample> {
        let mut found = None;
        self.sample_all(on, slice::from_ref(&u), |_, sample| found = sample);
        found
    }

    /// The density of [`Environment::sample`] for the unit direction `w`, in sr^-1.
    pub fn pdf(&self, w: Vec3) -> f32 {
        self.pdf_at(self.map_point(w))
    }

    #[inline]
    fn pdf_at(&self, at: MapPoint) -> f32 {
        self.importance.as_ref().map_or(0.0, |importance| importance.pdf(at))
    }

    /// The position of the unit direction `w` on the map.
    #[inline(always)]
    fn map_point(&self, w: Vec3) -> MapPoint {
        let local = self.world_from_map.transpose() * w;
        let around = trig::atan2(local.x, -local.z) / TAU + 0.5;
        let down = trig::atan2((local.x * local.x + local.z * local.z).sqrt(), local.y) / PI;
        MapPoint::new(around * self.width as f32, down * self.height as f32)
    }

    /// The radiance at a point of the map, linear between the centres of the texels.
    fn at(&self, at: MapPoint) -> Rgb {
        let Corners { texels, f } = self.corners(at);
        let [a, b, c, d] = texels.map(|i| self.texels[i as usize]);
        let (upper, lower) = (a * (1.0 - f.x) + b * f.x, c * (1.0 - f.x) + d * f.x);
        upper * (1.0 - f.y) + lower * f.y
    }

    /// The texels around a point of the map.
    #[inline(always)]
    fn corners(&self, at: MapPoint) -> Corners {
        let from_middle = at - 0.5;
        let base = Vec2::new(float::floor(from_middle.x), float::floor(from_middle.y));
        let (w, h) = (self.width as i32, self.height as i32);
        let (i, j) = (base.x as i32, base.y as i32);
        let column = |i: i32| {
            let i = if i < 0 { i + w } else { i };
            (if i >= w { i - w } else { i }) as u32
        };
        let row = |j: i32| j.clamp(0, h - 1) as u32 * w as u32;
        let (left, right, upper, lower) = (column(i), column(i + 1), row(j), row(j + 1));
        Corners {
            texels: [upper + left, upper + right, lower + left, lower + right],
            f: from_middle - base,
        }
    }
}

/// The luminance of a linear sRGB colour (Rec. 709).
fn luminance(c: Rgb) -> f64 {
    0.2126 * f64::from(c.r) + 0.7152 * f64::from(c.g) + 0.0722 * f64::from(c.b)
}
