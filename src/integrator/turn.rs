//! A turn: a few vertices of a wave, answered for one after the other.

use super::{Departures, Integrator, Path, Vertex, Visit};
use crate::{
    accel::Hit,
    camera::Camera,
    math::Ray,
    sampler::{DrawnTogether, Numbers, SampleKeys, Sampler},
    scene::{Scene, Surface},
};

/// Vertices that are answered for one after the other, all of them on surfaces or none.
pub struct Turn<'a> {
    pub scene: &'a Scene,
    /// Where the paths began.
    pub camera: &'a Camera,
    pub sampler: &'a Sampler,
    /// Of all paths of the wave: the ray that arrived, the path, and what was met.
    pub rays: &'a [Ray],
    pub paths: &'a [Path],
    pub hits: &'a [Option<Hit>],
    /// Which of them have their turn.
    pub chosen: &'a [u32],
    /// Of each that has: its surface (of none where nothing was met), its sample, and the numbers that are drawn for it.
    pub surfaces: &'a [Surface],
    pub keys: &'a SampleKeys,
    pub drawn: &'a DrawnTogether,
    /// Whether textures want to know how wide the paths are.
    pub has_cones: bool,
}

impl Turn<'_> {
    /// What may be asked about the `k`th vertex.
    #[inline(always)]
    fn visit(&self, k: usize) -> Visit<'_> {
        let i = self.chosen[k] as usize;
        let vertex = match (self.surfaces.get(k), &self.hits[i]) {
            (Some(surface), Some(hit)) => Vertex::Surface(surface, hit),
            _ => Vertex::Escape,
        };
        Visit {
            scene: self.scene,
            path: &self.paths[i],
            ray: &self.rays[i],
            vertex,
            numbers: Numbers {
                sampler: self.sampler,
                keys: self.keys,
                drawn: self.drawn,
                index: k,
            },
            camera: self.camera,
        }
    }

    /// Lets `integrator` answer for each vertex.
    #[inline(always)]
    pub(super) fn answer(&self, integrator: &(impl Integrator + ?Sized), out: &mut Departures) {
        for k in 0..self.chosen.len() {
            let visit = self.visit(k);
            match visit.vertex {
                Vertex::Surface(surface, _) if self.has_cones => out.leave_surface(visit.path, surface),
                _ => out.leave_from(visit.path),
            }
            integrator.vertex(&visit, out);
        }
    }
}
