//! BSDFs: the scattering of light at one point of a surface.
//!
//! A material evaluates its textures at a point and returns a [`Bsdf`]. All directions are unit,
//! leave the surface, and are in the shading frame: z is the shading normal, x the tangent. `wo`
//! points to the viewer, `wi` to the light. For an opaque BSDF the frame is flipped so that `wo.z >
//! 0`; for one that transmits, the sign of `wo.z` is the side of the viewer.

use crate::math::{Rgb, Sample2D, Vec3};

pub use layered::hero_channel::HeroChannel;

pub mod albedo;
#[cfg(test)]
mod battery;
pub mod beckmann;
pub mod block;
pub mod conductor;
pub mod dielectric;
pub mod diffuse;
pub mod folded;
pub mod fresnel;
pub mod layered;
pub mod microfacet;
pub mod phong;
pub mod sheen;
pub mod specular;
pub mod thin_film;

/// Indices of refraction are equal if their ratio differs from 1 by less.
const EQUAL_IOR: f32 = 1e-3;

/// Whether light passes from one medium into another unbent.
pub fn is_equal_ior(a: f32, b: f32) -> bool {
    (a / b - 1.0).abs() < EQUAL_IOR
}

/// The lobe by which light leaves a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lobe {
    /// Diffuse reflection.
    Diffuse,
    /// Reflection about the mirror direction, smooth or rough.
    Specular,
    /// Transmission through the surface.
    Transmission,
}

/// The value of a BSDF for two directions.
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

/// A direction sampled by a BSDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    pub wi: Vec3,
    /// `f |cos| / pdf` of all lobes that can sample `wi`.
    pub weight: Rgb,
    /// The part of `weight` of the diffuse lobes.
    pub diffuse: Rgb,
    /// Density of `wi` in sr^-1, of all lobes that can sample it; `None` for a delta lobe.
    pub pdf: Option<f32>,
    pub lobe: Lobe,
    /// Index of refraction of the side that `wi` is on over that of the side of `wo`; 1 for
    /// reflection.
    pub eta: f32,
}

impl BsdfSample {
    /// Whether the light passes unbent: see [`BsdfKind::straight`].
    #[inline]
    pub fn is_straight(&self) -> bool {
        self.pdf.is_none() && self.lobe == Lobe::Transmission && self.eta == 1.0
    }
}

/// The contract of every BSDF.
pub trait BsdfKind {
    /// The quantities that depend on `wo` alone, which all evaluations and samples of a vertex share.
    type Prepared;

    fn prepare(&self, wo: Vec3) -> Self::Prepared;

    /// Evaluates the BSDF, prepared for `wo`; zero for delta lobes.
    fn eval_prepared(&self, prepared: &Self::Prepared, wo: Vec3, wi: Vec3) -> BsdfEval;

    /// Samples a direction by `uc`, which selects the lobe, and `u`, all uniform in `[0, 1)`;
    /// `None` where the light is absorbed. The BSDF is prepared for `wo`.
    fn sample_prepared(&self, prepared: &Self::Prepared, wo: Vec3, uc: f32, u: Sample2D) -> Option<BsdfSample>;

    /// Does the same as [`BsdfKind::eval_prepared`] for a BSDF that is not prepared.
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        self.eval_prepared(&self.prepare(wo), wo, wi)
    }

    /// Does the same as [`BsdfKind::sample_prepared`] for a BSDF that is not prepared.
    fn sample(&self, wo: Vec3, uc: f32, u: Sample2D) -> Option<BsdfSample> {
        self.sample_prepared(&self.prepare(wo), wo, uc, u)
    }

    /// Whether the surface transmits light.
    fn transmits(&self) -> bool {
        false
    }

    /// The weight of the light that passes unbent, as if the surface were only a filter: that of a delta lobe of
    /// [`BsdfKind::sample`] in the direction `-wo`.
    fn straight(&self, _wo: Vec3) -> Rgb {
        Rgb::BLACK
    }

    /// Whether a smooth boundary reflects all light that arrives at the cosine `wo_z`, below 0 from inside.
    fn reflects_totally(&self, _wo_z: f32) -> bool {
        false
    }

    /// Whether light is reflected about the mirror direction, so that the shading normal must not turn that below the
    /// surface.
    fn mirrors(&self) -> bool {
        true
    }

    /// Whether the BSDF depends on the tangent.
    fn reads_tangent(&self) -> bool {
        false
    }

    /// Whether the BSDF depends on which side of the tangent the bitangent of the surface is.
    fn reads_bitangent(&self) -> bool {
        false
    }

    /// Makes the BSDF of a bitangent along the second axis of the shading frame that of one in the opposite direction.
    fn mirror_bitangent(&mut self) {}

    /// Whether there is a clear coat, which may have a normal of its own.
    fn has_coat(&self) -> bool {
        false
    }

    /// Gives the coat another normal than that of the shading frame: unit, in that frame, on the front.
    fn set_coat_normal(&mut self, _normal: Vec3) {}

    /// Whether there is more than one lobe, so that [`BsdfKind::sample`] reads `uc`.
    fn has_lobes(&self) -> bool {
        true
    }

    /// The same surface in a medium with the index of refraction `outside` instead of 1; `None` if that changes nothing.
    fn immersed(&self, outside: f32) -> Option<Bsdf>;

    /// The albedo of Lambert's model; `None` for all others.
    fn lambert_albedo(&self) -> Option<Rgb> {
        None
    }

    /// Whether it refracts red, green and blue in different directions.
    fn disperses(&self) -> bool {
        false
    }

    /// The same surface for paths that follow one channel; `None` if that changes nothing.
    fn for_channel(&self, _hero: HeroChannel) -> Option<Bsdf> {
        None
    }

    /// Whether all lobes are delta, so that [`BsdfKind::eval`] is zero and lights need not be
    /// sampled.
    fn is_delta(&self) -> bool {
        false
    }
}

/// A generic operation on a BSDF of any kind.
pub trait BsdfVisitor {
    /// Visits the BSDF. The method is compiled for each kind, so unused branches are removed.
    fn visit(self, bsdf: &(impl BsdfKind + Copy));
}

macro_rules! bsdfs {
    ($( $(#[$doc:meta])* $Variant:ident($Kind:ty), )*) => {
        /// A BSDF, flat and without pointers.
        #[derive(Clone, Copy, Debug)]
        pub enum Bsdf { $( $(#[$doc])* $Variant($Kind), )* }

        impl Bsdf {
            /// The names of all kinds.
            #[cfg(test)]
            const NAMES: &[&str] = &[$( stringify!($Variant), )*];

            /// Calls `visitor` with the concrete kind.
            #[inline(always)]
            pub fn dispatch(&self, visitor: impl BsdfVisitor) {
                match self { $( Self::$Variant(bsdf) => visitor.visit(bsdf), )* }
            }
        }

        /// Each method matches on the kind; [`Bsdf::dispatch`] matches once for several of them.
        impl BsdfKind for Bsdf {
            type Prepared = ();

            fn prepare(&self, _wo: Vec3) {}

            fn eval_prepared(&self, (): &(), wo: Vec3, wi: Vec3) -> BsdfEval {
                match self { $( Self::$Variant(bsdf) => bsdf.eval(wo, wi), )* }
            }

            fn sample_prepared(&self, (): &(), wo: Vec3, uc: f32, u: Sample2D) -> Option<BsdfSample> {
                match self { $( Self::$Variant(bsdf) => bsdf.sample(wo, uc, u), )* }
            }

            fn transmits(&self) -> bool {
                match self { $( Self::$Variant(bsdf) => bsdf.transmits(), )* }
            }

            fn straight(&self, wo: Vec3) -> Rgb {
                match self { $( Self::$Variant(bsdf) => bsdf.straight(wo), )* }
            }

            fn reflects_totally(&self, wo_z: f32) -> bool {
                match self { $( Self::$Variant(bsdf) => bsdf.reflects_totally(wo_z), )* }
            }

            fn mirrors(&self) -> bool {
                match self { $( Self::$Variant(bsdf) => bsdf.mirrors(), )* }
            }

            fn reads_tangent(&self) -> bool {
                match self { $( Self::$Variant(bsdf) => bsdf.reads_tangent(), )* }
            }

            fn reads_bitangent(&self) -> bool {
                match self { $( Self::$Variant(bsdf) => bsdf.reads_bitangent(), )* }
            }

            fn mirror_bitangent(&mut self) {
                match self { $( Self::$Variant(bsdf) => bsdf.mirror_bitangent(), )* }
            }

            fn has_coat(&self) -> bool {
                match self { $( Self::$Variant(bsdf) => bsdf.has_coat(), )* }
            }

            fn set_coat_normal(&mut self, normal: Vec3) {
                match self { $( Self::$Variant(bsdf) => bsdf.set_coat_normal(normal), )* }
            }

            fn has_lobes(&self) -> bool {
                match self { $( Self::$Variant(bsdf) => bsdf.has_lobes(), )* }
            }

            fn immersed(&self, outside: f32) -> Option<Bsdf> {
                match self { $( Self::$Variant(bsdf) => bsdf.immersed(outside), )* }
            }

            fn lambert_albedo(&self) -> Option<Rgb> {
                match self { $( Self::$Variant(bsdf) => bsdf.lambert_albedo(), )* }
            }

            fn disperses(&self) -> bool {
                match self { $( Self::$Variant(bsdf) => bsdf.disperses(), )* }
            }

            fn for_channel(&self, hero: HeroChannel) -> Option<Bsdf> {
                match self { $( Self::$Variant(bsdf) => bsdf.for_channel(hero), )* }
            }

            fn is_delta(&self) -> bool {
                match self { $( Self::$Variant(bsdf) => bsdf.is_delta(), )* }
            }
        }
    };
}

bsdfs! {
    /// Smooth diffuse.
    Lambert(diffuse::Lambert),
    /// A perfect mirror.
    Mirror(specular::Mirror),
    /// Smooth clear glass.
    SmoothDielectric(specular::SmoothDielectric),
    /// Rough diffuse.
    OrenNayar(diffuse::OrenNayar),
    /// Metal.
    Conductor(conductor::Conductor),
    /// Frosted glass.
    RoughDielectric(dielectric::RoughDielectric),
    /// Window glass, and thin frosted sheets.
    ThinDielectric(dielectric::ThinDielectric),
    /// Metal with the distribution of Beckmann.
    BeckmannConductor(conductor::Conductor<beckmann::Beckmann>),
    /// Frosted glass with it.
    BeckmannDielectric(dielectric::RoughDielectric<beckmann::Beckmann>),
    /// Thin frosted sheets with it.
    BeckmannPane(dielectric::ThinDielectric<beckmann::Beckmann>),
    /// Plastic.
    Phong(phong::Phong),
    /// Layers over metal, dielectric and diffuse.
    Layered(layered::Layered),
}

impl Bsdf {
    /// The same surface in a medium of the index of refraction `outside`, in place of 1.
    pub fn immersed(self, outside: f32) -> Self {
        BsdfKind::immersed(&self, outside).unwrap_or(self)
    }
}

impl From<layered::Layers> for Bsdf {
    fn from(layers: layered::Layers) -> Self {
        Self::Layered(layered::Layered::new(layers))
    }
}
