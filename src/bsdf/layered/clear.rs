//! What clear facets reflect and let pass, under a film and without.

use super::{Layered, Walls};
use crate::{
    bsdf::{
        albedo,
        dielectric::of_two_boundaries,
        fresnel::{dielectric, schlick_term},
    },
    math::{Rgb, Vec3},
};

/// How the reflectance of a clear facet differs from Fresnel's: it is scaled, and a part of the rest is reflected too.
pub(super) struct Shine {
    scale: Rgb,
    more: Rgb,
}

impl Shine {
    /// Of what is not clear.
    pub const NONE: Self = Self {
        scale: Rgb::BLACK,
        more: Rgb::BLACK,
    };
}

impl Layered {
    /// What the walls reflect by Fresnel's equations at the cosine `cos`.
    fn fresnel(&self, cos: f32, eta: f32) -> f32 {
        let once = dielectric(cos, eta);
        match self.walls {
            Walls::Thin => of_two_boundaries(once),
            Walls::Solid => once,
        }
    }

    /// The shine of clear facets: where a film lies on them, all reflect as much more or less as one does that faces the viewer's
    /// cosine `cos` from the surface's own normal.
    pub(super) fn shine(&self, cos: f32, eta: f32) -> Shine {
        let plain = Shine {
            scale: Rgb::gray(self.specular),
            more: Rgb::BLACK,
        };
        let all = self.fresnel(cos, eta);
        let bare = self.specular * all;
        if self.film.weight == 0.0 || all >= 1.0 {
            return plain;
        }
        let film = self.film.reflectance(Rgb::gray(self.normal_reflectance()), cos);
        let covered = film * self.film.weight + Rgb::gray(bare * (1.0 - self.film.weight));
        Shine {
            scale: covered.map(|r| {
                if r < bare {
                    self.specular * r / bare
                } else {
                    self.specular
                }
            }),
            more: covered.map(|r| ((r - bare) / (1.0 - bare)).max(0.0)),
        }
    }

    /// What clear facets of the shine `shine` lose between them, as a factor that makes up for it.
    pub(super) fn clear_gain(&self, shine: &Shine, o: Vec3, mirrors: f32, eta: f32) -> Rgb {
        match self.walls {
            Walls::Thin => Rgb::gray(1.0 / mirrors),
            Walls::Solid => {
                let clear = albedo::boundary(&self.facets, o, eta);
                let scaled = shine.scale * clear.fresnel + (Rgb::WHITE - shine.scale) * clear.passing;
                let all = scaled * (Rgb::WHITE - shine.more) + shine.more * mirrors;
                all.map(|a| 1.0 / a)
            }
        }
    }

    /// What a clear facet reflects and what it lets pass.
    pub(super) fn clear_shares(&self, shine: &Shine, cos: f32, eta: f32) -> (Rgb, Rgb) {
        let all = self.fresnel(cos, eta);
        if all >= 1.0 {
            return (Rgb::WHITE, Rgb::BLACK);
        }
        let grazing = schlick_term(cos);
        let color = self.specular_color.map(|c| c.min(1.0));
        let tint = color + (Rgb::WHITE - color) * grazing;
        let bare = shine.scale * all;
        let rest = Rgb::WHITE - shine.more;
        (tint * bare * rest + shine.more, (Rgb::WHITE - bare) * rest)
    }
}
