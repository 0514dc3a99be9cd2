//! Integrators: what one vertex of a path does.
//!
//! An integrator owns no rays. It receives the vertices where paths have arrived and returns what they add to the picture and
//! which rays leave them; the wave traces those, thousands at once.
//!
//! `max_depth` means the same everywhere: the number of ray segments from the camera, shadow rays included. 1 shows only
//! emitters (and ambient light), 2 also direct light, 5 has a camera ray and four more segments.

use crate::{
    accel::RayCost,
    bsdf::Lobe,
    camera::Camera,
    geometry::Hit,
    kind::kinds,
    light::environment::EnvironmentLight,
    math::{Ray, RayCone, Rgb, Vec3},
    sampler::{PathSampler, SampleUse},
    scene::{LightSamples, MediumStack, Scene, SurfaceInteraction},
    value::{Count, Problem, Spanned, kind_by_name},
};

pub mod cost;
mod diffuse;
mod direct;
pub mod light_layers;
pub mod occlusion;
pub mod output;
pub mod path;
pub mod path_limits;
mod reflected;
mod reflecting;
mod scatter;
mod stages;
mod vertex_batch;
pub mod whitted;

pub use light_layers::{FirstLobe, Lobes, Tag};
pub use output::{ShadingOutput, ShadowPassage};
pub use stages::{Stage, StageTimes};
pub use vertex_batch::VertexBatch;

/// The state of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathState {
    /// The index of its sample in the wave.
    pub sample: u32,
    /// The number of its segments, 1 for a camera ray.
    pub depth: u32,
    /// The weight of what it finds.
    pub throughput: Rgb,
    pub last: BounceState,
    /// The cone of rays that the path stands for: at a vertex, where it has arrived; else where its ray begins.
    pub cone: RayCone,
}

impl PathState {
    /// A path that begins at the camera.
    pub fn start(sample: u32) -> Self {
        Self {
            sample,
            depth: 1,
            throughput: Rgb::WHITE,
            last: BounceState::default(),
            cone: RayCone::default(),
        }
    }
}

/// The state of a path when it left its last vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BounceState {
    pub pdf: DirectionPdf,
    /// Unit shading normal of the vertex, zero where there is none.
    pub n: Vec3,
    /// The bodies that the path travels in.
    pub media: MediumStack,
    /// The number of departures by a lobe of each kind.
    pub bounces: Bounces,
    pub first: FirstLobe,
}

/// The density of a path's direction in sr^-1, if it has one: a camera or a mirror leaves no choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionPdf(f32);

impl DirectionPdf {
    /// The only direction.
    pub const DELTA: Self = Self(-1.0);

    #[inline]
    pub fn get(self) -> Option<f32> {
        (self != Self::DELTA).then_some(self.0)
    }
}

impl Default for DirectionPdf {
    fn default() -> Self {
        Self::DELTA
    }
}

impl From<Option<f32>> for DirectionPdf {
    #[inline]
    fn from(pdf: Option<f32>) -> Self {
        pdf.map_or(Self::DELTA, Self)
    }
}

/// The number of times that a path left by a lobe of each kind, since the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bounces {
    pub diffuse: u16,
    pub specular: u16,
    pub transmission: u16,
    /// Those by transmission that bent nothing, without one at the first surface.
    pub straight: u8,
}

impl Bounces {
    /// These and one more by `lobe`, if the limits allow it.
    #[inline(always)]
    pub fn and(mut self, lobe: Lobe, limits: Self) -> Option<Self> {
        let (count, limit) = match lobe {
            Lobe::Diffuse => (&mut self.diffuse, limits.diffuse),
            Lobe::Specular => (&mut self.specular, limits.specular),
            Lobe::Transmission => (&mut self.transmission, limits.transmission),
        };
        if *count >= limit {
            return None;
        }
        *count += 1;
        Some(self)
    }
}

/// The end of a path.
#[derive(Clone, Copy, Debug)]
pub enum Vertex<'a> {
    Surface(&'a SurfaceInteraction, &'a Hit),
    /// The ray met nothing but the background, which sends this light.
    Miss(&'a EnvironmentLight),
}

/// A vertex of a path and what its shading may read.
#[derive(Clone, Copy)]
pub struct VertexContext<'a> {
    pub scene: &'a Scene,
    pub path: &'a PathState,
    /// The ray that arrived.
    pub ray: &'a Ray,
    pub vertex: Vertex<'a>,
    /// The random numbers of the path's sample. There are none for [`Vertex::Miss`], where nothing is left to choose.
    pub numbers: PathSampler<'a>,
    /// Samples of lights that were drawn for many vertices at once.
    pub lights: &'a LightSamples,
    /// The camera where the path began.
    pub camera: &'a Camera,
    /// The round of shadow rays, from 0: see [`Integrator::shadow_rounds`].
    pub round: u32,
}

/// The contract of every integrator.
pub trait Integrator: Sync + Send {
    /// Shades one vertex of a path.
    fn vertex(&self, context: &VertexContext<'_>, out: &mut ShadingOutput);

    /// Shades a batch of vertices: [`Integrator::vertex`] for each in turn.
    fn shade_batch(&self, batch: &VertexBatch<'_>, out: &mut ShadingOutput) {
        batch.shade(self, out);
    }

    /// The uses of random numbers that nearly all vertices at the end of segment `depth` have: they are drawn for many
    /// vertices at once. A vertex may draw for other uses too.
    fn batched_dimensions(&self, _scene: &Scene, _depth: u32) -> Vec<SampleUse> {
        Vec::new()
    }

    /// The number of times that each vertex on a surface is shaded, with its shadow rays traced in between. An integrator
    /// that sends out very many of them from a vertex does so in several rounds, so that memory does not grow with them.
    fn shadow_rounds(&self) -> u32 {
        1
    }

    /// Whether its pictures show the cost of tracing. If so, [`Integrator::add_cost`] is called in place of
    /// [`Integrator::vertex`].
    fn wants_cost(&self) -> bool {
        false
    }

    /// Whether its radiance is the light of lights, so that it can be sorted by components and light groups.
    fn has_light(&self) -> bool {
        !self.wants_cost()
    }

    /// Adds what tracing the nearest hit of a camera ray cost.
    fn add_cost(&self, _cost: RayCost, _out: &mut ShadingOutput) {}

    /// The light that it leaves out, for the metadata of its pictures.
    fn limits(&self) -> Vec<Limit> {
        Vec::new()
    }

    /// This integrator behind a pointer.
    fn as_dyn(&self) -> &dyn Integrator
    where
        Self: Sized,
    {
        self
    }
}

/// Light that an integrator leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Its name in metadata, in camel case.
    pub name: &'static str,
    pub value: LimitValue,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LimitValue {
    /// A number of segments or of bounces.
    Count(u32),
    /// In W m^-2 sr^-1.
    Radiance(f32),
}

kinds! {
    /// The integrators that scene files and `--integrator` name.
    enum BuiltIn / IntegratorDesc {
        "path" => PathTracer(path::PathTracer, path::PathDesc),
        "whitted" => Whitted(whitted::Whitted, whitted::WhittedDesc),
        "cost" => Cost(cost::Cost, cost::CostDesc),
        "occlusion" => Occlusion(occlusion::Occlusion, occlusion::OcclusionDesc),
    }
    described only {}
    compiled by fn compile(&self) -> Result<BuiltIn, Problem>;
    /// The integrator behind a pointer.
    fn as_dyn(&self) -> &dyn Integrator;
}

/// Former integrators whose pictures are passes now, with the names of the passes.
const FORMER: &[(&str, &str)] = &[
    ("depth", "depth"),
    ("normals", "N"),
    ("uv", "UV"),
    ("object_id", "objectId"),
];

/// The pass that shows what `name`, no longer an integrator, showed.
pub fn replacing_pass(name: &str) -> Option<&'static str> {
    FORMER.iter().find(|(former, _)| *former == name).map(|(_, pass)| *pass)
}

/// The given depth, or `default`.
fn max_depth(given: &Option<Spanned<Count>>, default: u32) -> Result<u32, Problem> {
    match given {
        None => Ok(default),
        Some(depth) if depth.get_ref().0 == 0 => {
            Err(Problem::at(depth.span(), "expected a depth of at least 1, found 0"))
        }
        Some(depth) => Ok(depth.get_ref().0),
    }
}

impl IntegratorDesc {
    /// The integrator of this name with its default settings, or why there is none.
    pub fn by_name(name: &str) -> Result<Self, String> {
        match replacing_pass(name) {
            Some(pass) => Err(format!("`{name}` is a pass and no integrator: use --show {pass}")),
            None => kind_by_name("integrator", name, Self::NAMES),
        }
    }
}
