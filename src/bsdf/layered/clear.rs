//! Reflection and transmission of clear facets, with and without a thin film.

use super::{Boundary, Layered, reflectance::ClearReflectance};
use crate::{
    bsdf::{
        albedo,
        dielectric::double_boundary,
        fresnel::{dielectric, schlick_term},
    },
    math::{Rgb, Vec3},
};

impl Layered {
    /// The reflectance of the boundary by Fresnel's equations at the cosine `cos`.
    fn fresnel(&self, cos: f32, eta: f32) -> f32 {
        let once = dielectric(cos, eta);
        match self.layers.refraction() {
            Boundary::ThinWalled => double_boundary(once),
            Boundary::Solid => once,
        }
    }

    /// The shine of clear facets: where a film lies on them, all reflect as much more or less as
    /// one does that faces the viewer's cosine `cos` from the surface's own normal.
    pub(super) fn clear_reflectance(&self, cos: f32, eta: f32) -> ClearReflectance {
        let plain = ClearReflectance {
            scale: Rgb::gray(self.layers.specular),
            more: Rgb::BLACK,
        };
        let all = self.fresnel(cos, eta);
        let bare = self.layers.specular * all;
        if self.layers.thin_film.weight == 0.0 || all >= 1.0 {
            return plain;
        }
        let film = self
            .layers
            .thin_film
            .reflectance(Rgb::gray(self.layers.normal_reflectance()), cos);
        let covered = film * self.layers.thin_film.weight + Rgb::gray(bare * (1.0 - self.layers.thin_film.weight));
        ClearReflectance {
            scale: covered.map(|r| {
                if r < bare {
                    self.layers.specular * r / bare
                } else {
                    self.layers.specular
                }
            }),
            more: covered.map(|r| ((r - bare) / (1.0 - bare)).max(0.0)),
        }
    }

    /// The factor that compensates the light that clear facets with this reflectance lose by
    /// multiple scattering.
    pub(super) fn clear_gain(&self, reflectance: &ClearReflectance, o: Vec3, mirrors: f32, eta: f32) -> Rgb {
        match self.layers.refraction() {
            Boundary::ThinWalled => Rgb::gray(1.0 / mirrors),
            Boundary::Solid => {
                let clear = albedo::clear(&self.layers.facets, o, eta);
                let scaled = reflectance.scale * clear.fresnel + (Rgb::WHITE - reflectance.scale) * clear.passing;
                let all = scaled * (Rgb::WHITE - reflectance.more) + reflectance.more * mirrors;
                all.map(|a| 1.0 / a)
            }
        }
    }

    /// The fractions of light that a clear facet reflects and transmits.
    pub(super) fn clear_shares(&self, reflectance: &ClearReflectance, cos: f32, eta: f32) -> (Rgb, Rgb) {
        let all = self.fresnel(cos, eta);
        if all >= 1.0 {
            return (Rgb::WHITE, Rgb::BLACK);
        }
        let grazing = schlick_term(cos);
        let color = self.layers.specular_color.map(|c| c.min(1.0));
        let tint = color + (Rgb::WHITE - color) * grazing;
        let bare = reflectance.scale * all;
        let rest = Rgb::WHITE - reflectance.more;
        (tint * bare * rest + reflectance.more, (Rgb::WHITE - bare) * rest)
    }
}
