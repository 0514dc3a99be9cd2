//! Integrators: what one vertex of a path does.
//!
//! An integrator owns no rays. It is told where a path has arrived and says what that adds to the picture and which
//! rays leave; the wave traces them, thousands at once.
//!
//! `max_depth` means the same everywhere: the number of ray segments from the camera, shadow rays included. 1 sees only
//! what is bright by itself (and ambient light), 2 also what is lit directly, 5 has a camera ray and four more.

use crate::{
    accel::RayCost,
    kind::kinds,
    math::{Ray, Rgb},
    scene::{Scene, Surface},
    value::{Problem, by_name},
};

pub mod cost;
pub mod departures;
pub mod whitted;

pub use departures::Departures;

/// Where a path stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// Which sample of the wave it belongs to.
    pub slot: u32,
    /// How many segments it has, 1 for a camera ray.
    pub depth: u32,
    /// Weight of what it finds.
    pub throughput: Rgb,
}

/// Where it has arrived.
#[derive(Clone, Copy, Debug)]
pub enum Vertex<'a> {
    Surface(&'a Surface),
    /// Nothing was met along the ray.
    Escape(&'a Ray),
}

/// The contract of every integrator.
pub trait Integrator: Sync + Send {
    /// Answers for one vertex of a path.
    fn vertex(&self, scene: &Scene, path: &Path, vertex: &Vertex<'_>, out: &mut Departures);

    /// Whether it wants to know what tracing took, and is asked for [`Integrator::traversal`] only.
    fn reads_traversal(&self) -> bool {
        false
    }

    /// Answers for a ray by what its nearest hit took.
    fn traversal(&self, _cost: RayCost, _out: &mut Departures) {}
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
        "whitted" => Whitted(whitted::Whitted, whitted::WhittedDesc),
        "cost" => Cost(cost::Cost, cost::CostDesc),
    }
    described only {}
    compiled by fn compile(&self) -> Result<BuiltIn, Problem>;
    /// See [`Integrator::vertex`].
    fn vertex(&self, scene: &Scene, path: &Path, vertex: &Vertex<'_>, out: &mut Departures);
    /// See [`Integrator::reads_traversal`].
    fn reads_traversal(&self) -> bool;
    /// See [`Integrator::traversal`].
    fn traversal(&self, cost: RayCost, out: &mut Departures);
    /// What R, G and B are where they are not light; such pictures are shown as heat.
    fn layers(&self) -> &'static [Layer];
}

impl IntegratorDesc {
    /// The integrator of this name with its default settings, or why there is none.
    pub fn by_name(name: &str) -> Result<Self, String> {
        by_name(name, Self::NAMES)
    }
}

impl Integrator for BuiltIn {
    fn vertex(&self, scene: &Scene, path: &Path, vertex: &Vertex<'_>, out: &mut Departures) {
        Self::vertex(self, scene, path, vertex, out);
    }

    fn reads_traversal(&self) -> bool {
        Self::reads_traversal(self)
    }

    fn traversal(&self, cost: RayCost, out: &mut Departures) {
        Self::traversal(self, cost, out);
    }
}
