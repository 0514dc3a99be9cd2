//! Samples of lamps for many surfaces at once.

use super::{LightFamily, LightId, LightSampleContext, LightSource, SampledLight, Scene, SurfaceInteraction};
use crate::{
    light::{AreaBlock, LightSample},
    math::{Dispatch, Vec2, Vec3},
    shape::block::LANES,
};

/// A lamp that was chosen for a surface, and the light that it sends there, if any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LampSample {
    /// The normal for which it was chosen; `None` where the choice does not depend on it.
    normal: Option<Vec3>,
    pub sample: Option<(SampledLight, LightSample)>,
}

impl LampSample {
    /// Whether it is the sample for `at`, which is where the surface is.
    #[inline(always)]
    pub fn is_for(&self, at: &LightSampleContext) -> bool {
        self.normal.is_none_or(|n| n == at.n)
    }
}

/// The uniform numbers in `[0, 1)` by which lamps are sampled, for each surface.
#[derive(Clone, Copy, Debug)]
pub struct LampNumbers<'a> {
    /// The numbers for the choice of a lamp (x); `None` where there is but one.
    pub choices: Option<&'a [Vec2]>,
    pub points: &'a [Vec2],
}

/// Samples of lamps for a batch of surfaces.
#[derive(Debug, Default)]
pub struct LampSamples {
    /// One for each surface; `None` where its sample has to be drawn alone.
    pub samples: Vec<Option<LampSample>>,
    /// The surfaces and the chosen lamps in the lanes of the block.
    lanes: Vec<(usize, SampledLight)>,
    block: Box<AreaBlock>,
    /// The lamps of the block's lanes.
    lamps: [Option<LightId>; LANES],
}

impl Scene {
    /// Samples the lamps for each of these surfaces, in place of what `to` held: what [`Lights::choose`](super::Lights::choose)
    /// and [`Scene::sample_light`] give on the side of the viewer. Surfaces that light passes through are left out.
    pub fn sample_lamps(
        &self,
        on: impl Dispatch,
        surfaces: &[SurfaceInteraction],
        numbers: LampNumbers<'_>,
        to: &mut LampSamples,
    ) {
        to.samples.clear();
        to.samples.resize(surfaces.len(), None);
        to.lamps = [None; LANES];
        for (k, surface) in surfaces.iter().enumerate() {
            if !self.material(surface.material).is_lit() {
                continue;
            }
            let at = LightSampleContext {
                p: surface.lifted(),
                n: surface.viewed_normal(),
            };
            let choice = numbers.choices.map_or(0.0, |u| u[k].x);
            let choice = self.lights.choose(on, LightFamily::Lamps, &at, choice);
            to.samples[k] = Some(LampSample {
                normal: self.lights.has_choice_of_lamps().then_some(at.n),
                sample: None,
            });
            let Some(choice) = choice else { continue };
            let (lane, u) = (to.lanes.len(), numbers.points[k]);
            if to.lamps[lane] == Some(choice.light) || self.put_lamp(choice.light, lane, to) {
                to.block.rectangles.set_observer(lane, at.p, u);
                to.lanes.push((k, choice));
                if to.lanes.len() == LANES {
                    to.sample_block(on, self, surfaces, &numbers);
                }
            } else if let Some(sample) = &mut to.samples[k] {
                sample.sample = self.sample_light(choice.light, at.p, u).map(|light| (choice, light));
            }
        }
        to.sample_block(on, self, surfaces, &numbers);
    }

    /// Sets the lamp of a lane. Returns whether lamps like it are sampled in blocks.
    fn put_lamp(&self, light: LightId, lane: usize, to: &mut LampSamples) -> bool {
        let LightSource::Emitter(emitter) = self.lights.source(light) else {
            return false;
        };
        let is_put = self.put_emitter(emitter, lane, &mut to.block);
        to.lamps[lane] = is_put.then_some(light);
        is_put
    }
}

impl LampSamples {
    /// Samples the lamps of the block and empties it.
    fn sample_block(
        &mut self,
        on: impl Dispatch,
        scene: &Scene,
        surfaces: &[SurfaceInteraction],
        numbers: &LampNumbers<'_>,
    ) {
        if self.lanes.is_empty() {
            return;
        }
        self.block.sample(on);
        for (lane, (k, choice)) in self.lanes.drain(..).enumerate() {
            let light = if self.block.rectangles.is_known(lane) {
                self.block.light(lane)
            } else {
                scene.sample_light(choice.light, surfaces[k].lifted(), numbers.points[k])
            };
            if let Some(sample) = &mut self.samples[k] {
                sample.sample = light.map(|light| (choice, light));
            }
        }
    }
}
