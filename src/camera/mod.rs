//! Cameras generate a ray for each point of the film.
//!
//! A camera is made in three steps. A [`CameraDesc`] is the description in the scene file. It
//! compiles to a [`Pose`] and a [`Lens`], which keeps its parameters as they were given. A camera
//! path can then replace the pose and parameters of the lens. [`Camera::new`] combines both with
//! the size of the film, which turns a field of view, a focal length and an f-number into lengths.
//!
//! Each kind is one file with three types (description, lens, camera) and one row in the table
//! below.

use serde::Serialize;

use crate::{
    kind::kinds,
    math::{DVec3, Dispatch, Ray, RayCone, Vec2, Vec3},
    value::{Point, Problem, Spanned},
};

pub mod aperture_shape;
mod curve;
pub mod facts;
pub mod fisheye;
pub mod frame_camera;
pub mod intrinsics;
pub mod lens;
pub mod orthographic;
pub mod panorama;
pub mod path;
pub mod perspective;
pub mod pinhole;
mod pinhole_view;
pub mod pose;
pub mod shutter;
mod station;
pub mod stereo;

pub use facts::{DepthOfField, LensFacts, ViewMatrices};
pub use frame_camera::{FrameCamera, Neighbours, PictureCamera};
pub use lens::LensOverrides;
pub use pinhole_view::{CalibratedView, PinholeView, ViewDistortion};
pub use pose::{LookAt, Pose, PoseError, RotationOrder};
pub use shutter::{Readout, ReadoutDirection, Shutter, Timing};
pub use stereo::{SecondEye, StereoEye};

/// A film's width and height, in pixels, both at least 1. Pixels are square.
pub type FilmSize = [u32; 2];

/// The contract of every camera.
pub trait CameraKind {
    /// Returns the world-space ray of a point on the film, with a unit direction, `tmin` 0 and
    /// `tmax` infinite; `None` where no light reaches the film.
    ///
    /// `film` counts pixels, x to the right and y downwards from the top left corner of the
    /// picture, so that pixel centres are at .5; it may lie outside of the picture. `lens` is two
    /// uniform numbers in `[0, 1)` that choose a point of the aperture; a camera without one
    /// ignores them.
    fn ray(&self, film: Vec2, lens: Vec2) -> Option<Ray>;

    /// Appends [`CameraKind::ray`] of each point on the film with its lens sample, [`Ray::NONE`]
    /// where there is none.
    fn rays(&self, _on: impl Dispatch, film: &[Vec2], lens: &[Vec2], rays: &mut Vec<Ray>) {
        rays_one_by_one(self, film, lens, rays);
    }

    /// Whether [`CameraKind::ray`] reads `lens`.
    fn has_lens(&self) -> bool {
        false
    }

    /// Whether every point of the picture has a ray.
    fn fills_film(&self) -> bool {
        true
    }

    /// The share of a picture of this size, from 0 to 1, for which the model of the lens has no
    /// rays although the user expects some.
    fn missing_part(&self, _film: FilmSize) -> f64 {
        0.0
    }

    /// The ray cone of a pixel in the middle of the picture.
    fn pixel_cone(&self) -> RayCone;

    /// Interpolates linearly from this camera (`u` = 0) to `to` (`u` = 1), which must be similar.
    fn between(&self, to: &Self, u: f64) -> Self;

    /// Returns this camera moved by `by`, in m.
    fn moved(&self, by: DVec3) -> Self;

    /// Returns the camera of an eye beside this camera.
    ///
    /// # Errors
    /// Why it has no such eye.
    fn of_eye(&self, eye: &StereoEye) -> Result<Self, &'static str>
    where
        Self: Sized;

    /// The unit direction along which depth is measured; `None` where there is none.
    fn axis(&self) -> Option<Vec3> {
        None
    }

    /// The place on the film, in pixels, of a point in the world, in m, seen through the middle of the lens, and its depth, in
    /// m: along [`CameraKind::axis`], or the distance where there is none. `None` where the camera cannot see it.
    fn project(&self, p: DVec3) -> Option<DVec3>;

    /// The matrices from the world to the camera and to a picture of this size.
    fn matrices(&self, film: FilmSize) -> ViewMatrices;

    /// The lens; `None` for cameras that have none.
    fn lens_facts(&self) -> Option<LensFacts> {
        None
    }

    /// The view as that of a pinhole; `None` for cameras that have no focal length.
    fn pinhole(&self) -> Option<PinholeView> {
        None
    }

    /// The view as data sets say it; `None` for cameras of which they know no model.
    fn calibrated(&self) -> Option<CalibratedView> {
        self.pinhole().map(|view| CalibratedView {
            view,
            distortion: ViewDistortion::None,
        })
    }

    /// The columns after which the picture begins again, where it goes all around.
    fn period(&self) -> Option<f64> {
        None
    }
}

/// The contract of every lens.
pub trait LensKind: Sized {
    type Camera: CameraKind;

    /// The columns of a camera path that the lens supports.
    const COLUMNS: &'static [&'static str];

    /// Returns this lens with the parameters in `overrides` replaced. `target_distance` (m) is the
    /// distance to the current target, if there is one; a lens that focuses on the target follows
    /// it.
    fn with_overrides(&self, overrides: &LensOverrides, target_distance: Option<f64>) -> Self;

    /// Returns the parameters that a camera path can replace, as they are, without those of the sensor.
    fn parameters(&self) -> LensOverrides;

    /// Returns the camera with this lens at `pose` for a film.
    fn camera(&self, pose: &Pose, film: FilmSize) -> Self::Camera;
}

/// The pose and the lens of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CameraSetup<L> {
    pub pose: Pose,
    pub lens: L,
}

/// The camera of the scene file.
pub type SceneCamera = CameraSetup<Lens>;

/// Returns the pose at `eye` that looks at `target`.
fn look_at(eye: Point, target: &Spanned<Point>, up: Point) -> Result<Pose, Problem> {
    let at = LookAt {
        target: target.as_ref().0,
        up: up.0,
        roll: 0.0,
    };
    Pose::look_at(eye.0, &at).map_err(|e| Problem::at(target.span(), e.to_string()))
}

/// The default up direction.
fn default_up() -> Point {
    Point(DVec3::Y)
}

/// Returns the ray from `o` along the normalized `d`.
#[inline(always)]
fn unit_ray(o: DVec3, d: DVec3) -> Ray {
    Ray::new(o.as_vec3(), unit(d))
}

/// [`CameraKind::rays`] for cameras without a vectorized version.
#[inline]
fn rays_one_by_one<C: CameraKind + ?Sized>(camera: &C, film: &[Vec2], lens: &[Vec2], rays: &mut Vec<Ray>) {
    let places = film.iter().zip(lens);
    rays.extend(places.map(|(film, lens)| camera.ray(*film, *lens).unwrap_or(Ray::NONE)));
}

/// Normalizes `d`.
#[inline(always)]
fn unit(d: DVec3) -> Vec3 {
    (d * d.length_recip()).as_vec3()
}

/// Interpolates linearly; exactly `a` where both are equal.
fn lerp(a: DVec3, b: DVec3, u: f64) -> DVec3 {
    a + (b - a) * u
}

macro_rules! cameras {
    ($( $name:literal => $Variant:ident($Camera:ty, $Lens:ty, $Desc:ty), )*) => {
        kinds! {
            /// A camera for a film, flat and without pointers.
            #[derive(Serialize)]
            enum Camera / CameraDesc { $( $name => $Variant($Camera, $Desc), )* }
            described only {}
            /// See [`CameraKind::ray`].
            fn ray(&self, film: Vec2, lens: Vec2) -> Option<Ray>;
            /// See [`CameraKind::rays`].
            fn rays(&self, on: impl Dispatch, film: &[Vec2], lens: &[Vec2], rays: &mut Vec<Ray>);
            /// See [`CameraKind::has_lens`].
            fn has_lens(&self) -> bool;
            /// See [`CameraKind::fills_film`].
            fn fills_film(&self) -> bool;
            /// See [`CameraKind::missing_part`].
            fn missing_part(&self, film: FilmSize) -> f64;
            /// See [`CameraKind::pixel_cone`].
            fn pixel_cone(&self) -> RayCone;
            /// See [`CameraKind::axis`].
            fn axis(&self) -> Option<Vec3>;
            /// See [`CameraKind::project`].
            fn project(&self, p: DVec3) -> Option<DVec3>;
            /// See [`CameraKind::matrices`].
            fn matrices(&self, film: FilmSize) -> ViewMatrices;
            /// See [`CameraKind::lens_facts`].
            fn lens_facts(&self) -> Option<LensFacts>;
            /// See [`CameraKind::pinhole`].
            fn pinhole(&self) -> Option<PinholeView>;
            /// See [`CameraKind::calibrated`].
            fn calibrated(&self) -> Option<CalibratedView>;
            /// See [`CameraKind::period`].
            fn period(&self) -> Option<f64>;
        }

        impl Default for Lens {
            /// The perspective lens with default parameters.
            fn default() -> Self {
                Self::Perspective(perspective::PerspectiveLens::default())
            }
        }

        /// A lens as described; with a film it becomes a [`Camera`].
        #[derive(Clone, Copy, Debug, PartialEq, Serialize)]
        pub enum Lens { $( $Variant($Lens), )* }

        impl Lens {
            /// The name of its camera in scene files.
            pub fn name(&self) -> &'static str {
                match self { $( Self::$Variant(_) => $name, )* }
            }

            /// The columns of `overrides` that this lens does not support.
            pub fn unsupported_columns(&self, overrides: &LensOverrides) -> Vec<&'static str> {
                let known = self.columns();
                overrides.columns().filter(|c| !known.contains(c)).collect()
            }

            /// The columns of a camera path that this lens supports.
            pub fn columns(&self) -> &'static [&'static str] {
                match self { $( Self::$Variant(_) => <$Lens as LensKind>::COLUMNS, )* }
            }

            /// See [`LensKind::parameters`].
            pub fn parameters(&self) -> LensOverrides {
                match self { $( Self::$Variant(lens) => lens.parameters(), )* }
            }

            /// See [`LensKind::with_overrides`].
            pub fn with_overrides(&self, overrides: &LensOverrides, target_distance: Option<f64>) -> Self {
                match self { $( Self::$Variant(lens) => Self::$Variant(lens.with_overrides(overrides, target_distance)), )* }
            }
        }

        impl Camera {
            /// Creates the camera at `pose` with `lens` for a film.
            pub fn new(pose: &Pose, lens: &Lens, film: FilmSize) -> Self {
                match lens { $( Lens::$Variant(lens) => Self::$Variant(lens.camera(pose, film)), )* }
            }

            /// See [`CameraKind::moved`].
            #[inline(never)] // eighteen copies in the cameras of a shutter took 30 kB
            pub fn moved(&self, by: DVec3) -> Self {
                match self { $( Self::$Variant(camera) => Self::$Variant(camera.moved(by)), )* }
            }

            /// See [`CameraKind::of_eye`].
            ///
            /// # Errors
            /// Why it has no such eye.
            pub fn of_eye(&self, eye: &StereoEye) -> Result<Self, &'static str> {
                match self { $( Self::$Variant(camera) => camera.of_eye(eye).map(Self::$Variant), )* }
            }

            /// See [`CameraKind::between`]; `to` is of the same kind.
            #[inline]
            pub fn between(&self, to: &Self, u: f64) -> Self {
                match (self, to) {
                    $( (Self::$Variant(a), Self::$Variant(b)) => Self::$Variant(a.between(b, u)), )*
                    (stays, _) => *stays,
                }
            }
        }

        impl CameraDesc {
            /// Returns the eye point, in m, and the orientation, as they were written.
            pub fn view(&self) -> (DVec3, LookAt) {
                let (eye, target, up) = match self { $( Self::$Variant(desc) => (desc.eye, &desc.target, desc.up), )* };
                let (target, up) = (target.as_ref().0, up.0);
                (eye.0, LookAt { target, up, roll: 0.0 })
            }

            /// Returns the same camera at another eye point and with another target, in m.
            pub fn with_view(mut self, eye: DVec3, target: DVec3) -> Self {
                match &mut self {
                    $( Self::$Variant(desc) => {
                        desc.eye = Point::new(eye);
                        desc.target = Spanned::new(desc.target.span(), Point::new(target));
                    } )*
                }
                self
            }

            /// Returns the described pose and lens.
            ///
            /// # Errors
            /// All contradictions in the description.
            pub fn compile(&self) -> Result<SceneCamera, Vec<Problem>> {
                match self {
                    $( Self::$Variant(desc) => desc.compile().map(|c| CameraSetup { pose: c.pose, lens: Lens::$Variant(c.lens) }), )*
                }
            }
        }
    };
}

cameras! {
    "perspective" => Perspective(perspective::Perspective, perspective::PerspectiveLens, perspective::PerspectiveDesc),
    "orthographic" => Orthographic(orthographic::Orthographic, orthographic::OrthographicLens, orthographic::OrthographicDesc),
    "panorama" => Panorama(panorama::Panorama, panorama::PanoramaLens, panorama::PanoramaDesc),
    "fisheye" => Fisheye(fisheye::Fisheye, fisheye::FisheyeLens, fisheye::FisheyeDesc),
    "pinhole" => Pinhole(pinhole::Pinhole, pinhole::PinholeLens, pinhole::PinholeDesc),
}

#[cfg(test)]
mod tests;
