//! A sun: parallel light from infinitely far away.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `direction` | direction in which the light travels, `[x, y, z]` | | required |
//! | `irradiance` | number or `[r, g, b]`, on a surface that faces the sun | W m^-2 | required |
//! | `temperature` | of a black body, which colours the light and keeps its luminance, from 500 to 100000 | K | white |
//! | `exposure` | number of stops from -100 to 100: the light is `2^exposure` times as strong | | 0 |
//! | `angle` | diameter of the sun's disk, from 0 to 90; the real sun has 0.53 | degrees | 0 |
//! | `limb_darkening` | whether the disk is darker at its rim, as that of the real sun | | `false` |
//! | `camera` | whether the camera sees the disk before a visible background, with the `path` integrator | | `false` |
//!
//! ```toml
//! [[light]]
//! sun = { direction = [-1, -2, -1], irradiance = [3, 3, 2.8], angle = 0.53 }
//! ```
//!
//! With an `angle` the sun is a disk of constant radiance, irradiance / (pi sin^2(angle / 2)), and casts soft shadows.
//! Mirrors show it with the `path` integrator, whether the camera sees it or not. With `limb_darkening` the radiance is that
//! of the centre times 0.3 + m (0.93 - 0.23 m), where m = sqrt(1 - r^2) at the part r of the radius: the law at 550 nm of
//! Cox, "Allen's Astrophysical Quantities", 2000. The irradiance is the same. A [sky](../background/sky.md) brings a sun of
//! its own.

use std::f32::consts::{PI, TAU};

use serde::Deserialize;

use super::{IesFile, Light, LightBounds, LightFind, LightKind, LightSample, LightTables, temperature};
use crate::{
    math::{Frame, Rgb, Vec2, Vec3, WorkingSpace, trig},
    value::{Direction, Finite, NonNegative, Problem, RgbFactor, Spanned, Stops},
};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SunDesc {
    pub direction: Direction,
    pub irradiance: RgbFactor,
    pub temperature: Option<Spanned<Finite>>,
    pub exposure: Option<Stops>,
    #[serde(default)]
    pub angle: Option<Spanned<NonNegative>>,
    #[serde(default)]
    pub limb_darkening: bool,
    #[serde(default)]
    pub camera: bool,
}

impl SunDesc {
    /// It has no file.
    pub fn ies(&self) -> Option<IesFile<'_>> {
        None
    }

    pub fn compile(&self, _find: &LightFind<'_>) -> Result<SunLight, Problem> {
        let angle = self.angle.as_ref().map_or(0.0, |a| a.get_ref().0);
        if let Some(given) = self.angle.as_ref().filter(|_| angle > 90.0) {
            let message = format!("expected an angle of at most 90, found {angle}");
            return Err(Problem::at(given.span(), message));
        }
        let irradiance = self.irradiance.0 * temperature::factor(&self.temperature, self.exposure)?;
        Ok(SunLight {
            is_dark_at_limb: self.limb_darkening,
            camera: self.camera,
            ..SunLight::new(self.direction.0, irradiance).with_angle(trig::radians(angle))
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct SunLight {
    /// The unit direction in which the light travels.
    pub direction: Vec3,
    /// The irradiance on a surface that faces it, in W m^-2.
    pub irradiance: Rgb,
    /// 1 - cos of its angular radius; 0 for a sun without size.
    height: f32,
    is_dark_at_limb: bool,
    /// Whether the camera sees it.
    camera: bool,
}

impl SunLight {
    /// A sun without size; `direction` is unit.
    pub fn new(direction: Vec3, irradiance: Rgb) -> Self {
        Self {
            direction,
            irradiance,
            height: 0.0,
            is_dark_at_limb: false,
            camera: false,
        }
    }

    /// The same sun, darker at its rim.
    pub fn with_limb_darkening(self) -> Self {
        Self {
            is_dark_at_limb: true,
            ..self
        }
    }

    /// The same sun, seen by the camera.
    pub fn with_camera(self) -> Self {
        Self { camera: true, ..self }
    }

    /// The light among others.
    pub fn into_light(self) -> Light {
        Light::Sun(self)
    }

    /// The same sun with the angular diameter `angle`, in radians, at most pi / 2.
    pub fn with_angle(self, angle: f32) -> Self {
        let sin = trig::sin(angle * 0.25);
        Self {
            height: 2.0 * sin * sin,
            ..self
        }
    }

    /// The density of each direction towards it, in sr^-1; infinite without size.
    fn density(&self) -> f32 {
        1.0 / (TAU * self.height)
    }

    /// The radiance of the disk where 1 - cos of the angle to the centre is `off`, in W m^-2 sr^-1; infinite without size.
    fn radiance(&self, off: f32) -> Rgb {
        // pi sin^2, without cancellation.
        let mean = self.irradiance / (PI * self.height * (2.0 - self.height));
        if !self.is_dark_at_limb {
            return mean;
        }
        let square = off * (2.0 - off) / (self.height * (2.0 - self.height));
        let m = (1.0 - square).max(0.0).sqrt();
        // The mean of the law over the disk is 0.805.
        mean * ((0.3 + m * (0.93 - 0.23 * m)) / 0.805)
    }
}

impl LightKind for SunLight {
    #[inline]
    fn sample(&self, _tables: &LightTables<'_>, _from: Vec3, u: Vec2) -> Option<LightSample> {
        if self.irradiance.is_black() {
            return None;
        }
        if !self.has_size() {
            return Some(LightSample {
                wi: -self.direction,
                distance: f32::INFINITY,
                li: self.irradiance,
                pdf: None,
            });
        }
        let h = self.height * u.x;
        let (sin_phi, cos_phi) = trig::sin_cos(TAU * u.y);
        let r = (h * (2.0 - h)).sqrt();
        let local = Vec3::new(r * cos_phi, r * sin_phi, 1.0 - h);
        Some(LightSample {
            wi: Frame::from_normal(-self.direction).to_world(local).normalize(),
            distance: f32::INFINITY,
            li: self.radiance(h),
            pdf: Some(self.density()),
        })
    }

    fn bounds(&self, _tables: &LightTables<'_>) -> Option<LightBounds> {
        None
    }

    fn reaches(&self, _p: Vec3, n: Vec3) -> bool {
        // The centre may be below the horizon by the sine of the angular radius.
        let sin = (self.height * (2.0 - self.height)).sqrt();
        !self.irradiance.is_black() && -n.dot(self.direction) >= -sin - 1e-4
    }

    fn strength(&self) -> (Rgb, &'static str) {
        (self.irradiance, "W m^-2")
    }

    fn convert_colors(&mut self, space: WorkingSpace) {
        self.irradiance = space.from_rec709(self.irradiance);
    }

    fn has_size(&self) -> bool {
        self.height > 0.0
    }

    #[inline]
    fn radiance_towards(&self, w: Vec3) -> Option<(Rgb, f32)> {
        // 1 - cos of the angle to the centre, which is more precise for small angles.
        let off = (w + self.direction).length_squared() * 0.5;
        (self.has_size() && off <= self.height).then(|| (self.radiance(off), self.density()))
    }

    fn is_seen_by_camera(&self) -> bool {
        self.camera
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun(degrees: f32) -> SunLight {
        SunLight::new(Vec3::new(0.6, -0.8, 0.0), Rgb::gray(3.0)).with_angle(trig::radians(degrees))
    }

    #[test]
    fn a_disk_brings_the_irradiance_that_is_said_however_wide_it_is() {
        for degrees in [0.01, 0.53, 10.0, 90.0] {
            let sun = sun(degrees);
            let (n, mut irradiance) = (64, 0.0);
            for i in 0..n * n {
                let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                let s = sun.sample(&LightTables::NONE, Vec3::ZERO, u).expect("it shines");
                let pdf = s.pdf.expect("it has size");
                assert_eq!(sun.radiance_towards(s.wi), Some((s.li, pdf)), "{degrees}");
                irradiance += f64::from(s.li.r * -s.wi.dot(sun.direction) / pdf);
            }
            let mean = irradiance / f64::from(n * n);
            assert!((mean / 3.0 - 1.0).abs() < 1e-3, "{degrees}: {mean}");
        }
    }

    #[test]
    fn limb_darkening_keeps_the_irradiance_and_darkens_the_rim_to_three_tenths() {
        for degrees in [0.5, 60.0] {
            let (plain, sun) = (sun(degrees), sun(degrees).with_limb_darkening());
            let (n, mut irradiance) = (200, 0.0);
            for i in 0..n * n {
                let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                let s = sun.sample(&LightTables::NONE, Vec3::ZERO, u).expect("it shines");
                irradiance += f64::from(s.li.r * -s.wi.dot(sun.direction) / s.pdf.expect("it has size"));
            }
            let mean = irradiance / f64::from(n * n);
            assert!((mean / 3.0 - 1.0).abs() < 1e-3, "{degrees}: {mean}");
            let at = |off: f32| sun.radiance(off * plain.height).r / plain.radiance(0.0).r;
            assert!((at(0.0) - 1.0 / 0.805).abs() < 1e-4 && (at(1.0) / at(0.0) - 0.3).abs() < 1e-3);
        }
    }

    #[test]
    fn the_disk_ends_at_half_the_angle() {
        let sun = sun(10.0);
        let at = |degrees: f32| {
            let (sin, cos) = trig::sin_cos(trig::radians(degrees));
            let across = Vec3::new(0.8, 0.6, 0.0);
            sun.radiance_towards(-sun.direction * cos + across * sin)
        };
        assert!(at(0.0).is_some() && at(4.99).is_some());
        assert!(at(5.01).is_none() && at(175.0).is_none());
        assert!(self::sun(0.0).radiance_towards(Vec3::new(-0.6, 0.8, 0.0)).is_none());
    }

    #[test]
    fn surfaces_that_see_a_part_of_the_disk_are_reached() {
        let at = |degrees: f32| {
            let (sin, cos) = trig::sin_cos(trig::radians(degrees));
            sun(10.0).reaches(
                Vec3::ZERO,
                Vec3::new(-0.6, 0.8, 0.0) * cos + Vec3::new(0.8, 0.6, 0.0) * sin,
            )
        };
        assert!(at(0.0) && at(89.0) && at(94.9) && !at(95.1));
        assert!(sun(0.0).reaches(Vec3::ZERO, Vec3::ZERO));
    }
}
