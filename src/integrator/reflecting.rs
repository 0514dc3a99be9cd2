//! Blocks of opaque surfaces with one kind of BSDF: their direct light, and the directions of the paths that leave them.

use std::borrow::Cow;

use super::{
    VertexBatch,
    direct::Strategy,
    reflected::{ReflectedLight, ReflectedPath, reflected},
};
use crate::{
    bsdf::{
        Bsdf, Lobe,
        block::{BsdfBlock, EvalBlock, SampleBlock},
        conductor::ConductorBlock,
        diffuse::OrenNayarBlock,
        folded::FoldBlock,
        layered::LayerBlock,
    },
    material::BatchKind,
    math::{
        Dispatch, Frame, Sample2D, VectorLoop,
        block::{Each, LANES, get, get_rgb, set},
    },
    sampler::SampleUse,
    scene::{
        FamilyBlock, LightFamily, Scene, SurfaceInteraction,
        shading_frame::{ShadingFrame, shading_frame},
    },
};

/// A block of surfaces whose BSDFs are in a `B`.
struct KindBlock<'a, B> {
    bsdfs: B,
    scattering: ScatteringBlock<'a>,
}

/// The scattering at a block of surfaces; other lanes are unspecified.
#[repr(align(64))]
struct ScatteringBlock<'a> {
    /// Whether the lane holds a surface.
    is_set: [bool; LANES],
    /// The shading frames.
    s: [Each; 3],
    t: [Each; 3],
    n: [Each; 3],
    folds: FoldBlock,
    families: [Option<&'a FamilyBlock>; LightFamily::ALL.len()],
    lights: [LightLanes; LightFamily::ALL.len()],
    samples: SampleBlock,
}

/// The direct light of a family on each surface of a block.
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

/// A surface of a block.
#[derive(Clone, Copy)]
pub(super) struct BlockSurface<'a> {
    block: &'a ScatteringBlock<'a>,
    lane: usize,
}

/// Declares the blocks: one row for each kind of BSDF.
macro_rules! reflecting_blocks {
    ($( $field:ident: $Block:ty = $Kind:ident, )*) => {
        /// A block for each kind of BSDF in the scene.
        pub(super) struct ReflectingBlocks<'a> {
            $( $field: Option<KindBlock<'a, $Block>>, )*
            /// Whether no block holds a surface.
            is_empty: bool,
            /// The BSDFs that were made of surfaces which their block cannot hold.
            left: [Option<Cow<'a, Bsdf>>; LANES],
        }

        impl<'a> ReflectingBlocks<'a> {
            /// Empty blocks.
            #[inline(always)]
            pub fn of(scene: &Scene) -> Self {
                Self {
                    $( $field: scene.has_batch_kind(BatchKind::$Kind).then_some(KindBlock::EMPTY), )*
                    is_empty: true,
                    left: [const { None }; LANES],
                }
            }

            /// Fills the blocks for the vertices of `batch` from `first` on, a multiple of the blocks' size; paths have at most
            /// `max_depth` segments.
            #[inline(always)]
            pub fn fill(&mut self, batch: &VertexBatch<'a>, first: usize, strategy: Strategy, max_depth: u32) {
                self.is_empty = true;
                self.left.iter_mut().for_each(|left| *left = None);
                $(
                    if let Some(block) = &mut self.$field {
                        self.is_empty &= !block.fill(BatchKind::$Kind, batch, first, (strategy, max_depth), &mut self.left);
                    }
                )*
            }

            /// The surface of a vertex, if one of the blocks holds it.
            #[inline(always)]
            pub fn surface(&self, k: usize) -> Option<BlockSurface<'_>> {
                if self.is_empty {
                    return None;
                }
                $(
                    if let Some(surface) = self.$field.as_ref().and_then(|block| block.scattering.surface(k)) {
                        return Some(surface);
                    }
                )*
                None
            }

            /// The BSDF of a vertex that no block holds, if it was made.
            #[inline(always)]
            pub fn left(&self, k: usize) -> Option<&Bsdf> {
                self.left[k % LANES].as_deref()
            }
        }
    };
}

reflecting_blocks! {
    layered: LayerBlock = Layered,
    metal: ConductorBlock = Metal,
    rough_diffuse: OrenNayarBlock = RoughDiffuse,
}

impl ScatteringBlock<'_> {
    const EMPTY: Self = Self {
        is_set: [false; LANES],
        s: [[0.0; LANES]; 3],
        t: [[0.0; LANES]; 3],
        n: [[0.0; LANES]; 3],
        folds: FoldBlock::EMPTY,
        families: [None; LightFamily::ALL.len()],
        lights: [LightLanes::EMPTY; LightFamily::ALL.len()],
        samples: SampleBlock::EMPTY,
    };

    /// The surface of a vertex, if the block holds it.
    #[inline(always)]
    fn surface(&self, k: usize) -> Option<BlockSurface<'_>> {
        let lane = k % LANES;
        self.is_set[lane].then_some(BlockSurface { block: self, lane })
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

impl<'a, B: BsdfBlock> KindBlock<'a, B> {
    const EMPTY: Self = Self {
        bsdfs: B::EMPTY,
        scattering: ScatteringBlock::EMPTY,
    };

    /// Fills the block with surfaces whose materials are of a `kind`, and returns whether it holds
    /// any. The BSDFs of others are `left`.
    fn fill(
        &mut self,
        kind: BatchKind,
        batch: &VertexBatch<'a>,
        first: usize,
        (strategy, max_depth): (Strategy, u32),
        left: &mut Each<Option<Cow<'a, Bsdf>>>,
    ) -> bool {
        self.scattering.is_set = [false; LANES];
        let end = batch.len().min(first + LANES);
        let Some(surfaces) = batch.surfaces.get(first..end) else {
            return false;
        };
        let is_kind = |surface: &SurfaceInteraction| batch.scene.batch_kind(surface.material) == kind;
        if !surfaces.iter().any(is_kind) {
            return false;
        }
        let samples = &batch.samples;
        let (Some(families), Some(squares), Some(disks)) = (
            batch.families(first / LANES),
            samples.of(SampleUse::Bsdf),
            samples.disks(),
        ) else {
            return false;
        };
        (self.scattering.families, self.scattering.folds) = (families, FoldBlock::EMPTY);
        // Not drawn if no BSDF has several lobes.
        let choices = samples.thirds_of(SampleUse::Bsdf);
        let (mut lane_choices, mut lane_samples) = ([0.0; LANES], [Sample2D::default(); LANES]);
        for (lane, surface) in surfaces.iter().enumerate().filter(|(_, surface)| is_kind(surface)) {
            let k = first + lane;
            self.scattering.is_set[lane] = self.set(batch, k, surface, max_depth, &mut left[lane]);
            lane_choices[lane] = choices.map_or(0.0, |choices| choices[k].f32());
            lane_samples[lane] = Sample2D {
                square: squares[k],
                disk: disks[k],
            };
        }
        if self.scattering.is_set == [false; LANES] {
            return false;
        }
        batch.scene.geometry.accel.simd().dispatch(Scatterings {
            choices: &lane_choices,
            samples: &lane_samples,
            block: self,
            strategy,
        });
        true
    }

    /// Sets the surface of vertex `k`, and returns whether the block can hold it.
    #[inline(always)]
    fn set(
        &mut self,
        batch: &VertexBatch<'a>,
        k: usize,
        surface: &SurfaceInteraction,
        max_depth: u32,
        left: &mut Option<Cow<'a, Bsdf>>,
    ) -> bool {
        let (scene, lane) = (batch.scene, k % LANES);
        let path = &batch.paths[batch.indices[k] as usize];
        if path.depth >= max_depth || !path.last.media.is_empty() {
            return false;
        }
        let found = scene.bsdf(surface.material, &surface.texture);
        let Some(bsdf) = B::kind(&found).filter(|bsdf| self.bsdfs.set(lane, bsdf)) else {
            *left = Some(found);
            return false;
        };
        let ShadingFrame { frame, base, coat, .. } =
            shading_frame(scene, surface, scene.material(surface.material), bsdf);
        let wo = frame.to_local(surface.wo);
        let is_folded = scene.shading.normal_map(surface.material).is_some();
        let depends_on_normal = |family| scene.lights.depends_on_normal(family);
        let is_sampled = is_folded || frame.n == base || !scene.lights.families().any(depends_on_normal);
        if coat.is_some() || !is_sampled || wo.z <= 0.0 {
            *left = Some(found);
            return false;
        }
        let plane = is_folded.then(|| frame.to_local(base));
        self.scattering.folds.set(lane, plane);
        set(&mut self.scattering.s, lane, frame.s);
        set(&mut self.scattering.t, lane, frame.t);
        set(&mut self.scattering.n, lane, frame.n);
        self.bsdfs.set_view(lane, wo);
        true
    }
}

impl BlockSurface<'_> {
    /// The reflected light of each family that contributes, for the lane's `surface`.
    #[inline(always)]
    pub fn lights(self, surface: &SurfaceInteraction) -> impl Iterator<Item = ReflectedLight> {
        let Self { block, lane } = self;
        let families = block.families.iter().map_while(|family| *family);
        families.zip(&block.lights).filter_map(move |(family, lights)| {
            let diffuse = get_rgb(&lights.eval.diffuse, lane);
            let f_cos = diffuse + get_rgb(&lights.eval.glossy, lane);
            let (chosen, l) = reflected(family, lane, f_cos, lights.weight[lane])?;
            Some(ReflectedLight {
                chosen,
                f_cos,
                diffuse,
                l,
                shadow_ray: surface.shadow_ray(false, family.light.wi(lane), family.light.distance(lane)),
            })
        })
    }

    /// The continuation of the path at the lane's `surface`; `None` if it ends.
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
            n: if block.folds.is_folded(lane) {
                surface.viewed_normal()
            } else {
                frame.n
            },
        })
    }
}

/// Computes the scattering of all surfaces of a block.
struct Scatterings<'a, 'b, B> {
    choices: &'a Each,
    samples: &'a Each<Sample2D>,
    block: &'a mut KindBlock<'b, B>,
    strategy: Strategy,
}

impl<B: BsdfBlock> VectorLoop for Scatterings<'_, '_, B> {
    #[inline(always)]
    fn run(self) {
        let Self {
            choices,
            samples,
            block: KindBlock {
                bsdfs,
                scattering: block,
            },
            strategy,
        } = self;
        bsdfs.prepare();
        let mut samples = bsdfs.sample(choices, samples);
        let folds = &block.folds;
        let families = block.families.iter().flatten().count();
        // The directions to the lights; of folded BSDFs also their images, and last those of the samples. They are evaluated at one
        // place, for the sake of the program's size.
        let images = usize::from(folds.is_any());
        for query in 0..(1 + images) * families + images {
            let (k, is_image) = (query / (1 + images), query % (1 + images) == 1);
            let family = block.families.get(k).copied().flatten();
            let mut wi = samples.wi;
            if let Some(family) = family {
                for lane in 0..LANES {
                    let local = block.frame(lane).to_local(family.light.wi(lane));
                    set(&mut wi, lane, local);
                }
            }
            let queried = if is_image || family.is_none() {
                folds.mirrored(&wi)
            } else {
                wi
            };
            let eval = bsdfs.eval(&queried);
            let Some(family) = family else {
                folds.fold(&mut samples, &queried, &eval.pdf);
                break;
            };
            let lights = &mut block.lights[k];
            if is_image {
                folds.add(&mut lights.eval, &wi, &eval);
            } else {
                lights.eval = eval;
            }
            let (pdf, mut weights) = (lights.eval.pdf, [0.0; LANES]);
            for lane in 0..LANES {
                let of_light = family.light.pdf(lane) * family.pmf(lane);
                weights[lane] = strategy.weight_of_light(of_light, pdf[lane]) / of_light;
            }
            lights.weight = weights;
        }
        block.samples = samples;
    }
}
