//! Blocks of diffuse surfaces: their direct light, and the directions of the paths that leave them.
//!
//! The block computes all that does not depend on the surfaces' colours, with the operations of
//! [`Lambert`](crate::bsdf::diffuse::Lambert).

use std::f32::consts::FRAC_1_PI;

use super::{
    VertexBatch,
    direct::Strategy,
    reflected::{ReflectedLight, ReflectedPath, reflected},
};
use crate::{
    bsdf::Lobe,
    material::BatchKind,
    math::{
        Dispatch, Ray, Rgb, Vec2, Vec3, VectorLoop,
        block::{Each, LANES, get, set},
        float::select,
        warp,
    },
    scene::{FamilyBlock, LightFamily, surface_soa::SoaBlock},
};

/// A block of diffuse surfaces; the lanes of other surfaces are unspecified.
#[repr(align(64))]
pub(super) struct DiffuseBlock<'a> {
    /// Whether the surface of a lane is diffuse.
    is_diffuse: [bool; LANES],
    /// The ray of the continued path, and its density in sr^-1; 0 if the path ends.
    origin: [Each; 3],
    wi: [Each; 3],
    pdf: Each,
    /// The families of lights.
    families: [Option<&'a FamilyBlock>; LightFamily::ALL.len()],
    lights: [LightLanes; LightFamily::ALL.len()],
}

/// The direct light of a family on each surface of a block.
struct LightLanes {
    /// The shadow ray.
    origin: [Each; 3],
    d: [Each; 3],
    tmax: Each,
    /// `f |cos|` of a white surface.
    white: Each,
    /// The weight of the light in multiple importance sampling, over its density.
    weight: Each,
}

impl LightLanes {
    const EMPTY: Self = Self {
        origin: [[0.0; LANES]; 3],
        d: [[0.0; LANES]; 3],
        tmax: [0.0; LANES],
        white: [0.0; LANES],
        weight: [0.0; LANES],
    };
}

/// A diffuse surface of a block.
#[derive(Clone, Copy)]
pub(super) struct DiffuseSurface<'a> {
    block: &'a DiffuseBlock<'a>,
    lane: usize,
}

impl<'a> DiffuseBlock<'a> {
    pub const EMPTY: Self = Self {
        is_diffuse: [false; LANES],
        origin: [[0.0; LANES]; 3],
        wi: [[0.0; LANES]; 3],
        pdf: [0.0; LANES],
        families: [None; LightFamily::ALL.len()],
        lights: [LightLanes::EMPTY; LightFamily::ALL.len()],
    };

    /// The number of surfaces in a block.
    pub const LEN: usize = LANES;

    /// Fills the block for the vertices of `batch` from `first` on, a multiple of [`DiffuseBlock::LEN`].
    pub fn fill(&mut self, batch: &VertexBatch<'a>, first: usize, strategy: Strategy) {
        self.is_diffuse = [false; LANES];
        let (scene, end) = (batch.scene, batch.len().min(first + LANES));
        let (Some(surfaces), Some(disks)) = (
            batch.surfaces.get(first..end),
            batch.samples.disks().and_then(|disks| disks.get(first..end)),
        ) else {
            return;
        };
        let mut is_diffuse = [false; LANES];
        for (is_diffuse, surface) in is_diffuse.iter_mut().zip(surfaces) {
            *is_diffuse = scene.batch_kind(surface.material) == BatchKind::Diffuse;
        }
        if is_diffuse == [false; LANES] {
            return;
        }
        let Some(families) = batch.families(first / LANES) else {
            return;
        };
        (self.is_diffuse, self.families) = (is_diffuse, families);
        let mut all_disks = [Vec2::ZERO; LANES];
        all_disks[..disks.len()].copy_from_slice(disks);
        scene.geometry.accel.simd().dispatch(Scatterings {
            surfaces: &batch.blocks[first / LANES],
            disks: &all_disks,
            block: self,
            strategy,
        });
    }

    /// The surface of a lane, if it is diffuse.
    #[inline(always)]
    pub fn surface(&self, lane: usize) -> Option<DiffuseSurface<'_>> {
        let lane = lane % LANES;
        self.is_diffuse[lane].then_some(DiffuseSurface { block: self, lane })
    }
}

impl DiffuseSurface<'_> {
    /// The reflected light of each family that contributes, for a surface with this `albedo`.
    #[inline(always)]
    pub fn lights(self, albedo: Rgb) -> impl Iterator<Item = ReflectedLight> {
        let Self { block, lane } = self;
        let families = block.families.iter().map_while(|family| *family);
        families.zip(&block.lights).filter_map(move |(family, lights)| {
            let f_cos = albedo * lights.white[lane];
            let (chosen, l) = reflected(family, lane, f_cos, lights.weight[lane])?;
            Some(ReflectedLight {
                chosen,
                f_cos,
                diffuse: f_cos,
                l,
                shadow_ray: Ray::segment(get(&lights.origin, lane), get(&lights.d, lane), lights.tmax[lane]),
            })
        })
    }

    /// The continuation of the path, for a surface with this `albedo` and normal `n`; `None` if it ends.
    #[inline(always)]
    pub fn path(self, albedo: Rgb, n: Vec3) -> Option<ReflectedPath> {
        let Self { block, lane } = self;
        let pdf = block.pdf[lane];
        (pdf > 0.0 && !albedo.is_black()).then(|| ReflectedPath {
            ray: Ray::new(get(&block.origin, lane), get(&block.wi, lane)),
            pdf,
            weight: albedo,
            diffuse: albedo,
            lobe: Lobe::Diffuse,
            n,
        })
    }
}

/// Computes the scattering of all surfaces of a block.
struct Scatterings<'a, 'b> {
    surfaces: &'a SoaBlock,
    disks: &'a [Vec2; LANES],
    block: &'a mut DiffuseBlock<'b>,
    strategy: Strategy,
}

impl VectorLoop for Scatterings<'_, '_> {
    #[inline(always)]
    fn run(self) {
        let Self {
            surfaces,
            disks,
            block,
            strategy,
        } = self;
        // Results go to local arrays, so that the compiler knows that reads and writes do not alias.
        let (mut directions, mut origins, mut pdfs) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3], [0.0; LANES]);
        for lane in 0..LANES {
            let surface = surfaces.viewed(lane);
            let wi = warp::over_disk(disks[lane]);
            let is_seen = surface.wo.dot(surface.frame.n) > 0.0;
            let pdf = warp::cosine_hemisphere_pdf(wi.z);
            pdfs[lane] = if is_seen { pdf } else { 0.0 };
            let wi = surface.frame.to_world(wi);
            set(&mut directions, lane, wi);
            set(&mut origins, lane, surface.origin(wi));
        }
        (block.wi, block.origin, block.pdf) = (directions, origins, pdfs);
        for (family, lights) in block.families.into_iter().zip(&mut block.lights) {
            let Some(family) = family else { break };
            let mut found = LightLanes::EMPTY;
            for lane in 0..LANES {
                let surface = surfaces.viewed(lane);
                let (wi, distance) = (family.light.wi(lane), family.light.distance(lane));
                let cos = wi.dot(surface.frame.n);
                let is_lit = (surface.wo.dot(surface.frame.n) > 0.0) & (cos > 0.0);
                let white = cos * FRAC_1_PI;
                let of_surface = if is_lit { warp::cosine_hemisphere_pdf(cos) } else { 0.0 };
                let of_light = family.light.pdf(lane) * family.pmf(lane);
                found.white[lane] = if is_lit { white } else { 0.0 };
                found.weight[lane] = strategy.weight_of_light(of_light, of_surface) / of_light;
                let origin = surface.origin(wi);
                let segment = surface.p + wi * distance - origin;
                let is_near = distance.is_finite();
                set(&mut found.origin, lane, origin);
                set(&mut found.d, lane, select(is_near, segment, wi));
                found.tmax[lane] = if is_near { 1.0 } else { f32::INFINITY };
            }
            *lights = found;
        }
    }
}
