//! Cameras: what turns a place on the film into a ray.
//!
//! A camera is made in three steps, because what is known when differs. A [`CameraDesc`] is what the scene file says; it
//! compiles to a [`Pose`] and a [`Lens`], which keeps what was said in the terms in which it was said. A camera path
//! replaces the pose and, in those terms, parts of the lens. [`Camera::new`] puts the two before a film, and only then do
//! a vertical angle, a focal length and an f-number become lengths.
//!
//! A kind is one file with three types, the description, the lens and the camera before a film, and one row below.

use crate::{
    kind::kinds,
    math::{DVec3, Ray, RayCone, Runner, Vec2, Vec3},
    value::{Point, Problem, Spanned},
};

pub mod aperture_shape;
mod curve;
pub mod fisheye;
pub mod frame_camera;
pub mod lens;
pub mod orthographic;
pub mod panorama;
pub mod path;
pub mod perspective;
pub mod pose;

pub use frame_camera::FrameCamera;
pub use lens::LensOverrides;
pub use pose::{LookAt, Pose, PoseError, RotationOrder};

/// A film's width and height, in pixels, both at least 1. Pixels are square.
pub type FilmSize = [u32; 2];

/// The contract of every camera before its film.
pub trait CameraKind {
    /// The ray of world space that reaches the film at `film`, with a unit direction, `tmin` 0 and `tmax` infinite; `None`
    /// where no light reaches the film.
    ///
    /// `film` counts pixels, x to the right and y downwards from the top left corner of the picture, so that pixel
    /// centres are at .5; it may lie outside of the picture. `lens` is two uniform numbers in `[0, 1)` that choose a point
    /// of the aperture; a camera without one ignores them.
    fn ray(&self, film: Vec2, lens: Vec2) -> Option<Ray>;

    /// Appends [`CameraKind::ray`] for each place on the film with its numbers for the lens; where there is none,
    /// [`Ray::NONE`].
    fn rays(&self, _on: impl Runner, film: &[Vec2], lens: &[Vec2], rays: &mut Vec<Ray>) {
        rays_one_by_one(self, film, lens, rays);
    }

    /// Whether [`CameraKind::ray`] reads `lens`.
    fn has_lens(&self) -> bool;

    /// Whether every place in the picture has a ray.
    fn fills_film(&self) -> bool;

    /// What the ray of a pixel in the middle of the picture stands for.
    fn pixel_cone(&self) -> RayCone;

    /// This camera at `u`, from 0 to 1, of a straight way to `to`, which differs from it by little.
    fn between(&self, to: &Self, u: f64) -> Self;
    /// The unit line of sight, along which depth counts; `None` where there is none.
    fn axis(&self) -> Option<Vec3> {
        None
    }
}

/// The contract of every lens.
pub trait LensKind: Sized {
    type Camera: CameraKind;

    /// The columns of a camera path that mean something to it.
    const COLUMNS: &'static [&'static str];

    /// This lens where `overrides` are silent. `target_distance` (m) is the distance to what is looked at now, if there
    /// is such a thing: a lens that focuses on the target follows it.
    fn with_overrides(&self, overrides: &LensOverrides, target_distance: Option<f64>) -> Self;

    /// The camera with this lens at `pose` before a film.
    fn camera(&self, pose: &Pose, film: FilmSize) -> Self::Camera;
}

/// Where the scene's own camera stands, and through which lens it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSetup<L> {
    pub pose: Pose,
    pub lens: L,
}

/// The scene's own camera.
pub type SceneCamera = CameraSetup<Lens>;

/// The pose at `eye` that looks at `target`, as a scene file says them.
fn look_at(eye: Point, target: &Spanned<Point>, up: Point) -> Result<Pose, Problem> {
    let at = LookAt {
        target: target.as_ref().0.as_dvec3(),
        up: up.0.as_dvec3(),
        roll: 0.0,
    };
    Pose::look_at(eye.0.as_dvec3(), &at).map_err(|e| Problem::at(target.span(), e.to_string()))
}

/// Upwards, where a scene file does not say.
fn default_up() -> Point {
    Point(Vec3::Y)
}

/// The ray from `o` along `d`, brought to unit length.
#[inline(always)]
fn unit_ray(o: DVec3, d: DVec3) -> Ray {
    Ray::new(o.as_vec3(), unit(d))
}

/// [`CameraKind::rays`] of a camera that has no faster way.
#[inline]
fn rays_one_by_one<C: CameraKind + ?Sized>(camera: &C, film: &[Vec2], lens: &[Vec2], rays: &mut Vec<Ray>) {
    let places = film.iter().zip(lens);
    rays.extend(places.map(|(film, lens)| camera.ray(*film, *lens).unwrap_or(Ray::NONE)));
}

/// `d`, brought to unit length.
#[inline(always)]
fn unit(d: DVec3) -> Vec3 {
    (d * d.length_recip()).as_vec3()
}

/// `a` at 0 and `b` at 1; `a` itself where the two are the same.
fn lerp(a: DVec3, b: DVec3, u: f64) -> DVec3 {
    a + (b - a) * u
}

macro_rules! cameras {
    ($( $name:literal => $Variant:ident($Camera:ty, $Lens:ty, $Desc:ty), )*) => {
        kinds! {
            /// A camera before a film, flat and without pointers.
            enum Camera / CameraDesc { $( $name => $Variant($Camera, $Desc), )* }
            described only {}
            /// See [`CameraKind::ray`].
            fn ray(&self, film: Vec2, lens: Vec2) -> Option<Ray>;
            /// See [`CameraKind::rays`].
            fn rays(&self, on: impl Runner, film: &[Vec2], lens: &[Vec2], rays: &mut Vec<Ray>);
            /// See [`CameraKind::has_lens`].
            fn has_lens(&self) -> bool;
            /// See [`CameraKind::fills_film`].
            fn fills_film(&self) -> bool;
            /// See [`CameraKind::pixel_cone`].
            fn pixel_cone(&self) -> RayCone;
            /// See [`CameraKind::axis`].
            fn axis(&self) -> Option<Vec3>;
        }

        impl Default for Lens {
            /// The perspective lens of a camera of which nothing is said.
            fn default() -> Self {
                Self::Perspective(perspective::PerspectiveLens::default())
            }
        }

        /// A lens, as it was described; it becomes a [`Camera`] before a film.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Lens { $( $Variant($Lens), )* }

        impl Lens {
            /// The name that scene files have for its camera.
            pub fn name(&self) -> &'static str {
                match self { $( Self::$Variant(_) => $name, )* }
            }

            /// The columns that `overrides` come from and that mean nothing to this lens.
            pub fn unsupported_columns(&self, overrides: &LensOverrides) -> Vec<&'static str> {
                let known = match self { $( Self::$Variant(_) => <$Lens as LensKind>::COLUMNS, )* };
                overrides.columns().filter(|c| !known.contains(c)).collect()
            }

            /// See [`LensKind::with_overrides`].
            pub fn with_overrides(&self, overrides: &LensOverrides, target_distance: Option<f64>) -> Self {
                match self { $( Self::$Variant(lens) => Self::$Variant(lens.with_overrides(overrides, target_distance)), )* }
            }
        }

        impl Camera {
            /// The camera at `pose` with `lens` before a film.
            pub fn new(pose: &Pose, lens: &Lens, film: FilmSize) -> Self {
                match lens { $( Lens::$Variant(lens) => Self::$Variant(lens.camera(pose, film)), )* }
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
            /// The pose and the lens that are described.
            ///
            /// # Errors
            /// All that contradicts itself.
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
}

#[cfg(test)]
mod tests;
