//! An equidistant fisheye: the distance from the middle of the picture is proportional to the angle from the line of sight.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `eye` | position, `[x, y, z]` | m | required |
//! | `target` | point at the centre of view, `[x, y, z]`, not at the eye | m | required |
//! | `up` | direction that points up in the picture, `[x, y, z]` | | `[0, 1, 0]` |
//! | `fov` | angle across the image circle, above 0 and at most 360 | degrees | 180 |
//!
//! ```toml
//! [camera]
//! fisheye = { eye = [0, 1, 0], target = [0, 2, 0], fov = 180 }
//! ```
//!
//! The image circle touches the shorter sides of the picture. Outside of the circle R, G, B and A are 0. There is no depth
//! of field. A camera path may move this camera and set `fov`, below 180 there; other columns of a lens are errors.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Deserializer, Serialize, de};

use super::{
    CameraKind, CameraSetup, FilmSize, LensKind, LensOverrides, Pose, StereoEye, ViewMatrices, default_up,
    lens::FieldOfView, look_at, station::Station,
};
use crate::{
    math::{Ray, RayCone, Vec2},
    value::{Point, Problem, Spanned},
};

/// The description of a fisheye in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FisheyeDesc {
    pub eye: Point,
    pub target: Spanned<Point>,
    #[serde(default = "default_up")]
    pub up: Point,
    pub fov: Option<CircleAngle>,
}

/// The angle over an image circle, in degrees, above 0 and at most 360.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CircleAngle(pub f64);

impl<'de> Deserialize<'de> for CircleAngle {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let degrees = f64::deserialize(d)?;
        if degrees > 0.0 && degrees <= 360.0 {
            Ok(Self(degrees))
        } else {
            Err(de::Error::custom(format_args!(
                "expected an angle above 0 and at most 360 degrees, found {degrees}"
            )))
        }
    }
}

impl FisheyeDesc {
    /// # Errors
    /// The target is at the eye.
    pub fn compile(&self) -> Result<CameraSetup<FisheyeLens>, Vec<Problem>> {
        let pose = look_at(self.eye, &self.target, self.up).map_err(|e| vec![e])?;
        let lens = FisheyeLens {
            fov: self.fov.map_or(180.0, |a| a.0),
        };
        Ok(CameraSetup { pose, lens })
    }
}

/// A fisheye's lens, as it was described.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FisheyeLens {
    /// Over the image circle, in degrees as it was written.
    pub fov: f64,
}

impl LensKind for FisheyeLens {
    type Camera = Fisheye;

    const COLUMNS: &'static [&'static str] = &["fov"];

    fn with_overrides(&self, overrides: &LensOverrides, _target_distance: Option<f64>) -> Self {
        match overrides.view {
            Some(FieldOfView::Vertical(fov)) => Self { fov },
            _ => *self,
        }
    }

    fn parameters(&self) -> LensOverrides {
        LensOverrides {
            view: Some(FieldOfView::Vertical(self.fov)),
            ..LensOverrides::default()
        }
    }

    fn camera(&self, pose: &Pose, film: FilmSize) -> Fisheye {
        let size = DVec2::from(film.map(|n| f64::from(n.max(1))));
        Fisheye {
            station: Station::new(pose),
            center: 0.5 * size,
            radius: 0.5 * size.min_element(),
            half_fov: 0.5 * self.fov.to_radians(),
        }
    }
}

/// A fisheye before its film.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fisheye {
    station: Station,
    /// The centre of the image circle, in pixels.
    center: DVec2,
    radius: f64,
    /// From the line of sight to the circle, in radians.
    half_fov: f64,
}

impl CameraKind for Fisheye {
    fn ray(&self, film: Vec2, _lens: Vec2) -> Option<Ray> {
        let offset = film.as_dvec2() - self.center;
        let distance = offset.length();
        if distance > self.radius {
            return None;
        }
        let (sin, cos) = libm::sincos(self.half_fov * (distance / self.radius));
        let across = if distance > 0.0 {
            offset * (sin / distance)
        } else {
            offset
        };
        let d = DVec3::new(across.x, -across.y, -cos);
        Some(self.station.ray(d))
    }

    fn project(&self, p: DVec3) -> Option<DVec3> {
        let local = self.station.local(p);
        let across = DVec2::new(local.x, -local.y);
        let angle = libm::atan2(across.length(), -local.z);
        let film = self.center + across.normalize_or_zero() * (self.radius * angle / self.half_fov);
        let distance = local.length();
        (distance > 0.0 && angle <= self.half_fov).then(|| film.extend(distance))
    }

    fn matrices(&self, _film: FilmSize) -> ViewMatrices {
        self.station.matrices()
    }

    fn fills_film(&self) -> bool {
        false
    }

    fn pixel_cone(&self) -> RayCone {
        RayCone {
            width: 0.0,
            spread: (self.half_fov / self.radius) as f32,
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
            return Err("the eyes of a fisheye do not converge: leave out convergence");
        }
        Ok(Self {
            station: self.station.beside(eye.offset),
            ..*self
        })
    }

    fn between(&self, to: &Self, u: f64) -> Self {
        Self {
            station: self.station.between(&to.station, u),
            half_fov: self.half_fov + (to.half_fov - self.half_fov) * u,
            ..*self
        }
    }
}
