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
//! The density of a direction is proportional to the luminance of its texel above the mean; BSDF sampling finds the rest. Source:
//! Karlik et al., "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling", ACM TOG 38(6), 2019,
//! doi:10.1145/3355089.3356565. An image of one colour is not sampled at all.

use std::{
    f32::consts::{PI, TAU},
    slice,
};

use glam::Mat3;
use rayon::prelude::*;
use serde::Deserialize;

use super::LightSample;
use crate::{
    math::{
        ColorConversion, DMat3, Dispatch, Rgb, Vec2, Vec3, WorkingSpace, distribution::PiecewiseConstant2D, float, trig,
    },
    texture::Bitmap,
    value::{NonNegative, Point, Spanned},
};

mod batch;
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
    texels: Vec<Rgb>,
    width: usize,
    height: usize,
    world_from_map: Mat3,
    /// The cosine of the angle to +y at the upper edge of each row, and at the lower edge of the last.
    heights: Vec<f64>,
    /// 1 over the solid angle of each texel of a row, in sr^-1.
    inverse_solid_angles: Vec<f32>,
    /// The distribution of texels; `None` if no direction is brighter than the others.
    distribution: Option<PiecewiseConstant2D>,
    /// Texels of the picture with a number below 0, which became 0.
    pub clamped: u64,
}

/// Columns from the left and rows from the top, in texels; texel (0, 0) goes to (1, 1).
type MapPoint = Vec2;

/// The light from one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnvironmentLight {
    /// In W m^-2 sr^-1.
    pub radiance: Rgb,
    /// The density of the direction in light sampling, in sr^-1; 0 if it is not sampled.
    pub pdf: f32,
}

impl Environment {
    /// The light of `picture` times `intensity`, rotated by `world_from_map`.
    pub fn new(picture: &Bitmap, working_space: WorkingSpace, intensity: f32, world_from_map: DMat3) -> Self {
        let (width, height) = (picture.width as usize, picture.height as usize);
        let colors = ColorConversion::new(picture.primaries, working_space);
        let mut texels = vec![Rgb::BLACK; width * height];
        let clamped = texels
            .par_chunks_mut(width)
            .zip(0..height as u32)
            .map(|(row, y)| {
                let mut clamped = 0;
                for (texel, x) in row.iter_mut().zip(0..) {
                    let own = picture.rgb(x, y);
                    clamped += u64::from(own.r < 0.0 || own.g < 0.0 || own.b < 0.0);
                    *texel = colors.convert(own).map(|v| (v.max(0.0) * intensity).min(f32::MAX));
                }
                clamped
            })
            .sum();
        let mut environment = Self {
            texels,
            width,
            height,
            world_from_map: world_from_map.as_mat3(),
            heights: (0..=height)
                .map(|j| libm::cos(std::f64::consts::PI * j as f64 / height as f64))
                .collect(),
            inverse_solid_angles: Vec::new(),
            distribution: None,
            clamped,
        };
        environment.inverse_solid_angles = (0..height).map(|row| 1.0 / environment.solid_angle(row)).collect();
        environment.distribution = environment.distribute();
        environment
    }

    /// Whether [`Environment::sample`] returns samples.
    pub fn is_sampled(&self) -> bool {
        self.distribution.is_some()
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

    /// The light from a point of the map.
    #[inline]
    fn light_at(&self, at: MapPoint) -> EnvironmentLight {
        EnvironmentLight {
            radiance: self.at(at),
            pdf: self.pdf_at(at),
        }
    }

    #[inline]
    fn pdf_at(&self, at: MapPoint) -> f32 {
        let Some(distribution) = &self.distribution else {
            return 0.0;
        };
        let column = (at.x as usize).min(self.width - 1);
        let row = (at.y as usize).min(self.height - 1);
        distribution.pmf(column, row) * self.inverse_solid_angles[row]
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
    #[inline]
    fn at(&self, at: MapPoint) -> Rgb {
        let from_middle = at - 0.5;
        let base = Vec2::new(float::floor(from_middle.x), float::floor(from_middle.y));
        let f = from_middle - base;
        let (w, h) = (self.width as i32, self.height as i32);
        let (i, j) = (base.x as i32, base.y as i32);
        let column = |i: i32| {
            let i = if i < 0 { i + w } else { i };
            (if i >= w { i - w } else { i }) as usize
        };
        let (left, right) = (column(i), column(i + 1));
        let row = |j: i32| {
            let start = j.clamp(0, h - 1) as usize * self.width;
            let texels = &self.texels[start..start + self.width];
            texels[left] * (1.0 - f.x) + texels[right] * f.x
        };
        row(j) * (1.0 - f.y) + row(j + 1) * f.y
    }

    /// The solid angle of each texel of a row, in sr.
    fn solid_angle(&self, row: usize) -> f32 {
        (std::f64::consts::TAU / self.width as f64 * (self.heights[row] - self.heights[row + 1])) as f32
    }

    /// Writes the mean luminance within each texel of a row, under linear interpolation, to `to`. It is above 0 wherever the
    /// radiance is.
    fn luminances(&self, row: usize, to: &mut [f64]) {
        let rows = [row.saturating_sub(1), row, (row + 1).min(self.height - 1)];
        let column = |i: usize| {
            let [above, own, below] = rows.map(|j| luminance(self.texels[j * self.width + i]));
            0.125 * (above + below) + 0.75 * own
        };
        let (mut left, mut own) = (column(self.width - 1), column(0));
        for (i, to) in to.iter_mut().enumerate() {
            let right = column((i + 1) % self.width);
            *to = 0.125 * (left + right) + 0.75 * own;
            (left, own) = (own, right);
        }
    }

    fn distribute(&self) -> Option<PiecewiseConstant2D> {
        let totals: Vec<f64> = (0..self.height)
            .into_par_iter()
            .map(|row| {
                let mut luminances = vec![0.0; self.width];
                self.luminances(row, &mut luminances);
                luminances.iter().sum::<f64>() * f64::from(self.solid_angle(row))
            })
            .collect();
        let mean = totals.iter().sum::<f64>() / (4.0 * std::f64::consts::PI);
        // Ignores the rounding errors of a constant picture.
        let floor = mean * (1.0 + 1e-4);
        PiecewiseConstant2D::new([self.width, self.height], |row, weights| {
            self.luminances(row, weights);
            let solid_angle = f64::from(self.solid_angle(row));
            weights
                .iter_mut()
                .for_each(|w| *w = (*w - floor).max(0.0) * solid_angle);
        })
    }
}

/// The luminance of a linear sRGB colour (Rec. 709).
fn luminance(c: Rgb) -> f64 {
    0.2126 * f64::from(c.r) + 0.7152 * f64::from(c.g) + 0.0722 * f64::from(c.b)
}
