//! Light on layered surfaces, and the directions in which paths leave them, for blocks of surfaces.

use super::{
    VertexBatch,
    direct::Strategy,
    reflected::{ReflectedLight, ReflectedPath},
};
use crate::{
    bsdf::{
        Bsdf, Lobe,
        layered::{EvalBlock, LayerBlock, SampleBlock},
    },
    material::BatchKind,
    math::{
        Dispatch, Frame, Sample2D, VectorLoop,
        block::{Each, LANES, get, get_rgb, set},
    },
    sampler::SampleUse,
    scene::{FamilyBlock, LightFamily, SurfaceInteraction, shading_frame::shading_frame},
};

/// Some layered surfaces; lanes of other surfaces hold numbers without a meaning.
#[repr(align(64))]
pub(super) struct LayeredBlock<'a> {
    /// Whether the lane holds a surface.
    is_layered: [bool; LANES],
    layers: LayerBlock,
    /// The shading frames.
    s: [Each; 3],
    t: [Each; 3],
    n: [Each; 3],
    families: [Option<&'a FamilyBlock>; LightFamily::ALL.len()],
    lights: [LightLanes; LightFamily::ALL.len()],
    samples: SampleBlock,
}

/// The light of a family on each surface of a block.
struct LightLanes {
    eval: EvalBlock,
    /// The weight of the light in multiple importance sampling, over its density.
    weight: Each,
}

impl LightLanes {
    const EMPTY: Self = Self {
        eval: EvalBlock::EMPTY,
        weight: [0.0; LANES],
    };
}

/// A layered surface of a block.
#[derive(Clone, Copy)]
pub(super) struct LayeredSurface<'a> {
    block: &'a LayeredBlock<'a>,
    lane: usize,
}

impl<'a> LayeredBlock<'a> {
    pub const EMPTY: Self = Self {
        is_layered: [false; LANES],
        layers: LayerBlock::EMPTY,
        s: [[0.0; LANES]; 3],
        t: [[0.0; LANES]; 3],
        n: [[0.0; LANES]; 3],
        families: [None; LightFamily::ALL.len()],
        lights: [LightLanes::EMPTY; LightFamily::ALL.len()],
        samples: SampleBlock::EMPTY,
    };

    /// Fills the block for the vertices of `batch` from `first` on, a multiple of the block's size, whose paths may be
    /// `max_depth` long.
    pub fn fill(&mut self, batch: &VertexBatch<'a>, first: usize, strategy: Strategy, max_depth: u32) {
        self.is_layered = [false; LANES];
        let end = batch.len().min(first + LANES);
        let Some(surfaces) = batch.surfaces.get(first..end) else {
            return;
        };
        let is_layered = |surface: &SurfaceInteraction| batch.scene.batch_kind(surface.material) == BatchKind::Layered;
        if !surfaces.iter().any(is_layered) {
            return;
        }
        let samples = &batch.samples;
        let (Some(families), Some(choices), Some(squares), Some(disks)) = (
            batch.families(first / LANES),
            samples.of(SampleUse::Selection),
            samples.of(SampleUse::Bsdf),
            samples.disks(),
        ) else {
            return;
        };
        self.families = families;
        let (mut lane_choices, mut lane_samples) = ([0.0; LANES], [Sample2D::default(); LANES]);
        for (lane, surface) in surfaces.iter().enumerate().filter(|(_, surface)| is_layered(surface)) {
            let k = first + lane;
            self.is_layered[lane] = self.set(batch, k, surface, max_depth);
            lane_choices[lane] = choices[k].y;
            lane_samples[lane] = Sample2D {
                square: squares[k],
                disk: disks[k],
            };
        }
        if self.is_layered == [false; LANES] {
            return;
        }
        batch.scene.accel.simd().dispatch(Scatterings {
            choices: &lane_choices,
            samples: &lane_samples,
            block: self,
            strategy,
        });
    }

    /// Sets the surface of vertex `k`, and returns whether the block can hold it.
    #[inline(always)]
    fn set(&mut self, batch: &VertexBatch<'a>, k: usize, surface: &SurfaceInteraction, max_depth: u32) -> bool {
        let (scene, lane) = (batch.scene, k % LANES);
        let path = &batch.paths[batch.indices[k] as usize];
        if path.depth >= max_depth || !path.last.media.is_empty() {
            return false;
        }
        let bsdf = scene.bsdf(surface.material, &surface.texture);
        let Bsdf::Layered(layered) = &*bsdf else {
            return false;
        };
        let frame = shading_frame(scene, surface, scene.material(surface.material), layered).frame;
        let depends_on_normal = |family| scene.lights.depends_on_normal(family);
        if frame.n != surface.viewed_normal() && scene.lights.families().any(depends_on_normal) {
            return false;
        }
        set(&mut self.s, lane, frame.s);
        set(&mut self.t, lane, frame.t);
        set(&mut self.n, lane, frame.n);
        self.layers.set(lane, layered, frame.to_local(surface.wo))
    }

    /// The surface of a lane, if it is layered.
    #[inline(always)]
    pub fn surface(&self, lane: usize) -> Option<LayeredSurface<'_>> {
        let lane = lane % LANES;
        self.is_layered[lane].then_some(LayeredSurface { block: self, lane })
    }

    #[inline(always)]
    fn frame(&self, lane: usize) -> Frame {
        Frame {
            s: get(&self.s, lane),
            t: get(&self.t, lane),
            n: get(&self.n, lane),
        }
    }
}

impl LayeredSurface<'_> {
    /// The light of each family on the surface, `surface`, where any arrives.
    #[inline(always)]
    pub fn lights(self, surface: &SurfaceInteraction) -> impl Iterator<Item = ReflectedLight> {
        let Self { block, lane } = self;
        let families = block.families.iter().map_while(|family| *family);
        families.zip(&block.lights).filter_map(move |(family, lights)| {
            let (li, is_delta) = family.light.li(lane)?;
            let chosen = family.chosen(lane);
            let diffuse = get_rgb(&lights.eval.diffuse, lane);
            let f_cos = diffuse + get_rgb(&lights.eval.glossy, lane);
            let l = if is_delta {
                f_cos * li / chosen.pmf
            } else {
                f_cos * li * lights.weight[lane]
            };
            (!l.is_black()).then(|| ReflectedLight {
                chosen,
                f_cos,
                diffuse,
                l,
                shadow_ray: surface.shadow_ray(false, family.light.wi(lane), family.light.distance(lane)),
            })
        })
    }

    /// The way in which the path goes on from the surface, `surface`.
    #[inline(always)]
    pub fn path(self, surface: &SurfaceInteraction) -> Option<ReflectedPath> {
        let Self { block, lane } = self;
        let (samples, frame) = (&block.samples, block.frame(lane));
        let pdf = samples.pdf[lane];
        (pdf > 0.0).then(|| ReflectedPath {
            ray: surface.spawn_ray(false, frame.to_world(get(&samples.wi, lane))),
            pdf,
            weight: get_rgb(&samples.weight, lane),
            diffuse: get_rgb(&samples.diffuse, lane),
            lobe: if samples.is_diffuse[lane] != 0 {
                Lobe::Diffuse
            } else {
                Lobe::Specular
            },
            n: frame.n,
        })
    }
}

/// Computes the scattering of all surfaces of a block.
struct Scatterings<'a, 'b> {
    choices: &'a Each,
    samples: &'a Each<Sample2D>,
    block: &'a mut LayeredBlock<'b>,
    strategy: Strategy,
}

impl VectorLoop for Scatterings<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let Self {
            choices,
            samples,
            block,
            strategy,
        } = self;
        block.layers.prepare();
        for k in 0..block.families.len() {
            let Some(family) = block.families[k] else { break };
            let mut wi = [[0.0; LANES]; 3];
            for lane in 0..LANES {
                let local = block.frame(lane).to_local(family.light.wi(lane));
                set(&mut wi, lane, local);
            }
            let eval = block.layers.eval(&wi);
            let mut weights = [0.0; LANES];
            for (lane, weight) in weights.iter_mut().enumerate() {
                let of_light = family.light.pdf(lane) * family.pmf(lane);
                *weight = strategy.weight_of_light(of_light, eval.pdf[lane]) / of_light;
            }
            block.lights[k] = LightLanes { eval, weight: weights };
        }
        block.samples = block.layers.sample(choices, samples);
    }
}
