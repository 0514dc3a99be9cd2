//! A perspective camera, a pinhole or a thin lens.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `eye` | `[x, y, z]` | m | required |
//! | `target` | `[x, y, z]`, not at the eye | m | required |
//! | `up` | `[x, y, z]`, see [`Pose::look_at`] where it is parallel to the view | | `[0, 1, 0]` |
//! | `fov` | angle over the picture's height, above 0 and below 180 | degrees | 40 |
//! | `fov_x` | instead of `fov`: the angle over the picture's width | degrees | |
//! | `focal_length` | instead of `fov`: number above 0 | mm | |
//! | `sensor_width` | number above 0, with `focal_length` or `fstop` | mm | 36 |
//! | `sensor_height` | instead of `sensor_width` | mm | |
//! | `aperture_radius` | number of at least 0; 0 is a pinhole | m | 0 |
//! | `fstop` | instead of `aperture_radius`: focal length over diameter, above 0 | | |
//! | `focus_distance` | distance of the sharp plane along the line of sight, above 0 | m | the distance to `target` |
//! | `shift` | `[x, y]`: moves the picture to the right and up without turning the camera | picture widths | `[0, 0]` |
//!
//! ```toml
//! [camera]
//! perspective = { eye = [0, 1, 5], target = [0, 1, 0], focal_length = 50, fstop = 2.8 }
//! ```
//!
//! Pixels are square. With a positive `shift` the picture shows what lies further to the right and further up.
//! The thin lens: every ray of a film point passes through one point of the sharp plane, and its origin is uniform on a
//! disk around the eye. Source: Kolb, Mitchell, Hanrahan, "A Realistic Camera Model for Computer Graphics", SIGGRAPH
//! 1995, doi:10.1145/218380.218463, section 3.1.

use std::f64::consts::FRAC_PI_4;

use glam::{DMat3, DVec2, DVec3};
use serde::{Deserialize, Deserializer, de};

use super::{
    CameraKind, Compiled, FilmSize, LensKind, LensOverrides, LookAt, Pose,
    lens::{Aperture, Focus, Sensor, View},
};
use crate::{
    math::{Ray, Vec2, Vec3},
    value::{NonNegative, Point, Positive, Problem, Real, Spanned},
};

/// The vertical angle where nothing is said, in degrees.
const DEFAULT_FOV: f64 = 40.0;

/// What a scene file says of a perspective camera.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerspectiveDesc {
    pub eye: Point,
    pub target: Spanned<Point>,
    #[serde(default = "plus_y")]
    pub up: Point,
    pub fov: Option<Spanned<FieldOfView>>,
    pub fov_x: Option<Spanned<FieldOfView>>,
    pub focal_length: Option<Spanned<Positive>>,
    pub sensor_width: Option<Spanned<Positive>>,
    pub sensor_height: Option<Spanned<Positive>>,
    pub aperture_radius: Option<Spanned<NonNegative>>,
    pub fstop: Option<Spanned<Positive>>,
    pub focus_distance: Option<Positive>,
    pub shift: Option<[Real; 2]>,
}

fn plus_y() -> Point {
    Point(Vec3::Y)
}

/// An angle across a picture, in degrees, above 0 and below 180.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldOfView(pub f64);

impl<'de> Deserialize<'de> for FieldOfView {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let degrees = f64::deserialize(d)?;
        if degrees > 0.0 && degrees < 180.0 {
            Ok(Self(degrees))
        } else {
            Err(de::Error::custom(format_args!(
                "expected an angle above 0 and below 180 degrees, found {degrees}"
            )))
        }
    }
}

/// At most one of the alternatives that are given; every further one is a problem.
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
    /// The target is at the eye, two of a set of alternatives are given, a sensor without anything that needs one.
    pub fn compile(&self) -> Result<Compiled<PerspectiveLens>, Vec<Problem>> {
        let mut problems = Vec::new();
        let eye = self.eye.0.as_dvec3();
        let target = self.target.as_ref().0.as_dvec3();
        let at = LookAt {
            target,
            up: self.up.0.as_dvec3(),
            roll: 0.0,
        };
        let pose = Pose::look_at(eye, &at).unwrap_or_else(|e| {
            problems.push(Problem::at(self.target.span(), e.to_string()));
            Pose::at(eye)
        });
        let lens = self.lens(eye.distance(target), &mut problems);
        if problems.is_empty() {
            Ok(Compiled { pose, lens })
        } else {
            Err(problems)
        }
    }

    fn lens(&self, target_distance: f64, problems: &mut Vec<Problem>) -> PerspectiveLens {
        let view = OneOf::new()
            .or("fov", self.fov.as_ref(), problems, |v| View::Vertical(v.0))
            .or("fov_x", self.fov_x.as_ref(), problems, |v| View::Horizontal(v.0))
            .or("focal_length", self.focal_length.as_ref(), problems, |v| {
                View::FocalLength(v.0.into())
            });
        let sensor = OneOf::new()
            .or("sensor_width", self.sensor_width.as_ref(), problems, |v| {
                Sensor::Width(v.0.into())
            })
            .or("sensor_height", self.sensor_height.as_ref(), problems, |v| {
                Sensor::Height(v.0.into())
            });
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
        let [x, y] = self.shift.unwrap_or([Real(0.0); 2]);
        PerspectiveLens {
            view: view.value().unwrap_or(View::Vertical(DEFAULT_FOV)),
            sensor: sensor.value().unwrap_or_default(),
            aperture: aperture.value().unwrap_or(Aperture::Radius(0.0)),
            focus: match self.focus_distance {
                Some(m) => Focus::At(m.0.into()),
                None => Focus::OnTarget(target_distance),
            },
            shift: [x.0.into(), y.0.into()],
        }
    }
}

/// A perspective lens, as it was described.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerspectiveLens {
    pub view: View,
    pub sensor: Sensor,
    pub aperture: Aperture,
    pub focus: Focus,
    /// To the right and up, in picture widths.
    pub shift: [f64; 2],
}

impl PerspectiveLens {
    /// A pinhole that sees so many degrees over the picture's height.
    pub fn vertical(degrees: f64) -> Self {
        Self {
            view: View::Vertical(degrees),
            ..Self::default()
        }
    }
}

impl Default for PerspectiveLens {
    fn default() -> Self {
        Self {
            view: View::Vertical(DEFAULT_FOV),
            sensor: Sensor::default(),
            aperture: Aperture::Radius(0.0),
            focus: Focus::OnTarget(1.0),
            shift: [0.0; 2],
        }
    }
}

impl LensKind for PerspectiveLens {
    type Camera = Perspective;

    fn overridden(&self, overrides: &LensOverrides, target_distance: Option<f64>) -> Self {
        let focus = match (overrides.focus_distance, self.focus, target_distance) {
            (Some(m), ..) => Focus::At(m),
            (None, Focus::OnTarget(_), Some(m)) => Focus::OnTarget(m),
            (None, said, _) => said,
        };
        Self {
            view: overrides.view.unwrap_or(self.view),
            sensor: overrides.sensor.unwrap_or(self.sensor),
            aperture: overrides.aperture.unwrap_or(self.aperture),
            focus,
            shift: [
                overrides.shift_x.unwrap_or(self.shift[0]),
                overrides.shift_y.unwrap_or(self.shift[1]),
            ],
        }
    }

    fn camera(&self, pose: &Pose, film: FilmSize) -> Perspective {
        let [width, height] = film.map(|n| f64::from(n.max(1)));
        let aspect = width / height;
        let half_height = self.view.half_height(self.sensor, aspect);
        let focal_length = match self.view {
            View::FocalLength(mm) => mm,
            View::Vertical(_) | View::Horizontal(_) => 0.5 * self.sensor.height(aspect) / half_height,
        };
        Perspective {
            eye: pose.eye(),
            axes: pose.world_from_camera().matrix3,
            center: DVec2::new(
                0.5 * width - self.shift[0] * width,
                0.5 * height + self.shift[1] * width,
            ),
            pixel: 2.0 * half_height / height,
            lens_radius: self.aperture.radius(focal_length),
            focus_distance: self.focus.distance(),
        }
    }
}

/// A perspective camera before its film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perspective {
    eye: DVec3,
    /// From camera to world.
    axes: DMat3,
    /// Where the line of sight meets the film, in pixels.
    center: DVec2,
    /// The side of a pixel on the plane at distance 1.
    pixel: f64,
    /// In m; 0 is a pinhole.
    lens_radius: f64,
    /// In m, along the line of sight.
    focus_distance: f64,
}

impl CameraKind for Perspective {
    fn axis(&self) -> Option<Vec3> {
        Some(-self.axes.z_axis.as_vec3())
    }

    /// In double precision: a camera ray is made once, and neighbours far from the middle of a large picture differ in
    /// the last bits of single precision.
    fn ray(&self, film: Vec2, lens: Vec2) -> Ray {
        let offset = (film.as_dvec2() - self.center) * self.pixel;
        let at_one = DVec3::new(offset.x, -offset.y, -1.0);
        if self.lens_radius == 0.0 {
            return self.world_ray(self.eye, at_one);
        }
        let on_lens = (square_to_disk(lens) * self.lens_radius).extend(0.0);
        let sharp = at_one * self.focus_distance;
        self.world_ray(self.eye + self.axes * on_lens, sharp - on_lens)
    }

    fn has_lens(&self) -> bool {
        self.lens_radius > 0.0
    }
}

impl Perspective {
    fn world_ray(&self, o: DVec3, d_camera: DVec3) -> Ray {
        let d = self.axes * d_camera;
        Ray::new(o.as_vec3(), (d / d.length()).as_vec3())
    }
}

/// A point of the unit disk, uniform in area, from two uniform numbers; neighbours stay neighbours.
///
/// Source: Shirley and Chiu, "A Low Distortion Map Between Disk and Square", JGT 2(3), 1997,
/// doi:10.1080/10867651.1997.10487479.
fn square_to_disk(u: Vec2) -> DVec2 {
    let p = u.as_dvec2() * 2.0 - 1.0;
    if p == DVec2::ZERO {
        return p;
    }
    let (r, angle) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, 2.0 * FRAC_PI_4 - FRAC_PI_4 * (p.x / p.y))
    };
    let (sin, cos) = libm::sincos(angle);
    DVec2::new(cos, sin) * r
}

#[cfg(test)]
mod tests;
