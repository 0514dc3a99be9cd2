//! A perspective camera: a pinhole, or a thin lens with depth of field.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `eye` | position, `[x, y, z]` | m | required |
//! | `target` | point at the centre of view, `[x, y, z]`, not at the eye | m | required |
//! | `up` | direction that points up in the picture, `[x, y, z]` | | `[0, 1, 0]` |
//! | `fov` | vertical field of view, above 0 and below 180 | degrees | 40 |
//! | `fov_x` | instead of `fov`: horizontal field of view | degrees | |
//! | `focal_length` | instead of `fov`: number above 0 | mm | |
//! | `sensor_width` | number above 0, with `focal_length` or `fstop`; covers the picture's width, whatever its shape | mm | 36 |
//! | `sensor_height` | instead of `sensor_width`; covers the picture's height | mm | |
//! | `sensor_fit` | `"auto"`: `sensor_width` covers the longer side of the picture, as Blender's default does; `"width"` or `"height"`: the size of that name counts | | the size that is given |
//! | `aperture_radius` | number of at least 0; 0 is a pinhole | m | 0 |
//! | `fstop` | instead of `aperture_radius`: focal length over aperture diameter, above 0 | | |
//! | `focus_distance` | distance of the sharp plane along the line of sight, above 0 | m | the distance to `target` |
//! | `blades` | corners of the aperture, at least 3; 0 is a round aperture | | 0 |
//! | `blade_rotation` | angle of the first corner, counterclockwise from the right as seen from behind the camera | degrees | 0 |
//! | `shift` | `[x, y]`: moves the view to the right and up without turning the camera | picture widths | `[0, 0]` |
//!
//! ```toml
//! [camera]
//! perspective = { eye = [0, 1, 5], target = [0, 1, 0], focal_length = 50, fstop = 2.8 }
//! ```
//!
//! A camera of Blender has the sensor fit "Auto": write `sensor_fit = "auto"` for it, so that portrait pictures, too, have
//! its field of view. The fit holds for the `sensor_width` of a camera path, too.
//!
//! Pixels are square. Where `up` is parallel to the line of sight, another axis takes its place.
//!
//! # Implementation
//!
//! The thin lens: all rays of a film point meet in one point of the sharp plane, and their origins are uniform on the
//! aperture around the eye: a disk of the aperture's radius, or a regular polygon with its corners on that circle. Source:
//! Kolb, Mitchell, Hanrahan, "A Realistic Camera Model for Computer Graphics", SIGGRAPH 1995, doi:10.1145/218380.218463,
//! section 3.1. [`Pose::look_at`] describes an `up` that is parallel to the line of sight.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Deserializer, Serialize, de};

use super::{
    CameraKind, CameraSetup, FilmSize, LensFacts, LensKind, LensOverrides, PinholeView, Pose, StereoEye, ViewMatrices,
    aperture_shape::ApertureShape,
    default_up,
    lens::{Aperture, FieldOfView, Focus, Sensor, SensorFit},
    lerp, look_at, rays_one_by_one, unit, unit_ray,
};
use crate::{
    math::{Dispatch, Ray, RayCone, Vec2, Vec3, VectorLoop, trig},
    value::{Count, Finite, List, NonNegative, Point, Positive, Problem, Spanned, number},
};

/// The default vertical field of view, in degrees.
const DEFAULT_FOV: f64 = 40.0;

/// The description of a perspective camera in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerspectiveDesc {
    pub eye: Point,
    pub target: Spanned<Point>,
    #[serde(default = "default_up")]
    pub up: Point,
    pub fov: Option<Spanned<FovDegrees>>,
    pub fov_x: Option<Spanned<FovDegrees>>,
    pub focal_length: Option<Spanned<Positive>>,
    pub sensor_width: Option<Spanned<Positive>>,
    pub sensor_height: Option<Spanned<Positive>>,
    pub sensor_fit: Option<Spanned<SensorFit>>,
    pub aperture_radius: Option<Spanned<NonNegative>>,
    pub fstop: Option<Spanned<Positive>>,
    pub focus_distance: Option<Positive>,
    pub blades: Option<Spanned<Count>>,
    pub blade_rotation: Option<Spanned<Finite>>,
    pub shift: Option<List<Finite, 2>>,
}

/// An angle across a picture, in degrees, above 0 and below 180.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FovDegrees(pub f64);

impl<'de> Deserialize<'de> for FovDegrees {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let degrees = number(d)?;
        if degrees > 0.0 && degrees < 180.0 {
            Ok(Self(degrees))
        } else {
            Err(de::Error::custom(format_args!(
                "expected an angle above 0 and below 180 degrees, found {degrees}"
            )))
        }
    }
}

/// A set of alternative keys, of which at most one may be given.
struct OneOf<T> {
    chosen: Option<(&'static str, T)>,
}

impl<T> OneOf<T> {
    fn new() -> Self {
        Self { chosen: None }
    }

    fn or<V: Copy>(
        mut self,
        key: &'static str,
        given: Option<&Spanned<V>>,
        problems: &mut Vec<Problem>,
        make: impl FnOnce(V) -> T,
    ) -> Self {
        let Some(given) = given else { return self };
        match self.chosen {
            None => self.chosen = Some((key, make(*given.as_ref()))),
            Some((first, _)) => problems.push(
                Problem::at(given.span(), format!("`{key}` and `{first}` are both given"))
                    .with_help(format!("keep one of the two, `{first}` or `{key}`")),
            ),
        }
        self
    }

    fn value(self) -> Option<T> {
        self.chosen.map(|(_, value)| value)
    }
}

impl PerspectiveDesc {
    /// # Errors
    /// The target is at the eye, two of a set of alternatives are given, a sensor or a rotation
    /// without anything that needs one, one or two blades.
    pub fn compile(&self) -> Result<CameraSetup<PerspectiveLens>, Vec<Problem>> {
        let mut problems = Vec::new();
        let eye = self.eye.0;
        let pose = look_at(self.eye, &self.target, self.up).unwrap_or_else(|e| {
            problems.push(e);
            Pose::at(eye)
        });
        let lens = self.lens(eye.distance(self.target.as_ref().0), &mut problems);
        if problems.is_empty() {
            Ok(CameraSetup { pose, lens })
        } else {
            Err(problems)
        }
    }

    fn lens(&self, target_distance: f64, problems: &mut Vec<Problem>) -> PerspectiveLens {
        let view = OneOf::new()
            .or("fov", self.fov.as_ref(), problems, |v| FieldOfView::Vertical(v.0))
            .or("fov_x", self.fov_x.as_ref(), problems, |v| FieldOfView::Horizontal(v.0))
            .or("focal_length", self.focal_length.as_ref(), problems, |v| {
                FieldOfView::FocalLength(v.0.into())
            });
        let sensor = self.sensor(problems);
        let aperture = OneOf::new()
            .or("aperture_radius", self.aperture_radius.as_ref(), problems, |v| {
                Aperture::Radius(v.0.into())
            })
            .or("fstop", self.fstop.as_ref(), problems, |v| Aperture::FStop(v.0.into()));
        if self.focal_length.is_none() && self.fstop.is_none() {
            let idle = [
                ("sensor_width", &self.sensor_width),
                ("sensor_height", &self.sensor_height),
            ];
            for (key, given) in idle {
                if let Some(given) = given {
                    problems.push(Problem::at(
                        given.span(),
                        format!("`{key}` has no effect without `focal_length` or `fstop`"),
                    ));
                }
            }
        }
        let aperture_shape = self.aperture_shape(problems);
        let List([x, y]) = self.shift.unwrap_or(List([Finite(0.0); 2]));
        PerspectiveLens {
            view: view.value().unwrap_or(FieldOfView::Vertical(DEFAULT_FOV)),
            sensor,
            sensor_fit: self.sensor_fit.as_ref().map(|f| *f.get_ref()),
            aperture: aperture.value().unwrap_or(Aperture::Radius(0.0)),
            focus: match self.focus_distance {
                Some(m) => Focus::At(m.0.into()),
                None => Focus::OnTarget(target_distance),
            },
            aperture_shape,
            shift: [x.0.into(), y.0.into()],
        }
    }
}

impl PerspectiveDesc {
    fn sensor(&self, problems: &mut Vec<Problem>) -> Sensor {
        let width = self.sensor_width.as_ref().map(|v| Sensor::Width(v.get_ref().0.into()));
        let height = self
            .sensor_height
            .as_ref()
            .map(|v| Sensor::Height(v.get_ref().0.into()));
        let Some(fit) = &self.sensor_fit else {
            let sensor = OneOf::new()
                .or("sensor_width", self.sensor_width.as_ref(), problems, |v| {
                    Sensor::Width(v.0.into())
                })
                .or("sensor_height", self.sensor_height.as_ref(), problems, |v| {
                    Sensor::Height(v.0.into())
                });
            return sensor.value().unwrap_or_default();
        };
        let (fit, span) = (*fit.get_ref(), fit.span());
        let (used, other, key) = match fit {
            SensorFit::Height => (height, width, "sensor_height"),
            SensorFit::Auto | SensorFit::Width => (width, height, "sensor_width"),
        };
        if used.is_none() && other.is_some() {
            problems.push(Problem::at(span, format!("this `sensor_fit` needs `{key}`")));
        }
        used.map_or_else(|| fit.full_frame(), |sensor| fit.fit(sensor))
    }

    fn aperture_shape(&self, problems: &mut Vec<Problem>) -> ApertureShape {
        let blades = self.blades.as_ref().map_or(0, |b| b.get_ref().0);
        if let (Some(given), 1 | 2) = (&self.blades, blades) {
            let message = format!("expected at least 3 blades, or 0 for a round opening, found {blades}");
            problems.push(Problem::at(given.span(), message));
        }
        match (&self.blade_rotation, blades) {
            (Some(rotation), 0) => {
                let message = "`blade_rotation` has no effect without `blades`";
                problems.push(Problem::at(rotation.span(), message));
                ApertureShape::Round
            }
            (None, 0) => ApertureShape::Round,
            (rotation, blades) => ApertureShape::Polygon {
                blades,
                rotation: rotation.as_ref().map_or(0.0, |r| trig::radians(r.get_ref().0)),
            },
        }
    }
}

/// A perspective lens, as it was described.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PerspectiveLens {
    pub view: FieldOfView,
    pub sensor: Sensor,
    /// The sensor fit for a camera path's sensor; `None` uses the path's own size.
    pub sensor_fit: Option<SensorFit>,
    pub aperture: Aperture,
    pub focus: Focus,
    pub aperture_shape: ApertureShape,
    /// To the right and up, in picture widths.
    pub shift: [f64; 2],
}

impl PerspectiveLens {
    /// A pinhole with the given vertical field of view.
    pub fn vertical(degrees: f64) -> Self {
        Self {
            view: FieldOfView::Vertical(degrees),
            ..Self::default()
        }
    }
}

impl Default for PerspectiveLens {
    fn default() -> Self {
        Self {
            view: FieldOfView::Vertical(DEFAULT_FOV),
            sensor: Sensor::default(),
            sensor_fit: None,
            aperture: Aperture::Radius(0.0),
            focus: Focus::OnTarget(1.0),
            aperture_shape: ApertureShape::Round,
            shift: [0.0; 2],
        }
    }
}

impl LensKind for PerspectiveLens {
    type Camera = Perspective;

    const COLUMNS: &'static [&'static str] = &[
        "fov",
        "fov_x",
        "focal_length",
        "sensor_width",
        "sensor_height",
        "aperture_radius",
        "fstop",
        "focus_distance",
        "shift_x",
        "shift_y",
    ];

    fn with_overrides(&self, overrides: &LensOverrides, target_distance: Option<f64>) -> Self {
        let focus = match (overrides.focus_distance, self.focus, target_distance) {
            (Some(m), ..) => Focus::At(m),
            (None, Focus::OnTarget(_), Some(m)) => Focus::OnTarget(m),
            (None, given, _) => given,
        };
        Self {
            view: overrides.view.unwrap_or(self.view),
            sensor: match (overrides.sensor, self.sensor_fit) {
                (None, _) => self.sensor,
                (Some(given), None) => given,
                (Some(given), Some(fit)) => fit.fit(given),
            },
            sensor_fit: self.sensor_fit,
            aperture: overrides.aperture.unwrap_or(self.aperture),
            focus,
            aperture_shape: self.aperture_shape,
            shift: [
                overrides.shift_x.unwrap_or(self.shift[0]),
                overrides.shift_y.unwrap_or(self.shift[1]),
            ],
        }
    }

    fn parameters(&self) -> LensOverrides {
        LensOverrides {
            view: Some(self.view),
            sensor: None,
            aperture: Some(self.aperture),
            focus_distance: Some(self.focus.distance()),
            shift_x: Some(self.shift[0]),
            shift_y: Some(self.shift[1]),
            ..LensOverrides::default()
        }
    }

    fn camera(&self, pose: &Pose, film: FilmSize) -> Perspective {
        let [width, height] = film.map(|n| f64::from(n.max(1)));
        let aspect = width / height;
        let half_height = self.view.half_height(self.sensor, aspect);
        let focal_length = match self.view {
            FieldOfView::FocalLength(mm) => mm,
            FieldOfView::Vertical(_) | FieldOfView::Horizontal(_) => 0.5 * self.sensor.height(aspect) / half_height,
        };
        // Where the line of sight meets the film, in pixels, and the side of a pixel at distance 1.
        let center = DVec2::new(
            0.5 * width - self.shift[0] * width,
            0.5 * height + self.shift[1] * width,
        );
        let pixel = 2.0 * half_height / height;
        let (right, down) = (pose.right() * pixel, pose.up() * -pixel);
        Perspective {
            eye: pose.eye(),
            corner: pose.forward() - right * center.x - down * center.y,
            right,
            down,
            lens_axes: [pose.right(), pose.up()],
            lens_radius: self.aperture.radius(focal_length),
            focal_length,
            aperture_shape: self.aperture_shape,
            focus_distance: self.focus.distance(),
        }
    }
}

/// A perspective camera before its film.
///
/// In double precision, which costs next to nothing here: neighbours far from the middle of a large
/// picture differ in the last bits of single precision.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Perspective {
    eye: DVec3,
    /// From the eye to the picture's top left corner, on the plane at distance 1.
    corner: DVec3,
    /// One pixel to the right and one downwards, on that plane.
    right: DVec3,
    down: DVec3,
    /// Unit vectors to the right and up.
    lens_axes: [DVec3; 2],
    /// In m; 0 is a pinhole.
    lens_radius: f64,
    /// In mm.
    focal_length: f64,
    aperture_shape: ApertureShape,
    /// In m, along the line of sight.
    focus_distance: f64,
}

/// Directions through a pinhole.
struct Pinhole<'a> {
    camera: &'a Perspective,
    film: &'a [Vec2],
    rays: &'a mut [Ray],
}

impl VectorLoop for Pinhole<'_> {
    #[inline(always)]
    fn run(self) {
        for (film, ray) in self.film.iter().zip(self.rays) {
            ray.d = unit(self.camera.at_one(*film));
        }
    }
}

impl Perspective {
    /// The vector from the eye to the point at distance 1 that a film position shows.
    #[inline(always)]
    fn at_one(&self, film: Vec2) -> DVec3 {
        self.corner + self.right * f64::from(film.x) + self.down * f64::from(film.y)
    }
}

impl CameraKind for Perspective {
    fn axis(&self) -> Option<Vec3> {
        Some(self.forward().as_vec3())
    }

    fn project(&self, p: DVec3) -> Option<DVec3> {
        let (from_eye, forward) = (p - self.eye, self.forward());
        let depth = from_eye.dot(forward);
        let at_one = from_eye * (self.corner.dot(forward) / depth) - self.corner;
        let along = |axis: DVec3| at_one.dot(axis) / axis.length_squared();
        (depth > 0.0).then(|| DVec3::new(along(self.right), along(self.down), depth))
    }

    fn matrices(&self, film: FilmSize) -> ViewMatrices {
        self.view().matrices(film)
    }

    fn lens_facts(&self) -> Option<LensFacts> {
        Some(self.facts())
    }

    fn pinhole(&self) -> Option<PinholeView> {
        Some(self.view())
    }

    #[inline(always)]
    fn ray(&self, film: Vec2, lens: Vec2) -> Option<Ray> {
        let at_one = self.at_one(film);
        if self.lens_radius == 0.0 {
            return Some(unit_ray(self.eye, at_one));
        }
        let p = self.aperture_shape.sample(lens).as_dvec2() * self.lens_radius;
        let on_lens = self.lens_axes[0] * p.x + self.lens_axes[1] * p.y;
        Some(unit_ray(self.eye + on_lens, at_one * self.focus_distance - on_lens))
    }

    fn rays(&self, on: impl Dispatch, film: &[Vec2], lens: &[Vec2], rays: &mut Vec<Ray>) {
        if self.lens_radius > 0.0 {
            return rays_one_by_one(self, film, lens, rays);
        }
        let first = rays.len();
        rays.resize(first + film.len(), Ray::new(self.eye.as_vec3(), Vec3::ZERO));
        on.dispatch(Pinhole {
            camera: self,
            film,
            rays: &mut rays[first..],
        });
    }

    fn has_lens(&self) -> bool {
        self.lens_radius > 0.0
    }

    fn pixel_cone(&self) -> RayCone {
        RayCone {
            width: 0.0,
            spread: self.right.length() as f32,
        }
    }

    fn moved(&self, by: DVec3) -> Self {
        Self {
            eye: self.eye + by,
            ..*self
        }
    }

    fn of_eye(&self, eye: &StereoEye) -> Result<Self, &'static str> {
        Ok(self.beside(eye))
    }

    fn between(&self, to: &Self, u: f64) -> Self {
        let number = |a: f64, b: f64| a + (b - a) * u;
        Self {
            eye: lerp(self.eye, to.eye, u),
            corner: lerp(self.corner, to.corner, u),
            right: lerp(self.right, to.right, u),
            down: lerp(self.down, to.down, u),
            lens_axes: [
                lerp(self.lens_axes[0], to.lens_axes[0], u),
                lerp(self.lens_axes[1], to.lens_axes[1], u),
            ],
            lens_radius: number(self.lens_radius, to.lens_radius),
            focal_length: number(self.focal_length, to.focal_length),
            aperture_shape: self.aperture_shape,
            focus_distance: number(self.focus_distance, to.focus_distance),
        }
    }
}

mod facts;
#[cfg(test)]
mod tests;
