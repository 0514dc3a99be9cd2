//! BSDFs: how light is scattered at one place of a surface.
//!
//! A material makes a [`Bsdf`] of what it is at a place; from then on no texture is asked. All directions are unit, leave
//! the surface, and are given in the shading frame: z is the shading normal, positive in front, x the tangent. `wo` points
//! to the viewer, `wi` to the light. For a BSDF that lets nothing through the frame is turned so that `wo.z > 0`; for one
//! that does, the sign of `wo.z` tells the side it is seen from.

use std::ops::Deref;

use crate::math::{Rgb, Sample2D, Vec3};

pub mod albedo;
#[cfg(test)]
mod battery;
pub mod conductor;
pub mod dielectric;
pub mod diffuse;
pub mod fresnel;
pub mod layered;
pub mod microfacet;
pub mod phong;
pub mod sheen;
pub mod specular;
pub mod thin_film;

/// How light left a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lobe {
    /// Widely, on the side it came from.
    Diffuse,
    /// About the mirror direction, however narrow.
    Specular,
    /// Through the surface.
    Transmission,
}

/// What a BSDF says of two directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BsdfEval {
    /// `f |cos|` of the diffuse lobes.
    pub diffuse: Rgb,
    /// `f |cos|` of all other lobes.
    pub glossy: Rgb,
    /// Density of [`BsdfKind::sample`] to choose `wi`, in sr^-1.
    pub pdf: f32,
}

impl BsdfEval {
    /// `f |cos|` of all lobes.
    #[inline]
    pub fn f_cos(&self) -> Rgb {
        self.diffuse + self.glossy
    }
}

/// A direction that a BSDF chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    pub wi: Vec3,
    /// `f |cos| / pdf`, of all lobes that could have chosen `wi`.
    pub weight: Rgb,
    /// The part of `weight` that is of diffuse lobes.
    pub diffuse: Rgb,
    /// Density of `wi` in sr^-1, of all lobes that could have chosen it; `None` where the lobe has but one direction (delta).
    pub pdf: Option<f32>,
    pub lobe: Lobe,
    /// Index of refraction of the side that `wi` is on over that of the side of `wo`; 1 for reflection.
    pub eta: f32,
}

/// The contract of every BSDF.
pub trait BsdfKind {
    /// Zero for delta lobes.
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval;

    /// A direction, by `uc`, which chooses the lobe, and `u`, all uniform in `[0, 1)`; `None` where light ends here.
    fn sample(&self, wo: Vec3, uc: f32, u: Sample2D) -> Option<BsdfSample>;

    /// Whether light passes through.
    fn transmits(&self) -> bool {
        false
    }

    /// Whether the tangent matters; where not, any will do.
    fn reads_tangent(&self) -> bool {
        false
    }

    /// Whether [`BsdfKind::sample`] reads `uc`: there is more than one lobe.
    fn has_lobes(&self) -> bool {
        true
    }

    /// Whether all lobes are delta: asking for [`BsdfKind::eval`] is in vain, so no light needs sampling.
    fn is_delta(&self) -> bool {
        false
    }
}

/// What is done with a BSDF of whatever kind.
pub trait BsdfVisitor {
    /// Compiled for each kind by itself: what that kind never does costs nothing.
    fn visit(self, bsdf: &impl BsdfKind);
}

macro_rules! bsdfs {
    ($( $(#[$doc:meta])* $Variant:ident($Kind:ty), )*) => {
        /// The scattering at one place, flat and without pointers.
        #[derive(Clone, Copy, Debug)]
        pub enum Bsdf { $( $(#[$doc])* $Variant($Kind), )* }

        impl Bsdf {
            /// Calls `visitor` with the kind that this is.
            #[inline(always)]
            pub fn dispatch(&self, visitor: impl BsdfVisitor) {
                match self { $( Self::$Variant(bsdf) => visitor.visit(bsdf), )* }
            }
        }

        /// For who asks little; [`Bsdf::dispatch`] is faster.
        impl Deref for Bsdf {
            type Target = dyn BsdfKind;

            fn deref(&self) -> &Self::Target {
                match self { $( Self::$Variant(bsdf) => bsdf, )* }
            }
        }
    };
}

bsdfs! {
    /// Chalk.
    Lambert(diffuse::Lambert),
    /// A perfect mirror.
    Mirror(specular::Mirror),
    /// Smooth clear glass.
    SmoothDielectric(specular::SmoothDielectric),
    /// Clay.
    OrenNayar(diffuse::OrenNayar),
    /// Metal.
    Conductor(conductor::Conductor),
    /// Frosted glass.
    RoughDielectric(dielectric::RoughDielectric),
    /// Window glass, and thin frosted sheets.
    ThinDielectric(dielectric::ThinDielectric),
    /// Plastic.
    Phong(phong::Phong),
    /// Coats over metal, glass and chalk.
    Layered(layered::Layered),
}
