//! A camera by its intrinsics in pixels, as calibrations give them, with the distortion of a real lens.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `eye` | position, `[x, y, z]` | m | required |
//! | `target` | point on the optical axis, `[x, y, z]`, not at the eye | m | required |
//! | `up` | direction that points up in the picture, `[x, y, z]` | | `[0, 1, 0]` |
//! | `fx` | focal length across, above 0 | pixels | required |
//! | `fy` | focal length down, above 0 | pixels | `fx` |
//! | `cx`, `cy` | the point of the picture on the optical axis, from the top left corner; pixel centres are at .5 | pixels | the middle |
//! | `skew` | pixels to the right for each focal length down; `alpha` of OpenCV times `fx` | pixels | 0 |
//! | `size` | `[width, height]` of the pictures of the calibration, above 0; those of another size scale the view | pixels | those that are rendered |
//! | `distortion` | one of the models below | | none |
//!
//! | distortion | coefficients |
//! |---|---|
//! | `opencv = [k1, k2, p1, p2, ...]` | OpenCV's model with 4, 5, 8 or 12 numbers in its order: `k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4`, radial, tangential, rational and thin prism |
//! | `kannala_brandt = [k1, k2, k3, k4]` | OpenCV's `fisheye`: the angle t is seen at t (1 + k1 t² + k2 t⁴ + k3 t⁶ + k4 t⁸) focal lengths |
//! | `fisheye_polynomial = [c0, c1, ...]` | 2 to 6 numbers: r focal lengths from the middle the angle is c0 + c1 r + c2 r² + ..., in radians; with `fx = 1` r counts pixels, as in f-theta lenses |
//!
//! ```toml
//! [camera.pinhole]
//! eye = [0, 1, 5]
//! target = [0, 1, 0]
//! size = [1920, 1080]
//! fx = 1450
//! cx = 955.2
//! cy = 541.7
//! distortion.opencv = [-0.21, 0.08, 0.0004, -0.0002, -0.01]
//! ```
//!
//! OpenCV counts pixel centres from 0: add 0.5 to its `cx` and `cy`. Those of `transforms.json` and COLMAP are as here.
//!
//! Where a model has no ray, beyond the angle from which on its pictures fold over, R, G, B and A are 0. A warning tells how much
//! of the first frame is empty. Every pass and the motion vectors hold through the distortion. There is no depth of field. Depth is
//! along the optical axis, but for the two fisheyes, which have the distance. A camera path may move this camera, and its columns
//! `fx`, `fy`, `cx`, `cy`, `skew`, `width`, `height`, `k1` and so on replace the numbers; columns of other lenses are errors.
//!
//! # Implementation
//!
//! Rays solve the model by Newton's method in double precision. Sources: Brown, "Close-Range Camera Calibration",
//! Photogrammetric Engineering 37(8), 1971; Kannala, Brandt, "A Generic Camera Model and Calibration Method", PAMI 28(8), 2006,
//! doi:10.1109/TPAMI.2006.153; OpenCV's documentation of `calib3d` and `fisheye` for the terms and their order.

use std::f64::consts::PI;

use glam::{DMat2, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::{
    CalibratedView, CameraKind, CameraSetup, FilmSize, Lens, LensKind, LensOverrides, PinholeView, Pose, StereoEye,
    ViewDistortion, ViewMatrices, default_up, intrinsics, look_at, station::Station,
};
use crate::{
    math::{Ray, RayCone, Vec2, Vec3},
    value::{List, Point, Precise, PrecisePositive, Problem, Spanned},
};

mod brown;
mod columns;
mod distortion;
mod fisheyes;
mod model;
mod rising;

pub use distortion::{Distortion, DistortionDesc};

/// The cells along a side of the picture by which its missing part is told.
const MISSING_CELLS: u32 = 64;

/// The description of a pinhole in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PinholeDesc {
    pub eye: Point,
    pub target: Spanned<Point>,
    #[serde(default = "default_up")]
    pub up: Point,
    pub fx: PrecisePositive,
    pub fy: Option<PrecisePositive>,
    pub cx: Option<Precise>,
    pub cy: Option<Precise>,
    pub skew: Option<Precise>,
    pub size: Option<List<PrecisePositive, 2>>,
    pub distortion: Option<DistortionDesc>,
}

impl PinholeDesc {
    /// # Errors
    /// The target is at the eye, a wrong number of coefficients.
    pub fn compile(&self) -> Result<CameraSetup<PinholeLens>, Vec<Problem>> {
        let pose = look_at(self.eye, &self.target, self.up).map_err(|e| vec![e])?;
        let distortion = self.distortion.as_ref().map(DistortionDesc::compile).transpose();
        let lens = PinholeLens {
            focal: [self.fx, self.fy.unwrap_or(self.fx)].map(|f| f.0),
            center: [self.cx, self.cy].map(|c| c.map(|c| c.0)),
            skew: self.skew.map_or(0.0, |s| s.0),
            size: self.size.map(|List(size)| size.map(|n| n.0)),
            distortion: distortion.map_err(|e| vec![e])?.unwrap_or(Distortion::None),
        };
        Ok(CameraSetup { pose, lens })
    }
}

/// Intrinsics as they were described.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PinholeLens {
    /// Across and down, in pixels.
    pub focal: [f64; 2],
    /// In pixels from the top left corner.
    pub center: [Option<f64>; 2],
    /// In pixels.
    pub skew: f64,
    /// The size of the pictures for which the others hold, in pixels.
    pub size: Option<[f64; 2]>,
    pub distortion: Distortion,
}

impl From<PinholeLens> for Lens {
    fn from(lens: PinholeLens) -> Self {
        Self::Pinhole(lens)
    }
}

impl LensKind for PinholeLens {
    type Camera = Pinhole;

    const COLUMNS: &'static [&'static str] = &intrinsics::NAMES;

    fn with_overrides(&self, overrides: &LensOverrides, _target_distance: Option<f64>) -> Self {
        overrides.intrinsics.apply(self)
    }

    fn parameters(&self) -> LensOverrides {
        LensOverrides::default()
    }

    fn camera(&self, pose: &Pose, film: FilmSize) -> Pinhole {
        let film = DVec2::from(film.map(|n| f64::from(n.max(1))));
        let size = self.size.map_or(film, DVec2::from);
        let scale = film / size;
        let [cx, cy] = self.center;
        let center = DVec2::new(cx.unwrap_or(0.5 * size.x), cy.unwrap_or(0.5 * size.y)) * scale;
        let [fx, fy] = self.focal;
        let pixels = DMat2::from_cols(
            DVec2::new(fx * scale.x, 0.0),
            DVec2::new(self.skew * scale.x, fy * scale.y),
        );
        Pinhole {
            station: Station::new(pose),
            pixels,
            inverse: pixels.inverse(),
            center,
            distortion: self.distortion,
        }
    }
}

/// A pinhole before its film.
///
/// A place on the film, in focal lengths from the optical axis with y downwards, is what the distortion makes of a direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pinhole {
    station: Station,
    /// From focal lengths to pixels.
    pixels: DMat2,
    inverse: DMat2,
    /// In pixels.
    center: DVec2,
    distortion: Distortion,
}

impl CameraKind for Pinhole {
    fn ray(&self, film: Vec2, _lens: Vec2) -> Option<Ray> {
        let d = self
            .distortion
            .direction(self.inverse * (film.as_dvec2() - self.center))?;
        Some(self.station.ray(DVec3::new(d.x, -d.y, -d.z)))
    }

    fn fills_film(&self) -> bool {
        self.distortion == Distortion::None
    }

    fn missing_part(&self, film: FilmSize) -> f64 {
        let cells = film.map(|n| n.min(MISSING_CELLS));
        let center = |i: u32, axis: usize| (i as f32 + 0.5) / cells[axis] as f32 * film[axis] as f32;
        let places = (0..cells[1]).flat_map(|y| (0..cells[0]).map(move |x| Vec2::new(center(x, 0), center(y, 1))));
        let missing = places.filter(|place| self.ray(*place, Vec2::ZERO).is_none()).count();
        missing as f64 / f64::from(cells[0] * cells[1])
    }

    fn pixel_cone(&self) -> RayCone {
        // By the smaller of the distances to the next pixels.
        let next =
            [self.inverse.x_axis, self.inverse.y_axis].map(|step| step.length() * self.distortion.middle_slope());
        RayCone {
            width: 0.0,
            spread: next[0].min(next[1]).min(PI) as f32,
        }
    }

    fn axis(&self) -> Option<Vec3> {
        self.distortion.has_plane().then(|| self.station.forward().as_vec3())
    }

    fn project(&self, p: DVec3) -> Option<DVec3> {
        let local = self.station.local(p);
        let d = DVec3::new(local.x, -local.y, -local.z);
        let film = self.center + self.pixels * self.distortion.place(d)?;
        let depth = if self.distortion.has_plane() { d.z } else { d.length() };
        Some(film.extend(depth))
    }

    fn matrices(&self, film: FilmSize) -> ViewMatrices {
        self.pinhole()
            .map_or_else(|| self.station.matrices(), |view| view.matrices(film))
    }

    fn pinhole(&self) -> Option<PinholeView> {
        let view = self.calibrated()?;
        (view.distortion == ViewDistortion::None).then_some(view.view)
    }

    fn calibrated(&self) -> Option<CalibratedView> {
        let is_square = self.pixels.y_axis.x == 0.0;
        let view = PinholeView {
            eye: self.station.eye(),
            axes: self.station.axes(),
            focal: [self.pixels.x_axis.x, self.pixels.y_axis.y],
            center: self.center.to_array(),
        };
        let distortion = self.distortion.of_data_sets().filter(|_| is_square)?;
        Some(CalibratedView { view, distortion })
    }

    fn moved(&self, by: DVec3) -> Self {
        Self {
            station: self.station.moved(by),
            ..*self
        }
    }

    fn of_eye(&self, eye: &StereoEye) -> Result<Self, &'static str> {
        if eye.convergence.is_some() && self.distortion != Distortion::None {
            return Err("the eyes of a camera with distortion do not converge: leave out convergence");
        }
        let shift = eye.convergence.map_or(0.0, |distance| eye.offset / distance);
        Ok(Self {
            station: self.station.beside(eye.offset),
            center: self.center + self.pixels.x_axis * shift,
            ..*self
        })
    }

    fn between(&self, to: &Self, u: f64) -> Self {
        let still = Self {
            station: self.station.between(&to.station, u),
            ..*self
        };
        if self.pixels == to.pixels && self.center == to.center {
            return still;
        }
        let pixels = self.pixels + (to.pixels - self.pixels) * u;
        // The end of a distortion is found in thousands of steps: it stays from one time of the shutter to the next.
        Self {
            pixels,
            inverse: pixels.inverse(),
            center: self.center + (to.center - self.center) * u,
            ..still
        }
    }
}

#[cfg(test)]
mod tests;
