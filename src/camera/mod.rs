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
    math::{Ray, Vec2, Vec3},
    value::Problem,
};

mod curve;
pub mod lens;
pub mod path;
pub mod perspective;
pub mod pose;

pub use lens::LensOverrides;
pub use pose::{LookAt, Pose, PoseError, RotationOrder};

/// A film's width and height, in pixels, both at least 1. Pixels are square.
pub type FilmSize = [u32; 2];

/// The contract of every camera before its film.
pub trait CameraKind {
    /// The ray of world space that reaches the film at `film`, with a unit direction, `tmin` 0 and `tmax` infinite.
    ///
    /// `film` counts pixels, x to the right and y downwards from the top left corner of the picture, so that pixel
    /// centres are at .5; it may lie outside of the picture. `lens` is two uniform numbers in `[0, 1)` that choose a point
    /// of the aperture; a camera without one ignores them.
    fn ray(&self, film: Vec2, lens: Vec2) -> Ray;

    /// Whether [`CameraKind::ray`] reads `lens`.
    fn has_lens(&self) -> bool;

    /// The unit line of sight, along which depth counts; `None` where there is none.
    fn axis(&self) -> Option<Vec3> {
        None
    }
}

/// The contract of every lens.
pub trait LensKind: Sized {
    type Camera: CameraKind;

    /// This lens where `overrides` are silent. `target_distance` (m) is the distance to what is looked at now, if there
    /// is such a thing: a lens that focuses on the target follows it.
    fn overridden(&self, overrides: &LensOverrides, target_distance: Option<f64>) -> Self;

    /// The camera with this lens at `pose` before a film.
    fn camera(&self, pose: &Pose, film: FilmSize) -> Self::Camera;
}

/// Where the scene's own camera stands, and through which lens it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compiled<L> {
    pub pose: Pose,
    pub lens: L,
}

/// The scene's own camera.
pub type SceneCamera = Compiled<Lens>;

macro_rules! cameras {
    ($( $name:literal => $Variant:ident($Camera:ty, $Lens:ty, $Desc:ty), )*) => {
        kinds! {
            /// A camera before a film, flat and without pointers.
            enum Camera / CameraDesc { $( $name => $Variant($Camera, $Desc), )* }
            described only {}
            /// See [`CameraKind::ray`].
            fn ray(&self, film: Vec2, lens: Vec2) -> Ray;
            /// See [`CameraKind::has_lens`].
            fn has_lens(&self) -> bool;
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
            /// See [`LensKind::overridden`].
            pub fn overridden(&self, overrides: &LensOverrides, target_distance: Option<f64>) -> Self {
                match self { $( Self::$Variant(lens) => Self::$Variant(lens.overridden(overrides, target_distance)), )* }
            }
        }

        impl Camera {
            /// The camera at `pose` with `lens` before a film.
            pub fn new(pose: &Pose, lens: &Lens, film: FilmSize) -> Self {
                match lens { $( Lens::$Variant(lens) => Self::$Variant(lens.camera(pose, film)), )* }
            }
        }

        impl CameraDesc {
            /// The pose and the lens that are described.
            ///
            /// # Errors
            /// All that contradicts itself.
            pub fn compile(&self) -> Result<SceneCamera, Vec<Problem>> {
                match self {
                    $( Self::$Variant(desc) => desc.compile().map(|c| Compiled { pose: c.pose, lens: Lens::$Variant(c.lens) }), )*
                }
            }
        }
    };
}

cameras! {
    "perspective" => Perspective(perspective::Perspective, perspective::PerspectiveLens, perspective::PerspectiveDesc),
}
