//! The albedo of facets that reflect all light, and of facets that reflect as Schlick says.

use super::{anisotropic, isotropic};
use crate::{
    bsdf::{fresnel, microfacet::Ggx},
    math::Vec3,
};

/// Margins that keep a table above the exact albedo: for isotropic and anisotropic facets, and for
/// the light that they reflect at grazing angles.
const MARGIN: [f32; 2] = [0.001, 0.0035];
const ANISOTROPIC_MARGIN: [f32; 2] = [0.004, 0.009];

/// The place of facets in the tables of albedos.
#[derive(Clone, Copy, Debug)]
pub enum FacetAlbedo {
    Smooth,
    Isotropic(isotropic::RowPlace),
    Anisotropic,
}

impl FacetAlbedo {
    #[inline]
    pub fn new(ggx: &Ggx) -> Self {
        if ggx.is_smooth() {
            Self::Smooth
        } else if ggx.is_isotropic() {
            Self::Isotropic(isotropic::RowPlace::of_facets(ggx))
        } else {
            Self::Anisotropic
        }
    }

    /// The albedo of these facets, `ggx`, if they reflect all light, seen from `wo`.
    #[inline]
    pub fn mirrors(self, ggx: &Ggx, wo: Vec3) -> f32 {
        match self {
            Self::Smooth => 1.0,
            Self::Isotropic(place) => (place.rows().mirrors(ggx.stretched_cos(wo)) + MARGIN[0]).min(1.0),
            Self::Anisotropic => (anisotropic::mirrors(ggx, wo) + ANISOTROPIC_MARGIN[0]).min(1.0),
        }
    }

    /// The albedo of these facets, `ggx`, if they reflect as Schlick says, seen from `wo`, as weights of the
    /// reflectance at normal incidence and of the one at grazing incidence: the sum is [`FacetAlbedo::mirrors`].
    #[inline]
    pub fn schlick(self, ggx: &Ggx, wo: Vec3) -> [f32; 2] {
        let (all, part, above) = match self {
            Self::Smooth => {
                let grazing = fresnel::schlick_term(wo.z.abs());
                return [1.0 - grazing, grazing];
            }
            Self::Isotropic(place) => {
                let rows = place.rows();
                let all = rows.mirrors(ggx.stretched_cos(wo));
                (all, rows.grazing(wo.z.abs()), MARGIN)
            }
            Self::Anisotropic => brushed(ggx, wo),
        };
        let grazing = all * part + above[1];
        let all = (all + above[0]).min(1.0);
        let grazing = grazing.min(all);
        [all - grazing, grazing]
    }
}

/// The albedo of anisotropic facets, the mean of Schlick's term over the light that they reflect, and the margins of both.
#[inline(never)]
fn brushed(ggx: &Ggx, wo: Vec3) -> (f32, f32, [f32; 2]) {
    (
        anisotropic::mirrors(ggx, wo),
        anisotropic::grazing(ggx, wo),
        ANISOTROPIC_MARGIN,
    )
}
