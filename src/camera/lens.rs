//! The parameters of a lens, as they were given.
//!
//! A field of view, a focal length and an f-number become lengths only when the aspect ratio of the
//! film is known. A camera path may replace some of them and keep the others of the scene.

use serde::{Deserialize, Serialize};

use super::intrinsics::IntrinsicsOverrides;

/// The field of view of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum FieldOfView {
    /// The angle over the picture's height, in degrees as it was written; above 0 and below 180.
    Vertical(f64),
    /// The angle over the picture's width, in degrees as it was written; above 0 and below 180.
    Horizontal(f64),
    /// The focal length of the lens before its [`Sensor`], in mm, above 0.
    FocalLength(f64),
}

/// The size of the sensor along one side; the other side follows from square pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Sensor {
    /// In mm, above 0.
    Width(f64),
    /// In mm, above 0.
    Height(f64),
    /// The longer side of the picture, in mm, above 0.
    LongSide(f64),
}

impl Default for Sensor {
    /// A full frame: 36 mm wide.
    fn default() -> Self {
        Self::Width(36.0)
    }
}

/// The side of the picture that the size of the sensor covers, as Blender's sensor fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SensorFit {
    /// The width of the sensor covers the longer side of the picture.
    Auto,
    /// The width of the sensor covers the picture's width.
    Width,
    /// The height of the sensor covers the picture's height.
    Height,
}

impl SensorFit {
    /// Returns the sensor with this fit, from the size that was given.
    pub fn fit(self, sensor: Sensor) -> Sensor {
        match (self, sensor) {
            (Self::Auto, Sensor::Width(mm)) => Sensor::LongSide(mm),
            (_, given) => given,
        }
    }

    /// Returns a full frame, 36 mm by 24 mm, with this fit.
    pub fn full_frame(self) -> Sensor {
        match self {
            Self::Auto => Sensor::LongSide(36.0),
            Self::Width => Sensor::Width(36.0),
            Self::Height => Sensor::Height(24.0),
        }
    }
}

/// The size of the aperture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Aperture {
    /// The radius in m, at least 0; 0 is a pinhole.
    Radius(f64),
    /// The f-number, above 0: the focal length over the diameter.
    FStop(f64),
}

/// The distance of the plane of focus, along the line of sight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Focus {
    /// A given distance in m, above 0.
    At(f64),
    /// The distance to the target, in m.
    OnTarget(f64),
}

impl Focus {
    /// In m.
    pub fn distance(self) -> f64 {
        match self {
            Self::At(m) | Self::OnTarget(m) => m,
        }
    }
}

/// The lens parameters of a camera path; `None` keeps the parameter of the scene's camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LensOverrides {
    pub view: Option<FieldOfView>,
    pub sensor: Option<Sensor>,
    pub aperture: Option<Aperture>,
    /// In m, above 0.
    pub focus_distance: Option<f64>,
    /// In picture widths.
    pub shift_x: Option<f64>,
    /// In picture widths.
    pub shift_y: Option<f64>,
    pub intrinsics: IntrinsicsOverrides,
}

impl LensOverrides {
    /// The columns of a camera path that are given here.
    pub fn columns(&self) -> impl Iterator<Item = &'static str> {
        let view = self.view.map(|v| match v {
            FieldOfView::Vertical(_) => "fov",
            FieldOfView::Horizontal(_) => "fov_x",
            FieldOfView::FocalLength(_) => "focal_length",
        });
        let sensor = self.sensor.map(|s| match s {
            Sensor::Width(_) | Sensor::LongSide(_) => "sensor_width",
            Sensor::Height(_) => "sensor_height",
        });
        let aperture = self.aperture.map(|a| match a {
            Aperture::Radius(_) => "aperture_radius",
            Aperture::FStop(_) => "fstop",
        });
        let number = |v: Option<f64>, name| v.map(|_| name);
        [
            view,
            sensor,
            aperture,
            number(self.focus_distance, "focus_distance"),
            number(self.shift_x, "shift_x"),
            number(self.shift_y, "shift_y"),
        ]
        .into_iter()
        .flatten()
        .chain(self.intrinsics.columns())
    }

    /// The reason why the parameters are invalid, if they are.
    pub fn flaw(&self) -> Option<&'static str> {
        let above_0 = |v: f64| v > 0.0 && v.is_finite();
        let view = match self.view {
            Some(FieldOfView::Vertical(degrees) | FieldOfView::Horizontal(degrees)) => degrees > 0.0 && degrees < 180.0,
            Some(FieldOfView::FocalLength(mm)) => above_0(mm),
            None => true,
        };
        let sensor = match self.sensor {
            Some(Sensor::Width(mm) | Sensor::Height(mm) | Sensor::LongSide(mm)) => above_0(mm),
            None => true,
        };
        let aperture = match self.aperture {
            Some(Aperture::Radius(m)) => m == 0.0 || above_0(m),
            Some(Aperture::FStop(n)) => above_0(n),
            None => true,
        };
        let focus = self.focus_distance.is_none_or(above_0);
        let shift = [self.shift_x, self.shift_y].into_iter().flatten().all(f64::is_finite);
        [
            (
                view,
                "the view is not an angle between 0 and 180 degrees or a focal length above 0",
            ),
            (sensor, "the sensor's size is not above 0"),
            (
                aperture,
                "the aperture is not a radius of at least 0 or an f-number above 0",
            ),
            (focus, "the focus distance is not above 0"),
            (shift, "the shift is not finite"),
            (
                self.intrinsics.is_valid(),
                "a focal length or a size in pixels is not above 0, or a number of the lens is not finite",
            ),
            (
                !self.intrinsics.is_of_two_models(),
                "the distortion has coefficients of two models",
            ),
        ]
        .into_iter()
        .find(|(fine, _)| !fine)
        .map(|(_, flaw)| flaw)
    }
}

impl FieldOfView {
    /// The tangent of half the angle over the picture's height, for a picture `aspect` times as
    /// wide as high.
    pub fn half_height(self, sensor: Sensor, aspect: f64) -> f64 {
        match (self, sensor) {
            (Self::Vertical(degrees), _) => half_tan(degrees),
            (Self::Horizontal(degrees), _) => half_tan(degrees) / aspect,
            (Self::FocalLength(mm), Sensor::Height(height)) => 0.5 * height / mm,
            (Self::FocalLength(mm), Sensor::Width(width)) => 0.5 * width / (mm * aspect),
            (Self::FocalLength(mm), Sensor::LongSide(side)) => 0.5 * side / (mm * aspect.max(1.0)),
        }
    }
}

impl Sensor {
    /// In mm, behind a picture `aspect` times as wide as high.
    pub fn height(self, aspect: f64) -> f64 {
        match self {
            Self::Height(mm) => mm,
            Self::Width(mm) => mm / aspect,
            Self::LongSide(mm) => mm / aspect.max(1.0),
        }
    }
}

impl Aperture {
    /// The radius in m, of a lens with a focal length in mm.
    pub fn radius(self, focal_length: f64) -> f64 {
        match self {
            Self::Radius(m) => m,
            Self::FStop(n) => 0.5e-3 * focal_length / n,
        }
    }
}

/// The tangent of half an angle in degrees.
pub(super) fn half_tan(degrees: f64) -> f64 {
    libm::tan(0.5 * degrees.to_radians())
}
