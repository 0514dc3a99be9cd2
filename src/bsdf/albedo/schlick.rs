//! The albedo of facets that reflect all light, and of facets that reflect as Schlick says.

use super::{anisotropic, isotropic, mirrors::MirrorFacets, table::column};
use crate::{
    bsdf::{
        fresnel,
        microfacet::{Facets, Ggx},
    },
    math::{
        Vec2, Vec3,
        block::{Each, LANES, get},
    },
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
        weights(all, part, above)
    }
}

impl MirrorFacets for Ggx {
    type Albedo = FacetAlbedo;

    #[inline]
    fn albedo(&self) -> FacetAlbedo {
        FacetAlbedo::new(self)
    }

    #[inline]
    fn mirrors(&self, albedo: &FacetAlbedo, wo: Vec3) -> f32 {
        albedo.mirrors(self, wo)
    }
}

/// The weights of the reflectances at normal and at grazing incidence; `all` is the albedo of mirrors, and `part` the mean of
/// Schlick's term over the light that they reflect, both without the margins `above`.
#[inline(always)]
fn weights(all: f32, part: f32, above: [f32; 2]) -> [f32; 2] {
    let grazing = all * part + above[1];
    let all = (all + above[0]).min(1.0);
    let grazing = grazing.min(all);
    [all - grazing, grazing]
}

/// Sets the nodes of a lane.
#[inline(always)]
fn set_nodes([low, high]: &mut [[Each; 2]; 2], lane: usize, isotropic::Nodes([of_low, of_high]): isotropic::Nodes) {
    (low[0][lane], low[1][lane]) = (of_low[0], of_low[1]);
    (high[0][lane], high[1][lane]) = (of_high[0], of_high[1]);
}

/// The nodes of a lane.
#[inline(always)]
fn nodes_of([[a, b], [c, d]]: &[[Each; 2]; 2], lane: usize) -> isotropic::Nodes {
    isotropic::Nodes([[a[lane], b[lane]], [c[lane], d[lane]]])
}

/// Rough isotropic facets of some surfaces.
#[derive(Clone, Debug)]
pub struct AlbedoBlock {
    pub alpha: Each,
    places: Each<Option<isotropic::RowPlace>>,
    fractions: Each,
}

impl AlbedoBlock {
    /// The roughest facets in all lanes, whose albedo is of no interest.
    pub const EMPTY: Self = Self {
        alpha: [1.0; LANES],
        places: [None; LANES],
        fractions: [0.0; LANES],
    };

    /// Sets the facets of a lane, if they are rough and isotropic, and returns whether they are.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, albedo: FacetAlbedo, ggx: &Ggx) -> bool {
        let FacetAlbedo::Isotropic(place) = albedo else {
            return false;
        };
        self.alpha[lane] = ggx.alpha.x;
        self.places[lane] = Some(place);
        self.fractions[lane] = place.fraction();
        true
    }

    /// Removes the facets of a lane.
    #[inline(always)]
    pub fn remove(&mut self, lane: usize) {
        (self.alpha[lane], self.places[lane]) = (1.0, None);
    }

    /// The facets of a lane.
    #[inline(always)]
    pub fn facets(&self, lane: usize) -> Ggx {
        let alpha = Vec2::splat(self.alpha[lane]);
        Ggx { alpha }
    }

    /// [`FacetAlbedo::mirrors`] of each surface; small numbers without a meaning where there are no facets.
    #[inline(always)]
    pub fn mirrors(&self, wo: &[Each; 3]) -> Each {
        let (mut columns, mut along) = ([0_u32; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let (i, f) = isotropic::place(column(self.facets(lane).stretched_cos(get(wo, lane))));
            (columns[lane], along[lane]) = (i as u32, f);
        }
        let mut nodes = [[[0.0; LANES]; 2]; 2];
        for (lane, place) in self.places.iter().enumerate() {
            let Some(place) = place else { continue };
            set_nodes(&mut nodes, lane, place.rows().mirrors_about(columns[lane] as usize));
        }
        let mut found = [0.0; LANES];
        for lane in 0..LANES {
            let mirrors = nodes_of(&nodes, lane).between(along[lane], self.fractions[lane]);
            found[lane] = (mirrors + MARGIN[0]).min(1.0);
        }
        found
    }

    /// [`FacetAlbedo::schlick`] of each surface; small numbers without a meaning where there are no facets.
    #[inline(always)]
    pub fn schlick(&self, wo: &[Each; 3]) -> [Each; 2] {
        let (mut columns, mut along) = ([[0_u32; LANES]; 2], [[0.0; LANES]; 2]);
        for lane in 0..LANES {
            let wo = get(wo, lane);
            let (hidden, f) = isotropic::place(column(self.facets(lane).stretched_cos(wo)));
            let (seen, g) = isotropic::place(column(wo.z.abs()));
            (columns[0][lane], columns[1][lane]) = (hidden as u32, seen as u32);
            (along[0][lane], along[1][lane]) = (f, g);
        }
        let mut nodes = [[[[0.0; LANES]; 2]; 2]; 2];
        for (lane, place) in self.places.iter().enumerate() {
            let Some(place) = place else { continue };
            let rows = place.rows();
            let [mirrors, grazing] = &mut nodes;
            set_nodes(mirrors, lane, rows.mirrors_about(columns[0][lane] as usize));
            set_nodes(grazing, lane, rows.grazing_about(columns[1][lane] as usize));
        }
        let mut found = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            let mut values = [0.0; 2];
            for k in 0..2 {
                values[k] = nodes_of(&nodes[k], lane).between(along[k][lane], self.fractions[lane]);
            }
            let [a, b] = weights(values[0], values[1], MARGIN);
            (found[0][lane], found[1][lane]) = (a, b);
        }
        found
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
