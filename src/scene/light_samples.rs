//! Light samples for batches of surfaces.

use super::{
    LightChoice, LightFamily, LightId, LightSampleContext, LightSource, SampledLight, Scene, SurfaceInteraction,
    emitters::HeldLight,
};
use crate::{
    light::{AreaBlock, LightBlock, LightSample},
    math::{Dispatch, Vec2},
    sampler::UnitBits,
    shape::SampledPoint,
};

/// Samples of a family's lights for a block of surfaces.
#[derive(Clone, Debug)]
pub struct FamilyBlock {
    pub light: LightBlock,
    /// The chosen lights, and the probability of each choice.
    lights: [LightId; LightBlock::LEN],
    pmf: [f32; LightBlock::LEN],
    /// Not 0 if the block has no sample for this lane, and the scalar code must draw it.
    is_unknown: [u32; LightBlock::LEN],
}

/// Samples of lights for a batch of surfaces, in blocks.
#[derive(Debug, Default)]
pub struct LightSamples {
    families: [FamilyBlocks; LightFamily::ALL.len()],
    finite: FiniteLights,
}

/// The blocks of a family.
#[derive(Debug, Default)]
struct FamilyBlocks {
    blocks: Vec<FamilyBlock>,
    /// The number of blocks that hold samples.
    count: usize,
}

/// The finite lights of a block that are sampled together.
#[derive(Debug, Default)]
struct FiniteLights {
    block: Box<AreaBlock>,
    /// The light of each lane.
    lights: [Option<LightId>; LightBlock::LEN],
    /// The lanes, as bits, of whose lights the block holds the points alone.
    varying: u32,
}

/// The uniform numbers in `[0, 1)` for light sampling, for each surface.
#[derive(Clone, Copy, Debug)]
pub struct LightNumbers<'a> {
    /// The numbers that choose a light; `None` if there is no choice.
    pub choices: Option<&'a [UnitBits]>,
    pub points: &'a [Vec2],
}

impl FamilyBlock {
    const EMPTY: Self = Self {
        light: LightBlock::EMPTY,
        lights: [LightId(0); LightBlock::LEN],
        pmf: [1.0; LightBlock::LEN],
        is_unknown: [0; LightBlock::LEN],
    };

    #[inline(always)]
    fn set(&mut self, lane: usize, sample: Option<(SampledLight, LightSample)>) {
        if let Some((chosen, _)) = sample {
            self.choose(lane, chosen);
        }
        self.light.set(lane, sample.as_ref().map(|(_, sample)| sample));
    }

    /// The probability of the light chosen for a surface.
    #[inline(always)]
    pub fn pmf(&self, lane: usize) -> f32 {
        self.pmf[lane]
    }

    #[inline(always)]
    fn choose(&mut self, lane: usize, SampledLight { light, pmf }: SampledLight) {
        (self.lights[lane], self.pmf[lane]) = (light, pmf);
    }

    /// The light chosen for a surface; unspecified if no light arrives.
    #[inline(always)]
    pub fn chosen(&self, lane: usize) -> SampledLight {
        let lane = lane % LightBlock::LEN;
        SampledLight {
            light: self.lights[lane],
            pmf: self.pmf[lane],
        }
    }
}

impl FamilyBlocks {
    /// Returns blocks for this many surfaces, with unspecified contents.
    fn start(&mut self, surfaces: usize) -> &mut [FamilyBlock] {
        self.count = surfaces.div_ceil(LightBlock::LEN);
        if self.blocks.len() < self.count {
            self.blocks.resize(self.count, FamilyBlock::EMPTY);
        }
        &mut self.blocks[..self.count]
    }
}

impl LightSamples {
    /// Starts with a scene: forgets the lights of another one.
    pub fn start(&mut self) {
        self.finite.lights = [None; LightBlock::LEN];
    }

    /// Clears the samples of all families.
    pub fn clear(&mut self) {
        for blocks in &mut self.families {
            blocks.count = 0;
        }
    }

    /// The samples of a family, in the order of the surfaces.
    #[inline(always)]
    pub fn of(&self, family: LightFamily) -> &[FamilyBlock] {
        let FamilyBlocks { blocks, count } = &self.families[family as usize];
        &blocks[..*count]
    }

    /// The sample of a family's light for surface `k`; the outer `None` if the scalar code must draw it.
    #[inline(always)]
    pub fn get(&self, family: LightFamily, k: usize) -> Option<Option<(SampledLight, LightSample)>> {
        let block = self.of(family).get(k / LightBlock::LEN)?;
        let lane = k % LightBlock::LEN;
        let sample = || block.light.get(lane).map(|light| (block.chosen(lane), light));
        (block.is_unknown[lane] == 0).then(sample)
    }
}

impl Scene {
    /// Samples the background, once for each of these pairs of uniform numbers.
    pub fn sample_background(&self, on: impl Dispatch, numbers: &[Vec2], to: &mut LightSamples) {
        let Some(light) = self.lights.background() else {
            return;
        };
        let blocks = to.families[LightFamily::Background as usize].start(numbers.len());
        self.shading.background.radiance.sample_all(on, numbers, |k, sample| {
            let chosen = SampledLight { light, pmf: 1.0 };
            blocks[k / LightBlock::LEN].set(k % LightBlock::LEN, sample.map(|sample| (chosen, sample)));
        });
    }

    /// Samples the finite lights and the suns for each of these surfaces, with the results of
    /// [`Lights::choose`](super::Lights::choose) and [`Scene::sample_light`] on the viewer's side. Surfaces of materials that are
    /// not lit are left out, see [`MaterialKind::is_lit`](crate::material::MaterialKind::is_lit). `to` has started with this
    /// scene, see [`LightSamples::start`].
    pub fn sample_lights(
        &self,
        on: impl Dispatch,
        surfaces: &[SurfaceInteraction],
        numbers: LightNumbers<'_>,
        to: &mut LightSamples,
    ) {
        for family in self.lights.families().filter(|f| *f != LightFamily::Background) {
            let LightSamples { families, finite } = to;
            let blocks = families[family as usize].start(surfaces.len());
            for (block, first) in blocks.iter_mut().zip((0..).step_by(LightBlock::LEN)) {
                let surfaces = &surfaces[first..surfaces.len().min(first + LightBlock::LEN)];
                let numbers = LightNumbers {
                    choices: numbers.choices.map(|choices| &choices[first..]),
                    points: &numbers.points[first..],
                };
                self.sample_block(on, family, surfaces, numbers, block, finite);
            }
        }
    }

    /// Samples a family's lights for the surfaces of a block.
    fn sample_block(
        &self,
        on: impl Dispatch,
        family: LightFamily,
        surfaces: &[SurfaceInteraction],
        numbers: LightNumbers<'_>,
        to: &mut FamilyBlock,
        finite: &mut FiniteLights,
    ) {
        // The points of the surfaces that are lit, and their lanes.
        let (mut points, mut point_lanes, mut lit) = ([LightChoice::EMPTY; LightBlock::LEN], [0; LightBlock::LEN], 0);
        for (lane, surface) in surfaces.iter().enumerate() {
            let is_lit = self.material(surface.material).is_lit();
            to.is_unknown[lane] = u32::from(!is_lit);
            let at = LightSampleContext {
                p: surface.p,
                n: surface.viewed_normal(),
            };
            points[lit] = LightChoice::new(at, numbers.choices.map_or(0.0, |u| u[lane].f64()));
            point_lanes[lit] = lane;
            lit += usize::from(is_lit);
        }
        let points = &mut points[..lit];
        self.lights.choose_all(on, family, points);
        let (mut together, mut alone, mut dark) = (0_u32, 0_u32, 0_u32);
        for (LightChoice { at, chosen, .. }, &lane) in points.iter().zip(&point_lanes) {
            let Some(choice) = *chosen else {
                dark |= 1 << lane;
                continue;
            };
            to.choose(lane, choice);
            if finite.lights[lane] == Some(choice.light) || self.set_area_light(choice.light, lane, finite) {
                let points = &mut finite.block.points;
                points.set_observer(lane, at.p, numbers.points[lane]);
                together |= 1 << lane;
            } else {
                alone |= 1 << lane;
            }
        }
        if together != 0 {
            finite.block.sample(on, &mut to.light);
            alone |= together & !finite.block.points.known();
            for lane in lanes(together & finite.varying & !alone) {
                let LightSource::Emitter(emitter) = self.lights.source(to.lights[lane]) else {
                    continue;
                };
                let SampledPoint { p, ng, .. } = finite.block.points.point(lane);
                let front_cos = ng.dot(finite.block.points.from(lane) - p);
                let li = self.radiance_in_block(emitter, (p, ng), front_cos);
                to.light.set_radiance(lane, li);
            }
        }
        for lane in lanes(alone) {
            let sample = self.sample_light(to.lights[lane], surfaces[lane].p, numbers.points[lane]);
            to.light.set(lane, sample.as_ref());
        }
        for lane in lanes(dark) {
            to.light.set(lane, None);
        }
    }

    /// Sets the light of a lane. Returns whether a block can hold the light.
    #[inline(never)]
    fn set_area_light(&self, light: LightId, lane: usize, to: &mut FiniteLights) -> bool {
        let held = match self.lights.source(light) {
            LightSource::Emitter(emitter) => self.set_emitter(emitter, lane, &mut to.block),
            LightSource::Analytic(own) if own.put_in_block(lane, &mut to.block) => HeldLight::Whole,
            LightSource::Analytic(_) | LightSource::Background => HeldLight::Nothing,
        };
        to.varying &= !(1 << lane);
        to.varying |= u32::from(held == HeldLight::Points) << lane;
        let is_held = held != HeldLight::Nothing;
        to.lights[lane] = is_held.then_some(light);
        is_held
    }
}

/// The indices of the set bits.
fn lanes(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        lane
    })
}
