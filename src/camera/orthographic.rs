//! An orthographic camera: all rays are parallel, and objects have the same size at any distance.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `eye` | position, `[x, y, z]`; nothing behind its plane is visible | m | required |
//! | `target` | point at the centre of view, `[x, y, z]`, not at the eye | m | required |
//! | `up` | direction that points up in the picture, `[x, y, z]` | | `[0, 1, 0]` |
//! | `height` | height of the view, above 0 | m | required |
//! | `shift` | `[x, y]`: moves the view to the right and up | picture widths | `[0, 0]` |
//!
//! ```toml
//! [camera]
//! orthographic = { eye = [0, 10, 0], target = [0, 0, 0], height = 6 }
//! ```
//!
//! Pixels are square. There is no depth of field. A camera path may move this camera and set `shift_x` and `shift_y`; other
//! columns of a lens are errors.

use glam::{DMat4, DVec3, DVec4};
use serde::{Deserialize, Serialize};

use super::{
    CameraKind, CameraSetup, FilmSize, LensKind, LensOverrides, Pose, StereoEye, ViewMatrices, default_up, facts, lerp,
    look_at, unit_ray,
};
use crate::{
    math::{Ray, RayCone, Vec2, Vec3},
    value::{Finite, List, Point, Positive, Problem, Spanned},
};

/// The description of an orthographic camera in a scene file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrthographicDesc {
    pub eye: Point,
    pub target: Spanned<Point>,
    #[serde(default = "default_up")]
    pub up: Point,
    pub height: Positive,
    pub shift: Option<List<Finite, 2>>,
}

impl OrthographicDesc {
    /// # Errors
    /// The target is at the eye.
    pub fn compile(&self) -> Result<CameraSetup<OrthographicLens>, Vec<Problem>> {
        let pose = look_at(self.eye, &self.target, self.up).map_err(|e| vec![e])?;
        let List([x, y]) = self.shift.unwrap_or(List([Finite(0.0); 2]));
        let lens = OrthographicLens {
            height: self.height.0.into(),
            shift: [x.0.into(), y.0.into()],
        };
        Ok(CameraSetup { pose, lens })
    }
}

/// The view of an orthographic camera, as described.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OrthographicLens {
    /// The height of the view, in m, above 0.
    pub height: f64,
    /// To the right and up, in picture widths.
    pub shift: [f64; 2],
}

impl LensKind for OrthographicLens {
    type Camera = Orthographic;

    const COLUMNS: &'static [&'static str] = &["shift_x", "shift_y"];

    fn with_overrides(&self, overrides: &LensOverrides, _target_distance: Option<f64>) -> Self {
        Self {
            shift: [
                overrides.shift_x.unwrap_or(self.shift[0]),
                overrides.shift_y.unwrap_or(self.shift[1]),
            ],
            ..*self
        }
    }

    fn parameters(&self) -> LensOverrides {
        LensOverrides {
            shift_x: Some(self.shift[0]),
            shift_y: Some(self.shift[1]),
            ..LensOverrides::default()
        }
    }

    fn camera(&self, pose: &Pose, film: FilmSize) -> Orthographic {
        let [columns, rows] = film.map(|n| f64::from(n.max(1)));
        let pixel = self.height / rows;
        let (right, down) = (pose.right() * pixel, pose.up() * -pixel);
        let [x, y] = self.shift.map(|s| s * columns);
        Orthographic {
            corner: pose.eye() - right * (0.5 * columns - x) - down * (0.5 * rows + y),
            right,
            down,
            forward: pose.forward(),
        }
    }
}

/// An orthographic camera before its film.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Orthographic {
    /// The picture's top left corner, in m.
    corner: DVec3,
    /// One pixel to the right and one downwards, in m.
    right: DVec3,
    down: DVec3,
    forward: DVec3,
}

impl CameraKind for Orthographic {
    fn axis(&self) -> Option<Vec3> {
        Some(self.forward.as_vec3())
    }

    fn project(&self, p: DVec3) -> Option<DVec3> {
        let from_corner = p - self.corner;
        let along = |axis: DVec3| from_corner.dot(axis) / axis.length_squared();
        let depth = from_corner.dot(self.forward);
        (depth > 0.0).then(|| DVec3::new(along(self.right), along(self.down), depth))
    }

    fn matrices(&self, film: FilmSize) -> ViewMatrices {
        let [width, height] = film.map(|n| f64::from(n.max(1)));
        let center = self.corner + 0.5 * (self.right * width + self.down * height);
        let axes = [self.right.normalize(), -self.down.normalize(), self.forward];
        let camera_from_world = facts::camera_from_world(center, axes);
        let [across, up] = [self.right.length() * width, self.down.length() * height];
        let ndc_from_camera = DMat4::from_cols(
            DVec4::new(across.recip(), 0.0, 0.0, 0.0),
            DVec4::new(0.0, -up.recip(), 0.0, 0.0),
            DVec4::new(0.0, 0.0, 1.0, 0.0),
            DVec4::new(0.5, 0.5, 0.0, 1.0),
        );
        ViewMatrices {
            camera_from_world,
            ndc_from_world: Some(ndc_from_camera * camera_from_world),
        }
    }

    #[inline]
    fn ray(&self, film: Vec2, _lens: Vec2) -> Option<Ray> {
        let o = self.corner + self.right * f64::from(film.x) + self.down * f64::from(film.y);
        Some(unit_ray(o, self.forward))
    }

    fn pixel_cone(&self) -> RayCone {
        RayCone {
            width: self.right.length() as f32,
            spread: 0.0,
        }
    }

    fn moved(&self, by: DVec3) -> Self {
        Self {
            corner: self.corner + by,
            ..*self
        }
    }

    fn of_eye(&self, _eye: &StereoEye) -> Result<Self, &'static str> {
        Err("the two eyes of an orthographic camera see the same")
    }

    fn between(&self, to: &Self, u: f64) -> Self {
        Self {
            corner: lerp(self.corner, to.corner, u),
            right: lerp(self.right, to.right, u),
            down: lerp(self.down, to.down, u),
            forward: lerp(self.forward, to.forward, u),
        }
    }
}
