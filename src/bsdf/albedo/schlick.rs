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

/// The albedo of facets that reflect all light, seen from `wo`.
#[inline]
pub fn mirrors(ggx: &Ggx, wo: Vec3) -> f32 {
    if ggx.is_smooth() {
        1.0
    } else if ggx.is_isotropic() {
        (isotropic::mirrors(ggx, wo) + MARGIN[0]).min(1.0)
    } else {
        (anisotropic::mirrors(ggx, wo) + ANISOTROPIC_MARGIN[0]).min(1.0)
    }
}

/// The albedo of facets that reflect as Schlick says, seen from `wo`, as weights of the reflectance
/// at normal incidence and of the one at grazing incidence: the sum is [`mirrors`].
#[inline]
pub fn schlick(ggx: &Ggx, wo: Vec3) -> [f32; 2] {
    if ggx.is_smooth() {
        let grazing = fresnel::schlick_term(wo.z.abs());
        return [1.0 - grazing, grazing];
    }
    let (all, part, above) = if ggx.is_isotropic() {
        let rows = isotropic::RowPair::of_facets(ggx);
        (rows.mirrors(ggx.stretched_cos(wo)), rows.grazing(wo.z.abs()), MARGIN)
    } else {
        (
            anisotropic::mirrors(ggx, wo),
            anisotropic::grazing(ggx, wo),
            ANISOTROPIC_MARGIN,
        )
    };
    let grazing = all * part + above[1];
    let all = (all + above[0]).min(1.0);
    let grazing = grazing.min(all);
    [all - grazing, grazing]
}
