//! The description of a layered surface at a point.

use super::hero_channel::HeroChannel;
use crate::{
    bsdf::{
        EQUAL_IOR, is_equal_ior,
        microfacet::{Facets as _, Ggx},
        thin_film::ThinFilm,
    },
    math::{Rgb, Vec2, Vec3},
};

/// The boundary of a surface: a thin sheet or a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// A thin sheet; light is transmitted without refraction.
    ThinWalled,
    /// The boundary of a volume; light is refracted.
    Solid,
}

/// The layers of a surface at a point, as its material has them.
#[derive(Clone, Copy, Debug)]
pub struct Layers {
    /// The colour of metal at normal incidence, of the diffuse base, and of transmitted light.
    pub base_color: Rgb,
    /// The fraction of metal.
    pub metallic: f32,
    /// The transparent fraction of the rest.
    pub transmission: f32,
    /// The part of the diffuse base's light that leaves on the other side, and its colour.
    pub diffuse_transmission: f32,
    pub diffuse_transmission_color: Rgb,
    /// The facets of metal and of boundaries; isotropic where light passes into a solid.
    pub facets: Ggx,
    /// Cosine and sine of the angle from the frame's first axis to that of the facets, towards the second one.
    pub rotation: Vec2,
    /// Index of refraction behind the surface over that in front.
    pub ior: f32,
    /// 20 over the Abbe number of a solid; 0 is none.
    pub dispersion: f32,
    /// The channel whose index `ior` is, in a dispersive solid.
    pub hero: Option<HeroChannel>,
    pub boundary: Boundary,
    /// Strength of the boundary's reflection.
    pub specular: f32,
    /// Colour of the boundary's reflection at normal incidence.
    pub specular_color: Rgb,
    pub thin_film: ThinFilm,
    /// The coated fraction.
    pub coat: f32,
    pub coat_facets: Ggx,
    /// The unit normal of the coat on the front, in the shading frame.
    pub coat_normal: Vec3,
    pub sheen: Rgb,
    pub sheen_roughness: f32,
}

impl Default for Layers {
    /// A white diffuse base under a rough dielectric.
    fn default() -> Self {
        Self {
            base_color: Rgb::WHITE,
            metallic: 0.0,
            transmission: 0.0,
            diffuse_transmission: 0.0,
            diffuse_transmission_color: Rgb::WHITE,
            facets: Ggx::new(Vec2::ONE),
            rotation: Vec2::X,
            ior: 1.5,
            dispersion: 0.0,
            hero: None,
            boundary: Boundary::ThinWalled,
            specular: 1.0,
            specular_color: Rgb::WHITE,
            thin_film: ThinFilm::NONE,
            coat: 0.0,
            coat_facets: Ggx::SMOOTH,
            coat_normal: Vec3::Z,
            sheen: Rgb::BLACK,
            sheen_roughness: 0.0,
        }
    }
}

impl Layers {
    pub(super) fn normal_reflectance(&self) -> f32 {
        let r = (self.ior - 1.0) / (self.ior + 1.0);
        r * r
    }

    /// The reflectance of the boundary at normal incidence, without a thin film.
    pub fn reflectance_of_boundary(&self) -> Rgb {
        let f0 = self.normal_reflectance();
        self.specular_color.map(|c| (c * f0).min(1.0)) * self.specular
    }

    /// The parts of the three kinds of base: metal, diffuse and clear.
    pub(super) fn parts(&self) -> [f32; 3] {
        let metal = self.metallic;
        let clear = (1.0 - metal) * self.transmission;
        [metal, (1.0 - metal - clear).max(0.0), clear]
    }

    /// The albedos of the diffuse base on this side and on the other, in the channel where each is largest.
    pub(super) fn diffuse_albedos(&self) -> [f32; 2] {
        [
            self.base_color.max_component() * (1.0 - self.diffuse_transmission),
            self.diffuse_transmission_color.max_component() * self.diffuse_transmission,
        ]
    }

    /// Whether a part of it is a clear boundary.
    pub(super) fn is_clear(&self) -> bool {
        self.transmission > 0.0 && self.metallic < 1.0
    }

    /// The same layers in a medium of the index of refraction `outside`, in place of 1.
    pub fn immersed(self, outside: f32) -> Self {
        Self {
            ior: self.ior / outside,
            ..self
        }
    }

    /// These layers, where rough facets lie between equal media with an index that just counts as another: facets pass light all but
    /// unbent then, and those of a sheet would scatter it.
    pub(super) fn between_media(self) -> Self {
        let is_unbent = self.boundary == Boundary::Solid && !self.facets.is_smooth() && is_equal_ior(self.ior, 1.0);
        Self {
            ior: if is_unbent { 1.0 + 2.0 * EQUAL_IOR } else { self.ior },
            ..self
        }
    }

    /// How the boundary passes light: between equal media it does not refract, like a thin sheet.
    #[inline]
    pub fn refraction(&self) -> Boundary {
        if is_equal_ior(self.ior, 1.0) {
            Boundary::ThinWalled
        } else {
            self.boundary
        }
    }

    /// `w` in the frame of the facets.
    pub(super) fn facet_from_surface(&self, w: Vec3) -> Vec3 {
        Vec3::new(
            w.x * self.rotation.x + w.y * self.rotation.y,
            w.y * self.rotation.x - w.x * self.rotation.y,
            w.z,
        )
    }

    /// `w`, given in the frame of the facets.
    pub(super) fn surface_from_facet(&self, w: Vec3) -> Vec3 {
        Vec3::new(
            w.x * self.rotation.x - w.y * self.rotation.y,
            w.y * self.rotation.x + w.x * self.rotation.y,
            w.z,
        )
    }
}
