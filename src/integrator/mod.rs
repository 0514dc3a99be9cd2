//! Integrators: what one vertex of a path does.
//!
//! An integrator owns no rays. It is told where a path has arrived and says what that adds to the picture and which
//! rays leave; the wave traces them, thousands at once.
//!
//! `max_depth` means the same everywhere: the number of ray segments from the camera, shadow rays included. 1 sees only
//! what is bright by itself (and ambient light), 2 also what is lit directly, 5 has a camera ray and four more.

use crate::{
    accel::{Hit, RayCost},
    camera::Camera,
    kind::kinds,
    material::MaterialId,
    math::{Cone, Ray, Rgb, Vec3},
    sampler::{Numbers, Purpose},
    scene::{Scene, Surface},
    value::{Problem, Spanned, Whole, by_name},
};

pub mod components;
pub mod cost;
pub mod departures;
pub mod depth;
mod direct;
pub mod normals;
pub mod object_id;
pub mod occlusion;
pub mod path;
mod turn;
pub mod uv;
pub mod whitted;

pub use components::{Component, Lobes, Tag};
pub use departures::Departures;
pub use turn::Turn;

/// Where a path stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// Which sample of the wave it belongs to.
    pub slot: u32,
    /// How many segments it has, 1 for a camera ray.
    pub depth: u32,
    /// Weight of what it finds.
    pub throughput: Rgb,
    pub last: Onward,
    /// How wide the bundle is that it stands for: at a vertex, where it has arrived; else where its ray begins.
    pub cone: Cone,
}

impl Path {
    /// A path that begins at the camera.
    pub fn start(slot: u32) -> Self {
        Self {
            slot,
            depth: 1,
            throughput: Rgb::WHITE,
            last: Onward::default(),
            cone: Cone::default(),
        }
    }
}

/// How a path left its last vertex: what the next one wants to know of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Onward {
    /// Density of the direction in sr^-1; `None` where there was but one (a camera, a mirror).
    pub pdf: Option<f32>,
    /// Unit shading normal of the vertex, zero where there is none.
    pub n: Vec3,
    /// The medium that the path travels in, by the material whose inside it is.
    pub medium: Option<MaterialId>,
    /// How often it left by a lobe of each kind.
    pub bounces: Bounces,
}

/// How often a path left by a lobe of each kind, since the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bounces {
    pub diffuse: u16,
    pub specular: u16,
    pub transmission: u16,
}

/// Where a path has arrived.
#[derive(Clone, Copy, Debug)]
pub enum Vertex<'a> {
    Surface(&'a Surface, &'a Hit),
    /// Nothing was met.
    Escape,
}

/// A vertex of a path, and all that may be asked about it.
#[derive(Clone, Copy)]
pub struct Visit<'a> {
    pub scene: &'a Scene,
    pub path: &'a Path,
    /// The ray that arrived.
    pub ray: &'a Ray,
    pub vertex: Vertex<'a>,
    /// The random numbers of the path's sample. For [`Vertex::Escape`] there are none: nothing is left to choose there.
    pub numbers: Numbers<'a>,
    /// Where the path began.
    pub camera: &'a Camera,
}

/// The contract of every integrator.
pub trait Integrator: Sync + Send {
    /// Answers for one vertex of a path.
    fn vertex(&self, visit: &Visit<'_>, out: &mut Departures);

    /// Answers for a few vertices: [`Integrator::vertex`] for each in turn.
    fn turn(&self, turn: &Turn<'_>, out: &mut Departures) {
        turn.answer(self, out);
    }

    /// What surely most of its vertices at the end of segment `depth` draw for: that is drawn for many at once. It may draw
    /// for more, and what it does not ask for was drawn in vain.
    fn draws(&self, _scene: &Scene, _depth: u32) -> Vec<Purpose> {
        Vec::new()
    }

    /// Whether it wants to know what tracing took, and is asked for [`Integrator::traversal`] only.
    fn reads_traversal(&self) -> bool {
        false
    }

    /// Answers for a ray by what its nearest hit took.
    fn traversal(&self, _cost: RayCost, _out: &mut Departures) {}

    /// What the numbers of its pictures are.
    fn shown(&self) -> Shown {
        Shown::Light
    }

    /// What R, G and B are called where they are not light.
    fn layers(&self) -> &'static [Layer] {
        &[]
    }

    /// How much of the light it looks for, for whoever wants to know what a picture lacks.
    fn limits(&self) -> Vec<Limit> {
        Vec::new()
    }
}

/// What an integrator leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// As metadata call it, in camel case.
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

/// What the numbers of a picture are, for whoever shows them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    Light,
    /// R and G are counts.
    Counts,
    /// From -1 to 1.
    Signed,
    /// R is a distance in m.
    Distance,
    /// Whole numbers begin anew.
    Fraction,
    /// G is a hash, R is 0 where there is none.
    Id,
}

impl Shown {
    /// Whether the mean of two numbers means nothing: such pictures have one sample, through the centre of the pixel and of
    /// the lens; where nothing is met the integrator says what that is, and alpha is 0.
    pub fn is_measured(self) -> bool {
        match self {
            Self::Light | Self::Counts => false,
            Self::Signed | Self::Distance | Self::Fraction | Self::Id => true,
        }
    }
}

/// A channel of R, G, B (0, 1, 2) that has a name of its own in files that hold layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layer {
    pub name: &'static str,
    pub channel: usize,
}

kinds! {
    /// The integrators that scene files and `--integrator` know.
    enum BuiltIn / IntegratorDesc {
        "path" => PathTracer(path::PathTracer, path::PathDesc),
        "whitted" => Whitted(whitted::Whitted, whitted::WhittedDesc),
        "cost" => Cost(cost::Cost, cost::CostDesc),
        "occlusion" => Occlusion(occlusion::Occlusion, occlusion::OcclusionDesc),
        "normals" => Normals(normals::Normals, normals::NormalsDesc),
        "depth" => Depth(depth::Depth, depth::DepthDesc),
        "uv" => Uv(uv::Uv, uv::UvDesc),
        "object_id" => ObjectId(object_id::ObjectId, object_id::ObjectIdDesc),
    }
    described only {}
    compiled by fn compile(&self) -> Result<BuiltIn, Problem>;
    /// See [`Integrator::vertex`].
    fn vertex(&self, visit: &Visit<'_>, out: &mut Departures);
    /// See [`Integrator::turn`].
    fn turn(&self, turn: &Turn<'_>, out: &mut Departures);
    /// See [`Integrator::draws`].
    fn draws(&self, scene: &Scene, depth: u32) -> Vec<Purpose>;
    /// See [`Integrator::reads_traversal`].
    fn reads_traversal(&self) -> bool;
    /// See [`Integrator::traversal`].
    fn traversal(&self, cost: RayCost, out: &mut Departures);
    /// See [`Integrator::shown`].
    fn shown(&self) -> Shown;
    /// See [`Integrator::layers`].
    fn layers(&self) -> &'static [Layer];
    /// See [`Integrator::limits`].
    fn limits(&self) -> Vec<Limit>;
}

/// The depth that is said, or `default`.
fn max_depth(said: &Option<Spanned<Whole>>, default: u32) -> Result<u32, Problem> {
    match said {
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
        by_name("integrator", name, Self::NAMES)
    }
}

impl Integrator for BuiltIn {
    fn vertex(&self, visit: &Visit<'_>, out: &mut Departures) {
        Self::vertex(self, visit, out);
    }

    fn turn(&self, turn: &Turn<'_>, out: &mut Departures) {
        Self::turn(self, turn, out);
    }

    fn draws(&self, scene: &Scene, depth: u32) -> Vec<Purpose> {
        Self::draws(self, scene, depth)
    }

    fn reads_traversal(&self) -> bool {
        Self::reads_traversal(self)
    }

    fn traversal(&self, cost: RayCost, out: &mut Departures) {
        Self::traversal(self, cost, out);
    }

    fn shown(&self) -> Shown {
        Self::shown(self)
    }

    fn layers(&self) -> &'static [Layer] {
        Self::layers(self)
    }

    fn limits(&self) -> Vec<Limit> {
        Self::limits(self)
    }
}
