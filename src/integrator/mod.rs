//! Integrators: the shading of the vertices of paths.
//!
//! An integrator owns no rays. For each vertex it returns the radiance that the vertex adds and the rays that leave it; the
//! wave traces those, thousands at once.
//!
//! `max_depth` means the same everywhere: the number of ray segments from the camera, shadow rays included. 1 shows only
//! emitters (and ambient light), 2 also direct light, 5 has a camera ray and four more segments.

use serde::Serialize;

use crate::{
    accel::RayCost,
    bsdf::Lobe,
    camera::Camera,
    geometry::Hit,
    kind::kinds,
    light::environment::EnvironmentLight,
    math::{Ray, RayCone, Rgb, Vec3, WorkingSpace},
    sampler::{Draw, PathSampler},
    scene::{
        LightId, LightOrigin, LightSamples, LightSetId, LitWorld, MediumStack, ObjectId, RayKind, Scene,
        SurfaceInteraction,
    },
    value::{Count, Problem, Spanned},
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
    /// The weight of the light that it finds.
    pub throughput: Rgb,
    pub last: BounceState,
    /// The ray cone of the path, at the hit while a vertex is shaded, otherwise at the origin of its ray.
    pub cone: RayCone,
}

impl PathState {
    /// A path that starts at the camera.
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
    /// Unit shading normal of the vertex; zero if it has none.
    pub n: Vec3,
    /// The media around the path.
    pub media: MediumStack,
    /// The number of scattering events of each kind.
    pub bounces: Bounces,
    pub first: FirstLobe,
    /// The lights that light the last vertex.
    pub lit_by: LightSetId,
}

/// The density of a path's direction in sr^-1, or a delta distribution after a camera or a mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionPdf(f32);

impl DirectionPdf {
    /// A delta distribution.
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

/// The number of scattering events of each kind since the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Bounces {
    pub diffuse: u16,
    pub specular: u16,
    pub transmission: u16,
    /// Transmissions without refraction, except at the first surface.
    pub straight: u8,
    /// Whether there was one event of a kind more than the limits have.
    #[serde(skip)]
    pub exceed: bool,
    /// Where the ray comes from.
    #[serde(skip)]
    pub ray: RayKind,
}

impl Bounces {
    /// Adds an event by `lobe`.
    #[inline(always)]
    pub fn and(mut self, lobe: Lobe, limits: Self) -> Self {
        let (count, limit) = match lobe {
            Lobe::Diffuse => (&mut self.diffuse, limits.diffuse),
            Lobe::Specular => (&mut self.specular, limits.specular),
            Lobe::Transmission => (&mut self.transmission, limits.transmission),
        };
        if *count >= limit {
            self.exceed = true;
        } else {
            *count += 1;
        }
        self.ray = lobe.into();
        self
    }
}

/// A vertex at the end of a path.
#[derive(Clone, Copy, Debug)]
pub enum Vertex<'a> {
    Surface(&'a SurfaceInteraction, &'a Hit),
    /// The ray hit nothing. The background emits this light; it is black if the ray has an end, at a surface that it passes.
    Miss(&'a EnvironmentLight),
}

/// A vertex of a path, with the data for shading it.
#[derive(Clone, Copy)]
pub struct VertexContext<'a> {
    pub scene: &'a Scene,
    pub path: &'a PathState,
    /// The ray that arrived.
    pub ray: &'a Ray,
    pub vertex: Vertex<'a>,
    /// The random numbers of the path's sample; none for [`Vertex::Miss`], where none are needed.
    pub numbers: PathSampler<'a>,
    /// The light samples of the batch.
    pub lights: &'a LightSamples,
    /// The camera of the path.
    pub camera: &'a Camera,
    /// The round of shadow rays, from 0: see [`Integrator::shadow_rounds`].
    pub round: u32,
    /// The number of samples of the wave. Paths of higher numbers meet catchers alone.
    pub sample_count: u32,
}

impl VertexContext<'_> {
    /// Whether a sampled light lights an object.
    #[inline(always)]
    pub fn is_lit(&self, object: ObjectId, light: LightId) -> bool {
        !self.scene.selects_lights() || self.scene.is_lit(object, light, self.world())
    }

    /// The objects that the path meets.
    #[inline]
    fn world(&self) -> LitWorld {
        if self.path.sample < self.sample_count {
            LitWorld::Whole
        } else {
            LitWorld::Catchers
        }
    }

    /// Whether light of this origin, which the path has found, lights the path's last vertex.
    #[inline(always)]
    pub fn arrives(&self, origin: LightOrigin) -> bool {
        self.scene.is_in(self.path.last.lit_by, origin)
    }
}

/// The contract of every integrator.
pub trait Integrator: Sync + Send {
    /// Shades one vertex of a path.
    fn vertex(&self, context: &VertexContext<'_>, out: &mut ShadingOutput);

    /// Converts its own colours from the primaries of scene files.
    fn convert_colors(&mut self, _space: WorkingSpace) {}

    /// Shades a batch of vertices: [`Integrator::vertex`] for each in turn.
    fn shade_batch(&self, batch: &VertexBatch<'_>, out: &mut ShadingOutput) {
        batch.shade(self, out);
    }

    /// The random numbers that nearly all vertices at the end of segment `depth` use; they are drawn in batches. A vertex may draw
    /// others too.
    fn batched_draws(&self, _scene: &Scene, _depth: u32) -> Vec<Draw> {
        Vec::new()
    }

    /// The number of times that each surface vertex is shaded, with its shadow rays traced in between. An integrator with very
    /// many shadow rays per vertex uses several rounds to bound their memory.
    fn shadow_rounds(&self) -> u32 {
        1
    }

    /// Whether a path goes on in one direction at most. If so, the order in which the vertices of a
    /// wave are shaded does not matter.
    fn follows_one_direction(&self) -> bool {
        false
    }

    /// Whether its pictures show the cost of tracing. If so, [`Integrator::add_cost`] is called in place of
    /// [`Integrator::vertex`].
    fn wants_cost(&self) -> bool {
        false
    }

    /// Whether its radiance is light, which can be split into components and light groups.
    fn has_light(&self) -> bool {
        !self.wants_cost()
    }

    /// Adds the cost of tracing the nearest hit of a camera ray.
    fn add_cost(&self, _cost: RayCost, _out: &mut ShadingOutput) {}

    /// The limits that leave out light, for the metadata of pictures.
    fn limits(&self) -> Vec<Limit> {
        Vec::new()
    }

    /// This integrator as a trait object.
    fn as_dyn(&self) -> &dyn Integrator
    where
        Self: Sized,
    {
        self
    }
}

/// A limit beyond which an integrator leaves out light.
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
    #[derive(Serialize)]
    enum BuiltIn / IntegratorDesc {
        "path" => PathTracer(path::PathTracer, path::PathDesc),
        "whitted" => Whitted(whitted::Whitted, whitted::WhittedDesc),
        "cost" => Cost(cost::Cost, cost::CostDesc),
        "occlusion" => Occlusion(occlusion::Occlusion, occlusion::OcclusionDesc),
    }
    described only {}
    compiled by fn compile(&self) -> Result<BuiltIn, Problem>;
    changed by {
        /// See [`Integrator::convert_colors`].
        fn convert_colors(&mut self, space: WorkingSpace);
    }
    /// The integrator as a trait object.
    fn as_dyn(&self) -> &dyn Integrator;
}

/// Former integrators that have become passes, with the names of the passes.
const FORMER: &[(&str, &str)] = &[
    ("depth", "depth"),
    ("normals", "N"),
    ("uv", "UV"),
    ("object_id", "objectId"),
];

/// The pass that has replaced the former integrator `name`.
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

impl Default for IntegratorDesc {
    fn default() -> Self {
        Self::PathTracer(path::PathDesc::default())
    }
}
