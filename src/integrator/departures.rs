//! What leaves the vertices of a wave: radiance for samples, shadow rays, and rays that carry paths on.

use super::{Lobes, Onward, Path, Tag, components::Sorted};
use crate::{
    math::{Cone, Ray, Rgb, Vec3},
    scene::{LightGroup, Surface},
};

/// The answers of an integrator for all vertices of a wave, in order.
///
/// Everything is given as seen from the vertex; the throughput of its path is applied here.
#[derive(Debug, Default)]
pub struct Departures {
    /// Radiance of each sample of the wave, in W m^-2 sr^-1.
    pub(crate) radiance: Vec<Rgb>,
    pub(crate) shadow_rays: Vec<Ray>,
    /// The sample that each shadow ray belongs to, and what it brings if nothing is in the way.
    pub(crate) shadow_light: Vec<(u32, Rgb)>,
    pub(crate) rays: Vec<Ray>,
    pub(crate) paths: Vec<Path>,
    /// The same light once more, by components and by groups, where somebody asks for it.
    pub(crate) sorted: Option<Sorted>,
    from: Origin,
    has_cones: bool,
    /// Of the last surface, where paths have cones.
    mirror: Mirror,
}

/// What departures need to know of the path whose vertex is answered for.
#[derive(Clone, Copy, Debug, Default)]
struct Origin {
    slot: u32,
    depth: u32,
    throughput: Rgb,
    cone: Cone,
}

/// What a surface does to the cones of the rays that it reflects.
#[derive(Clone, Copy, Debug, Default)]
struct Mirror {
    /// On the side of the viewer.
    n: Vec3,
    /// See [`Surface::bend`].
    bend: f32,
}

impl Departures {
    /// Starts a wave of `samples` samples; `has_cones` says whether textures want to know how wide paths are.
    pub(crate) fn start(&mut self, samples: usize, has_cones: bool) {
        self.has_cones = has_cones;
        self.radiance.clear();
        self.radiance.resize(samples, Rgb::BLACK);
        if let Some(sorted) = &mut self.sorted {
            sorted.start(samples);
        }
        self.forget_rays();
    }

    /// Forgets the rays, not the radiance.
    pub(crate) fn forget_rays(&mut self) {
        self.shadow_rays.clear();
        self.shadow_light.clear();
        self.rays.clear();
        self.paths.clear();
        if let Some(sorted) = &mut self.sorted {
            sorted.forget_shadows();
        }
    }

    /// The path whose vertex is answered for next.
    #[inline]
    pub(crate) fn leave_from(&mut self, path: &Path) {
        self.from = Origin {
            slot: path.slot,
            depth: path.depth,
            throughput: path.throughput,
            cone: path.cone,
        };
    }

    /// The same, where the path has met a surface and textures want to know how wide it is.
    #[inline]
    pub(crate) fn leave_surface(&mut self, path: &Path, surface: &Surface) {
        self.leave_from(path);
        self.mirror = Mirror {
            n: if surface.ng.dot(surface.wo) < 0.0 {
                -surface.ng
            } else {
                surface.ng
            },
            bend: surface.bend(),
        };
    }

    /// Weakens all that the vertex is answered with from here on: the path came through a medium.
    #[inline(always)]
    pub fn attenuate(&mut self, weight: Rgb) {
        self.from.throughput *= weight;
    }

    /// Adds radiance that leaves the vertex towards the path, in W m^-2 sr^-1, of lights that are in no group.
    #[inline(always)]
    pub fn add(&mut self, l: Rgb) {
        self.add_of(l, LightGroup::default);
    }

    /// The same of a light in the group that `group` tells, if it is asked.
    #[inline(always)]
    pub fn add_of(&mut self, l: Rgb, group: impl FnOnce() -> LightGroup) {
        let (slot, l) = (self.from.slot, self.from.throughput * l);
        self.radiance[slot as usize] += l;
        if let Some(sorted) = &mut self.sorted {
            sorted.add(slot, self.from.depth, l, group());
        }
    }

    /// Adds radiance that leaves the vertex if `ray` meets nothing, of lights that are in no group and by diffuse lobes.
    #[inline(always)]
    pub fn shadow(&mut self, ray: Ray, l_if_visible: Rgb) {
        self.shadow_of(ray, l_if_visible, || Tag {
            group: LightGroup::default(),
            lobes: Lobes::Above { diffuse: Rgb::WHITE },
        });
    }

    /// The same of a light and by lobes that `tag` tells, if it is asked.
    #[inline(always)]
    pub fn shadow_of(&mut self, ray: Ray, l_if_visible: Rgb, tag: impl FnOnce() -> Tag) {
        let (slot, l) = (self.from.slot, self.from.throughput * l_if_visible);
        self.shadow_rays.push(ray);
        self.shadow_light.push((slot, l));
        if let Some(sorted) = &mut self.sorted {
            sorted.shadow(slot, self.from.depth, l, tag());
        }
    }

    /// Says by which lobes the path leaves the vertex, as `lobes` tells if it is asked: what it finds is sorted by those of its
    /// first surface.
    #[inline(always)]
    pub fn leave_by(&mut self, lobes: impl FnOnce() -> Lobes) {
        if let Some(sorted) = &mut self.sorted
            && self.from.depth == 1
        {
            sorted.set_first(self.from.slot, lobes());
        }
    }

    /// Carries the path on along `ray`, `last` says how; what it finds counts `weight` times.
    ///
    /// A mirror keeps the path's cone but for what its own curvature adds, a surface that lets the ray through keeps it as it
    /// is, and a direction that was drawn at random widens it by its density ([`Cone::scattered`](crate::math::Cone)).
    #[inline(always)]
    pub fn go_on(&mut self, ray: Ray, weight: Rgb, last: Onward) {
        let path = &self.from;
        let cone = match last.pdf {
            _ if !self.has_cones => path.cone,
            Some(pdf) => path.cone.scattered(pdf),
            None if ray.d.dot(self.mirror.n) > 0.0 => path.cone.mirrored(self.mirror.bend),
            None => path.cone,
        };
        self.rays.push(ray);
        self.paths.push(Path {
            slot: path.slot,
            depth: path.depth + 1,
            throughput: path.throughput * weight,
            last,
            cone,
        });
    }
}
