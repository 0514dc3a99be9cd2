//! The lights of a scene, and the selection of some of them.
//!
//! Lights are numbered: first the analytic lights, in the order of the scene file, then the
//! emitters, then the background if it is sampled.
//!
//! At each point one light of each family ([`LightFamily`]) is sampled: a choice between families would only add noise. The
//! suns that can contribute are equally likely. Finite lights are selected by two light trees, one for point lights and
//! one for surfaces; see [`crate::light::tree`].

use std::sync::Arc;

use super::{EmitterId, Emitters, LightId, SceneGeometry, SceneShading, lamps::Lamps};
use crate::{
    light::{
        Light, LightTables, Picture, PictureMap,
        tree::{LightTree, TreeChoice},
    },
    math::{Dispatch, Rgb, Vec3, block::LANES},
};

/// A point whose illumination is sampled.
#[derive(Clone, Copy, Debug)]
pub struct LightSampleContext {
    pub p: Vec3,
    /// Unit shading normal; zero if light from all sides contributes.
    pub n: Vec3,
}

/// A family of lights, each of which is sampled on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightFamily {
    /// Finite lights: points and surfaces.
    Finite,
    /// Infinite lights, except the background.
    Suns,
    Background,
}

impl LightFamily {
    pub const ALL: [Self; 3] = [Self::Finite, Self::Suns, Self::Background];
}

/// A light that was selected for a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledLight {
    pub light: LightId,
    /// The probability of the selection among its family.
    pub pmf: f32,
}

/// A point for which [`Lights::choose_all`] selects a light.
#[derive(Clone, Copy, Debug)]
pub struct LightChoice {
    pub at: LightSampleContext,
    /// Uniform in `[0, 1)`.
    u: f64,
    /// The light; `None` if none can contribute.
    pub chosen: Option<SampledLight>,
}

impl LightChoice {
    /// A point at the origin.
    pub const EMPTY: Self = Self {
        at: LightSampleContext {
            p: Vec3::ZERO,
            n: Vec3::ZERO,
        },
        u: 0.0,
        chosen: None,
    };

    /// The point `at`, with a uniform number in `[0, 1)`.
    #[inline(always)]
    pub fn new(at: LightSampleContext, u: f64) -> Self {
        Self { at, u, chosen: None }
    }
}

/// The source of a light.
#[derive(Clone, Copy, Debug)]
pub enum LightSource<'a> {
    Analytic(&'a Light),
    Emitter(EmitterId),
    Background,
}

/// All lights.
#[derive(Clone, Debug)]
pub struct Lights {
    all: Arc<[Light]>,
    /// The pictures of `all`; empty if no light has one.
    pictures: Vec<Option<Arc<PictureMap>>>,
    emitters: Emitters,
    background: Option<LightId>,
    /// The infinite lights, except the background.
    infinite: Vec<LightId>,
    /// The `infinite` lights with a disk of nonzero size.
    suns: Vec<LightId>,
    /// Whether the camera sees one of these, before a background that it sees.
    has_visible_suns: bool,
    lamps: Lamps,
    /// The finite analytic lights, by their numbers in the tree.
    points: Vec<LightId>,
    point_tree: LightTree,
    emitter_tree: LightTree,
    dark_emitters: usize,
    /// The only finite light, if there is exactly one.
    only_finite: Option<LightId>,
    /// The families that have lights.
    families: Vec<LightFamily>,
}

impl Lights {
    /// Collects the analytic lights, the surfaces that emit, and the background.
    pub fn new(geometry: &SceneGeometry, shading: &SceneShading) -> Self {
        Self::with_pictures(geometry, shading, pictures(shading, |_, _| None))
    }

    /// The lights after a change of other things than textures.
    pub fn renewed(&self, geometry: &SceneGeometry, shading: &SceneShading) -> Self {
        let known = |light: usize, new: &Picture| {
            let is_same = self.all.get(light).and_then(Light::picture) == Some(new);
            self.pictures.get(light).filter(|_| is_same)?.clone()
        };
        Self::with_pictures(geometry, shading, pictures(shading, known))
    }

    fn with_pictures(geometry: &SceneGeometry, shading: &SceneShading, pictures: Vec<Option<Arc<PictureMap>>>) -> Self {
        let (all, tables) = (Arc::clone(&shading.lights), shading.light_tables());
        let emitters = Emitters::collect(geometry, shading);
        let bounds = emitters.bounds(geometry, shading);
        let radiance = &shading.background.radiance;
        let (mut points, mut point_bounds, mut infinite, mut suns) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (light, id) in all.iter().zip((0..).map(LightId)) {
            let bounds = light.bounds(&LightTables {
                picture: picture(&pictures, id),
                ..tables
            });
            if light.has_size() && bounds.is_none() {
                suns.push(id);
            }
            match bounds {
                Some(bounds) => {
                    points.push(id);
                    point_bounds.push(bounds);
                }
                None => infinite.push(id),
            }
        }
        let background = LightId(all.len() as u32 + emitters.count());
        let only_finite = match (&points[..], emitters.count()) {
            (&[point], 0) => Some(point),
            ([], 1) => Some(LightId(all.len() as u32)),
            _ => None,
        };
        let has_family = |family: &LightFamily| match family {
            LightFamily::Finite => !points.is_empty() || emitters.count() > 0,
            LightFamily::Suns => !infinite.is_empty(),
            LightFamily::Background => radiance.is_sampled(),
        };
        Self {
            families: LightFamily::ALL.into_iter().filter(has_family).collect(),
            lamps: Lamps::of(&all),
            emitters,
            background: radiance.is_sampled().then_some(background),
            infinite,
            has_visible_suns: shading.background.visible
                && shading.background.backdrop.is_none()
                && suns.iter().any(|sun| all[sun.0 as usize].is_seen_by_camera()),
            suns,
            all,
            pictures,
            points,
            point_tree: LightTree::build(point_bounds.into_iter()),
            dark_emitters: bounds.without_area,
            emitter_tree: LightTree::build(bounds.all.into_iter()),
            only_finite,
        }
    }

    /// The analytic lights.
    pub fn all(&self) -> &[Light] {
        &self.all
    }

    /// The light of the picture of an analytic light, if it has one.
    #[inline]
    pub fn picture(&self, light: LightId) -> Option<&PictureMap> {
        picture(&self.pictures, light)
    }

    /// Whether an analytic light has a picture.
    pub fn has_pictures(&self) -> bool {
        !self.pictures.is_empty()
    }

    pub fn emitters(&self) -> &Emitters {
        &self.emitters
    }

    /// The number of emitters that give no light because they have no area.
    pub fn dark_emitters(&self) -> usize {
        self.dark_emitters
    }

    /// The background, if it is sampled.
    pub fn background(&self) -> Option<LightId> {
        self.background
    }

    pub fn source(&self, light: LightId) -> LightSource<'_> {
        if let Some(own) = self.all.get(light.0 as usize) {
            return LightSource::Analytic(own);
        }
        if self.background == Some(light) {
            return LightSource::Background;
        }
        LightSource::Emitter(EmitterId(light.0 - self.all.len() as u32))
    }

    pub fn of_emitter(&self, emitter: EmitterId) -> LightId {
        LightId(self.all.len() as u32 + emitter.0)
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.families.is_empty()
    }

    /// Whether [`Lights::choose`] reads its number for any family.
    pub fn has_choice(&self) -> bool {
        self.infinite.len() > 1 || (self.has_finite() && self.only_finite.is_none())
    }

    /// Whether the choice of a light of the family depends on the normal of the surface that it lights.
    #[inline]
    pub fn depends_on_normal(&self, family: LightFamily) -> bool {
        match family {
            LightFamily::Finite => self.only_finite.is_none(),
            LightFamily::Suns => true,
            LightFamily::Background => false,
        }
    }

    #[inline]
    pub fn has_finite(&self) -> bool {
        self.families.first() == Some(&LightFamily::Finite)
    }

    /// The families that have lights.
    #[inline]
    pub fn families(&self) -> impl Iterator<Item = LightFamily> {
        self.families.iter().copied()
    }

    /// The number of lights.
    pub fn count(&self) -> u32 {
        self.all.len() as u32 + self.emitters.count() + u32::from(self.background.is_some())
    }

    /// The suns whose disk contains the unit direction `w`, with the radiance in W m^-2 sr^-1 and the density of that
    /// direction in sr^-1.
    #[inline]
    pub fn suns(&self, w: Vec3) -> impl Iterator<Item = (LightId, Rgb, f32)> {
        self.suns.iter().filter_map(move |&id| {
            let found = self.all[id.0 as usize].radiance_towards(w);
            found.map(|(l, pdf)| (id, l, pdf))
        })
    }

    /// Whether the camera sees one of [`Self::suns`].
    #[inline]
    pub fn has_visible_suns(&self) -> bool {
        self.has_visible_suns
    }

    /// The lights with a surface that rays find.
    #[inline]
    pub fn lamps(&self) -> &Lamps {
        &self.lamps
    }

    fn reaches(&self, light: LightId, at: &LightSampleContext) -> bool {
        self.all[light.0 as usize].reaches(at.p, at.n)
    }

    /// The infinite lights that contribute at a point.
    fn reaching<'a>(&'a self, at: &'a LightSampleContext) -> impl Iterator<Item = LightId> + Clone + 'a {
        self.infinite.iter().copied().filter(|l| self.reaches(*l, at))
    }

    /// The probability of point lights among finite lights; `None` if no finite light contributes.
    fn pmf_points(&self, at: &LightSampleContext) -> Option<f64> {
        if self.point_tree.is_empty() || self.emitter_tree.is_empty() {
            return Some(if self.point_tree.is_empty() { 0.0 } else { 1.0 });
        }
        let [points, surfaces] = [&self.point_tree, &self.emitter_tree].map(|tree| tree.importance(at.p, at.n));
        (points + surfaces > 0.0).then(|| points / (points + surfaces))
    }

    /// Selects a light of a family for the point `at`, by a uniform number in `[0, 1)`; `None` if none can contribute.
    pub fn choose(
        &self,
        on: impl Dispatch,
        family: LightFamily,
        at: &LightSampleContext,
        u: f64,
    ) -> Option<SampledLight> {
        let mut point = LightChoice::new(*at, u);
        self.choose_all(on, family, std::slice::from_mut(&mut point));
        point.chosen
    }

    /// Does the same for each of up to [`LANES`] points.
    pub fn choose_all(&self, on: impl Dispatch, family: LightFamily, points: &mut [LightChoice]) {
        match family {
            LightFamily::Finite if self.only_finite.is_none() => self.choose_finite(on, points),
            LightFamily::Finite | LightFamily::Background => {
                let only = match family {
                    LightFamily::Background => self.background,
                    _ => self.only_finite,
                };
                for point in points {
                    point.chosen = only.map(|light| SampledLight { light, pmf: 1.0 });
                }
            }
            LightFamily::Suns => {
                for point in points {
                    point.chosen = self.choose_sun(point);
                }
            }
        }
    }

    fn choose_sun(&self, point: &LightChoice) -> Option<SampledLight> {
        let reaching = self.reaching(&point.at);
        let count = reaching.clone().count();
        let which = ((point.u * count as f64) as usize).min(count.checked_sub(1)?);
        let pmf = 1.0 / count as f32;
        reaching.into_iter().nth(which).map(|light| SampledLight { light, pmf })
    }

    fn choose_finite(&self, on: impl Dispatch, points: &mut [LightChoice]) {
        let mut choices = [TreeChoice::new(Vec3::ZERO, Vec3::ZERO, 0.0); LANES];
        // The lanes of each tree, and the probability of the tree.
        let (mut of_points, mut of_surfaces, mut pmf) = (0, 0, [0.0; LANES]);
        for (lane, point) in points.iter_mut().enumerate().take(LANES) {
            point.chosen = None;
            let at = &point.at;
            let Some(pmf_points) = self.pmf_points(at) else {
                continue;
            };
            let rest = 1.0 - pmf_points;
            let u = if point.u < pmf_points {
                of_points |= 1 << lane;
                pmf[lane] = pmf_points;
                point.u / pmf_points
            } else {
                of_surfaces |= 1 << lane;
                pmf[lane] = rest;
                ((point.u - pmf_points) / rest).min(1.0 - f64::EPSILON)
            };
            choices[lane] = TreeChoice::new(at.p, at.n, u);
        }
        self.point_tree.choose_all(on, &mut choices, of_points);
        self.emitter_tree.choose_all(on, &mut choices, of_surfaces);
        for (lane, (point, choice)) in points.iter_mut().zip(&choices).enumerate() {
            point.chosen = choice.chosen.map(|(light, pmf_in_tree)| SampledLight {
                light: if of_points >> lane & 1 == 1 {
                    self.points[light as usize]
                } else {
                    self.of_emitter(EmitterId(light))
                },
                pmf: (pmf[lane] * pmf_in_tree) as f32,
            });
        }
    }

    /// Selects an emitter for the point `at`, by a uniform number in `[0, 1)`; `None` if none can contribute.
    pub fn choose_emitter(&self, on: impl Dispatch, at: &LightSampleContext, u: f64) -> Option<SampledLight> {
        if self.emitter_tree.importance(at.p, at.n) == 0.0 {
            return None;
        }
        let (light, pmf) = self.emitter_tree.choose(on, at.p, at.n, u)?;
        Some(SampledLight {
            light: self.of_emitter(EmitterId(light)),
            pmf: pmf as f32,
        })
    }

    /// The probability that [`Lights::choose`] selects `light` within its family for the point `at`.
    pub fn pmf(&self, at: &LightSampleContext, light: LightId) -> f32 {
        if self.only_finite == Some(light) || self.background == Some(light) {
            return 1.0;
        }
        let pmf = match self.source(light) {
            LightSource::Background => 1.0,
            LightSource::Analytic(_) => match self.points.binary_search_by_key(&light.0, |l| l.0) {
                Err(_) if self.reaches(light, at) => return 1.0 / self.reaching(at).count() as f32,
                Err(_) => 0.0,
                Ok(i) => match self.pmf_points(at) {
                    Some(of_points) if of_points > 0.0 => of_points * self.point_tree.pmf(at.p, at.n, i as u32),
                    _ => 0.0,
                },
            },
            LightSource::Emitter(emitter) => match self.pmf_points(at) {
                Some(of_points) if of_points < 1.0 => (1.0 - of_points) * self.emitter_tree.pmf(at.p, at.n, emitter.0),
                _ => 0.0,
            },
        };
        pmf as f32
    }
}

/// The pictures of the analytic lights, those that are not `known` made anew; empty if no light has one.
fn pictures(
    shading: &SceneShading,
    known: impl Fn(usize, &Picture) -> Option<Arc<PictureMap>>,
) -> Vec<Option<Arc<PictureMap>>> {
    let of_light = |(i, light): (usize, &Light)| {
        let picture = light.picture()?;
        Some(known(i, picture).unwrap_or_else(|| Arc::new(picture.map(&shading.textures()))))
    };
    let all: Vec<_> = shading.lights.iter().enumerate().map(of_light).collect();
    if all.iter().all(Option::is_none) {
        Vec::new()
    } else {
        all
    }
}

/// See [`Lights::picture`].
#[inline]
fn picture(pictures: &[Option<Arc<PictureMap>>], light: LightId) -> Option<&PictureMap> {
    pictures.get(light.0 as usize)?.as_deref()
}

#[cfg(test)]
mod tests;
