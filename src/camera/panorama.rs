//! A panorama: an equirectangular picture of all directions, 360 x 180 degrees.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `eye` | position, `[x, y, z]` | m | required |
//! | `target` | point at the middle of the picture, `[x, y, z]`, not at the eye | m | required |
//! | `up` | direction that points up in the picture, `[x, y, z]` | | `[0, 1, 0]` |
//!
//! ```toml
//! [camera]
//! panorama = { eye = [0, 1.6, 0], target = [0, 1.6, -1] }
//! ```
//!
//! A picture that is twice as wide as high has square pixels at the horizon; any other shape is stretched. The left and the
//! right edge show the direction behind the camera. A target at the height of the eye keeps the horizon level. There is no
//! depth of field. A camera path may move this camera; columns of a lens are errors.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{
    CameraKind, CameraSetup, FilmSize, LensKind, LensOverrides, Pose, StereoEye, ViewMatrices, default_up, look_at,
    station::Station,
};
use crate::{
    math::{Ray, RayCone, Vec2},
    value::{Point, Problem, Spanned},
};

/// The description of a panorama in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PanoramaDesc {
    pub eye: Point,
    pub target: Spanned<Point>,
    #[serde(default = "default_up")]
    pub up: Point,
}

impl PanoramaDesc {
    /// # Errors
    /// The target is at the eye.
    pub fn compile(&self) -> Result<CameraSetup<PanoramaLens>, Vec<Problem>> {
        let pose = look_at(self.eye, &self.target, self.up).map_err(|e| vec![e])?;
        Ok(CameraSetup {
            pose,
            lens: PanoramaLens,
        })
    }
}

/// The lens of a panorama, which has no parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PanoramaLens;

impl LensKind for PanoramaLens {
    type Camera = Panorama;

    const COLUMNS: &'static [&'static str] = &[];

    fn with_overrides(&self, _overrides: &LensOverrides, _target_distance: Option<f64>) -> Self {
        *self
    }

    fn parameters(&self) -> LensOverrides {
        LensOverrides::default()
    }

    fn camera(&self, pose: &Pose, film: FilmSize) -> Panorama {
        let [width, height] = film.map(|n| f64::from(n.max(1)));
        Panorama {
            station: Station::new(pose),
            pixel: [TAU / width, PI / height],
            eye: 0.0,
        }
    }
}

/// A panorama before its film.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Panorama {
    station: Station,
    /// Longitude and latitude of a pixel, in radians.
    pixel: [f64; 2],
    /// The place of the eye to the right of each direction's vertical plane, in m; 0 without stereo.
    eye: f64,
}

impl CameraKind for Panorama {
    /// Beyond the poles, where a pixel's filter reaches, it looks down on the other side.
    fn ray(&self, film: Vec2, _lens: Vec2) -> Option<Ray> {
        let (sin_lon, cos_lon) = libm::sincos(self.pixel[0] * f64::from(film.x) - PI);
        let (sin_lat, cos_lat) = libm::sincos(0.5 * PI - self.pixel[1] * f64::from(film.y));
        let d = DVec3::new(cos_lat * sin_lon, sin_lat, -cos_lat * cos_lon);
        Some(match self.eye == 0.0 {
            true => self.station.ray(d),
            false => self.station.ray_from(DVec3::new(cos_lon, 0.0, sin_lon) * self.eye, d),
        })
    }

    fn project(&self, p: DVec3) -> Option<DVec3> {
        let local = self.station.local(p);
        // From the eye's place on its circle, along the tangent.
        let across = libm::hypot(local.x, local.z);
        let level = libm::sqrt((across * across - self.eye * self.eye).max(0.0));
        let distance = libm::hypot(level, local.y);
        let turn = if self.eye == 0.0 {
            0.0
        } else {
            libm::atan2(self.eye, level)
        };
        let longitude = libm::remainder(libm::atan2(local.x, -local.z) - turn, TAU);
        let latitude = libm::atan2(local.y, level);
        let [x, y] = [(longitude + PI) / self.pixel[0], (0.5 * PI - latitude) / self.pixel[1]];
        (distance > 0.0 && across >= self.eye.abs()).then(|| DVec3::new(x, y, distance))
    }

    fn period(&self) -> Option<f64> {
        Some(TAU / self.pixel[0])
    }

    fn matrices(&self, _film: FilmSize) -> ViewMatrices {
        self.station.matrices()
    }

    fn pixel_cone(&self) -> RayCone {
        RayCone {
            width: 0.0,
            spread: self.pixel[0].max(self.pixel[1]) as f32,
        }
    }

    fn moved(&self, by: DVec3) -> Self {
        Self {
            station: self.station.moved(by),
            ..*self
        }
    }

    fn of_eye(&self, eye: &StereoEye) -> Result<Self, &'static str> {
        if eye.convergence.is_some() {
            return Err("the eyes of a panorama do not converge: leave out convergence");
        }
        Ok(Self {
            eye: eye.offset,
            ..*self
        })
    }

    fn between(&self, to: &Self, u: f64) -> Self {
        Self {
            station: self.station.between(&to.station, u),
            ..*self
        }
    }
}
