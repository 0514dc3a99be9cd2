//! The lights of a scene, and the selection of one of them.
//!
//! Lights are numbered: first the analytic lights, in the order of the scene file, then the
//! emitters, then the background if it is sampled.
//!
//! The selection begins with equal probabilities for each infinite light (suns, the background) and
//! for all finite lights together, leaving out those that cannot contribute. Finite lights are then
//! selected by two light trees, one for points and one for surfaces; see [`crate::light::tree`].

use super::{BackgroundRadiance, EmitterId, Emitters, LightId};
use crate::{
    light::{Light, LightBounds, tree::LightTree},
    math::{
        Rgb, Vec3,
        hash::{mix32, unit_f32},
    },
};

/// A point whose illumination is sampled.
#[derive(Clone, Copy, Debug)]
pub struct LightSampleContext {
    pub p: Vec3,
    /// Unit shading normal; zero where light from all sides contributes.
    pub n: Vec3,
}

/// A light that was selected for a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledLight {
    pub light: LightId,
    /// The probability of the selection.
    pub pmf: f32,
}

/// The source of a light.
#[derive(Clone, Copy, Debug)]
pub enum LightSource<'a> {
    Analytic(&'a Light),
    Emitter(EmitterId),
    Background,
}

/// All lights.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    all: Vec<Light>,
    emitters: Emitters,
    background: Option<LightId>,
    /// The infinite lights, except the background.
    infinite: Vec<LightId>,
    /// Those of `infinite` that are a disk.
    suns: Vec<LightId>,
    /// The finite analytic lights, by their numbers in the tree.
    points: Vec<LightId>,
    point_tree: LightTree,
    emitter_tree: LightTree,
    /// The only light, if there is exactly one.
    only: Option<LightId>,
}

/// The weights of the selection at a point.
struct SelectionWeights {
    /// The number of equal probabilities: 1 for all finite lights if they contribute, and 1 for
    /// each infinite light that does.
    count: u32,
    /// The importance of the finite lights: points and surfaces.
    near: [f64; 2],
}

impl SelectionWeights {
    fn has_near(&self) -> bool {
        self.near[0] + self.near[1] > 0.0
    }

    /// The probability of points among the finite lights.
    fn of_points(&self) -> f64 {
        self.near[0] / (self.near[0] + self.near[1])
    }
}

impl Lights {
    /// Collects analytic lights, emitters with their bounds, and the background.
    pub fn new(
        all: Vec<Light>,
        emitters: Emitters,
        bounds: impl ExactSizeIterator<Item = LightBounds>,
        background: &BackgroundRadiance,
    ) -> Self {
        let (mut points, mut point_bounds, mut infinite, mut suns) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (light, id) in all.iter().zip((0..).map(LightId)) {
            match light.bounds() {
                Some(bounds) => {
                    points.push(id);
                    point_bounds.push(bounds);
                }
                None => infinite.push(id),
            }
            if matches!(light, Light::Sun(sun) if sun.has_size()) {
                suns.push(id);
            }
        }
        let near = all.len() as u32 + emitters.count();
        let background = background.is_sampled().then_some(LightId(near));
        let only = match (near, background) {
            (0, Some(background)) => Some(background),
            (1, None) => Some(LightId(0)),
            _ => None,
        };
        Self {
            all,
            emitters,
            background,
            infinite,
            suns,
            points,
            point_tree: LightTree::build(point_bounds.into_iter()),
            emitter_tree: LightTree::build(bounds),
            only,
        }
    }

    /// The analytic lights.
    pub fn all(&self) -> &[Light] {
        &self.all
    }

    pub fn emitters(&self) -> &Emitters {
        &self.emitters
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

    pub fn is_empty(&self) -> bool {
        self.count() == 0
    }

    /// Whether [`Lights::choose`] reads its number: there is more than one light.
    pub fn has_choice(&self) -> bool {
        self.only.is_none()
    }

    /// The number of lights.
    pub fn count(&self) -> u32 {
        self.all.len() as u32 + self.emitters.count() + u32::from(self.background.is_some())
    }

    /// The suns whose disk the unit direction `w` meets, with its radiance in W m^-2 sr^-1 and the
    /// density of that direction in sr^-1.
    #[inline]
    pub fn suns(&self, w: Vec3) -> impl Iterator<Item = (LightId, Rgb, f32)> {
        self.suns.iter().filter_map(move |&id| match &self.all[id.0 as usize] {
            Light::Sun(sun) => sun.radiance_towards(w).map(|(l, pdf)| (id, l, pdf)),
            _ => None,
        })
    }

    fn reaches(&self, light: LightId, at: &LightSampleContext) -> bool {
        self.all[light.0 as usize].reaches(at.p, at.n)
    }

    fn weights(&self, at: &LightSampleContext) -> SelectionWeights {
        let mut weights = SelectionWeights {
            count: u32::from(self.background.is_some()),
            near: [&self.point_tree, &self.emitter_tree].map(|tree| tree.importance(at.p, at.n)),
        };
        weights.count += u32::from(weights.has_near());
        weights.count += self.infinite.iter().filter(|l| self.reaches(**l, at)).count() as u32;
        weights
    }

    /// Selects a light for the point `at`, by a uniform number in `[0, 1)`; `None` where none can
    /// contribute.
    pub fn choose(&self, at: &LightSampleContext, u: f32) -> Option<SampledLight> {
        if let Some(light) = self.only {
            return Some(SampledLight { light, pmf: 1.0 });
        }
        let weights = self.weights(at);
        let scaled = extend_precision(u, at.p) * f64::from(weights.count);
        let mut which = (scaled as u32).min(weights.count.checked_sub(1)?);
        let pmf = 1.0 / f64::from(weights.count);
        if weights.has_near() {
            if which == 0 {
                return self
                    .choose_near(at, &weights, scaled)
                    .map(|(light, near)| SampledLight {
                        light,
                        pmf: (pmf * near) as f32,
                    });
            }
            which -= 1;
        }
        let mut infinite = self.infinite.iter().filter(|l| self.reaches(**l, at));
        let light = infinite.nth(which as usize).copied().or(self.background)?;
        Some(SampledLight { light, pmf: pmf as f32 })
    }

    /// Selects a finite light, by a uniform number in `[0, 1)`.
    fn choose_near(&self, at: &LightSampleContext, weights: &SelectionWeights, u: f64) -> Option<(LightId, f64)> {
        let of_points = weights.of_points();
        if u < of_points {
            let (light, pmf) = self.point_tree.choose(at.p, at.n, u / of_points)?;
            Some((self.points[light as usize], of_points * pmf))
        } else {
            let of_emitters = 1.0 - of_points;
            let u = ((u - of_points) / of_emitters).min(1.0 - f64::EPSILON);
            let (light, pmf) = self.emitter_tree.choose(at.p, at.n, u)?;
            Some((self.of_emitter(EmitterId(light)), of_emitters * pmf))
        }
    }

    /// Selects an emitter for the point `at`, by a uniform number in `[0, 1)`; `None` where none
    /// can contribute.
    pub fn choose_emitter(&self, at: &LightSampleContext, u: f32) -> Option<SampledLight> {
        if self.emitter_tree.importance(at.p, at.n) == 0.0 {
            return None;
        }
        let (light, pmf) = self.emitter_tree.choose(at.p, at.n, extend_precision(u, at.p))?;
        Some(SampledLight {
            light: self.of_emitter(EmitterId(light)),
            pmf: pmf as f32,
        })
    }

    /// The probability of [`Lights::choose`] to select `light` for the point `at`.
    pub fn pmf(&self, at: &LightSampleContext, light: LightId) -> f32 {
        if self.only.is_some() {
            return 1.0;
        }
        let weights = self.weights(at);
        let near = match self.source(light) {
            LightSource::Background => 1.0,
            LightSource::Analytic(_) => match self.points.binary_search_by_key(&light.0, |l| l.0) {
                Err(_) if self.reaches(light, at) => 1.0,
                Err(_) => 0.0,
                Ok(_) if weights.near[0] == 0.0 => 0.0,
                Ok(i) => weights.of_points() * self.point_tree.pmf(at.p, at.n, i as u32),
            },
            LightSource::Emitter(_) if weights.near[1] == 0.0 => 0.0,
            LightSource::Emitter(emitter) => (1.0 - weights.of_points()) * self.emitter_tree.pmf(at.p, at.n, emitter.0),
        };
        if near == 0.0 {
            return 0.0;
        }
        (near / f64::from(weights.count)) as f32
    }
}

/// Extends `u` beyond single precision, as a tree of a million lights needs. The extra digits are a
/// hash of the point.
fn extend_precision(u: f32, p: Vec3) -> f64 {
    const LAST: f64 = 1.0 / 16_777_216.0;
    let [x, y, z] = p.to_array().map(f32::to_bits);
    let digits = unit_f32(mix32(x ^ mix32(y ^ mix32(z ^ u.to_bits()))));
    f64::from(u) + f64::from(digits) * LAST
}

#[cfg(test)]
mod tests;
